//! Flights generated from a log's own track: its smoothed path as the truth, and noise at the log's own
//! levels.

use anyhow::{Context as _, bail};
use model::Model;
use nalgebra::{DMatrix, DVector};
use pylon::flight::{Channel, Column, Flight};
use pylon::replay::Replay;
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;

use super::noise::{heavy, steps, wander};
use crate::median::median;

/// Half of the width of the window beyond which noise counts as slow, seconds.
const SLOW_S: f64 = 15.0;
/// Sigma of the Gaussian that smooths the path, seconds; at least the rows' interval.
const SMOOTH_S: f64 = 2.0;
/// Limit on slow errors, metres: larger ones are a setting or a fault, not noise.
const LARGEST_SLOW_M: f64 = 20.0;
/// Least number of rows of a track.
const FEW_ROWS: usize = 200;

/// The track of a log, and the noise of its two altitudes.
#[derive(Clone, Debug)]
pub struct Track {
    /// The rows that a diagnosis works on.
    pub used: std::ops::Range<usize>,
    /// The smoothed altitude by row, metres; NaN where there is none.
    path_m: Vec<f64>,
    /// Noise of the difference of both altitudes within half a minute, metres.
    pub fast_m: f64,
    /// The slower rest of it, less what depends on height, climb and time, metres.
    pub slow_m: f64,
    /// Step of the altitudes, metres; 0 without steps.
    quantum_m: f64,
    /// True airspeed by row, m/s: the speed over ground less a steady wind; empty where there is none.
    airspeed_mps: Vec<f64>,
}

impl Track {
    /// Computes the track of a log.
    ///
    /// # Errors
    /// If no flight can be made of the log; the text gives the reason.
    pub fn of(flight: &Flight) -> anyhow::Result<Self> {
        let replay = Replay::to_diagnose(flight, &Model::default(), None)?;
        let (start_s, end_s) = replay.extent().used_s;
        let is_used = |time_s: &f64| (start_s..=end_s).contains(time_s);
        let first = flight.time_s.iter().position(is_used).context("no row is used")?;
        let last = flight.time_s.iter().rposition(is_used).context("no row is used")?;
        let (baro, gps) = (flight.channel(Channel::BaroAltM), flight.channel(Channel::GpsAltM));
        let (baro, gps) = (baro.context("no barometer")?, gps.context("no receiver")?);
        let times_s = &flight.time_s;
        let both: Vec<(f64, f64, f64)> = (first..=last)
            .filter_map(|row| Some((times_s[row], f64::from(baro.get(row)?), f64::from(gps.get(row)?))))
            .filter(|(_, baro_m, gps_m)| baro_m.is_finite() && gps_m.is_finite())
            .collect();
        if both.len() < FEW_ROWS {
            bail!("{} rows with both altitudes", both.len());
        }
        if times_s.windows(2).any(|pair| pair[1] <= pair[0]) {
            bail!("its time runs backwards");
        }
        let all: Vec<(f64, f64)> =
            baro.samples().map(|(row, metres)| (times_s[row], f64::from(metres))).collect();
        let interval_s = median(times_s.windows(2).map(|pair| pair[1] - pair[0]).collect());
        let path_m = smoothed(times_s, &all, SMOOTH_S.max(interval_s));
        let (fast_m, slow_m) = levels(&both);
        if median(both.iter().map(|(_, baro_m, _)| (baro_m - both[0].1).abs()).collect()) == 0.0 {
            bail!("its barometer is stuck");
        }
        if slow_m > LARGEST_SLOW_M {
            bail!("barometer and receiver are {slow_m:.0} m apart: too far for noise");
        }
        let is_whole = both.iter().all(|(_, baro_m, gps_m)| baro_m.fract() == 0.0 && gps_m.fract() == 0.0);
        let airspeed_mps = airspeed(flight, first..last + 1).unwrap_or_default();
        let quantum_m = if is_whole { 1.0 } else { 0.0 };
        Ok(Self { used: first..last + 1, path_m, fast_m, slow_m, quantum_m, airspeed_mps })
    }

