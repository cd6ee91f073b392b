//! Every row of the decision table, on made-up wires, forces and messages: the rig, and what holds for all
//! rows.

use proptest::prelude::*;

use super::*;
use crate::input::LaunchDoubt;

mod clock;
mod open_wire;
mod without_wire;

const TICK_US: u64 = 5_000;
const G: f32 = 9.806_65;
const CONFIG: LaunchConfig = LaunchConfig::DEFAULT;

/// The climb rate of the fixes.
#[derive(Clone, Copy, PartialEq)]
enum Fixes {
    None,
    /// Constant, whatever the accelerometer reads.
    Level,
    /// The load factor's integral.
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
    /// How far the clock has leapt forward.
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
/// Released: open, own lift of 0.4 g, no messages.
const RELEASED: Now = Now { is_open: Some(true), load: Some(0.4), is_sending: false, ..CAPTIVE };
/// The cable is torn under the pylon, or a release that nothing on board feels.
const TORN: Now = Now { is_open: Some(true), is_sending: false, ..CAPTIVE };

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

    /// Without a receiver, an open wire and silent messages are a launch in bounded time: without an
    /// accelerometer, whatever the wire was before; with one, if it feels the release and neither wire nor
    /// force was odd before. It is dated to the start of the suspicion, when the calibration was held.
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
