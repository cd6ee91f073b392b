//! One mission, tick by tick: settling, calibration, latch, monitoring.

use serde::{Deserialize, Serialize};

use crate::atmosphere::pressure_altitude_m;
use crate::calibration::{Calibration, CaptiveStep, StatisticalChecks, Surprise};
use crate::config::{MAX_ESTIMATED_EFFECTS, MissionConfig};
use crate::cross_check::CrossCheck;
use crate::effect::{EffectSubject, Formulas, SignalTracker};
use crate::error::FilterError;
use crate::estimator::ConfigError;
use crate::free_flight::FreeFlight;
use crate::guard::Guard;
use crate::input::{BaroReading, GpsFix, LaunchDoubt, TickInput};
use crate::latch::LatchRecord;
use crate::output::{CrossCheckOutput, Phase, Rejection, SensorOutput, TickOutput, Trust};
use crate::plausible;
use crate::quality::{Check, FailedChecks};
use crate::reading::{StuckDetector, is_held};
use crate::reference::{AcceptedFix, ReferenceTracker};
use crate::sensor::{SENSORS, Sensor};
use crate::time::microseconds;

use calibrated::Calibrated;
use effects::{EffectUse, effect_sum};
use latching::{Decision, Latching, TakenBack};

/// How many of a source's readings were used, and why the others were not.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct SourceCounters {
    /// Readings that were finite, new and moving.
    pub accepted: u32,
    /// NaN or infinite, or an invalid pressure.
    pub not_finite: u32,
    /// Fixes that repeat the last one: held.
    pub held: u32,
    /// Readings of a stuck sensor.
    pub stuck: u32,
    /// Updates that the filter refused.
    pub variance: u32,
    /// Outliers: too far from the filter's prediction; in free flight, fixes that the receiver's own climb
    /// rate contradicts.
    pub gated: u32,
    /// Finite, but no aircraft can be there or do that.
    pub implausible: u32,
}

impl SourceCounters {
    fn count(&mut self, rejection: Option<Rejection>) {
        let counter = match rejection {
            None => &mut self.accepted,
            Some(Rejection::NotFinite) => &mut self.not_finite,
            Some(Rejection::Held) => &mut self.held,
            Some(Rejection::Stuck) => &mut self.stuck,
            Some(Rejection::Variance) => &mut self.variance,
            Some(Rejection::Gated) => &mut self.gated,
            Some(Rejection::Implausible) => &mut self.implausible,
        };
        *counter = counter.saturating_add(1);
    }
}

/// All counters; nothing is left out of a computation without being counted here.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Counters {
    /// Ticks processed.
    pub ticks: u32,
    /// Ticks ignored because their time was not after the last tick's.
    pub out_of_order: u32,
    /// The reference.
    pub gps: SourceCounters,
    /// The sensors, in the order of [`Sensor`].
    pub sensors: [SourceCounters; SENSORS],
    /// Signals that were not finite, or that no aircraft can have.
    pub signals_not_finite: u32,
    /// Readings corrected without one of the model's effects because its signal was missing.
    pub effects_without_signal: u32,
    /// Ticks, summed over the effects by formula, at which an effect had no value although its signals were
    /// there: a division by zero, the root of a negative number, an overflow. The effect adds nothing at such
    /// a tick.
    pub effects_silent: u32,
    /// Readings and fixes that were corrected by an effect outside the range of the regressor in which its
    /// coefficient was learned.
    pub effects_extrapolated: u32,
    /// How often the launch discrete fell or rose again after launch.
    pub launch_repeats: u32,
    /// How often the mission continued from a snapshot.
    pub restarts: u32,
    /// Suspected launches that were withdrawn. Bounces of one separation, each within 20 ms of the one
    /// before, count as one.
    pub launch_suspicions: u32,
    /// Readings in free flight that were not judged because the reference may have caused their error.
    pub readings_unjudged: u32,
}

