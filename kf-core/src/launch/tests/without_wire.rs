//! The rows of a wire that shows no opening: closed, broken or unreadable.

use super::*;

#[test]
fn after_a_torn_cable_a_fall_is_a_launch() {
    let mut rig = Rig::captive();
    assert_eq!(rig.run(10.0, TORN), None);
    for no_release in [
        Now { load: Some(1.6), ..TORN },
        Now { load: Some(0.5), fixes: Fixes::Level, ..TORN },
        Now { load: Some(0.05), fixes: Fixes::Level, ..TORN },
    ] {
        assert_eq!(rig.run(0.4, no_release), None);
        assert_eq!(rig.run(10.0, TORN), None);
    }
    assert_eq!((rig.state(), rig.detector.counts().false_alarms), (LaunchState::Captive, 3));
    let mut fallen = Rig { detector: rig.detector.clone(), ..rig };
    let launch = rig.run(3.0, RELEASED).unwrap();
    assert_eq!(launch.by, Confirmation::Unconfirmed);
    let launch = fallen.run(3.0, Now { load: Some(0.1), ..TORN }).unwrap();
    assert!(matches!(launch.by, Confirmation::FreeFall | Confirmation::Unconfirmed), "{launch:?}");
}

/// Messages that continue are the mother ship's, whatever the force does when the wire breaks.
#[test]
fn a_broken_wire_is_none_whatever_the_accelerometer_reads() {
    for load in [None, Some(0.0), Some(0.4), Some(3.0), Some(16.0)] {
        let mut rig = Rig::captive();
        assert_eq!(rig.run(5.0, Now { load, fixes: Fixes::Level, ..OPEN }), None);
        assert_eq!(rig.run(5.0, OPEN), None);
        assert_eq!(
            (rig.state(), rig.detector.wire()),
            (LaunchState::Captive, WireCondition::Broken),
            "{load:?}"
        );
    }
}

#[test]
fn a_broken_wire_is_found_and_a_later_launch_is_not_missed() {
    let mut rig = Rig::captive();
    assert_eq!(rig.run(0.25, OPEN), None);
    assert!(rig.suspected_for_s().is_some());
    assert_eq!(rig.run(60.0, OPEN), None);
    assert_eq!((rig.state(), rig.detector.wire()), (LaunchState::Captive, WireCondition::Broken));
    assert_eq!(rig.detector.counts().broken_wires, 1);
    // A gust alone is no launch.
    assert_eq!(rig.run(0.5, Now { load: Some(1.6), ..OPEN }), None);
    assert_eq!(rig.run(20.0, OPEN), None);
    assert_eq!((rig.state(), rig.detector.counts().false_alarms), (LaunchState::Captive, 1));
    let released_us = rig.now_us();
    let launch = rig.run(5.0, RELEASED).unwrap();
    assert_eq!(launch.by, Confirmation::ForceAndSilence);
    // The departure is noticed within the smoothing, the silence after five intervals of 20 ms.
    assert!(launch.first_edge_us - released_us <= 40_000, "{launch:?}");
    assert!((75_000..=105_000).contains(&(launch.confirmed_us - released_us)), "{launch:?} {released_us}");
}

/// A loose contact: it is broken after five openings, holds no calibration any more, and hides no release.
#[test]
fn a_bouncing_wire_is_broken_until_it_rests() {
    let mut rig = Rig::captive();
    for _ in 0..100 {
        assert_eq!(rig.run(0.06, OPEN), None);
        assert_eq!(rig.run(0.1, CAPTIVE), None);
    }
    assert_eq!((rig.state(), rig.detector.wire()), (LaunchState::Captive, WireCondition::Broken));
    let counts = rig.detector.counts();
    assert_eq!((counts.broken_wires, counts.reclosures, counts.mended_wires), (1, 5, 0));
    let mut rested = Rig { detector: rig.detector.clone(), ..rig };
    assert_eq!(rested.run(4.0, CAPTIVE), None);
    assert_eq!(rested.detector.wire(), WireCondition::Closed);
    let mut launched = None;
    for _ in 0..20 {
        for is_open in [true, false] {
            launched = launched.or(rig.run(0.08, Now { is_open: Some(is_open), ..RELEASED }));
        }
    }
    assert_eq!(launched.map(|launch| launch.by), Some(Confirmation::ForceAndSilence));
}

