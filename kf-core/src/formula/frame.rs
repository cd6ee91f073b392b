//! The signals of one tick.

use super::signal::{PLACES, Signal};
use crate::atmosphere::{pressure_altitude_m, static_pressure_pa};
use crate::effect::{Clock, SignalTracker};
use crate::input::{BaroReading, GpsFix, ImuSample, TickInput};
use crate::plausible;
use crate::time::elapsed_s;

/// Columns of specific force, body rates and attitude.
pub(super) const INERTIAL_AND_ATTITUDE: &[&str] = &[
    "accel_x_mps2",
    "accel_y_mps2",
    "accel_z_mps2",
    "gyro_x_radps",
    "gyro_y_radps",
    "gyro_z_radps",
    "roll_rad",
    "pitch_rad",
    "yaw_rad",
];

/// Zero degrees Celsius, K.
const CELSIUS_K: f32 = 273.15;

/// Latest values of the signals, which of them are new, and the phase of the flight. Values are in the units
/// of [`Signal::unit`]; NaN stands for a value that has not been seen.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    pub(super) values: [f32; PLACES],
    pub(super) new: u64,
    pub(super) seconds: f32,
    pub(super) launched: bool,
    pub(super) calibration_begins: bool,
    last_us: Option<u64>,
    last_accel_mps2: Option<[f32; 3]>,
}

impl Default for Frame {
    fn default() -> Self {
        Self {
            values: [f32::NAN; PLACES],
            new: 0,
            seconds: 0.0,
            launched: false,
            calibration_begins: false,
            last_us: None,
            last_accel_mps2: None,
        }
    }
}

impl Frame {
    /// Begins a tick by hand, `seconds` after the last one: only time is new. For callers that have signals
    /// and no [`TickInput`]s; follow it with [`Self::set`].
    pub fn begin(&mut self, seconds: f32, launched: bool, calibration_begins: bool) {
        (self.seconds, self.launched, self.calibration_begins) = (seconds, launched, calibration_begins);
        self.new = ALWAYS_NEW;
    }

    /// Sets a new sample, in the unit of [`Signal::unit`]; a value that is not finite is ignored.
    #[inline]
    pub fn set(&mut self, place: u8, value: f32) {
        if let (Some(slot), true) = (self.values.get_mut(usize::from(place)), value.is_finite()) {
            *slot = value;
            self.new |= 1 << place;
        }
    }

    /// The latest value at a place of a program, which has been checked to be valid; NaN where it has not
    /// been seen.
    #[inline(always)]
    pub(super) fn number(&self, place: u8) -> f32 {
        self.values.get(usize::from(place) & PLACES.wrapping_sub(1)).copied().unwrap_or(f32::NAN)
    }

    /// The latest value at a place.
    #[must_use]
    pub fn value(&self, place: u8) -> Option<f32> {
        self.values.get(usize::from(place)).copied().filter(|value| !value.is_nan())
    }

    /// Begins the calibration at the next tick (again, if it had begun).
    pub const fn begin_calibration(&mut self) {
        self.calibration_begins = true;
    }

    /// Takes what is new at a tick, of the signals in the set `used`; `fix` is the tick's if it was accepted.
    /// The tracker has already taken the tick. Call [`Self::end`] after the programs have run.
    #[inline]
    pub fn take(&mut self, used: u64, input: &TickInput, fix: Option<&GpsFix>, tracker: &SignalTracker) {
        self.seconds = self.last_us.map_or(0.0, |last_us| elapsed_s(last_us, input.time_us));
        self.last_us = Some(input.time_us);
        self.launched = tracker.is_launched();
        self.new = ALWAYS_NEW;
        let imu = input.imu.as_ref().filter(|imu| used & INERTIAL != 0 && plausible::imu(imu));
        // In halves: 32 bits are one register of the target.
        for (half, base) in [(used as u32, 0_u8), ((used >> 32) as u32, 32)] {
            let (mut left, mut new) = (half, 0_u32);
            while left != 0 {
                let bit = left & left.wrapping_neg();
                let place = usize::from(base) + left.trailing_zeros() as usize;
                left ^= bit;
                let value = match Signal::ALL.get(place) {
                    Some(signal) => self.sample(*signal, input, imu, fix, tracker),
                    None => input.columns.get(place - Signal::ALL.len()),
                };
                if let (Some(value), Some(slot)) = (value, self.values.get_mut(place))
                    && value.is_finite()
                {
                    *slot = value;
                    new |= bit;
                }
            }
            self.new |= u64::from(new) << base;
        }
    }

    /// After a restart: the next tick's step starts at this time.
    pub(crate) const fn resume(&mut self, last_us: u64) {
        self.last_us = Some(last_us);
    }

    /// Ends the tick.
    pub const fn end(&mut self) {
        self.calibration_begins = false;
    }

