//! Captive flight: estimates the biases, and gathers what their quality is judged by.

use crate::block_statistics::BlockStatistics;
use crate::config::{ClimbRate, MissionConfig, SigmaSource};
use crate::effect::{ActingEffects, EffectSubject};
use crate::error::FilterError;
use crate::estimator::{ConfigError, Estimator, MeasurementNoise};
use crate::gauss_markov::mean_variance_factor;
use crate::guard::Guard;
use crate::input::GpsFix;
use crate::latch::{LatchRecord, SensorLatch, collected};
use crate::quality::{Check, FailedChecks};
use crate::reference::{AcceptedFix, ReferenceTracker};
use crate::sensor::{SENSORS, Sensor};
use crate::time::seconds_between;
use crate::ud::Innovation;

pub(crate) use statistical_checks::StatisticalChecks;

use gate::{GATE_SIGMAS, Outcome, SourceGate};
use reference_level::ReferenceLevel;
use settling::SettlingLevel;

/// Error of an unmeasured climb rate (1 sigma, m/s): the altitude may then do whatever an aircraft can do.
const UNKNOWN_CLIMB_RATE_MPS: f32 = 10.0;
/// An innovation beyond this many sigmas is implausible.
const IMPLAUSIBLE_SIGMAS: f32 = 3.0;
/// Uncertainty of a level that was given up (1 sigma), metres: unknown within [`crate::plausible::altitude`].
/// With a smaller value, the altitude would have to absorb part of the step.
const UNKNOWN_LEVEL_M: f32 = 1e5;
/// Fastest change of a mother ship's vertical speed, m/s^2: a load factor of 0 or 2. A larger limit would let
/// a climb rate that is wrong for half a second carry the altitude away.
const FASTEST_CHANGE_MPS2: f32 = 10.0;

/// An innovation in metres, and its NIS with the innovation's sign.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Surprise {
    pub innovation_m: f32,
    pub signed_nis: f32,
}

/// Noise of a source whose error may be correlated in time.
#[derive(Clone, Copy, Debug, PartialEq)]
struct SourceNoise {
    single: MeasurementNoise,
    /// `2 sigma^2 tau`: spectral density at zero frequency of a first-order Gauss-Markov error, m^2 s.
    density_m2_s: f32,
}

impl SourceNoise {
    fn new(sigma_m: f32, correlation_time_s: f32) -> Result<Self, FilterError> {
        let variance_m2 = sigma_m * sigma_m;
        let density_m2_s = 2.0 * variance_m2 * correlation_time_s;
        if !density_m2_s.is_finite() {
            return Err(FilterError::NotFinite);
        }
        if density_m2_s < 0.0 {
            return Err(FilterError::NotPositive);
        }
        Ok(Self { single: MeasurementNoise::from_variance_m2(variance_m2)?, density_m2_s })
    }

    /// White noise that carries the same information over many correlation times, for a measurement
    /// `interval_s` after the previous one; the first one counts in full. `excess` is the ratio of the
    /// source's variance to the model's.
    #[inline(always)]
    fn equivalent(&self, interval_s: Option<f32>, excess: f32) -> MeasurementNoise {
        let variance_m2 = match interval_s {
            Some(interval_s) if self.density_m2_s > interval_s * self.single.variance_m2() => {
                self.density_m2_s / interval_s
            }
            _ if excess == 1.0 => return self.single,
            _ => self.single.variance_m2(),
        };
        MeasurementNoise::from_variance_m2(variance_m2 * excess).unwrap_or(self.single)
    }

    /// Judges the innovation of one measurement by the error of one measurement, not by the equivalent white
    /// noise that the gain is computed with.
    #[inline(always)]
    fn surprise(&self, innovation: Innovation, used: MeasurementNoise) -> Surprise {
        const UNIT: f32 = crate::estimator::UNIT_M;
        let innovation_m = innovation.value * UNIT;
        let (used_m2, single_m2) = (used.variance_m2(), self.single.variance_m2());
        let variance_m2 = if used_m2 == single_m2 {
            innovation.variance * (UNIT * UNIT)
        } else {
            innovation.variance * (UNIT * UNIT) - used_m2 + single_m2
        };
        Surprise { innovation_m, signed_nis: innovation_m * innovation_m.abs() / variance_m2 }
    }
}

