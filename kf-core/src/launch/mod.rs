//! Launch: when the UAV left its mother ship, by the umbilical's break-wire, the mother ship's messages, the
//! force on the vehicle and its climb rate.
//!
//! None of them is proof. A wire bounces, breaks under the pylon and shorts; a data link dies by itself; a
//! cable that tears takes both at once; a gust or a fault moves the accelerometer. What each one shows, by
//! physics:
//!
//! - Wire: parts once the vehicle has moved by the connector's travel and the cable's slack, up to a quarter
//!   of a second after the hooks open (0.3 m of fall). Contacts that part bounce for milliseconds.
//! - Messages: come through the same umbilical, so one that arrives later than the cable's slack allows
//!   proves that the vehicle is still there, whatever else is read. Silence is no more than a hint.
//! - Force: under the pylon the vehicle has the mother ship's load factor and vibration. Free, it has those
//!   of its own wings and engine, and an ejector's push for some ten milliseconds. A share L/W of its weight
//!   carried by its own wings makes a step of 1 - L/W; without a step the mean on some axis or the roughness
//!   still changes, for thrust, drag and vibration are others (`character.rs`).
//! - Climb rate: near free fall takes 7 m/s a second off it. It is the receiver's, so it and the
//!   accelerometer do not fail together.
//!
//! # Decisions
//! `e`: first opening edge. "Departs": the force leaves its captive mean within [`LaunchConfig::window_s`] of
//! `e`, before or after. "Changes": since the suspicion began, the force's character, or the climb rate has
//! fallen by 5 m/s (`climb.rs`). "Known": the accelerometer delivers, and has since before `e`, so that a
//! change would have been seen. "Silent": for longer than [`LaunchConfig::silent_intervals`] of their own
//! intervals (of fewer than three messages: than [`LaunchConfig::undecided_s`]). "Alive": not silent yet at
//! `e`. "Limit": [`LaunchConfig::undecided_s`] after `e`.
//!
//! | wire | messages | force and climb rate | verdict |
//! |---|---|---|---|
//! | open, shorter than the debounce | any | any | suspected from `e`; closed again: captive, a bounce |
//! | open | one later than `e` and the window | any | `broken wire`, captive |
//! | open | were alive, not yet silent | any | suspected until silent, at most until the limit |
//! | open | were alive, now silent | departs and changes | launched, [`Confirmation::Force`] |
//! | open | were alive, now silent | changes | launched, [`Confirmation::Silence`] |
//! | open | none at `e` | departs and changes | launched, [`Confirmation::Force`] |
//! | open | none at `e` | changes | launched, [`Confirmation::Unconfirmed`] |
//! | open | none, or silent | known, neither departs nor changes | suspected; at the limit `broken`, captive: a wire or a cable torn under the pylon |
//! | open within 10 s of a cold start | none, or silent | no change | suspected; at the limit `broken`, captive |
//! | open less than 5 s after the start | none, or silent | known, does not depart within the window | suspected; then `broken`, captive |
//! | open | none, or silent | departs without a change, or not known | suspected; at the limit launched, [`Confirmation::Unconfirmed`] |
//! | open | none, or silent | the unit has died, fixes go on | suspected; from the limit on launched, [`Confirmation::Unconfirmed`], once the climb rate is another (by 2 m/s in the first six seconds, by 4 m/s later), or a minute has passed |
//! | open | none, or silent | the unit delivers, but not within the window of `e`, fixes go on | the same; after a minute `broken`, captive |
//! | open | none, or silent | low, but not since within the window of `e`, and the fixes' climb rate has not fallen | as with a unit that has died; if it ends, as with one that did not deliver |
//! | broken or unreadable | silent from the departure on | departs | launched, [`Confirmation::ForceAndSilence`] |
//! | broken | fall silent | changes | launched, [`Confirmation::ForceAndSilence`] |
//! | broken | fall silent | known, no change | suspected; at the limit captive |
//! | broken | fall silent | not known | suspected; at the limit launched, [`Confirmation::Unconfirmed`] |
//! | broken or unreadable | none | departs, and the climb rate falls by 5 m/s within the limit | launched, [`Confirmation::Unconfirmed`] |
//! | any but open | none | near free fall for [`LaunchConfig::fall_s`], and the climb rate falls so too | launched, [`Confirmation::FreeFall`] |
//! | broken or unreadable | none | near free fall for [`LaunchConfig::long_fall_s`], no fixes | launched, [`Confirmation::FreeFall`] |
//! | closed | silent from then on | near free fall for [`LaunchConfig::fall_s`] | launched, [`Confirmation::StuckWire`] |
//! | any but open | any | any other | captive |
//!
//! A wire that reads closed for less than a second is not yet closed again: if it reopens, a departure about
//! its first opening still counts.
//!
//! A start that continues a suspicion ([`LaunchDetector::resume_suspected`]) is not captive before the window
//! has passed. If the wire had been open for the window, and the force had not departed, the start knows so,
//! and what the force was like under the pylon ([`LaunchDetector::captive_force`]). The wire then counts as
//! opened at the first tick without a departure, and the force as known. Otherwise the force is not known,
//! and a release is the likelier explanation: it may cause a dip of the supply, and a torn cable seldom does.
//!
//! A wire is unreadable after [`LaunchConfig::undecided_s`] without a reading. A broken wire that reads
//! closed for the debounce time is whole again. A wire that opens five times, each within a second of the
//! last, is a loose contact: broken until it has been at rest for a second. If it rests closed it is whole
//! again; if it rests open, it counts as opened when it last did. A wire that is open at the first tick
//! counts as opened there. A launch is final.
//!
//! In the first ten seconds there is no captive flight to compare with, and no calibration that a launch
//! would latch. A wire that opens then without a change is broken: otherwise a cable torn at power-on would
//! be a launch. There are two exceptions. After an interruption ([`LaunchDetector::resume_captive`]) the
//! vehicle may have been released meanwhile, unless the wire was broken before
//! ([`LaunchDetector::call_wire_broken`]). A start that finds the traces of a mission
//! ([`LaunchDetector::note_traces`]) and moves over ground at 10 m/s was a dip of the supply in flight, and
//! the release may be a second away.
//!
//! In the first five seconds there is no captive mean: the force departs from one g, and nothing else can
//! show a release, so the opening is decided once the window has passed. Waiting for the limit would leave
//! the wire undecided at the next dip of the supply, and a start with an open wire that was not found broken
//! counts as released.
//!
//! # One fault is no launch
//! - Wire broken, bouncing, unreadable: the messages continue. Without messages, force and climb rate are
//!   known and do not change.
//! - Messages that stop, or come from a stranger: the wire is closed, and holds.
//! - Accelerometer dead at zero, stuck or wild: while the wire is closed, only together with the climb rate
//!   or with silent messages is it a launch.
//! - The whole cable torn: wire and messages fail together, so they are one witness. Force and climb rate are
//!   the other. Nothing else on board can decide: the mother ship's motion after the tear is not known.
//!
//! A release that changes neither mean, roughness nor climb rate in 3 s cannot be distinguished from a torn
//! cable. Such a vehicle is still within 2 m of the pylon (below the 0.06 g that shows in still air), and its
//! launch is then seen, unconfirmed, when it first falls. If both the cable and the accelerometer have
//! failed, the receiver's climb rate decides: a vehicle that leaves with less than three quarters of its
//! weight on its wings has lost 2 m/s at the limit. One that carries itself is seen when it first climbs or
//! sinks otherwise than under the pylon, after a minute at the latest; until then nothing is calibrated and
//! no sensor is reported as monitored. If the accelerometer delivers again and force and climb rate are those
//! of captive flight for that minute, the cable has torn: a vehicle is steered sooner. Without a receiver, or
//! without an inertial unit from the start, a release is the likelier explanation, because every flight has
//! one: it is a launch, and `launch_confirmed` fails.
//!
//! A wire that is shorted closed, or cannot be read, hides a release that is no fall: the state then stays
//! captive, and no sensor is reported as monitored. If silence and a change were a launch there, a data link
//! that dies during a manoeuvre would be one.
//!
//! # What calibration sees
//! No calibration data is taken from the first tick of a suspicion on ([`LaunchState::doubt`]), so the time
//! that a verdict takes changes no latched bias. Where the first sign of a launch is not the wire (broken,
//! closed or unreadable) the suspicion starts with the departure or the fall, some 30 ms of smoothing after
//! the release; with a broken wire and no departure it starts only when the silence is noticed.
//!
//! # False alarms and misses
//! A vertical gust `w` changes the mother ship's load factor by `rho V a w / (2 W/S)` (Pratt's sharp-edged
//! gust, NACA Report 1206, 1954): at 1 m/s, 0.2 g for a transport (100 m/s, 2,500 N/m^2, a = 5/rad: 0.11 g),
//! 0.5 g for a light carrier (28 m/s, 150 N/m^2). So no fixed threshold tells gusts from releases for both:
//! the force departs when it is both [`LaunchConfig::departure`] and [`LaunchConfig::departure_sigmas`]
//! captive standard deviations away, and its character has changed when two blocks in a row are six away.
//! - False alarm: a cable must tear within 3 s of a manoeuvre or of a change of the mother ship's engine. Of
//!   1,500 tears at random in five simulated captive flights in turbulence (0.8 and 0.5 m/s) none was a
//!   launch; no block was beyond 4.4 of the 6 deviations.
//! - Miss: none of eight such flights with an engine of 0.8 m/s^2, whose release is no step; it was seen 0.5
//!   to 1.5 s after the edge. With neither step, engine nor vibration it is the case above.
//! - Near free fall (below [`LaunchConfig::fall_load`] g) for 2 s takes 14 m/s off the climb rate: no carrier
//!   pushes over so with a vehicle under it.

