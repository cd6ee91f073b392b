//! Launch: when the UAV left its mother ship, by the umbilical's break-wire, the force on the vehicle and the
//! mother ship's messages.
//!
//! None of the three is proof. A wire bounces, breaks under the pylon and shorts; a gust moves the accelerometer; a
//! data link dies by itself. What each one says, from physics:
//!
//! - Wire: parts once the vehicle has moved by the connector's travel and the cable's slack, up to a quarter of a second
//!   after the hooks open (0.3 m of fall). Contacts that part bounce for milliseconds.
//! - Force: under the pylon the vehicle has the mother ship's load factor. Free, it has that of its own lift, and an
//!   ejector's push for some ten milliseconds. A vehicle that carries a share L/W of its weight by its own wings
//!   under the pylon makes a step of 1 - L/W: 0.3 g and more up to L/W = 0.7. Above that a release can not be felt.
//! - Messages: come through the same umbilical, so one that arrives later than the cable's slack allows proves that
//!   it is still there. Silence is no more than a hint.
//!
//! # Decisions
//! `e`: first opening edge. "Departs": the force leaves its captive mean within [`LaunchConfig::window_s`] of `e`,
//! before or after. "Silent": for longer than [`LaunchConfig::silent_intervals`] of their own intervals (of fewer than
//! three messages: than [`LaunchConfig::undecided_s`]). "Alive": not silent yet at `e`.
//!
//! | wire | force | messages | verdict |
//! |---|---|---|---|
//! | open, shorter than the debounce | any | any | suspected from `e`; closed again: captive, a bounce |
//! | open | departs | any | launched, [`Confirmation::Force`] |
//! | open | no departure, or no samples | were alive, now silent | launched, [`Confirmation::Silence`] |
//! | open | no departure, or no samples | go on | suspected; after [`LaunchConfig::undecided_s`] `broken wire`, captive |
//! | open | no departure, or no samples | none at `e` | suspected; after [`LaunchConfig::undecided_s`] launched, [`Confirmation::Unconfirmed`] |
//! | broken | departs | silent from then on | launched, [`Confirmation::ForceAndSilence`] |
//! | broken | no departure | silent | suspected; after [`LaunchConfig::undecided_s`] launched, [`Confirmation::Unconfirmed`] |
//! | unreadable for longer than [`LaunchConfig::undecided_s`] | departs | silent from then on | launched, [`Confirmation::ForceAndSilence`] |
//! | closed | near free fall for [`LaunchConfig::fall_s`] | silent from then on | launched, [`Confirmation::StuckWire`] |
//! | any but open | near free fall for [`LaunchConfig::long_fall_s`] | none when it began | launched, [`Confirmation::FreeFall`] |
//! | any but open | any | go on | captive |
//!
//! A broken wire that reads closed for the debounce time is whole again. A wire that is open at the first tick opened
//! there. A launch is final.
//!
//! # What calibration sees
//! From the first tick of a suspicion on no calibration data may be taken ([`LaunchState::doubt`]), so how long a
//! verdict takes changes no latched bias. Where the first sign of a launch is not the wire (broken, closed or unreadable)
//! the suspicion starts with the departure or the fall, some 30 ms of smoothing after the release; with a broken
//! wire and no departure it starts only when the silence is noticed.
//!
//! # False alarms and misses
//! A vertical gust `w` changes the mother ship's load factor by `rho V a w / (2 W/S)` (Pratt's sharp-edged gust, NACA
//! Report 1206, 1954): at 1 m/s, 0.2 g for a transport (100 m/s, 2,500 N/m^2, a = 5/rad: 0.11 g), 0.5 g for a light
//! carrier (28 m/s, 150 N/m^2). So no fixed threshold tells gusts from releases for both: the force departs when it is
//! both [`LaunchConfig::departure`] and [`LaunchConfig::departure_sigmas`] captive standard deviations away.
//! - False alarm: a wire must break within the window of such a departure. For Gaussian turbulence a window of half a
//!   second with some ten independent values sees 4 sigmas once in 1,600. A pull-up or push-over that begins within that
//!   window of a break, and a jolt that itself tears the wire, are called a launch; messages that go on afterwards
//!   are counted ([`LaunchCounts::messages_after_launch`]). What it costs: the calibration ends early.
//! - Miss by the force alone: L/W near 1, or turbulence of a quarter of g and more (4 sigmas of it are the whole of the
//!   weight). The messages or the time limit then decide, later but on the same data.
//! - Near free fall (below [`LaunchConfig::fall_load`] g) for 2 s takes 14 m/s off the climb rate: no carrier pushes over so
//!   with a vehicle under it. It misses a launch whose vehicle carries itself sooner; with neither wire nor messages
//!   such a launch is not seen, and nothing could show it.