#[test]
fn a_broken_wire_can_be_whole_again() {
    let mut rig = Rig::captive();
    assert_eq!(rig.run(4.0, OPEN), None);
    assert_eq!(rig.run(0.015, CAPTIVE), None);
    assert_eq!(rig.detector.wire(), WireCondition::Broken);
    assert_eq!(rig.run(1.0, CAPTIVE), None);
    assert_eq!((rig.detector.wire(), rig.detector.counts().mended_wires), (WireCondition::Closed, 1));
    assert_eq!(rig.run(2.0, RELEASED).map(|launch| launch.by), Some(Confirmation::Force));
}

/// A broken wire, and then the messages end: a launch if anything else changes or nothing can show a change,
/// otherwise two faults.
#[test]
fn silence_after_a_broken_wire_needs_a_change() {
    for (now, by) in [
        (TORN, None),
        (Now { vibration: 0.6, ..TORN }, Some(Confirmation::ForceAndSilence)),
        (Now { load: None, ..TORN }, Some(Confirmation::Unconfirmed)),
    ] {
        let mut rig = Rig::captive();
        assert_eq!(rig.run(5.0, OPEN), None);
        let silent_us = rig.now_us();
        let launch = rig.run(10.0, now);
        assert_eq!(launch.map(|launch| launch.by), by);
        if let Some(launch) = launch {
            let suspected_us = launch.first_edge_us - silent_us;
            assert!((80_000..=105_000).contains(&suspected_us), "{suspected_us}");
        } else {
            assert_eq!((rig.state(), rig.detector.counts().false_alarms), (LaunchState::Captive, 1));
        }
    }
}

#[test]
fn a_stuck_wire_needs_a_fall_and_silence() {
    let falling = Now { load: Some(0.05), fixes: Fixes::Level, ..CAPTIVE };
    // Five seconds of fall with messages: a dead accelerometer, whatever it reads.
    let mut rig = Rig::captive();
    assert_eq!(rig.run(5.0, falling), None);
    assert_eq!(rig.state(), LaunchState::Captive);
    // Silence without a fall.
    let mut rig = Rig::captive();
    assert_eq!(rig.run(60.0, Now { is_sending: false, ..CAPTIVE }), None);
    assert_eq!(rig.state(), LaunchState::Captive);
    // A jolt and silence: the fall is too short.
    let mut rig = Rig::captive();
    assert_eq!(rig.run(0.2, Now { is_sending: false, ..falling }), None);
    assert_eq!(rig.run(60.0, Now { is_sending: false, ..CAPTIVE }), None);
    assert_eq!((rig.state(), rig.detector.counts().false_alarms), (LaunchState::Captive, 1));
    // Both: a launch after the fall's least time. The vehicle may then pull out.
    let mut rig = Rig::captive();
    let released_us = rig.now_us();
    assert_eq!(rig.run(0.2, Now { is_sending: false, ..falling }), None);
    let launch = rig.run(5.0, Now { is_sending: false, ..falling }).unwrap();
    assert_eq!(launch.by, Confirmation::StuckWire);
    // From 1 g to 0.3 g takes the smoothing of 30 ms 2 ln(1/0.3) of its constants: 72 ms.
    assert!(launch.first_edge_us - released_us <= 80_000, "{launch:?}");
    assert_eq!(launch.confirmed_us - launch.first_edge_us, 300_000);
    // Slow messages, silent only after the pull-out.
    let mut rig = Rig::new();
    rig.message_ticks = 40;
    rig.run(20.0, CAPTIVE);
    assert_eq!(rig.run(0.6, Now { is_sending: false, ..falling }), None);
    let launch = rig.run(5.0, Now { is_sending: false, ..CAPTIVE }).unwrap();
    assert_eq!(launch.by, Confirmation::StuckWire);
}

