//! Gusts that the aircraft flies through.

use super::super::random::{GaussMarkov, Random};
use super::super::rotation::Vector;
use super::super::scenario::Turbulence;

pub(super) struct Gusts {
    turbulence: Turbulence,
    axes: [GaussMarkov; 3],
}

impl Gusts {
    pub(super) fn new(turbulence: Turbulence) -> Self {
        Self { turbulence, axes: [GaussMarkov::default(); 3] }
    }

    /// The gust one row on, north-east-down, m/s. The field is frozen in the air, so the airspeed turns
    /// its length into time (Taylor's hypothesis).
    pub(super) fn next(&mut self, random: &mut Random, airspeed_mps: f64, dt: f64) -> Vector {
        let turbulence = &self.turbulence;
        let sigmas =
            [turbulence.horizontal_sigma_mps, turbulence.horizontal_sigma_mps, turbulence.vertical_sigma_mps];
        let step = dt * airspeed_mps / turbulence.length_m;
        let mut gust = [0.0; 3];
        for ((value, axis), sigma) in gust.iter_mut().zip(&mut self.axes).zip(sigmas) {
            *value = sigma * axis.next(random, step);
        }
        gust
    }
}
