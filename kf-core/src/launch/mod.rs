//! Launch: when the UAV left its mother ship, by the umbilical's break-wire, the mother ship's messages, the
//! force on the vehicle and its climb rate.
//!
//! None of them is proof. A wire bounces, breaks under the pylon and shorts; a data link dies by itself; a
//! cable that tears takes both at once; a gust or a fault moves the accelerometer. What each one says, from
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
//! | open | none, or silent | the unit has died, fixes go on | suspected; at the limit or later launched, [`Confirmation::Unconfirmed`], once the climb rate is another by 2 m/s, or a minute has passed |
//! | open | none, or silent | low since longer before `e` than the window, and the fixes' climb rate has not fallen | as with a unit that has died |
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
//! A wire that reads closed for less than a second has not closed: a departure about its first opening counts
//! at the next one.
//!
//! A wire counts as unreadable once it has not been read for the limit's time. A broken wire that reads
//! closed for the debounce time is whole again. One that opens five times, each within a second of the time
//! before, is a loose contact, and broken; it is whole again once it has read closed for a second. A
//! wire that is open at the first tick opened there. A launch is final.
//!
//! In the first ten seconds there is nothing that a change could be told from, and nothing calibrated that a
//! launch would latch: a wire that opens there without a change is broken, for else a cable torn at power-on
//! would be a launch. A start after an interruption is excepted ([`LaunchDetector::after_interruption`]): the
//! vehicle may have been released while it lasted; unless the wire was broken before it
//! ([`LaunchDetector::with_broken_wire`]). So is one that finds the traces of a mission
//! ([`LaunchDetector::after_traces`]) and moves over ground at 10 m/s: nobody has switched it on, its supply
//! has dipped, and the release may be a second away. In the first five seconds the force departs from one g,
//! there being no captive mean yet, and nothing else can show: once the window has passed the opening is
//! decided. To wait for the limit would be to leave the wire undecided for the next dip of the supply, and
//! who starts with an open wire that nobody has called broken has been released.
//!
//! # One fault is no launch
//! - Wire broken, bouncing, unreadable: her messages go on. Without any, force and climb rate are known and
//!   do not change.
//! - Messages that stop, or come from a stranger: the wire is closed, and holds.
//! - Accelerometer dead at zero, stuck or wild: with a closed wire it needs the climb rate or the messages'
//!   silence with it.
//! - The whole cable torn: wire and messages speak with one voice, and are one witness. Force and climb rate
//!   are the other. Nothing else on board can tell: the mother ship's motion after the tear is not known
//!   here.
//!
//! What cannot be told apart is a release that changes neither mean, roughness nor climb rate in 3 s, from a
//! torn cable. Such a vehicle hangs within 2 m of the pylon still (below the 0.06 g that shows in still air),
//! and its launch is then seen, unconfirmed, when it first falls. Of two faults, one of them the cable, and
//! the accelerometer gone with it, the receiver's climb rate decides: one who leaves with less than three
//! quarters of its weight on its wings has lost 2 m/s at the limit. One that carries itself is seen when it
//! first climbs or sinks otherwise than under the pylon, after a minute at the latest: nothing is
//! calibrated meanwhile, and no sensor is said to be watched. Without a receiver, or with no unit from the
//! start, a release is the likelier reading, for it is to happen in every flight: a launch, and
//! `launch_confirmed` fails.
//!
//! A wire that is shorted closed, or cannot be read, hides a release that is no fall: it is then captive for
//! ever, and no sensor is said to be watched. To call silence and a change a launch there would make one of a
//! data link that dies while its ship manoeuvres.
//!
//! # What calibration sees
//! From the first tick of a suspicion on no calibration data may be taken ([`LaunchState::doubt`]), so how
//! long a verdict takes changes no latched bias. Where the first sign of a launch is not the wire (broken,
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

mod character;
mod climb;
mod clock;
mod force;
mod link;
#[cfg(test)]
mod tests;
mod wire;

use crate::estimator::ConfigError;
use crate::guard::Guard;
use crate::input::LaunchDoubt;
use crate::time::{microseconds, seconds_between};
use character::Character;
use climb::Climb;
use clock::Clock;
use force::Force;
use link::Link;
use wire::{Reading, Wire};

