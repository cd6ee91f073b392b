//! Numbers with an answer.

use serde::Serialize;

/// Position of an array in the numbers that are handed over with an answer: f64, in the machine's byte order.
///
/// NaN means that there is no value.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Numbers {
    /// Index of the first number.
    pub start: u32,
    /// Number of values.
    pub length: u32,
}
