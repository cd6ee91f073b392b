//! ICM-42688-P inertial unit on SPI (TDK InvenSense DS-000347, revision 1.6; section numbers refer to it).
//!
//! # Timing
//! One poll is two bursts. The first reads temperature, specific force, rate and the interrupt status; the
//! second the chip's configuration, so that no sample made with a wrong one is used ([`MAX_POLL_BYTES`]). The
//! chip samples at 1 kHz, so a 200 Hz tick always finds a new sample; the flag for it is read in the same
//! burst. The chip's own filter keeps vibration out (`registers.rs` has the numbers): averaging its FIFO
//! would take 80 bytes more a tick.
//!
//! # Errors
//! A configuration that reads back wrong is read again: a bit that flipped on the way is only counted. If it
//! is wrong twice, it is wrong in the chip: the differing registers are written again, which costs that
//! poll's sample (45 ms, if the sensors were switched off). The driver resets and configures the chip again
//! when the chip reports a reset, when it makes no samples, and after [`GIVE_UP_AFTER`] polls in a row
//! without a right answer. That takes at most [`BACK_OFF_US`] and 20 polls. [`SensorError::Saturated`] costs
//! only its sample. The chip sends no check of its data: a bit of a sample that flips on the way is not
//! detected.

mod mounting;
mod registers;

pub use mounting::{AccelRange, ChipAxis, GyroRange, Mounting};

use embedded_hal::spi::SpiDevice;
use kf_core::guard::Guard;
use kf_core::input::ImuSample;
use registers::{CONFIGURED, READ};

use crate::bus;
use crate::error::SensorError;
use crate::health::Health;
use crate::sensor::InertialUnit;

/// Largest number of bytes that one poll moves: a sample, the configuration twice, and a write of each of its
/// registers.
pub const MAX_POLL_BYTES: usize = 1 + BURST + 2 * (1 + CONFIGURED) + 2 * CONFIGURED;
/// Polls in a row without a right answer after which the chip is reset: 200 ms. A reset costs 120 ms more,
/// and repairs no wire.
pub const GIVE_UP_AFTER: u8 = 40;
/// Wait after an error before the chip is reset, microseconds.
pub const BACK_OFF_US: u64 = 10_000;
/// Time without a sample after which the chip is stale, microseconds: 20 of its periods.
pub const STALE_AFTER_US: u64 = 20_000;

/// Duration of a software reset, microseconds (14.1: "1 ms").
const RESET_US: u64 = 1_000;
/// Time until the gyro has started, microseconds (14.36: "at least 45 ms").
const START_US: u64 = 45_000;
/// Bytes from the temperature to the interrupt status: 2 + 6 + 6 of data, 2 of timestamp, 1 of status.
const BURST: usize = 17;
/// Counts per degree, and the temperature at 0 counts (4.13).
const COUNTS_PER_DEGREE: f32 = 132.48;
const DEGREES_AT_ZERO: f32 = 25.0;

/// Ranges, and orientation of the chip in the vehicle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Config {
    /// Full scale of the accelerometer.
    pub accel_range: AccelRange,
    /// Full scale of the gyro.
    pub gyro_range: GyroRange,
    /// Orientation of the chip's axes in the body.
    pub mounting: Mounting,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Phase {
    BackOff {
        until_us: u64,
    },
    Reset,
    Resetting {
        until_us: u64,
    },
    Configure {
        next: u8,
    },
    Verify,
    Starting {
        until_us: u64,
    },
    /// `failures`: polls since the last right answer.
    Running {
        last_sample_us: u64,
        failures: u8,
    },
}

/// The driver.
#[derive(Clone, Debug)]
pub struct Icm42688p<Spi> {
    spi: Spi,
    config: Config,
    phase: Phase,
    temperature_c: Option<f32>,
    health: Health,
}

impl<Spi: SpiDevice> Icm42688p<Spi> {
    /// A driver that has not yet spoken to its chip. SPI mode 0 or 3, 24 MHz at most.
    pub const fn new(spi: Spi, config: Config) -> Self {
        Self { spi, config, phase: Phase::Reset, temperature_c: None, health: Health::new() }
    }

    /// Its counts.
    pub const fn health(&self) -> Health {
        self.health
    }

