//! Infers units that the format leaves to the recorder's maker, by what is physically possible.
//!
//! The specification gives airspeeds "in kt, kph, etc." and temperatures in degrees, and makers add decimals
//! without a point. A unit is used only if the data fit it and no other; else the importer keeps the plain
//! numbers as a signal and reports it.

use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};
use thiserror::Error;

use crate::import::airspeed::standard_temperature_c;

/// A unit: its name, and how many of it are one of ours.
pub type Unit = (&'static str, f64);

const SPEED_UNITS: [Unit; 9] = [
    ("km/h", 3.6),
    ("tenths of km/h", 36.0),
    ("hundredths of km/h", 360.0),
    ("kt", 3600.0 / 1852.0),
    ("tenths of kt", 36_000.0 / 1852.0),
    ("hundredths of kt", 360_000.0 / 1852.0),
    ("m/s", 1.0),
    ("tenths of m/s", 10.0),
    ("hundredths of m/s", 100.0),
];
const CLIMB_UNITS: [Unit; 3] = [("m/s", 1.0), ("tenths of m/s", 10.0), ("hundredths of m/s", 100.0)];
const TEMPERATURE_UNITS: [Unit; 3] =
    [("degrees C", 1.0), ("tenths of degrees C", 10.0), ("hundredths of degrees C", 100.0)];

/// Fewest samples for a conclusion.
const FEWEST_SAMPLES: usize = 60;
/// Below this speed over ground an aircraft may be parked, m/s.
const SLOWEST_MPS: f64 = 5.0;
/// A unit fits if this share of the samples...
const MOST: f64 = 0.75;
/// ... fits within this share of the median speed.
const LARGEST_MISFIT: f64 = 0.2;
/// Every other possible unit must have a misfit of at least this factor times the best one's, and times
/// `SMALLEST_MISFIT`.
const CLEARANCE: f64 = 2.0;
const SMALLEST_MISFIT: f64 = 0.03;
/// Largest wind, m/s and as a share of the airspeed.
const STRONGEST_WIND_MPS: f64 = 40.0;
const STRONGEST_WIND_SHARE: f64 = 0.8;
/// Sigma of the wind, and sigma of a speed around the one expected with a constant wind, m/s.
const WIND_SIGMA_MPS: f64 = 10.0;
const SPEED_SIGMA_MPS: f64 = 2.0;
const WIND_STEPS: usize = 8;

/// A unit that was inferred, and the reason.
#[derive(Clone, Debug, PartialEq)]
pub struct Inferred {
    /// The unit.
    pub unit: Unit,
    /// What was compared, and how well it fits.
    pub why: String,
}

/// An airspeed or ground speed as logged, with the velocity over ground at the same time (north, east,
/// m/s).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpeedSample {
    /// The logged number; an indicated airspeed already converted to true airspeed.
    pub raw: f64,
    /// Velocity over ground.
    pub ground_mps: (f64, f64),
}

fn median(values: impl Iterator<Item = f64>) -> f64 {
    quantile(values, 0.5)
}

/// A quantile; NaN without values.
fn quantile(values: impl Iterator<Item = f64>, share: f64) -> f64 {
    let mut values: Vec<f64> = values.collect();
    let index = (values.len() as f64 * share) as usize;
    if index < values.len() { *values.select_nth_unstable_by(index, f64::total_cmp).1 } else { f64::NAN }
}

/// Why a unit could not be inferred.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum UnitUnknown {
    /// There are too few samples.
    #[error("only {found} samples in motion to infer the unit from, expected {FEWEST_SAMPLES}")]
    TooFew {
        /// Samples.
        found: usize,
    },
    /// Two units fit.
    #[error("{best} fits the {speeds}, to {percent:.0} %, but {other} does to {next_percent:.0} % as well")]
    TwoFit {
        /// What the speed was compared with.
        speeds: &'static str,
        /// The unit that fits best.
        best: &'static str,
        /// Its misfit, per cent of the speed.
        percent: f64,
        /// The unit that fits second best.
        other: &'static str,
        /// Its misfit, per cent of the speed.
        next_percent: f64,
    },
    /// No unit fits.
    #[error("no unit fits the {with}")]
    NoneFits {
        /// What the numbers were compared with.
        with: &'static str,
    },
    /// Two units give possible air temperatures.
    #[error("{0} and {1} are both possible")]
    TwoPossible(&'static str, &'static str),
    /// No unit does.
    #[error("no unit gives possible temperatures")]
    NonePossible,
    /// A variometer that does not follow the climb.
    #[error("it does not follow the climb by pressure altitude")]
    DoesNotFollow,
}

