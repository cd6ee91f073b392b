//! A flight's traces as the tables from which its charts are drawn.

use kf_core::sensor::{SENSORS, Sensor};

use super::table::Table;
use crate::compare::{Comparison, EstimateTrace, ModelTrace, Traces};

/// Columns of a sensor's readings against the model.
pub(super) const MEASURED: usize = 0;
/// See [`MEASURED`].
pub(super) const MODELLED: usize = 1;
/// See [`MEASURED`].
pub(super) const ERROR: usize = 2;
/// Columns of an estimate or an error.
pub(super) const VALUE: usize = 0;
/// See [`VALUE`].
pub(super) const SIGMA: usize = 1;
/// Column of the moving average in free flight; the error itself is [`VALUE`].
pub(super) const AVERAGE: usize = 1;

/// The data from which a flight's charts are drawn. Lengths in metres, times by the flight's own clock.
#[derive(Clone, Debug)]
pub(super) struct Recording {
    /// When the UAV was launched, microseconds.
    pub(super) launch_us: Option<u64>,
    /// Altitude of the reference in captive flight: its estimate and sigma.
    pub(super) altitude: Table,
    /// Biases in captive flight: estimate and sigma.
    pub(super) biases: [Table; SENSORS],
    /// Innovation of the reference in captive flight.
    pub(super) reference_residual: Table,
    /// Calibrated residuals in captive flight.
    pub(super) captive_error: [Table; SENSORS],
    /// Errors and their moving averages in free flight.
    pub(super) free_error: [Table; SENSORS],
    /// Reading, the model's prediction of it, and the difference, over the whole flight.
    pub(super) whole: [Table; SENSORS],
}

impl Recording {
    /// The recording of a comparison's traces.
    pub(super) fn of(traces: &Traces, comparison: &Comparison) -> Self {
        let estimate = |EstimateTrace { value_m, sigma_m }: &EstimateTrace| Table::of(&[value_m, sigma_m]);
        let against_model = |ModelTrace { measured_m, modelled_m, error_m }: &ModelTrace| {
            Table::of(&[measured_m, modelled_m, error_m])
        };
        let by_sensor = |table: &dyn Fn(usize) -> Table| Sensor::ALL.map(|sensor| table(sensor.index()));
        Self {
            launch_us: comparison.launch_s.map(|launch_s| (launch_s * 1e6).round() as u64),
            altitude: estimate(&traces.altitude),
            biases: by_sensor(&|k| estimate(&traces.biases[k])),
            reference_residual: Table::of(&[&traces.reference_residual_m]),
            captive_error: by_sensor(&|k| Table::of(&[&traces.captive_error_m[k]])),
            free_error: by_sensor(&|k| Table::of(&[&traces.free_error_m[k], &traces.moving_average_m[k]])),
            whole: by_sensor(&|k| against_model(&traces.against_model[k])),
        }
    }
}
