//! What the noise of the reference's own altitude does to `baro.scale`, whose regressor is made of it where the climb rate is not
//! measured.
//!
//! The residual has the reference's error with one sign and the regressor with the other, which draws the coefficient towards -1 by
//! the share that the error has of the regressor's square: some thousandths over a thousand metres, a tenth in level flight. With
//! the sensor's own altitude for the regressor it is the sensor's error, and draws the other way. The truth lies between
//! the two (Frisch, "Statistical Confluence Analysis by Means of Complete Regression Systems", 1934; Klepper and Leamer,
//! "Consistent sets of estimates for regressions with errors in all variables", Econometrica 52, 1984), so how far they are
//! apart is how unsure the coefficient is beside its noise.

use kf_core::effect::EffectId;
use kf_core::sensor::Sensor;

use super::candidates::Candidate;
use super::epochs::Epochs;
use super::noise::Noise;
use super::problem::Problem;

/// A column, and the one that is the same by the sensor's own altitude.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reversed {
    column: usize,
    by_sensor: usize,
}

/// Appends the altitude by the barometer itself to every flight's columns.
pub(super) fn reversed(
    epochs: &mut [Epochs],
    held: &mut [Epochs],
    candidates: &[Candidate],
) -> Option<Reversed> {
    let column = candidates.iter().position(|candidate| candidate.effect() == EffectId::BaroScale)?;
    let baro = Sensor::Baro.index();
    for epochs in epochs.iter_mut().chain(held.iter_mut()) {
        let series = &epochs.series;
        let with_residual = series.columns[column].iter().zip(&series.residual_m).map(|(row, residuals)| {
            let mut row = *row;
            row[baro] += if residuals[baro].is_finite() { residuals[baro] } else { 0.0 };
            row
        });
        let with_residual = with_residual.collect();
        epochs.series.columns.push(with_residual);
    }
    let by_sensor = epochs.first().map(|epochs| epochs.series.columns.len() - 1)?;
    Some(Reversed { column, by_sensor })
}

impl Reversed {
    /// What the noise of altitudes adds to the variance of each chosen column's coefficient.
    pub(super) fn variances(self, problem: &Problem<'_>, noise: &Noise, columns: &[usize]) -> Vec<f64> {
        let mut variances = vec![0.0; columns.len()];
        if let Some(at) = columns.iter().position(|column| *column == self.column) {
            let all: Vec<usize> = (0..columns.len()).collect();
            let mut reversed = columns.to_vec();
            reversed[at] = self.by_sensor;
            let fitted = |columns: &[usize]| problem.information(noise, columns).solve(&all);
            if let (Some(direct), Some(reversed)) = (fitted(columns), fitted(&reversed)) {
                variances[at] = (direct.coefficients[at] - reversed.coefficients[at]).powi(2);
            }
        }
        variances
    }
}
