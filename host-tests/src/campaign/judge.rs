//! The invariants of a run, and the cost of its faults.

use std::fmt;

use chip_models::flown::{Chip, Fault, Quantity};
use kf_core::launch::LaunchConfig;
use kf_core::output::Trust;
use kf_core::sensor::Sensor;
use survival::Start;

use super::fault::{Drawn, Phase, Place};
use super::flight::TICKS_PER_S;
use super::run::{Case, Flown, PUSH_TICKS};
use super::watch::{Flagged, REFERENCE, REPORTING_TICKS, Restarted, Seen, Watched};

/// Largest allowed distance of a latched bias from the clean run's, in multiples of its own sigma.
const BIAS_SIGMAS: f32 = 4.0;
/// Largest allowed ratio of a bound to the clean run's, either way.
const BOUND_FACTOR: f32 = 1.3;
/// Largest allowed ratio of a failure's detection delay to the clean run's.
const DELAY_FACTOR: f32 = 1.5;
/// Allowed cost of a transient beyond its own length, ticks: half a second.
const GRACE_TICKS: usize = 100;
/// Half of the default model's moving average: the lag of the average of a ramp (eq. 16's second criterion;
/// `kf_core::monitor`: "a ramp is doubtful at the bound and untrustworthy half a window later").
const HALF_WINDOW_TICKS: usize = 200;
/// How long a launch may be left undecided, ticks.
const UNDECIDED_TICKS: usize = (LaunchConfig::DEFAULT.undecided_s as f64 * TICKS_PER_S) as usize;
/// Time from a message to the tick that uses it, plus the wire's debounce, ticks: a launch may be reported
/// this much after the limit.
const DECISION_TICKS: usize = 10;
/// Largest number of operations on ports in a tick. A clean flight's worst tick takes 14. The budget of
/// instructions, which the QEMU sample must meet, covers all work.
const MOST_OPERATIONS: u32 = 40;
/// Calling a sensor untrustworthy is right if its true error, or that error's change since the launch, is
/// beyond this share of the bound: the reference has an error of its own, which the bound allows for. A
/// receiver that was off throughout the calibration leaves a wrong bias; what the sensor has drifted since is
/// its own error nevertheless.
const RIGHTLY: f32 = 0.6;
/// So it is if a receiver without the fault shows the sensor beyond this share of the bound: what the fault
/// did to the sensor and the receiver's usual wander add up to that, and the wander is no fault. Less than 1,
/// because the judge's average lags the monitor's by a second, in which an integrated altitude may drift by a
/// metre. docs/fault-campaign.md has the shares of twenty flags.
const SHOWN: f32 = 0.8;
/// Flagging an altitude that the flight computer integrates is owed once its true error is beyond this
/// multiple of the bound. Its own drift may cancel a push, and the same error of the reference may hide what
/// is left.
const OWED: f32 = 2.0 - RIGHTLY;

/// What must hold in every run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Invariant {
    /// No launch without separation.
    Launch,
    /// A separation is detected whatever a single fault does, except to the wire: a wire that is shorted or
    /// cannot be read hides it, as documented in `kf_core::launch`.
    Seen,
    /// A latch called good has each bias within 4 of its own sigmas of the clean run's.
    Bias,
    /// The monitor's bound is within 1.3 of the clean run's, or the calibration is called degraded.
    Bound,
    /// A failure after launch is flagged within 1.5 times the clean delay, or the sensor was reported as not
    /// monitored.
    Detection,
    /// A healthy sensor is not called untrustworthy because of another's fault.
    Blame,
    /// A transient costs a sensor at most the transient's length and half a second.
    Transient,
    /// A transient costs no sensor for the rest of the flight.
    Permanent,
    /// No panic.
    Panic,
    /// No late tick: its work is bounded.
    Work,
    /// Every restart is reported in the telemetry.
    RestartReported,
    /// No published number is invalid.
    Finite,
    /// The latch never changes.
    Latch,
}

impl Invariant {
    /// All invariants.
    pub const ALL: [Self; 13] = [
        Self::Launch,
        Self::Seen,
        Self::Bias,
        Self::Bound,
        Self::Detection,
        Self::Blame,
        Self::Transient,
        Self::Permanent,
        Self::Panic,
        Self::Work,
        Self::RestartReported,
        Self::Finite,
        Self::Latch,
    ];

