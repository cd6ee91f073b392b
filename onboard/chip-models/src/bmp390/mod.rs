//! BMP390 barometer (section numbers are those of Bosch BST-BMP390-DS002, revision 1.7): registers, normal
//! mode and the data path. FIFO, interrupts and forced mode are not modelled.

mod trimming;

pub use trimming::Trimming;

use crate::bus::SpiChip;
use crate::source::{Air, Source};

const ERR_REG: u8 = 0x02;
const STATUS: u8 = 0x03;
const DATA: u8 = 0x04;
const EVENT: u8 = 0x10;
const PWR_CTRL: u8 = 0x1B;
const OSR: u8 = 0x1C;
const ODR: u8 = 0x1D;
const NVM: u8 = 0x30;
const CMD: u8 = 0x7E;

/// ERR_REG: rate and oversampling are incompatible (4.3.3).
const CONFIGURATION_ERROR: u8 = 0x04;
/// STATUS: ready for a command; new pressure; new temperature (4.3.4).
const COMMAND_READY: u8 = 0x10;
const DATA_READY: u8 = 0x60;

/// Start time after power-on or a reset, microseconds.
const START_US: u64 = 2_000;

/// The chip.
#[derive(Clone, Debug)]
pub struct Bmp390Model<Surroundings> {
    /// The surrounding air, sampled in the middle of each conversion.
    pub air: Surroundings,
    /// Time by which each conversion exceeds the datasheet's, microseconds.
    pub slower_by_us: u64,
    trimming: Trimming,
    registers: [u8; 128],
    ready_us: u64,
    /// When the running conversion ends.
    done_us: Option<u64>,
    address: u8,
    reading: bool,
    position: usize,
}

impl<Surroundings: Source<Air>> Bmp390Model<Surroundings> {
    /// A chip without power.
    pub const fn new(trimming: Trimming, air: Surroundings) -> Self {
        Self {
            air,
            slower_by_us: 0,
            trimming,
            registers: [0; 128],
            ready_us: 0,
            done_us: None,
            address: 0,
            reading: false,
            position: 0,
        }
    }

    /// A register, to inspect or damage. An address has 7 bits.
    pub const fn register_mut(&mut self, address: u8) -> &mut u8 {
        &mut self.registers[(address & 0x7F) as usize]
    }

    /// The trimming coefficients.
    pub const fn trimming(&self) -> &Trimming {
        &self.trimming
    }

    fn register(&self, address: u8) -> u8 {
        self.registers[usize::from(address & 0x7F)]
    }

    /// Duration of a conversion of both quantities, microseconds (section 3.9.2).
    fn conversion_us(&self) -> u64 {
        let osr = self.register(OSR);
        let oversampled = |field: u8| 2_020u64 << field.min(5);
        234 + 392 + oversampled(osr & 7) + 163 + oversampled((osr >> 3) & 7) + self.slower_by_us
    }

    /// Time between the starts of two conversions in normal mode: 5 ms times a power of two (section 4.3.19).
    fn period_us(&self) -> u64 {
        (5_000u64 << self.register(ODR).min(17)).max(self.conversion_us())
    }

    fn convert_until(&mut self, now_us: u64) {
        while let Some(done_us) = self.done_us
            && done_us <= now_us
        {
            let air = self.air.at(done_us.saturating_sub(self.conversion_us() / 2));
            let (pressure, temperature) = self.trimming.raw(air);
            for (address, raw) in [(DATA, pressure), (DATA + 3, temperature)] {
                for (offset, byte) in (0u8..3).zip(raw.to_le_bytes()) {
                    *self.register_mut(address + offset) = byte;
                }
            }
            *self.register_mut(STATUS) |= DATA_READY;
            self.done_us = Some(done_us + self.period_us());
        }
    }

    fn write(&mut self, now_us: u64, address: u8, value: u8) {
        match address {
            CMD if value == 0xB6 => self.power_on_reset(now_us),
            PWR_CTRL => {
                *self.register_mut(address) = value & 0x33;
                let fits = self.conversion_us() <= 5_000u64 << self.register(ODR).min(17);
                self.done_us = None;
                if value & 0x33 == 0x33 && fits {
                    self.done_us = Some(now_us + self.conversion_us());
                } else if value & 0x33 == 0x33 {
                    *self.register_mut(ERR_REG) |= CONFIGURATION_ERROR;
                }
            }
            OSR => *self.register_mut(address) = value & 0x3F,
            ODR => *self.register_mut(address) = value & 0x1F,
            0x1F => *self.register_mut(address) = value & 0x0E,
            _ => {}
        }
    }

    fn read(&mut self, address: u8) -> u8 {
        let value = self.register(address);
        match address {
            ERR_REG | EVENT => *self.register_mut(address) = 0,
            DATA => *self.register_mut(STATUS) &= !0x20,
            0x07 => *self.register_mut(STATUS) &= !0x40,
            _ => {}
        }
        value
    }
}

impl<Surroundings: Source<Air>> SpiChip for Bmp390Model<Surroundings> {
    fn select(&mut self, now_us: u64) {
        self.position = 0;
        self.convert_until(now_us);
    }

    fn exchange(&mut self, now_us: u64, mosi: u8) -> u8 {
        let position = self.position;
        self.position += 1;
        if now_us < self.ready_us {
            return 0;
        }
        if position == 0 {
            self.reading = mosi & 0x80 != 0;
            self.address = mosi & 0x7F;
            return 0;
        }
        if self.reading {
            // Section 5.3.2: one dummy byte, then the registers.
            if position == 1 {
                return 0;
            }
            let value = self.read(self.address);
            self.address = (self.address + 1) & 0x7F;
            return value;
        }
        // A write does not increment the address: address and value alternate.
        if position % 2 == 1 {
            self.write(now_us, self.address, mosi);
        } else {
            self.address = mosi & 0x7F;
        }
        0
    }

    fn deselect(&mut self, _now_us: u64) {}

    fn power_on_reset(&mut self, now_us: u64) {
        self.registers = [0; 128];
        for (address, value) in [
            (0x00, 0x60),
            (0x01, 0x01),
            (STATUS, COMMAND_READY),
            (DATA + 2, 0x80),
            (DATA + 5, 0x80),
            (EVENT, 0x01),
            (0x15, 0x01),
            (0x17, 0x02),
            (OSR, 0x02),
        ] {
            *self.register_mut(address) = value;
        }
        for (address, value) in (NVM..).zip(self.trimming.registers()) {
            *self.register_mut(address) = value;
        }
        self.ready_us = now_us + START_US;
        self.done_us = None;
    }
}
