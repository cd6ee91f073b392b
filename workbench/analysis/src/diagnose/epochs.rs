//! A flight as block means of residuals and regressors, and what is known of them.

use kf_core::sensor::Sensor;

use super::diagnosis::Glitch;
use super::series::Series;

/// A flight ready to be diagnosed.
#[derive(Clone, Debug)]
pub struct Epochs {
    /// Residuals, and one column for each candidate (all zero where it is not available).
    pub series: Series,
    /// For each candidate, whether the flight has its signals.
    pub available: Vec<bool>,
    /// Variance of the noise in every candidate's block means, m^2 per squared unit of the coefficient: a
    /// regressor is made of measured signals.
    pub column_noise_m2: Vec<f64>,
    /// Variance of the noise of a measured climb rate in a block's mean, m^2/s^2. The columns of delays are
    /// made of it, interpolated between the fixes, so that `column_noise_m2` does not contain it.
    pub climb_noise_m2: f64,
    /// Means of the signals in each block: those of [`super::signals::NAMES`], then the unknown columns.
    pub signals: Vec<Vec<f64>>,
    /// Names of the signals.
    pub signal_names: Vec<String>,
    /// Intervals in which the reference jumped away and came back.
    pub glitches: Vec<Glitch>,
    /// Lasting steps of the sensors' own altitudes: sensor, and time in seconds ([`replay::steps`]).
    pub steps: Vec<(Sensor, f64)>,
    /// Readings left out because the reference was lost around them.
    pub unreferenced: u64,
    /// Readings that the mission refuses as well: not finite, implausible, or of a sensor that is stuck.
    pub refused: u64,
}

impl Epochs {
    /// The same flight with these columns only, in this order. Columns do not depend on each other.
    pub(super) fn of_columns(&self, places: &[usize]) -> Self {
        let Self { series, signals, signal_names, glitches, steps, unreferenced, refused, .. } = self;
        let Series {
            time_s, fixes, free, residual_m, readings, block_s, full_block, forward_sigma_mps2, ..
        } = series;
        let column = |place: &usize| series.columns.get(*place).cloned().unwrap_or_default();
        Self {
            series: Series {
                columns: places.iter().map(column).collect(),
                time_s: time_s.clone(),
                fixes: fixes.clone(),
                free: free.clone(),
                residual_m: residual_m.clone(),
                readings: readings.clone(),
                block_s: *block_s,
                full_block: *full_block,
                forward_sigma_mps2: *forward_sigma_mps2,
            },
            available: places.iter().filter_map(|place| self.available.get(*place).copied()).collect(),
            column_noise_m2: places
                .iter()
                .filter_map(|place| self.column_noise_m2.get(*place).copied())
                .collect(),
            climb_noise_m2: self.climb_noise_m2,
            signals: signals.clone(),
            signal_names: signal_names.clone(),
            glitches: glitches.clone(),
            steps: steps.clone(),
            unreferenced: *unreferenced,
            refused: *refused,
        }
    }
}
