//! The hidden effects by their physics rather than by the catalogue's formulas: pressures at the port, a
//! filtered pressure, errors of an accelerometer's axis, a late receiver.

use std::collections::VecDeque;

use pylon::simulate::TruthSample;
use pylon::simulate::scenario::{Effect, EffectId};

use super::path::{GRAVITY, STEP_S};

/// Gas constant of dry air, J/(kg K) (ICAO Doc 7488, table A).
const GAS: f64 = 287.052_87;
/// Latitude of all flights, rad.
pub(super) const LATITUDE_RAD: f64 = 47.0 * std::f64::consts::PI / 180.0;
/// Rotation rate of the earth, rad/s, and its mean radius, m.
const EARTH: [f64; 2] = [7.292_115e-5, 6_371_008.8];

/// The standard atmosphere below 11 km (ICAO Doc 7488): pressure at an altitude, Pa.
pub(super) fn pressure_pa(altitude_m: f64) -> f64 {
    101_325.0 * (1.0 - 0.0065 * altitude_m / 288.15).powf(GRAVITY / (0.0065 * GAS))
}

/// Its inverse, m.
pub(super) fn altitude_m(pressure_pa: f64) -> f64 {
    288.15 / 0.0065 * (1.0 - (pressure_pa / 101_325.0).powf(0.0065 * GAS / GRAVITY))
}

fn launch(flight: &[TruthSample]) -> Option<&TruthSample> {
    flight.iter().find(|row| !row.captive)
}

/// Pressure at the barometer, Pa, per row, including the effects; `is_hose`: a lag is a filter (tubing), else
/// a pure delay.
pub(super) fn barometer_pa(flight: &[TruthSample], effects: &[Effect], is_hose: bool) -> Vec<f64> {
    let Some(start) = launch(flight) else { return Vec::new() };
    let mut filtered = None;
    let mut waiting = VecDeque::new();
    let mut sensed = Vec::with_capacity(flight.len());
    for row in flight {
        let since_launch_s = if row.captive { 0.0 } else { row.time_s - start.time_s };
        let mut height_m = row.pressure_altitude_m;
        // From where the height and the temperature count does not matter: the bias takes the difference.
        for effect in effects.iter().filter(|effect| effect.id == EffectId::BaroScale) {
            height_m += effect.coefficient * (row.altitude_m - start.altitude_m);
        }
        let undisturbed_pa = pressure_pa(height_m);
        let density = undisturbed_pa / (GAS * (row.air_temperature_c + 273.15));
        let dynamic_pa = 0.5 * density * row.airspeed_mps * row.airspeed_mps;
        let mut disturbed_pa = undisturbed_pa;
        let mut reading_m = 0.0;
        for Effect { id, coefficient, time_constant_s, .. } in effects {
            match id {
                EffectId::BaroDynamicPressure => disturbed_pa -= coefficient * dynamic_pa,
                // The mother ship's field acts while she is there.
                EffectId::BaroCarrierField if row.captive => disturbed_pa += coefficient * dynamic_pa,
                EffectId::BaroAngleOfAttack => {
                    disturbed_pa -= coefficient * row.angle_of_attack_rad * dynamic_pa;
                }
                EffectId::BaroSideslip => disturbed_pa -= coefficient * row.sideslip_rad.powi(2) * dynamic_pa,
                EffectId::BaroPropwash => {
                    disturbed_pa -= coefficient * density * GRAVITY * row.throttle * row.throttle;
                }
                EffectId::BaroTemperature => {
                    reading_m += coefficient * (row.baro_temperature_c - start.baro_temperature_c);
                }
                EffectId::BaroWarmUp => {
                    reading_m +=
                        coefficient * (1.0 - (-since_launch_s / time_constant_s.unwrap_or(f64::NAN)).exp());
                }
                EffectId::BaroDrift => reading_m += coefficient * since_launch_s,
                EffectId::BaroAcceleration => reading_m += coefficient * (row.load_factor() - 1.0),
                _ => {}
            }
        }
        for effect in effects.iter().filter(|effect| effect.id == EffectId::BaroLag) {
            let lag_s = effect.coefficient.max(STEP_S);
            disturbed_pa = if is_hose {
                let last = filtered.unwrap_or(disturbed_pa);
                let next = last + STEP_S / lag_s * (disturbed_pa - last);
                filtered = Some(next);
                next
            } else {
                waiting.push_back(disturbed_pa);
                let held = (lag_s / STEP_S) as usize;
                if waiting.len() > held + 1 {
                    waiting.pop_front();
                }
                waiting.front().copied().unwrap_or(disturbed_pa)
            };
        }
        sensed.push(pressure_pa(altitude_m(disturbed_pa) + reading_m));
    }
    sensed
}