/// What one tick of captive flight found.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct CaptiveStep {
    pub reference: Option<Result<Surprise, FilterError>>,
    pub sensors: [Option<Result<Surprise, FilterError>>; SENSORS],
}

/// The calibration in progress.
#[derive(Clone, Debug)]
pub(crate) struct Calibration<const HEAD: usize, const TAIL: usize, const E: usize> {
    estimator: Estimator<HEAD, TAIL, E>,
    acting: ActingEffects,
    /// The altitude has a prior: from the configuration, or the first fix.
    has_altitude: bool,
    /// A fix has been used.
    has_fix: bool,
    reference_noise: SourceNoise,
    sensor_noise: [SourceNoise; SENSORS],
    reference_gate: SourceGate,
    sensor_gates: [SourceGate; SENSORS],
    /// The reference's level was given up: the next fix sets a new one.
    reference_is_void: bool,
    start_us: Option<u64>,
    propagated_us: u64,
    last_reading_us: [Option<u64>; SENSORS],
    residuals: [BlockStatistics; SENSORS],
    altitude: BlockStatistics,
    airspeed_squared: BlockStatistics,
    reference_drift: BlockStatistics,
    reference_level: ReferenceLevel,
    settling: [SettlingLevel; SENSORS],
    /// Index of the series to be tidied next.
    turn: u8,
    innovations: u32,
    implausible: u32,
    reference_was_lost: bool,
    /// Square of the last airspeed, (m/s)^2.
    last_airspeed_squared_m2ps2: f32,
}

impl<const HEAD: usize, const TAIL: usize, const E: usize> Calibration<HEAD, TAIL, E> {
    pub(crate) fn new(config: &MissionConfig<E>) -> Result<Self, ConfigError> {
        let reference = &config.reference;
        if HEAD > 0 && reference.climb_rate.is_some() {
            return Err(ConfigError::ClimbRateNeedsDenseFilter);
        }
        let mut sensor_noise = [SourceNoise::new(1.0, 0.0)?; SENSORS];
        for (noise, sensor) in sensor_noise.iter_mut().zip(&config.sensors) {
            *noise = SourceNoise::new(sensor.sigma_m, sensor.correlation_time_s)?;
        }
        Ok(Self {
            estimator: Estimator::new(config, reference.prior_altitude_m.unwrap_or(0.0))?,
            acting: ActingEffects::of(config),
            has_altitude: reference.prior_altitude_m.is_some(),
            has_fix: false,
            reference_noise: SourceNoise::new(reference.sigma_m, reference.correlation_time_s)?,
            sensor_noise,
            reference_gate: SourceGate::NEW,
            sensor_gates: [SourceGate::NEW; SENSORS],
            reference_is_void: false,
            start_us: None,
            propagated_us: 0,
            last_reading_us: [None; SENSORS],
            residuals: [const { BlockStatistics::EMPTY }; SENSORS],
            altitude: BlockStatistics::EMPTY,
            airspeed_squared: BlockStatistics::EMPTY,
            reference_drift: BlockStatistics::EMPTY,
            reference_level: ReferenceLevel::NEW,
            settling: [SettlingLevel::NEW; SENSORS],
            turn: 0,
            innovations: 0,
            implausible: 0,
            reference_was_lost: false,
            last_airspeed_squared_m2ps2: 0.0,
        })
    }

    /// Starts again with the next fix: the fix that everything so far was measured against was an outlier.
    #[cold]
    #[inline(never)]
    fn restart(&mut self, time_us: u64) {
        self.has_altitude = false;
        self.has_fix = false;
        self.start_us = Some(time_us);
        self.last_reading_us = [None; SENSORS];
        self.sensor_gates = [SourceGate::NEW; SENSORS];
        for residuals in &mut self.residuals {
            *residuals = BlockStatistics::EMPTY;
        }
        self.altitude = BlockStatistics::EMPTY;
        self.airspeed_squared = BlockStatistics::EMPTY;
        self.reference_drift = BlockStatistics::EMPTY;
        self.reference_level.forget(false);
        self.stagger();
    }

