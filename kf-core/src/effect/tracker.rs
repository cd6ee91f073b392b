//! The latest signals, and the regressors computed from them.

use serde::{Deserialize, Serialize};

use super::catalogue::Uses;
use super::forward_error::ForwardError;
use super::free_flight_integrals::{AccelerationSource, FreeFlightIntegrals, Step};
use super::inertial::Inertial;
use super::reference_motion::ReferenceMotion;
use super::{Clock, EffectId, Regressor};
use crate::input::{GpsFix, ImuSample, Signals, TickInput};
use crate::plausible;
use crate::root::reciprocal_root;
use crate::time::elapsed_s;
use crate::trigonometry::sine_and_cosine;

/// Default latitude of a tracker, degrees: half-way to the pole.
pub const DEFAULT_LATITUDE_DEG: f32 = 45.0;

/// Rotation rate of the earth, rad/s (WGS 84, NGA.STND.0036, table 3.1).
const EARTH_RATE_RADPS: f32 = 7.292_115e-5;

/// Source of the airspeed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AirspeedSource {
    /// The measured true airspeed.
    TrueAirspeed,
    /// The speed over ground, wind included: no airspeed has been measured yet.
    GroundSpeed,
}

/// Follows the signals and computes regressors from them.
///
/// Give it every tick in time order. At the first tick of a phase, call [`Self::begin_calibration`] or
/// [`Self::begin_free_flight`] first; then call [`Self::take`], then ask for [`Self::regressor_m`]. Numbers
/// that are not finite are counted and ignored. Signals that no effect of the model reads cost nothing.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SignalTracker {
    uses: Uses,
    /// `2 Omega cos(latitude)`, rad/s.
    eastward_radps: f32,
    first_us: Option<u64>,
    /// Time of the last tick. A snapshot has it already.
    #[serde(skip)]
    now_us: u64,
    launch_us: Option<u64>,

    true_airspeed_mps: Option<f32>,
    pub(super) angle_of_attack_rad: Option<f32>,
    pub(super) sideslip_rad: Option<f32>,
    pub(super) throttle: Option<f32>,
    baro_temperature_c: Option<f32>,
    motion: ReferenceMotion,
    inertial: Inertial,

    origin_altitude: Origin,
    origin_temperature: Origin,
    latched_airspeed_squared_m2ps2: Option<f32>,

    /// Only of use before launch, and a snapshot is of free flight.
    #[serde(skip)]
    forward_error: ForwardError,
    integrals: FreeFlightIntegrals,
    /// The integrals could not be continued over a restart.
    integrals_lost: bool,
    refused: u32,
}

/// Origin of a difference: the first value of the calibration or, until there is one, the first value of all.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Origin {
    value: Option<f32>,
    is_due: bool,
}

impl Origin {
    fn see(&mut self, value: f32) {
        if self.value.is_none() || self.is_due {
            *self = Self { value: Some(value), is_due: false };
        }
    }
}

impl Default for SignalTracker {
    /// A tracker for every effect of the catalogue, at [`DEFAULT_LATITUDE_DEG`].
    fn default() -> Self {
        Self::with_uses(Uses::EVERYTHING, eastward_radps(DEFAULT_LATITUDE_DEG).unwrap_or(0.0))
    }
}

/// `2 Omega cos(latitude)`, rad/s; `None` for an invalid latitude.
fn eastward_radps(latitude_deg: f32) -> Option<f32> {
    if !(-90.0..=90.0).contains(&latitude_deg) {
        return None;
    }
    sine_and_cosine(latitude_deg.to_radians()).map(|(_, cosine)| 2.0 * EARTH_RATE_RADPS * cosine)
}

impl SignalTracker {
    /// A tracker for these effects only; the regressor of any other may stay `None`. An invalid latitude
    /// (degrees, north positive) counts as a pole.
    #[must_use]
    #[inline]
    pub fn for_effects(effects: impl IntoIterator<Item = EffectId>, latitude_deg: f32) -> Self {
        let uses = effects.into_iter().fold(Uses::NOTHING, |uses, effect| uses.and(effect.row().uses));
        Self::with_uses(uses, eastward_radps(latitude_deg).unwrap_or(0.0))
    }

    /// Sets the latitude of the flight, degrees, north positive; an invalid one changes nothing.
    pub fn set_latitude_deg(&mut self, latitude_deg: f32) {
        self.eastward_radps = eastward_radps(latitude_deg).unwrap_or(self.eastward_radps);
    }

