//! The rows of an open wire.

use super::*;

#[test]
fn a_release_is_confirmed_by_force_once_the_messages_have_ended() {
    for before in [0.0, 0.05, 0.1, 0.2] {
        let mut rig = Rig::captive();
        rig.run(before, Now { is_open: Some(false), ..RELEASED });
        let edge_us = rig.now_us() + TICK_US;
        let launch = rig.run(2.0, RELEASED).unwrap();
        let LaunchState::Launched(stated) = rig.state() else { panic!() };
        assert_eq!(launch, stated);
        assert_eq!((launch.first_edge_us, launch.by), (edge_us, Confirmation::Force));
        // Two blocks of a quarter of a second.
        let took_us = launch.confirmed_us - edge_us;
        assert!((500_000..=520_000).contains(&took_us), "{took_us} {before}");
    }
}

/// An ejector's push is a departure too, even if the vehicle then carries itself: it was pushed away, or its
/// engine runs. If nothing stays different, a jolt may have torn the cable.
#[test]
fn an_ejector_is_felt() {
    let after = |now: Now, load| {
        let mut rig = Rig::captive();
        assert_eq!(rig.run(0.03, Now { load: Some(load), ..CAPTIVE }), None);
        rig.run(5.0, Now { is_sending: false, ..now }).map(|launch| launch.by)
    };
    assert_eq!(after(Now { vibration: 0.6, ..OPEN }, 4.0), Some(Confirmation::Force));
    // -20 g for 30 ms are 6 m/s.
    assert_eq!(after(OPEN, -20.0), Some(Confirmation::Force));
    assert_eq!(after(OPEN, 4.0), Some(Confirmation::Unconfirmed));
}

/// In a turn that lasts, a release departs from the turn's load factor.
#[test]
fn a_release_out_of_a_turn_that_lasts_is_a_departure() {
    let mut rig = Rig::captive();
    assert_eq!(rig.run(20.0, Now { load: Some(1.8), fixes: Fixes::Level, ..CAPTIVE }), None);
    let launch = rig.run(2.0, Now { fixes: Fixes::Level, vibration: 0.6, ..TORN });
    assert_eq!(launch.map(|launch| launch.by), Some(Confirmation::Force));
}

#[test]
fn a_bounce_is_counted_and_calibration_goes_on() {
    let mut rig = Rig::captive();
    for bounce in 1..=3 {
        // Open for 15 ms: the fifth reading would be 20 ms after the first.
        assert_eq!(rig.run(0.02, OPEN), None);
        assert_eq!(rig.suspected_for_s(), Some(0.015));
        rig.step(CAPTIVE);
        assert_eq!(rig.state(), LaunchState::Captive);
        assert_eq!(rig.detector.counts().bounces, bounce);
    }
    assert_eq!(rig.detector.counts().reclosures, 0);
    // While a force departs, too: the debounce comes first.
    assert_eq!(rig.run(0.05, Now { load: Some(0.3), ..CAPTIVE }), None);
    assert_eq!(rig.run(0.02, Now { load: Some(0.3), ..OPEN }), None);
    assert_eq!(rig.run(1.0, CAPTIVE), None);
    assert_eq!(rig.run(2.0, RELEASED).map(|launch| launch.by), Some(Confirmation::Force));
}

/// The wire closes again after the debounce, before anything is decided.
#[test]
fn a_long_opening_that_closes_is_no_launch() {
    let mut rig = Rig::captive();
    assert_eq!(rig.run(0.2, OPEN), None);
    assert!(rig.suspected_for_s().is_some());
    assert_eq!(rig.run(1.0, CAPTIVE), None);
    assert_eq!((rig.state(), rig.detector.counts().reclosures), (LaunchState::Captive, 1));
}

