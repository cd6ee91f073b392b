//! Normal equations of a whitened regression with the biases projected out, and what subsets of its
//! columns explain.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use super::matrix::product;

/// A column whose projection keeps less than this share of its square cannot be distinguished from the
/// biases.
const COLLINEAR: f64 = 1e-10;

/// Normal equations of one or several flights: column 0 is the residual, the others the regressors.
#[derive(Clone, Debug)]
pub struct Information {
    /// Products of the columns after the biases are projected out.
    gram: DMatrix<f64>,
    /// The columns' squares before that. The share that remains shows whether a column differs from a bias.
    raw: Vec<f64>,
    /// Number of whitened readings.
    pub rows: usize,
    /// Twice the part of the (restricted) log likelihood that does not depend on the columns.
    log_determinant: f64,
}

/// A least-squares fit on some of the columns.
#[derive(Clone, Debug, PartialEq)]
pub struct Solution {
    /// Coefficients, in the order of the columns asked for.
    pub coefficients: Vec<f64>,
    /// Their covariance, row after row.
    pub covariance: Vec<f64>,
    /// Natural logarithm of the covariance's determinant.
    pub log_determinant: f64,
    /// Sum of squares of the residual after the fit.
    pub rest: f64,
}

impl Information {
    /// For `width` columns (the residual and the regressors), still empty.
    #[must_use]
    pub fn new(width: usize) -> Self {
        Self { gram: DMatrix::zeros(width, width), raw: vec![0.0; width], rows: 0, log_determinant: 0.0 }
    }

    /// Adds a flight's normal equations. Its columns are the residual, `own` columns of its own (biases, and
    /// whatever else is estimated flight by flight), and the regressors. Own columns without a reading are
    /// left out.
    pub fn add_flight(&mut self, products: &DMatrix<f64>, own: usize, rows: usize, log_determinant: f64) {
        let width = self.raw.len();
        let present = present(products, own);
        let kept: Vec<usize> = std::iter::once(0).chain(1 + own..own + width).collect();
        let inner = products.select_rows(&present).select_columns(&present);
        let cross = products.select_rows(&present).select_columns(&kept);
        let mut outer = products.select_rows(&kept).select_columns(&kept);
        for (j, raw) in self.raw.iter_mut().enumerate() {
            *raw += outer[(j, j)];
        }
        self.log_determinant += log_determinant;
        if let Some(factor) = inner.cholesky() {
            outer -= product(&cross.transpose(), &factor.solve(&cross));
            let diagonal = factor.l_dirty().diagonal();
            self.log_determinant += 2.0 * diagonal.iter().map(|entry| libm::log(*entry)).sum::<f64>();
        }
        self.gram += outer;
        self.rows += rows - present.len().min(rows);
    }

    /// The normal equations of these and other flights, with the same columns.
    #[must_use]
    pub fn plus(&self, other: &Self) -> Self {
        Self {
            gram: &self.gram + &other.gram,
            raw: self.raw.iter().zip(&other.raw).map(|(one, other)| one + other).collect(),
            rows: self.rows + other.rows,
            log_determinant: self.log_determinant + other.log_determinant,
        }
    }

    /// The same flights, as if the residual were the sum of some columns with these coefficients, without
    /// noise.
    #[must_use]
    pub fn with_response(&self, columns: &[usize], coefficients: &[f64]) -> Self {
        let mut with = self.clone();
        let terms = || columns.iter().map(|column| column + 1).zip(coefficients);
        let width = self.raw.len();
        for j in 1..width {
            let product: f64 = terms().map(|(at, coefficient)| coefficient * self.gram[(at, j)]).sum();
            with.gram[(0, j)] = product;
            with.gram[(j, 0)] = product;
        }
        with.gram[(0, 0)] = terms().map(|(at, coefficient)| coefficient * with.gram[(0, at)]).sum();
        with
    }

    /// Whether a column is more than a combination of the biases.
    #[must_use]
    pub fn is_excited(&self, column: usize) -> bool {
        let at = column + 1;
        self.raw[at] > 0.0 && self.gram[(at, at)] > COLLINEAR * self.raw[at]
    }

    /// Sum of squares of the residual.
    #[must_use]
    pub fn total(&self) -> f64 {
        self.gram[(0, 0)]
    }

