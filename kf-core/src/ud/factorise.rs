//! The factors of a full covariance.

use super::UdFilter;
use crate::error::FilterError;

/// `matrix = U D U^T` (Bierman 1977, eq. III.4.7 ff.): U unit upper triangular, D diagonal.
///
/// Only the upper triangle of `matrix` is read.
///
/// # Errors
/// [`FilterError::NotFinite`]; [`FilterError::NotPositive`] if the matrix is not positive definite.
pub(super) type Factors<const N: usize> = ([[f32; N]; N], [f32; N]);

pub(super) fn factorise<const N: usize>(matrix: &[[f32; N]; N]) -> Result<Factors<N>, FilterError> {
    let mut p = *matrix;
    let mut u = [[0.0; N]; N];
    let mut d = [0.0; N];
    for j in (0..N).rev() {
        let pivot = p[j][j];
        if !pivot.is_finite() {
            return Err(FilterError::NotFinite);
        }
        if pivot <= 0.0 {
            return Err(FilterError::NotPositive);
        }
        d[j] = pivot;
        u[j][j] = 1.0;
        for k in 0..j {
            let entry = p[k][j] / pivot;
            if !entry.is_finite() {
                return Err(FilterError::NotFinite);
            }
            u[k][j] = entry;
            for i in 0..=k {
                p[i][k] -= u[i][j] * entry * pivot;
            }
        }
    }
    Ok((u, d))
}

impl<const N: usize> UdFilter<0, N> {
    /// A filter with correlated states (x0 and P0 of eq. 3).
    ///
    /// # Errors
    /// [`FilterError::NotFinite`]; [`FilterError::NotPositive`] if P0 is not positive definite.
    pub fn with_covariance(state: [f32; N], covariance: &[[f32; N]; N]) -> Result<Self, FilterError> {
        let (factor, d) = factorise(covariance)?;
        let mut filter = Self::new([], [], state, d)?;
        filter.factor = factor;
        Ok(filter)
    }
}
