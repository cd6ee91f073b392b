//! Numbers with an answer.

use serde::Serialize;

/// Where an array lies in the numbers that are handed over with an answer: f64, in the machine's own order.
///
/// NaN stands for: no value here.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Numbers {
    /// The first one's place.
    pub start: u32,
    /// How many.
    pub length: u32,
}
