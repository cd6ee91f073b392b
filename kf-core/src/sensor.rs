//! The altitude sensors that are calibrated against the reference.

use serde::{Deserialize, Serialize};

/// Number of sensors that carry a bias state.
pub const SENSORS: usize = 3;

/// A sensor with a bias state, in the order of the paper's eq. 9.
///
/// The reference (`gps`) is not one of them: its own error is what every bias is relative to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[repr(u8)]
pub enum Sensor {
    /// The mother ship's inertial altitude: available in captive flight only.
    ImuMaster = 0,
    /// The UAV's own inertial altitude.
    ImuSlave = 1,
    /// The UAV's barometric altimeter.
    Baro = 2,
}

impl Sensor {
    /// Every sensor, in the order of its bias state.
    pub const ALL: [Self; SENSORS] = [Self::ImuMaster, Self::ImuSlave, Self::Baro];

    /// Position of the sensor's bias among the bias states.
    #[must_use]
    pub const fn index(self) -> usize {
        self as usize
    }

    /// The name used in files, on the command line and in reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::ImuMaster => "imu_master",
            Self::ImuSlave => "imu_slave",
            Self::Baro => "baro",
        }
    }

    /// Whether the sensor leaves with the UAV at launch, so that it can be monitored in free flight.
    #[must_use]
    pub const fn flies_free(self) -> bool {
        !matches!(self, Self::ImuMaster)
    }
}
