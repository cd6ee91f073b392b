//! The oracle: a dense f64 Kalman filter, eqs 4 to 8 as a textbook prints them (with the gain that
//! eq. 14 drops, and Joseph's form of eq. 8, which stays positive). It shares nothing with kf-core.

use nalgebra::{DMatrix, DVector};

/// A discrete Kalman filter of any size.
#[derive(Clone, Debug)]
pub struct Textbook {
    /// State x `[n]`.
    pub state: DVector<f64>,
    /// Covariance P [n x n].
    pub covariance: DMatrix<f64>,
}

impl Textbook {
    /// Initial state and covariance (eq. 3).
    #[must_use]
    pub const fn new(state: DVector<f64>, covariance: DMatrix<f64>) -> Self {
        Self { state, covariance }
    }

    /// The paper's problem in the paper's order: altitude, three biases (section 3.2).
    #[must_use]
    pub fn paper() -> Self {
        let sigmas = DVector::from_row_slice(&[50.0, 100.0, 150.0, 300.0]);
        Self::new(
            DVector::from_row_slice(&[2100.0, 0.0, 0.0, 0.0]),
            DMatrix::from_diagonal(&sigmas.map(|s| s * s)),
        )
    }

    /// H of section 3.2, with columns for coefficients whose regressors (per sensor) are given.
    #[must_use]
    pub fn paper_observation(regressors_m: &[Vec<f64>; 3]) -> DMatrix<f64> {
        let effects = regressors_m[0].len();
        let mut h = DMatrix::zeros(4, 4 + effects);
        for i in 0..4 {
            h[(i, 0)] = 1.0;
        }
        for (i, own) in regressors_m.iter().enumerate() {
            h[(i + 1, i + 1)] = 1.0;
            for (j, phi) in own.iter().enumerate() {
                h[(i + 1, 4 + j)] = *phi;
            }
        }
        h
    }

    /// R of section 3.2, m^2.
    #[must_use]
    pub fn paper_noise() -> DMatrix<f64> {
        DMatrix::from_diagonal(&DVector::from_row_slice(&[625.0, 2500.0, 4900.0, 22_500.0]))
    }

    /// Eqs 4 and 5: `x = A x + B u`, `P = A P A' + G Q G'`.
    pub fn propagate(&mut self, a: &DMatrix<f64>, bu: &DVector<f64>, g: &DMatrix<f64>, q: &DMatrix<f64>) {
        self.state = a * &self.state + bu;
        self.covariance = a * &self.covariance * a.transpose() + g * q * g.transpose();
    }

    /// Eqs 6 to 8. Returns the innovation and its covariance; `None` (and nothing changed) if that
    /// cannot be inverted.
    pub fn update(
        &mut self,
        y: &DVector<f64>,
        h: &DMatrix<f64>,
        r: &DMatrix<f64>,
    ) -> Option<(DVector<f64>, DMatrix<f64>)> {
        let s = h * &self.covariance * h.transpose() + r;
        let k = &self.covariance * h.transpose() * s.clone().try_inverse()?;
        let innovation = y - h * &self.state;
        self.state += &k * &innovation;
        let n = self.state.len();
        let rest = DMatrix::identity(n, n) - &k * h;
        self.covariance = &rest * &self.covariance * rest.transpose() + &k * r * k.transpose();
        Some((innovation, s))
    }

    /// Standard deviation of one state.
    #[must_use]
    pub fn sigma(&self, index: usize) -> f64 {
        self.covariance[(index, index)].sqrt()
    }
}