/// A release without a step: a change of vibration, drag or climb rate shows it, with messages at any rate.
#[test]
fn silence_and_a_change_confirm_a_release_that_is_no_departure() {
    for (now, message_ticks) in [
        (Now { vibration: 0.6, ..TORN }, 4),
        (Now { vibration: 0.1, ..TORN }, 20),
        (Now { load: Some(0.85), ..TORN }, 20),
        (Now { load: Some(0.85), ..TORN }, 200),
        (Now { load: Some(0.8), fixes: Fixes::None, ..TORN }, 4),
    ] {
        let mut rig = Rig::new();
        rig.message_ticks = message_ticks;
        rig.run(20.0, CAPTIVE);
        let edge_us = rig.now_us() + TICK_US;
        let launch = rig.run(20.0, now).unwrap();
        assert_eq!((launch.first_edge_us, launch.by), (edge_us, Confirmation::Silence));
        // Five intervals after the last message, which came up to one before the edge, and two blocks; or the
        // time limit.
        let took_us = launch.confirmed_us - edge_us;
        let silent_us = (message_ticks * TICK_US * 11 / 2).max(520_000);
        assert!(took_us <= silent_us.min(3_000_000), "{took_us} {message_ticks}");
    }
}

/// The whole cable tears under the pylon: wire and messages both end, and the vehicle's motion does not
/// change.
#[test]
fn a_torn_cable_is_no_launch() {
    for message_ticks in [4, 20, 100] {
        for seed in 1..30 {
            let mut rig = Rig::new();
            (rig.seed, rig.message_ticks, rig.gust_sigma) = (seed * 7_919, message_ticks, 0.05);
            rig.run(20.0, CAPTIVE);
            assert_eq!(rig.run(2.9, TORN), None);
            assert!(rig.suspected_for_s().is_some());
            assert_eq!(rig.run(60.0, TORN), None);
            assert_eq!((rig.state(), rig.detector.wire()), (LaunchState::Captive, WireCondition::Broken));
            assert_eq!(rig.detector.counts().torn_cables, 1);
        }
    }
}

/// If nothing can show whether the cable is torn, it is a launch, reported as unconfirmed.
#[test]
fn without_force_a_torn_cable_is_a_launch_without_confirmation() {
    let torn = Now { fixes: Fixes::None, ..TORN };
    for now in [Now { load: None, ..torn }, Now { vibration: 0.0, load: Some(1.0), ..torn }] {
        let mut rig = Rig::captive();
        rig.gust = 0.0;
        rig.gust_sigma = if now.vibration == 0.0 { 0.0 } else { 0.02 };
        let launch = rig.run(10.0, now).unwrap();
        assert_eq!(launch.by, Confirmation::Unconfirmed);
        assert_eq!(launch.confirmed_us - launch.first_edge_us, 3_000_000);
    }
}

/// A dead unit and a torn cable are no launch while the fixes show the mother ship's climb rate. A release
/// that a dead unit does not feel is seen in the climb rate: at the limit if the vehicle sinks, when it is
/// first steered, or after a minute. If the unit delivers again by then, and reads what it did under the
/// pylon, the cable has torn.
#[test]
fn with_a_dead_unit_the_climb_rate_decides() {
    for dead in [Now { load: None, ..TORN }, Now { vibration: 0.0, ..TORN }] {
        let captive = || {
            let mut rig = Rig::captive();
            (rig.gust, rig.gust_sigma) = (0.0, 0.0);
            rig.run(2.0, Now { is_sending: true, is_open: Some(false), ..dead });
            rig
        };
        for change_mps in [-4.4, 4.4] {
            let mut rig = captive();
            let edge_us = rig.now_us() + TICK_US;
            assert_eq!(rig.run(40.0, dead), None);
            assert!(rig.suspected_for_s().is_some_and(|suspected_s| suspected_s > 39.0));
            rig.climb_mps += 0.5 * change_mps;
            assert_eq!(rig.run(10.0, dead), None);
            rig.climb_mps += 0.5 * change_mps;
            let launch = rig.run(1.0, dead).unwrap();
            assert_eq!((launch.first_edge_us, launch.by), (edge_us, Confirmation::Unconfirmed));
        }
        for (change_mps, limit_us) in [(-3.0, 3_000_000), (0.0, 60_000_000)] {
            let mut rig = captive();
            assert_eq!(rig.run(0.5, dead), None);
            rig.climb_mps += change_mps;
            let launch = rig.run(60.0, dead).unwrap();
            assert_eq!(launch.confirmed_us - launch.first_edge_us, limit_us);
        }
        // In the meantime the carrier has swung by 3 m/s.
        for climbed_mps in [0.0, 3.0] {
            let mut rig = captive();
            assert_eq!(rig.run(5.0, dead), None);
            assert_eq!(rig.run(54.0, TORN), None);
            rig.climb_mps += climbed_mps;
            assert!(rig.suspected_for_s().is_some_and(|suspected_s| suspected_s > 58.0));
            assert_eq!(rig.run(2.0, TORN), None);
            assert_eq!((rig.state(), rig.detector.wire()), (LaunchState::Captive, WireCondition::Broken));
        }
        // If the receiver falls silent too, there is no evidence left.
        let mut rig = captive();
        assert_eq!(rig.run(10.0, dead), None);
        assert_eq!(
            rig.run(2.0, Now { fixes: Fixes::None, ..dead }).map(|launch| launch.by),
            Some(Confirmation::Unconfirmed)
        );
    }
}

