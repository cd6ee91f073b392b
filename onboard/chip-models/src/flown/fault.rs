//! Faults of the board's chips on demand, as stored in a flight record.

use flight_record::{Kind, Payload};
use serde::{Deserialize, Serialize};

use crate::bus::WireFault;
use crate::disturbance::{Disturbance, Flip, Offset};
use crate::line::LineFaults;
use crate::vibration::Vibration;

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
    /// The umbilical's break-wire.
    Wire,
}

/// What a chip measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Quantity {
    /// Barometer: static pressure, Pa; bits are those of D1.
    Pressure,
    /// Barometer: its temperature, degrees Celsius; bits are those of D2.
    Temperature,
    /// Inertial unit: specific force along this axis (0 to 2: forward, right, down), m/s^2; 16 bits.
    Force(u8),
    /// Inertial unit: angular rate about this axis, rad/s; 16 bits.
    Rate(u8),
    /// Receiver: both its altitudes, metres; bits are those of the message's millimetres.
    Altitude,
    /// Receiver: its velocity along this axis (0 to 2: north, east, down), m/s; has no bits to flip.
    Velocity(u8),
}

impl Quantity {
    /// The chip that measures it, and its index among that chip's quantities.
    const fn channel(self) -> (Chip, usize) {
        match self {
            Self::Pressure => (Chip::Baro, 0),
            Self::Temperature => (Chip::Baro, 1),
            Self::Force(axis) => (Chip::Imu, axis as usize),
            Self::Rate(axis) => (Chip::Imu, 3 + axis as usize),
            Self::Altitude => (Chip::Gps, 0),
            Self::Velocity(axis) => (Chip::Gps, 1 + axis as usize),
        }
    }

    /// Whether that chip measures it.
    const fn is_of(self, chip: Chip) -> bool {
        let has_axis = match self {
            Self::Force(axis) | Self::Rate(axis) | Self::Velocity(axis) => axis < 3,
            _ => true,
        };
        has_axis
            && matches!(
                (chip, self.channel().0),
                (Chip::Baro, Chip::Baro) | (Chip::Imu, Chip::Imu) | (Chip::Gps, Chip::Gps)
            )
    }
}

