//! The score: the derivative of the likelihood with respect to the noise's parameters, and the weights of
//! readings, by one pass of the filter forward and one backward (Koopman and Shephard, "Exact score for time
//! series models in state space form", Biometrika 79, 1992; de Jong, "Smoothing and interpolation with the
//! state-space model", Journal of the American Statistical Association 84, 1989). Finite differences would
//! need a pass for every parameter.
//!
//! With the readings' covariance `V` and columns `q` that do not depend on the noise, the slope is that of
//!
//! `log |V| + sum over q of q' V^-1 q`.

use kf_core::sensor::SENSORS;

use super::noise::{Noise, NoiseSlope, ProcessSlope, white_share};
use super::series::{BySensor, Series};
use super::whitener::{Decay, FIX, LANES, Means, OWN, Pass, Reading, STATES, State, filter};

/// The filter's forward pass: all that the backward pass needs.
struct Tape {
    /// The step into each block, in the flight's order.
    steps: Vec<Step>,
    /// Means before each step, `groups` per step.
    means: Vec<Means>,
    readings: Vec<Kept>,
    /// Weighted innovations, `groups` per reading.
    innovations: Vec<[f64; LANES]>,
}

struct Step {
    decay: Decay,
    /// The states' covariance before the step.
    covariance: [State; STATES],
    /// How many readings came before the step.
    first: usize,
}

struct Kept {
    block: usize,
    sensor: usize,
    /// The filter's gain divided by the innovation's variance.
    gain: State,
    /// Inverse of that variance.
    inverse: f64,
}

impl Pass for Tape {
    fn block(&mut self, covariance: &[State; STATES], means: &[Means], decay: &Decay) {
        self.steps.push(Step { decay: *decay, covariance: *covariance, first: self.readings.len() });
        self.means.extend_from_slice(means);
    }

    fn reading(&mut self, reading: &Reading<'_>) {
        let inverse = reading.scale * reading.scale;
        self.readings.push(Kept {
            block: reading.block,
            sensor: reading.sensor,
            gain: reading.gain.map(|gain| gain * inverse),
            inverse,
        });
        let innovations = reading.row.iter().map(|row| row.map(|value| value * reading.scale));
        self.innovations.extend(innovations);
    }
}

fn recorded(series: &Series, noise: &Noise, columns: &[&[BySensor]]) -> Tape {
    let mut tape =
        Tape { steps: Vec::new(), means: Vec::new(), readings: Vec::new(), innovations: Vec::new() };
    tape.steps.reserve(series.len());
    filter(series, noise, columns, &|_| true, &mut tape);
    tape
}

/// Information of the readings after some time about the states at that time: `r` for every column, `N` for
/// the readings themselves (the papers' letters).
struct Backward {
    columns: Vec<Means>,
    information: [State; STATES],
}

impl Backward {
    fn new(groups: usize) -> Self {
        Self { columns: vec![[[0.0; LANES]; STATES]; groups], information: [[0.0; STATES]; STATES] }
    }

    /// Processes a reading with its innovations over their variance. `weights` then holds the columns'
    /// weights in `V^-1 q`, and the result is the diagonal of `V^-1`, both of that reading.
    fn take(&mut self, reading: &Kept, innovations: &[[f64; LANES]], weights: &mut [[f64; LANES]]) -> f64 {
        let read = [0, FIX, 2, OWN + reading.sensor];
        for ((columns, innovations), weights) in self.columns.iter_mut().zip(innovations).zip(weights) {
            *weights = *innovations;
            for (column, gain) in columns.iter().zip(&reading.gain) {
                for (weight, value) in weights.iter_mut().zip(column) {
                    *weight -= gain * value;
                }
            }
            for state in read {
                for (value, weight) in columns[state].iter_mut().zip(&*weights) {
                    *value += weight;
                }
            }
        }
        let by_gain: State = std::array::from_fn(|j| {
            self.information[j].iter().zip(&reading.gain).map(|(entry, gain)| entry * gain).sum()
        });
        let diagonal = reading.inverse
            + by_gain.iter().zip(&reading.gain).map(|(entry, gain)| entry * gain).sum::<f64>();
        for state in read {
            for (j, by_gain) in by_gain.iter().enumerate() {
                self.information[state][j] -= by_gain;
                self.information[j][state] -= by_gain;
            }
        }
        for j in read {
            for k in read {
                self.information[j][k] += diagonal;
            }
        }
        diagonal
    }

    /// The derivative with respect to the states' covariance at the current time of the backward pass.
    fn slope(&self, j: usize, k: usize) -> f64 {
        let columns = self.columns.iter().map(|columns| dot(&columns[j], &columns[k]));
        self.information[j][k] - columns.sum::<f64>()
    }

