//! Every row of the decision table, on made-up wires, forces and messages.

use proptest::prelude::*;

use super::*;

const TICK_US: u64 = 5_000;
const G: f32 = 9.806_65;
const CONFIG: LaunchConfig = LaunchConfig::DEFAULT;

/// A tick's wire, load factor and whether the mother ship's messages are sent.
#[derive(Clone, Copy)]
struct Now {
    is_open: Option<bool>,
    load: Option<f32>,
    is_sending: bool,
}

const CAPTIVE: Now = Now { is_open: Some(false), load: Some(1.0), is_sending: true };

struct Rig {
    detector: LaunchDetector,
    tick: u64,
    last_message_us: Option<u64>,
    message_ticks: u64,
    seed: u32,
    /// Standard deviation of the load factor by gusts, g, and its value now.
    gust_sigma: f32,
    gust: f32,
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
        self.tick * TICK_US
    }

    fn step(&mut self, now: Now) -> LaunchState {
        self.tick += 1;
        if now.is_sending && self.tick.is_multiple_of(self.message_ticks) {
            self.last_message_us = Some(self.now_us());
        }
        // Gusts of half a second.
        let fade = 0.01f32;
        self.gust += self.gust_sigma * (2.0 * fade).sqrt() * self.normal() - fade * self.gust;
        let noise = [0.3, 0.3, 0.3].map(|sigma| sigma * self.normal());
        let force_mps2 = now.load.map(|load| {
            [noise[0], noise[1], noise[2] - G * load - if load > 0.5 { G * self.gust } else { 0.0 }]
        });
        let time_us = self.now_us();
        self.detector.tick(&LaunchInput {
            time_us,
            is_open: now.is_open,
            force_mps2,
            last_message_us: self.last_message_us,
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
const RELEASED: Now = Now { is_open: Some(true), load: Some(0.4), is_sending: false };

#[test]
fn a_release_is_confirmed_by_force_as_soon_as_the_wire_is_debounced() {
    for before in [0.0, 0.05, 0.1, 0.2] {
        let mut rig = Rig::captive();
        rig.run(before, Now { is_open: Some(false), ..RELEASED });
        let edge_us = rig.now_us() + TICK_US;
        let launch = rig.run(1.0, RELEASED).unwrap();
        let LaunchState::Launched(stated) = rig.state() else { panic!() };
        assert_eq!(launch, stated);
        assert_eq!((launch.first_edge_us, launch.by), (edge_us, Confirmation::Force));
        // 20 ms of debounce; the force's smoothing of 30 ms needs 0.02 s to fall by 0.3 of 0.6 g.
        let took_us = launch.confirmed_us - edge_us;
        let latest_us = if before >= 0.05 { 20_000 } else { 35_000 };
        assert!((20_000..=latest_us).contains(&took_us), "{took_us} {before}");
    }
}

/// An ejector's push is a departure too, also where the vehicle then carries itself.
#[test]
fn an_ejector_is_felt() {
    let mut rig = Rig::captive();
    assert_eq!(rig.run(0.03, Now { load: Some(4.0), ..CAPTIVE }), None);
    let launch = rig.run(1.0, Now { load: Some(1.0), is_sending: true, ..OPEN }).unwrap();
    assert_eq!(launch.by, Confirmation::Force);
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
    assert_eq!(rig.run(1.0, RELEASED).map(|launch| launch.by), Some(Confirmation::Force));
}

/// The wire closes again after the debounce, before anything is decided.
#[test]
fn a_long_opening_that_closes_is_no_launch() {
    let mut rig = Rig::captive();
    assert_eq!(rig.run(1.0, OPEN), None);
    assert!(rig.suspected_for_s().is_some());
    assert_eq!(rig.run(1.0, CAPTIVE), None);
    assert_eq!((rig.state(), rig.detector.counts().reclosures), (LaunchState::Captive, 1));
}

#[test]
fn silence_confirms_a_release_that_can_not_be_felt() {
    for (load, message_ticks) in [(Some(1.0), 4), (Some(0.9), 20), (None, 20), (Some(1.0), 200)] {
        let mut rig = Rig::new();
        rig.message_ticks = message_ticks;
        rig.run(20.0, CAPTIVE);
        let edge_us = rig.now_us() + TICK_US;
        let launch = rig.run(20.0, Now { load, is_sending: false, ..OPEN }).unwrap();
        assert_eq!((launch.first_edge_us, launch.by), (edge_us, Confirmation::Silence));
        // Five intervals after the last message, which came up to one before the edge.
        let intervals = (launch.confirmed_us - edge_us) as f64 / (message_ticks * TICK_US) as f64;
        assert!((4.0..=5.5).contains(&intervals), "{intervals}");
    }
}

#[test]
fn a_broken_wire_is_found_and_a_later_launch_is_not_missed() {
    let mut rig = Rig::captive();
    assert_eq!(rig.run(2.9, OPEN), None);
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
    assert!(launch.first_edge_us - released_us <= 30_000, "{launch:?}");
    assert!((80_000..=105_000).contains(&(launch.confirmed_us - released_us)), "{launch:?} {released_us}");
}

#[test]
fn a_broken_wire_can_be_whole_again() {
    let mut rig = Rig::captive();
    assert_eq!(rig.run(4.0, OPEN), None);
    assert_eq!(rig.run(0.015, CAPTIVE), None);
    assert_eq!(rig.detector.wire(), WireCondition::Broken);
    assert_eq!(rig.run(1.0, CAPTIVE), None);
    assert_eq!((rig.detector.wire(), rig.detector.counts().mended_wires), (WireCondition::Closed, 1));
    assert_eq!(rig.run(1.0, RELEASED).map(|launch| launch.by), Some(Confirmation::Force));
}

/// Wire and messages both say so, and the force does not: a launch that can not be felt, or both have failed. It can not
/// be refused.
#[test]
fn silence_after_a_broken_wire_is_a_launch_without_confirmation() {
    let mut rig = Rig::captive();
    assert_eq!(rig.run(5.0, OPEN), None);
    let silent_us = rig.now_us();
    let launch = rig.run(10.0, Now { is_sending: false, ..OPEN }).unwrap();
    assert_eq!(launch.by, Confirmation::Unconfirmed);
    let suspected_us = launch.first_edge_us - silent_us;
    assert!((80_000..=105_000).contains(&suspected_us), "{suspected_us}");
    assert_eq!(launch.confirmed_us - launch.first_edge_us, 3_000_000);
}

#[test]
fn a_stuck_wire_needs_a_fall_and_silence() {
    let falling = Now { load: Some(0.05), ..CAPTIVE };
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

#[test]
fn without_wire_and_messages_only_a_long_fall_shows_a_launch() {
    for is_open in [Some(false), None] {
        let quiet = Now { is_open, load: Some(1.0), is_sending: false };
        let falling = Now { load: Some(0.1), ..quiet };
        let mut rig = Rig::new();
        assert_eq!(rig.run(10.0, quiet), None);
        assert_eq!(rig.run(1.8, falling), None);
        assert!(rig.suspected_for_s().is_some_and(|seconds| seconds > 1.5));
        assert_eq!(rig.run(10.0, quiet), None);
        assert_eq!((rig.state(), rig.detector.counts().false_alarms), (LaunchState::Captive, 1));
        let launch = rig.run(5.0, falling).unwrap();
        assert_eq!(launch.by, Confirmation::FreeFall);
        assert_eq!(launch.confirmed_us - launch.first_edge_us, 2_000_000);
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
        rig.detector.tick(&LaunchInput { time_us, is_open: Some(false), force_mps2, last_message_us: None });
        assert_eq!(rig.state(), LaunchState::Captive);
    }
    assert_eq!(rig.detector.counts().forces_refused, 1_999);
}

#[test]
fn the_wire_decides_where_nothing_else_can_say() {
    for load in [None, Some(1.0)] {
        let mut rig = Rig::new();
        let alone = Now { load, is_sending: false, ..CAPTIVE };
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
    // Messages that had died under the pylon, long before.
    let mut rig = Rig::captive();
    assert_eq!(rig.run(10.0, Now { is_sending: false, ..CAPTIVE }), None);
    let launch = rig.run(10.0, Now { is_sending: false, ..OPEN }).unwrap();
    assert_eq!(launch.by, Confirmation::Unconfirmed);
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
        rig.step(Now { is_open, is_sending: false, load: Some(1.0) });
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

/// In air so rough that 0.3 g comes every second, a wire that breaks is not taken for a release, and a release is.
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
                .run(1.0, Now { load: Some(0.1), ..RELEASED })
                .is_some_and(|launch| launch.by == Confirmation::Force),
        );
    }
    // At 4 sigmas one in 1,600 for each break; of 200, four or more are as good as impossible. A release is a step of
    // 0.9 g, six sigmas of 0.15 g.
    assert!(false_launches <= 3, "{false_launches}");
    assert!(felt >= 195, "{felt}");
}

#[test]
fn what_comes_after_a_launch_is_counted_and_changes_nothing() {
    let mut rig = Rig::captive();
    let launch = rig.run(1.0, RELEASED).unwrap();
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

#[test]
fn time_that_does_not_increase_is_ignored() {
    let mut rig = Rig::captive();
    let before = rig.detector.clone();
    for time_us in [rig.now_us(), 0] {
        let input = LaunchInput { time_us, is_open: Some(true), force_mps2: None, last_message_us: None };
        assert_eq!(rig.detector.tick(&input), LaunchState::Captive);
    }
    assert_eq!(rig.detector.counts().out_of_order, 2);
    assert_eq!(rig.detector.wire(), before.wire());
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

    /// Under the pylon, with messages: neither any wire with a captive force nor any force with a closed wire.
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

    /// Whatever was before: an open wire and no more messages are a launch, in bounded time; and it is dated to where the
    /// suspicion, and with it the hold of the calibration, began.
    #[test]
    fn no_launch_is_refused(stretches in stretches(), load in proptest::option::of(0.0f32..2.0), seed in any::<u32>()) {
        let mut rig = Rig::captive();
        rig.seed = seed;
        let mut since = None;
        let last = (2_000, Some(true), load, false);
        for (ticks, is_open, load, is_sending) in stretches.into_iter().chain([last]) {
            for _ in 0..ticks {
                let was_launched = rig.state().is_launched();
                match rig.step(Now { is_open, load, is_sending }) {
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