/// A mission from the first tick on. See the crate's documentation for `HEAD` and `TAIL`; `E` effects are
/// states.
#[derive(Clone, Debug)]
pub struct Mission<const HEAD: usize, const TAIL: usize, const E: usize> {
    config: MissionConfig<E>,
    phase: Phase,
    first_us: Option<u64>,
    last_us: u64,
    /// The launch discrete at the last tick.
    launch_was: bool,
    tracker: ReferenceTracker,
    signals: SignalTracker,
    formulas: Formulas,
    /// Regressors of the estimated effects on the reference, at the last fix.
    fix_regressors_m: [f32; E],
    /// The last fix that was an outlier: the next one may be the same fix, held.
    gated_fix: Option<GpsFix>,
    stuck: [StuckDetector; SENSORS],
    last_accepted_us: [Option<u64>; SENSORS],
    calibration: Calibration<HEAD, TAIL, E>,
    latching: Latching,
    free_flight: FreeFlight,
    cross_check: CrossCheck,
    /// Made by [`Self::resume`], with no tick since.
    is_resumed: bool,
    counters: Counters,
}

impl<const HEAD: usize, const TAIL: usize, const E: usize> Mission<HEAD, TAIL, E> {
    /// A mission before its first tick.
    ///
    /// # Errors
    /// [`ConfigError`].
    pub fn new(config: &MissionConfig<E>) -> Result<Self, ConfigError> {
        if E > MAX_ESTIMATED_EFFECTS {
            return Err(ConfigError::Shape);
        }
        check(config)?;
        if !Formulas::fit(config) {
            return Err(ConfigError::Shape);
        }
        let effects = config.estimated_effects.iter().chain(&config.constant_effects);
        Ok(Self {
            phase: Phase::Settling,
            first_us: None,
            last_us: 0,
            launch_was: false,
            tracker: ReferenceTracker::new(&config.reference),
            signals: SignalTracker::for_effects(effects.map(|effect| effect.id()), config.latitude_deg),
            formulas: Formulas::of(config),
            fix_regressors_m: [0.0; E],
            gated_fix: None,
            stuck: core::array::from_fn(|_| StuckDetector::default()),
            last_accepted_us: [None; SENSORS],
            calibration: Calibration::new(config)?,
            latching: Latching::START,
            free_flight: FreeFlight::new(config),
            cross_check: CrossCheck::new(microseconds(config.monitor.window_s)),
            is_resumed: false,
            counters: Counters::default(),
            config: config.clone(),
        })
    }

    /// The calibration as latched at launch, after launch.
    #[must_use]
    pub fn latch(&self) -> Option<&LatchRecord> {
        self.latching.record().filter(|_| self.latching.is_launched())
    }

    /// Time of the last tick processed, microseconds; 0 before the first.
    #[must_use]
    pub const fn last_us(&self) -> u64 {
        self.last_us
    }

    /// The counters.
    #[must_use]
    pub const fn counters(&self) -> &Counters {
        &self.counters
    }