/// Limits of the decision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LaunchConfig {
    /// How long the wire must read open without a closed reading between, seconds.
    pub debounce_s: f32,
    /// How far from the edge a departure of force, and how long after the first sign a last message, may lie,
    /// seconds.
    pub window_s: f32,
    /// Departure of the specific force's magnitude from its captive mean, as a share of that mean.
    pub departure: f32,
    /// The same in standard deviations of the captive magnitude, smoothed over 30 ms.
    pub departure_sigmas: f32,
    /// Messages are silent after so many of their own mean intervals.
    pub silent_intervals: u16,
    /// How long an open wire that nothing confirms, a wire that cannot be read, or a sign of the force that
    /// nothing confirms, is left undecided, seconds.
    pub undecided_s: f32,
    /// Specific force below which it is near free fall, g.
    pub fall_load: f32,
    /// Near free fall that, with silence or the climb rate, shows a launch, seconds.
    pub fall_s: f32,
    /// Near free fall that alone shows a launch, where no wire contradicts it, seconds.
    pub long_fall_s: f32,
}

impl LaunchConfig {
    /// From the module's physics. `undecided_s`: an engine must have been started, some blocks compared, and
    /// slow messages missed.
    pub const DEFAULT: Self = Self {
        debounce_s: 0.02,
        window_s: 0.25,
        departure: 0.3,
        departure_sigmas: 4.0,
        silent_intervals: 5,
        undecided_s: 3.0,
        fall_load: 0.3,
        fall_s: 0.3,
        long_fall_s: 2.0,
    };
}

/// What one tick brought.
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

/// What confirmed a launch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Confirmation {
    /// Open wire, the force departed from its captive mean, and is another one.
    Force,
    /// Open wire, the messages fell silent, and force or climb rate is another one.
    Silence,
    /// The wire was broken or could not be read: departure or change of force, and silence.
    ForceAndSilence,
    /// The wire is stuck closed: near free fall and silence.
    StuckWire,
    /// Near free fall by force and climb rate; without fixes, for long.
    FreeFall,
    /// Wire and messages alone, or the vehicle's motion alone, and nobody who could contradict them.
    Unconfirmed,
}

impl Confirmation {
    /// The name used in telemetry and reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Force => "force",
            Self::Silence => "silence",
            Self::ForceAndSilence => "force_and_silence",
            Self::StuckWire => "stuck_wire",
            Self::FreeFall => "free_fall",
            Self::Unconfirmed => "unconfirmed",
        }
    }
}

/// A launch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Launch {
    /// When the suspicion began: the first edge, or the first sign in the force or the messages;
    /// microseconds.
    pub first_edge_us: u64,
    /// When it was confirmed, microseconds.
    pub confirmed_us: u64,
    /// By what.
    pub by: Confirmation,
}

/// What is known after a tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LaunchState {
    /// Under the pylon: calibration data may be taken.
    Captive,
    /// Perhaps launched: no calibration data is taken, and the calibration held.
    Suspected {
        /// Since when, microseconds.
        since_us: u64,
    },
    /// Launched.
    Launched(Launch),
}

impl LaunchState {
    /// For [`crate::input::TickInput::launch`].
    #[must_use]
    pub const fn is_launched(self) -> bool {
        matches!(self, Self::Launched(_))
    }

    /// For [`crate::input::TickInput::launch_doubt`].
    #[must_use]
    pub const fn doubt(self) -> LaunchDoubt {
        match self {
            Self::Captive => LaunchDoubt::None,
            Self::Suspected { .. } => LaunchDoubt::Suspected,
            Self::Launched(launch) => match launch.by {
                Confirmation::Unconfirmed => LaunchDoubt::Unconfirmed,
                _ => LaunchDoubt::None,
            },
        }
    }
}

/// What the wire is taken for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WireCondition {
    /// It reads closed.
    Closed,
    /// It reads open, and nothing has contradicted it.
    Open,
    /// It reads open, and was found to be no launch: messages came all the same, or nothing else changed.
    Broken,
    /// It has not been read for longer than the time limit.
    Unreadable,
}

impl WireCondition {
    /// The name used in telemetry and reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Closed => "closed",
            Self::Open => "open",
            Self::Broken => "broken",
            Self::Unreadable => "unreadable",
        }
    }
}