/// A wire that reads closed or cannot be read, and no messages: the climb rate must confirm the
/// accelerometer's fall.
#[test]
fn without_messages_only_a_fall_of_force_and_climb_rate_shows_a_launch() {
    for is_open in [Some(false), None] {
        let quiet = Now { is_open, is_sending: false, ..CAPTIVE };
        let falling = Now { load: Some(0.1), ..quiet };
        let mut rig = Rig::new();
        assert_eq!(rig.run(10.0, quiet), None);
        // Too short to show in the climb rate.
        assert_eq!(rig.run(0.4, falling), None);
        assert_eq!(rig.run(10.0, quiet), None);
        assert_eq!((rig.state(), rig.detector.counts().false_alarms), (LaunchState::Captive, 1));
        // A dead accelerometer, for any time.
        assert_eq!(rig.run(60.0, Now { fixes: Fixes::Level, ..falling }), None);
        assert_eq!((rig.state(), rig.detector.counts().false_alarms), (LaunchState::Captive, 2));
        assert_eq!(rig.run(10.0, quiet), None);
        let launch = rig.run(5.0, falling).unwrap();
        // 5 m/s at 0.9 g take 0.57 s, the fix up to 0.1 s more; the fall is noticed after the smoothing.
        assert!(launch.confirmed_us - launch.first_edge_us <= 700_000, "{launch:?}");
    }
}

/// Without fixes a closed wire holds, and one that cannot be read does not.
#[test]
fn without_fixes_a_fall_does_not_overrule_a_closed_wire() {
    for (is_open, by) in [(Some(false), None), (None, Some(Confirmation::FreeFall))] {
        let quiet = Now { is_open, is_sending: false, fixes: Fixes::None, ..CAPTIVE };
        let mut rig = Rig::new();
        assert_eq!(rig.run(10.0, quiet), None);
        let launch = rig.run(5.0, Now { load: Some(0.1), ..quiet });
        assert_eq!(launch.map(|launch| launch.by), by);
    }
}

/// An accelerometer that reads zero does not show a fall.
#[test]
fn a_dead_accelerometer_is_no_fall() {
    let mut rig = Rig::captive();
    rig.last_message_us = None;
    for k in 1..2_000 {
        let force_mps2 = Some(if k % 3 == 0 { [f32::NAN, 0.0, 0.0] } else { [0.0; 3] });
        let time_us = rig.now_us() + k * TICK_US;
        rig.detector.tick(&LaunchInput {
            time_us,
            is_open: Some(false),
            force_mps2,
            ..LaunchInput::default()
        });
        assert_eq!(rig.state(), LaunchState::Captive);
    }
    assert_eq!(rig.detector.counts().forces_refused, 1_999);
}

#[test]
fn a_wire_that_can_not_be_read_says_nothing() {
    let unreadable = Now { is_open: None, ..CAPTIVE };
    let mut rig = Rig::captive();
    assert_eq!(rig.run(2.0, unreadable), None);
    assert_eq!(rig.detector.wire(), WireCondition::Closed);
    assert_eq!(rig.run(2.0, unreadable), None);
    assert_eq!((rig.state(), rig.detector.wire()), (LaunchState::Captive, WireCondition::Unreadable));
    assert_eq!(rig.detector.counts().unreadable, 800);
    // Neither the end of the messages nor a gust makes it a launch.
    assert_eq!(rig.run(10.0, Now { load: Some(1.5), ..unreadable }), None);
    assert_eq!(rig.run(10.0, unreadable), None);
    let launch = rig.run(5.0, Now { is_open: None, ..RELEASED }).unwrap();
    assert_eq!(launch.by, Confirmation::ForceAndSilence);
    // Unreadable in the middle of an opening: a reading that is missing does not make it closed.
    let mut rig = Rig::captive();
    for is_open in [Some(true), None, None, None] {
        rig.step(Now { is_open, is_sending: false, ..CAPTIVE });
    }
    assert!(rig.suspected_for_s().is_some());
    rig.run(0.2, Now { is_sending: false, ..CAPTIVE });
    assert_eq!(rig.detector.counts().bounces, 1);
    // And for good before it was debounced: no launch by that wire.
    let mut rig = Rig::captive();
    rig.step(OPEN);
    assert_eq!(rig.run(10.0, unreadable), None);
    assert_eq!(rig.state(), LaunchState::Captive);
}
