//! Reading the covariance out of the factors.

use super::UdFilter;

impl<const HEAD: usize, const TAIL: usize> UdFilter<HEAD, TAIL> {
    /// One entry of U; rows and columns count head states first.
    fn u(&self, row: usize, column: usize) -> f32 {
        if row == column {
            return 1.0;
        }
        let Some(tail_column) = column.checked_sub(HEAD) else { return 0.0 };
        let entries = match row.checked_sub(HEAD) {
            None => self.cross.get(row),
            Some(tail_row) if tail_row < tail_column => self.factor.get(tail_row),
            Some(_) => None,
        };
        entries.and_then(|entries| entries.get(tail_column)).copied().unwrap_or(0.0)
    }

    /// One entry of D.
    fn d(&self, index: usize) -> f32 {
        let entry = match index.checked_sub(HEAD) {
            None => self.head_d.get(index),
            Some(tail) => self.tail_d.get(tail),
        };
        entry.copied().unwrap_or(0.0)
    }

    /// One entry of P; rows and columns count head states first. Zero outside of the matrix. On the
    /// diagonal it is [`Self::variance`], to the bit.
    #[must_use]
    pub fn covariance(&self, row: usize, column: usize) -> f32 {
        if row == column {
            return self.variance(row);
        }
        let from = row.max(column);
        (from..HEAD + TAIL).map(|k| self.u(row, k) * self.d(k) * self.u(column, k)).sum()
    }

    /// Variance of one state; head states first. Zero outside of the state vector.
    #[must_use]
    pub fn variance(&self, index: usize) -> f32 {
        match index.checked_sub(HEAD) {
            None => {
                let own = self.head_d.get(index).copied().unwrap_or(0.0);
                let tail = self.cross.get(index).map_or(0.0, |row| weighted_squares(row, &self.tail_d));
                own + tail
            }
            Some(tail) => {
                let own = self.tail_d.get(tail).copied().unwrap_or(0.0);
                let row = self.factor.get(tail).and_then(|row| row.get(tail + 1..));
                let above = self.tail_d.get(tail + 1..);
                own + row.zip(above).map_or(0.0, |(row, d)| weighted_squares(row, d))
            }
        }
    }
}

/// `sum_k row_k^2 d_k`.
fn weighted_squares(row: &[f32], d: &[f32]) -> f32 {
    row.iter().zip(d).map(|(u, d)| u * u * d).sum()
}