mod captive_force;
mod character;
mod climb;
mod clock;
mod config;
mod force;
mod link;
mod open_wire;
mod state;
#[cfg(test)]
mod tests;
mod wire;
mod without_wire;

pub use captive_force::{CAPTIVE_FORCE_WORDS, CaptiveForce};
pub use config::LaunchConfig;
pub use state::{Confirmation, Launch, LaunchCounts, LaunchState, WireCondition};

use crate::estimator::ConfigError;
use crate::time::{microseconds, seconds_between};
use character::Character;
use climb::Climb;
use clock::Clock;
use force::Force;
use link::Link;
use wire::{Reading, Wire};
use without_wire::Sign;

/// Inputs of one tick.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LaunchInput {
    /// Time of the tick, microseconds. One that leaps, runs back or stands still is taken for the next tick.
    pub time_us: u64,
    /// Whether the umbilical's discrete reads open; `None`: it could not be read.
    pub is_open: Option<bool>,
    /// Specific force, body axes, m/s^2, if there is a new sample.
    pub force_mps2: Option<[f32; 3]>,
    /// When the last message of the mother ship came, microseconds, by the ticks' clock; `None`: none ever.
    pub last_message_us: Option<u64>,
    /// Climb rate of a fix, upward, m/s, if there is a new one that has it.
    pub climb_mps: Option<f32>,
    /// Square of a fix's speed over ground, (m/s)^2, if there is a new one that has it.
    pub ground_speed_squared_m2ps2: Option<f32>,
}

