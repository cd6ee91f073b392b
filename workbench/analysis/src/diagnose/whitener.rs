//! The innovations of a Kalman filter as a whitening of regressions (de Jong, "The diffuse Kalman filter",
//! Annals of Statistics 19, 1991): the filter of the noise alone runs over the residuals and, with the same
//! gains, over every regressor. The output is uncorrelated, of unit variance, and as linear in the
//! coefficients as the input. One pass, linear in the flight's length.

use kf_core::sensor::SENSORS;

use super::noise::Noise;
use super::series::{BySensor, Series};

/// Index among the states of the white noise of a block's fixes.
pub const FIX: usize = 1;
/// Index of the first sensor's wander.
pub const OWN: usize = 3;
/// Reference's wander, a block's white noise of the fixes, the slow wander, and each sensor's wander.
pub const STATES: usize = OWN + SENSORS;
/// One value per state.
pub type State = [f64; STATES];

/// Number of columns that the filter processes together: they are adjacent in memory, and the processor works
/// on several at once.
pub const LANES: usize = 4;
/// The filter's means for some columns, by state.
pub type Means = [[f64; LANES]; STATES];

/// Runs the noise's filter over a flight. `columns` are the residuals, followed by the regressors; `sink`
/// receives block, sensor and the whitened values of all columns, one row per reading. Blocks that `used`
/// rejects are treated as if they had no reading.
///
/// Returns the sum of the logarithms of the innovations' variances (m^2).
pub fn whiten(
    series: &Series,
    noise: &Noise,
    columns: &[&[BySensor]],
    used: &dyn Fn(usize) -> bool,
    sink: &mut dyn FnMut(usize, usize, &[f64]),
) -> f64 {
    whiten_by_groups(series, noise, columns, used, &mut |block, sensor, row| {
        sink(block, sensor, &row.as_flattened()[..columns.len()]);
    })
}

/// As [`whiten`], with the columns in groups of [`LANES`]; the last group is padded with zeros.
pub fn whiten_by_groups<S: FnMut(usize, usize, &[[f64; LANES]])>(
    series: &Series,
    noise: &Noise,
    columns: &[&[BySensor]],
    used: &dyn Fn(usize) -> bool,
    sink: &mut S,
) -> f64 {
    struct Rows<'a, S>(&'a mut S);
    impl<S: FnMut(usize, usize, &[[f64; LANES]])> Pass for Rows<'_, S> {
        fn reading(&mut self, reading: &Reading<'_>) {
            (self.0)(reading.block, reading.sensor, reading.row);
        }
    }
    filter(series, noise, columns, used, &mut Rows(sink))
}

/// A reading that the filter processes.
pub struct Reading<'a> {
    /// Its block.
    pub block: usize,
    /// Its sensor.
    pub sensor: usize,
    /// The states' covariance with the reading, m^2.
    pub gain: &'a State,
    /// Inverse of the root of the innovation's variance, 1/m.
    pub scale: f64,
    /// The innovations of all columns times that scale.
    pub row: &'a [[f64; LANES]],
}

