//! A flight in the form that the diagnosis uses: block means of residuals and of every candidate's regressor.
//!
//! Averaging over blocks is linear, so a model that holds for the readings holds for the block means with the
//! same coefficients. Only the noise within a block is approximated.

use std::sync::Arc;

use kf_core::sensor::SENSORS;

/// One value per sensor, in the order of [`kf_core::sensor::Sensor`].
pub type BySensor = [f64; SENSORS];

/// Block means of one flight.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Series {
    /// Mid time of every block, seconds, increasing.
    pub time_s: Vec<f64>,
    /// Number of fixes of the reference within each block; at least part of one.
    pub fixes: Vec<f64>,
    /// Whether the block lies in free flight (after launch, or after the calibration window).
    pub free: Vec<bool>,
    /// Mean residual of each sensor in each block, metres; NaN where the sensor has no reading there.
    pub residual_m: Vec<BySensor>,
    /// Number of readings of each sensor in each block.
    pub readings: Vec<[u32; SENSORS]>,
    /// Mean regressor of every column in each block, metres per unit of the coefficient, by the sensor whose
    /// residual it is added to; zero for a sensor that the column does not act on. All copies share it,
    /// because the columns are nearly all of a series' memory.
    pub columns: Vec<Arc<Vec<BySensor>>>,
    /// Length of a block, seconds.
    pub block_s: f64,
    /// Number of readings in a full block, by sensor (the median).
    pub full_block: BySensor,
    /// Remaining error (1 sigma) of the forward acceleration that inertial regressors integrate, m/s^2.
    pub forward_sigma_mps2: f64,
}

impl Series {
    /// Number of blocks.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.time_s.len()
    }

    /// Whether there are no blocks.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.time_s.is_empty()
    }

    /// Whether the sensor has any block.
    #[must_use]
    pub fn has(&self, sensor: usize) -> bool {
        self.residual_m.iter().any(|residuals| residuals[sensor].is_finite())
    }

    /// Whether any block lies in captive flight and any in free flight.
    #[must_use]
    pub fn has_both_phases(&self) -> bool {
        self.free.iter().any(|free| *free) && self.free.iter().any(|free| !*free)
    }
}