    /// Processes one tick. Bad input is refused, counted and reported in the output; it never stops the
    /// mission.
    pub fn tick(&mut self, input: &TickInput) -> TickOutput {
        let time_us = input.time_us;
        if self.first_us.is_some() && time_us <= self.last_us {
            self.counters.out_of_order = self.counters.out_of_order.saturating_add(1);
            let mut output = self.output(time_us);
            output.out_of_order = true;
            return output;
        }
        self.counters.ticks = self.counters.ticks.saturating_add(1);
        let first_us = *self.first_us.get_or_insert(time_us);
        let bridged_us = self.bridge(time_us);
        self.last_us = time_us;

        let latched_now = self.follow_launch(input, time_us);
        if self.phase == Phase::Settling
            && !self.latching.is_held()
            && time_us.saturating_sub(first_us) >= microseconds(self.config.settling_s)
        {
            self.phase = Phase::Calibrating;
            self.signals.begin_calibration();
            self.formulas.begin_calibration();
        }

        let carried = if input.gps.is_some() { self.carried(time_us) } else { None };
        let (accepted, gps_rejection) = match input.gps.as_ref().map(|fix| self.take_fix(time_us, fix)) {
            None => (None, None),
            Some(Ok(accepted)) => (Some(accepted), None),
            Some(Err(rejection)) => (None, Some(rejection)),
        };
        let taken_fix = input.gps.as_ref().filter(|_| accepted.is_some());
        self.signals.take(input, taken_fix);
        let silent = self.formulas.take(&self.config, input, taken_fix, &self.signals);
        self.counters.effects_silent = self.counters.effects_silent.saturating_add(silent);
        self.counters.signals_not_finite = self.signals.refused();
        let mut use_of_effects = EffectUse::new(self.regressors());
        let regressors_m = use_of_effects.regressors_m();
        let fix = accepted.map(|accepted| self.correct_fix(accepted, &mut use_of_effects));
        let gps_rejection = gps_rejection.or(fix.and_then(|fix| self.check_fix(time_us, fix, carried)));
        if let (Latching::Captive { .. }, Some(fix)) = (&self.latching, &fix) {
            let has_settled = self.phase == Phase::Calibrating;
            self.calibration.follow_reference(&self.config, time_us, fix, &self.tracker, has_settled);
        }
        let reference_m = self.reference_m(time_us);
        let (readings_m, mut rejections) =
            self.take_readings(time_us, input, reference_m, &mut use_of_effects);
        self.count_effects(&use_of_effects);

        if let Some(AcceptedFix { interval_s: None, .. }) = accepted {
            self.latching.note_reacquired();
        }
        let step = if self.is_calibrating() {
            let fix = match fix {
                Some(fix) if self.latching.take_reacquired() => Some(AcceptedFix { interval_s: None, ..fix }),
                fix => fix,
            };
            let step =
                self.calibration.step(&self.config, time_us, fix, &self.tracker, &readings_m, &regressors_m);
            let is_new = input.signals.true_airspeed_mps.is_some() || input.gps.is_some();
            if let (true, Some(squared)) = (is_new, self.signals.airspeed_squared_m2ps2()) {
                self.calibration.note_airspeed(time_us, squared);
            }
            step
        } else {
            CaptiveStep::default()
        };

        let mut output = self.output(time_us);
        output.latched_now = latched_now;
        output.bridged_us = bridged_us;
        output.extrapolated = use_of_effects.extrapolated();
        let reference = split(step.reference);
        output.gps_rejection = gps_rejection.or(reference.1);
        output.gps_innovation_m = reference.0.map(|surprise| surprise.innovation_m);
        output.gps_signed_nis = reference.0.map(|surprise| surprise.signed_nis);
        if input.gps.is_some() {
            self.counters.gps.count(output.gps_rejection);
        }
        // Again: the coefficients of effects on the reference may just have changed.
        let reference_m = if E == 0 { reference_m } else { self.reference_m(time_us) };
        let coefficients = self.coefficients();
        for sensor in Sensor::ALL {
            let i = sensor.index();
            let (surprise, refused) = split(step.sensors[i]);
            rejections[i] = rejections[i].or(refused);
            if readings_m[i].is_some() || rejections[i].is_some() {
                self.counters.sensors[i].count(rejections[i]);
                if rejections[i].is_none() {
                    self.last_accepted_us[i] = Some(time_us);
                }
            }
            let out = &mut output.sensors[i];
            out.rejection = rejections[i];
            out.innovation_m = surprise.map(|surprise| surprise.innovation_m);
            out.signed_nis = surprise.map(|surprise| surprise.signed_nis);
            // Outliers do not count towards the residual's spread.
            let is_residual =
                refused.is_none() || (refused == Some(Rejection::Gated) && !Guard::RobustSigma.stands());
            if let (Some(reading_m), true) = (readings_m[i], is_residual) {
                let subject = EffectSubject::Sensor(sensor);
                let effects_m = effect_sum(self.calibration.acting(), subject, &coefficients, &regressors_m);
                match reference_m {
                    Some(reference_m)
                        if self.watch(sensor, time_us, reading_m - effects_m - reference_m, out) => {}
                    _ => {
                        let said = self.check_each_other(sensor, time_us, reading_m - effects_m);
                        output.cross_check =
                            said.filter(|_| self.latching.is_launched()).or(output.cross_check);
                    }
                }
            }
            if self.latching.is_launched() {
                let has_standard = reference_m.is_some() && self.has_standard();
                out.trust = self.free_flight.trust(sensor, time_us, has_standard);
            }
        }
        output
    }

