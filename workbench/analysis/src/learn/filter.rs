//! A coefficient by the core's own filter: what the flight computer would have learned if it had known the
//! noise.
//!
//! The states are the reference's wander, the white noise of a block's fixes, the slow wander, each sensor's
//! wander, the sensors' biases, the wind's two, and one coefficient for each term, all in single precision.

use kf_core::error::FilterError;
use kf_core::sensor::SENSORS;
use kf_core::ud::{NoiseVariance, Row, UdFilter};
use thiserror::Error;

use crate::diagnose::{BySensor, LearningProblem, Noise, Series, Term};

/// Index of the first of the sensors' wanders.
const WANDER: usize = 3;
/// Index of the first bias.
const BIAS: usize = WANDER + SENSORS;
/// Index of the first wind state.
const WIND: usize = BIAS + SENSORS;
/// Index of the first coefficient.
const COEFFICIENTS: usize = WIND + 2;
/// Maximum number of terms: a model's 16 effects, the five that a diagnosis may find, and the one that is
/// learned.
const MOST_TERMS: usize = 22;

/// Prior sigma of a bias about its first reading, metres: unknown.
const BIAS_SIGMA_M: f64 = 1000.0;
/// Prior sigma of an unknown coefficient, in multiples of the physically largest one.
const PRIOR_RANGES: f64 = 30.0;

/// A coefficient as the filter learned it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Learned {
    /// The coefficient, in its effect's unit.
    pub coefficient: f64,
    /// Its sigma by the filter alone.
    pub filter_sigma: f64,
    /// One sigma of it, including its spread over the parts of the flights and its signals' scale errors.
    pub sigma: f64,
    /// The same without what is a share of the coefficient itself, for how far it is from zero: where the effect
    /// does not act, that share is nothing.
    pub sigma_to_zero: f64,
}

/// Why a coefficient was not learned.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum LearnError {
    /// More terms than the filter holds.
    #[error("{0} effects at once, expected at most {MOST_TERMS}")]
    TooMany(usize),
    /// The filter rejected a value.
    #[error("the filter stopped at block {block}: {error:?}")]
    Filter {
        /// The block of the flight, from 0.
        block: usize,
        /// Why.
        error: FilterError,
    },
}

/// Runs the filter over a problem; its first term is the one to learn.
///
/// # Errors
/// See [`LearnError`].
pub fn learn(problem: &LearningProblem) -> Result<Learned, LearnError> {
    match problem.terms.len() {
        terms @ 1..=2 => sized::<{ COEFFICIENTS + 2 }>(problem, terms),
        terms @ 3..=6 => sized::<{ COEFFICIENTS + 6 }>(problem, terms),
        terms @ 7..=12 => sized::<{ COEFFICIENTS + 12 }>(problem, terms),
        terms => sized::<{ COEFFICIENTS + MOST_TERMS }>(problem, terms),
    }
}

/// With a filter of this many states, of which those without a term are known to be zero.
fn sized<const STATES: usize>(problem: &LearningProblem, terms: usize) -> Result<Learned, LearnError> {
    let (Some(term), true) = (problem.terms.first(), COEFFICIENTS + terms <= STATES) else {
        return Err(LearnError::TooMany(terms));
    };
    let mut filter =
        start::<STATES>(&problem.terms).map_err(|error| LearnError::Filter { block: 0, error })?;
    for flight in &problem.flights {
        fly(&mut filter, flight, problem)?;
    }
    let unit = unit(term);
    let coefficient = f64::from(filter.tail()[COEFFICIENTS]) * unit;
    let variance = f64::from(filter.variance(COEFFICIENTS)) * unit * unit;
    let squares = variance * problem.inflation + problem.beyond_noise;
    Ok(Learned {
        coefficient,
        filter_sigma: variance.sqrt(),
        sigma: squares.sqrt(),
        sigma_to_zero: (squares - problem.relative).sqrt(),
    })
}

/// The coefficient that moves a sensor by a metre in flight: the unit of its state.
fn unit(term: &Term) -> f64 {
    1.0 / f64::from(term.regressor.id.typical_regressor_m())
}

/// A filter that knows only what the model contains about its own effects.
fn start<const STATES: usize>(terms: &[Term]) -> Result<UdFilter<0, STATES>, FilterError> {
    let mut variance = [0.0; STATES];
    for (slot, term) in variance.iter_mut().skip(COEFFICIENTS).zip(terms) {
        let bounds = term.regressor.id.plausible();
        let largest = bounds.iter().fold(0.0_f64, |most, bound| most.max(f64::from(bound.abs())));
        let sigma = term.known_sigma.unwrap_or(PRIOR_RANGES * largest) / unit(term);
        *slot = (sigma * sigma) as f32;
    }
    UdFilter::new([], [], [0.0; STATES], variance)
}

