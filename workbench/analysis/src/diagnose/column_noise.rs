//! How much noise is in a candidate's column.

/// The noise of a column, by the second differences of its samples. A regressor is straight within a few
/// hundredths of a second, so these bends are the noise of its signals (after von Neumann, "Distribution of
/// the ratio of the mean square successive difference to the variance", 1941). Held samples do not count.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ColumnNoise {
    last: [Option<f64>; 2],
    squares: f64,
    bends: u64,
}

/// With fewer bends than this, the noise is not estimated.
pub(super) const FEW_BENDS: u64 = 20;

/// Squares of a bend's three weights, 1, -2 and 1: its variance over that of a sample.
pub(super) const BEND: f64 = 6.0;

impl ColumnNoise {
    pub(super) fn take(&mut self, value: f64) {
        if self.last[0] == Some(value) {
            return;
        }
        if let [Some(last), Some(before)] = self.last {
            let bend = value - 2.0 * last + before;
            self.squares += bend * bend;
            self.bends += 1;
        }
        self.last = [Some(value), self.last[0]];
    }

    /// Variance of the mean of a block's samples.
    pub(super) fn of_mean(&self, blocks: usize) -> f64 {
        if self.bends < FEW_BENDS || blocks == 0 {
            return 0.0;
        }
        let one = self.squares / (BEND * self.bends as f64);
        one / (self.bends as f64 / blocks as f64).max(1.0)
    }
}