/// Observes a pass of the filter.
pub trait Pass {
    /// Called before a block, with the states after the last one and the transition to it.
    fn block(&mut self, _covariance: &[State; STATES], _means: &[Means], _decay: &Decay) {}
    /// Called after a reading's innovation, in the filter's order.
    fn reading(&mut self, reading: &Reading<'_>);
}

/// Runs the filter; see [`whiten`].
pub fn filter<P: Pass>(
    series: &Series,
    noise: &Noise,
    columns: &[&[BySensor]],
    used: &dyn Fn(usize) -> bool,
    pass: &mut P,
) -> f64 {
    let groups = columns.len().div_ceil(LANES);
    let mut means: Vec<Means> = vec![[[0.0; LANES]; STATES]; groups];
    let mut covariance = [[0.0; STATES]; STATES];
    covariance[0][0] = square(noise.reference.sigma_m);
    covariance[2][2] = square(noise.slow.sigma_m);
    for i in 0..SENSORS {
        covariance[OWN + i][OWN + i] = square(noise.sensors[i].wander.sigma_m);
    }
    let mut row = vec![[0.0; LANES]; groups];
    let mut log_determinant = LogarithmOfProduct::default();
    let mut last_s: Option<f64> = None;
    let mut decay = Decay::over(noise, 0.0, false);
    for (block, time_s) in series.time_s.iter().enumerate() {
        let elapsed_s = last_s.map_or(0.0, |last_s| to_microseconds(time_s - last_s));
        last_s = Some(*time_s);
        let free = series.free[block];
        if decay.elapsed_s != elapsed_s || decay.free != free {
            decay = Decay::over(noise, elapsed_s, free);
        }
        pass.block(&covariance, &means, &decay);
        decay.propagate(&mut covariance, &mut means);
        covariance[FIX][FIX] = square(noise.fix_sigma_m) / series.fixes[block];
        if !used(block) {
            continue;
        }
        for sensor in 0..SENSORS {
            if !series.residual_m[block][sensor].is_finite() {
                continue;
            }
            let white = noise.white_m2(series, block, sensor);
            // The measurement's row is [1, 1, 1, ..., 1 at the sensor's wander, ...].
            let own = OWN + sensor;
            let mut gain = [0.0; STATES];
            for (gain, row) in gain.iter_mut().zip(&covariance) {
                *gain = row[0] + row[1] + row[2] + row[own];
            }
            let variance = gain[0] + gain[1] + gain[2] + gain[own] + white;
            let inverse = 1.0 / variance;
            let scale = inverse.sqrt();
            for (value, column) in row.as_flattened_mut().iter_mut().zip(columns) {
                *value = column[block][sensor];
            }
            for (values, means) in row.iter_mut().zip(&mut means) {
                let own = means[own];
                let innovations: [f64; LANES] = std::array::from_fn(|lane| {
                    values[lane] - means[0][lane] - means[1][lane] - means[2][lane] - own[lane]
                });
                let weighted = innovations.map(|innovation| innovation * inverse);
                *values = innovations.map(|innovation| innovation * scale);
                for (means, gain) in means.iter_mut().zip(&gain) {
                    for (mean, weighted) in means.iter_mut().zip(&weighted) {
                        *mean += gain * weighted;
                    }
                }
            }
            for j in 0..STATES {
                let weighted = gain[j] * inverse;
                for k in 0..STATES {
                    covariance[j][k] -= weighted * gain[k];
                }
            }
            log_determinant.multiply(variance);
            pass.reading(&Reading { block, sensor, gain: &gain, scale, row: &row });
        }
    }
    log_determinant.value()
}

/// Times are whole microseconds, and so are the differences of their means, to a negligible error. Blocks of
/// equal length then have the same decay.
fn to_microseconds(seconds: f64) -> f64 {
    (seconds * 1e6).round() * 1e-6
}

/// The sum of logarithms as the logarithm of a product, which is taken as rarely as a double's range allows.
struct LogarithmOfProduct {
    product: f64,
    sum: f64,
}

impl Default for LogarithmOfProduct {
    fn default() -> Self {
        Self { product: 1.0, sum: 0.0 }
    }
}

impl LogarithmOfProduct {
    /// The product of two factors within these bounds still fits a double.
    const WITHIN: std::ops::Range<f64> = 1e-100..1e100;

    fn multiply(&mut self, factor: f64) {
        if !Self::WITHIN.contains(&factor) {
            self.sum += libm::log(factor);
            return;
        }
        self.product *= factor;
        if !Self::WITHIN.contains(&self.product) {
            self.sum += libm::log(self.product);
            self.product = 1.0;
        }
    }

    fn value(&self) -> f64 {
        self.sum + libm::log(self.product)
    }
}

/// The share of the processes that is left after some time, and the variance added; the white noise of the
/// fixes starts again.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Decay {
    /// The time, seconds.
    pub elapsed_s: f64,
    /// Whether the flight is in free flight then.
    pub free: bool,
    /// The share of each state that is left.
    pub keep: State,
    /// The variance added to each one, m^2.
    added: State,
}

impl Decay {
    fn over(noise: &Noise, elapsed_s: f64, free: bool) -> Self {
        let mut decay = Self { elapsed_s, free, keep: [0.0; STATES], added: [0.0; STATES] };
        let mut process = |state: usize, sigma_m: f64, time_s: f64| {
            let kept = libm::exp(-elapsed_s / time_s);
            decay.keep[state] = kept;
            decay.added[state] = square(sigma_m) * (1.0 - kept * kept);
        };
        process(0, noise.reference.sigma_m, noise.reference.time_s);
        process(2, noise.slow.sigma_m, noise.slow.time_s);
        for (i, sensor) in noise.sensors.iter().enumerate() {
            let factor = if free { sensor.free_flight_factor } else { 1.0 };
            process(OWN + i, sensor.wander.sigma_m * factor, sensor.wander.time_s);
        }
        decay
    }

    /// Carries the processes to the next block.
    fn propagate(&self, covariance: &mut [State; STATES], means: &mut [Means]) {
        for means in means {
            for (means, keep) in means.iter_mut().zip(&self.keep) {
                for mean in means {
                    *mean *= keep;
                }
            }
        }
        for (j, row) in covariance.iter_mut().enumerate() {
            for (entry, keep) in row.iter_mut().zip(&self.keep) {
                *entry *= self.keep[j] * keep;
            }
            row[j] += self.added[j];
        }
    }
}

const fn square(x: f64) -> f64 {
    x * x
}