/// The constant wind that best explains `|ground - wind| = raw / scale`: Gauss-Newton steps from the
/// least-squares solution of `|ground|^2 - (raw / scale)^2 = 2 ground . wind - |wind|^2`, with its last term
/// free. A weak prior keeps the wind defined where the track never turns.
fn wind_mps(samples: &[SpeedSample], scale: f64) -> Option<Vector2<f64>> {
    let mut normal = Matrix3::zeros();
    let mut right = Vector3::zeros();
    for SpeedSample { raw, ground_mps: (north, east) } in samples {
        let row = Vector3::new(2.0 * north, 2.0 * east, -1.0);
        normal += row * row.transpose();
        right += row * (north * north + east * east - (raw / scale).powi(2));
    }
    normal += Matrix3::identity();
    let start = normal.lu().solve(&right)?;
    let mut wind = Vector2::new(start.x, start.y);
    let prior = (SPEED_SIGMA_MPS / WIND_SIGMA_MPS).powi(2);
    for _ in 0..WIND_STEPS {
        let mut normal = Matrix2::from_diagonal_element(prior);
        let mut right = -prior * wind;
        for SpeedSample { raw, ground_mps: (north, east) } in samples {
            let air = Vector2::new(*north, *east) - wind;
            let speed = air.norm();
            if speed > 0.0 {
                let direction = air / speed;
                normal += direction * direction.transpose();
                right += direction * (speed - raw / scale);
            }
        }
        wind += normal.lu().solve(&right)?;
    }
    Some(wind)
}

/// The unit of a true airspeed.
///
/// # Errors
/// [`UnitUnknown`].
pub fn airspeed_unit(samples: Vec<SpeedSample>) -> Result<Inferred, UnitUnknown> {
    speed_unit(samples, true)
}

/// The unit of a speed over ground.
///
/// # Errors
/// [`UnitUnknown`].
pub fn ground_speed_unit(samples: Vec<SpeedSample>) -> Result<Inferred, UnitUnknown> {
    speed_unit(samples, false)
}

fn speed_unit(mut moving: Vec<SpeedSample>, has_wind: bool) -> Result<Inferred, UnitUnknown> {
    moving.retain(|sample| sample.raw > 0.0 && sample.ground_mps.0.hypot(sample.ground_mps.1) > SLOWEST_MPS);
    if moving.len() < FEWEST_SAMPLES {
        return Err(UnitUnknown::TooFew { found: moving.len() });
    }
    let mut fits: Vec<(f64, f64, Unit)> = Vec::new();
    for unit in SPEED_UNITS {
        let scale = unit.1;
        let wind = if has_wind { wind_mps(&moving, scale) } else { Some(Vector2::zeros()) };
        let Some(wind) = wind else { continue };
        let wind_speed = wind.norm();
        let speed = median(moving.iter().map(|sample| sample.raw / scale));
        if wind_speed > STRONGEST_WIND_MPS.min(STRONGEST_WIND_SHARE * speed) {
            continue;
        }
        let misfits = moving.iter().map(|SpeedSample { raw, ground_mps: (north, east) }| {
            ((Vector2::new(*north, *east) - wind).norm() - raw / scale).abs()
        });
        let misfit = quantile(misfits, MOST);
        fits.push((misfit / speed, wind_speed, unit));
    }
    fits.sort_by(|left, right| left.0.total_cmp(&right.0));
    let speeds = if has_wind { "speed over ground, less a constant wind" } else { "speed over ground" };
    match fits.as_slice() {
        [(misfit, wind_speed, unit), others @ ..] if *misfit <= LARGEST_MISFIT => {
            let percent = 100.0 * misfit;
            match others.first() {
                Some((next, _, other)) if *next < CLEARANCE * misfit.max(SMALLEST_MISFIT) => {
                    let next_percent = 100.0 * next;
                    Err(UnitUnknown::TwoFit { speeds, best: unit.0, percent, other: other.0, next_percent })
                }
                _ => {
                    let wind = if has_wind { format!(" of {wind_speed:.0} m/s") } else { String::new() };
                    let why =
                        format!("it fits the {speeds}{wind}, to {percent:.1} %, and no other unit does");
                    Ok(Inferred { unit: *unit, why })
                }
            }
        }
        _ => Err(UnitUnknown::NoneFits { with: speeds }),
    }
}