    /// Name for tables.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Launch => "false launch",
            Self::Seen => "launch not seen in time",
            Self::Bias => "wrong bias called good",
            Self::Bound => "wrong bound called good",
            Self::Detection => "failure not flagged in time",
            Self::Blame => "healthy sensor called untrustworthy",
            Self::Transient => "transient costs too much",
            Self::Permanent => "transient costs the sensor",
            Self::Panic => "panic",
            Self::Work => "tick with too much work",
            Self::RestartReported => "restart not reported",
            Self::Finite => "not finite",
            Self::Latch => "latch changed",
        }
    }
}

/// A broken invariant.
#[derive(Clone, Debug, PartialEq)]
pub struct Violation {
    /// The broken invariant.
    pub invariant: Invariant,
    /// What happened.
    pub what: String,
}

/// The worst consequence in a run, from harmless to grave.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub enum Consequence {
    /// Nothing visible.
    None,
    /// The calibration is called degraded.
    Degraded,
    /// A sensor, or the reference, delivered nothing for this many seconds longer than in the clean run.
    Silent(f32),
    /// A sensor is reported as not monitored for this many seconds longer.
    Unmonitored(f32),
    /// A wrong sensor is flagged.
    Flagged,
    /// The launch is confirmed this many seconds later.
    LateLaunch(f32),
    /// The launch is not detected.
    NoLaunch,
    /// An invariant is broken.
    Violation(Invariant),
}

impl fmt::Display for Consequence {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::None => formatter.write_str("none"),
            Self::Degraded => formatter.write_str("degraded"),
            Self::Silent(seconds) => write!(formatter, "silent {seconds:.1} s"),
            Self::Unmonitored(seconds) => write!(formatter, "unmonitored {seconds:.0} s"),
            Self::Flagged => formatter.write_str("flagged"),
            Self::LateLaunch(seconds) => write!(formatter, "launch {seconds:.1} s late"),
            Self::NoLaunch => formatter.write_str("launch not seen"),
            Self::Violation(invariant) => write!(formatter, "**{}**", invariant.name()),
        }
    }
}

/// Verdict on a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    /// The broken invariants.
    pub violations: Vec<Violation>,
    /// The worst consequence.
    pub worst: Consequence,
}

/// Sensors that fly free.
const FREE: [Sensor; 2] = [Sensor::ImuSlave, Sensor::Baro];

/// Judges a run.
#[must_use]
pub fn judge(case: &Case, flown: &Flown) -> Verdict {
    let mut judge = Judge { case, clean: &flown.clean, faulty: &flown.faulty, violations: Vec::new() };
    judge.machine();
    judge.launch();
    judge.seen();
    judge.calibration();
    judge.blame();
    judge.detection();
    judge.transients();
    let worst = judge.worst();
    Verdict { violations: judge.violations, worst }
}

struct Judge<'a> {
    case: &'a Case,
    clean: &'a Watched,
    faulty: &'a Watched,
    violations: Vec<Violation>,
}

fn seconds(ticks: usize) -> f32 {
    ticks as f32 * 0.005
}

/// Error of a flagged sensor as the receiver of the clean flight would show it, metres.
#[must_use]
pub fn shown_m(clean: &Watched, flagged: &Flagged) -> f32 {
    flagged.true_error_m - clean.fix_error_m(flagged.tick)
}

/// The sensor whose own measurement a fault spoils.
fn is_own(fault: &Drawn, sensor: Sensor, has_unit: bool) -> bool {
    match sensor {
        Sensor::Baro => fault.place == Place::Baro,
        Sensor::ImuSlave => fault.place == Place::Imu && !has_unit,
        Sensor::ImuMaster => fault.place == Place::Master,
    }
}