    /// The fit on some columns; `None` where they cannot be told apart.
    #[must_use]
    pub fn solve(&self, columns: &[usize]) -> Option<Solution> {
        if columns.is_empty() {
            return Some(Solution {
                coefficients: Vec::new(),
                covariance: Vec::new(),
                log_determinant: 0.0,
                rest: self.total(),
            });
        }
        let at: Vec<usize> = columns.iter().map(|column| column + 1).collect();
        if !columns.iter().all(|column| self.is_excited(*column)) {
            return None;
        }
        let scale: Vec<f64> = at.iter().map(|j| self.gram[(*j, *j)].sqrt()).collect();
        let n = at.len();
        let inner = DMatrix::from_fn(n, n, |r, c| self.gram[(at[r], at[c])] / (scale[r] * scale[c]));
        let right = DVector::from_fn(n, |r, _| self.gram[(at[r], 0)] / scale[r]);
        let factor = inner.cholesky()?;
        if factor.l_dirty().diagonal().iter().any(|entry| *entry < 1e-5) {
            return None;
        }
        let scaled = factor.solve(&right);
        let inverse = factor.inverse();
        let diagonal = factor.l_dirty().diagonal();
        let unscaled: f64 = diagonal.iter().zip(&scale).map(|(entry, scale)| libm::log(entry * scale)).sum();
        Some(Solution {
            log_determinant: -2.0 * unscaled,
            coefficients: scaled.iter().zip(&scale).map(|(value, scale)| value / scale).collect(),
            covariance: (0..n * n).map(|k| inverse[(k / n, k % n)] / (scale[k / n] * scale[k % n])).collect(),
            rest: self.total() - scaled.dot(&right),
        })
    }

    /// The least-squares coefficients of a combination of the columns (one factor per column) on some of
    /// them; `None` where these cannot be told apart.
    #[must_use]
    pub fn regression(&self, combination: &[f64], on: &[usize]) -> Option<Vec<f64>> {
        let mut of = self.clone();
        let along = |column: usize| {
            let terms = combination.iter().enumerate();
            terms.map(|(other, factor)| factor * self.gram[(column + 1, other + 1)]).sum::<f64>()
        };
        for column in on {
            of.gram[(column + 1, 0)] = along(*column);
        }
        of.solve(on).map(|solution| solution.coefficients)
    }

    /// As [`Self::solve`], with a prior for each column's coefficient, as a sigma about zero.
    #[must_use]
    pub fn solve_with_prior(&self, columns: &[usize], sigmas: &[f64]) -> Option<Solution> {
        let mut with = self.clone();
        for (column, sigma) in columns.iter().zip(sigmas) {
            let (at, believed) = (column + 1, 1.0 / (sigma * sigma));
            with.gram[(at, at)] += believed;
            with.raw[at] += believed;
        }
        with.solve(columns)
    }

    /// Twice the part of the log likelihood that does not depend on the columns.
    #[must_use]
    pub const fn twice_log_determinant(&self) -> f64 {
        -self.log_determinant
    }

    /// Square of the correlation of two columns after others are projected out of both.
    #[must_use]
    pub fn shared(&self, a: usize, b: usize, others: &[usize]) -> Option<f64> {
        let alone = |column: usize| {
            let columns: Vec<usize> = others.iter().copied().chain([column]).collect();
            let solution = self.solve(&columns)?;
            // The last diagonal element of the covariance is the inverse of the column's remaining square.
            solution.covariance.last().map(|variance| 1.0 / variance)
        };
        let left = alone(a)?;
        let columns: Vec<usize> = others.iter().copied().chain([b, a]).collect();
        let Some(both) = self.solve(&columns) else { return Some(1.0) };
        let beside = both.covariance.last().map(|variance| 1.0 / variance)?;
        Some((1.0 - beside / left).clamp(0.0, 1.0))
    }
}

/// The own columns of a flight that have a reading.
fn present(products: &DMatrix<f64>, own: usize) -> Vec<usize> {
    (1..=own).filter(|column| products[(*column, *column)] > 0.0).collect()
}

/// The own columns of a flight that have a reading, and the Cholesky factor of their normal equations; `None`
/// where they cannot be told apart.
#[must_use]
pub fn own_factor(products: &DMatrix<f64>, own: usize) -> Option<(Vec<usize>, Cholesky<f64, Dyn>)> {
    let present = present(products, own);
    let factor = products.select_rows(&present).select_columns(&present).cholesky()?;
    Some((present, factor))
}