/// Error of the inertial altitude, m, per row: errors of its accelerometer and attitude, integrated twice
/// from launch on.
pub(super) fn inertial_error_m(flight: &[TruthSample], effects: &[Effect]) -> Vec<f64> {
    let (Some(start), Some(first)) = (launch(flight), flight.first()) else { return Vec::new() };
    // The catalogue's h0, the altitude at calibration (DESIGN.md), but for the settling time before it.
    let calibrated_at_m = first.altitude_m;
    let velocity_mps: f64 =
        effects.iter().filter(|e| e.id == EffectId::ImuVelocityError).map(|e| e.coefficient).sum();
    let (mut climb, mut height) = (velocity_mps, 0.0);
    let mut errors = Vec::with_capacity(flight.len());
    for row in flight {
        if row.captive {
            errors.push(0.0);
            continue;
        }
        let since_s = row.time_s - start.time_s;
        let [roll, pitch, yaw] = row.euler_rad;
        let vertical = roll.cos() * pitch.cos();
        let [north, east, down] = row.acceleration_mps2();
        let forward = north * yaw.cos() + east * yaw.sin();
        let [v_north, v_east, _] = row.velocity_mps;
        let error: f64 = effects
            .iter()
            .map(|effect| {
                effect.coefficient
                    * match effect.id {
                        // A bias acts along its axis.
                        EffectId::ImuAccelBias => vertical,
                        EffectId::ImuAccelScale => -down,
                        EffectId::ImuTilt => forward,
                        EffectId::ImuGyroBias => forward * since_s,
                        EffectId::ImuVibration => 3.0 * row.vibration_mps2 * row.vibration_mps2,
                        EffectId::ImuGravityGradient => {
                            2.0 * GRAVITY / EARTH[1] * (row.altitude_m - calibrated_at_m)
                        }
                        EffectId::ImuEotvos => {
                            2.0 * EARTH[0] * LATITUDE_RAD.cos() * v_east
                                + (v_north * v_north + v_east * v_east) / EARTH[1]
                        }
                        _ => 0.0,
                    }
            })
            .sum();
        height += STEP_S * (climb + 0.5 * STEP_S * error);
        climb += STEP_S * error;
        errors.push(height);
    }
    errors
}

/// What the receiver reports at a time: its altitude, m, and its delay, s.
pub(super) fn receiver(row: &TruthSample, effects: &[Effect]) -> (f64, f64) {
    let (mut added_m, mut late_s) = (0.0, 0.0);
    for Effect { id, coefficient, time_constant_s, .. } in effects {
        match id {
            EffectId::GpsLatency => late_s += coefficient,
            EffectId::GpsConvergence => {
                added_m += coefficient * (-row.time_s / time_constant_s.unwrap_or(f64::NAN)).exp();
            }
            EffectId::GpsLeverArm => added_m += coefficient * row.euler_rad[1].sin(),
            _ => {}
        }
    }
    (added_m, late_s)
}

/// What one unit of an effect adds to its sensor, m, per row: for the effect's size. A lag and a latency are
/// linear in it for slow motions.
pub(super) fn unit_m(effect: &Effect, flight: &[TruthSample]) -> Vec<f64> {
    let one = [Effect { coefficient: 1.0, ..*effect }];
    match effect.id {
        EffectId::BaroLag | EffectId::GpsLatency => flight.iter().map(|row| -row.climb_rate_mps()).collect(),
        EffectId::GpsConvergence | EffectId::GpsLeverArm => {
            flight.iter().map(|row| receiver(row, &one).0).collect()
        }
        id if id.name().starts_with("imu.") => inertial_error_m(flight, &one),
        // A small one, so that the pressure is linear in it.
        _ => {
            let small = [Effect { coefficient: 1e-3, ..*effect }];
            let without = barometer_pa(flight, &[], true);
            let with = barometer_pa(flight, &small, true);
            with.iter()
                .zip(without)
                .map(|(with, without)| 1e3 * (altitude_m(*with) - altitude_m(without)))
                .collect()
        }
    }
}

#[cfg(test)]
mod tests {
    use pylon::simulate::regressor;
    use pylon::simulate::scenario::InjectionPhase;
    use rand::SeedableRng as _;
    use rand_chacha::ChaCha8Rng;

    use super::super::path::{Airframe, Course, fly};
    use super::*;
    use crate::blind::draw::Plan;
    use crate::blind::flight::unit;

    #[test]
    fn the_atmosphere_is_the_tables() {
        // ICAO Doc 7488, table 1: 0, 1000 and 5000 m.
        for (height_m, pascal) in [(0.0, 101_325.0), (1000.0, 89_874.6), (5000.0, 54_019.9)] {
            assert!((pressure_pa(height_m) - pascal).abs() < 0.1, "{height_m}");
            assert!((altitude_m(pressure_pa(height_m)) - height_m).abs() < 1e-6);
        }
    }

    /// Each effect is close enough to the catalogue's definition to be that effect: on a flight in free air
    /// it correlates by at least 0.97 with the catalogue's regressor as `pylon simulate` computes it, with a
    /// slope within 15 % (a bias along the body's axis is less where the aircraft banks).
    #[test]
    fn each_effect_is_near_the_catalogues() {
        let mut random = ChaCha8Rng::seed_from_u64(7);
        let airframe = Airframe::draw(&mut random);
        let flight = fly(&airframe, Course::Drawn(Plan::Rich), &mut random);
        for id in EffectId::ALL.iter().copied().filter(|id| *id != EffectId::BaroHysteresis) {
            let time_constant_s =
                matches!(id, EffectId::BaroWarmUp | EffectId::GpsConvergence).then_some(40.0);
            let effect = unit(id, time_constant_s);
            let ours = unit_m(&effect, &flight);
            let theirs = regressor(&effect, &flight, LATITUDE_RAD.to_degrees());
            let captive = effect.phase != InjectionPhase::Free;
            let rows: Vec<usize> = (0..flight.len()).filter(|k| captive || !flight[*k].captive).collect();
            let mean = |values: &[f64]| rows.iter().map(|k| values[*k]).sum::<f64>() / rows.len() as f64;
            let (a, b) = (mean(&ours), mean(&theirs));
            let sum = |f: &dyn Fn(usize) -> f64| rows.iter().map(|k| f(*k)).sum::<f64>();
            let cross = sum(&|k| (ours[k] - a) * (theirs[k] - b));
            let own = sum(&|k| (ours[k] - a).powi(2));
            let squares = sum(&|k| (theirs[k] - b).powi(2));
            let (slope, correlation) = (cross / squares, cross / (own * squares).sqrt());
            assert!(correlation > 0.97 && (slope - 1.0).abs() < 0.15, "{}: {slope} {correlation}", id.name());
        }
    }
}