/// Decides when the vehicle has left; see the module.
#[derive(Clone, Debug)]
pub struct LaunchDetector {
    config: LaunchConfig,
    state: LaunchState,
    /// The first tick's time.
    first_us: Option<u64>,
    /// There was a mission before this start. If the vehicle turns out to be in flight, it was an
    /// interruption.
    had_mission: bool,
    /// The start was an interruption.
    was_interrupted: bool,
    /// The start continued a suspicion.
    continues_suspicion: bool,
    /// The opening of the wire about which the force has not departed: when it was, microseconds. If it was
    /// before the start, it counts as having opened at the first tick.
    unmoved_us: Option<u64>,
    /// The force has departed about this opening of the wire. What it does later does not undo that.
    has_departed: bool,
    clock: Clock,
    wire: Wire,
    force: Force,
    character: Character,
    climb: Climb,
    link: Link,
    sign: Option<Sign>,
    /// The last message before a silence that was no launch.
    refuted_silence_us: Option<u64>,
    /// Start of a fall that the climb rate has not confirmed.
    refuted_fall_us: Option<u64>,
    counts: LaunchCounts,
}

/// The force's character is known after 5 s of captive flight (`character.rs`); the inertial unit and the
/// receiver take some seconds until they deliver.
const EARLY_US: u64 = 10_000_000;
/// Ground speed from which the vehicle is in flight, squared: (10 m/s)^2. Nothing taxies as fast with a loose
/// cable, and nothing flies as slowly.
const UNDER_WAY_M2PS2: f32 = 100.0;

