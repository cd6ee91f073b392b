//! The textbook's filter (paper, eqs 6 to 8, with the gain that eq. 14 drops) written with nalgebra, and an
//! unpublished variant that a careful engineer would write.

use nalgebra::{Matrix4, RowVector4, Vector4};

use crate::problem::{COVARIANCE, Filter, NOISE, OBSERVATION, STATE};

/// Four scalar updates a tick; `RANK_ONE`: `P - K (P h')'` instead of eq. 8's `(I - K h) P`.
pub struct Sequential<const RANK_ONE: bool> {
    x: Vector4<f32>,
    p: Matrix4<f32>,
    h: [RowVector4<f32>; 4],
    r: [f32; 4],
}

impl<const RANK_ONE: bool> Sequential<RANK_ONE> {
    /// On the paper's problem.
    pub fn new() -> Self {
        Self {
            x: Vector4::from(STATE),
            p: Matrix4::from_diagonal(&Vector4::from(COVARIANCE)),
            h: OBSERVATION.map(RowVector4::from),
            r: NOISE,
        }
    }
}

impl<const RANK_ONE: bool> Filter for Sequential<RANK_ONE> {
    fn tick(&mut self, _time_us: u64, measurements: &[f32; 4]) {
        for ((h, r), y) in self.h.iter().zip(&self.r).zip(measurements) {
            let pht = self.p * h.transpose();
            let gain = pht / ((h * pht).x + r);
            self.x += gain * (y - (h * self.x).x);
            if RANK_ONE {
                self.p -= gain * pht.transpose();
            } else {
                self.p = (Matrix4::identity() - gain * h) * self.p;
            }
        }
    }

    fn state(&self) -> [f32; 4] {
        self.x.into()
    }

    fn variances(&self) -> [f32; 4] {
        self.p.diagonal().into()
    }
}

/// One update a tick with a 4 x 4 inverse.
pub struct Dense {
    x: Vector4<f32>,
    p: Matrix4<f32>,
    h: Matrix4<f32>,
    r: Matrix4<f32>,
}

impl Dense {
    /// On the paper's problem.
    pub fn new() -> Self {
        Self {
            x: Vector4::from(STATE),
            p: Matrix4::from_diagonal(&Vector4::from(COVARIANCE)),
            h: Matrix4::from_fn(|row, column| OBSERVATION[row][column]),
            r: Matrix4::from_diagonal(&Vector4::from(NOISE)),
        }
    }
}

impl Filter for Dense {
    fn tick(&mut self, _time_us: u64, measurements: &[f32; 4]) {
        let pht = self.p * self.h.transpose();
        let Some(inverse) = (self.h * pht + self.r).try_inverse() else {
            return;
        };
        let gain = pht * inverse;
        self.x += gain * (Vector4::from(*measurements) - self.h * self.x);
        self.p = (Matrix4::identity() - gain * self.h) * self.p;
    }

    fn state(&self) -> [f32; 4] {
        self.x.into()
    }

    fn variances(&self) -> [f32; 4] {
        self.p.diagonal().into()
    }
}