mod force;
mod link;
#[cfg(test)]
mod tests;
mod wire;

use crate::estimator::ConfigError;
use crate::input::LaunchDoubt;
use crate::time::{microseconds, seconds_between};
use force::Force;
use link::Link;
use wire::{Reading, Wire};

/// Limits of the decision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LaunchConfig {
    /// How long the wire must read open without a closed reading between, seconds.
    pub debounce_s: f32,
    /// How far from the edge a departure of force, and how long after the first sign a last message, may lie, seconds.
    pub window_s: f32,
    /// Departure of the specific force's magnitude from its captive mean, as a share of that mean.
    pub departure: f32,
    /// The same in standard deviations of the captive magnitude, smoothed over 30 ms.
    pub departure_sigmas: f32,
    /// Messages are silent after so many of their own mean intervals.
    pub silent_intervals: u16,
    /// How long an open wire that nothing confirms, or a wire that can not be read, is left undecided, seconds.
    pub undecided_s: f32,
    /// Specific force below which it is near free fall, g.
    pub fall_load: f32,
    /// Near free fall that, with silence, shows a launch, seconds.
    pub fall_s: f32,
    /// Near free fall that alone shows a launch, seconds.
    pub long_fall_s: f32,
}

impl LaunchConfig {
    /// From the module's physics. `undecided_s`: a release with L/W near 1 must be over, and slow messages missed.
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
    /// Time of the tick, microseconds; must increase.
    pub time_us: u64,
    /// Whether the umbilical's discrete reads open; `None`: it could not be read.
    pub is_open: Option<bool>,
    /// Specific force, body axes, m/s^2, if there is a new sample.
    pub force_mps2: Option<[f32; 3]>,
    /// When the last message of the mother ship came, microseconds, by the ticks' clock; `None`: none ever.
    pub last_message_us: Option<u64>,
}