    /// Whether the calibration is good enough to trust a sensor by. If the reference had left its own climb
    /// rate, a source had settled on another level, and too many innovations were outliers, then biases and
    /// alarm limits mix both levels, and none of their variances covers the difference. An error beyond such
    /// a limit is still flagged. If only the last of the three did not fail, the levels are those of the
    /// settling time and of the calibration, and the calibration then has a single level.
    #[inline]
    fn has_standard(&self) -> bool {
        const OF_TWO_LEVELS: u16 = 1 << Check::ReferenceConverged as u16
            | 1 << Check::ReadingsConsistent as u16
            | 1 << Check::InnovationsPlausible as u16;
        !self.config.monitor.reference_check
            || self.latching.record().is_none_or(|latch| latch.failed_checks & OF_TWO_LEVELS != OF_TWO_LEVELS)
    }

    /// Whether the filter takes data.
    fn is_calibrating(&self) -> bool {
        self.phase == Phase::Calibrating && !self.latching.is_held()
    }

    /// Takes a fix if it is a measurement and not an outlier.
    #[inline]
    fn take_fix(&mut self, time_us: u64, fix: &GpsFix) -> Result<AcceptedFix, Rejection> {
        if let Err(rejection) = self.tracker.check(fix) {
            self.note_implausible(None, rejection);
            return Err(rejection);
        }
        if self.is_calibrating() {
            if self.gated_fix.as_ref().is_some_and(|gated| is_held(fix, gated)) {
                return Err(Rejection::Held);
            }
            let effects = self.effects_on_fix();
            if !self.calibration.admits(&self.config, time_us, fix, &self.tracker, effects) {
                self.gated_fix = Some(*fix);
                return Err(Rejection::Gated);
            }
            if !self.calibration.has_altitude() {
                // The fix from which heights are counted may have been an outlier.
                self.signals.begin_calibration();
                self.formulas.begin_calibration();
            }
        }
        Ok(self.tracker.accept(time_us, fix))
    }

    /// Counts an implausible value of a source in captive flight.
    fn note_implausible(&mut self, source: Option<Sensor>, rejection: Rejection) {
        if rejection == Rejection::Implausible && self.is_calibrating() {
            self.calibration.note_implausible(source);
        }
    }

    /// Follows the launch discrete and the suspicion of a launch; true at the tick at which the calibration
    /// is latched.
    fn follow_launch(&mut self, input: &TickInput, time_us: u64) -> bool {
        let launch = input.launch;
        let changed = launch != self.launch_was;
        self.launch_was = launch;
        let is_suspected = input.launch_doubt == LaunchDoubt::Suspected;
        match &self.latching {
            Latching::Latched { decision: Decision::Launched, .. } => {
                if changed {
                    self.counters.launch_repeats = self.counters.launch_repeats.saturating_add(1);
                }
                return false;
            }
            Latching::Captive { .. } if !launch && !is_suspected => return false,
            Latching::Captive { .. } => self.hold(time_us),
            Latching::Latched { decision: Decision::Suspected { .. }, .. } if !launch && !is_suspected => {
                self.take_back(time_us);
                return false;
            }
            Latching::Latched { decision: Decision::Suspected { .. }, .. } => _ = self.check_held(),
        }
        if launch {
            self.confirm(input.launch_doubt);
        }
        launch
    }