    /// Whether the filter takes that fix: false for an outlier. Call it before anything else uses the fix:
    /// the tracker, the signals and every residual depend on the fixes. Effects on the reference are as at
    /// the last fix, metres and square metres.
    pub(crate) fn admits(
        &mut self,
        config: &MissionConfig<E>,
        time_us: u64,
        fix: &GpsFix,
        tracker: &ReferenceTracker,
        (effects_m, effects_variance_m2): (f32, f32),
    ) -> bool {
        if !self.has_altitude || !gate::stands() {
            return true;
        }
        let expected_m = self.estimator.altitude_m() + effects_m;
        let mut variance_m2 = self.estimator.altitude_variance_m2()
            + self.reference_noise.single.variance_m2()
            + effects_variance_m2;
        let mut climbed_m = 0.0;
        let mut is_smooth = true;
        let mut limit = self.reference_gate.limit();
        if let Some(climb) = &config.reference.climb_rate {
            if tracker.is_fresh(time_us) {
                let seconds = seconds_between(self.propagated_us, time_us);
                let (climb_m, climb_variance_m2) = climb_over(climb, tracker, seconds);
                climbed_m = climb_m;
                variance_m2 += climb_variance_m2;
                if let (Some(last_mps), Some(down_mps)) = (tracker.climb_rate_mps(), fix.velocity_down_mps) {
                    // Errors of both fixes, and what the aircraft may have done between them.
                    let since_fix_s = seconds_between(tracker.last_fix_us(), time_us);
                    let tolerated_mps =
                        FASTEST_CHANGE_MPS2 * since_fix_s + 2.0 * GATE_SIGMAS * climb.sigma_mps;
                    is_smooth = (last_mps + down_mps).abs() <= tolerated_mps;
                }
            } else {
                // A fix beyond even that is on another level, however noisy the receiver was before it was
                // lost.
                variance_m2 += square(config.reference.prior_sigma_m);
                limit = square(GATE_SIGMAS);
                self.reference_gate.restart();
            }
        }
        let innovation_m = fix.altitude_m - expected_m - climbed_m;
        if is_smooth && square(innovation_m) <= limit * variance_m2 {
            return true;
        }
        self.innovations = self.innovations.saturating_add(1);
        self.implausible = self.implausible.saturating_add(1);
        let was_established = self.reference_gate.is_established();
        if self.reference_gate.refuse(time_us, innovation_m > 0.0) == Outcome::Outlier {
            return false;
        }
        // A filter that claims a constant altitude cannot let it move, so it starts again as well.
        if was_established && HEAD == 0 {
            self.reference_is_void = true;
        } else {
            if !was_established {
                self.reference_gate = SourceGate::NEW;
            }
            self.restart(time_us);
        }
        true
    }

    /// Tidies one series a tick, so that no tick does more of the outstanding work.
    #[inline(never)]
    fn tidy(&mut self) {
        let sensors = self.residuals.len();
        let turn = usize::from(self.turn);
        let series = match turn.checked_sub(sensors) {
            None => self.residuals.get_mut(turn),
            Some(0) => Some(&mut self.altitude),
            Some(1) => Some(&mut self.airspeed_squared),
            Some(_) => Some(&mut self.reference_drift),
        };
        if let Some(series) = series {
            series.tidy();
        }
        self.turn = if turn > sensors + 1 { 0 } else { self.turn + 1 };
    }

    /// Staggers the series, so that no two of them run out of blocks in the same tick.
    fn stagger(&mut self) {
        let others = [&mut self.altitude, &mut self.airspeed_squared, &mut self.reference_drift];
        for (place, statistics) in (0..).zip(self.residuals.iter_mut().chain(others)) {
            statistics.stagger(place);
        }
    }