    #[inline]
    fn with_uses(uses: Uses, eastward_radps: f32) -> Self {
        Self {
            uses,
            eastward_radps,
            first_us: None,
            now_us: 0,
            launch_us: None,
            true_airspeed_mps: None,
            angle_of_attack_rad: None,
            sideslip_rad: None,
            throttle: None,
            baro_temperature_c: None,
            motion: ReferenceMotion::default(),
            inertial: Inertial::default(),
            origin_altitude: Origin::default(),
            origin_temperature: Origin::default(),
            latched_airspeed_squared_m2ps2: None,
            forward_error: ForwardError::default(),
            integrals: FreeFlightIntegrals::default(),
            integrals_lost: false,
            refused: 0,
        }
    }

    /// Makes the altitude of the next fix `h0`, and the next temperature of the barometer `T0`. Before, they
    /// are the first values of all.
    pub fn begin_calibration(&mut self) {
        self.origin_altitude.is_due = true;
        self.origin_temperature.is_due = true;
        self.forward_error = ForwardError::default();
    }

    /// Launch: `t` and the integrals are 0 at `time_us`, and the airspeed is latched (the first one from now
    /// on, if there has been none).
    pub fn begin_free_flight(&mut self, time_us: u64) {
        self.launch_us = Some(time_us);
        self.now_us = self.now_us.max(time_us);
        self.latched_airspeed_squared_m2ps2 = self.airspeed_squared_m2ps2();
        self.integrals = FreeFlightIntegrals::from_launch(self.forward_error.estimate_mps2());
        self.inertial.restart();
    }

    /// Whether this tracker is for these effects: a snapshot may hold another model's.
    pub(crate) fn is_for(&self, effects: impl IntoIterator<Item = EffectId>, latitude_deg: f32) -> bool {
        let fresh = Self::for_effects(effects, latitude_deg);
        fresh.uses == self.uses && fresh.eastward_radps.to_bits() == self.eastward_radps.to_bits()
    }

    /// Continues after the tick at this time, which a snapshot of the tracker does not contain.
    pub(crate) fn continue_after(&mut self, time_us: u64) {
        self.now_us = time_us;
    }

    /// The integrals have a gap of unknown effect: regressors computed from them are not available from now
    /// on.
    pub(crate) fn lose_integrals(&mut self) {
        self.integrals_lost = true;
    }

    /// Withdraws the launch: the flight is captive as before, and the next [`Self::begin_free_flight`] starts
    /// afresh.
    pub fn resume_captive(&mut self) {
        self.launch_us = None;
        self.integrals_lost = false;
        self.latched_airspeed_squared_m2ps2 = None;
        self.integrals = FreeFlightIntegrals::default();
        self.forward_error.restart();
        self.inertial.restart();
    }

    /// Takes what is new at a tick; `fix` is the tick's fix if it was accepted (finite, and not the last one
    /// held).
    #[inline]
    pub fn take(&mut self, input: &TickInput, fix: Option<&GpsFix>) {
        let from_us = self.now_us;
        self.now_us = input.time_us.max(from_us);
        if self.first_us.is_none() {
            self.first_us = Some(input.time_us);
        }
        self.take_signals(&input.signals);
        if let Some(fix) = fix {
            self.motion.take_velocity(fix);
            if self.uses.any_of(Uses::HEIGHT) {
                self.motion.take_height(input.time_us, fix);
                self.origin_altitude.see(fix.altitude_m);
            }
        }
        if let Some(imu) = &input.imu {
            self.take_imu(imu, input.signals.attitude_rad.is_some());
        }
        if self.launch_us.is_some() {
            if self.latched_airspeed_squared_m2ps2.is_none() {
                self.latched_airspeed_squared_m2ps2 = self.airspeed_squared_m2ps2();
            }
            if !self.uses.any_of(Uses::INTEGRATED) {
                return;
            }
            let step = Step {
                uses: self.uses,
                seconds: elapsed_s(from_us, self.now_us),
                elapsed_s: self.elapsed_s(Clock::Launch),
                has_fix: fix.is_some(),
                height_gained_m: self.height_gained_m(),
                eastward_radps: self.eastward_radps,
                inertial: &self.inertial,
                motion: &self.motion,
            };
            let is_taken = self.integrals.advance(&step);
            self.count_unless(is_taken);
        } else if self.uses.any_of(Uses::FORWARD) {
            self.compare_forward(elapsed_s(from_us, self.now_us), fix);
        }
    }

    /// Measures the error of the forward acceleration in captive flight.
    fn compare_forward(&mut self, seconds: f32, fix: Option<&GpsFix>) {
        let Some([_, forward_mps2]) = self.inertial.upward_and_forward_mps2() else { return };
        self.forward_error.advance(seconds, forward_mps2);
        let velocity = fix.and_then(|fix| fix.velocity_north_mps.zip(fix.velocity_east_mps));
        if let Some((north_mps, east_mps)) = velocity {
            self.forward_error.take([north_mps, east_mps]);
        }
    }