    /// Total noise, rms, metres.
    #[must_use]
    pub fn noise_m(&self) -> f64 {
        self.fast_m.hypot(self.slow_m)
    }

    /// The flight with both altitudes on the path, without noise or quantisation, and an airspeed where there
    /// is one.
    #[must_use]
    pub fn clean(&self, flight: &Flight) -> Flight {
        let mut clean = flight.clone();
        for channel in [Channel::BaroAltM, Channel::GpsAltM] {
            let Some(old) = flight.channel(channel) else { continue };
            let mut column = Column::with_capacity(old.len());
            for row in 0..old.len() {
                let path_m = self.path_m.get(row).copied().filter(|metres| metres.is_finite());
                column.push(old.get(row).and(path_m).map(|metres| metres as f32));
            }
            clean.set_channel(channel, column);
        }
        if !self.airspeed_mps.is_empty() {
            let mut column = Column::with_capacity(self.airspeed_mps.len());
            for speed_mps in &self.airspeed_mps {
                column.push(Some(*speed_mps as f32).filter(|speed_mps| speed_mps.is_finite()));
            }
            clean.set_channel(Channel::TasMps, column);
        }
        clean
    }

    /// A clean flight, possibly with an effect, with noise; its airspeed is recorded with errors of its own
    /// if `has_airspeed`, else not at all.
    #[must_use]
    pub fn noisy(&self, clean: &Flight, seed: u64, has_airspeed: bool) -> Flight {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let times_s = &clean.time_s;
        let mut flight = clean.clone();
        let gps_wander = wander(&mut random, times_s, 0.7 * self.slow_m, 60.0, 1800.0);
        let gps_steps = steps(&mut random, times_s, 0.5 * self.slow_m, 300.0);
        let averaged = random.random_range(1..5);
        let gps_noise = heavy(&mut random, times_s.len(), 0.85 * self.fast_m, 3.0, averaged);
        let baro_wander = wander(&mut random, times_s, 0.5 * self.slow_m, 300.0, 3000.0);
        let baro_noise = heavy(&mut random, times_s.len(), 0.5 * self.fast_m, 4.0, 1);
        let bias_m = random.random_range(-40.0..40.0);
        let step = |metres: f64| match self.quantum_m {
            quantum_m if quantum_m > 0.0 => (metres / quantum_m).round() * quantum_m,
            _ => metres,
        };
        change(&mut flight, Channel::GpsAltM, &|row, metres| {
            step(metres + gps_wander[row] + gps_steps[row] + gps_noise[row])
        });
        change(&mut flight, Channel::BaroAltM, &|row, metres| {
            step(metres + bias_m + baro_wander[row] + baro_noise[row])
        });
        let scale = 1.0 + random.random_range(-0.02..0.02);
        let speed_noise = heavy(&mut random, times_s.len(), 0.3, 5.0, 2);
        if has_airspeed {
            change(&mut flight, Channel::TasMps, &|row, mps| (mps * scale + speed_noise[row]).max(0.0));
        } else {
            flight.channels.retain(|(channel, _)| *channel != Channel::TasMps);
        }
        flight
    }
}

/// Changes every cell of a channel.
fn change(flight: &mut Flight, channel: Channel, to: &dyn Fn(usize, f64) -> f64) {
    let Some(old) = flight.channel(channel) else { return };
    let mut column = Column::with_capacity(old.len());
    for row in 0..old.len() {
        column.push(old.get(row).map(|value| to(row, f64::from(value)) as f32));
    }
    flight.set_channel(channel, column);
}

