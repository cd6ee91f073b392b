//! Every row of the decision table, on made-up wires, forces and messages.

use proptest::prelude::*;

use super::*;
use crate::input::LaunchDoubt;

mod clock;

const TICK_US: u64 = 5_000;
const G: f32 = 9.806_65;
const CONFIG: LaunchConfig = LaunchConfig::DEFAULT;

/// What the fixes say of the climb rate.
#[derive(Clone, Copy, PartialEq)]
enum Fixes {
    None,
    /// Whatever the accelerometer reads, the climb rate stays.
    Level,
    /// It is the load factor's integral.
    ByLoad,
}

/// A tick's wire, load factor, climb rate, and whether the mother ship's messages are sent.
#[derive(Clone, Copy)]
struct Now {
    is_open: Option<bool>,
    load: Option<f32>,
    is_sending: bool,
    fixes: Fixes,
    /// Standard deviation of each axis's noise, m/s^2: an engine's vibration.
    vibration: f32,
}

const CAPTIVE: Now =
    Now { is_open: Some(false), load: Some(1.0), is_sending: true, fixes: Fixes::ByLoad, vibration: 0.3 };

struct Rig {
    detector: LaunchDetector,
    tick: u64,
    last_message_us: Option<u64>,
    message_ticks: u64,
    seed: u32,
    /// Standard deviation of the load factor by gusts, g, and its value now.
    gust_sigma: f32,
    gust: f32,
    climb_mps: f32,
    ground_speed_mps: f32,
    /// How far the clock has leapt on.
    leapt_us: u64,
}

impl Rig {
    fn new() -> Self {
        let detector = LaunchDetector::new(CONFIG).unwrap();
        Self {
            detector,
            tick: 0,
            last_message_us: None,
            message_ticks: 4,
            seed: 1,
            gust_sigma: 0.02,
            gust: 0.0,
            climb_mps: 2.0,
            ground_speed_mps: 40.0,
            leapt_us: 0,
        }
    }

    /// After ten seconds under the pylon.
    fn captive() -> Self {
        let mut rig = Self::new();
        rig.run(10.0, CAPTIVE);
        assert_eq!(rig.detector.state(), LaunchState::Captive);
        rig
    }

    /// Sum of twelve uniform numbers: of variance 1.
    fn normal(&mut self) -> f32 {
        let mut sum = -6.0;
        for _ in 0..12 {
            self.seed = self.seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            sum += (self.seed >> 8) as f32 / 16_777_216.0;
        }
        sum
    }

    fn now_us(&self) -> u64 {
        (self.tick * TICK_US).wrapping_add(self.leapt_us)
    }

    fn step(&mut self, now: Now) -> LaunchState {
        self.tick += 1;
        if now.is_sending && self.tick.is_multiple_of(self.message_ticks) {
            self.last_message_us = Some(self.now_us());
        }
        // Gusts of half a second.
        let fade = 0.01f32;
        self.gust += self.gust_sigma * (2.0 * fade).sqrt() * self.normal() - fade * self.gust;
        let noise = [now.vibration; 3].map(|sigma| sigma * self.normal());
        if now.fixes == Fixes::ByLoad {
            self.climb_mps += (now.load.unwrap_or(1.0) - 1.0) * G * 0.005;
        }
        let has_fix = now.fixes != Fixes::None && self.tick.is_multiple_of(20);
        let climb_mps = has_fix.then_some(self.climb_mps);
        let ground_speed_squared_m2ps2 = has_fix.then_some(self.ground_speed_mps * self.ground_speed_mps);
        let force_mps2 = now.load.map(|load| {
            [noise[0], noise[1], noise[2] - G * load - if load > 0.5 { G * self.gust } else { 0.0 }]
        });
        let time_us = self.now_us();
        self.detector.tick(&LaunchInput {
            time_us,
            is_open: now.is_open,
            force_mps2,
            last_message_us: self.last_message_us,
            climb_mps,
            ground_speed_squared_m2ps2,
        })
    }