    /// Temperature of the chip with the last sample, degrees Celsius.
    pub const fn temperature_c(&self) -> Option<f32> {
        self.temperature_c
    }

    /// The bus, for a test or a board that accesses the chip's model.
    pub const fn bus_mut(&mut self) -> &mut Spi {
        &mut self.spi
    }

    fn write(&mut self, register: u8, value: u8) -> Result<(), SensorError> {
        bus::write(&mut self.spi, &[register, value])
    }

    /// Reads consecutive registers.
    ///
    /// # Errors
    /// [`SensorError::Bus`]; [`SensorError::StuckBus`] when the line did not move although more than one
    /// register was read.
    fn read<const COUNT: usize>(&mut self, first: u8) -> Result<[u8; COUNT], SensorError> {
        let values = bus::read::<COUNT>(&mut self.spi, &[READ | first])?;
        if COUNT > 1 && bus::is_stuck(&values) { Err(SensorError::StuckBus) } else { Ok(values) }
    }

    fn step(&mut self, now_us: u64) -> Result<Option<ImuSample>, SensorError> {
        match self.phase {
            Phase::BackOff { until_us } | Phase::Resetting { until_us } | Phase::Starting { until_us }
                if now_us < until_us => {}
            Phase::BackOff { .. } | Phase::Reset => {
                self.health.initialised();
                self.write(registers::REG_BANK_SEL, 0)?;
                self.write(registers::DEVICE_CONFIG, registers::SOFT_RESET)?;
                self.phase = Phase::Resetting { until_us: now_us.saturating_add(RESET_US) };
            }
            Phase::Resetting { .. } => {
                self.identify()?;
                self.phase = Phase::Configure { next: 0 };
            }
            Phase::Configure { next } => {
                self.phase = match registers::ORDER.get(usize::from(next)) {
                    Some(&place) => {
                        self.configure(usize::from(place))?;
                        Phase::Configure { next: next + 1 }
                    }
                    None => Phase::Verify,
                };
            }
            Phase::Verify => {
                if self.wrong_configuration()?.is_some() {
                    return Err(SensorError::ConfigurationLost);
                }
                self.phase = Phase::Starting { until_us: now_us.saturating_add(START_US) };
            }
            Phase::Starting { .. } => {
                self.phase = Phase::Running { last_sample_us: now_us, failures: 0 };
            }
            Phase::Running { last_sample_us, .. } => return self.sample(last_sample_us, now_us),
        }
        Ok(None)
    }

    /// Checks the identity. Then reads the status, which clears the flag of the reset just made.
    fn identify(&mut self) -> Result<(), SensorError> {
        match self.read::<1>(registers::WHO_AM_I)? {
            [registers::IDENTITY] => {}
            [0x00 | 0xFF] => return Err(SensorError::StuckBus),
            _ => return Err(SensorError::WrongDevice),
        }
        // If the reset did not happen, registers that this driver does not write keep their old values.
        match self.read::<1>(registers::INT_STATUS)? {
            [status] if status & registers::RESET_DONE != 0 => Ok(()),
            _ => Err(SensorError::Timeout),
        }
    }

    /// The phase after an error.
    fn after(&mut self, error: SensorError, now_us: u64) -> Phase {
        match (self.phase, error) {
            // No answer, or a wrong one: most likely not the chip's fault, unless it has another bank
            // selected, which is empty.
            (
                Phase::Running { last_sample_us, failures },
                SensorError::Bus | SensorError::StuckBus | SensorError::ConfigurationLost,
            ) if failures < GIVE_UP_AFTER && Guard::ReadBackAgain.stands() => {
                if error == SensorError::StuckBus {
                    let _ = self.write(registers::REG_BANK_SEL, 0);
                }
                Phase::Running { last_sample_us, failures: failures + 1 }
            }
            // Sensors that were written again have to start.
            (starting @ Phase::Starting { .. }, _) => starting,
            // The chip is there and needs its configuration now.
            (_, SensorError::ConfigurationLost) => Phase::Reset,
            _ => Phase::BackOff { until_us: now_us.saturating_add(BACK_OFF_US) },
        }
    }