/// What confirmed a launch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Confirmation {
    /// Open wire, and the force departed from its captive mean.
    Force,
    /// Open wire, and the messages fell silent.
    Silence,
    /// The wire was broken or could not be read: departure of force and silence.
    ForceAndSilence,
    /// The wire is stuck closed: near free fall and silence.
    StuckWire,
    /// Near free fall alone, for long.
    FreeFall,
    /// Nothing confirmed the wire, and nothing contradicted it until the time limit.
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
    /// When the suspicion began: the first edge, or the first sign in the force or the messages; microseconds.
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
    /// It reads open, and messages came through the umbilical all the same.
    Broken,
    /// It has not been read for longer than the time limit.
    Unreadable,
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
    /// Ticks ignored because their time was not after the last one's.
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
    last_us: Option<u64>,
    wire: Wire,
    force: Force,
    link: Link,
    sign: Option<Sign>,
    counts: LaunchCounts,
}

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
            last_us: None,
            wire: Wire::default(),
            force: Force::default(),
            link: Link::default(),
            sign: None,
            counts: LaunchCounts::default(),
        })
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
        let now_us = input.time_us;
        if self.last_us.is_some_and(|last_us| now_us <= last_us) {
            count(&mut self.counts.out_of_order);
            return self.state;
        }
        self.last_us = Some(now_us);
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
        self.force.take(input, is_captive, &self.config, &mut self.counts);
        let verdict = match self.wire.reading() {
            Reading::Open { edge_us, is_settled } => {
                self.sign = None;
                self.judge_open(now_us, edge_us, is_settled)
            }
            Reading::Closed => self.judge_without(now_us, false),
            Reading::Nothing => self.judge_without(now_us, true),
        };
        let since_us = match self.state {
            LaunchState::Suspected { since_us } => since_us,
            LaunchState::Captive | LaunchState::Launched(_) => now_us,
        };
        self.state = match verdict {
            Verdict::Captive => LaunchState::Captive,
            Verdict::Suspected => LaunchState::Suspected { since_us },
            Verdict::Launched(by) => {
                LaunchState::Launched(Launch { first_edge_us: since_us, confirmed_us: now_us, by })
            }
        };
        self.state
    }

    fn has_lasted(since_us: u64, now_us: u64, limit_s: f32) -> bool {
        now_us.saturating_sub(since_us) >= microseconds(limit_s)
    }

    /// Whether a message came so late after a sign of launch that the umbilical must still be there.
    fn is_attached_after(&self, sign_us: u64) -> bool {
        self.link
            .last_us()
            .is_some_and(|last_us| last_us > sign_us.saturating_add(microseconds(self.config.window_s)))
    }

    #[inline(never)]
    fn judge_open(&mut self, now_us: u64, edge_us: u64, is_settled: bool) -> Verdict {
        if !is_settled {
            return Verdict::Suspected;
        }
        let window_us = microseconds(self.config.window_s);
        if self.force.departed_us().is_some_and(|departed_us| departed_us.abs_diff(edge_us) <= window_us) {
            return Verdict::Launched(Confirmation::Force);
        }
        let was_alive = self.link.is_alive_at(edge_us, &self.config);
        if was_alive && self.link.is_silent(now_us, &self.config) {
            return Verdict::Launched(Confirmation::Silence);
        }
        if Self::has_lasted(edge_us, now_us, self.config.undecided_s) {
            if self.is_attached_after(edge_us) {
                self.wire.call_broken();
                count(&mut self.counts.broken_wires);
                return Verdict::Captive;
            }
            if !was_alive {
                return Verdict::Launched(Confirmation::Unconfirmed);
            }
        }
        Verdict::Suspected
    }

    /// While the wire shows no launch: it is closed, or (`says_nothing`) broken or unreadable.
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
        match self.sign {
            None => Verdict::Captive,
            Some(Sign::Silence { since_us }) => {
                match Self::has_lasted(since_us, now_us, self.config.undecided_s) {
                    true => Verdict::Launched(Confirmation::Unconfirmed),
                    false => Verdict::Suspected,
                }
            }
            Some(Sign::Force { since_us, has_lasted }) => {
                if self.link.is_alive_at(since_us, &self.config) {
                    let by =
                        if says_nothing { Confirmation::ForceAndSilence } else { Confirmation::StuckWire };
                    let is_shown = has_lasted && self.link.is_silent(now_us, &self.config);
                    return if is_shown { Verdict::Launched(by) } else { Verdict::Suspected };
                }
                match Self::has_lasted(since_us, now_us, self.config.long_fall_s) {
                    true => Verdict::Launched(Confirmation::FreeFall),
                    false => Verdict::Suspected,
                }
            }
        }
    }

    fn new_sign(&self, now_us: u64, says_nothing: bool) -> Option<Sign> {
        let is_alive = self.link.is_alive_at(now_us, &self.config);
        let departed = self.force.departed_us().filter(|departed_us| *departed_us == now_us);
        let departed = departed.filter(|_| says_nothing && is_alive);
        if let Some(since_us) = departed {
            return Some(Sign::Force { since_us, has_lasted: true });
        }
        let fall = self.force.falling_since_us().filter(|since_us| !self.is_attached_after(*since_us));
        if let Some(since_us) = fall {
            return Some(Sign::Force { since_us, has_lasted: false });
        }
        let is_cut =
            self.wire.condition() == WireCondition::Broken && self.link.is_silent(now_us, &self.config);
        is_cut.then_some(Sign::Silence { since_us: now_us })
    }

    /// The sign as it stands now; `None`: it came to nothing.
    fn followed(&self, sign: Sign, now_us: u64, says_nothing: bool) -> Option<Sign> {
        match sign {
            Sign::Silence { .. } => self.link.is_silent(now_us, &self.config).then_some(sign),
            Sign::Force { since_us, has_lasted } => {
                if self.is_attached_after(since_us) {
                    return None;
                }
                let goes_on = self.force.falling_since_us() == Some(since_us);
                if !self.link.is_alive_at(since_us, &self.config) {
                    return goes_on.then_some(sign);
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