impl Judge<'_> {
    fn broken(&mut self, invariant: Invariant, what: String) {
        self.violations.push(Violation { invariant, what });
    }

    fn is_degraded(watched: &Watched) -> bool {
        watched.latch.as_ref().is_some_and(|latch| latch.failed_checks != 0)
    }

    fn machine(&mut self) {
        for (name, flight) in [("clean", self.clean), ("faulty", self.faulty)] {
            if let Some(panic) = &flight.panic {
                self.violations.push(Violation {
                    invariant: Invariant::Panic,
                    what: format!("{name} flight, tick {}: {panic}", flight.ticks.len()),
                });
            }
            if let Some((tick, what)) = flight.not_finite {
                self.violations.push(Violation {
                    invariant: Invariant::Finite,
                    what: format!("{name} flight, {:.3} s: {what}", seconds(tick)),
                });
            }
            if flight.most_operations > MOST_OPERATIONS {
                self.violations.push(Violation {
                    invariant: Invariant::Work,
                    what: format!("{name} flight: {} operations in a tick", flight.most_operations),
                });
            }
            if flight.other_latches > 0 {
                self.violations.push(Violation {
                    invariant: Invariant::Latch,
                    what: format!("{name} flight: {} times", flight.other_latches),
                });
            }
        }
        // A program that crashes repeatedly pauses, longer each time, but must come back.
        let crashes = self.case.faults.iter().find(|fault| fault.place == Place::Program);
        let is_back = self.faulty.ticks.last().is_some_and(Option::is_some);
        let may_pause = crashes.is_some_and(|fault| is_back || fault.to >= self.faulty.ticks.len());
        if self.faulty.standby_ticks > 0 && !may_pause {
            self.violations.push(Violation {
                invariant: Invariant::Permanent,
                what: format!(
                    "the flight computer stands by for {:.2} s",
                    seconds(self.faulty.standby_ticks)
                ),
            });
        }
        let restarts = &self.faulty.restarts;
        for (place, restart) in restarts.iter().enumerate().filter(|(_, restart)| !restart.is_reported) {
            // If the computer is off again before its text is out, a later restart's number reports it: that
            // counts them all.
            let is_counted =
                |later: &Restarted| later.tick <= restart.tick + REPORTING_TICKS && later.is_reported;
            if restarts.iter().skip(place + 1).any(is_counted) {
                continue;
            }
            self.violations.push(Violation {
                invariant: Invariant::RestartReported,
                what: format!("at {:.3} s: {:?}", seconds(restart.tick), restart.report),
            });
        }
    }

    fn launch(&mut self) {
        let separation = self.case.plan.separates.then(|| self.case.plan.separation());
        for (name, flight) in [("clean", self.clean), ("faulty", self.faulty)] {
            let Some(launched) = flight.launched else { continue };
            if separation.is_none_or(|separation| launched < separation) {
                let truth = separation.map_or_else(
                    || "and there is no separation".to_owned(),
                    |separation| format!("{:.3} s before separation", seconds(separation - launched)),
                );
                self.violations.push(Violation {
                    invariant: Invariant::Launch,
                    what: format!("{name} flight: launched at {:.3} s, {truth}", seconds(launched)),
                });
            }
        }
    }

    fn seen(&mut self) {
        let ([fault], Some(edge), Some(clean)) =
            (self.case.faults.as_slice(), self.clean.first_edge, self.clean.launched)
        else {
            return;
        };
        // Where the clean flight does not detect the launch in time, nothing is required.
        if fault.place == Place::Wire || clean > edge + UNDECIDED_TICKS + DECISION_TICKS {
            return;
        }
        let latest = clean.max(fault.to) + UNDECIDED_TICKS + GRACE_TICKS;
        if self.faulty.ticks.len() <= latest || self.faulty.launched.is_some_and(|tick| tick <= latest) {
            return;
        }
        let when = self.faulty.launched.map_or_else(
            || "never".to_owned(),
            |tick| format!("{:.2} s later than in the clean flight", seconds(tick.saturating_sub(clean))),
        );
        self.broken(Invariant::Seen, format!("{when}; the cable parts at {:.3} s", seconds(edge)));
    }

    fn calibration(&mut self) {
        let (Some(clean), Some(faulty)) = (&self.clean.latch, &self.faulty.latch) else { return };
        if faulty.failed_checks != 0 || self.has(Invariant::Launch) {
            return;
        }
        for sensor in Sensor::ALL {
            let (clean, faulty) = (&clean.sensors[sensor.index()], &faulty.sensors[sensor.index()]);
            if clean.readings < 2 || faulty.readings < 2 {
                continue;
            }
            // An offset that lasts from before the calibration until the latch is the sensor's bias.
            let latched = self.faulty.launched.unwrap_or(self.faulty.ticks.len());
            let is_its_bias = |fault: &Drawn| {
                fault.is_altitude_offset()
                    && fault.phase == Phase::Settling
                    && fault.to >= latched
                    && is_own(fault, sensor, false)
            };
            if self.case.faults.iter().any(is_its_bias) {
                continue;
            }
            let sigma_m = faulty.bias_variance_m2.max(0.0).sqrt();
            let off_m = faulty.bias_m - clean.bias_m;
            // NaN is an error as well.
            let is_off =
                off_m.is_nan() || off_m.abs() > BIAS_SIGMAS * sigma_m && !self.is_level_the_only_one(latched);
            if is_off {
                self.broken(
                    Invariant::Bias,
                    format!(
                        "{}: {:.2} m, clean {:.2} m: {:.1} sigmas of {sigma_m:.2} m",
                        sensor.name(),
                        faulty.bias_m,
                        clean.bias_m,
                        off_m.abs() / sigma_m
                    ),
                );
            }
            if !sensor.flies_free() || clean.bound_m2 <= 0.0 || faulty.bound_m2 == 0.0 {
                continue;
            }
            let factor = (faulty.bound_m2 / clean.bound_m2).sqrt();
            if !(1.0 / BOUND_FACTOR..=BOUND_FACTOR).contains(&factor) {
                self.broken(
                    Invariant::Bound,
                    format!(
                        "{}: bound {:.2} m, clean {:.2} m",
                        sensor.name(),
                        faulty.bound_m(),
                        clean.bound_m()
                    ),
                );
            }
        }
    }

    /// Whether the receiver had the same offset from before its first fix until the latch: everything is
    /// measured against that, and no other level is known on board.
    fn is_level_the_only_one(&self, latched: usize) -> bool {
        let is_fresh = |seen: &Option<Seen>| seen.is_some_and(|seen| seen.fresh & 1 << REFERENCE != 0);
        let Some(first_fix) = self.faulty.ticks.iter().position(is_fresh) else { return false };
        self.case.faults.iter().any(|fault| {
            let begins = fault.events.first().is_some_and(|(_, event)| {
                event.chip == Chip::Gps
                    && matches!(event.fault, Fault::Offset { quantity: Quantity::Altitude, .. })
            });
            begins && fault.from <= first_fix && fault.to >= latched
        })
    }

    fn has(&self, invariant: Invariant) -> bool {
        self.violations.iter().any(|violation| violation.invariant == invariant)
    }

    fn bound_m(&self, sensor: Sensor) -> f32 {
        self.faulty.latch.as_ref().map_or(f32::INFINITY, |latch| latch.sensors[sensor.index()].bound_m())
    }

    /// The clean run's alarm limit, metres; infinite if the sensor is not monitored there. A fault may widen
    /// the limit, or take it away; what is right does not depend on that.
    fn clean_bound_m(&self, sensor: Sensor) -> f32 {
        let latch = self.clean.latch.as_ref();
        let bound_m = latch.map(|latch| latch.sensors[sensor.index()].bound_m());
        bound_m.filter(|bound_m| *bound_m > 0.0).unwrap_or(f32::INFINITY)
    }

    /// Whether a sensor was called untrustworthy without being wrong.
    fn wrongly(&self, sensor: Sensor) -> Option<usize> {
        let flagged = self.faulty.flagged[sensor.index()]?;
        if self.clean.flagged[sensor.index()].is_some() {
            return None;
        }
        let fails = self.case.failure.filter(|failure| failure.sensor == sensor);
        if fails.is_some_and(|failure| flagged.tick >= failure.tick) {
            return None;
        }
        let bound_m = self.clean_bound_m(sensor).min(self.bound_m(sensor));
        let shown_m = shown_m(self.clean, &flagged);
        // A fault of the sensor's own may be over: what it was off by at the launch shows no bias.
        let has_unit = self.case.plan.own_unit.is_some();
        let is_spoilt = self.case.faults.iter().any(|fault| is_own(fault, sensor, has_unit));
        let launched = self.faulty.launched.and_then(|tick| self.faulty.ticks.get(tick).copied().flatten());
        let calibrated_m =
            launched.filter(|_| !is_spoilt).map_or(0.0, |seen| seen.true_error_m[sensor.index()]);
        let is_right = flagged.true_error_m.abs() >= RIGHTLY * bound_m
            || (flagged.true_error_m - calibrated_m).abs() >= RIGHTLY * bound_m
            || shown_m.abs() >= SHOWN * bound_m;
        (!is_right).then_some(flagged.tick)
    }

    fn blame(&mut self) {
        if self.has(Invariant::Launch) {
            return;
        }
        let has_unit = self.case.plan.own_unit.is_some();
        for sensor in FREE {
            let own = self.case.faults.iter().find(|fault| is_own(fault, sensor, has_unit));
            let Some(tick) = self.wrongly(sensor) else { continue };
            let error_m = self.faulty.flagged[sensor.index()].map_or(0.0, |flagged| flagged.true_error_m);
            let what = format!(
                "{} at {:.3} s, {error_m:.2} m off, bound {:.2} m",
                sensor.name(),
                seconds(tick),
                self.bound_m(sensor)
            );
            match own {
                None => self.broken(Invariant::Blame, what),
                Some(fault) if fault.is_transient() => {
                    let allowed = fault.to - fault.from + GRACE_TICKS;
                    match self.early(sensor, tick) {
                        Some(early) if early <= allowed => {}
                        Some(early) => self.broken(
                            Invariant::Transient,
                            format!("flagged {:.2} s before it leaves its bound: {what}", seconds(early)),
                        ),
                        None => self.broken(Invariant::Permanent, format!("flagged: {what}")),
                    }
                }
                Some(_) => {}
            }
        }
    }

    /// Number of ticks from a sensor's flag until it leaves its bound. A transient may turn the level of an
    /// altitude that is integrated, which then drifts away for good: no flag costs such a sensor more than
    /// the time until it is useless. `None` if it is within its bound in the end, or when it fails by itself.
    fn early(&self, sensor: Sensor, flagged: usize) -> Option<usize> {
        let bound_m = self.clean_bound_m(sensor).min(self.bound_m(sensor));
        let is_beyond =
            |seen: &Option<Seen>| seen.is_some_and(|seen| seen.true_error_m[sensor.index()].abs() >= bound_m);
        let fails = self.case.failure.filter(|failure| failure.sensor == sensor);
        let end = fails.map_or(usize::MAX, |failure| failure.tick).min(self.faulty.ticks.len());
        let after = self.faulty.ticks.get(flagged..end)?;
        let last = after.iter().rev().find(|seen| seen.is_some())?;
        is_beyond(last).then(|| after.iter().position(is_beyond))?
    }

    fn detection(&mut self) {
        let Some(failure) = self.case.failure else { return };
        if self.has(Invariant::Launch) {
            return;
        }
        let (sensor, i) = (failure.sensor, failure.sensor.index());
        // A push while the flight computer is away does not count: no sample of it was taken, so none of it
        // is in the altitude.
        let has_unit = self.case.plan.own_unit.is_some();
        let is_there = |tick: usize| self.faulty.ticks.get(tick).is_some_and(Option::is_some);
        if sensor == Sensor::ImuSlave && !has_unit && !(failure.tick..failure.tick + PUSH_TICKS).any(is_there)
        {
            return;
        }
        let Some(clean) = self.clean.flagged[i].filter(|clean| clean.tick >= failure.tick) else { return };
        // A sensor that is doubtful before it fails is flagged for that sooner or later; the time of the flag
        // is then unrelated to the failure.
        if self.clean.trust(sensor, failure.tick) != Some(Trust::Trusted) {
            return;
        }
        let delay = clean.tick - failure.tick;
        let allowed = (delay as f32 * DELAY_FACTOR) as usize + GRACE_TICKS;
        let latest = failure.tick + allowed;
        // The failure could not be detected during the faults in between.
        let blind: usize = self
            .case
            .faults
            .iter()
            .map(|fault| fault.to.min(latest).saturating_sub(fault.from.max(failure.tick)))
            .sum();
        // Nor could it at any time, however long, at which something that the monitor depends on is at fault:
        // the sensor itself, the reference, the computer.
        let bears = |fault: &&Drawn| {
            matches!(fault.place, Place::Gps | Place::Supply | Place::Clock | Place::Program)
                || is_own(fault, sensor, has_unit)
        };
        let is_whole = |tick: &usize| {
            let mut bearing = self.case.faults.iter().filter(bears);
            bearing.all(|fault| !(fault.from..fault.to).contains(tick))
        };
        let Some(whole) = (failure.tick..self.faulty.ticks.len()).filter(is_whole).nth(allowed) else {
            return;
        };
        let latest = whole.max(latest + blind);
        let flagged = self.faulty.flagged[i].map(|flagged| flagged.tick);
        if latest >= self.faulty.ticks.len() || flagged.is_some_and(|tick| tick <= latest) {
            return;
        }
        // Where no trust is reported, no detection is missed.
        let is_promised =
            |tick: usize| matches!(self.faulty.trust(sensor, tick), Some(Trust::Trusted | Trust::Doubtful));
        let promised = (failure.tick..latest).filter(|tick| is_promised(*tick)).count();
        if promised < delay || !is_promised(latest) || (Self::is_degraded(self.faulty) && flagged.is_some()) {
            return;
        }
        // A sensor that reads right needs no flag until it leaves its bound. From then on the flag is due as
        // soon as in the clean flight. After a gap, an altitude that the flight computer integrates has a
        // different drift from the clean one's, and mending the gap also removes a push during it.
        let is_integrated = sensor == Sensor::ImuSlave && !has_unit;
        let rightly_m = if is_integrated { OWED } else { RIGHTLY } * self.bound_m(sensor);
        let is_right = |watched: &Watched, tick: usize| {
            let seen = watched.ticks.get(tick).copied().flatten();
            seen.is_none_or(|seen| seen.true_error_m[i].abs() < rightly_m)
        };
        // When the sensor stopped reading right, given a tick at which it is wrong.
        let left = |watched: &Watched, wrong: usize| {
            (failure.tick..wrong).rev().find(|tick| is_right(watched, *tick)).unwrap_or(failure.tick)
        };
        let end = self.faulty.ticks.len();
        let Some(wrong) = (latest..end).find(|tick| !is_right(self.faulty, *tick)) else { return };
        // The time from there to the flag in the clean flight, which may be zero where the receiver was off
        // in the same direction. The average, which the second criterion judges, needs half its window.
        let beyond = left(self.faulty, wrong);
        let from_there = clean.tick.saturating_sub(left(self.clean, clean.tick)).max(HALF_WINDOW_TICKS);
        let owed = beyond + (from_there as f32 * DELAY_FACTOR) as usize + GRACE_TICKS;
        if owed > latest && (owed >= end || flagged.is_some_and(|tick| tick <= owed) || !is_promised(owed)) {
            return;
        }
        let later = flagged.map_or_else(
            || "never flagged".to_owned(),
            |tick| format!("flagged after {:.2} s", seconds(tick - failure.tick)),
        );
        self.broken(
            Invariant::Detection,
            format!(
                "{} {:?} at {:.3} s: {later}, clean after {:.2} s",
                sensor.name(),
                failure.kind,
                seconds(failure.tick),
                seconds(delay)
            ),
        );
    }

    /// First and last tick of the faults, if all are over within a second.
    fn transient(&self) -> Option<(usize, usize)> {
        let faults = &self.case.faults;
        let is_brief = !faults.is_empty()
            && faults.iter().all(|fault| fault.is_transient() && fault.place != Place::Clock);
        if !is_brief {
            return None;
        }
        let (from, to) =
            faults.iter().fold((usize::MAX, 0), |(from, to), fault| (from.min(fault.from), to.max(fault.to)));
        (to <= from + 200 && to + 1_000 < self.faulty.ticks.len()).then_some((from, to))
    }

    fn transients(&mut self) {
        let Some((from, to)) = self.transient() else { return };
        if self.has(Invariant::Launch) {
            return;
        }
        let mut end = self.faulty.ticks.len().min(self.clean.ticks.len());
        // Where the launch is not detected, as `seen` allows, calibration continues and gates a failing
        // sensor: the cause is then the sensor's own failure.
        let launched = self.faulty.launched.unwrap_or(usize::MAX);
        if let Some(failure) = self.case.failure.filter(|failure| failure.tick < launched) {
            end = end.min(failure.tick);
        }
        let parted = if self.case.plan.separates { self.case.plan.separation() } else { end };
        // A restart under the pylon costs a calibration, and that is reported. This also holds at the first
        // edge, until the task below that tick has kept a copy.
        let begins_anew = |start: Start| matches!(start, Start::Captive | Start::Cold);
        // The same holds for a release that the clean flight itself does not detect in time: until then the
        // vehicle is still treated as captive.
        let edge = self.clean.first_edge.unwrap_or(end);
        let seen = self.clean.launched.unwrap_or(end);
        let known = if seen > edge + UNDECIDED_TICKS + DECISION_TICKS { seen } else { edge };
        let restarts_captive = from <= known + 1
            && self
                .faulty
                .restarts
                .iter()
                .any(|restart| restart.report.is_some_and(|report| begins_anew(report.start)));
        for source in 0..=REFERENCE {
            let until = if source == Sensor::ImuMaster.index() { parted } else { end };
            if from >= until || restarts_captive {
                continue;
            }
            let usual = self.clean.longest_gap(source, from, until);
            let gap = self.faulty.longest_gap(source, from, until);
            let name = Sensor::ALL.get(source).map_or("reference", |sensor| sensor.name());
            let allowed = (to - from) + GRACE_TICKS + usual;
            if gap > allowed {
                let until_end = until.saturating_sub(to) <= gap + 400;
                let invariant = if until_end { Invariant::Permanent } else { Invariant::Transient };
                self.broken(
                    invariant,
                    format!(
                        "{name} delivers nothing for {:.2} s; the fault lasts {:.2} s from {:.3} s on",
                        seconds(gap),
                        seconds(to - from),
                        seconds(from)
                    ),
                );
            }
        }
        // Where the clean flight does not detect the launch, or not yet, it monitors nothing either.
        let Some(launched) = self.clean.launched.zip(self.faulty.launched).map(|(a, b)| a.max(b)) else {
            return;
        };
        for sensor in FREE {
            let extra = self.in_vain(self.faulty, sensor, launched);
            let extra = extra.saturating_sub(self.in_vain(self.clean, sensor, launched));
            if extra > (to - from) + GRACE_TICKS && !restarts_captive {
                let last = self.faulty.ticks.iter().rev().flatten().next();
                let for_good = last.is_some_and(|seen| seen.trust[sensor.index()] == Trust::Unmonitored);
                let invariant = if for_good { Invariant::Permanent } else { Invariant::Transient };
                self.broken(
                    invariant,
                    format!("{} is unmonitored for {:.2} s longer", sensor.name(), seconds(extra)),
                );
            }
        }
    }

    /// Number of ticks from a given one on at which a sensor that reads correctly is not monitored. One that is
    /// wrong and not yet flagged is not missed.
    fn in_vain(&self, watched: &Watched, sensor: Sensor, from: usize) -> usize {
        let limit_m = RIGHTLY * self.clean_bound_m(sensor);
        let seen = watched.ticks.iter().skip(from).flatten();
        let is_in_vain = |seen: &&Seen| {
            seen.trust[sensor.index()] == Trust::Unmonitored
                && seen.true_error_m[sensor.index()].abs() < limit_m
        };
        seen.filter(is_in_vain).count()
    }

    fn worst(&self) -> Consequence {
        if let Some(violation) = self.violations.first() {
            return Consequence::Violation(violation.invariant);
        }
        let late = match (self.clean.launched, self.faulty.launched) {
            (Some(_), None) => return Consequence::NoLaunch,
            (Some(clean), Some(faulty)) => faulty.saturating_sub(clean),
            _ => 0,
        };
        if late > 40 {
            return Consequence::LateLaunch(seconds(late));
        }
        if FREE.into_iter().any(|sensor| {
            self.faulty.flagged[sensor.index()].is_some() && self.clean.flagged[sensor.index()].is_none()
        }) {
            return Consequence::Flagged;
        }
        let unmonitored = FREE
            .into_iter()
            .map(|sensor| self.faulty.unmonitored(sensor).saturating_sub(self.clean.unmonitored(sensor)))
            .max()
            .unwrap_or(0);
        if unmonitored > 0 {
            return Consequence::Unmonitored(seconds(unmonitored));
        }
        let from = self.case.faults.iter().map(|fault| fault.from).min().unwrap_or(0);
        let end = self.faulty.ticks.len().min(self.clean.ticks.len());
        let parted = if self.case.plan.separates { self.case.plan.separation() } else { end };
        let silent = (0..=REFERENCE)
            .map(|source| {
                let until = if source == Sensor::ImuMaster.index() { parted } else { end };
                if from >= until {
                    return 0;
                }
                let usual = self.clean.longest_gap(source, from, until);
                self.faulty.longest_gap(source, from, until).saturating_sub(usual)
            })
            .max()
            .unwrap_or(0);
        if silent > 10 {
            return Consequence::Silent(seconds(silent));
        }
        if Self::is_degraded(self.faulty) && !Self::is_degraded(self.clean) {
            return Consequence::Degraded;
        }
        Consequence::None
    }
}

#[cfg(test)]
mod tests;