    /// Withdraws a suspicion: captive flight continues.
    fn take_back(&mut self, time_us: u64) {
        // With the coefficients that are held: after a restart the filter has none.
        self.resume_reference();
        let Latching::Latched { record, decision: Decision::Suspected { has_reacquired, .. } } =
            &self.latching
        else {
            return;
        };
        let taken_back = Some(TakenBack::now(time_us, record));
        self.latching = Latching::Captive { taken_back, has_reacquired: *has_reacquired };
        self.signals.resume_captive();
        self.formulas.resume_captive();
        self.counters.launch_suspicions = self.counters.launch_suspicions.saturating_add(1);
    }

    /// Turns the held calibration into the latch.
    fn confirm(&mut self, doubt: LaunchDoubt) {
        while self.check_held() {}
        self.phase = Phase::FreeFlight;
        if let Latching::Latched { record, decision } = &mut self.latching {
            *decision = Decision::Launched;
            let mut failed = FailedChecks::from_bits(record.failed_checks);
            failed.note(Check::LaunchConfirmed, doubt != LaunchDoubt::Unconfirmed);
            record.failed_checks = failed.bits();
        }
    }

    /// Copies the calibration at the first edge and begins monitoring.
    fn hold(&mut self, time_us: u64) {
        // Contacts bounce when they part. All bounces are one suspicion, so that the calibration held at one
        // bounce stays valid until that of the next one is stored.
        if self.latching.bounce(time_us).is_some() {
            self.counters.launch_suspicions = self.counters.launch_suspicions.saturating_sub(1);
        }
        let mut delivering = false;
        let mut silent = false;
        let mut faults = self.counters.out_of_order > 0
            || self.counters.gps.not_finite > 0
            || self.counters.signals_not_finite > 0;
        for sensor in Sensor::ALL {
            let i = sensor.index();
            let counters = &self.counters.sensors[i];
            faults |= counters.not_finite > 0 || counters.variance > 0;
            silent |= counters.stuck > 0;
            if let (true, Some(last_us)) = (sensor.flies_free(), self.last_accepted_us[i]) {
                let is_recent =
                    time_us.saturating_sub(last_us) <= microseconds(self.config.reference.lost_after_s);
                delivering |= is_recent;
                silent |= !is_recent;
            }
        }
        let mut latch = self.calibration.latch(
            &self.config,
            time_us,
            &self.tracker,
            self.phase == Phase::Calibrating,
            !faults,
            delivering && !silent,
        );
        let left_m = self.calibration.reference_drift_m(&self.tracker);
        self.free_flight.begin(&self.config, &latch, left_m);
        self.cross_check.begin(&latch);
        let mut failed = FailedChecks::from_bits(latch.failed_checks);
        let unchecked = StatisticalChecks::begin(&self.config, latch.duration_s, &self.tracker, &mut failed);
        latch.failed_checks = failed.bits();
        let has_reacquired = matches!(self.latching, Latching::Captive { has_reacquired: true, .. });
        let decision = Decision::Suspected { unchecked: Some(unchecked), has_reacquired };
        self.latching = Latching::Latched { record: latch, decision };
        self.signals.begin_free_flight(time_us);
    }

    /// Evaluates a part of the checks that a held calibration still lacks; true if more remain. This ends,
    /// because each part is evaluated once.
    fn check_held(&mut self) -> bool {
        let Latching::Latched { record, decision: Decision::Suspected { unchecked, .. } } =
            &mut self.latching
        else {
            return false;
        };
        let Some(checks) = unchecked else { return false };
        let mut failed = FailedChecks::from_bits(record.failed_checks);
        let is_done = checks.evaluate_next(&self.config, &self.calibration, &mut failed);
        record.failed_checks = failed.bits();
        if is_done {
            *unchecked = None;
        }
        !is_done
    }

