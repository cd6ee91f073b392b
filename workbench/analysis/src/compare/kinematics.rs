//! How the aircraft moved, second by second, from whichever signals the flight has.

use kf_core::atmosphere::STANDARD_GRAVITY_MPS2;
use kf_core::input::{GpsFix, TickInput};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::manoeuvre::Motion;
use crate::name::Name;

/// Speed below which the direction of the ground track means nothing, m/s.
const TRACK_SPEED_MPS: f64 = 5.0;
/// Longest interval between two fixes that gives a turn rate, seconds.
const LONGEST_FIX_GAP_S: f64 = 5.0;
/// Number of seconds for which a signal is held over a gap.
const HELD_SECONDS: usize = 10;
/// Half the interval over which altitudes are differenced to a climb rate, seconds.
const ALTITUDE_BASE: usize = 2;

/// A running mean.
#[derive(Clone, Copy, Debug, Default)]
struct Mean {
    sum: f64,
    count: u32,
}

impl Mean {
    #[inline]
    fn push(&mut self, value: f64) {
        if value.is_finite() {
            self.sum += value;
            self.count += 1;
        }
    }

    fn get(self) -> Option<f64> {
        (self.count > 0).then(|| self.sum / f64::from(self.count))
    }
}

/// Signals of one second.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct SignalMeans {
    doppler_climb: Mean,
    gps_altitude: Mean,
    true_airspeed: Mean,
    ground_speed: Mean,
    load_factor: Mean,
    track_rate: Mean,
    yaw_rate: Mean,
}

/// Derives motion from the inputs; keeps the state that differences need.
#[derive(Clone, Debug, Default)]
pub(super) struct SignalReader {
    last_track: Option<(u64, f64)>,
    last_yaw: Option<(u64, f64)>,
}

impl SignalReader {
    /// Adds one tick's signals to the means of its second.
    #[inline]
    pub(super) fn take(&mut self, input: &TickInput, means: &mut SignalMeans) {
        if let Some(airspeed) = input.signals.true_airspeed_mps {
            means.true_airspeed.push(f64::from(airspeed));
        }
        if let Some(imu) = &input.imu {
            means.load_factor.push(f64::from(-imu.accel_mps2[2] / STANDARD_GRAVITY_MPS2));
        }
        if let Some([_, _, yaw]) = input.signals.attitude_rad {
            Self::turn(&mut self.last_yaw, input.time_us, f64::from(yaw), &mut means.yaw_rate);
        }
        if let Some(fix) = &input.gps {
            self.take_fix(input.time_us, fix, means);
        }
    }

    fn take_fix(&mut self, time_us: u64, fix: &GpsFix, means: &mut SignalMeans) {
        means.gps_altitude.push(f64::from(fix.altitude_m));
        if let Some(down) = fix.velocity_down_mps {
            means.doppler_climb.push(-f64::from(down));
        }
        let (Some(north), Some(east)) = (fix.velocity_north_mps, fix.velocity_east_mps) else { return };
        let (north, east) = (f64::from(north), f64::from(east));
        let horizontal = libm::hypot(north, east);
        means.ground_speed.push(libm::hypot(horizontal, f64::from(fix.velocity_down_mps.unwrap_or(0.0))));
        if horizontal > TRACK_SPEED_MPS {
            Self::turn(&mut self.last_track, time_us, libm::atan2(east, north), &mut means.track_rate);
        } else {
            self.last_track = None;
        }
    }

    /// Takes the rate of an angle between two readings, the short way round.
    fn turn(last: &mut Option<(u64, f64)>, time_us: u64, angle: f64, rate: &mut Mean) {
        if !angle.is_finite() {
            return;
        }
        if let Some((last_us, last_angle)) = *last {
            let seconds = time_us.saturating_sub(last_us) as f64 * 1e-6;
            if seconds > 0.0 && seconds <= LONGEST_FIX_GAP_S {
                let full = std::f64::consts::TAU;
                let change = (angle - last_angle + 1.5 * full).rem_euclid(full) - 0.5 * full;
                rate.push(change / seconds);
            }
        }
        *last = Some((time_us, angle));
    }
}

