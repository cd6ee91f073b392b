//! Errors of healthy sensors against a reference: generated ones, and those of real logs.

use std::fs;
use std::path::{Path, PathBuf};

use kf_core::gauss_markov::mean_variance_factor;
use nalgebra::{Matrix3, Vector3};
use pylon::flight::{Channel, Flight};
use pylon::import::import_file;
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;

/// Duration of calibration before the launch, seconds.
pub const CAPTIVE_S: f64 = 120.0;
/// Duration of free flight, seconds.
pub const FREE_S: f64 = 150.0;
/// Reference of the default preset: error, metres, and its correlation time, seconds.
const REFERENCE_M: f64 = 2.0;
const CORRELATION_S: f64 = 60.0;

/// The error of a healthy sensor in free flight, after the calibration before it.
#[derive(Clone, Debug)]
pub struct Launch {
    /// The errors, metres.
    pub errors_m: Vec<f64>,
    /// Time between two of them, seconds.
    pub interval_s: f64,
    /// The monitor's sigma as latched with the default preset, metres.
    pub sigma_m: f64,
}

impl Launch {
    /// Makes a launch from a residual, cut into calibration and free flight; `None` if it is too short, or
    /// has no spread.
    fn of(residual_m: &[f64], interval_s: f64, correlation_s: f64) -> Option<Self> {
        let captive = (CAPTIVE_S / interval_s) as usize;
        let free = (FREE_S / interval_s) as usize;
        let (captive_m, rest_m) = residual_m.split_at_checked(captive)?;
        let free_m = rest_m.get(..free)?;
        let bias_m = captive_m.iter().sum::<f64>() / captive as f64;
        let variance_m2 =
            captive_m.iter().map(|x| (x - bias_m) * (x - bias_m)).sum::<f64>() / (captive as f64 - 1.0);
        let unseen = f64::from(mean_variance_factor(CAPTIVE_S as f32, correlation_s as f32));
        let sigma_m = (variance_m2 + 2.0 * REFERENCE_M * REFERENCE_M * unseen).sqrt();
        let errors_m = free_m.iter().map(|x| x - bias_m).collect();
        (variance_m2 > 0.0).then_some(Self { errors_m, interval_s, sigma_m })
    }
}

/// A kind of generated residual, at the 5 Hz of a receiver's fixes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Made {
    /// Independent, Gaussian, 2 m.
    White,
    /// The default preset's reference: 2 m of wander over 60 s, and 0.5 m of white noise.
    Wandering,
    /// The same, with white noise of Student's t with three degrees of freedom, and steps of 2 m (Laplace)
    /// every 100 s on average, which decay in 60 s: satellites that rise and set.
    HeavyTails,
}

/// Healthy launches of that kind.
#[must_use]
pub fn made(kind: Made, launches: usize, seed: u64) -> Vec<Launch> {
    const INTERVAL_S: f64 = 0.2;
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let samples = ((CAPTIVE_S + FREE_S) / INTERVAL_S) as usize;
    let kept = (-INTERVAL_S / CORRELATION_S).exp();
    let correlation_s = if kind == Made::White { 0.0 } else { CORRELATION_S };
    let one = |_| {
        let (mut wander, mut steps) = (REFERENCE_M * normal(&mut rng), 0.0);
        let residual_m: Vec<f64> = (0..samples)
            .map(|_| {
                wander = kept * wander + REFERENCE_M * (1.0 - kept * kept).sqrt() * normal(&mut rng);
                steps *= kept;
                match kind {
                    Made::White => REFERENCE_M * normal(&mut rng),
                    Made::Wandering => wander + 0.5 * normal(&mut rng),
                    Made::HeavyTails => {
                        if rng.random::<f64>() < INTERVAL_S / 100.0 {
                            let u = rng.random::<f64>() - 0.5;
                            steps -= 2.0 * u.signum() * (1.0 - 2.0 * u.abs()).max(1e-12).ln();
                        }
                        let squares: f64 = (0..3).map(|_| normal(&mut rng).powi(2)).sum();
                        wander + steps + 0.5 * normal(&mut rng) / (squares / 3.0).sqrt()
                    }
                }
            })
            .collect();
        Launch::of(&residual_m, INTERVAL_S, correlation_s)
    };
    (0..launches).filter_map(one).collect()
}

/// A standard normal number (Box and Muller).
fn normal(rng: &mut ChaCha8Rng) -> f64 {
    let radius = (-2.0 * (1.0 - rng.random::<f64>()).ln()).sqrt();
    radius * (std::f64::consts::TAU * rng.random::<f64>()).cos()
}

/// Which of the real logs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Half {
    /// Logs on which rules were developed: IGC logs with an even number, and the ArduCopter's.
    Development,
    /// Logs for the final figures only: IGC logs with an odd number, or none.
    Final,
}

/// Launches from the real logs.
#[derive(Clone, Debug, Default)]
pub struct Real {
    /// Healthy launches: each log in consecutive pieces.
    pub launches: Vec<Launch>,
    /// Names of the logs that were used.
    pub used: Vec<String>,
    /// Logs without a launch, and why.
    pub skipped: Vec<String>,
}