/// What was counted. All saturate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LaunchCounts {
    /// Openings that were shorter than the debounce.
    pub bounces: u32,
    /// Openings that were longer, and closed again before anything was decided.
    pub reclosures: u32,
    /// Times that the wire was found broken.
    pub broken_wires: u32,
    /// Times that the wire opened and the messages were silent, or none, and the vehicle moved and shook as
    /// before.
    pub torn_cables: u32,
    /// Times that a broken wire was whole again.
    pub mended_wires: u32,
    /// Ticks at which the wire could not be read.
    pub unreadable: u32,
    /// Suspicions by force or silence that came to nothing.
    pub false_alarms: u32,
    /// Specific forces that are none: not finite, beyond any unit, or exactly zero on all axes (a dead one; a
    /// falling one has noise).
    pub forces_refused: u32,
    /// Silences under the pylon after which messages came again.
    pub link_losses: u32,
    /// Messages dated in the future or before the last one.
    pub messages_refused: u32,
    /// Ticks whose time was not after the last one's: each is taken for the next tick.
    pub out_of_order: u32,
    /// Messages that came after the launch was confirmed.
    pub messages_after_launch: u32,
    /// Times that the wire closed after the launch was confirmed.
    pub closures_after_launch: u32,
}

/// A sign of launch while the wire shows none.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Sign {
    Force { since_us: u64, has_lasted: bool },
    Silence { since_us: u64 },
}

/// Decides when the vehicle has left; see the module.
#[derive(Clone, Debug)]
pub struct LaunchDetector {
    config: LaunchConfig,
    state: LaunchState,
    /// The first tick's time.
    first_us: Option<u64>,
    /// There was a mission before this start: it is an interruption if it turns out to be in flight.
    had_mission: bool,
    /// The start was an interruption.
    was_interrupted: bool,
    /// The force has departed about this opening of the wire: whatever it does later does not undo that.
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
    /// Begin of a fall that the climb rate has not shown.
    refuted_fall_us: Option<u64>,
    counts: LaunchCounts,
}

/// The force's character is known after 5 s of captive flight (`character.rs`); the inertial unit and the
/// receiver take some seconds until they deliver.
const EARLY_US: u64 = 10_000_000;
/// Who moves over ground as fast as this, squared, is not being made ready: (10 m/s)^2, faster than anybody
/// taxies with a loose cable, slower than anything flies.
const UNDER_WAY_M2PS2: f32 = 100.0;

/// How long the wire may stay open, with a dead inertial unit and an unchanged climb rate, before that is a
/// launch, seconds. A torn cable under a unit that stays dead for longer becomes a false launch, of two
/// faults; a release that nothing else shows is unseen for as long, by a single one. A vehicle is steered
/// within a minute of its release, and most faults that last for a minute are seen by the carrier's crew.
const UNSHOWN_S: f32 = 60.0;