    /// Whether there is an altitude to start from: a fix, or the configuration's.
    pub(crate) const fn has_altitude(&self) -> bool {
        self.has_altitude
    }

    pub(crate) const fn acting(&self) -> &ActingEffects {
        &self.acting
    }

    pub(crate) const fn estimator(&self) -> &Estimator<HEAD, TAIL, E> {
        &self.estimator
    }

    /// Takes one tick of captive flight. `readings_m` are finite and free of constant effects.
    #[inline]
    pub(crate) fn step(
        &mut self,
        config: &MissionConfig<E>,
        time_us: u64,
        fix: Option<AcceptedFix>,
        tracker: &ReferenceTracker,
        readings_m: &[Option<f32>; SENSORS],
        regressors_m: &[f32; E],
    ) -> CaptiveStep {
        let mut step = CaptiveStep::default();
        if self.start_us.is_none() {
            self.start_us = Some(time_us);
            self.propagated_us = time_us;
            self.stagger();
        }
        self.tidy();
        if !tracker.is_fresh(time_us) {
            self.reference_was_lost |= self.has_altitude && tracker.last_fix().is_some();
            return step;
        }
        if fix.is_none() && readings_m.iter().all(Option::is_none) {
            return step;
        }
        let is_void = fix.is_some() && core::mem::take(&mut self.reference_is_void);
        // The first fix used has no previous one, whatever the settling time has seen; nor has a fix that
        // overturns those before it.
        let fix = fix.map(|fix| match self.has_fix && !is_void {
            true => fix,
            false => AcceptedFix { interval_s: None, ..fix },
        });
        if let Some(fix) = fix {
            if !self.has_altitude {
                self.has_altitude = true;
                // The configuration has already made an estimator once; a finite altitude cannot
                // make it fail.
                if let Ok(estimator) = Estimator::new(config, fix.altitude_m) {
                    self.estimator = estimator;
                }
            }
            self.altitude.add(time_us, fix.altitude_m);
            if let Some(difference_m) = fix.altitude_minus_climb_m {
                self.reference_drift.add(time_us, difference_m);
            }
        }
        if !self.has_altitude {
            return step;
        }
        let was_lost = self.has_fix && fix.is_some_and(|fix| fix.interval_s.is_none());
        self.has_fix |= fix.is_some();
        if is_void {
            // Cannot fail: the variance is a constant, and the shape has been checked.
            let _ = self.estimator.climb(0.0, square(UNKNOWN_LEVEL_M));
        }
        if self.propagate(config, time_us, tracker, was_lost).is_err() {
            step.reference = Some(Err(FilterError::NotFinite));
            return step;
        }
        // With effects, the filter's state does not fit in the registers anyway: a second, unrolled copy of
        // every update would only waste flash.
        if let (0, Some(fix), &[Some(master), Some(slave), Some(baro)]) = (E, fix, readings_m) {
            let readings_m = [master, slave, baro];
            if let Some(step) = self.take_together(time_us, fix, &readings_m, regressors_m) {
                return step;
            }
        }
        if let Some(fix) = fix {
            let noise = self.reference_noise.equivalent(fix.interval_s, self.reference_gate.excess());
            let own_m = self.acting.own_regressors(EffectSubject::Gps, regressors_m);
            let result = self.estimator.update_reference(fix.altitude_m, &own_m, noise);
            let surprise = result.map(|innovation| self.reference_noise.surprise(innovation, noise));
            self.judge(surprise);
            if let Ok(surprise) = surprise {
                self.reference_gate.take(time_us, surprise.signed_nis.abs());
            }
            step.reference = Some(surprise);
        }
        step.sensors = [
            self.take_reading(Sensor::ImuMaster, time_us, readings_m, regressors_m),
            self.take_reading(Sensor::ImuSlave, time_us, readings_m, regressors_m),
            self.take_reading(Sensor::Baro, time_us, readings_m, regressors_m),
        ];
        self.estimator.fold();
        step
    }

