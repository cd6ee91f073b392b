//! The candidates that take part in a search, and what is known about their regressors.

use super::candidates::Candidate;
use super::information::{Information, Solution};
use super::noise::Noise;
use super::physical_range::{Bounds, is_consistent, is_possible};
use super::problem::Problem;
use super::series::BySensor;

/// Gain in twice the log likelihood that an effect needs beyond what the best of this many candidates gains
/// by chance (which is 2 ln of their number). 16 is a chance of 1 in 10,000 for one of them, which leaves
/// room for noise that is not quite what the likelihood assumes.
const EVIDENCE: f64 = 16.0;

/// What is known about each candidate's regressor.
#[derive(Clone, Debug)]
pub struct Suspects<'a> {
    candidates: &'a [Candidate],
    noise_m2: Vec<f64>,
    attenuating_m2: Vec<f64>,
    shape: Vec<f64>,
    bounds: Vec<Bounds>,
    usable: Vec<usize>,
    penalty: f64,
}

/// What is known about every candidate's regressor, in the candidates' order.
#[derive(Clone, Debug)]
pub struct Regressors {
    /// Variance of the noise in each one's block means, m^2 per squared unit of its coefficient.
    pub noise_m2: Vec<f64>,
    /// The same with the noise of a measured climb rate in the columns of delays.
    pub attenuating_m2: Vec<f64>,
    /// Relative error (squares) of each one's shape.
    pub shape: Vec<f64>,
    /// Physical ranges of the coefficients.
    pub bounds: Vec<Bounds>,
}

/// What a square metre of white noise in block means adds to the squares: in one sensor's, and in all sensors'
/// alike.
#[derive(Clone, Copy, Debug, Default)]
pub struct White {
    by_sensor: BySensor,
    shared: f64,
}

impl White {
    /// Under this noise.
    #[must_use]
    pub fn of(problem: &Problem<'_>, noise: &Noise) -> Self {
        Self { by_sensor: problem.weight_of_white(noise), shared: problem.weight_of_shared_white(noise) }
    }
}

impl<'a> Suspects<'a> {
    /// The candidates whose columns are in `usable`.
    #[must_use]
    pub fn new(candidates: &'a [Candidate], regressors: Regressors, usable: Vec<usize>) -> Self {
        let mut effects: Vec<_> = usable.iter().map(|column| candidates[*column].effect()).collect();
        effects.dedup();
        let penalty = 2.0 * libm::log(effects.len().max(1) as f64) + EVIDENCE;
        let Regressors { noise_m2, attenuating_m2, shape, bounds } = regressors;
        Self { candidates, noise_m2, attenuating_m2, shape, bounds, usable, penalty }
    }

    /// A column's candidate.
    #[must_use]
    pub fn candidate(&self, column: usize) -> &'a Candidate {
        &self.candidates[column]
    }

    /// Normal equations of all usable columns under a noise.
    #[must_use]
    pub fn information(&self, problem: &Problem<'_>, noise: &Noise) -> Information {
        problem.information(noise, &self.usable)
    }

    /// The columns of the candidates that take part.
    #[must_use]
    pub fn usable(&self) -> &[usize] {
        &self.usable
    }

    /// Position of a candidate's column among the usable ones.
    #[must_use]
    pub fn position(&self, column: usize) -> Option<usize> {
        self.usable.iter().position(|usable| *usable == column)
    }

    /// Positions of several columns.
    #[must_use]
    pub fn positions(&self, columns: &[usize]) -> Vec<usize> {
        columns.iter().filter_map(|column| self.position(*column)).collect()
    }

    /// Whether two columns belong to the same effect.
    #[must_use]
    pub fn same_effect(&self, a: usize, b: usize) -> bool {
        self.candidates[a].effect() == self.candidates[b].effect()
    }

    /// Whether every coefficient of a fit of these columns is physically possible.
    #[must_use]
    pub fn is_possible(&self, set: &[usize], solution: &Solution) -> bool {
        let bounds: Vec<Bounds> = set.iter().map(|column| self.bounds[*column]).collect();
        is_possible(&bounds, solution)
    }

    /// Whether these columns may act together with the coefficients of their fit: possible ones, that agree with
    /// their shapes.
    #[must_use]
    pub fn may_act(&self, set: &[usize], solution: &Solution) -> bool {
        self.is_possible(set, solution) && self.is_consistent(set, solution)
    }

    /// Whether every coefficient of a fit of these columns agrees with its column's shape.
    #[must_use]
    pub fn is_consistent(&self, set: &[usize], solution: &Solution) -> bool {
        let bounds: Vec<Bounds> = set.iter().map(|column| self.bounds[*column]).collect();
        is_consistent(&bounds, solution)
    }

    /// What every candidate's coefficient may be, in the candidates' order.
    #[must_use]
    pub fn bounds(&self) -> &[Bounds] {
        &self.bounds
    }

    /// The range of a column's coefficient.
    #[must_use]
    pub fn range(&self, column: usize) -> [f64; 2] {
        self.bounds[column].range
    }

    /// The share of a column's coefficient that is uncertain in addition to its noise.
    #[must_use]
    pub fn scale(&self, column: usize) -> f64 {
        self.bounds[column].scale
    }

    /// Sigmas of the priors of columns' coefficients before a flight: half of their range's width.
    #[must_use]
    pub fn prior(&self, columns: &[usize]) -> Vec<f64> {
        columns.iter().map(|column| self.range(*column)).map(|[least, most]| 0.5 * (most - least)).collect()
    }

    /// Gain in twice the log likelihood that another effect needs to be added.
    #[must_use]
    pub const fn penalty(&self) -> f64 {
        self.penalty
    }

    /// Possible relative error (squares) of the shape of what a candidate contributes to a tenth of a flight.
    #[must_use]
    pub fn shape(&self, column: usize) -> f64 {
        self.shape[column]
    }

    /// Variance of the noise in a candidate's block means.
    #[must_use]
    pub fn column_noise_m2(&self, column: usize) -> f64 {
        self.noise_m2.get(column).copied().unwrap_or(0.0)
    }

    /// The share of a column's squares (of which `covariance` is the inverse, beside the other columns) that is
    /// the noise of its signals. The coefficient is too small by it.
    #[must_use]
    pub fn attenuation(&self, column: usize, covariance: f64, white: &White) -> f64 {
        let weight = match self.candidates[column].sensor() {
            Some(sensor) => white.by_sensor[sensor.index()],
            None => white.shared,
        };
        self.attenuating_m2.get(column).copied().unwrap_or(0.0) * weight * covariance
    }

    /// The sum of squares that a set leaves, less what the noise in its regressors leaves if the set is
    /// right.
    #[must_use]
    pub fn rest_but_noise(
        &self,
        information: &Information,
        weights: &BySensor,
        set: &[usize],
    ) -> Option<f64> {
        let solution = information.solve(&self.positions(set))?;
        let noise = set.iter().zip(&solution.coefficients).map(|(column, coefficient)| {
            let weight = match self.candidates[*column].sensor() {
                Some(sensor) => weights[sensor.index()],
                None => weights.iter().sum(),
            };
            coefficient * coefficient * self.noise_m2[*column] * weight
        });
        Some(solution.rest - noise.sum::<f64>())
    }
}