/// Largest deviation from the standard atmosphere due to weather, kelvins.
const WEATHER_K: f64 = 35.0;
/// Lower climbs give no lapse rate, metres.
const LOWEST_CLIMB_M: f64 = 300.0;
/// Lapse rates of real air columns, kelvins a kilometre.
const LAPSE_RATES_K_PER_KM: std::ops::RangeInclusive<f64> = -13.0..=-2.5;

/// The unit of an outside air temperature from samples of pressure altitude (metres) and logged number.
///
/// # Errors
/// [`UnitUnknown`].
pub fn temperature_unit(samples: &[(f64, f64)]) -> Result<Inferred, UnitUnknown> {
    if samples.len() < FEWEST_SAMPLES {
        return Err(UnitUnknown::TooFew { found: samples.len() });
    }
    let count = samples.len() as f64;
    let mean = |value: fn(&(f64, f64)) -> f64| samples.iter().map(value).sum::<f64>() / count;
    let (mean_altitude, mean_raw) = (mean(|sample| sample.0), mean(|sample| sample.1));
    let spread: f64 = samples.iter().map(|(altitude, _)| (altitude - mean_altitude).powi(2)).sum();
    let product: f64 =
        samples.iter().map(|(altitude, raw)| (altitude - mean_altitude) * (raw - mean_raw)).sum();
    let lowest = samples.iter().map(|sample| sample.0).fold(f64::INFINITY, f64::min);
    let highest = samples.iter().map(|sample| sample.0).fold(f64::NEG_INFINITY, f64::max);
    let lapse = (highest - lowest > LOWEST_CLIMB_M).then_some(1000.0 * product / spread);
    let mut possible = TEMPERATURE_UNITS.into_iter().filter_map(|unit| {
        let deviation =
            median(samples.iter().map(|(altitude, raw)| raw / unit.1 - standard_temperature_c(*altitude)));
        let lapse = lapse.map(|lapse| lapse / unit.1);
        let fits =
            deviation.abs() <= WEATHER_K && lapse.is_none_or(|lapse| LAPSE_RATES_K_PER_KM.contains(&lapse));
        fits.then_some((unit, deviation, lapse))
    });
    match (possible.next(), possible.next()) {
        (Some((unit, deviation, lapse)), None) => {
            let lapse = lapse.map_or_else(String::new, |lapse| format!(" and {lapse:.1} K/km"));
            let why = format!(
                "that is {deviation:+.0} K from the standard atmosphere{lapse}, and other units are impossible"
            );
            Ok(Inferred { unit, why })
        }
        (Some((unit, ..)), Some((other, ..))) => Err(UnitUnknown::TwoPossible(unit.0, other.0)),
        (None, _) => Err(UnitUnknown::NonePossible),
    }
}