/// A unit reads free fall, and a second later the wire breaks: no release is felt that long before the wire
/// opens, and the fixes show no fall.
#[test]
fn a_wire_that_breaks_in_a_fall_that_is_none_is_no_launch() {
    let falls = Now { load: Some(0.1), is_sending: false, fixes: Fixes::Level, ..CAPTIVE };
    // Gusts end the fall for moments, the last time just before the edge.
    for before_s in [1.0, 0.1] {
        let mut rig = Rig::captive();
        assert_eq!(rig.run(10.0, Now { is_sending: false, ..CAPTIVE }), None);
        assert_eq!(rig.run(1.0, falls), None);
        assert_eq!(rig.run(0.1, Now { load: Some(0.4), ..falls }), None);
        assert_eq!(rig.run(before_s, falls), None);
        assert_eq!(rig.run(2.9, Now { is_open: Some(true), ..falls }), None);
        assert!(rig.suspected_for_s().is_some());
        assert_eq!(rig.run(20.0, falls), None);
        assert_eq!(rig.state(), LaunchState::Captive);
    }
    // Such a unit shows nothing about a release; a loss of 3 m/s of climb rate does.
    let mut rig = Rig::captive();
    assert_eq!(rig.run(10.0, Now { is_sending: false, ..CAPTIVE }), None);
    assert_eq!(rig.run(1.0, falls), None);
    let edge_us = rig.now_us() + TICK_US;
    rig.climb_mps -= 3.0;
    let launch = rig.run(5.0, Now { is_open: Some(true), ..falls }).unwrap();
    assert_eq!((launch.confirmed_us, launch.by), (edge_us + 3_000_000, Confirmation::Unconfirmed));
    // Without fixes nothing contradicts the fall; with these it is confirmed.
    for fixes in [Fixes::None, Fixes::ByLoad] {
        let mut rig = Rig::captive();
        assert_eq!(rig.run(10.0, Now { is_sending: false, ..CAPTIVE }), None);
        assert_eq!(rig.run(0.4, Now { fixes, ..falls }), None);
        assert!(rig.run(3.0, Now { is_open: Some(true), fixes, ..falls }).is_some());
    }
}

/// A unit reads a fall from half a second before the wire opens until shortly after it, and then what it read
/// under the pylon: it would not have felt a release, so the climb rate decides.
#[test]
fn a_unit_that_reads_a_fall_as_the_wire_opens_proves_no_torn_cable() {
    for (is_sending, after_s) in [(true, 0.3), (true, 0.6), (false, 0.3), (false, 0.6)] {
        let mut rig = Rig::captive();
        let captive = Now { is_sending, ..CAPTIVE };
        assert_eq!(rig.run(10.0, captive), None);
        let falls = Now { load: Some(0.1), fixes: Fixes::Level, ..captive };
        assert_eq!(rig.run(0.5, falls), None);
        let edge_us = rig.now_us() + TICK_US;
        let open = Now { is_open: Some(true), is_sending: false, fixes: Fixes::Level, ..CAPTIVE };
        assert_eq!(rig.run(after_s, Now { load: Some(0.1), ..open }), None);
        assert_eq!(rig.run(10.0, open), None);
        assert!(rig.suspected_for_s().is_some());
        rig.climb_mps += 4.5;
        let launch = rig.run(1.0, open).unwrap();
        assert_eq!(launch.by, Confirmation::Unconfirmed);
        // Without messages the fall has raised the suspicion.
        assert_eq!(launch.first_edge_us == edge_us, is_sending);
    }
}