/// A small flight whose covariance can be written down completely.
#[cfg(test)]
pub(super) mod small {
    use nalgebra::DMatrix;

    use super::super::noise::{GaussMarkov, SensorNoise};
    use super::*;

    pub fn noise() -> Noise {
        let sensor = |sigma_m, time_s, white| SensorNoise {
            wander: GaussMarkov { sigma_m, time_s },
            captive_white_m: white,
            free_white_m: 2.0 * white,
            free_flight_factor: 1.0,
        };
        Noise {
            reference: GaussMarkov { sigma_m: 2.0, time_s: 40.0 },
            slow: GaussMarkov { sigma_m: 3.0, time_s: 300.0 },
            fix_sigma_m: 0.4,
            sensors: [sensor(1.0, 5.0, 0.3), sensor(0.5, 20.0, 0.2), sensor(0.7, 9.0, 0.5)],
        }
    }

    /// Uneven times, gaps, a sensor that is missing at times, partly filled blocks.
    pub fn series() -> Series {
        let mut series = Series { block_s: 1.0, full_block: [10.0; SENSORS], ..Series::default() };
        for k in 0..24_u32 {
            let t = f64::from(k) + if k > 10 { 3.5 } else { 0.0 };
            series.time_s.push(t);
            series.fixes.push(f64::from(1 + k % 5));
            series.free.push(k > 12);
            series.readings.push([10, 4 + k % 7, 10]);
            let value = |i: u32| f64::from((k * 37 + i * 11) % 19) / 6.0 - 1.5;
            let master = if k > 12 { f64::NAN } else { value(0) };
            series.residual_m.push([master, if k % 4 == 3 { f64::NAN } else { value(1) }, value(2)]);
        }
        series
    }

    /// Covariance of all readings, written down from the processes.
    pub fn dense(series: &Series, noise: &Noise) -> (DMatrix<f64>, Vec<f64>) {
        let mut at = Vec::new();
        for block in 0..series.len() {
            for sensor in 0..SENSORS {
                if series.residual_m[block][sensor].is_finite() {
                    at.push((block, sensor));
                }
            }
        }
        let markov = |process: &GaussMarkov, apart: f64| {
            process.sigma_m * process.sigma_m * (-apart.abs() / process.time_s).exp()
        };
        let covariance = DMatrix::from_fn(at.len(), at.len(), |r, c| {
            let ((block, sensor), (other_block, other_sensor)) = (at[r], at[c]);
            let apart = series.time_s[block] - series.time_s[other_block];
            let mut sum = markov(&noise.reference, apart) + markov(&noise.slow, apart);
            if block == other_block {
                sum += noise.fix_sigma_m.powi(2) / series.fixes[block];
            }
            if sensor == other_sensor {
                let own = &noise.sensors[sensor];
                sum += markov(&own.wander, apart);
                if block == other_block {
                    let white = if series.free[block] { own.free_white_m } else { own.captive_white_m };
                    sum +=
                        white * white * series.full_block[sensor] / f64::from(series.readings[block][sensor]);
                }
            }
            sum
        });
        let values = at.iter().map(|(block, sensor)| series.residual_m[*block][*sensor]).collect();
        (covariance, values)
    }
}

#[cfg(test)]
mod tests {
    use super::small::{dense, noise, series};
    use super::*;

    #[test]
    fn the_likelihood_is_that_of_the_dense_covariance() {
        let (series, noise) = (series(), noise());
        let (covariance, values) = dense(&series, &noise);
        let factor = covariance.cholesky().unwrap();
        let values = nalgebra::DVector::from_vec(values);
        let expected_squares = values.dot(&factor.solve(&values));
        let expected_determinant: f64 = 2.0 * factor.l().diagonal().iter().map(|x| x.ln()).sum::<f64>();

        let mut squares = 0.0;
        let mut rows = 0;
        let log_determinant = whiten(&series, &noise, &[&series.residual_m], &|_| true, &mut |_, _, row| {
            squares += row[0] * row[0];
            rows += 1;
        });
        assert_eq!(rows, values.len());
        assert!((squares - expected_squares).abs() < 1e-8 * expected_squares, "{squares} {expected_squares}");
        assert!((log_determinant - expected_determinant).abs() < 1e-8 * expected_determinant.abs());
    }

    #[test]
    fn a_block_that_is_not_used_is_as_good_as_absent() {
        let (series, noise) = (series(), noise());
        let mut without = series.clone();
        without.residual_m[7] = [f64::NAN; SENSORS];
        let run = |series: &Series, used: &dyn Fn(usize) -> bool| {
            let mut rows = Vec::new();
            whiten(series, &noise, &[&series.residual_m], used, &mut |_, _, row| rows.push(row[0]));
            rows
        };
        assert_eq!(run(&series, &|block| block != 7), run(&without, &|_| true));
    }
}
