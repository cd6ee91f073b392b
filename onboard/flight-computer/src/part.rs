//! The parts of a tick.

use drivers::Device;

/// Number of parts.
pub const PARTS: usize = 10;

/// A part of a tick, for measuring its cost.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Part {
    /// The satellite receiver's driver.
    Receiver = 0,
    /// The barometer's driver.
    Barometer = 1,
    /// The inertial unit's driver.
    InertialUnit = 2,
    /// The umbilical: the launch discrete and the mother ship's altitude.
    Umbilical = 3,
    /// Links to other equipment of the vehicle.
    Vehicle = 4,
    /// The launch decision and the strapdown channel.
    Onboard = 5,
    /// The mission: estimator, latch, monitors.
    Mission = 6,
    /// Passing the tick's results to the telemetry.
    Telemetry = 7,
    /// Keeping the mark for a restart.
    Mark = 8,
    /// Making and queueing the telemetry's messages. A task below the tick does this, so it is not part of
    /// the tick's cost.
    Messages = 9,
}

impl Part {
    /// Every part, in the order of [`Self::index`].
    pub const ALL: [Self; PARTS] = [
        Self::Receiver,
        Self::Barometer,
        Self::InertialUnit,
        Self::Umbilical,
        Self::Vehicle,
        Self::Onboard,
        Self::Mission,
        Self::Telemetry,
        Self::Mark,
        Self::Messages,
    ];

    /// Its place among the parts.
    #[must_use]
    pub const fn index(self) -> usize {
        self as usize
    }

    /// The name used in reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Receiver => "receiver",
            Self::Barometer => "barometer",
            Self::InertialUnit => "inertial_unit",
            Self::Umbilical => "umbilical",
            Self::Vehicle => "vehicle",
            Self::Onboard => "onboard",
            Self::Mission => "mission",
            Self::Telemetry => "telemetry",
            Self::Mark => "mark",
            Self::Messages => "messages_below",
        }
    }
}

impl From<Device> for Part {
    fn from(device: Device) -> Self {
        match device {
            Device::Receiver => Self::Receiver,
            Device::Barometer => Self::Barometer,
            Device::InertialUnit => Self::InertialUnit,
            Device::Launch | Device::Master => Self::Umbilical,
            Device::Slave | Device::Vehicle => Self::Vehicle,
        }
    }
}