    /// A signal's value if it is new; `imu` is the tick's sample if it is plausible. Not inlined: the
    /// compiler would compute every signal before the loop over those that are used.
    #[inline(never)]
    fn sample(
        &mut self,
        signal: Signal,
        input: &TickInput,
        imu: Option<&ImuSample>,
        fix: Option<&GpsFix>,
        tracker: &SignalTracker,
    ) -> Option<f32> {
        let signals = &input.signals;
        let accel = |axis: usize| imu.and_then(|imu| imu.accel_mps2.get(axis).copied());
        let gyro = |axis: usize| imu.and_then(|imu| imu.gyro_radps.get(axis).copied());
        let attitude = |axis: usize| signals.attitude_rad.and_then(|angles| angles.get(axis).copied());
        let speed = |value: Option<f32>| value.filter(|speed| plausible::velocity(*speed));
        let flow = |value: Option<f32>| value.filter(|angle| plausible::flow_angle(*angle));
        let kelvin = |value: Option<f32>| {
            value.filter(|celsius| plausible::temperature(*celsius)).map(|celsius| celsius + CELSIUS_K)
        };
        match signal {
            Signal::Time => Some(tracker.elapsed_s(Clock::Launch)),
            Signal::TimeOn => Some(tracker.elapsed_s(Clock::Start)),
            Signal::Launch => Some(if tracker.is_launched() { 1.0 } else { 0.0 }),
            Signal::CosineLatitude => Some(tracker.cosine_latitude()),
            Signal::Airspeed => tracker.airspeed_mps().filter(|_| {
                speed(signals.true_airspeed_mps).is_some()
                    || fix.is_some()
                    || self.value(signal.place()).is_none()
            }),
            Signal::GroundSpeed => fix.and_then(|_| tracker.horizontal_speed_mps()),
            Signal::ClimbRate => fix.and_then(|_| tracker.climb_rate_mps()),
            Signal::Altitude => {
                // Carried on at every tick, but not a new sample between two fixes.
                let altitude_m = tracker.altitude_m();
                if fix.is_none()
                    && let (Some(slot), Some(altitude_m)) =
                        (self.values.get_mut(usize::from(signal.place())), altitude_m)
                {
                    *slot = altitude_m;
                    return None;
                }
                altitude_m
            }
            Signal::LoadFactor => imu.and_then(|_| tracker.load_factor()),
            Signal::UpwardAcceleration => tracker.upward_and_forward_mps2().map(|[upward, _]| upward),
            Signal::ForwardAcceleration => tracker.upward_and_forward_mps2().map(|[_, forward]| forward),
            Signal::AccelerationVariance => {
                let now = imu?.accel_mps2;
                let last = self.last_accel_mps2.replace(now)?;
                let square: f32 =
                    now.iter().zip(last).map(|(now, before)| (now - before) * (now - before)).sum();
                Some(0.5 * square)
            }
            Signal::TrueAirspeed => speed(signals.true_airspeed_mps),
            Signal::AngleOfAttack => flow(signals.angle_of_attack_rad),
            Signal::Sideslip => flow(signals.sideslip_rad),
            Signal::Throttle => signals.throttle.filter(|throttle| plausible::throttle(*throttle)),
            Signal::OutsideAirTemperature => kelvin(signals.outside_air_temperature_c),
            Signal::BaroTemperature => kelvin(signals.baro_temperature_c),
            Signal::Roll => attitude(0),
            Signal::Pitch => attitude(1),
            Signal::Yaw => attitude(2),
            Signal::AccelX => accel(0),
            Signal::AccelY => accel(1),
            Signal::AccelZ => accel(2),
            Signal::GyroX => gyro(0),
            Signal::GyroY => gyro(1),
            Signal::GyroZ => gyro(2),
            Signal::GpsAltitude => fix.map(|fix| fix.altitude_m),
            Signal::GpsNorth => fix.and_then(|fix| fix.velocity_north_mps),
            Signal::GpsEast => fix.and_then(|fix| fix.velocity_east_mps),
            Signal::GpsDown => fix.and_then(|fix| fix.velocity_down_mps),
            Signal::GpsAccuracy => fix.and_then(|fix| fix.vertical_accuracy_m),
            Signal::GpsSatellites => fix.and_then(|fix| fix.satellites.map(f32::from)),
            Signal::BaroPressure => match input.baro? {
                BaroReading::PressurePa(pressure_pa) => pressure_altitude_m(pressure_pa)
                    .filter(|m| plausible::altitude(*m).is_none())
                    .map(|_| pressure_pa),
                BaroReading::AltitudeM(altitude_m) => {
                    static_pressure_pa(altitude_m).filter(|_| plausible::altitude(altitude_m).is_none())
                }
            },
            Signal::BaroAltitude => {
                let altitude_m = match input.baro? {
                    BaroReading::PressurePa(pressure_pa) => pressure_altitude_m(pressure_pa)?,
                    BaroReading::AltitudeM(altitude_m) => altitude_m,
                };
                plausible::altitude(altitude_m).is_none().then_some(altitude_m)
            }
            Signal::ImuMaster => input.imu_master_altitude_m.filter(|m| plausible::altitude(*m).is_none()),
            Signal::ImuSlave => input.imu_slave_altitude_m.filter(|m| plausible::altitude(*m).is_none()),
        }
    }
}

/// Signals computed from the tick's inertial sample.
const INERTIAL: u64 = Signal::LoadFactor.bit()
    | Signal::AccelerationVariance.bit()
    | Signal::AccelX.bit()
    | Signal::AccelY.bit()
    | Signal::AccelZ.bit()
    | Signal::GyroX.bit()
    | Signal::GyroY.bit()
    | Signal::GyroZ.bit();

/// Signals with a new value at every tick.
const ALWAYS_NEW: u64 = Signal::Time.bit() | Signal::TimeOn.bit() | Signal::Launch.bit();
