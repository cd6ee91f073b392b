//! Computes an injected effect: its regressor over a flight's truth.
//!
//! The formulas of DESIGN.md's catalogue, written independently: from the truth, not from what sensors
//! measure, and sharing nothing with `kf_core::effect`.

use super::atmosphere::GRAVITY;
use super::motion::TruthSample;
use super::scenario::{Effect, EffectId, InjectionPhase};

/// Rotation rate of the earth, rad/s (WGS 84, NGA.STND.0036, table 3.1).
const EARTH_RATE: f64 = 7.292_115e-5;
/// Mean radius of the earth, m (WGS 84, R1).
const EARTH_RADIUS: f64 = 6_371_008.8;
/// Vertical gradient of gravity in free air, 1/s^2 (2 g / R; Torge, "Geodesy", section 3.3).
const GRAVITY_GRADIENT: f64 = 3.086e-6;

/// The sensor whose reading an effect is added to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Victim {
    Baro,
    ImuSlave,
    Gps,
}

pub(super) const fn victim(id: EffectId) -> Victim {
    match id {
        EffectId::BaroDynamicPressure
        | EffectId::BaroCarrierField
        | EffectId::BaroAngleOfAttack
        | EffectId::BaroSideslip
        | EffectId::BaroLag
        | EffectId::BaroScale
        | EffectId::BaroTemperature
        | EffectId::BaroWarmUp
        | EffectId::BaroDrift
        | EffectId::BaroAcceleration
        | EffectId::BaroPropwash
        | EffectId::BaroHysteresis => Victim::Baro,
        EffectId::ImuVelocityError
        | EffectId::ImuAccelBias
        | EffectId::ImuAccelScale
        | EffectId::ImuTilt
        | EffectId::ImuGyroBias
        | EffectId::ImuVibration
        | EffectId::ImuGravityGradient
        | EffectId::ImuEotvos => Victim::ImuSlave,
        EffectId::GpsLatency | EffectId::GpsConvergence | EffectId::GpsLeverArm => Victim::Gps,
    }
}

/// Double integral, exact for an input that is linear between rows.
#[derive(Default)]
struct DoubleIntegral {
    last: Option<(f64, f64)>,
    slope: f64,
    value: f64,
}

impl DoubleIntegral {
    fn next(&mut self, time: f64, input: f64) -> f64 {
        if let Some((last_time, last_input)) = self.last {
            let dt = time - last_time;
            self.value += dt * (self.slope + dt * (2.0 * last_input + input) / 6.0);
            self.slope += dt * 0.5 * (last_input + input);
        }
        self.last = Some((time, input));
        self.value
    }
}

/// Head of the dynamic pressure, m.
fn head(airspeed: f64) -> f64 {
    airspeed * airspeed / (2.0 * GRAVITY)
}

/// An effect's regressor at every row of a flight; zero where the effect does not act.
///
/// Clock, integrals, `h0`, `T0` and `V_latch`: see [`InjectionPhase`].
pub fn regressor(effect: &Effect, flight: &[TruthSample], latitude_deg: f64) -> Vec<f64> {
    let launch = flight.iter().position(|sample| !sample.captive);
    let Some(first) = (match effect.phase {
        InjectionPhase::Free => launch,
        InjectionPhase::Captive | InjectionPhase::Both => Some(0),
    }) else {
        return vec![0.0; flight.len()];
    };
    let Some(calibrated) = flight.first() else { return Vec::new() };
    let at_launch = flight.get(launch.unwrap_or(0)).unwrap_or(calibrated);
    let past_end = if effect.phase == InjectionPhase::Captive { launch } else { None };
    let end = past_end.unwrap_or(flight.len());
    let start_s = flight.get(first).map_or(0.0, |sample| sample.time_s);

    let mut value = evaluator(effect, [calibrated, at_launch], latitude_deg);
    let acting = flight.iter().take(end).skip(first).map(|sample| value(sample, sample.time_s - start_s));
    let mut regressor = vec![0.0; first];
    regressor.extend(acting);
    regressor.resize(flight.len(), 0.0);
    regressor
}

