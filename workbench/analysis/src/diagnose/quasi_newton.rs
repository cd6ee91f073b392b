//! Minimisation by quasi-Newton steps: BFGS (Nocedal and Wright, "Numerical Optimization", 2nd edition,
//! algorithm 6.1).

use executor::Executor;
use nalgebra::{DMatrix, DVector};

use super::matrix::product;

/// Step of the finite differences; the arguments are logarithms, so it is relative.
const DIFFERENCE: f64 = 1e-4;
const ITERATIONS: usize = 40;
/// Longest step: a factor of e^2 in any value.
const LONGEST: f64 = 2.0;

/// The function to minimise.
pub trait Function {
    /// What an evaluation keeps for computing the slope at the same point.
    type Left;

    /// The value, and what is kept for the slope.
    fn value(&self, at: &[f64]) -> (f64, Self::Left);

    /// The derivative with respect to every argument.
    fn slope(&self, at: &[f64], left: &Self::Left) -> Vec<f64>;
}

/// A function without an analytic slope: finite differences replace it, computed in parallel by the executor.
pub struct Differences<'a, F> {
    /// The function.
    pub function: F,
    /// Runs the evaluations.
    pub executor: &'a dyn Executor,
}

impl<F: Fn(&[f64]) -> f64 + Sync> Function for Differences<'_, F> {
    /// The value itself.
    type Left = f64;

    fn value(&self, at: &[f64]) -> (f64, f64) {
        let value = (self.function)(at);
        (value, value)
    }

    fn slope(&self, at: &[f64], value: &f64) -> Vec<f64> {
        let slope = |k: usize| {
            move || {
                let mut probe = at.to_vec();
                probe[k] += DIFFERENCE;
                ((self.function)(&probe) - value) / DIFFERENCE
            }
        };
        executor::map(self.executor, (0..at.len()).map(slope))
    }
}

/// The result of a search.
#[derive(Clone, Debug)]
pub struct Minimum {
    /// The arguments.
    pub at: Vec<f64>,
    /// The function's value there.
    pub value: f64,
}

/// Searches for a minimum from `start` until an iteration gains less than `tolerance`.
pub fn minimise<F: Function>(function: &F, start: &[f64], tolerance: f64) -> Minimum {
    let n = start.len();
    let mut at = DVector::from_column_slice(start);
    let (mut value, left) = function.value(at.as_slice());
    let mut slope = DVector::from_vec(function.slope(at.as_slice(), &left));
    let mut inverse = DMatrix::<f64>::identity(n, n) * 0.05;
    let mut fresh = true;
    let mut settled = false;
    for _ in 0..ITERATIONS {
        let mut direction = -(&inverse * &slope);
        if direction.dot(&slope) >= 0.0 {
            inverse = DMatrix::identity(n, n) * 0.05;
            fresh = true;
            direction = -(&inverse * &slope);
        }
        let longest = direction.amax();
        if longest > LONGEST {
            direction *= LONGEST / longest;
        }
        let Some((step, next, left)) = line_search(function, &at, value, &direction, &slope) else {
            if fresh {
                break;
            }
            inverse = DMatrix::identity(n, n) * 0.05;
            fresh = true;
            continue;
        };
        let gained = value - next;
        let moved = direction * step;
        at += &moved;
        value = next;
        let next_slope = DVector::from_vec(function.slope(at.as_slice(), &left));
        let bent = &next_slope - &slope;
        slope = next_slope;
        let curvature = bent.dot(&moved);
        if curvature > 1e-10 {
            if fresh {
                inverse = DMatrix::identity(n, n) * (curvature / bent.norm_squared());
                fresh = false;
            }
            let rho = 1.0 / curvature;
            // In the product of a column and a row no entry is a sum.
            let left = DMatrix::identity(n, n) - &moved * bent.transpose() * rho;
            inverse =
                product(&product(&left, &inverse), &left.transpose()) + &moved * moved.transpose() * rho;
        }
        if gained < tolerance {
            // A step that gains little may come from a poor metric: the search ends only with a fresh one, or
            // after two.
            if fresh || settled {
                break;
            }
            settled = true;
        } else {
            settled = false;
        }
    }
    Minimum { at: at.as_slice().to_vec(), value }
}

/// Backtracks until the decrease is one ten-thousandth of what the slope promises (Armijo).
fn line_search<F: Function>(
    function: &F,
    at: &DVector<f64>,
    value: f64,
    direction: &DVector<f64>,
    slope: &DVector<f64>,
) -> Option<(f64, f64, F::Left)> {
    let promised = direction.dot(slope);
    let mut step = 1.0;
    for _ in 0..12 {
        let (next, left) = function.value((at + direction * step).as_slice());
        if next.is_finite() && next <= value + 1e-4 * step * promised {
            return Some((step, next, left));
        }
        step *= 0.4;
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_the_bottom_of_a_bent_valley() {
        // Rosenbrock's function, its minimum at (1, 1), less steep: the differences are not exact.
        let valley = |x: &[f64]| (1.0 - x[0]).powi(2) + 10.0 * (x[1] - x[0] * x[0]).powi(2);
        let valley = Differences { function: valley, executor: &executor::Inline };
        let minimum = minimise(&valley, &[-1.2, 1.0], 1e-12);
        assert!(minimum.value < 1e-3, "{minimum:?}");
        assert!((minimum.at[0] - 1.0).abs() < 0.05);
    }
}