    fn carry(&mut self, keep: &State) {
        for columns in &mut self.columns {
            for (column, keep) in columns.iter_mut().zip(keep) {
                *column = column.map(|value| value * keep);
            }
        }
        for (row, own) in self.information.iter_mut().zip(keep) {
            for (entry, keep) in row.iter_mut().zip(keep) {
                *entry *= own * keep;
            }
        }
    }
}

fn dot(one: &[f64; LANES], other: &[f64; LANES]) -> f64 {
    one.iter().zip(other).map(|(one, other)| one * other).sum()
}

/// The backward pass over a flight, reading by reading and block by block, the last first. `reading` receives
/// each reading's diagonal of `V^-1` and its weights, `block` each step into a block before it is reversed.
/// The pass ends before the first block.
fn back(
    tape: &Tape,
    groups: usize,
    mut reading: impl FnMut(&Kept, f64, &[[f64; LANES]]),
    mut block: impl FnMut(usize, &Step, &Backward),
) -> Backward {
    let mut backward = Backward::new(groups);
    let mut weights = vec![[0.0; LANES]; groups];
    let mut last = tape.readings.len();
    for (k, step) in tape.steps.iter().enumerate().rev() {
        for at in (step.first..last).rev() {
            let innovations = &tape.innovations[at * groups..(at + 1) * groups];
            let diagonal = backward.take(&tape.readings[at], innovations, &mut weights);
            reading(&tape.readings[at], diagonal, &weights);
        }
        last = step.first;
        block(k, step, &backward);
        backward.carry(&step.decay.keep);
    }
    backward
}

/// The derivatives of `log |V| + sum of q' V^-1 q` over the columns.
#[must_use]
pub fn score(series: &Series, noise: &Noise, columns: &[&[BySensor]]) -> NoiseSlope {
    let groups = columns.len().div_ceil(LANES);
    let tape = recorded(series, noise, columns);
    let mut whites = [[0.0; 2]; SENSORS];
    let mut slope = NoiseSlope::default();
    let first = back(
        &tape,
        groups,
        |reading, diagonal, weights| {
            let squares: f64 = weights.iter().map(|weights| dot(weights, weights)).sum();
            let share = white_share(series, reading.block, reading.sensor);
            let phase = usize::from(series.free[reading.block]);
            whites[reading.sensor][phase] += share * (diagonal - squares);
        },
        |block, step, backward| {
            slope.fix_variance += backward.slope(FIX, FIX) / series.fixes[block];
            let means = &tape.means[block * groups..(block + 1) * groups];
            step.add(&mut slope, noise, backward, means);
        },
    );
    slope.reference.variance += first.slope(0, 0);
    slope.slow.variance += first.slope(2, 2);
    for (i, (sensor, [captive, free])) in slope.sensors.iter_mut().zip(whites).enumerate() {
        sensor.captive.variance += first.slope(OWN + i, OWN + i);
        sensor.captive_white_variance = captive;
        sensor.free_white_variance = free;
    }
    slope
}

impl Step {
    /// Adds the derivatives with respect to the processes that carry the states into a block.
    fn add(&self, slope: &mut NoiseSlope, noise: &Noise, backward: &Backward, means: &[Means]) {
        let of = |state: usize, sigma_m: f64, time_s: f64| {
            let keep = self.decay.keep[state];
            let new = backward.slope(state, state);
            let mut by_keep = -2.0 * sigma_m * sigma_m * keep * new;
            for (k, other) in self.decay.keep.iter().enumerate() {
                by_keep += 2.0 * backward.slope(state, k) * other * self.covariance[state][k];
            }
            for (columns, means) in backward.columns.iter().zip(means) {
                by_keep -= 2.0 * dot(&columns[state], &means[state]);
            }
            ProcessSlope {
                variance: (1.0 - keep * keep) * new,
                time: by_keep * keep * self.decay.elapsed_s / (time_s * time_s),
            }
        };
        let add = |sum: &mut ProcessSlope, new: ProcessSlope| {
            sum.variance += new.variance;
            sum.time += new.time;
        };
        add(&mut slope.reference, of(0, noise.reference.sigma_m, noise.reference.time_s));
        add(&mut slope.slow, of(2, noise.slow.sigma_m, noise.slow.time_s));
        for (i, (sum, sensor)) in slope.sensors.iter_mut().zip(&noise.sensors).enumerate() {
            let factor = if self.decay.free { sensor.free_flight_factor } else { 1.0 };
            let mut new = of(OWN + i, sensor.wander.sigma_m * factor, sensor.wander.time_s);
            if self.decay.free {
                sum.free_variance += new.variance;
                new.variance = 0.0;
            }
            add(&mut sum.captive, new);
        }
    }
}