/// A regressor as a function of the truth and of the effect's clock (s), called row after row.
type Evaluator<'a> = Box<dyn FnMut(&TruthSample, f64) -> f64 + 'a>;

fn evaluator<'a>(
    effect: &Effect,
    [calibrated, at_launch]: [&'a TruthSample; 2],
    latitude_deg: f64,
) -> Evaluator<'a> {
    // Present for the effects that use them, because the scenario was checked.
    let time_constant_s = effect.time_constant_s.unwrap_or(f64::NAN);
    let width_m = effect.width_m.unwrap_or(f64::NAN);
    match effect.id {
        EffectId::BaroDynamicPressure => Box::new(|s, _| head(s.airspeed_mps)),
        EffectId::BaroCarrierField => {
            Box::new(|s, _| if s.captive { 0.0 } else { head(at_launch.airspeed_mps) })
        }
        EffectId::BaroAngleOfAttack => Box::new(|s, _| s.angle_of_attack_rad * head(s.airspeed_mps)),
        EffectId::BaroSideslip => Box::new(|s, _| s.sideslip_rad * s.sideslip_rad * head(s.airspeed_mps)),
        EffectId::BaroLag | EffectId::GpsLatency => Box::new(|s, _| -s.climb_rate_mps()),
        EffectId::BaroScale => Box::new(|s, _| s.altitude_m - calibrated.altitude_m),
        EffectId::BaroTemperature => Box::new(|s, _| s.baro_temperature_c - calibrated.baro_temperature_c),
        EffectId::BaroWarmUp => Box::new(move |_, t| 1.0 - libm::exp(-t / time_constant_s)),
        EffectId::BaroDrift | EffectId::ImuVelocityError => Box::new(|_, t| t),
        EffectId::BaroAcceleration => Box::new(|s, _| s.load_factor() - 1.0),
        EffectId::BaroPropwash => Box::new(|s, _| s.throttle * s.throttle),
        EffectId::BaroHysteresis => {
            let mut centre: Option<f64> = None;
            Box::new(move |s, _| {
                let h = s.altitude_m;
                let held = centre.unwrap_or(h).max(h - width_m).min(h + width_m);
                centre = Some(held);
                (held - h) / width_m
            })
        }
        EffectId::ImuAccelBias => Box::new(|_, t| 0.5 * t * t),
        EffectId::ImuAccelScale => integrated(|s, _| -s.acceleration_mps2()[2]),
        EffectId::ImuTilt => integrated(|s, _| along_heading(s)),
        EffectId::ImuGyroBias => integrated(|s, t| along_heading(s) * t),
        EffectId::ImuVibration => integrated(|s, _| 3.0 * s.vibration_mps2 * s.vibration_mps2),
        EffectId::ImuGravityGradient => {
            integrated(|s, _| GRAVITY_GRADIENT * (s.altitude_m - calibrated.altitude_m))
        }
        EffectId::ImuEotvos => {
            let eastward = 2.0 * EARTH_RATE * libm::cos(latitude_deg.to_radians());
            integrated(move |s, _| {
                let [north, east, _] = s.velocity_mps;
                eastward * east + (north * north + east * east) / EARTH_RADIUS
            })
        }
        EffectId::GpsConvergence => Box::new(move |_, t| libm::exp(-t / time_constant_s)),
        EffectId::GpsLeverArm => Box::new(|s, _| libm::sin(s.euler_rad[1])),
    }
}

fn integrated<'a>(mut input: impl FnMut(&TruthSample, f64) -> f64 + 'a) -> Evaluator<'a> {
    let mut integral = DoubleIntegral::default();
    Box::new(move |sample, t| integral.next(t, input(sample, t)))
}

/// Horizontal acceleration along the heading, m/s^2.
fn along_heading(sample: &TruthSample) -> f64 {
    let (sine, cosine) = libm::sincos(sample.euler_rad[2]);
    let [north, east, _] = sample.acceleration_mps2();
    north * cosine + east * sine
}

#[cfg(test)]
mod tests;