/// No vehicle leaves without a change of force for three seconds: a torn cable needs no receiver to be
/// recognised.
#[test]
fn a_torn_cable_is_none_without_a_receiver_either() {
    let mut rig = Rig::new();
    rig.run(20.0, Now { fixes: Fixes::None, ..CAPTIVE });
    assert_eq!(rig.run(60.0, Now { fixes: Fixes::None, ..TORN }), None);
    assert_eq!((rig.state(), rig.detector.wire()), (LaunchState::Captive, WireCondition::Broken));
}

/// A second after a start there is nothing to compare a change with. In flight, with the traces of a mission,
/// the supply has dipped, and the opening may be the release; otherwise the vehicle is being made ready, or
/// the cable was torn.
#[test]
fn a_release_soon_after_a_dip_of_the_supply_in_flight_is_seen() {
    let after = |has_traces, ground_speed_mps, captive_s, now: Now| {
        let mut rig = Rig { ground_speed_mps, ..Rig::new() };
        if has_traces {
            rig.detector.note_traces();
        }
        rig.run(captive_s, Now { fixes: now.fixes, ..CAPTIVE });
        let torn = Now { fixes: now.fixes, ..TORN };
        rig.run(1.0, now).or_else(|| rig.run(5.0, torn)).map(|launch| launch.by)
    };
    for captive_s in [0.5, 1.5, 4.0] {
        let by = after(true, 40.0, captive_s, RELEASED);
        assert!(matches!(by, Some(Confirmation::Force | Confirmation::Unconfirmed)), "{captive_s}: {by:?}");
        assert_eq!(after(true, 5.0, captive_s, TORN), None);
        assert_eq!(after(false, 40.0, captive_s, TORN), None);
    }
    // A unit that has delivered for less than the cable's slack may have missed the release.
    assert_eq!(after(true, 40.0, 0.2, TORN), Some(Confirmation::Unconfirmed));
    let mut rig = Rig::new();
    rig.detector.resume_captive();
    rig.run(0.2, Now { fixes: Fixes::None, ..CAPTIVE });
    let launch = rig.run(5.0, Now { fixes: Fixes::None, ..TORN });
    assert_eq!(launch.map(|launch| launch.by), Some(Confirmation::Unconfirmed));
    // A unit that delivered before the edge and shows no change means a torn cable.
    for captive_s in [0.5, 1.5, 4.0] {
        assert_eq!(after(true, 40.0, captive_s, TORN), None);
    }
}

/// A restart between the fall that raised a suspicion and the opening of the wire, or between two bounces: the
/// suspicion is one with that of the opening. If nothing opens within the cable's slack, it was none.
#[test]
fn a_suspicion_outlasts_a_restart_by_the_cables_slack() {
    let restarted = |closed_s: f32| {
        let mut rig = Rig::new();
        rig.detector.resume_suspected(None);
        rig.run(closed_s, Now { load: Some(0.4), ..CAPTIVE });
        rig
    };
    let since = |rig: &Rig| match rig.state() {
        LaunchState::Suspected { since_us } => Some(since_us),
        _ => None,
    };
    let mut rig = restarted(CONFIG.window_s - 0.01);
    let first = since(&rig);
    assert_eq!(first, Some(TICK_US));
    rig.step(RELEASED);
    assert_eq!(since(&rig), first);
    assert_eq!(restarted(CONFIG.window_s + 0.01).state(), LaunchState::Captive);
}