/// The weights of all readings in each column's products with others, `V^-1 q`, 1/m: block, sensor and a row
/// with one weight per column, the last reading first.
pub fn weights(
    series: &Series,
    noise: &Noise,
    columns: &[&[BySensor]],
    sink: &mut dyn FnMut(usize, usize, &[f64]),
) {
    let tape = recorded(series, noise, columns);
    back(
        &tape,
        columns.len().div_ceil(LANES),
        |reading, _, weights| {
            sink(reading.block, reading.sensor, &weights.as_flattened()[..columns.len()]);
        },
        |_, _, _| (),
    );
}

#[cfg(test)]
mod tests {
    use super::super::whitener::small::{dense, noise, series};
    use super::*;

    fn column(series: &Series, of: impl Fn(usize, usize) -> f64) -> Vec<BySensor> {
        (0..series.len()).map(|block| std::array::from_fn(|sensor| of(block, sensor))).collect()
    }

    /// `V^-1 q` of the dense covariance, reading by reading.
    #[test]
    fn weights_are_those_of_the_dense_covariance() {
        let (series, noise) = (series(), noise());
        let (covariance, values) = dense(&series, &noise);
        let other = column(&series, |block, sensor| (block as f64 * 0.7 + sensor as f64).sin());
        let expected = covariance.cholesky().unwrap().inverse() * nalgebra::DVector::from_vec(values);
        let mut found: Vec<(usize, usize, f64)> = Vec::new();
        weights(&series, &noise, &[&other, &series.residual_m], &mut |block, sensor, row| {
            assert_eq!(row.len(), 2);
            found.push((block, sensor, row[1]));
        });
        found.reverse();
        let in_order: Vec<(usize, usize)> =
            found.iter().map(|(block, sensor, _)| (*block, *sensor)).collect();
        assert!(in_order.is_sorted());
        assert_eq!(found.len(), expected.len());
        for ((block, sensor, weight), expected) in found.iter().zip(expected.iter()) {
            assert!((weight - expected).abs() < 1e-9, "{block} {sensor}: {weight}, expected {expected}");
        }
    }

    /// The slope in each parameter of the noise is that of `log |V| + q' V^-1 q + p' V^-1 p` of the dense
    /// covariance, by central differences.
    #[test]
    fn the_score_is_the_slope_of_the_dense_likelihood() {
        let (series, noise) = (series(), noise());
        let other = column(&series, |block, sensor| (block as f64 * 0.7 + sensor as f64).sin());
        let value = |noise: &Noise| {
            let (covariance, values) = dense(&series, noise);
            let mut others = Vec::new();
            for (block, own) in other.iter().enumerate() {
                others.extend((0..3).filter(|i| series.residual_m[block][*i].is_finite()).map(|i| own[i]));
            }
            let factor = covariance.cholesky().unwrap();
            let squares = |values: Vec<f64>| {
                let values = nalgebra::DVector::from_vec(values);
                values.dot(&factor.solve(&values))
            };
            let determinant = 2.0 * factor.l().diagonal().iter().map(|x| x.ln()).sum::<f64>();
            determinant + squares(values) + squares(others)
        };
        let slope = score(&series, &noise, &[&series.residual_m, &other]);
        type Number = fn(&mut Noise) -> &mut f64;
        let in_variance = |slope: f64, sigma_m: f64| 2.0 * sigma_m * slope;
        let of = &slope.sensors[1];
        let own = &noise.sensors[1];
        // Its free-flight factor is one.
        let wander = of.captive.variance + of.free_variance;
        let numbers: [(Number, f64); 9] = [
            (|n| &mut n.reference.sigma_m, in_variance(slope.reference.variance, noise.reference.sigma_m)),
            (|n| &mut n.reference.time_s, slope.reference.time),
            (|n| &mut n.slow.sigma_m, in_variance(slope.slow.variance, noise.slow.sigma_m)),
            (|n| &mut n.slow.time_s, slope.slow.time),
            (|n| &mut n.fix_sigma_m, in_variance(slope.fix_variance, noise.fix_sigma_m)),
            (|n| &mut n.sensors[1].wander.sigma_m, in_variance(wander, own.wander.sigma_m)),
            (|n| &mut n.sensors[1].wander.time_s, of.captive.time),
            (
                |n| &mut n.sensors[1].captive_white_m,
                in_variance(of.captive_white_variance, own.captive_white_m),
            ),
            (|n| &mut n.sensors[1].free_white_m, in_variance(of.free_white_variance, own.free_white_m)),
        ];
        for (k, (number, slope)) in numbers.into_iter().enumerate() {
            let moved = |by: f64| {
                let mut moved = noise;
                *number(&mut moved) += by;
                value(&moved)
            };
            let step = 1e-4;
            let difference = (moved(step) - moved(-step)) / (2.0 * step);
            assert!(
                (slope - difference).abs() < 1e-5 * (1.0 + difference.abs()),
                "{k}: {slope}, {difference}"
            );
        }
    }
}
