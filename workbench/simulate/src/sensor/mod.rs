//! Simulates the sensors' sampling of the truth: when a sample is taken, its age, noise and resolution.

mod altitude;
mod gps;
mod onboard;

use super::motion::TruthSample;
use super::random::{GaussMarkov, Random};
use super::scenario::{Noise, Sampling};
use flight_data::Channel;

pub(super) use altitude::{ImuAltitude, baro, imu_altitude};
pub(super) use gps::gps;
pub(super) use onboard::{air_data, attitude, inertial};

/// One channel's samples, with their rows.
pub(super) type Series = Vec<(usize, f64)>;
/// What one sensor delivers.
pub(super) type Readings = Vec<(Channel, Series)>;

/// One scheduled sample.
#[derive(Clone, Copy, Debug)]
struct Due {
    row: usize,
    /// Time of the row, s.
    time_s: f64,
    /// Position of what is sampled among the rows: the row less the latency; negative before the first row,
    /// where nothing is known.
    source: f64,
    lost: bool,
}

/// When a sensor samples, and which samples get lost.
fn schedule<'a>(
    sampling: &'a Sampling,
    flight: &'a [TruthSample],
    row_rate_hz: f64,
    mut random: Random,
) -> impl Iterator<Item = Due> + 'a {
    let count = move |row: usize| libm::floor(row as f64 * sampling.rate_hz / row_rate_hz);
    flight.iter().enumerate().filter_map(move |(row, sample)| {
        if row > 0 && count(row) <= count(row - 1) {
            return None;
        }
        let time_s = sample.time_s;
        // Drawn for every sample, so that an outage leaves later dropouts where they were.
        let dropped = random.uniform() < sampling.dropout_probability;
        let out = sampling.outages.iter().any(|outage| outage.contains(time_s));
        Some(Due { row, time_s, source: row as f64 - sampling.latency_s * row_rate_hz, lost: dropped || out })
    })
}

/// A value between rows; `None` before the first row.
fn between(source: f64, value: impl Fn(usize) -> Option<f64>) -> Option<f64> {
    if source < 0.0 {
        return None;
    }
    let row = libm::floor(source);
    let part = source - row;
    let before = value(row as usize)?;
    if part == 0.0 {
        return Some(before);
    }
    Some(before + part * (value(row as usize + 1)? - before))
}

/// White noise and wander of one channel.
struct NoiseSource {
    noise: Noise,
    wander: GaussMarkov,
    last_s: Option<f64>,
}

impl NoiseSource {
    fn new(noise: Noise) -> Self {
        Self { noise, wander: GaussMarkov::default(), last_s: None }
    }

    fn next(&mut self, random: &mut Random, time_s: f64) -> f64 {
        let white = self.noise.white * random.normal();
        if self.noise.wander == 0.0 {
            return white;
        }
        let elapsed = time_s - self.last_s.unwrap_or(time_s);
        self.last_s = Some(time_s);
        white + self.noise.wander * self.wander.next(random, elapsed / self.noise.wander_time_s)
    }
}

/// Rounds to a multiple of the resolution; 0 means no rounding.
fn quantise(value: f64, quantum: f64) -> f64 {
    // Adding zero turns a negative zero into a positive one, as a converter has.
    if quantum > 0.0 { libm::rint(value / quantum) * quantum + 0.0 } else { value }
}

#[cfg(test)]
mod tests;
