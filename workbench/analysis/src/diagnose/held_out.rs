//! Errors on data that was not used for learning: manoeuvres left out of the fit, or whole flights.

use super::information::{Information, own_coefficients};
use super::noise::Noise;
use super::problem::Problem;
use super::series::{BySensor, Series};
use kf_core::sensor::SENSORS;

/// Number of stretches of free flight that are left out in turn.
pub(super) const FOLDS: usize = 5;

/// The share of the held-out errors' squares beyond which most of them come from the coefficients' own
/// uncertainty.
const EXTRAPOLATED: f64 = 0.5;

/// Sums of squares of the held-out errors, by sensor.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HeldOut {
    sum: BySensor,
    blocks: [u64; SENSORS],
    /// The part of the sums that the uncertainty of the coefficients used for the prediction must cause.
    unsure: BySensor,
}

impl HeldOut {
    /// Root mean square of one sensor's error, metres; `None` without a block, and where most of it only
    /// shows that the coefficients are not known from the rest.
    #[must_use]
    pub fn rms_m(&self, sensor: usize) -> Option<f64> {
        self.rms_of_m(|i| i == sensor)
    }

    /// Root mean square over all sensors in free flight, metres.
    #[must_use]
    pub fn rms_all_m(&self) -> Option<f64> {
        self.rms_of_m(|_| true)
    }

    /// As [`Self::rms_all_m`], reliable or not.
    #[must_use]
    pub fn any_rms_m(&self) -> Option<f64> {
        let blocks: u64 = self.blocks.iter().sum();
        (blocks > 0).then(|| (self.sum.iter().sum::<f64>() / blocks as f64).sqrt())
    }

    fn rms_of_m(&self, is_asked: impl Fn(usize) -> bool) -> Option<f64> {
        let of =
            |values: &BySensor| -> f64 { (0..SENSORS).filter(|i| is_asked(*i)).map(|i| values[i]).sum() };
        let blocks: u64 = (0..SENSORS).filter(|i| is_asked(*i)).map(|i| self.blocks[i]).sum();
        let (sum, unsure) = (of(&self.sum), of(&self.unsure));
        // If only the left-out stretch shows a coefficient, its prediction means nothing.
        (blocks > 0 && unsure <= EXTRAPOLATED * sum).then(|| (sum / blocks as f64).sqrt())
    }

    fn add(&mut self, sensor: usize, error_m: f64, unsure_m2: f64) {
        if error_m.is_finite() {
            self.unsure[sensor] += unsure_m2;
            self.sum[sensor] += error_m * error_m;
            self.blocks[sensor] += 1;
        }
    }
}

/// The stretch of free flight that a block belongs to; `None` in captive flight.
pub(super) fn fold(flight: &Series, block: usize) -> Option<usize> {
    let first = flight.free.iter().position(|free| *free)?;
    let at = block.checked_sub(first)?;
    Some((at * FOLDS / (flight.len() - first)).min(FOLDS - 1))
}

/// Errors of stretches of free flight, each predicted from the rest of the flights.
#[must_use]
pub fn manoeuvres(problem: &Problem<'_>, noise: &Noise, picks: &[usize], prior: &[f64]) -> HeldOut {
    let mut errors = HeldOut::default();
    let all: Vec<usize> = (0..picks.len()).collect();
    for left_out in 0..FOLDS {
        let mut information = Information::new(1 + picks.len());
        let mut flights = Vec::new();
        for flight in problem.flights {
            let used = |block| fold(flight, block) != Some(left_out);
            let one = problem.products(flight, noise, &problem.columns(flight, picks), &used);
            information.add_flight(&one.products, problem.own(), one.rows, one.log_determinant);
            flights.push(one);
        }
        let common = coefficients(&information, &all, prior);
        for (flight, one) in problem.flights.iter().zip(&flights) {
            let own = own_coefficients(&one.products, problem.own(), &common.values);
            let tested = |block| fold(flight, block) == Some(left_out);
            add_errors(problem, flight, picks, &own, &common, &tested, &mut errors);
        }
    }
    errors
}