/// The verdict of a tick, before it gets its time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Verdict {
    Captive,
    Suspected,
    Launched(Confirmation),
}

pub(crate) fn count(counter: &mut u32) {
    *counter = counter.saturating_add(1);
}

impl LaunchDetector {
    /// A detector without history, under the mother ship.
    ///
    /// # Errors
    /// [`ConfigError::OutOfRange`]: a limit is not positive and finite, or the fall's are not in order.
    pub fn new(config: LaunchConfig) -> Result<Self, ConfigError> {
        let LaunchConfig { debounce_s, window_s, departure, departure_sigmas, undecided_s, .. } = config;
        let LaunchConfig { fall_load, fall_s, long_fall_s, silent_intervals, .. } = config;
        let limits =
            [debounce_s, window_s, departure, departure_sigmas, undecided_s, fall_load, fall_s, long_fall_s];
        let is_valid = limits.into_iter().all(|limit| limit > 0.0 && limit <= 3_600.0)
            && departure < 1.0
            && fall_load < 1.0
            && debounce_s < undecided_s
            && fall_s <= long_fall_s
            && silent_intervals > 0;
        if !is_valid {
            return Err(ConfigError::OutOfRange);
        }
        Ok(Self {
            config,
            state: LaunchState::Captive,
            first_us: None,
            had_mission: false,
            was_interrupted: false,
            continues_suspicion: false,
            unmoved_us: None,
            clock: Clock::default(),
            wire: Wire::default(),
            force: Force::default(),
            character: Character::default(),
            climb: Climb::default(),
            link: Link::default(),
            sign: None,
            has_departed: false,
            refuted_silence_us: None,
            refuted_fall_us: None,
            counts: LaunchCounts::default(),
        })
    }

    /// After a restart that has interrupted a flight: an open wire may have opened meanwhile.
    pub const fn resume_captive(&mut self) {
        self.was_interrupted = true;
    }

    /// As [`Self::resume_captive`], while a launch was suspected. The suspicion lasts for at least the
    /// cable's slack: what raised it, a fall or a contact that bounces, may show itself again only then.
    /// `before`: the last [`Self::captive_force`], if there was one.
    pub const fn resume_suspected(&mut self, before: Option<CaptiveForce>) {
        self.was_interrupted = true;
        self.continues_suspicion = true;
        if let Some(before) = before {
            self.resume_unmoved(before);
        }
    }

    /// After a start that was a cold one, because the wire is closed, but has found the traces of a mission:
    /// yesterday's, or one whose supply has dipped. Moving over ground tells which.
    pub const fn note_traces(&mut self) {
        self.had_mission = true;
    }

    /// After a restart before which the wire was found broken. It becomes whole again like any broken wire.
    pub fn call_wire_broken(&mut self) {
        self.wire.call_broken();
    }

    /// The verdict after the last tick.
    #[must_use]
    pub const fn state(&self) -> LaunchState {
        self.state
    }

    /// The wire's condition.
    #[must_use]
    pub const fn wire(&self) -> WireCondition {
        self.wire.condition()
    }

    /// The counters.
    #[must_use]
    pub const fn counts(&self) -> &LaunchCounts {
        &self.counts
    }

