//! Measurements with correlated noise, transformed into uncorrelated scalars.

use super::factorise::factorise;
use super::{Innovation, NoiseVariance, Row, UdFilter};
use crate::error::FilterError;

/// Transforms `y = H x + v`, `v ~ N(0, R)` with full R into scalars with independent noise: `R = U D U^T`, so
/// `U^-1 v` has the diagonal covariance D (Bierman 1977, ch. II.7).
#[derive(Clone, Debug, PartialEq)]
pub struct Whitening<const M: usize> {
    u: [[f32; M]; M],
    d: [NoiseVariance; M],
}

impl<const M: usize> Whitening<M> {
    /// The whitening of measurement noise R [M x M].
    ///
    /// # Errors
    /// [`FilterError::NotFinite`]; [`FilterError::NotPositive`] if R is not positive definite.
    pub fn new(noise: &[[f32; M]; M]) -> Result<Self, FilterError> {
        let (u, variances) = factorise(noise)?;
        let mut d = [NoiseVariance(1.0); M];
        for (d, variance) in d.iter_mut().zip(variances) {
            *d = NoiseVariance::new(variance)?;
        }
        Ok(Self { u, d })
    }

    /// `U^-1 y` and `U^-1 H`, by back substitution.
    fn apply<const N: usize>(&self, y: &mut [f32; M], h: &mut [[f32; N]; M]) {
        for i in (0..M).rev() {
            for k in i + 1..M {
                let u = self.u[i][k];
                y[i] -= u * y[k];
                for column in 0..N {
                    h[i][column] -= u * h[k][column];
                }
            }
        }
    }
}

impl<const N: usize> UdFilter<0, N> {
    /// Takes a vector measurement with correlated noise (eqs 6 to 8 with full H and R), then folds.
    ///
    /// `y` is `[M]`, `h` is `[M x N]`. Returns the innovations of the whitened scalars; the sum of their
    /// [`Innovation::nis`] is the NIS of the vector.
    ///
    /// # Errors
    /// [`FilterError::NotFinite`]. The filter is then unchanged.
    pub fn update_vector<const M: usize>(
        &mut self,
        y: &[f32; M],
        h: &[[f32; N]; M],
        whitening: &Whitening<M>,
    ) -> Result<[Innovation; M], FilterError> {
        let mut next = self.clone();
        let mut y = *y;
        let mut h = *h;
        whitening.apply(&mut y, &mut h);
        let mut innovations = [Innovation { value: 0.0, variance: 1.0 }; M];
        for i in 0..M {
            let row = Row { head: None, tail: h[i], first: 0 };
            innovations[i] = next.update(&row, y[i], whitening.d[i])?;
        }
        next.fold();
        *self = next;
        Ok(innovations)
    }
}