/// The unit of a variometer from samples of climb rate (m/s, by pressure altitude) and logged number.
///
/// # Errors
/// [`UnitUnknown`].
pub fn climb_unit(samples: &[(f64, f64)]) -> Result<Inferred, UnitUnknown> {
    if samples.len() < FEWEST_SAMPLES {
        return Err(UnitUnknown::TooFew { found: samples.len() });
    }
    let sum = |value: fn(&(f64, f64)) -> f64| samples.iter().map(value).sum::<f64>();
    let (climb2, raw2, product) =
        (sum(|(climb, _)| climb * climb), sum(|(_, raw)| raw * raw), sum(|(climb, raw)| climb * raw));
    let correlation = product / (climb2 * raw2).sqrt();
    // Its reciprocal regression brackets the scale from above, this one from below.
    let scale = (product / climb2) / correlation;
    if correlation.is_nan() || correlation <= 0.5 {
        return Err(UnitUnknown::DoesNotFollow);
    }
    CLIMB_UNITS
        .into_iter()
        .find(|unit| (scale / unit.1).ln().abs() < 2.0_f64.ln())
        .map(|unit| Inferred {
            unit,
            why: format!("it follows the climb by pressure altitude (correlation {correlation:.2})"),
        })
        .ok_or(UnitUnknown::NoneFits { with: "climb by pressure altitude" })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::import::airspeed::true_airspeed_factor;

    /// A glider at 28 m/s in a wind of 8 m/s from the west: circles, or straight to the north.
    fn flight(circles: bool, scale: f64) -> Vec<SpeedSample> {
        (0..600)
            .map(|second| {
                let heading = if circles { f64::from(second) * 0.25 } else { 0.0 };
                let speed = 28.0 + 3.0 * (f64::from(second) * 0.05).sin();
                SpeedSample {
                    raw: (speed * scale).round(),
                    ground_mps: (speed * heading.cos(), speed * heading.sin() + 8.0),
                }
            })
            .collect()
    }

    #[test]
    fn tells_every_airspeed_unit_from_a_flight_that_turns() {
        for unit in SPEED_UNITS {
            let inferred = airspeed_unit(flight(true, unit.1)).unwrap();
            assert_eq!(inferred.unit, unit);
            assert!(inferred.why.contains("wind of 8 m/s"), "{}", inferred.why);
        }
    }

    #[test]
    fn tells_every_ground_speed_unit() {
        for unit in SPEED_UNITS {
            let samples: Vec<_> = flight(true, 1.0)
                .into_iter()
                .map(|sample| {
                    let (north, east) = sample.ground_mps;
                    SpeedSample { raw: (north.hypot(east) * unit.1).round(), ..sample }
                })
                .collect();
            assert_eq!(ground_speed_unit(samples).unwrap().unit, unit);
        }
    }

    #[test]
    fn refuses_what_it_can_not_tell() {
        // Straight and at one speed: kt with a tail wind look like km/h with a head wind.
        let straight: Vec<_> = (0..600).map(|_| SpeedSample { raw: 50.0, ground_mps: (20.0, 0.0) }).collect();
        let refused = airspeed_unit(straight).unwrap_err().to_string();
        assert!(refused.contains("as well"), "{refused}");
        assert_eq!(airspeed_unit(flight(true, 3.6)[..59].to_vec()), Err(UnitUnknown::TooFew { found: 59 }));
        // A number unrelated to speed.
        let other: Vec<_> = flight(true, 1.0)
            .into_iter()
            .enumerate()
            .map(|(index, sample)| SpeedSample { raw: if index % 2 == 0 { 10.0 } else { 400.0 }, ..sample })
            .collect();
        assert!(matches!(airspeed_unit(other), Err(UnitUnknown::NoneFits { .. })));
    }

    #[test]
    fn tells_temperatures_by_atmosphere_and_lapse() {
        let climb = |scale: f64| -> Vec<(f64, f64)> {
            (0..200)
                .map(|step| (10.0 * f64::from(step), ((20.0 - 0.08 * f64::from(step)) * scale).round()))
                .collect()
        };
        for unit in TEMPERATURE_UNITS {
            assert_eq!(temperature_unit(&climb(unit.1)).unwrap().unit, unit);
        }
        // 12 degrees or 1.2 degrees at constant altitude: both are possible.
        let level: Vec<_> = (0..200).map(|_| (1000.0, 120.0)).collect();
        assert_eq!(
            temperature_unit(&level).unwrap_err().to_string(),
            "tenths of degrees C and hundredths of degrees C are both possible"
        );
        let broken: Vec<_> = (0..200).map(|step| (10.0 * f64::from(step), 9999.0)).collect();
        assert!(temperature_unit(&broken).is_err());
    }

    #[test]
    fn tells_variometers_by_the_climb() {
        let climb = |scale: f64| -> Vec<(f64, f64)> {
            (0..200)
                .map(|step| {
                    let rate = 3.0 * (f64::from(step) * 0.1).sin();
                    (rate + 0.5 * (f64::from(step) * 1.7).sin(), (rate * scale).round())
                })
                .collect()
        };
        for unit in CLIMB_UNITS {
            assert_eq!(climb_unit(&climb(unit.1)).unwrap().unit, unit);
        }
        let unrelated: Vec<_> = climb(1.0).into_iter().map(|(rate, _)| (rate, 5.0)).collect();
        assert_eq!(climb_unit(&unrelated), Err(UnitUnknown::DoesNotFollow));
    }

    #[test]
    fn true_airspeed_grows_as_density_falls() {
        // ICAO standard atmosphere: density ratio 0.8217 at 2000 m, 0.2971 at 11 000 m, 0.1851 at 14 000 m.
        for (altitude, ratio) in [(0.0, 1.0), (2000.0, 0.8217), (11_000.0, 0.2971), (14_000.0, 0.1851)] {
            let factor = true_airspeed_factor(altitude, standard_temperature_c(altitude));
            assert!((factor - 1.0 / f64::sqrt(ratio)).abs() < 1e-3, "{altitude}: {factor}");
        }
        // Warmer air is thinner.
        assert!((true_airspeed_factor(0.0, 44.0) - (317.15_f64 / 288.15).sqrt()).abs() < 1e-12);
    }
}