    /// Takes a tick at which everything is new, all at once. `None` if any part was refused: nothing has then
    /// been taken, and each reading must be tried separately.
    #[inline(always)]
    fn take_together(
        &mut self,
        time_us: u64,
        fix: AcceptedFix,
        readings_m: &[f32; SENSORS],
        regressors_m: &[f32; E],
    ) -> Option<CaptiveStep> {
        if gate::stands() && self.sensor_gates.iter().any(SourceGate::is_on_probation) {
            return None;
        }
        let reference_noise = self.reference_noise.equivalent(fix.interval_s, self.reference_gate.excess());
        let noise = core::array::from_fn(|i| self.noise_now(i, time_us));
        let reference_m = self.acting.own_regressors(EffectSubject::Gps, regressors_m);
        let own_m =
            Sensor::ALL.map(|sensor| self.acting.own_regressors(EffectSubject::Sensor(sensor), regressors_m));
        let (gates, sources) = (&self.sensor_gates, &self.sensor_noise);
        let admits = |innovations: &[Innovation; SENSORS]| {
            !gate::stands()
                || (0..SENSORS).all(|i| {
                    noise[i].gate(gates[i].limit(), sources[i].single, false).admits(&innovations[i])
                })
        };
        let (reference, sensors) = self
            .estimator
            .update_together(
                fix.altitude_m,
                &reference_m,
                reference_noise,
                readings_m,
                &own_m,
                &noise,
                admits,
            )
            .ok()?;
        self.last_reading_us = [Some(time_us); SENSORS];
        let reference = Ok(self.reference_noise.surprise(reference, reference_noise));
        let sensors: [_; SENSORS] =
            core::array::from_fn(|i| Ok(self.sensor_noise[i].surprise(sensors[i], noise[i])));
        self.judge(reference);
        let gates = core::iter::once(&mut self.reference_gate).chain(&mut self.sensor_gates);
        for (gate, surprise) in gates.zip(core::iter::once(&reference).chain(&sensors)) {
            if let Ok(surprise) = surprise {
                gate.take(time_us, surprise.signed_nis.abs());
            }
        }
        for surprise in sensors {
            self.judge(surprise);
        }
        Some(CaptiveStep { reference: Some(reference), sensors: sensors.map(Some) })
    }

    /// Current noise of a sensor's reading. Inlined where the filter is small enough for that to pay; with
    /// effects, three copies would only waste flash.
    #[inline(always)]
    fn noise_now(&self, sensor: usize, time_us: u64) -> MeasurementNoise {
        if E == 0 { self.compute_noise(sensor, time_us) } else { self.compute_noise_once(sensor, time_us) }
    }

    #[inline(never)]
    fn compute_noise_once(&self, sensor: usize, time_us: u64) -> MeasurementNoise {
        self.compute_noise(sensor, time_us)
    }

    #[inline(always)]
    fn compute_noise(&self, sensor: usize, time_us: u64) -> MeasurementNoise {
        let last_us = self.last_reading_us.get(sensor).copied().flatten();
        let interval_s = last_us.map(|last_us| seconds_between(last_us, time_us));
        let excess = match self.sensor_gates.get(sensor) {
            Some(gate) if gate::stands() => gate.excess(),
            _ => 1.0,
        };
        // There is no other sensor, but an impossible case must not panic.
        self.sensor_noise.get(sensor).unwrap_or(&self.reference_noise).equivalent(interval_s, excess)
    }

    /// Applies eqs 4 and 5 up to now, where configured; `was_lost`: there was no reference until this tick's
    /// fix.
    #[inline]
    fn propagate(
        &mut self,
        config: &MissionConfig<E>,
        time_us: u64,
        tracker: &ReferenceTracker,
        was_lost: bool,
    ) -> Result<(), FilterError> {
        let seconds = seconds_between(self.propagated_us, time_us);
        self.propagated_us = time_us;
        if let Some(climb) = &config.reference.climb_rate {
            let (climb_m, variance_m2) = if was_lost {
                // In the meantime the altitude may have changed by any amount.
                (0.0, config.reference.prior_sigma_m * config.reference.prior_sigma_m)
            } else {
                climb_over(climb, tracker, seconds)
            };
            self.estimator.climb(climb_m, variance_m2)?;
        }
        for (sensor, config) in Sensor::ALL.into_iter().zip(&config.sensors) {
            if config.wander_m_per_sqrt_s > 0.0 {
                let variance_m2 = config.wander_m_per_sqrt_s * config.wander_m_per_sqrt_s * seconds;
                self.estimator.wander(sensor, variance_m2)?;
            }
        }
        Ok(())
    }