    /// The sigma of the constant error that the forward acceleration of `imu.tilt` and `imu.gyro_bias` still
    /// has after captive flight, m/s^2. What captive flight shows of it is subtracted from launch on.
    #[must_use]
    pub fn forward_sigma_mps2(&self) -> f32 {
        self.forward_error.sigma_mps2()
    }

    #[inline]
    fn take_signals(&mut self, signals: &Signals) {
        let refused = &mut self.refused;
        let mut take = |slot: &mut Option<f32>, value: Option<f32>, is_plausible: fn(f32) -> bool| match value
        {
            Some(value) if is_plausible(value) => *slot = Some(value),
            Some(_) => *refused = refused.saturating_add(1),
            None => {}
        };
        take(&mut self.true_airspeed_mps, signals.true_airspeed_mps, plausible::velocity);
        if self.uses.any_of(Uses::ANGLE_OF_ATTACK) {
            take(&mut self.angle_of_attack_rad, signals.angle_of_attack_rad, plausible::flow_angle);
        }
        if self.uses.any_of(Uses::SIDESLIP) {
            take(&mut self.sideslip_rad, signals.sideslip_rad, plausible::flow_angle);
        }
        if self.uses.any_of(Uses::THROTTLE) {
            take(&mut self.throttle, signals.throttle, plausible::throttle);
        }
        if self.uses.any_of(Uses::BARO_TEMPERATURE) {
            let mut temperature_c = None;
            take(&mut temperature_c, signals.baro_temperature_c, plausible::temperature);
            if let Some(temperature_c) = temperature_c {
                self.baro_temperature_c = Some(temperature_c);
                self.origin_temperature.see(temperature_c);
            }
        }
        if let (true, Some([roll_rad, pitch_rad, yaw_rad])) =
            (self.uses.any_of(Uses::ATTITUDE), signals.attitude_rad)
        {
            if self.uses.any_of(Uses::FORWARD) && self.launch_us.is_none() {
                self.forward_error.turn_to(yaw_rad);
            }
            let is_taken = self.inertial.take_attitude(roll_rad, pitch_rad);
            self.count_unless(is_taken);
        }
    }

    fn take_imu(&mut self, imu: &ImuSample, has_attitude: bool) {
        const READ: Uses = Uses::LOAD_FACTOR.and(Uses::VERTICAL).and(Uses::FORWARD).and(Uses::VIBRATION);
        if !self.uses.any_of(READ) {
            return;
        }
        if !plausible::imu(imu) {
            self.count_unless(false);
            return;
        }
        if !has_attitude && self.uses.any_of(Uses::VERTICAL.and(Uses::FORWARD)) {
            self.inertial.turn(self.now_us, imu.gyro_radps);
        }
        self.inertial.take_accel(self.now_us, imu.accel_mps2);
        if self.uses.any_of(Uses::VIBRATION) && self.launch_us.is_some() {
            let is_taken = self.inertial.shake(self.now_us, imu.accel_mps2);
            self.count_unless(is_taken);
        }
    }

    fn count_unless(&mut self, is_taken: bool) {
        if !is_taken {
            self.refused = self.refused.saturating_add(1);
        }
    }

    /// Number of signal values refused: not finite, implausible, not a valid angle, or so large that an
    /// integral overflows.
    #[must_use]
    pub const fn refused(&self) -> u32 {
        self.refused
    }

    /// Source of the airspeed, once there is one.
    #[must_use]
    pub fn airspeed_source(&self) -> Option<AirspeedSource> {
        let measured = self.true_airspeed_mps.map(|_| AirspeedSource::TrueAirspeed);
        measured.or_else(|| self.motion.speed_squared_m2ps2().map(|_| AirspeedSource::GroundSpeed))
    }

    /// Source of the forward acceleration of `imu.tilt` and `imu.gyro_bias`: decided at launch; before
    /// launch, the source that would be chosen now.
    #[must_use]
    pub fn acceleration_source(&self) -> Option<AccelerationSource> {
        self.integrals.source.or_else(|| AccelerationSource::now(&self.inertial, &self.motion))
    }

    /// Present regressor of an effect, metres per unit of its coefficient; `None` while a signal that it
    /// needs has not been seen, and where the number overflows.
    #[must_use]
    #[inline]
    pub fn regressor_m(&self, regressor: Regressor) -> Option<f32> {
        (regressor.id.row().value)(self, &regressor).filter(|value_m| value_m.is_finite())
    }

