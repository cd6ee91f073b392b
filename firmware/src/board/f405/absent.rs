//! A link that this board does not have: nothing ever comes of it, which is no fault.

use drivers::{AltitudeLink, SensorError, VehicleLink, VehicleState};

/// The link.
pub struct Absent;

impl AltitudeLink for Absent {
    fn poll(&mut self, _now_us: u64) -> Result<Option<f32>, SensorError> {
        Ok(None)
    }
}

impl VehicleLink for Absent {
    fn poll(&mut self, _now_us: u64) -> Result<Option<VehicleState>, SensorError> {
        Ok(None)
    }
}