/// What a tick comes to, before it is dated.
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
    /// A detector that has seen nothing, on the mother ship.
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

    /// After a restart that has interrupted a flight: a wire that is open may have opened in it.
    #[must_use]
    pub const fn after_interruption(self) -> Self {
        Self { was_interrupted: true, ..self }
    }

    /// After a start that was a cold one, because the wire is closed, but has found the traces of a mission:
    /// yesterday's, or one whose supply has dipped. Moving over ground tells which.
    #[must_use]
    pub const fn after_traces(self) -> Self {
        Self { had_mission: true, ..self }
    }

    /// After a restart of one that had found the wire broken. It is whole again as any broken wire is.
    #[must_use]
    pub fn with_broken_wire(mut self) -> Self {
        self.wire.call_broken();
        self
    }

    /// As it was after the last tick.
    #[must_use]
    pub const fn state(&self) -> LaunchState {
        self.state
    }

    /// What the wire is taken for.
    #[must_use]
    pub const fn wire(&self) -> WireCondition {
        self.wire.condition()
    }

    /// What was counted.
    #[must_use]
    pub const fn counts(&self) -> &LaunchCounts {
        &self.counts
    }

    /// Takes everything that is new at one tick.
    pub fn tick(&mut self, input: &LaunchInput) -> LaunchState {
        let (input, leap_us) = &self.clock.without_leaps(input);
        if *leap_us < 0 {
            count(&mut self.counts.out_of_order);
        }
        if let LaunchState::Suspected { since_us } = &mut self.state {
            *since_us = since_us.saturating_add_signed(*leap_us);
        }
        let now_us = input.time_us;
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
            self.character.take(now_us, force_mps2, is_captive && self.force.falling_since_us().is_none());
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

    /// Whether a message came so late after a sign of launch that the umbilical must still be there.
    #[inline(never)]
    fn is_attached_after(&self, sign_us: u64) -> bool {
        self.link
            .last_us()
            .is_some_and(|last_us| last_us > sign_us.saturating_add(microseconds(self.config.window_s)))
    }

    #[inline(never)]
    fn judge_open(&mut self, now_us: u64, edge_us: u64, is_settled: bool, is_early: bool) -> Verdict {
        if !is_settled {
            self.has_departed = self.has_departed && self.wire.has_reopened();
            return Verdict::Suspected;
        }
        let window_us = microseconds(self.config.window_s);
        self.has_departed |=
            self.force.departed_us().is_some_and(|departed_us| departed_us.abs_diff(edge_us) <= window_us);
        let was_alive = self.link.is_alive_at(edge_us, &self.config);
        let is_silent = was_alive && self.link.is_silent(now_us, &self.config);
        if is_silent && !Guard::ListenUntilDecided.stands() {
            return Verdict::Launched(Confirmation::Silence);
        }
        if self.is_attached_after(edge_us) {
            self.wire.call_broken();
            count(&mut self.counts.broken_wires);
            return Verdict::Captive;
        }
        let is_over = Self::has_lasted(edge_us, now_us, self.config.undecided_s);
        if was_alive && !is_silent && !is_over {
            return Verdict::Suspected;
        }
        // A release is felt no longer before the edge than the cable's slack takes. A force that has been low
        // for longer shows none, where the climb rate would show its fall.
        let climb_is_known = self.climb.is_known(edge_us, now_us);
        let is_older = climb_is_known
            && self
                .force
                .below_since_us()
                .is_some_and(|below_us| edge_us.saturating_sub(below_us) > window_us);
        if self.climb.has_fallen(edge_us) || (self.character.has_changed() && !is_older) {
            return Verdict::Launched(match (self.has_departed, was_alive) {
                (true, _) => Confirmation::Force,
                (false, true) => Confirmation::Silence,
                (false, false) => Confirmation::Unconfirmed,
            });
        }
        let would_show = self.character.is_living(now_us) && !is_older;
        let is_all_seen = would_show
            && !self.has_departed
            && !self.character.is_comparable()
            && Self::has_lasted(edge_us, now_us, self.config.window_s);
        if !is_over && !is_all_seen {
            return Verdict::Suspected;
        }
        if !is_early && (self.has_departed || !would_show) {
            // A unit that has died, or lies, shows neither a release nor that there is none: the climb rate is
            // the only witness.
            let waits = !self.has_departed
                && self.character.is_comparable()
                && climb_is_known
                && !self.climb.is_another()
                && !Self::has_lasted(edge_us, now_us, UNSHOWN_S);
            return if waits { Verdict::Suspected } else { Verdict::Launched(Confirmation::Unconfirmed) };
        }
        self.wire.call_broken();
        count(&mut self.counts.torn_cables);
        self.refuted_silence_us = self.link.last_us();
        Verdict::Captive
    }

    /// Whether the vehicle moves or shakes otherwise than it did until the suspicion began.
    fn has_changed(&self, since_us: u64) -> bool {
        self.character.has_changed() || self.climb.has_fallen(since_us)
    }

    /// `says_nothing`: the wire is broken or cannot be read; otherwise it reads closed.
    #[inline(never)]
    fn judge_without(&mut self, now_us: u64, says_nothing: bool) -> Verdict {
        if let Some(sign) = self.sign {
            self.sign = self.followed(sign, now_us, says_nothing);
            if self.sign.is_none() {
                count(&mut self.counts.false_alarms);
            }
        }
        if self.sign.is_none() {
            self.sign = self.new_sign(now_us, says_nothing);
        }
        let by = match self.sign {
            None => return Verdict::Captive,
            Some(Sign::Silence { since_us }) => self.shown_by_silence(since_us, now_us),
            Some(Sign::Force { since_us, has_lasted }) => {
                if self.link.is_alive_at(since_us, &self.config) {
                    let by =
                        if says_nothing { Confirmation::ForceAndSilence } else { Confirmation::StuckWire };
                    (has_lasted && self.link.is_silent(now_us, &self.config)).then_some(by)
                } else {
                    self.shown_by_force(since_us, now_us, says_nothing)
                }
            }
        };
        by.map_or(Verdict::Suspected, Verdict::Launched)
    }

    /// A broken wire, and messages that have ended.
    fn shown_by_silence(&self, since_us: u64, now_us: u64) -> Option<Confirmation> {
        if self.has_changed(since_us) {
            return Some(Confirmation::ForceAndSilence);
        }
        Self::has_lasted(since_us, now_us, self.config.undecided_s).then_some(Confirmation::Unconfirmed)
    }

    /// The force alone, without messages: only together with the climb rate.
    fn shown_by_force(&self, since_us: u64, now_us: u64, says_nothing: bool) -> Option<Confirmation> {
        let is_fall = self.force.falling_since_us().is_some_and(|falling_us| falling_us <= now_us);
        let lasts = |limit_s| is_fall && Self::has_lasted(since_us, now_us, limit_s);
        if self.climb.has_fallen(since_us) {
            if lasts(self.config.fall_s) {
                return Some(Confirmation::FreeFall);
            }
            if says_nothing {
                return Some(Confirmation::Unconfirmed);
            }
        }
        let stands_alone = says_nothing && !self.climb.is_known(since_us, now_us);
        (lasts(self.config.long_fall_s) && (stands_alone || !Guard::ClosedWireHolds.stands()))
            .then_some(Confirmation::FreeFall)
    }

    fn new_sign(&self, now_us: u64, says_nothing: bool) -> Option<Sign> {
        let departed = self.force.departed_us().filter(|departed_us| *departed_us == now_us);
        if let Some(since_us) = departed.filter(|_| says_nothing) {
            return Some(Sign::Force { since_us, has_lasted: true });
        }
        let fall = self
            .force
            .falling_since_us()
            .filter(|since_us| !self.is_attached_after(*since_us) && self.refuted_fall_us != Some(*since_us));
        if let Some(since_us) = fall {
            return Some(Sign::Force { since_us, has_lasted: false });
        }
        let is_cut = self.wire.condition() == WireCondition::Broken
            && self.link.is_silent(now_us, &self.config)
            && self.refuted_silence_us != self.link.last_us();
        is_cut.then_some(Sign::Silence { since_us: now_us })
    }

    /// The sign as it stands now; `None`: it came to nothing.
    fn followed(&mut self, sign: Sign, now_us: u64, says_nothing: bool) -> Option<Sign> {
        match sign {
            Sign::Silence { since_us } => {
                let is_refuted = Self::has_lasted(since_us, now_us, self.config.undecided_s)
                    && !self.has_changed(since_us)
                    && self.character.is_known(now_us);
                if is_refuted {
                    self.refuted_silence_us = self.link.last_us();
                }
                (!is_refuted && self.link.is_silent(now_us, &self.config)).then_some(sign)
            }
            Sign::Force { since_us, has_lasted } => {
                if self.is_attached_after(since_us) {
                    return None;
                }
                let falling_us = self.force.falling_since_us();
                let goes_on = falling_us == Some(since_us);
                if !self.link.is_alive_at(since_us, &self.config) {
                    // A unit that goes on reading a fall which the climb rate does not show is dead.
                    if Self::has_lasted(since_us, now_us, self.config.undecided_s) {
                        self.refuted_fall_us = falling_us;
                        return None;
                    }
                    return (goes_on || (says_nothing && has_lasted)).then_some(sign);
                }
                let has_lasted = has_lasted
                    || (goes_on && Self::has_lasted(since_us, now_us, self.config.fall_s))
                    || (says_nothing && self.force.departed_us() == Some(since_us));
                (has_lasted || goes_on).then_some(Sign::Force { since_us, has_lasted })
            }
        }
    }
}

/// Seconds between two samples; `None` for the first.
fn step_s(last_us: Option<u64>, now_us: u64) -> Option<f32> {
    last_us.map(|last_us| seconds_between(last_us, now_us))
}