/// The signal from which each quantity was read.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct MotionSources {
    /// For the climb rate.
    pub climb_rate: Option<Name>,
    /// For the speed.
    pub speed: Option<Name>,
    /// For the load factor.
    pub load_factor: Option<Name>,
    /// For the turn rate.
    pub turn_rate: Option<Name>,
}

impl MotionSources {
    /// Signals that the flight would need for the unknown quantities.
    #[must_use]
    pub fn missing(&self) -> Vec<String> {
        let mut missing = Vec::new();
        let mut need = |quantity: &str, channels: &str| {
            missing.push(format!("{quantity} unknown: the flight would need {channels}"));
        };
        if self.climb_rate.is_none() {
            need("climb rate", "gps_vd_mps");
        }
        if self.speed.is_none() {
            need("speed", "tas_mps (or gps_vn_mps and gps_ve_mps)");
        }
        if self.load_factor.is_none() {
            need("load factor", "accel_x_mps2, accel_y_mps2, accel_z_mps2 and gyro_*_radps");
        }
        if self.turn_rate.is_none() {
            need("turn rate", "gps_vn_mps and gps_ve_mps (or yaw_rad)");
        }
        missing
    }
}

/// The motion of every second. A signal of the second-best source is used only where the flight has none of
/// the best.
pub(super) fn motions(seconds: &[SignalMeans]) -> (Vec<Motion>, MotionSources) {
    let any = |signal: fn(&SignalMeans) -> Mean| seconds.iter().any(|means| signal(means).count > 0);
    let series = |signal: fn(&SignalMeans) -> Mean| held(seconds.iter().map(|means| signal(means).get()));
    let none = || vec![None; seconds.len()];
    let mut sources = MotionSources::default();

    let climb = if any(|means| means.doppler_climb) {
        sources.climb_rate = Some("gps_vd_mps".into());
        series(|means| means.doppler_climb)
    } else if any(|means| means.gps_altitude) {
        sources.climb_rate = Some("gps_alt_m, differenced over 4 s".into());
        differences(&series(|means| means.gps_altitude), ALTITUDE_BASE)
    } else {
        none()
    };
    let speed = if any(|means| means.true_airspeed) {
        sources.speed = Some("tas_mps".into());
        series(|means| means.true_airspeed)
    } else if any(|means| means.ground_speed) {
        sources.speed = Some("gps velocity: speed over ground, wind included".into());
        series(|means| means.ground_speed)
    } else {
        none()
    };
    let load = if any(|means| means.load_factor) {
        sources.load_factor = Some("accel_z_mps2".into());
        series(|means| means.load_factor)
    } else {
        none()
    };
    let turn = if any(|means| means.track_rate) {
        sources.turn_rate = Some("gps_vn_mps and gps_ve_mps".into());
        series(|means| means.track_rate)
    } else if any(|means| means.yaw_rate) {
        sources.turn_rate = Some("yaw_rad".into());
        series(|means| means.yaw_rate)
    } else {
        none()
    };
    let growth = differences(&speed, 1);
    let motions = (0..seconds.len())
        .map(|index| Motion {
            climb_rate_mps: climb[index],
            speed_mps: speed[index],
            acceleration_mps2: growth[index],
            load_factor: load[index],
            turn_rate_radps: turn[index],
        })
        .collect();
    (motions, sources)
}

/// Bridges gaps of up to [`HELD_SECONDS`] with the value before them.
fn held(series: impl Iterator<Item = Option<f64>>) -> Vec<Option<f64>> {
    let mut last: Option<(f64, usize)> = None;
    series
        .map(|value| {
            last = match (value, last) {
                (Some(value), _) => Some((value, 0)),
                (None, Some((value, age))) if age < HELD_SECONDS => Some((value, age + 1)),
                (None, _) => None,
            };
            last.map(|(value, _)| value)
        })
        .collect()
}