/// A cable tears, and the supply dips half a second later: the start knows that the force had not departed and
/// what it was like, so it decides as if there had been no dip. If the dip comes sooner, nothing is known.
#[test]
fn a_torn_cable_is_none_after_a_restart_either() {
    let restarted = |before_s: f32, torn: Now, now: Now| {
        let mut rig = Rig::captive();
        rig.run(before_s, torn);
        let force = rig.detector.captive_force();
        let mut next = Rig::new();
        next.detector.resume_suspected(force);
        // Another dip, before the window has passed again.
        next.run(0.1, now);
        assert_eq!(next.detector.captive_force(), force);
        let mut last = Rig::new();
        last.detector.resume_suspected(next.detector.captive_force());
        let launch = last.run(10.0, now).map(|launch| launch.by);
        assert_eq!(launch.is_none(), last.detector.wire() == WireCondition::Broken);
        (force.is_some(), launch)
    };
    assert_eq!(restarted(0.5, TORN, TORN), (true, None));
    assert_eq!(restarted(0.1, TORN, TORN), (false, Some(Confirmation::Unconfirmed)));
    assert_eq!(restarted(0.4, RELEASED, RELEASED), (false, Some(Confirmation::Unconfirmed)));
    // It was a release without a step: the vehicle now vibrates, or sinks.
    for now in [Now { vibration: 0.6, ..TORN }, Now { load: Some(0.85), ..TORN }] {
        assert_eq!(restarted(0.5, TORN, now), (true, Some(Confirmation::Unconfirmed)));
    }
    // A dead unit shows neither.
    let dead = Now { load: None, ..TORN };
    assert_eq!(restarted(0.5, TORN, dead), (true, Some(Confirmation::Unconfirmed)));
    // A suspicion that is over has nothing to hand on.
    let mut rig = Rig::captive();
    rig.run(0.5, TORN);
    assert!(rig.detector.captive_force().is_some());
    rig.run(1.0, CAPTIVE);
    assert_eq!((rig.state(), rig.detector.captive_force()), (LaunchState::Captive, None));
}

/// In the first seconds only a departure can show a release, so the wire is broken as soon as the window has
/// passed without one, before the next dip of the supply.
#[test]
fn a_wire_that_breaks_soon_after_a_dip_is_called_broken_at_once() {
    let mut rig = Rig::new();
    rig.detector.note_traces();
    rig.run(0.4, CAPTIVE);
    assert_eq!(rig.run(0.24, TORN), None);
    assert_eq!(rig.detector.wire(), WireCondition::Open);
    assert_eq!(rig.run(0.02, TORN), None);
    assert_eq!((rig.state(), rig.detector.wire()), (LaunchState::Captive, WireCondition::Broken));
    // It was a release after all: it falls.
    assert!(rig.run(3.0, RELEASED).is_some());
}

/// A unit that reads no force for five seconds under the pylon must not widen the spreads that departures and
/// changes are compared with.
#[test]
fn free_fall_that_was_none_hides_no_release() {
    let mut rig = Rig::captive();
    rig.run(5.0, Now { load: Some(0.0), fixes: Fixes::Level, ..CAPTIVE });
    assert_eq!(rig.run(5.0, CAPTIVE), None);
    let edge_us = rig.now_us() + TICK_US;
    let launch = rig.run(2.0, RELEASED).unwrap();
    assert_eq!((launch.first_edge_us, launch.by), (edge_us, Confirmation::Force));
}

/// A vehicle that soon carries itself shows its release for a second. A unit that is silent in that second
/// cannot show that nothing changed, even if it delivers afterwards.
#[test]
fn a_unit_that_was_silent_at_the_edge_denies_no_launch() {
    let mut rig = Rig::captive();
    rig.run(0.5, Now { load: None, ..CAPTIVE });
    rig.climb_mps -= 3.0;
    assert_eq!(rig.run(1.5, Now { load: None, ..TORN }), None);
    assert_eq!(rig.run(5.0, TORN).map(|launch| launch.by), Some(Confirmation::Unconfirmed));
}

