//! Autocorrelation and cross-correlation.

use serde::{Deserialize, Serialize};

use super::{ModelText, Numbers, Signal, Times};

/// Asks how a signal (a sensor's error) is correlated with itself or another.
#[derive(Clone, Debug, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct CorrelationRequest {
    /// The flight.
    pub flight: String,
    /// The model that flies.
    pub model: ModelText,
    /// What the user says of its times.
    pub times: Times,
    /// The signal.
    pub signal: Signal,
    /// The other; null: with itself.
    pub with: Option<Signal>,
    /// From when, seconds of the flight's own clock; null: from its first row.
    pub from_s: Option<f64>,
    /// To when; null: to its last.
    pub to_s: Option<f64>,
    /// The longest lag, seconds.
    pub longest_lag_s: f64,
}

/// A correlation by lag.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Correlated {
    /// Lags, seconds; of a cross-correlation on both sides of zero, positive where the signal is behind the
    /// other.
    pub lag_s: Numbers,
    /// The correlation, from -1 to 1.
    pub correlation: Numbers,
    /// Half the width of the band that 99 of 100 correlations at a lag lie in where there is none, as
    /// MATLAB's `resid` draws it: of white noise for an autocorrelation, by Bartlett's formula, from both
    /// autocorrelations, for a cross-correlation.
    pub band: f64,
    /// Length of the block means that it is made of, seconds.
    pub block_s: f64,
    /// How many.
    pub blocks: u32,
    /// Whether the time asked for was too short, or the signal has too many gaps, for lags that long; they
    /// end sooner.
    pub is_cut: bool,
}
