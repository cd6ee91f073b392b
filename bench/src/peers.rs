//! The peers: published filters, each used as its own documentation recommends and in its cheapest form.

use adskalman::{CovarianceUpdateMethod, ObservationModel, StateAndCovariance};
use kfilter::measurement::LinearMeasurement;
use kfilter::{KalmanFilter as _, KalmanLinearNoInput, KalmanUpdate as _};
use multicalc::estimation::{CovarianceUpdate, KalmanFilter, KalmanModel};
use multicalc::linear_algebra as mc;
use nalgebra::{Matrix4, U4, Vector4};
use nalgebra_0_34 as na34;

use crate::problem::{COVARIANCE, Filter, NOISE, OBSERVATION, STATE};

/// An element of a diagonal matrix.
fn diagonal(values: &[f32; 4], row: usize, column: usize) -> f32 {
    if row == column { values[row] } else { 0.0 }
}

/// kfilter, `ROWS` measurements at a time.
pub struct Kfilter<const ROWS: usize, const TIMES: usize> {
    filter: KalmanLinearNoInput<f32, 4>,
    measurements: [LinearMeasurement<f32, 4, ROWS>; TIMES],
}

impl<const ROWS: usize, const TIMES: usize> Kfilter<ROWS, TIMES> {
    /// On the paper's problem.
    pub fn new() -> Self {
        let filter = KalmanLinearNoInput::new(
            na34::SMatrix::identity(),
            na34::SMatrix::zeros(),
            na34::SVector::from(STATE),
            na34::SMatrix::from_fn(|row, column| diagonal(&COVARIANCE, row, column)),
        );
        let measurements = core::array::from_fn(|time| {
            LinearMeasurement::new(
                na34::SMatrix::from_fn(|row, column| OBSERVATION[time * ROWS + row][column]),
                na34::SMatrix::from_fn(|row, column| {
                    diagonal(&NOISE, time * ROWS + row, time * ROWS + column)
                }),
                na34::SVector::zeros(),
            )
        });
        Self { filter, measurements }
    }
}

impl<const ROWS: usize, const TIMES: usize> Filter for Kfilter<ROWS, TIMES> {
    fn tick(&mut self, _time_us: u64, measurements: &[f32; 4]) {
        for (measurement, values) in self.measurements.iter_mut().zip(measurements.chunks_exact(ROWS)) {
            measurement.z.copy_from_slice(values);
            // A refused update becomes apparent when the results are compared.
            let _ = self.filter.update(measurement);
        }
    }

    fn state(&self) -> [f32; 4] {
        (*self.filter.state()).into()
    }

    fn variances(&self) -> [f32; 4] {
        self.filter.covariance().diagonal().into()
    }
}

/// adskalman's observation model of the paper's problem.
struct AdskalmanModel {
    h: Matrix4<f32>,
    ht: Matrix4<f32>,
    r: Matrix4<f32>,
}

impl ObservationModel<f32, U4, U4> for AdskalmanModel {
    fn H(&self) -> &Matrix4<f32> {
        &self.h
    }

    fn HT(&self) -> &Matrix4<f32> {
        &self.ht
    }

    fn R(&self) -> &Matrix4<f32> {
        &self.r
    }
}

/// adskalman, with its cheapest covariance update.
pub struct Adskalman {
    model: AdskalmanModel,
    estimate: StateAndCovariance<f32, U4>,
}

impl Adskalman {
    /// On the paper's problem.
    pub fn new() -> Self {
        let h = Matrix4::from_fn(|row, column| OBSERVATION[row][column]);
        Self {
            model: AdskalmanModel { h, ht: h.transpose(), r: Matrix4::from_diagonal(&Vector4::from(NOISE)) },
            estimate: StateAndCovariance::new(
                Vector4::from(STATE),
                Matrix4::from_diagonal(&Vector4::from(COVARIANCE)),
            ),
        }
    }
}

impl Filter for Adskalman {
    fn tick(&mut self, _time_us: u64, measurements: &[f32; 4]) {
        let measurements = Vector4::from(*measurements);
        if let Ok(estimate) =
            self.model.update(&self.estimate, &measurements, CovarianceUpdateMethod::OptimalKalman)
        {
            self.estimate = estimate;
        }
    }

    fn state(&self) -> [f32; 4] {
        (*self.estimate.state()).into()
    }

    fn variances(&self) -> [f32; 4] {
        self.estimate.covariance().diagonal().into()
    }
}

/// multicalc, with its cheaper covariance update.
pub struct Multicalc(KalmanFilter<4, 4, f32>);

impl Multicalc {
    /// On the paper's problem.
    pub fn new() -> Self {
        let diagonal_matrix = |values: &[f32; 4]| {
            mc::Matrix::new(core::array::from_fn(|row| {
                core::array::from_fn(|column| diagonal(values, row, column))
            }))
        };
        let model = KalmanModel {
            state_transition: mc::Matrix::identity(),
            measurement_model: mc::Matrix::new(OBSERVATION),
            process_noise: mc::Matrix::zeros(),
            measurement_noise: diagonal_matrix(&NOISE),
        };
        Self(
            KalmanFilter::new(mc::Vector::new(STATE), diagonal_matrix(&COVARIANCE), model)
                .with_covariance_update(CovarianceUpdate::Naive),
        )
    }
}

impl Filter for Multicalc {
    fn tick(&mut self, _time_us: u64, measurements: &[f32; 4]) {
        // A refused update becomes apparent when the results are compared.
        let _ = self.0.update(mc::Vector::new(*measurements));
    }

    fn state(&self) -> [f32; 4] {
        core::array::from_fn(|row| self.0.state()[row])
    }

    fn variances(&self) -> [f32; 4] {
        core::array::from_fn(|row| self.0.covariance()[(row, row)])
    }
}
