//! An SPI bus with one chip on it, and the possible faults of the wires.

use core::convert::Infallible;

use embedded_hal::spi::{ErrorKind, ErrorType, Operation, SpiDevice};

use crate::line::noise_after;

/// A chip as seen by its bus: one byte out for each byte in, between two edges of chip select.
pub trait SpiChip {
    /// Chip select went low.
    fn select(&mut self, now_us: u64);
    /// One byte each way.
    fn exchange(&mut self, now_us: u64, mosi: u8) -> u8;
    /// Chip select went high.
    fn deselect(&mut self, now_us: u64);
    /// Power returned after a dip: the chip loses its configuration.
    fn power_on_reset(&mut self, now_us: u64);
}

/// A fault of the wires.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WireFault {
    /// MISO reads 0 whatever the chip sends. The chip itself still receives.
    StuckLow,
    /// MISO reads 1.
    StuckHigh,
    /// The peripheral reports an error for every transaction.
    BusError,
    /// These bits are flipped once, in the byte that the chip sends after `after_bytes` more.
    FlipBits {
        /// Bytes before it.
        after_bytes: u32,
        /// The bits.
        mask: u8,
    },
    /// Whatever the chip sends arrives as noise.
    Garbage {
        /// State of its random numbers.
        noise: u32,
    },
}

/// Traffic on a bus.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Traffic {
    /// Bytes, counted once although they go both ways.
    pub bytes: u64,
    /// Pairs of edges of chip select.
    pub transactions: u64,
}

/// A chip on its own bus: the `SpiDevice` for a driver.
#[derive(Clone, Debug)]
pub struct ChipOnBus<Chip> {
    /// The chip.
    pub chip: Chip,
    /// Present fault of the wires.
    pub fault: Option<WireFault>,
    now_us: u64,
    traffic: Traffic,
}

impl<Chip: SpiChip> ChipOnBus<Chip> {
    /// A chip that has just been powered, on healthy wires, at time 0.
    pub fn new(mut chip: Chip) -> Self {
        chip.power_on_reset(0);
        Self { chip, fault: None, now_us: 0, traffic: Traffic::default() }
    }

    /// Sets the time of the following transactions, microseconds: the bus has no clock of its own.
    pub const fn set_time(&mut self, now_us: u64) {
        self.now_us = now_us;
    }

    /// Simulates a dip of the supply now.
    pub fn power_dip(&mut self) {
        self.chip.power_on_reset(self.now_us);
    }

    /// Traffic on the bus so far.
    pub const fn traffic(&self) -> Traffic {
        self.traffic
    }

    fn exchange(&mut self, mosi: u8) -> u8 {
        let sent = self.chip.exchange(self.now_us, mosi);
        self.traffic.bytes += 1;
        match &mut self.fault {
            Some(WireFault::StuckLow) => 0x00,
            Some(WireFault::StuckHigh) => 0xFF,
            Some(WireFault::FlipBits { after_bytes: 0, mask }) => {
                let flipped = sent ^ *mask;
                self.fault = None;
                flipped
            }
            Some(WireFault::FlipBits { after_bytes, .. }) => {
                *after_bytes -= 1;
                sent
            }
            Some(WireFault::Garbage { noise }) => {
                *noise = noise_after(*noise);
                (*noise >> 24) as u8
            }
            Some(WireFault::BusError) | None => sent,
        }
    }
}

/// The peripheral's error; its kind is [`ErrorKind::Other`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BusError;

impl embedded_hal::spi::Error for BusError {
    fn kind(&self) -> ErrorKind {
        ErrorKind::Other
    }
}

impl From<Infallible> for BusError {
    fn from(never: Infallible) -> Self {
        match never {}
    }
}

impl<Chip> ErrorType for ChipOnBus<Chip> {
    type Error = BusError;
}

impl<Chip: SpiChip> SpiDevice for ChipOnBus<Chip> {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), BusError> {
        if self.fault == Some(WireFault::BusError) {
            return Err(BusError);
        }
        self.traffic.transactions += 1;
        self.chip.select(self.now_us);
        for operation in operations {
            match operation {
                Operation::Read(answer) => answer.iter_mut().for_each(|byte| *byte = self.exchange(0)),
                Operation::Write(command) => {
                    for &byte in *command {
                        self.exchange(byte);
                    }
                }
                Operation::Transfer(answer, command) => {
                    for index in 0..answer.len().max(command.len()) {
                        let byte = self.exchange(command.get(index).copied().unwrap_or(0));
                        if let Some(slot) = answer.get_mut(index) {
                            *slot = byte;
                        }
                    }
                }
                Operation::TransferInPlace(bytes) => {
                    bytes.iter_mut().for_each(|byte| *byte = self.exchange(*byte))
                }
                Operation::DelayNs(nanoseconds) => self.now_us += u64::from(nanoseconds.div_ceil(1_000)),
            }
        }
        self.chip.deselect(self.now_us);
        Ok(())
    }
}
