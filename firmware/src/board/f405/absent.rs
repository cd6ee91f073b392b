//! A link that this board does not have: it never delivers anything, which is not a fault.

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
