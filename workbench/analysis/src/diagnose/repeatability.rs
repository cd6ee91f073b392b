//! Whether a coefficient repeats from one part of the flights to the next.

use super::information::Information;
use super::long_run;
use super::noise::Noise;
use super::problem::Problem;
use super::series::Series;
use super::whitener::whiten;

use nalgebra::DMatrix;

/// Number of parts into which a flight is cut.
pub(super) const PARTS: usize = 10;
/// A coefficient may differ by this share from part to part without its formula being wrong.
const SHAPE: f64 = 0.1;
/// Beyond this, the spread over the parts is not chance: 99 % of chi-squared of 9 over 9.
const CHANCE: f64 = 2.4;

/// How a coefficient varies when each part in turn is left out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Repeatability {
    /// Factor by which the fit's variance is too small for the spread over the parts; at least 1, and 1 where
    /// the spread may be chance.
    pub inflation: f64,
    /// The mean square of the deviations over its expected value, which allows for a share of the
    /// coefficient's own size; large where the formula is wrong.
    pub unevenness: f64,
}

/// Leaves out each part in turn (a delete-a-group jackknife; Shao and Tu, "The Jackknife and Bootstrap",
/// section 2.3). A part without which a coefficient is not known at all is no evidence about repeatability.
#[must_use]
pub fn repeatability(problem: &Problem<'_>, noise: &Noise, picks: &[usize]) -> Vec<Repeatability> {
    let all: Vec<usize> = (0..picks.len()).collect();
    let parts: Vec<Parts> = problem.flights.iter().map(|flight| cut(problem, flight, noise, picks)).collect();
    let Some(whole) = total(problem, &parts, None, picks.len()).solve(&all) else { return Vec::new() };
    let n = picks.len();
    let mut chance = vec![(0.0, 0u32); n];
    let mut uneven = vec![0.0; n];
    for (flight, cut) in parts.iter().enumerate() {
        for part in 0..cut.products.len() {
            let Some(rest) = total(problem, &parts, Some((flight, part)), n).solve(&all) else { continue };
            for k in 0..n {
                let variance = rest.covariance[k * n + k] - whole.covariance[k * n + k];
                // Without this part the coefficient is not known well enough to compare.
                if variance <= 0.0 || rest.covariance[k * n + k] > 9.0 * whole.covariance[k * n + k] {
                    continue;
                }
                let moved = (rest.coefficients[k] - whole.coefficients[k]).powi(2);
                let share = variance / rest.covariance[k * n + k];
                chance[k].0 += moved / variance;
                chance[k].1 += 1;
                uneven[k] += moved / (variance + (SHAPE * whole.coefficients[k]).powi(2) * share);
            }
        }
    }
    let judged = chance.iter().zip(&uneven).map(|((sum, count), uneven)| {
        let mean = |sum: f64| if *count > 2 { sum / f64::from(*count) } else { 1.0 };
        let inflation = mean(*sum);
        Repeatability {
            inflation: if inflation > CHANCE { inflation } else { 1.0 },
            unevenness: mean(*uneven),
        }
    });
    judged.collect()
}

/// The factor by which the variance of each coefficient exceeds that of its fit: the larger of those by its
/// spread over the parts and by the residual's autocorrelation.
#[must_use]
pub fn inflation(
    problem: &Problem<'_>,
    noise: &Noise,
    picks: &[usize],
    repeat: &[Repeatability],
) -> Vec<f64> {
    let long_run = long_run::inflation(problem, noise, picks);
    let repeat = repeat.iter().map(|repeat| repeat.inflation).chain(std::iter::repeat(1.0));
    long_run.iter().zip(repeat).map(|(a, b)| a.max(b)).collect()
}

/// Normal equations of a flight's parts.
struct Parts {
    products: Vec<DMatrix<f64>>,
    rows: usize,
}

fn cut(problem: &Problem<'_>, flight: &Series, noise: &Noise, picks: &[usize]) -> Parts {
    let columns = problem.columns(flight, picks);
    let width = columns.len();
    let part = |block: usize| (block * PARTS / flight.len().max(1)).min(PARTS - 1);
    let mut products = vec![DMatrix::zeros(width, width); PARTS];
    let mut rows = 0;
    whiten(flight, noise, &columns, &|_| true, &mut |block, _, row| {
        rows += 1;
        let products: &mut DMatrix<f64> = &mut products[part(block)];
        for (c, b) in row.iter().enumerate() {
            for (r, a) in row.iter().enumerate() {
                products[(r, c)] += a * b;
            }
        }
    });
    Parts { products, rows }
}

fn total(problem: &Problem<'_>, parts: &[Parts], left_out: Option<(usize, usize)>, n: usize) -> Information {
    let mut information = Information::new(1 + n);
    for (flight, cut) in parts.iter().enumerate() {
        let width = 1 + problem.own() + n;
        let mut sum = DMatrix::zeros(width, width);
        for (part, products) in cut.products.iter().enumerate() {
            if left_out != Some((flight, part)) {
                sum += products;
            }
        }
        problem.add_prior(&mut sum);
        information.add_flight(&sum, problem.own(), cut.rows, 0.0);
    }
    information
}