/// Central differences per second over `2 base` seconds, one-sided at the ends.
fn differences(series: &[Option<f64>], base: usize) -> Vec<Option<f64>> {
    (0..series.len())
        .map(|index| {
            let from = index.saturating_sub(base);
            let to = (index + base).min(series.len() - 1);
            let (before, after) = (series[from]?, series[to]?);
            (to > from).then(|| (after - before) / (to - from) as f64)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use kf_core::input::{ImuSample, Signals};

    fn second(reader: &mut SignalReader, start_us: u64, input: impl Fn(u64) -> TickInput) -> SignalMeans {
        let mut means = SignalMeans::default();
        for tick in 0..5 {
            let time_us = start_us + tick * 200_000;
            reader.take(&TickInput { time_us, ..input(time_us) }, &mut means);
        }
        means
    }

    #[test]
    fn reads_a_turn_across_north_and_a_dive() {
        let mut reader = SignalReader::default();
        let fix = |time_us: u64| {
            // 0.1 rad/s to the right, from 0.2 rad before north; 50 m/s forward, 12 m/s down.
            let track = -0.2 + 0.1e-6 * time_us as f64;
            GpsFix {
                altitude_m: 1_000.0,
                velocity_north_mps: Some((50.0 * track.cos()) as f32),
                velocity_east_mps: Some((50.0 * track.sin()) as f32),
                velocity_down_mps: Some(12.0),
                ..GpsFix::default()
            }
        };
        let seconds: Vec<_> = (0..5)
            .map(|s| {
                second(&mut reader, s * 1_000_000, |t| TickInput {
                    gps: Some(fix(t)),
                    ..TickInput::default()
                })
            })
            .collect();
        let (motions, sources) = motions(&seconds);
        for motion in &motions {
            assert!((motion.turn_rate_radps.unwrap() - 0.1).abs() < 1e-4, "{motion:?}");
            assert_eq!(motion.climb_rate_mps, Some(-12.0));
            assert!((motion.speed_mps.unwrap() - 50.0_f64.hypot(12.0)).abs() < 1e-3);
            assert_eq!(motion.load_factor, None);
        }
        assert_eq!(sources.climb_rate.as_deref(), Some("gps_vd_mps"));
        assert_eq!(sources.missing().len(), 1, "{:?}", sources.missing());
    }

    #[test]
    fn falls_back_on_altitude_and_says_so() {
        let mut reader = SignalReader::default();
        let seconds: Vec<_> = (0..8)
            .map(|s| {
                second(&mut reader, s * 1_000_000, |t| TickInput {
                    gps: Some(GpsFix { altitude_m: 500.0 + 3e-6 * t as f32, ..GpsFix::default() }),
                    signals: Signals { true_airspeed_mps: Some(20.0 + 2.0 * s as f32), ..Signals::default() },
                    imu: Some(ImuSample { accel_mps2: [0.0, 0.0, -19.613_3], gyro_radps: [0.0; 3] }),
                    ..TickInput::default()
                })
            })
            .collect();
        let (motions, sources) = motions(&seconds);
        assert!(motions.iter().all(|motion| (motion.climb_rate_mps.unwrap() - 3.0).abs() < 1e-3));
        assert!(motions.iter().all(|motion| (motion.acceleration_mps2.unwrap() - 2.0).abs() < 1e-9));
        assert!(motions.iter().all(|motion| (motion.load_factor.unwrap() - 2.0).abs() < 1e-6));
        assert_eq!(sources.climb_rate.as_deref(), Some("gps_alt_m, differenced over 4 s"));
        assert_eq!(sources.turn_rate, None);
    }

    #[test]
    fn bridges_short_gaps_only_and_ignores_what_is_not_finite() {
        let mut values = vec![Some(1.0)];
        values.extend([None; 12]);
        let bridged = held(values.into_iter());
        assert_eq!(bridged[10], Some(1.0));
        assert_eq!(bridged[11], None);
        let mut mean = Mean::default();
        mean.push(f64::NAN);
        assert_eq!(mean.get(), None);
    }
}