    /// Square of the true airspeed, (m/s)^2, or of the speed over ground where no airspeed has ever
    /// been measured.
    #[must_use]
    pub fn airspeed_squared_m2ps2(&self) -> Option<f32> {
        self.true_airspeed_mps.map(|speed| speed * speed).or(self.motion.speed_squared_m2ps2())
    }

    /// The true airspeed, m/s, or the speed over ground where no airspeed has ever been measured.
    pub(crate) fn airspeed_mps(&self) -> Option<f32> {
        self.true_airspeed_mps.or_else(|| {
            let squared = self.motion.speed_squared_m2ps2()?;
            Some(if squared < f32::MIN_POSITIVE { 0.0 } else { squared * reciprocal_root(squared) })
        })
    }

    /// See [`ReferenceMotion::horizontal_speed_mps`].
    pub(crate) fn horizontal_speed_mps(&self) -> Option<f32> {
        self.motion.horizontal_speed_mps()
    }

    /// Present altitude of the reference, carried on from the last fix, metres.
    pub(crate) fn altitude_m(&self) -> Option<f32> {
        self.motion.altitude_m(self.now_us)
    }

    /// See [`Inertial::upward_and_forward_mps2`]; after launch without the constant error that captive
    /// flight showed.
    pub(crate) fn upward_and_forward_mps2(&self) -> Option<[f32; 2]> {
        let [upward_mps2, forward_mps2] = self.inertial.upward_and_forward_mps2()?;
        Some([upward_mps2, forward_mps2 - self.integrals.forward_error_mps2])
    }

    /// Cosine of the flight's latitude.
    pub(crate) fn cosine_latitude(&self) -> f32 {
        self.eastward_radps * (0.5 / EARTH_RATE_RADPS)
    }

    /// Whether [`Self::begin_free_flight`] was called.
    pub(crate) const fn is_launched(&self) -> bool {
        self.launch_us.is_some()
    }

    /// Climb rate, m/s: the last fix's own, else from the fixes' altitudes by a critically damped g-h
    /// filter.
    #[must_use]
    pub fn climb_rate_mps(&self) -> Option<f32> {
        self.motion.climb_rate_mps()
    }

    /// Seconds on a clock; the launch's reads 0 before launch.
    #[must_use]
    pub fn elapsed_s(&self, clock: Clock) -> f32 {
        let start_us = match clock {
            Clock::Launch => self.launch_us,
            Clock::Start => self.first_us,
        };
        start_us.map_or(0.0, |start_us| elapsed_s(start_us, self.now_us))
    }

    /// Zero before launch, then the square of the airspeed at launch, (m/s)^2.
    pub(super) fn latched_airspeed_squared_m2ps2(&self) -> Option<f32> {
        match self.launch_us {
            None => self.airspeed_squared_m2ps2().map(|_| 0.0),
            Some(_) => self.latched_airspeed_squared_m2ps2,
        }
    }

    /// `h - h0`, metres.
    pub(super) fn height_gained_m(&self) -> Option<f32> {
        Some(self.motion.altitude_m(self.now_us)? - self.origin_altitude.value?)
    }

    /// `T - T0`, kelvin.
    pub(super) fn baro_warming_k(&self) -> Option<f32> {
        Some(self.baro_temperature_c? - self.origin_temperature.value?)
    }

    pub(crate) const fn load_factor(&self) -> Option<f32> {
        self.inertial.load_factor()
    }

    pub(super) fn sin_pitch(&self) -> Option<f32> {
        self.inertial.sin_pitch()
    }

    pub(super) fn vertical_integral_m(&self) -> Option<f32> {
        (self.inertial.is_complete() && !self.integrals_lost).then_some(self.integrals.vertical.value())
    }

    /// Double integrals of the forward acceleration, and of it times `t`.
    pub(super) fn forward_integrals_m(&self) -> Option<[f32; 2]> {
        self.acceleration_source()
            .filter(|_| !self.integrals_lost)
            .map(|_| [self.integrals.forward.value(), self.integrals.turning.value()])
    }

    pub(super) fn vibration_integral_m(&self) -> Option<f32> {
        self.inertial.vibration_integral_m().filter(|_| !self.integrals_lost)
    }

    pub(super) fn gravity_integral_m(&self) -> Option<f32> {
        self.height_gained_m().filter(|_| !self.integrals_lost).map(|_| self.integrals.gravity.value())
    }

    pub(super) fn eotvos_integral_m(&self) -> Option<f32> {
        self.motion.velocity_mps().filter(|_| !self.integrals_lost).map(|_| self.integrals.eotvos.value())
    }
}