/// A unit reads twelve g for a fifth of a second as it is switched on.
#[test]
fn wild_samples_at_power_on_hide_no_departure() {
    let mut rig = Rig::new();
    rig.run(0.3, CAPTIVE);
    rig.run(0.2, Now { load: Some(12.0), ..CAPTIVE });
    rig.run(20.0, CAPTIVE);
    assert_eq!(rig.run(5.0, RELEASED).map(|launch| launch.by), Some(Confirmation::Force));
}

/// The wire is shorted for 0.9 s soon after it has opened: the departure about its first opening counts at
/// the next one. After a longer rest it does not.
#[test]
fn a_wire_that_closes_for_a_moment_has_opened_once() {
    let carries_itself = Now { vibration: CAPTIVE.vibration, load: Some(1.0), fixes: Fixes::None, ..TORN };
    for (shorted_s, is_launch) in [(0.9, true), (1.1, false)] {
        let mut rig = Rig::captive();
        let jolt = Now { load: Some(0.5), ..carries_itself };
        assert_eq!(rig.run(0.1, jolt), None);
        assert_eq!(rig.run(0.1, carries_itself), None);
        assert_eq!(rig.run(shorted_s, Now { is_open: Some(false), ..carries_itself }), None);
        let launch = rig.run(5.0, carries_itself);
        assert_eq!(launch.map(|launch| launch.by), is_launch.then_some(Confirmation::Unconfirmed));
    }
}

/// One wild sample in captive flight must not widen the spread so that a release's change of roughness is
/// hidden for ten seconds.
#[test]
fn one_wild_sample_hides_no_release() {
    let mut rig = Rig::captive();
    rig.step(Now { load: Some(-15.0), ..CAPTIVE });
    assert_eq!(rig.run(2.0, CAPTIVE), None);
    let launch = rig.run(2.0, Now { vibration: 1.0, ..TORN }).unwrap();
    assert_eq!(launch.by, Confirmation::Silence);
}

/// A plug that bounces in the release itself and comes to rest open is no broken wire: a second later it has
/// opened. One whose vehicle still hangs is broken, and stays so while it is open.
#[test]
fn a_bouncing_wire_that_rests_open_has_opened() {
    for is_released in [true, false] {
        let mut rig = Rig::new();
        assert_eq!(rig.run(20.0, Now { is_sending: false, ..CAPTIVE }), None);
        let vibration = if is_released { 1.0 } else { 0.3 };
        let open = Now { is_open: Some(true), is_sending: false, vibration, ..CAPTIVE };
        for _ in 0..6 {
            assert_eq!(rig.run(0.05, open), None);
            assert_eq!(rig.run(0.05, Now { is_open: Some(false), ..open }), None);
        }
        assert_eq!(rig.detector.wire(), WireCondition::Broken);
        assert_eq!(rig.run(0.9, open), None);
        assert_eq!(rig.detector.wire(), WireCondition::Broken);
        let launch = rig.run(10.0, open);
        assert_eq!(launch.map(|launch| launch.by), is_released.then_some(Confirmation::Unconfirmed));
        if !is_released {
            assert_eq!((rig.state(), rig.detector.wire()), (LaunchState::Captive, WireCondition::Broken));
            assert_eq!((rig.detector.counts().torn_cables, rig.detector.counts().mended_wires), (1, 1));
        }
    }
}

/// A cable tears, and its accelerometer reads a fall 1.9 s later: a release is felt about the edge, so the
/// fixes must show that fall. If they do, it is a launch.
#[test]
fn a_fall_after_a_torn_cable_needs_the_climb_rate() {
    for (fixes, is_launch) in [(Fixes::Level, false), (Fixes::ByLoad, true)] {
        let mut rig = Rig::captive();
        assert_eq!(rig.run(1.9, TORN), None);
        let falls = Now { load: Some(0.1), fixes, ..TORN };
        assert_eq!(rig.run(1.0, falls).is_some(), is_launch);
        if !is_launch {
            assert_eq!(rig.run(30.0, TORN), None);
            assert_eq!((rig.state(), rig.detector.wire()), (LaunchState::Captive, WireCondition::Broken));
        }
    }
}