    // Unrolled for each sensor: its row is then a constant, and no bounds check is left.
    #[inline(always)]
    fn take_reading(
        &mut self,
        sensor: Sensor,
        time_us: u64,
        readings_m: &[Option<f32>; SENSORS],
        regressors_m: &[f32; E],
    ) -> Option<Result<Surprise, FilterError>> {
        let i = sensor.index();
        let reading_m = (*readings_m.get(i)?)?;
        let noise = self.noise_now(i, time_us);
        let own_m = self.acting.own_regressors(EffectSubject::Sensor(sensor), regressors_m);
        let (source, single) = (self.sensor_gates.get(i)?, self.sensor_noise.get(i)?);
        let gate =
            gate::stands().then(|| noise.gate(source.limit(), single.single, source.is_on_probation()));
        let result = self.estimator.update_sensor(sensor, reading_m, &own_m, noise, gate);
        let surprise = result.map(|innovation| single.surprise(innovation, noise));
        match surprise {
            Ok(surprise) => {
                let (gate, last_us) = (self.sensor_gates.get_mut(i)?, self.last_reading_us.get_mut(i)?);
                if !(gate::stands() && gate.is_on_probation()) {
                    *last_us = Some(time_us);
                }
                gate.take(time_us, surprise.signed_nis.abs());
            }
            Err(FilterError::Gated { above }) => self.refuse(sensor, time_us, above),
            Err(_) => {}
        }
        self.judge(surprise);
        Some(surprise)
    }

    /// Takes an outlier of a sensor. If it overturns the estimate, the next reading determines the bias
    /// again, and the statistics restart.
    #[cold]
    #[inline(never)]
    fn refuse(&mut self, sensor: Sensor, time_us: u64, above: bool) {
        let i = sensor.index();
        let Some(gate) = self.sensor_gates.get_mut(i) else { return };
        if gate.refuse(time_us, above) == Outcome::Outlier {
            return;
        }
        // Cannot fail: the variance is a constant.
        let _ = self.estimator.wander(sensor, square(UNKNOWN_LEVEL_M));
        if let (Some(last_us), Some(residuals)) = (self.last_reading_us.get_mut(i), self.residuals.get_mut(i))
        {
            *last_us = None;
            *residuals = BlockStatistics::EMPTY;
        }
    }

    /// Counts a reading that never reached the filter: a healthy source does not deliver such readings.
    pub(crate) fn note_implausible(&mut self, source: Option<Sensor>) {
        let gate = match source {
            Some(sensor) => self.sensor_gates.get_mut(sensor.index()),
            None => Some(&mut self.reference_gate),
        };
        if let Some(gate) = gate {
            gate.note_misfit();
        }
    }

    fn judge(&mut self, surprise: Result<Surprise, FilterError>) {
        let is_implausible = match surprise {
            Ok(surprise) => surprise.signed_nis.abs() > IMPLAUSIBLE_SIGMAS * IMPLAUSIBLE_SIGMAS,
            Err(FilterError::Gated { .. }) => true,
            Err(_) => return,
        };
        self.innovations = self.innovations.saturating_add(1);
        self.implausible = self.implausible.saturating_add(u32::from(is_implausible));
    }

