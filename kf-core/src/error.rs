//! Why an operation of the filter was refused. A refused operation leaves the filter unchanged.

/// Refusal of a filter operation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FilterError {
    /// A measurement, row, matrix or variance is NaN or infinite, or makes the result so.
    NotFinite,
    /// A noise variance is not positive, so that an innovation variance might not be.
    NotPositive,
    /// The operation would couple states that this filter's shape keeps uncoupled
    /// (process noise on a tail state while there are head states).
    Shape,
    /// The innovation is beyond its gate.
    Gated {
        /// Whether it is positive: the measurement lies above its prediction.
        above: bool,
    },
    /// The caller did not admit the innovations.
    Refused,
}
