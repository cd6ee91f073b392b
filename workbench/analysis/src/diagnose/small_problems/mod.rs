//! Small problems whose answers are known by algebra: one flight of one or two sensors, regressors that are
//! sines, chosen coefficients. One file for each part of the diagnosis that they test.

mod free_flight_excess;
mod interval;
mod judge;
mod long_run;
mod noise_prior;
mod repeatability;
mod rivals;
mod search;
mod unexplained;

use std::f64::consts::TAU;
use std::sync::Arc;

use executor::Inline;
use kf_core::effect::{Clock, EffectId, Regressor};
use kf_core::sensor::{SENSORS, Sensor};
use model::Model;
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution as _, StandardNormal};

use super::candidates::Candidate;
use super::epochs::Epochs;
use super::noise::{GaussMarkov, Noise, NoisePrior, SensorNoise};
use super::physical_range::Bounds;
use super::problem::Problem;
use super::series::{BySensor, Series};
use super::signals::NAMES;
use super::suspects::{Regressors, Suspects};

/// Index of the barometer among the sensors.
const BARO: usize = Sensor::Baro as usize;
/// White noise of a block, metres.
const WHITE_M: f64 = 0.3;
/// The wander that the reference and the sensors are simulated with.
const WANDER: GaussMarkov = GaussMarkov { sigma_m: 0.5, time_s: 20.0 };

/// The noise that the flights are simulated with.
pub(super) const NOISE: Noise = {
    let sensor = SensorNoise {
        wander: GaussMarkov { sigma_m: 0.05, time_s: 30.0 },
        captive_white_m: WHITE_M,
        free_white_m: WHITE_M,
        free_flight_factor: 1.0,
    };
    Noise {
        reference: WANDER,
        slow: GaussMarkov { sigma_m: 0.0, time_s: 1200.0 },
        fix_sigma_m: 0.01,
        sensors: [sensor; SENSORS],
    }
};

/// A flight of one block a second, the first half captive.
pub(super) struct Small {
    pub(super) series: Series,
    candidates: Vec<Candidate>,
    pub(super) bounds: Vec<Bounds>,
    /// Variance of the noise of the candidates' signals.
    signal_noise_m2: f64,
}

/// Sine number `k`: their periods have no common multiple within a flight.
pub(super) fn sine(k: usize, block: usize) -> f64 {
    const PERIODS_S: [f64; 6] = [23.0, 31.0, 41.0, 53.0, 67.0, 83.0];
    (TAU * block as f64 / PERIODS_S[k] + k as f64).sin()
}

impl Small {
    /// A flight of this many seconds in which nothing acts: a bias of 7 m, white noise and the reference's
    /// wander.
    pub(super) fn new(blocks: usize, seed: u64) -> Self {
        let mut generator = ChaCha8Rng::seed_from_u64(seed);
        let mut normal = move || -> f64 { StandardNormal.sample(&mut generator) };
        let keep = (-1.0 / WANDER.time_s).exp();
        let mut wander_m = WANDER.sigma_m * normal();
        let residual_m = (0..blocks).map(|_| {
            wander_m = keep * wander_m + WANDER.sigma_m * (1.0 - keep * keep).sqrt() * normal();
            let mut residual_m = [f64::NAN; SENSORS];
            residual_m[BARO] = 7.0 + wander_m + WHITE_M * normal();
            residual_m
        });
        let series = Series {
            residual_m: residual_m.collect(),
            time_s: (0..blocks).map(|block| block as f64).collect(),
            fixes: vec![1.0; blocks],
            free: (0..blocks).map(|block| block >= blocks / 2).collect(),
            readings: vec![[0, 0, 10]; blocks],
            columns: Vec::new(),
            block_s: 1.0,
            full_block: [10.0; SENSORS],
            forward_sigma_mps2: 0.0,
        };
        Self { series, candidates: Vec::new(), bounds: Vec::new(), signal_noise_m2: 0.0 }
    }

    /// Adds a candidate whose regressor is `of(block)`; its physical range is -10 to 10.
    pub(super) fn candidate(self, id: EffectId, of: impl Fn(usize) -> f64) -> Self {
        self.candidate_in(id, [-10.0, 10.0], of)
    }

    /// As [`Self::candidate`], with the physical range of the coefficient.
    fn candidate_in(mut self, id: EffectId, range: [f64; 2], of: impl Fn(usize) -> f64) -> Self {
        self.series.columns.push(Arc::new(on_baro((0..self.series.len()).map(of))));
        let regressor = Regressor { id, time_constant_s: 0.0, since: Clock::Launch };
        self.candidates.push(Candidate::of(regressor));
        self.bounds.push(Bounds { range, scale: 0.0, consistent: [f64::NEG_INFINITY, f64::INFINITY] });
        self
    }

    /// States the coefficients that agree with the last candidate's shape.
    fn consistent(mut self, with: [f64; 2]) -> Self {
        let last = self.bounds.len() - 1;
        self.bounds[last].consistent = with;
        self
    }

    /// Adds an error of the barometer, metres by block.
    pub(super) fn error(mut self, of: impl Fn(usize) -> f64) -> Self {
        for (block, residual_m) in self.series.residual_m.iter_mut().enumerate() {
            residual_m[BARO] += of(block);
        }
        self
    }

    /// Removes the noise: only the bias and errors added later remain.
    fn noiseless(mut self) -> Self {
        self.series.residual_m.iter_mut().for_each(|residual_m| residual_m[BARO] = 7.0);
        self
    }

    /// The suspects: all candidates.
    pub(super) fn suspects(&self) -> Suspects<'_> {
        let count = self.candidates.len();
        let regressors = Regressors {
            noise_m2: vec![0.0; count],
            attenuating_m2: vec![self.signal_noise_m2; count],
            shape: vec![0.01; count],
            bounds: self.bounds.clone(),
        };
        Suspects::new(&self.candidates, regressors, (0..count).collect())
    }

    /// The flight with signals by name; the other signals were not recorded.
    fn epochs(&self, signals: &[(&str, &dyn Fn(usize) -> f64)]) -> Epochs {
        let of = |block: usize| {
            let value = |name: &&str| signals.iter().find(|(own, _)| own == name).map(|(_, of)| of(block));
            NAMES.iter().map(|name| value(name).unwrap_or(f64::NAN)).collect()
        };
        Epochs {
            signals: (0..self.series.len()).map(of).collect(),
            signal_names: NAMES.iter().map(ToString::to_string).collect(),
            available: vec![true; self.candidates.len()],
            column_noise_m2: vec![0.0; self.candidates.len()],
            climb_noise_m2: 0.0,
            series: self.series.clone(),
            glitches: Vec::new(),
            steps: Vec::new(),
            unreferenced: 0,
            refused: 0,
        }
    }
}

/// A column that acts on the barometer.
fn on_baro(values: impl Iterator<Item = f64>) -> Vec<BySensor> {
    let column = values.map(|value| {
        let mut by_sensor = [0.0; SENSORS];
        by_sensor[BARO] = value;
        by_sensor
    });
    column.collect()
}

/// The default model's prior for some flights.
fn prior(flights: &[Series]) -> NoisePrior {
    let model = Model::default();
    NoisePrior::new(flights, &model.reference, &model.sensors)
}

/// A problem of some flights with the default model's prior.
pub(super) fn problem(flights: &[Series]) -> Problem<'_> {
    Problem::new(flights, prior(flights), Vec::new(), &Inline)
}