    /// Writes one register of the configuration, by its index.
    fn configure(&mut self, place: usize) -> Result<(), SensorError> {
        match (registers::INTF_CONFIG0..).zip(registers::configuration(&self.config)).nth(place) {
            Some((register, value)) => self.write(register, value),
            None => Ok(()),
        }
    }

    /// The registers that the chip holds instead of its configuration; `None` if they are right. One wrong
    /// answer does not count: they are read again.
    fn wrong_configuration(&mut self) -> Result<Option<[u8; CONFIGURED]>, SensorError> {
        let wanted = registers::configuration(&self.config);
        let mut held = self.read(registers::INTF_CONFIG0)?;
        if held != wanted && Guard::ReadBackAgain.stands() {
            self.health.asked_again();
            held = self.read(registers::INTF_CONFIG0)?;
        }
        Ok((held != wanted).then_some(held))
    }

    /// Writes the registers that differ. If sensors were off, they have to start.
    fn mend(&mut self, held: [u8; CONFIGURED], now_us: u64) -> Result<(), SensorError> {
        let wanted = registers::configuration(&self.config);
        for place in registers::ORDER.map(usize::from) {
            if held.get(place) != wanted.get(place) {
                self.configure(place)?;
            }
        }
        if held
            .get(registers::POWER)
            .is_some_and(|power| power & registers::LOW_NOISE != registers::LOW_NOISE)
        {
            self.phase = Phase::Starting { until_us: now_us.saturating_add(START_US) };
        }
        Ok(())
    }

    fn sample(&mut self, last_sample_us: u64, now_us: u64) -> Result<Option<ImuSample>, SensorError> {
        let burst = self.read::<BURST>(registers::TEMP_DATA1)?;
        let [t1, t0, data @ .., _, _, status] = burst;
        let says_reset = status & registers::RESET_DONE != 0;
        // A reset chip holds none of its configuration, so a chip that holds all of it was not reset.
        if let Some(held) = self.wrong_configuration()? {
            if says_reset || !Guard::ReadBackAgain.stands() {
                self.phase = Phase::Reset;
            } else {
                self.mend(held, now_us)?;
            }
            return Err(SensorError::ConfigurationLost);
        }
        if says_reset {
            self.health.asked_again();
        }
        let [ax1, ax0, ay1, ay0, az1, az0, gx1, gx0, gy1, gy0, gz1, gz0] = data;
        let counts =
            [[ax1, ax0], [ay1, ay0], [az1, az0], [gx1, gx0], [gy1, gy0], [gz1, gz0]].map(i16::from_be_bytes);
        // Every data register resets to -32768 (14.6 to 14.19), so this value means that no sample has been
        // made.
        let fresh = status & registers::DATA_READY != 0 && counts != [i16::MIN; 6];
        if !fresh {
            self.phase = Phase::Running { last_sample_us, failures: 0 };
            let age_us = now_us.saturating_sub(last_sample_us);
            return if age_us > STALE_AFTER_US { Err(SensorError::Stale) } else { Ok(None) };
        }
        self.phase = Phase::Running { last_sample_us: now_us, failures: 0 };
        self.temperature_c =
            Some(f32::from(i16::from_be_bytes([t1, t0])) / COUNTS_PER_DEGREE + DEGREES_AT_ZERO);
        if counts.iter().any(|&count| count == i16::MAX || count == i16::MIN) {
            return Err(SensorError::Saturated);
        }
        let [ax, ay, az, gx, gy, gz] = counts.map(f32::from);
        let accel = self.config.accel_range.mps2_per_count();
        let gyro = self.config.gyro_range.radps_per_count();
        Ok(Some(ImuSample {
            accel_mps2: self.config.mounting.to_body([ax * accel, ay * accel, az * accel]),
            gyro_radps: self.config.mounting.to_body([gx * gyro, gy * gyro, gz * gyro]),
        }))
    }
}

impl<Spi: SpiDevice> InertialUnit for Icm42688p<Spi> {
    fn poll(&mut self, now_us: u64) -> Result<Option<ImuSample>, SensorError> {
        let outcome = self.step(now_us);
        if let Err(error) = outcome
            && error != SensorError::Saturated
        {
            self.phase = self.after(error, now_us);
        }
        self.health.note(outcome)
    }
}

#[cfg(test)]
mod tests;
