//! Autocorrelation and cross-correlation.

use serde::{Deserialize, Serialize};

use super::{ModelText, Numbers, Signal, Times};

/// Asks for the correlation of a signal (a sensor's error) with itself or another.
#[derive(Clone, Debug, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct CorrelationRequest {
    /// The flight.
    pub flight: String,
    /// The model to fly.
    pub model: ModelText,
    /// The user's times for it.
    pub times: Times,
    /// The signal.
    pub signal: Signal,
    /// The other signal; null: the signal itself.
    pub with: Option<Signal>,
    /// Start, seconds of the flight's own clock; null: its first row.
    pub from_s: Option<f64>,
    /// End; null: its last row.
    pub to_s: Option<f64>,
    /// The longest lag, seconds.
    pub longest_lag_s: f64,
}

/// A correlation by lag.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Correlated {
    /// Lags, seconds; for a cross-correlation on both sides of zero, positive if the signal lags the other.
    pub lag_s: Numbers,
    /// The correlation, from -1 to 1.
    pub correlation: Numbers,
    /// Half the width of the band that holds 99 of 100 correlations at a lag if there is no true correlation,
    /// as MATLAB's `resid` draws it: that of white noise for an autocorrelation; by Bartlett's formula, from
    /// both autocorrelations, for a cross-correlation.
    pub band: f64,
    /// Length of the blocks whose means are correlated, seconds.
    pub block_s: f64,
    /// Number of blocks.
    pub blocks: u32,
    /// Whether the lags end sooner than asked for, because the time is too short or the signal has too many
    /// gaps.
    pub is_cut: bool,
}