/// A smooth path through samples, by local straight lines with Gaussian weights of that sigma (seconds); NaN
/// where no sample is near.
fn smoothed(times_s: &[f64], samples: &[(f64, f64)], sigma_s: f64) -> Vec<f64> {
    let mut first = 0;
    let at = times_s.iter().map(|time_s| {
        while samples.get(first).is_some_and(|(sample_s, _)| *sample_s < time_s - 3.0 * sigma_s) {
            first += 1;
        }
        let near = samples[first..].iter().take_while(|(sample_s, _)| *sample_s <= time_s + 3.0 * sigma_s);
        let (mut n, mut t, mut tt, mut m, mut tm) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for (sample_s, metres) in near {
            let apart_s = sample_s - time_s;
            let weight = (-0.5 * (apart_s / sigma_s).powi(2)).exp();
            n += weight;
            t += weight * apart_s;
            tt += weight * apart_s * apart_s;
            m += weight * metres;
            tm += weight * apart_s * metres;
        }
        let determinant = n * tt - t * t;
        if determinant > 1e-9 { (m * tt - tm * t) / determinant } else { m / n }
    });
    at.collect()
}

/// Rms of the fast and of the slow part of the difference.
fn levels(both: &[(f64, f64, f64)]) -> (f64, f64) {
    let differences: Vec<f64> = both.iter().map(|(_, baro_m, gps_m)| baro_m - gps_m).collect();
    let mean = |k: usize, of: &dyn Fn(usize) -> f64| {
        let time_s = both[k].0;
        let from = both.partition_point(|(other_s, ..)| *other_s < time_s - SLOW_S);
        let to = both.partition_point(|(other_s, ..)| *other_s <= time_s + SLOW_S);
        (from..to).map(of).sum::<f64>() / (to - from) as f64
    };
    let slow: Vec<f64> = (0..both.len()).map(|k| mean(k, &|j| differences[j])).collect();
    // The median of |x| is 0.6745 sigma for a Gaussian.
    let fast_m = median((0..both.len()).map(|k| (differences[k] - slow[k]).abs()).collect()) / 0.6745;
    let start_s = both[0].0;
    let columns = DMatrix::from_fn(both.len(), 4, |k, column| match column {
        0 => 1.0,
        1 => (both[k].0 - start_s) / 1000.0,
        2 => both[k].1 / 1000.0,
        _ => {
            let (before, after) = (k.saturating_sub(2), (k + 2).min(both.len() - 1));
            (both[after].1 - both[before].1) / (both[after].0 - both[before].0)
        }
    });
    let target = DVector::from_vec(slow);
    let fitted = columns.clone().svd(true, true).solve(&target, 1e-9);
    let rest = fitted.map_or_else(|_| target.clone(), |fitted| &target - columns * fitted);
    (fast_m.max(0.1), (rest.norm_squared() / both.len() as f64).sqrt().max(0.3))
}

/// True airspeed from the speed over ground and one wind: the centre of the circle on which the velocities
/// lie (Kasa, "A circle fitting procedure and its error analysis", IEEE Transactions on Instrumentation and
/// Measurement 25, 1976).
fn airspeed(flight: &Flight, used: std::ops::Range<usize>) -> Option<Vec<f64>> {
    let (north, east) = (flight.channel(Channel::GpsVnMps)?, flight.channel(Channel::GpsVeMps)?);
    let velocity = |row: usize| Some((f64::from(north.get(row)?), f64::from(east.get(row)?)));
    let known: Vec<(f64, f64)> = used.filter_map(velocity).collect();
    if known.len() < FEW_ROWS {
        return None;
    }
    let columns =
        DMatrix::from_fn(known.len(), 3, |k, column| [2.0 * known[k].0, 2.0 * known[k].1, 1.0][column]);
    let squares = DVector::from_fn(known.len(), |k, _| known[k].0.powi(2) + known[k].1.powi(2));
    let wind = columns.svd(true, true).solve(&squares, 1e-9).ok()?;
    let samples: Vec<(f64, f64)> = (0..flight.rows())
        .filter_map(|row| {
            let (north, east) = velocity(row)?;
            Some((flight.time_s[row], (north - wind[0]).hypot(east - wind[1])))
        })
        .collect();
    Some(smoothed(&flight.time_s, &samples, SMOOTH_S))
}