    /// Decides on the inputs of one tick.
    pub fn tick(&mut self, input: &LaunchInput) -> LaunchState {
        let (input, leap_us) = &self.clock.without_leaps(input);
        if *leap_us < 0 {
            count(&mut self.counts.out_of_order);
        }
        if let LaunchState::Suspected { since_us } = &mut self.state {
            *since_us = since_us.saturating_add_signed(*leap_us);
        }
        let now_us = input.time_us;
        if let (None, Some(unmoved_us)) = (self.first_us, &mut self.unmoved_us) {
            *unmoved_us = now_us;
            self.character.assume_living(now_us);
        }
        let first_us = *self.first_us.get_or_insert(now_us);
        // No speed of an aircraft overflows when squared; NaN is not fast.
        let is_under_way = input.ground_speed_squared_m2ps2.is_some_and(|squared| squared >= UNDER_WAY_M2PS2);
        self.was_interrupted |= self.had_mission && is_under_way;
        let has_message = self.link.take(input, &self.config, &mut self.counts);
        if self.state.is_launched() {
            if has_message {
                count(&mut self.counts.messages_after_launch);
            }
            if self.wire.closes(input.is_open) {
                count(&mut self.counts.closures_after_launch);
            }
            return self.state;
        }
        self.wire.take(input, &self.config, &mut self.counts);
        let is_captive = self.state == LaunchState::Captive;
        if let Some(force_mps2) = self.force.take(input, is_captive, &self.config, &mut self.counts) {
            // What the force is like while the wire bounces may already be free flight.
            let is_usual = is_captive && self.force.falling_since_us().is_none() && !self.wire.is_restless();
            self.character.take(now_us, force_mps2, is_usual);
        }
        if let Some(climb_mps) = input.climb_mps {
            self.climb.take(now_us, climb_mps, is_captive);
        }
        let verdict = match self.wire.reading() {
            Reading::Open { edge_us, is_settled } => {
                self.sign = None;
                let since_start_us = edge_us.saturating_sub(first_us);
                let is_early = !self.was_interrupted && since_start_us < EARLY_US;
                self.judge_open(now_us, edge_us, is_settled, is_early)
            }
            Reading::Closed => self.judge_without(now_us, false),
            Reading::Nothing => self.judge_without(now_us, true),
        };
        let clock_us = self.clock.told_us(now_us);
        let since_us = match self.state {
            LaunchState::Suspected { since_us } => since_us,
            LaunchState::Captive | LaunchState::Launched(_) => clock_us,
        };
        self.state = match verdict {
            Verdict::Captive
                if self.continues_suspicion && !Self::has_lasted(first_us, now_us, self.config.window_s) =>
            {
                LaunchState::Suspected { since_us }
            }
            Verdict::Captive => LaunchState::Captive,
            Verdict::Suspected => LaunchState::Suspected { since_us },
            Verdict::Launched(by) => {
                LaunchState::Launched(Launch { first_edge_us: since_us, confirmed_us: clock_us, by })
            }
        };
        self.state
    }

    #[inline(never)]
    fn has_lasted(since_us: u64, now_us: u64, limit_s: f32) -> bool {
        now_us.saturating_sub(since_us) >= microseconds(limit_s)
    }

    /// Whether a message came so long after a sign of launch that the umbilical must still be connected.
    #[inline(never)]
    fn is_attached_after(&self, sign_us: u64) -> bool {
        self.link
            .last_us()
            .is_some_and(|last_us| last_us > sign_us.saturating_add(microseconds(self.config.window_s)))
    }

    /// Whether the vehicle's motion or vibration has changed since the suspicion began.
    fn has_changed(&self, since_us: u64) -> bool {
        self.character.has_changed() || self.climb.has_fallen(since_us)
    }
}

/// Seconds between two samples; `None` for the first.
fn step_s(last_us: Option<u64>, now_us: u64) -> Option<f32> {
    last_us.map(|last_us| seconds_between(last_us, now_us))
}