    /// The readings that are measurements, free of constant effects, and why the others were refused.
    fn take_readings(
        &mut self,
        time_us: u64,
        input: &TickInput,
        reference_m: Option<f32>,
        use_of_effects: &mut EffectUse<E>,
    ) -> ([Option<f32>; SENSORS], [Option<Rejection>; SENSORS]) {
        let baro_m = input.baro.map(|reading| match reading {
            BaroReading::PressurePa(pressure_pa) => pressure_altitude_m(pressure_pa).unwrap_or(f32::NAN),
            BaroReading::AltitudeM(altitude_m) => altitude_m,
        });
        let raw_m = [input.imu_master_altitude_m, input.imu_slave_altitude_m, baro_m];
        let mut readings_m = [None; SENSORS];
        let mut rejections = [None; SENSORS];
        for sensor in Sensor::ALL {
            let i = sensor.index();
            let Some(raw_m) = raw_m[i] else { continue };
            if let Some(rejection) = plausible::altitude(raw_m) {
                rejections[i] = Some(rejection);
                self.note_implausible(Some(sensor), rejection);
                continue;
            }
            let sigma_m = self.config.sensors[i].sigma_m;
            let reference_sigma_m = self.config.reference.sigma_m;
            if self.stuck[i].is_stuck(time_us, raw_m, reference_m, sigma_m, reference_sigma_m) {
                rejections[i] = Some(Rejection::Stuck);
                continue;
            }
            let correction_m = self.correction_m(EffectSubject::Sensor(sensor), use_of_effects);
            readings_m[i] = Some(raw_m - correction_m);
        }
        (readings_m, rejections)
    }

    /// Eq. 16 for one sensor: `residual_m` is the reading less effects and reference. False if the error was
    /// not judged because the reference may have caused it.
    fn watch(&mut self, sensor: Sensor, time_us: u64, residual_m: f32, output: &mut SensorOutput) -> bool {
        match &self.latching {
            Latching::Latched { record: latch, decision } => {
                let error_m = residual_m - latch.sensors[sensor.index()].bias_m;
                let is_current = self.tracker.is_current(time_us);
                let watched = self.free_flight.take(sensor, time_us, error_m, is_current);
                match watched {
                    Some(watched) if matches!(decision, Decision::Launched) => {
                        output.error_m = Some(watched.error_m);
                        output.moving_average_m = watched.moving_average_m;
                    }
                    _ => output.error_m = error_m.is_finite().then_some(error_m),
                }
                if watched.is_some_and(|watched| watched.moving_average_m.is_none()) {
                    self.counters.readings_unjudged = self.counters.readings_unjudged.saturating_add(1);
                    return false;
                }
            }
            Latching::Captive { .. } => {
                let error_m = residual_m - output.bias_m;
                output.error_m = error_m.is_finite().then_some(error_m);
                if !residual_m.is_finite() {
                    return true;
                }
                if self.phase == Phase::Calibrating {
                    self.calibration.note_residual(time_us, sensor, residual_m);
                } else if self.tracker.last_fix().is_some_and(|fix| self.config.quality.accepts(fix)) {
                    self.calibration.note_settling(&self.config, sensor, residual_m);
                }
            }
        }
        true
    }

    /// Eq. 16 without a credible reference: `altitude_m` is the reading less effects.
    #[cold]
    fn check_each_other(
        &mut self,
        sensor: Sensor,
        time_us: u64,
        altitude_m: f32,
    ) -> Option<CrossCheckOutput> {
        let bias_m = self.latching.record()?.sensors.get(sensor.index())?.bias_m;
        self.cross_check.take(sensor, time_us, altitude_m - bias_m)
    }

    /// The coefficients: the latched ones, or the current ones before a latch.
    #[inline]
    fn coefficients(&self) -> [f32; E] {
        match self.latching.record() {
            Some(latch) => core::array::from_fn(|effect| latch.coefficient(effect)),
            None => self.calibration.estimator().coefficients(),
        }
    }