    /// Takes a fix of captive flight. While the receiver settles, a fix that does not claim to be accurate
    /// may move the level.
    #[inline]
    pub(crate) fn follow_reference(
        &mut self,
        config: &MissionConfig<E>,
        time_us: u64,
        fix: &AcceptedFix,
        tracker: &ReferenceTracker,
        has_settled: bool,
    ) {
        let counts = has_settled || tracker.last_fix().is_some_and(|fix| config.quality.accepts(fix));
        let had_jumped = self.reference_level.has_jumped();
        // Everything is measured against the first fix's level. If it ends within the memory that it is
        // judged by, the calibration begins again. It was a false one if some fixes were off as the
        // calibration began; if it was that of the settling time, nothing shows which of the two is right.
        if has_settled && !self.has_fix {
            self.reference_level.restart();
        }
        let is_apart = self.reference_level.follow(&config.reference, fix, counts);
        let is_young = |start_us| seconds_between(start_us, time_us) < reference_level::BEFORE_S;
        if is_apart && self.start_us.is_some_and(is_young) {
            let has_jumped = had_jumped || !self.reference_level.leads_back();
            self.restart(time_us);
            self.reference_level.forget(has_jumped);
            self.reference_level.follow(&config.reference, fix, counts);
        }
    }

    /// Distance of the reference from its mean over the calibration, which the biases refer to, by its own
    /// climb rate, metres. Zero where no climb rate carries it.
    pub(crate) fn reference_drift_m(&self, tracker: &ReferenceTracker) -> f32 {
        match (tracker.altitude_minus_climb_m(), self.reference_drift.mean()) {
            (Some(now_m), Some(mean_m)) => now_m - mean_m,
            _ => 0.0,
        }
    }

    /// Notes a residual of the settling time, against a reference that is reported to be good.
    #[inline(never)]
    pub(crate) fn note_settling(&mut self, config: &MissionConfig<E>, sensor: Sensor, residual_m: f32) {
        let i = sensor.index();
        if let (Some(level), Some(sensor)) = (self.settling.get_mut(i), config.sensors.get(i)) {
            level.note(config, sensor, residual_m);
        }
    }

    /// Notes a calibrated residual that still contains the bias (which does not affect its spread).
    #[inline]
    pub(crate) fn note_residual(&mut self, time_us: u64, sensor: Sensor, residual_m: f32) {
        if let Some(statistics) = self.residuals.get_mut(sensor.index()) {
            statistics.add(time_us, residual_m);
        }
    }

    /// Notes the squared airspeed, (m/s)^2. A real airspeed does not double or halve between two samples
    /// (beyond 10 m/s, where gusts are smaller): a sample that does, and the one after it, are ignored.
    #[inline]
    pub(crate) fn note_airspeed(&mut self, time_us: u64, airspeed_squared_m2ps2: f32) {
        const SLACK_M2PS2: f32 = 100.0;
        let last_m2ps2 = core::mem::replace(&mut self.last_airspeed_squared_m2ps2, airspeed_squared_m2ps2);
        if !Guard::RobustSigma.stands()
            || (airspeed_squared_m2ps2 <= 4.0 * last_m2ps2 + SLACK_M2PS2
                && last_m2ps2 <= 4.0 * airspeed_squared_m2ps2 + SLACK_M2PS2)
        {
            self.airspeed_squared.add(time_us, airspeed_squared_m2ps2);
        }
    }

    /// Whether every source has been consistent, and every bias is within what its prior and the settling
    /// time allow.
    fn is_consistent(&self, config: &MissionConfig<E>, duration_s: f32) -> bool {
        let share = config.quality.implausible_share;
        let mut sensors =
            Sensor::ALL.into_iter().zip(&config.sensors).zip(&self.sensor_gates).zip(&self.settling);
        !gate::stands()
            || self.reference_gate.is_consistent(share)
                && sensors.all(|(((sensor, known), gate), settling)| {
                    let bias_m = self.estimator.bias_m(sensor);
                    let is_allowed =
                        square(bias_m - known.prior_bias_m) <= square(GATE_SIGMAS * known.prior_sigma_m);
                    gate.is_consistent(share)
                        && is_allowed
                        && settling.is_level_of(config, known, bias_m, duration_s)
                })
    }

