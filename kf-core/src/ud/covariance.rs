//! Covariance from the factors.

use super::UdFilter;

impl<const HEAD: usize, const TAIL: usize> UdFilter<HEAD, TAIL> {
    /// Part of a row of U right of the head, without a tail state's 1 on the diagonal, and the column at
    /// which it begins.
    fn row(&self, state: usize) -> (&[f32], usize) {
        match state.checked_sub(HEAD) {
            None => (self.cross.get(state).map_or(&[], |row| row), 0),
            Some(tail) => {
                (self.factor.get(tail).and_then(|row| row.get(tail + 1..)).unwrap_or(&[]), tail + 1)
            }
        }
    }

    /// One entry of P; rows and columns count head states first. Zero outside the matrix. On the diagonal it
    /// equals [`Self::variance`], to the bit.
    #[must_use]
    pub fn covariance(&self, row: usize, column: usize) -> f32 {
        if row == column {
            return self.variance(row);
        }
        let ((upper, from), (lower, start)) = (self.row(row.min(column)), self.row(row.max(column)));
        let above = upper.get(start - from..).unwrap_or(&[]);
        let d = self.tail_d.get(start..).unwrap_or(&[]);
        let both: f32 = above.iter().zip(lower).zip(d).map(|((upper, lower), d)| upper * d * lower).sum();
        // Factor of the 1 on the lower row's diagonal; in the head it is a zero of the upper row.
        let on_diagonal = match start.checked_sub(1) {
            Some(tail) => {
                let upper = upper.get(tail.saturating_sub(from));
                upper.zip(self.tail_d.get(tail)).map_or(0.0, |(upper, d)| upper * d)
            }
            None => 0.0,
        };
        on_diagonal + both
    }

    /// Every entry of the upper triangle of P, to the bit as [`Self::covariance`] returns it, as row, column
    /// and entry: all of them cost little more than the last few taken one by one.
    #[inline(always)]
    pub(crate) fn for_each_covariance(&self, mut take: impl FnMut(usize, usize, f32)) {
        for (i, upper) in self.cross.iter().enumerate() {
            let weighted: [f32; TAIL] = core::array::from_fn(|k| upper[k] * self.tail_d[k]);
            take(i, i, self.variance(i));
            for (j, lower) in self.cross.iter().enumerate().skip(i + 1) {
                take(i, j, 0.0 + products(&weighted, lower));
            }
            for j in 0..TAIL {
                take(i, HEAD + j, weighted[j] + products(&weighted[j + 1..], &self.factor[j][j + 1..]));
            }
        }
        let variances = self.tail_variances();
        for (i, upper) in self.factor.iter().enumerate() {
            let weighted: [f32; TAIL] = core::array::from_fn(|k| upper[k] * self.tail_d[k]);
            take(HEAD + i, HEAD + i, variances[i]);
            for j in i + 1..TAIL {
                take(
                    HEAD + i,
                    HEAD + j,
                    weighted[j] + products(&weighted[j + 1..], &self.factor[j][j + 1..]),
                );
            }
        }
    }

    /// Variance of one state; head states first. Zero outside the state vector.
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

/// `sum_k a_k b_k`.
#[inline(always)]
fn products(a: &[f32], b: &[f32]) -> f32 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