/// A fault of a chip.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Fault {
    /// No fault from now on; permanent changes from an earlier fault stay in the chip.
    None,
    /// SPI: the chip's data line reads 0.
    StuckLow,
    /// SPI: the chip's data line reads 1.
    StuckHigh,
    /// SPI: the peripheral reports an error for every transaction.
    BusError,
    /// These bits are flipped once, in the byte that the chip sends after `after_bytes` more.
    FlipBits {
        /// Bytes before it.
        after_bytes: u32,
        /// The bits.
        mask: u8,
    },
    /// The chip's supply dips, once.
    Reset,
    /// Barometer: conversions exceed the datasheet's longest time, microseconds.
    Slow {
        /// By this much.
        by_us: u32,
    },
    /// Barometer, inertial unit: it stops making samples.
    Stalled,
    /// UART: nothing passes.
    Unplugged,
    /// UART: the next bytes that the device sends are lost, once.
    LoseBytes {
        /// Number of bytes.
        count: u32,
    },
    /// Receiver: it refuses every configuration message.
    Refuses,
    /// Receiver: it acknowledges nothing. Mother ship: it sends nothing.
    Silent,
    /// SPI: whatever the chip sends arrives as noise. UART: whatever is sent, the line carries bytes of noise
    /// at its full rate; a floating line does so after separation as well.
    Garbage {
        /// Seed of the bytes.
        seed: u32,
    },
    /// Umbilical: another MAVLink system on the line sends ALTITUDE ten times a second, in addition to the
    /// mother ship; until separation.
    Stranger {
        /// Its MAVLink system.
        system: u8,
        /// Its component.
        component: u8,
        /// The altitude that it sends, metres.
        altitude_m: i32,
    },
    /// Umbilical: the mother ship's altitude is wrong by this much, metres.
    Lies {
        /// Too high by this much.
        by_m: i32,
    },
    /// Umbilical: the mother ship sends NaN.
    NotANumber,
    /// Umbilical: the mother ship sends the same altitude for ever.
    Holds,
    /// Umbilical: the whole cable is torn: the wire reads open, and nothing passes on the line.
    Torn,
    /// Wire: it reads open whatever its state: broken.
    Open,
    /// Wire: it reads closed whatever its state: shorted.
    Shorted,
    /// Wire: it cannot be read.
    Unreadable,
    /// Wire: it opens and closes at random, whatever its state. Each state lasts between zero and twice its
    /// mean; if shorter than a tick, the tick sees one of them.
    Bounces {
        /// Mean time open, microseconds.
        open_us: u32,
        /// Mean time closed, microseconds.
        closed_us: u32,
        /// Seed of the random sequence.
        seed: u32,
    },
    /// Inertial unit: bits of one of its registers are flipped once, until the register is written. Receiver:
    /// one of its settings is changed once, until it is configured: 0 whether it sends solutions, 1 whether
    /// it sends NMEA, 2 its rate, back to once a second.
    FlipRegister {
        /// Address of the register in bank 0, or number of the setting.
        address: u8,
        /// The bits.
        mask: u8,
    },
    /// Barometer: bits of its calibration memory read wrong.
    FlipProm {
        /// Index of the byte, of 16.
        byte: u8,
        /// The bits.
        mask: u8,
    },
    /// Bits of the next results are flipped in the chip, once.
    FlipData {
        /// The quantity.
        quantity: Quantity,
        /// The bits: 24 for the barometer, 16 for the inertial unit, 32 for the receiver.
        mask: u32,
        /// Number of results.
        results: u32,
    },
    /// The next results are wrong by this much, once, within the chip's range.
    Spike {
        /// The quantity.
        quantity: Quantity,
        /// Size, thousandths of its unit.
        by_milli: i32,
        /// Number of results.
        results: u32,
    },
    /// Results are wrong by this much, within the chip's range: an error far beyond it saturates the chip.
    Offset {
        /// The quantity.
        quantity: Quantity,
        /// Size, thousandths of its unit.
        by_milli: i32,
    },
    /// The last result is repeated and reported as new; the receiver's with the present time.
    Frozen,
    /// Receiver: the last solution is repeated with its original time.
    Held,
    /// Receiver: it has no fix, and reports so.
    NoFix,
    /// Receiver: after a cold start its altitude is wrong at first, and the error decays.
    ColdStart {
        /// The initial error, mm.
        error_mm: i32,
        /// Time constant of its decay, s.
        decay_s: u16,
        /// Whether its accuracy estimate includes the error.
        is_honest: bool,
    },
    /// Barometer: the next conversions never end, once.
    LoseConversions {
        /// Number of conversions.
        count: u32,
    },
    /// Inertial unit: vibration of the airframe.
    Vibration {
        /// The quantity that vibrates.
        quantity: Quantity,
        /// Frequency, mHz.
        frequency_mhz: u32,
        /// Amplitude, thousandths of the quantity's unit.
        amplitude_milli: u32,
    },
    /// Receiver: from now on it is one of generation 8, just switched on, on a line of this speed. This is
    /// not a fault but a possible configuration of a board; it stays.
    Generation8 {
        /// Speed of its line, baud.
        baud: u32,
    },
}

impl Fault {
    /// Its effect on the wires of an SPI bus, if it has one.
    pub(super) const fn of_wires(self) -> Option<WireFault> {
        match self {
            Self::StuckLow => Some(WireFault::StuckLow),
            Self::StuckHigh => Some(WireFault::StuckHigh),
            Self::BusError => Some(WireFault::BusError),
            Self::FlipBits { after_bytes, mask } => Some(WireFault::FlipBits { after_bytes, mask }),
            Self::Garbage { seed } => Some(WireFault::Garbage { noise: seed }),
            _ => None,
        }
    }

    /// Its effect on the lines of a UART.
    pub(super) fn of_line(self) -> LineFaults {
        let mut faults = LineFaults::default();
        match self {
            Self::Unplugged | Self::Torn => faults.unplugged = true,
            Self::LoseBytes { count } => faults.lose_bytes = count,
            Self::FlipBits { after_bytes, mask } => faults.flip_bits = Some((after_bytes, mask)),
            Self::Garbage { seed } => faults.noise = Some(seed),
            _ => {}
        }
        faults
    }