    /// Runs for some seconds; stops where a launch is confirmed.
    fn run(&mut self, seconds: f32, now: Now) -> Option<Launch> {
        for _ in 0..(seconds * 200.0).round() as u64 {
            if let LaunchState::Launched(launch) = self.step(now) {
                return Some(launch);
            }
        }
        None
    }

    fn state(&self) -> LaunchState {
        self.detector.state()
    }

    fn suspected_for_s(&self) -> Option<f32> {
        match self.state() {
            LaunchState::Suspected { since_us } => Some((self.now_us() - since_us) as f32 * 1e-6),
            _ => None,
        }
    }
}

const OPEN: Now = Now { is_open: Some(true), ..CAPTIVE };
/// Released: open, own lift of 0.4 g, nobody sends.
const RELEASED: Now = Now { is_open: Some(true), load: Some(0.4), is_sending: false, ..CAPTIVE };
/// The cable is torn under the pylon, or a release that nothing on board feels.
const TORN: Now = Now { is_open: Some(true), is_sending: false, ..CAPTIVE };

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

/// An ejector's push is a departure too, also where the vehicle then carries itself: it has been pushed away,
/// or its engine runs. Where nothing goes on being different, a jolt may have torn the cable.
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

/// A turn that lasts is what the vehicle is carried in: a release out of it departs from the turn's load, by
/// whatever level flight has.
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

/// A release without a step: another vibration, drag or climb rate shows it, with messages of any rate.
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

/// The cable is torn as a whole under the pylon: wire and messages both say so, and nothing on board moves
/// otherwise.
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

/// Where nobody can say whether the cable is torn, it is a launch, and says that it is not confirmed.
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

/// A unit that has died and a cable that is torn are no launch as long as the fixes show the mother ship's
/// climb rate. A release that a dead unit does not feel is seen in it: at the limit if it sinks, when the
/// vehicle is first steered, or after a minute.
#[test]
fn with_a_dead_unit_the_climb_rate_decides() {
    for dead in [Now { load: None, ..TORN }, Now { vibration: 0.0, ..TORN }] {
        let captive = || {
            let mut rig = Rig::captive();
            (rig.gust, rig.gust_sigma) = (0.0, 0.0);
            rig.run(2.0, Now { is_sending: true, is_open: Some(false), ..dead });
            rig
        };
        for change_mps in [-3.0, 3.0] {
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
        // A receiver that falls silent too is no witness any more.
        let mut rig = captive();
        assert_eq!(rig.run(10.0, dead), None);
        assert_eq!(
            rig.run(2.0, Now { fixes: Fixes::None, ..dead }).map(|launch| launch.by),
            Some(Confirmation::Unconfirmed)
        );
    }
}

/// A unit reads free fall, and a second later the wire breaks: no release is felt so long before it is seen,
/// and the fixes show no fall.
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
    // A unit that lies so shows neither a release nor that there is none: 3 m/s off the climb rate do.
    let mut rig = Rig::captive();
    assert_eq!(rig.run(10.0, Now { is_sending: false, ..CAPTIVE }), None);
    assert_eq!(rig.run(1.0, falls), None);
    let edge_us = rig.now_us() + TICK_US;
    rig.climb_mps -= 3.0;
    let launch = rig.run(5.0, Now { is_open: Some(true), ..falls }).unwrap();
    assert_eq!((launch.confirmed_us, launch.by), (edge_us + 3_000_000, Confirmation::Unconfirmed));
    // Without fixes nobody denies it, and with them it falls.
    for fixes in [Fixes::None, Fixes::ByLoad] {
        let mut rig = Rig::captive();
        assert_eq!(rig.run(10.0, Now { is_sending: false, ..CAPTIVE }), None);
        assert_eq!(rig.run(0.4, Now { fixes, ..falls }), None);
        assert!(rig.run(3.0, Now { is_open: Some(true), fixes, ..falls }).is_some());
    }
}

