//! How much larger a coefficient's error is than its fit reports, because the whitened residual is not quite
//! white.

use nalgebra::{DMatrix, DVector};

use super::matrix::product;
use super::noise::Noise;
use super::problem::Problem;
use super::whitener::whiten;

/// Longest lag used, seconds: slower errors belong to the wander, which the fit includes.
const LONGEST_LAG_S: f64 = 8.0;

/// Long-run variance of each coefficient's score over the variance that the fit assumes for it, at least one
/// (Newey and West, "A simple, positive semi-definite, heteroskedasticity and autocorrelation consistent
/// covariance matrix", Econometrica 55, 1987; weights falling linearly with the lag).
#[must_use]
pub fn inflation(problem: &Problem<'_>, noise: &Noise, picks: &[usize]) -> Vec<f64> {
    let mut long_run = vec![0.0; picks.len()];
    let mut fitted = vec![0.0; picks.len()];
    for flight in problem.flights {
        let columns = problem.columns(flight, picks);
        let width = columns.len();
        let mut rows: Vec<f64> = Vec::new();
        let mut blocks: Vec<usize> = Vec::new();
        whiten(flight, noise, &columns, &|_| true, &mut |block, _, row| {
            rows.extend_from_slice(row);
            blocks.push(block);
        });
        let matrix = DMatrix::from_row_slice(blocks.len(), width, &rows);
        let rest = against_others(&matrix, 0, width);
        for k in 0..picks.len() {
            let column = 1 + problem.own() + k;
            let alone = against_others(&matrix, column, width);
            let mut score = vec![0.0; flight.len()];
            for (row, block) in blocks.iter().enumerate() {
                score[*block] += rest[row] * alone[row];
            }
            fitted[k] += alone.norm_squared();
            long_run[k] += variance(&score, flight.block_s);
        }
    }
    long_run
        .iter()
        .zip(&fitted)
        .map(|(long_run, fitted)| if *fitted > 0.0 { (long_run / fitted).max(1.0) } else { 1.0 })
        .collect()
}

/// Long-run variance of a sum of blocks of this length (seconds).
#[must_use]
pub fn variance(score: &[f64], block_s: f64) -> f64 {
    let lags = (LONGEST_LAG_S / block_s).ceil() as usize;
    let terms = (0..=lags.min(score.len().saturating_sub(1))).map(|lag| {
        let product: f64 = score.iter().zip(&score[lag..]).map(|(a, b)| a * b).sum();
        let weight = 1.0 - lag as f64 / (lags + 1) as f64;
        if lag == 0 { product } else { 2.0 * weight * product }
    });
    terms.sum()
}

/// What remains of a column after all the others except the residual are projected out of it.
fn against_others(matrix: &DMatrix<f64>, column: usize, width: usize) -> DVector<f64> {
    let others: Vec<usize> =
        (1..width).filter(|c| *c != column && matrix.column(*c).norm_squared() > 0.0).collect();
    let own = matrix.column(column).clone_owned();
    if others.is_empty() {
        return own;
    }
    let scale: Vec<f64> = others.iter().map(|c| matrix.column(*c).norm()).collect();
    let beside = DMatrix::from_fn(matrix.nrows(), others.len(), |row, c| matrix[(row, others[c])] / scale[c]);
    let normal = product(&beside.transpose(), &beside);
    match normal.cholesky() {
        Some(factor) => &own - &beside * factor.solve(&(beside.transpose() * &own)),
        None => own,
    }
}
