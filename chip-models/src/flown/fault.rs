//! Faults of the board's chips on demand, as a flight record carries them.

use flight_record::{Kind, Payload};
use serde::{Deserialize, Serialize};

use crate::bus::WireFault;

/// A chip of the board.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Chip {
    /// The MS5611.
    Baro,
    /// The ICM-42688-P.
    Imu,
    /// The u-blox receiver and its line.
    Gps,
    /// The mother ship's end of the umbilical and its line.
    Umbilical,
}

/// What goes wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Fault {
    /// Nothing, from now on: what a fault before has changed for good in the chip stays as it is.
    None,
    /// SPI: the chip's data line reads 0.
    StuckLow,
    /// SPI: it reads 1.
    StuckHigh,
    /// SPI: the peripheral reports an error for every transaction.
    BusError,
    /// These bits of one byte that the chip sends, after so many more, are flipped, once.
    FlipBits {
        /// Bytes until then.
        after_bytes: u32,
        /// The bits.
        mask: u8,
    },
    /// Its power dips, once.
    Reset,
    /// Barometer: conversions take so much longer than the datasheet's longest, microseconds.
    Slow {
        /// How much.
        by_us: u32,
    },
    /// Inertial unit: it makes no samples any more.
    Stalled,
    /// UART: nothing passes.
    Unplugged,
    /// UART: the next bytes are lost, once.
    LoseBytes {
        /// How many.
        count: u32,
    },
    /// Receiver: it refuses every configuration message.
    Refuses,
    /// Receiver: it acknowledges nothing.
    Silent,
}

impl Fault {
    /// What it does to the wires of an SPI bus, if that is what it is.
    pub(super) const fn of_wires(self) -> Option<WireFault> {
        match self {
            Self::StuckLow => Some(WireFault::StuckLow),
            Self::StuckHigh => Some(WireFault::StuckHigh),
            Self::BusError => Some(WireFault::BusError),
            Self::FlipBits { after_bytes, mask } => Some(WireFault::FlipBits { after_bytes, mask }),
            _ => None,
        }
    }
}

impl Chip {
    /// Whether that can go wrong with this chip.
    #[must_use]
    pub const fn can(self, fault: Fault) -> bool {
        match fault {
            Fault::None | Fault::FlipBits { .. } => true,
            Fault::StuckLow | Fault::StuckHigh | Fault::BusError => matches!(self, Self::Baro | Self::Imu),
            Fault::Slow { .. } => matches!(self, Self::Baro),
            Fault::Stalled => matches!(self, Self::Imu),
            Fault::Reset => !matches!(self, Self::Umbilical),
            Fault::Unplugged | Fault::LoseBytes { .. } => matches!(self, Self::Gps | Self::Umbilical),
            Fault::Refuses | Fault::Silent => matches!(self, Self::Gps),
        }
    }
}

/// A fault that begins, at the tick that follows it in the record.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ChipFault {
    /// Of which chip.
    pub chip: Chip,
    /// What.
    pub fault: Fault,
}

impl Payload for ChipFault {
    const KIND: Kind = Kind::ChipFault;
}