fn fly<const STATES: usize>(
    filter: &mut UdFilter<0, STATES>,
    flight: &Series,
    problem: &LearningProblem,
) -> Result<(), LearnError> {
    let LearningProblem { noise, terms, wind, .. } = problem;
    let wind_sigmas = wind.map_or([0.0; 2], |wind| wind.map(|nuisance| nuisance.sigma));
    // A bias is counted from the sensor's first reading: the rest is small enough for single precision.
    let first_m: BySensor = std::array::from_fn(|i| {
        let mut readings = flight.residual_m.iter().map(|residuals| residuals[i]);
        readings.find(|residual| residual.is_finite()).unwrap_or(0.0)
    });
    let mut last_s = None;
    for block in 0..flight.len() {
        let in_block = |error| LearnError::Filter { block, error };
        let elapsed_s = last_s.map(|last_s: f64| flight.time_s[block] - last_s);
        last_s = Some(flight.time_s[block]);
        match elapsed_s {
            None => begin(filter, noise, flight.fixes[block], wind_sigmas),
            Some(elapsed_s) => carry(filter, noise, elapsed_s, flight.free[block], flight.fixes[block]),
        }
        .map_err(in_block)?;
        for sensor in 0..SENSORS {
            let residual_m = flight.residual_m[block][sensor];
            if !residual_m.is_finite() {
                continue;
            }
            let own = &noise.sensors[sensor];
            let white_m = if flight.free[block] { own.free_white_m } else { own.captive_white_m };
            let share = flight.full_block[sensor] / f64::from(flight.readings[block][sensor]);
            let mut row = [0.0; STATES];
            row[0] = 1.0;
            row[1] = 1.0;
            row[2] = 1.0;
            row[WANDER + sensor] = 1.0;
            row[BIAS + sensor] = 1.0;
            for (slot, nuisance) in row.iter_mut().skip(WIND).zip(wind.iter().flatten()) {
                *slot = flight.columns[nuisance.column][block][sensor] as f32;
            }
            for (slot, term) in row.iter_mut().skip(COEFFICIENTS).zip(terms) {
                *slot = (flight.columns[term.column][block][sensor] * unit(term)) as f32;
            }
            let variance = NoiseVariance::new((white_m * white_m * share) as f32).map_err(in_block)?;
            let row = Row { head: None, tail: row, first: 0 };
            filter.update(&row, (residual_m - first_m[sensor]) as f32, variance).map_err(in_block)?;
        }
        filter.fold();
    }
    Ok(())
}

/// The start of a flight: of its noise only the size is known, and biases and wind are not those of the last
/// flight.
fn begin<const STATES: usize>(
    filter: &mut UdFilter<0, STATES>,
    noise: &Noise,
    fixes: f64,
    wind_sigmas: [f64; 2],
) -> Result<(), FilterError> {
    let mut added_m2 = [0.0; COEFFICIENTS];
    let sigmas = [noise.reference.sigma_m, noise.fix_sigma_m / fixes.sqrt(), noise.slow.sigma_m]
        .into_iter()
        .chain(noise.sensors.map(|sensor| sensor.wander.sigma_m))
        .chain([BIAS_SIGMA_M; SENSORS])
        .chain(wind_sigmas);
    for (added, sigma) in added_m2.iter_mut().zip(sigmas) {
        *added = (sigma * sigma) as f32;
    }
    propagate(filter, &[0.0; COEFFICIENTS], &added_m2)
}

/// Carries the noise to the next block.
fn carry<const STATES: usize>(
    filter: &mut UdFilter<0, STATES>,
    noise: &Noise,
    elapsed_s: f64,
    free: bool,
    fixes: f64,
) -> Result<(), FilterError> {
    let mut kept = [1.0; COEFFICIENTS];
    let mut added_m2 = [0.0; COEFFICIENTS];
    let mut process = |state: usize, sigma_m: f64, time_s: f64| {
        let share = libm::exp(-elapsed_s / time_s);
        kept[state] = share as f32;
        added_m2[state] = (sigma_m * sigma_m * (1.0 - share * share)) as f32;
    };
    process(0, noise.reference.sigma_m, noise.reference.time_s);
    process(2, noise.slow.sigma_m, noise.slow.time_s);
    for (i, sensor) in noise.sensors.iter().enumerate() {
        let factor = if free { sensor.free_flight_factor } else { 1.0 };
        process(WANDER + i, sensor.wander.sigma_m * factor, sensor.wander.time_s);
    }
    kept[1] = 0.0;
    added_m2[1] = (noise.fix_sigma_m * noise.fix_sigma_m / fixes) as f32;
    propagate(filter, &kept, &added_m2)
}

/// Keeps the share of each state except the coefficients, and adds variance to it.
fn propagate<const STATES: usize>(
    filter: &mut UdFilter<0, STATES>,
    kept: &[f32; COEFFICIENTS],
    added_m2: &[f32; COEFFICIENTS],
) -> Result<(), FilterError> {
    let mut transition = [[0.0; STATES]; STATES];
    for (state, row) in transition.iter_mut().enumerate() {
        row[state] = kept.get(state).copied().unwrap_or(1.0);
    }
    let mut inputs = [[0.0; COEFFICIENTS]; STATES];
    for (state, row) in inputs.iter_mut().take(COEFFICIENTS).enumerate() {
        row[state] = 1.0;
    }
    filter.propagate(&transition, &[0.0; STATES], &inputs, added_m2)
}