#[test]
fn the_wire_decides_where_nothing_else_can_say() {
    for fixes in [Fixes::ByLoad, Fixes::None] {
        let mut rig = Rig::new();
        let alone = Now { load: None, fixes, is_sending: false, ..CAPTIVE };
        assert_eq!(rig.run(20.0, alone), None);
        let edge_us = rig.now_us() + TICK_US;
        let launch = rig.run(10.0, Now { is_open: Some(true), ..alone }).unwrap();
        let wanted = Launch {
            first_edge_us: edge_us,
            confirmed_us: edge_us + 3_000_000,
            by: Confirmation::Unconfirmed,
        };
        assert_eq!(launch, wanted);
        assert_eq!(rig.state().doubt(), LaunchDoubt::Unconfirmed);
    }
    // With both, and messages that ended long before: a breaking wire is no launch, a release is.
    for (now, by) in [(TORN, None), (RELEASED, Some(Confirmation::Force))] {
        let mut rig = Rig::captive();
        assert_eq!(rig.run(10.0, Now { is_sending: false, ..CAPTIVE }), None);
        assert_eq!(rig.run(10.0, now).map(|launch| launch.by), by);
    }
}

/// In air so rough that 0.3 g occurs every second, a breaking wire is not taken for a release, and a release
/// is detected.
#[test]
fn rough_air_widens_what_counts_as_a_departure() {
    let (mut false_launches, mut felt) = (0, 0);
    for seed in 0..200 {
        let mut rig = Rig::new();
        (rig.seed, rig.gust_sigma) = (seed * 7_919 + 1, 0.15);
        rig.run(30.0, CAPTIVE);
        let mut released = Rig { detector: rig.detector.clone(), ..rig };
        false_launches += u32::from(rig.run(4.0, OPEN).is_some());
        felt += u32::from(
            released
                .run(2.0, Now { load: Some(0.1), ..RELEASED })
                .is_some_and(|launch| launch.by == Confirmation::Force),
        );
    }
    // At 4 sigmas the chance is one in 1,600 per break; four or more of 200 are practically impossible. A
    // release is a step of 0.9 g, six sigmas of 0.15 g.
    assert!(false_launches <= 3, "{false_launches}");
    assert!(felt >= 195, "{felt}");
}

/// Half a second of wild samples, seconds before the release, must not hide a step of 0.3 g that a wing's
/// lift takes back within a second.
#[test]
fn wild_samples_before_a_release_hide_no_departure() {
    for wild_load in [0.0, 10.7] {
        let mut rig = Rig::captive();
        rig.run(0.5, Now { load: (wild_load > 0.0).then_some(wild_load), ..CAPTIVE });
        rig.run(2.5, CAPTIVE);
        let mut launch = None;
        for tick in 0..800 {
            let load = 0.6 + 0.4 * (tick as f32 / 160.0).min(1.0);
            launch = launch.or(rig.run(0.005, Now { load: Some(load), ..RELEASED }));
        }
        assert!(launch.is_some(), "{wild_load}: {:?} {:?}", rig.state(), rig.detector.wire());
    }
}

/// A flipped bit, or a unit that reads free fall, seconds after a release whose step a wing has taken back,
/// must not undo the departure.
#[test]
fn wild_samples_after_a_release_undo_no_departure() {
    for (wild_load, wild_ticks) in [(8.0, 1), (0.0, 600), (-4.0, 3)] {
        let mut rig = Rig::captive();
        let mut launch = None;
        for tick in 0..800 {
            let is_wild = (260..260 + wild_ticks).contains(&tick);
            let load = if is_wild { wild_load } else { 0.4 + 0.6 * (tick as f32 / 40.0).min(1.0) };
            launch = launch.or(rig.run(0.005, Now { load: Some(load), fixes: Fixes::Level, ..RELEASED }));
        }
        let Some(launch) = launch else { panic!("{wild_load}: {:?} {:?}", rig.state(), rig.detector.wire()) };
        assert!(launch.confirmed_us - launch.first_edge_us <= 3_100_000, "{wild_load}: {launch:?}");
    }
}