/// A vehicle that leaves and feels nothing of it for three seconds does not exist: that needs no receiver to
/// know.
#[test]
fn a_torn_cable_is_none_without_a_receiver_either() {
    let mut rig = Rig::new();
    rig.run(20.0, Now { fixes: Fixes::None, ..CAPTIVE });
    assert_eq!(rig.run(60.0, Now { fixes: Fixes::None, ..TORN }), None);
    assert_eq!((rig.state(), rig.detector.wire()), (LaunchState::Captive, WireCondition::Broken));
}

/// A second after a start nothing is known that a change could be told from. In flight, with the traces of a
/// mission, its supply has dipped, and the release comes as it would have; otherwise somebody is making the
/// vehicle ready, or tears the cable.
#[test]
fn a_release_soon_after_a_dip_of_the_supply_in_flight_is_seen() {
    let after = |has_traces, ground_speed_mps, captive_s, now: Now| {
        let mut rig = Rig { ground_speed_mps, ..Rig::new() };
        if has_traces {
            rig.detector = rig.detector.after_traces();
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
    rig.detector = rig.detector.after_interruption();
    rig.run(0.2, Now { fixes: Fixes::None, ..CAPTIVE });
    let launch = rig.run(5.0, Now { fixes: Fixes::None, ..TORN });
    assert_eq!(launch.map(|launch| launch.by), Some(Confirmation::Unconfirmed));
    // What is watched from before the edge on and feels nothing is a cable that is torn.
    for captive_s in [0.5, 1.5, 4.0] {
        assert_eq!(after(true, 40.0, captive_s, TORN), None);
    }
}

/// Nothing but a departure can show in the first seconds, so the wire is broken once that is out of the
/// question: the next dip of the supply is to find it called so.
#[test]
fn a_wire_that_breaks_soon_after_a_dip_is_called_broken_at_once() {
    let mut rig = Rig::new();
    rig.detector = rig.detector.after_traces();
    rig.run(0.4, CAPTIVE);
    assert_eq!(rig.run(0.24, TORN), None);
    assert_eq!(rig.detector.wire(), WireCondition::Open);
    assert_eq!(rig.run(0.02, TORN), None);
    assert_eq!((rig.state(), rig.detector.wire()), (LaunchState::Captive, WireCondition::Broken));
    // It was a release after all: it falls.
    assert!(rig.run(3.0, RELEASED).is_some());
}

/// A unit that reads no force for five seconds, under the pylon, must not widen what a departure and a change
/// are held against.
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
/// has not seen that nothing changed, however well it is afterwards.
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

/// The wire is shorted for 0.9 s soon after it has opened: the departure about its first opening counts at the
/// next one. After a longer rest it does not.
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

/// One wild sample in captive flight must not hide for ten seconds, in what it does to the spread, how the
/// roughness changes at a release.
#[test]
fn one_wild_sample_hides_no_release() {
    let mut rig = Rig::captive();
    rig.step(Now { load: Some(-15.0), ..CAPTIVE });
    assert_eq!(rig.run(2.0, CAPTIVE), None);
    let launch = rig.run(2.0, Now { vibration: 1.0, ..TORN }).unwrap();
    assert_eq!(launch.by, Confirmation::Silence);
}

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

/// Messages that go on are the mother ship's: whatever the force does in the moment in which the wire breaks.
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
    // A gust alone is none.
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
fn a_broken_wire_can_be_whole_again() {
    let mut rig = Rig::captive();
    assert_eq!(rig.run(4.0, OPEN), None);
    assert_eq!(rig.run(0.015, CAPTIVE), None);
    assert_eq!(rig.detector.wire(), WireCondition::Broken);
    assert_eq!(rig.run(1.0, CAPTIVE), None);
    assert_eq!((rig.detector.wire(), rig.detector.counts().mended_wires), (WireCondition::Closed, 1));
    assert_eq!(rig.run(2.0, RELEASED).map(|launch| launch.by), Some(Confirmation::Force));
}

/// A broken wire, and then the messages end: a launch if anything else changes or nobody can say, and else
/// two faults.
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
    // Both: said after the fall's least time. The vehicle may then pull out.
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

/// A wire that reads closed, or cannot be read, and no messages: the accelerometer's fall has to be the climb
/// rate's.
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
        // A dead accelerometer, for as long as it likes.
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

/// An accelerometer that reads nothing does not fall.
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
    // With both, and messages that had died under the pylon long before: a wire that breaks is none, a
    // release is.
    for (now, by) in [(TORN, None), (RELEASED, Some(Confirmation::Force))] {
        let mut rig = Rig::captive();
        assert_eq!(rig.run(10.0, Now { is_sending: false, ..CAPTIVE }), None);
        assert_eq!(rig.run(10.0, now).map(|launch| launch.by), by);
    }
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
    // Messages that end do not make a launch of it, nor does a gust.
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

/// In air so rough that 0.3 g comes every second, a wire that breaks is not taken for a release, and a
/// release is.
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
    // At 4 sigmas one in 1,600 for each break; of 200, four or more are as good as impossible. A release is a
    // step of 0.9 g, six sigmas of 0.15 g.
    assert!(false_launches <= 3, "{false_launches}");
    assert!(felt >= 195, "{felt}");
}

#[test]
fn what_comes_after_a_launch_is_counted_and_changes_nothing() {
    let mut rig = Rig::captive();
    let launch = rig.run(2.0, RELEASED).unwrap();
    for now in [CAPTIVE, OPEN, CAPTIVE] {
        rig.run(1.0, now);
        assert_eq!(rig.state(), LaunchState::Launched(launch));
    }
    for _ in 0..200 {
        rig.step(CAPTIVE);
    }
    let counts = rig.detector.counts();
    assert!(counts.messages_after_launch >= 50 && counts.closures_after_launch == 2, "{counts:?}");
}

/// 0.7 s of ticks whose times were there before, while the vehicle leaves: the departure is in them. And back
/// to the start.
#[test]
fn a_clock_that_runs_back_hides_no_launch_and_makes_none() {
    for back_us in [0.7e6 as u64, 10_000_000] {
        let mut rig = Rig::captive();
        rig.leapt_us = rig.leapt_us.wrapping_sub(back_us);
        let launch = rig.run(2.0, RELEASED).unwrap();
        let usual = Rig::captive().run(2.0, RELEASED).unwrap();
        assert_eq!(launch.by, Confirmation::Force, "{back_us}");
        let waited_us = |launch: Launch| launch.confirmed_us - launch.first_edge_us;
        assert_eq!(waited_us(launch), waited_us(usual), "{back_us}: {launch:?}");
        assert_eq!(rig.detector.counts().out_of_order, 1);

        let mut rig = Rig::captive();
        rig.run(1.0, OPEN);
        rig.leapt_us = rig.leapt_us.wrapping_sub(back_us);
        assert_eq!(rig.run(20.0, OPEN), None, "{back_us}: a broken wire");
        assert_eq!(rig.detector.wire(), WireCondition::Broken);
    }
}

#[test]
fn a_time_that_is_repeated_is_a_tick_and_counted() {
    let mut rig = Rig::captive();
    for k in 1..=3 {
        let input = LaunchInput { time_us: rig.now_us(), is_open: Some(false), ..LaunchInput::default() };
        assert_eq!(rig.detector.tick(&input), LaunchState::Captive);
        assert_eq!(rig.detector.counts().out_of_order, k);
    }
}

#[test]
fn messages_of_another_time_are_refused() {
    let mut rig = Rig::captive();
    // Messages from the future, and from before the last.
    for last_message_us in [rig.now_us() + 1_000_000, 0] {
        rig.last_message_us = Some(last_message_us);
        rig.step(Now { is_sending: false, ..CAPTIVE });
    }
    assert_eq!(rig.detector.counts().messages_refused, 2);
}

#[test]
fn limits_that_are_none_are_refused() {
    for config in [
        LaunchConfig { debounce_s: 0.0, ..CONFIG },
        LaunchConfig { window_s: f32::NAN, ..CONFIG },
        LaunchConfig { departure: 1.0, ..CONFIG },
        LaunchConfig { debounce_s: 4.0, ..CONFIG },
        LaunchConfig { fall_s: 3.0, ..CONFIG },
        LaunchConfig { silent_intervals: 0, ..CONFIG },
        LaunchConfig { undecided_s: f32::INFINITY, ..CONFIG },
    ] {
        assert_eq!(LaunchDetector::new(config).err(), Some(ConfigError::OutOfRange), "{config:?}");
    }
}

/// A stretch of flight: ticks, wire, load factor, whether messages are sent.
fn stretches() -> impl Strategy<Value = Vec<(u64, Option<bool>, Option<f32>, bool)>> {
    let wire = prop_oneof![3 => Just(Some(true)), 3 => Just(Some(false)), 1 => Just(None)];
    let load = prop_oneof![3 => Just(Some(1.0f32)), 2 => (0.0f32..3.0).prop_map(Some), 1 => Just(None)];
    proptest::collection::vec((1u64..1_000, wire, load, any::<bool>()), 1..12)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    /// Under the pylon, with messages: neither any wire with a captive force nor any force with a closed
    /// wire.
    #[test]
    fn nothing_launches_what_is_captive(stretches in stretches(), by_wire in any::<bool>(), seed in any::<u32>()) {
        let mut rig = Rig::captive();
        rig.seed = seed;
        for (ticks, is_open, load, _) in stretches {
            let now = if by_wire { Now { is_open, ..CAPTIVE } } else { Now { load, ..CAPTIVE } };
            for _ in 0..ticks {
                let state = rig.step(now);
                prop_assert!(!state.is_launched(), "{state:?}");
            }
        }
        rig.run(10.0, CAPTIVE);
        prop_assert_eq!(rig.state(), LaunchState::Captive);
    }

    /// Without a receiver an open wire and no more messages are a launch in bounded time, where there is no
    /// accelerometer, whatever the wire was before; or where it feels the release, and neither wire nor force
    /// were odd before. It is dated to where the suspicion, and with it the hold of the calibration, began.
    #[test]
    fn no_launch_is_refused(stretches in stretches(), load in proptest::option::of(0.0f32..0.5), seed in any::<u32>()) {
        let mut rig = Rig::captive();
        rig.seed = seed;
        let mut since = None;
        let last = (4_000, Some(true), load, false);
        let before = stretches.into_iter().map(|stretch| match (stretch, load) {
            ((ticks, _, _, is_sending), Some(_)) => (ticks, Some(false), Some(1.0), is_sending),
            ((ticks, is_open, _, is_sending), None) => (ticks, is_open, None, is_sending),
        });
        for (ticks, is_open, load, is_sending) in before.chain([last]) {
            for _ in 0..ticks {
                let was_launched = rig.state().is_launched();
                match rig.step(Now { is_open, load, is_sending, fixes: Fixes::None, ..CAPTIVE }) {
                    LaunchState::Captive => since = None,
                    LaunchState::Suspected { since_us } => {
                        prop_assert_eq!(*since.get_or_insert(rig.now_us()), since_us);
                    }
                    LaunchState::Launched(launch) if !was_launched => {
                        prop_assert_eq!(launch.first_edge_us, since.unwrap_or(rig.now_us()));
                        prop_assert_eq!(launch.confirmed_us, rig.now_us());
                    }
                    LaunchState::Launched(_) => {}
                }
            }
        }
        prop_assert!(rig.state().is_launched(), "{:?} {:?}", rig.state(), rig.detector.wire());
    }
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