    /// The part of the output that does not depend on this tick's input.
    fn output(&self, time_us: u64) -> TickOutput {
        let has_standard = self.tracker.is_fresh(time_us) && self.has_standard();
        // A latched calibration is read from the latch, whether or not the filter that made it still exists.
        let calibrated = match self.latching.record() {
            Some(latch) => Calibrated::of_latch(latch),
            None => Calibrated::of_estimator(self.calibration.estimator()),
        };
        let nothing_new = |sensor: Sensor, [bias_m, bias_variance_m2]: [f32; 2]| SensorOutput {
            bias_m,
            bias_variance_m2,
            innovation_m: None,
            signed_nis: None,
            error_m: None,
            moving_average_m: None,
            trust: if self.latching.is_launched() {
                self.free_flight.trust(sensor, time_us, has_standard)
            } else {
                Trust::Calibrating
            },
            rejection: None,
        };
        // One by one: `map` on the array moves each of them through memory twice.
        let [master, slave, baro] = Sensor::ALL;
        let [of_master, of_slave, of_baro] = calibrated.biases;
        let sensors =
            [nothing_new(master, of_master), nothing_new(slave, of_slave), nothing_new(baro, of_baro)];
        TickOutput {
            time_us,
            out_of_order: false,
            phase: self.phase,
            latched_now: false,
            failed_checks: self.latch().map_or(0, |latch| latch.failed_checks),
            altitude_m: calibrated.altitude_m,
            altitude_variance_m2: calibrated.altitude_variance_m2,
            gps_innovation_m: None,
            gps_signed_nis: None,
            gps_rejection: None,
            sensors,
            extrapolated: 0,
            cross_check: None,
            bridged_us: None,
            coefficients: calibrated.coefficients,
        }
    }
}

fn split(result: Option<Result<Surprise, FilterError>>) -> (Option<Surprise>, Option<Rejection>) {
    match result {
        None => (None, None),
        Some(Ok(surprise)) => (Some(surprise), None),
        Some(Err(FilterError::Gated { .. })) => (None, Some(Rejection::Gated)),
        Some(Err(_)) => (None, Some(Rejection::Variance)),
    }
}

/// Checks the ranges that the rest relies on; sigmas and priors are checked where the filter is made.
fn check<const E: usize>(config: &MissionConfig<E>) -> Result<(), ConfigError> {
    let not_negative = |x: f32| x.is_finite() && x >= 0.0;
    let positive = |x: f32| x.is_finite() && x > 0.0;
    let monitor = &config.monitor;
    let climb = config.reference.climb_rate;
    let effects = config.estimated_effects.iter().chain(&config.constant_effects);
    let correction_is_valid = match config.second_correction {
        crate::config::SecondCorrection::Kalman { wander_m_per_sqrt_s } => not_negative(wander_m_per_sqrt_s),
        _ => true,
    };
    let is_valid = not_negative(config.settling_s)
        && positive(config.reference.lost_after_s)
        && climb.is_none_or(|c| positive(c.sigma_mps) && positive(c.correlation_time_s))
        && positive(monitor.multiplier)
        && positive(monitor.window_s)
        && not_negative(monitor.persistence_s)
        && correction_is_valid
        && config.sensors.iter().all(|sensor| not_negative(sensor.wander_m_per_sqrt_s))
        && (-90.0..=90.0).contains(&config.latitude_deg)
        && effects.into_iter().all(|effect| {
            effect.coefficient.is_finite()
                && not_negative(effect.sigma)
                && (!effect.id().has_time_constant() || positive(effect.regressor.time_constant_s))
                && effect.envelope_m.is_none_or(|[least, largest]| least <= largest)
        });
    if is_valid { Ok(()) } else { Err(ConfigError::OutOfRange) }
}

mod calibrated;
mod effects;
mod latching;
mod reference;
mod resume;
#[cfg(test)]
mod tests;