/// Errors in free flight of flights that were not learned from: biases from their own captive flight,
/// coefficients from the learning flights.
#[must_use]
pub fn flights(
    learned: &Problem<'_>,
    held: &Problem<'_>,
    noise: &Noise,
    picks: &[usize],
    prior: &[f64],
) -> HeldOut {
    let all: Vec<usize> = (0..picks.len()).collect();
    let common = coefficients(&learned.information(noise, picks), &all, prior);
    let mut errors = HeldOut::default();
    for flight in held.flights {
        let has_captive = flight.free.iter().any(|free| !*free);
        let used = |block: usize| !has_captive || !flight.free[block];
        let one = held.products(flight, noise, &held.columns(flight, picks), &used);
        let own = own_coefficients(&one.products, held.own(), &common.values);
        add_errors(held, flight, picks, &own, &common, &|block| flight.free[block], &mut errors);
    }
    errors
}

/// Coefficients that other data is predicted with, and their variances.
struct Common {
    values: Vec<f64>,
    variances: Vec<f64>,
}

/// The fit's coefficients, with their physical ranges as a prior: an effect that the rest does not show is
/// predicted as zero.
fn coefficients(information: &Information, all: &[usize], prior: &[f64]) -> Common {
    let n = all.len();
    match information.solve_with_prior(all, prior) {
        Some(solution) => Common {
            values: solution.coefficients,
            variances: (0..n).map(|k| solution.covariance[k * n + k]).collect(),
        },
        None => Common { values: vec![0.0; n], variances: prior.iter().map(|sigma| sigma * sigma).collect() },
    }
}

fn add_errors(
    problem: &Problem<'_>,
    flight: &Series,
    picks: &[usize],
    own: &[f64],
    common: &Common,
    tested: &dyn Fn(usize) -> bool,
    errors: &mut HeldOut,
) {
    let columns = problem.columns(flight, picks);
    let first = columns.len() - picks.len();
    // The bias absorbs the mean of a coefficient's error.
    let means: Vec<BySensor> = columns[first..]
        .iter()
        .map(|column| {
            std::array::from_fn(|i| column.iter().map(|row| row[i]).sum::<f64>() / flight.len().max(1) as f64)
        })
        .collect();
    for block in (0..flight.len()).filter(|block| tested(*block)) {
        for sensor in 0..SENSORS {
            let explained = own.iter().chain(&common.values).zip(&columns[1..]);
            let explained_m: f64 = explained.map(|(value, column)| value * column[block][sensor]).sum();
            let unsure = common.variances.iter().zip(&columns[first..]).zip(&means);
            let unsure_m2: f64 = unsure
                .map(|((variance, column), mean)| variance * (column[block][sensor] - mean[sensor]).powi(2))
                .sum();
            errors.add(sensor, flight.residual_m[block][sensor] - explained_m, unsure_m2);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The error is the root of the mean square of one sensor's blocks, or of all; a value that is not finite
    /// is not a block. Where most of it is the coefficients' own uncertainty, it is not reported.
    #[test]
    fn errors_are_root_mean_squares() {
        let mut errors = HeldOut::default();
        assert_eq!((errors.rms_m(2), errors.rms_all_m(), errors.any_rms_m()), (None, None, None));
        for error_m in [3.0, -5.0, f64::NAN] {
            errors.add(2, error_m, 1.0);
        }
        errors.add(1, 2.0, 0.5);
        assert_eq!(errors.rms_m(2), Some(17.0_f64.sqrt()));
        assert_eq!(errors.rms_m(1), Some(2.0));
        assert_eq!(errors.rms_m(0), None);
        assert_eq!(errors.rms_all_m(), Some((38.0_f64 / 3.0).sqrt()));
        errors.add(1, 1.0, 2.5);
        assert_eq!(errors.rms_m(1), None, "three of five square metres");
        assert_eq!(errors.any_rms_m(), Some((39.0_f64 / 4.0).sqrt()));
    }

    /// Free flight has five stretches of equal length.
    #[test]
    fn a_fold_is_a_fifth_of_free_flight() {
        let count = 50;
        let flight = Series {
            time_s: (0..count).map(|k| k as f64).collect(),
            free: (0..count).map(|k| k >= 20).collect(),
            ..Series::default()
        };
        let folds: Vec<Option<usize>> =
            [0, 19, 20, 25, 26, 38, 49].map(|block| fold(&flight, block)).to_vec();
        assert_eq!(folds, [None, None, Some(0), Some(0), Some(1), Some(3), Some(4)]);
    }
}