    /// Its effect on a chip's results.
    pub(super) fn of_results(self) -> Disturbance {
        let mut disturbance = Disturbance::NONE;
        let offset = |quantity: Quantity, by_milli: i32, results| {
            Some(Offset { channel: quantity.channel().1, by: by_milli as f32 * 1e-3, results })
        };
        match self {
            Self::Frozen => disturbance.frozen = true,
            Self::Spike { quantity, by_milli, results } => {
                disturbance.offset = offset(quantity, by_milli, results);
            }
            Self::Offset { quantity, by_milli } => {
                disturbance.offset = offset(quantity, by_milli, u32::MAX);
            }
            Self::FlipData { quantity, mask, results } => {
                disturbance.flip = Some(Flip { channel: quantity.channel().1, mask, results });
            }
            _ => {}
        }
        disturbance
    }

    /// The vibration of the inertial unit, if it is one.
    pub(super) const fn of_airframe(self) -> Option<Vibration> {
        match self {
            Self::Vibration { quantity, frequency_mhz, amplitude_milli } => Some(Vibration {
                channel: quantity.channel().1,
                frequency_mhz,
                amplitude: amplitude_milli as f32 * 1e-3,
            }),
            _ => None,
        }
    }

    /// Whether it is over as soon as it has happened, so that it needs no end.
    #[must_use]
    pub const fn is_once(self) -> bool {
        matches!(
            self,
            Self::Reset
                | Self::FlipBits { .. }
                | Self::LoseBytes { .. }
                | Self::FlipRegister { .. }
                | Self::FlipData { .. }
                | Self::Spike { .. }
                | Self::LoseConversions { .. }
                | Self::Generation8 { .. }
        )
    }
}

impl Chip {
    /// Whether this chip can have this fault.
    #[must_use]
    pub const fn can(self, fault: Fault) -> bool {
        match fault {
            Fault::None => true,
            Fault::FlipBits { .. } | Fault::Garbage { .. } => !matches!(self, Self::Wire),
            Fault::StuckLow | Fault::StuckHigh | Fault::BusError | Fault::Stalled => {
                matches!(self, Self::Baro | Self::Imu)
            }
            Fault::Slow { .. } | Fault::LoseConversions { .. } => matches!(self, Self::Baro),
            Fault::FlipProm { byte, .. } => matches!(self, Self::Baro) && byte < 16,
            Fault::FlipRegister { address, .. } => match self {
                Self::Imu => address < 128,
                Self::Gps => address < 3,
                Self::Baro | Self::Umbilical | Self::Wire => false,
            },
            Fault::Reset | Fault::Frozen => matches!(self, Self::Baro | Self::Imu | Self::Gps),
            Fault::Unplugged | Fault::LoseBytes { .. } => matches!(self, Self::Gps | Self::Umbilical),
            Fault::Silent => matches!(self, Self::Gps | Self::Umbilical),
            Fault::Stranger { .. } | Fault::Lies { .. } | Fault::NotANumber | Fault::Holds | Fault::Torn => {
                matches!(self, Self::Umbilical)
            }
            Fault::Open | Fault::Shorted | Fault::Unreadable | Fault::Bounces { .. } => {
                matches!(self, Self::Wire)
            }
            Fault::Refuses
            | Fault::Held
            | Fault::NoFix
            | Fault::ColdStart { .. }
            | Fault::Generation8 { .. } => matches!(self, Self::Gps),
            Fault::FlipData { quantity: Quantity::Velocity(_), .. } => false,
            Fault::FlipData { quantity, .. }
            | Fault::Spike { quantity, .. }
            | Fault::Offset { quantity, .. } => quantity.is_of(self),
            Fault::Vibration { quantity, .. } => matches!(self, Self::Imu) && quantity.is_of(self),
        }
    }
}

/// A fault that begins at the tick after it in the record.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ChipFault {
    /// The chip.
    pub chip: Chip,
    /// The fault.
    pub fault: Fault,
}

impl Payload for ChipFault {
    const KIND: Kind = Kind::ChipFault;
}