    /// Copies the calibration at launch. Its failed checks exclude those of [`StatisticalChecks`].
    pub(crate) fn latch(
        &self,
        config: &MissionConfig<E>,
        time_us: u64,
        tracker: &ReferenceTracker,
        settled: bool,
        inputs_valid: bool,
        sensors_alive: bool,
    ) -> LatchRecord {
        let duration_s = self.start_us.map_or(0.0, |start_us| seconds_between(start_us, time_us));
        let unseen_m2 = square(config.reference.sigma_m)
            * mean_variance_factor(duration_s, config.reference.correlation_time_s);
        let mut are_credible = true;
        let mut sensors = [SensorLatch::default(); SENSORS];
        for ((latch, sensor), residuals) in sensors.iter_mut().zip(Sensor::ALL).zip(&self.residuals) {
            let summary = residuals.summary();
            let bias_variance_m2 = self.estimator.bias_variance_m2(sensor);
            let residual_variance_m2 = summary.map_or(0.0, |summary| summary.variance);
            let spread_m2 = residual_variance_m2 + 2.0 * unseen_m2;
            let variance_m2 = match config.monitor.sigma {
                SigmaSource::Residual => spread_m2,
                SigmaSource::Covariance => bias_variance_m2,
                SigmaSource::Datasheet => square(config.sensors[sensor.index()].sigma_m),
            };
            // A residual spread ten times the model's does not belong to that sensor: a bound computed from
            // it would call anything trusted.
            let modelled_m2 =
                square(config.sensors[sensor.index()].sigma_m) + square(config.reference.sigma_m);
            let bias_m = self.estimator.bias_m(sensor);
            let multiplier2 = square(config.monitor.multiplier);
            // If its readings were, on average, further from the bias than their spread allows, the reference
            // was on another level when the bias was estimated.
            let is_its_own = residual_variance_m2 <= gate::LARGEST_SPREAD * modelled_m2
                && summary.is_none_or(|summary| square(summary.mean - bias_m) <= multiplier2 * spread_m2);
            are_credible &= is_its_own;
            let calibrated =
                summary.is_some() && (is_its_own || config.monitor.sigma != SigmaSource::Residual);
            *latch = SensorLatch {
                bias_m,
                bias_variance_m2,
                readings: summary.map_or(0, |summary| summary.count),
                residual_variance_m2,
                mean_variance_m2: summary.map_or(0.0, |summary| summary.mean_variance),
                bound_m2: if calibrated { multiplier2 * variance_m2 } else { 0.0 },
            };
        }
        let mut failed = FailedChecks::default();
        failed.note(Check::Settled, settled);
        failed.note(Check::LongEnough, duration_s >= config.quality.minimum_duration_s);
        failed.note(Check::InputsValid, inputs_valid);
        failed.note(Check::SensorsAlive, sensors_alive);
        let is_fresh = tracker.is_fresh(time_us) && !self.reference_was_lost;
        failed.note(Check::ReferenceFresh, is_fresh);
        let is_consistent = are_credible && self.is_consistent(config, duration_s);
        failed.note(Check::ReadingsConsistent, is_consistent);

        let biases = Sensor::ALL.map(|sensor| self.estimator.bias_m(sensor));
        let coefficients = self.estimator.coefficients();
        let values = core::iter::once(self.estimator.altitude_m()).chain(biases).chain(coefficients);
        let state = collected(values);
        let covariance = self.estimator.covariance_triangle();
        LatchRecord { time_us, duration_s, failed_checks: failed.bits(), sensors, state, covariance }
    }
}

/// Climb of the altitude in `seconds`, metres, and its variance.
#[inline]
fn climb_over(climb: &ClimbRate, tracker: &ReferenceTracker, seconds: f32) -> (f32, f32) {
    let density = |sigma: f32| 2.0 * sigma * sigma * climb.correlation_time_s;
    match tracker.climb_rate_mps() {
        Some(rate) => (rate * seconds, density(climb.sigma_mps) * seconds),
        None => (0.0, density(UNKNOWN_CLIMB_RATE_MPS) * seconds),
    }
}

const fn square(x: f32) -> f32 {
    x * x
}

mod gate;
mod reference_level;
mod settling;
mod statistical_checks;