/// The own coefficients of a flight (biases first), given the common ones; zero where there is no reading.
#[must_use]
pub fn own_coefficients(products: &DMatrix<f64>, own: usize, common: &[f64]) -> Vec<f64> {
    let mut coefficients = vec![0.0; own];
    let Some((present, factor)) = own_factor(products, own) else { return coefficients };
    let right = DVector::from_fn(present.len(), |r, _| {
        let explained: f64 =
            common.iter().enumerate().map(|(k, value)| products[(present[r], 1 + own + k)] * value).sum();
        products[(present[r], 0)] - explained
    });
    for (at, value) in present.iter().zip(factor.solve(&right).iter()) {
        coefficients[at - 1] = *value;
    }
    coefficients
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Products of the rows `[y, 1, x, z]` with y = 5 + 2 x - 3 z and a remainder.
    fn products(rest: impl Fn(i32) -> f64) -> (DMatrix<f64>, usize) {
        let mut products = DMatrix::zeros(4, 4);
        for k in 0..50 {
            let (x, z) = (f64::from(k), f64::from(k * k % 17));
            let row = DVector::from_column_slice(&[5.0 + 2.0 * x - 3.0 * z + rest(k), 1.0, x, z]);
            products += &row * row.transpose();
        }
        (products, 50)
    }

    #[test]
    fn finds_coefficients_beside_a_bias_and_the_bias_itself() {
        let (products, rows) = products(|_| 0.0);
        let mut information = Information::new(3);
        information.add_flight(&products, 1, rows, 0.0);
        let solution = information.solve(&[0, 1]).unwrap();
        assert!((solution.coefficients[0] - 2.0).abs() < 1e-9, "{solution:?}");
        assert!((solution.coefficients[1] + 3.0).abs() < 1e-9);
        assert!(solution.rest.abs() < 1e-6);
        let own = own_coefficients(&products, 1, &solution.coefficients);
        assert!((own[0] - 5.0).abs() < 1e-9, "{own:?}");
    }

    #[test]
    fn a_column_that_is_a_bias_is_not_excited_and_two_equal_ones_can_not_be_solved() {
        let mut products = DMatrix::zeros(4, 4);
        for k in 0..20 {
            let x = f64::from(k * k);
            let row = DVector::from_column_slice(&[x, 1.0, 7.0, x]);
            products += &row * row.transpose();
        }
        let mut information = Information::new(3);
        information.add_flight(&products, 1, 20, 0.0);
        assert!(!information.is_excited(0) && information.is_excited(1));
        assert_eq!(information.solve(&[0]), None);
        assert!(information.solve(&[1, 1]).is_none());
        assert!(information.shared(1, 1, &[]).is_some_and(|shared| shared > 0.999_999));
    }

    #[test]
    fn a_flight_without_noise_reads_what_its_columns_make_and_is_added_to_others() {
        let (first, rows) = products(|k| if k % 2 == 0 { 1.0 } else { -1.0 });
        let (second, _) = products(|k| f64::from(k % 3));
        let of = |products: &DMatrix<f64>| {
            let mut information = Information::new(3);
            information.add_flight(products, 1, rows, 0.0);
            information
        };
        let made = of(&second).with_response(&[0, 1], &[0.5, 7.0]);
        let solution = made.solve(&[0, 1]).unwrap();
        assert!((solution.coefficients[0] - 0.5).abs() < 1e-9 && solution.rest.abs() < 1e-6, "{solution:?}");
        // With only one of the two columns, the other's part remains.
        assert!(made.solve(&[0]).unwrap().rest > 1.0);
        let mut both = Information::new(3);
        both.add_flight(&first, 1, rows, 0.0);
        both.add_flight(&second, 1, rows, 0.0);
        let sum = of(&first).plus(&of(&second));
        let (one, other) = (both.solve(&[0, 1]).unwrap(), sum.solve(&[0, 1]).unwrap());
        assert!((one.rest - other.rest).abs() < 1e-6 * one.rest);
        assert!((one.covariance[0] - other.covariance[0]).abs() < 1e-12 * one.covariance[0]);
    }

    #[test]
    fn two_flights_share_coefficients_and_not_biases() {
        let (first, rows) = products(|_| 0.0);
        // The second flight's bias is 100 m off; its coefficients are the same.
        let (second, _) = products(|_| 100.0);
        let mut information = Information::new(3);
        information.add_flight(&first, 1, rows, 0.0);
        information.add_flight(&second, 1, rows, 0.0);
        let solution = information.solve(&[0, 1]).unwrap();
        assert!(solution.rest.abs() < 1e-5, "{solution:?}");
        assert!((solution.coefficients[0] - 2.0).abs() < 1e-9);
    }
}
