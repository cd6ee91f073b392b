//! Small flights for the tests of the search: one sensor, a block a second, known white noise, and chosen
//! columns.

use std::sync::Arc;

use executor::Inline;
use kf_core::sensor::{SENSORS, Sensor};
use model::Model;

use crate::diagnose::parts::{BySensor, Noise, NoisePrior, Problem, Series};
use crate::diagnose::{GaussMarkov, SensorNoise};

/// Index of the barometer among the sensors.
pub(super) const BARO: usize = Sensor::Baro as usize;
/// White noise of a block, metres.
pub(super) const WHITE_M: f64 = 0.3;

/// White noise only: generalised least squares are ordinary ones over its variance.
pub(super) const WHITE: Noise = {
    const NOTHING: GaussMarkov = GaussMarkov { sigma_m: 0.0, time_s: 20.0 };
    let sensor = SensorNoise {
        wander: NOTHING,
        captive_white_m: WHITE_M,
        free_white_m: WHITE_M,
        free_flight_factor: 1.0,
    };
    Noise { reference: NOTHING, slow: NOTHING, fix_sigma_m: 0.0, sensors: [sensor; SENSORS] }
};

/// Pseudo-random numbers between -1 and 1: a generator of Numerical Recipes.
pub(super) fn noise(seed: u32) -> impl FnMut() -> f64 {
    let mut state = seed;
    move || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(state >> 8) / f64::from(1_u32 << 23) - 1.0
    }
}

/// A flight of the barometer's errors, the first third captive, with columns that act on it.
pub(super) fn flight(errors_m: &[f64], columns: &[&[f64]]) -> Series {
    let on_baro = |value: f64, other: f64| -> BySensor {
        std::array::from_fn(|i| if i == BARO { value } else { other })
    };
    let count = errors_m.len();
    let column =
        |values: &&[f64]| Arc::new(values.iter().map(|value| on_baro(*value, 0.0)).collect::<Vec<_>>());
    Series {
        residual_m: errors_m.iter().map(|error_m| on_baro(*error_m, f64::NAN)).collect(),
        time_s: (0..count).map(|block| block as f64).collect(),
        fixes: vec![1.0; count],
        free: (0..count).map(|block| block >= count / 3).collect(),
        readings: vec![std::array::from_fn(|i| if i == BARO { 10 } else { 0 }); count],
        columns: columns.iter().map(column).collect(),
        block_s: 1.0,
        full_block: [10.0; SENSORS],
        forward_sigma_mps2: 0.0,
    }
}

/// A problem of some flights with the default model's prior.
pub(super) fn problem(flights: &[Series]) -> Problem<'_> {
    let model = Model::default();
    Problem::new(flights, NoisePrior::new(flights, &model.reference, &model.sensors), Vec::new(), &Inline)
}
