//! A sensor that this board does not have.

use drivers::{
    AltitudeLink, Barometer, BarometerSample, InertialUnit, LaunchDiscrete, SatelliteReceiver, SensorError,
    VehicleLink, VehicleState,
};
use kf_core::input::{GpsFix, ImuSample};

/// A sensor that is not there.
pub struct Absent;

impl SatelliteReceiver for Absent {
    fn poll(&mut self, _now_us: u64) -> Result<Option<GpsFix>, SensorError> {
        Err(SensorError::NoDevice)
    }
}

impl Barometer for Absent {
    fn poll(&mut self, _now_us: u64) -> Result<Option<BarometerSample>, SensorError> {
        Err(SensorError::NoDevice)
    }
}

impl InertialUnit for Absent {
    fn poll(&mut self, _now_us: u64) -> Result<Option<ImuSample>, SensorError> {
        Err(SensorError::NoDevice)
    }
}

impl AltitudeLink for Absent {
    fn poll(&mut self, _now_us: u64) -> Result<Option<f32>, SensorError> {
        Err(SensorError::NoDevice)
    }
}

impl VehicleLink for Absent {
    fn poll(&mut self, _now_us: u64) -> Result<Option<VehicleState>, SensorError> {
        Err(SensorError::NoDevice)
    }
}

impl LaunchDiscrete for Absent {
    fn poll(&mut self, _now_us: u64) -> Result<bool, SensorError> {
        Err(SensorError::NoDevice)
    }
}