/// Reads the logs of that half.
#[must_use]
pub fn real(half: Half) -> Real {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/flights/real");
    let mut files: Vec<PathBuf> = fs::read_dir(folder.join("igc_many"))
        .map(|entries| entries.filter_map(|entry| Some(entry.ok()?.path())).collect())
        .unwrap_or_default();
    files.push(folder.join("tlog/dronekit_flight_replay.tlog"));
    files.sort();
    let mut real = Real::default();
    for file in files {
        let name = file.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
        if half_of(&name) != half {
            continue;
        }
        match residual(&file) {
            Err(why) => real.skipped.push(format!("{name}: {why}")),
            Ok((residual_m, interval_s)) => {
                let piece = ((CAPTIVE_S + FREE_S) / interval_s) as usize + 2;
                let pieces = residual_m.chunks(piece);
                let before = real.launches.len();
                real.launches.extend(pieces.filter_map(|piece| Launch::of(piece, interval_s, CORRELATION_S)));
                if real.launches.len() == before {
                    real.skipped.push(format!("{name}: shorter than one piece"));
                } else {
                    real.used.push(name);
                }
            }
        }
    }
    real
}

/// Decides by the last digit of the log's number.
fn half_of(name: &str) -> Half {
    if name.ends_with(".tlog") {
        return Half::Development;
    }
    let digit = name.trim_end_matches(".igc").chars().rev().find_map(|c| c.to_digit(10));
    if digit.is_some_and(|digit| digit % 2 == 0) { Half::Development } else { Half::Final }
}

/// Barometer less receiver in flight, at the median interval, less the part that a straight line in altitude
/// and climb rate explains over the whole log: that part belongs to effects of a model (`baro.scale`,
/// `baro.lag`), not to the noise of a monitor.
fn residual(file: &Path) -> Result<(Vec<f64>, f64), String> {
    let (flight, _) = import_file(file).map_err(|error| error.to_string().lines().collect::<String>())?;
    let (times_s, gps_m, baro_m) = altitudes(&flight).ok_or("no barometer beside the receiver")?;
    let mut steps: Vec<f64> =
        times_s.windows(2).map(|pair| pair[1] - pair[0]).filter(|dt| *dt > 0.0).collect();
    steps.sort_by(f64::total_cmp);
    let interval_s = *steps.get(steps.len() / 2).ok_or("no rows")?;
    if !(0.05..=4.0).contains(&interval_s) {
        return Err(format!("a fix every {interval_s} s"));
    }
    let near = (5.0 / interval_s).ceil() as usize;
    let rows: Vec<usize> = (near..times_s.len().saturating_sub(near))
        .filter(|&k| {
            let dt = times_s[k + near] - times_s[k - near];
            dt < 30.0 && (gps_m[k + near] - gps_m[k - near]).abs() > 0.0
        })
        .collect();
    let climb = |k: usize| (baro_m[k + near] - baro_m[k - near]) / (times_s[k + near] - times_s[k - near]);
    let middle_m = baro_m.iter().sum::<f64>() / baro_m.len() as f64;
    let (mut normal, mut right) = (Matrix3::zeros(), Vector3::zeros());
    let regressors = |k: usize| Vector3::new(1.0, (baro_m[k] - middle_m) / 100.0, climb(k));
    for &k in &rows {
        let row = regressors(k);
        normal += row * row.transpose();
        right += row * (baro_m[k] - gps_m[k]);
    }
    let solution = normal.try_inverse().ok_or("the altitude does not change")? * right;
    let residual_m: Vec<f64> =
        rows.iter().map(|&k| baro_m[k] - gps_m[k] - regressors(k).dot(&solution)).collect();
    Ok((residual_m, interval_s))
}

type Altitudes = (Vec<f64>, Vec<f64>, Vec<f64>);

/// Times, the receiver's altitude and the barometer's, at the rows with a fix and a pressure; the barometer's
/// is its latest.
fn altitudes(flight: &Flight) -> Option<Altitudes> {
    let gps = flight.channel(Channel::GpsAltM)?;
    let (baro, is_pressure) = match flight.channel(Channel::BaroAltM) {
        Some(column) => (column, false),
        None => (flight.channel(Channel::BaroPa)?, true),
    };
    let mut found = Altitudes::default();
    let mut last_m = None;
    for (row, time_s) in flight.time_s.iter().enumerate() {
        let altitude_m = baro.get(row).and_then(|value| {
            if is_pressure { kf_core::atmosphere::pressure_altitude_m(value) } else { Some(value) }
        });
        last_m = altitude_m.or(last_m);
        if let (Some(gps_m), Some(baro_m)) = (gps.get(row), last_m) {
            found.0.push(*time_s);
            found.1.push(f64::from(gps_m));
            found.2.push(f64::from(baro_m));
        }
    }
    // A logger without a barometer writes zeros.
    (found.2.iter().any(|baro_m| *baro_m != 0.0)).then_some(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn made_residuals_have_the_spread_they_claim_and_are_the_seeds() {
        let launches = made(Made::White, 40, 1);
        let squares: f64 = launches.iter().flat_map(|launch| &launch.errors_m).map(|x| x * x).sum();
        let count: usize = launches.iter().map(|launch| launch.errors_m.len()).sum();
        // 30,000 samples: their variance is determined to 0.8 %; the biases add one part in 600.
        assert!((squares / count as f64 / 4.0 - 1.0).abs() < 0.035);
        assert!(launches.iter().all(|launch| (launch.sigma_m / 2.0 - 1.0).abs() < 0.15));
        let again = made(Made::White, 40, 1);
        assert!(launches.iter().zip(&again).all(|(one, other)| one.errors_m == other.errors_m));
    }

    #[test]
    fn every_log_is_of_one_half() {
        assert_eq!(half_of("goigc2_0028.igc"), Half::Development);
        assert_eq!(half_of("goigc2_0011.igc"), Half::Final);
        assert_eq!(half_of("goigc2_2algb9d1.igc"), Half::Final);
        assert_eq!(half_of("dronekit_flight_replay.tlog"), Half::Development);
    }
}
