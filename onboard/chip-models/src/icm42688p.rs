//! ICM-42688-P inertial unit (TDK InvenSense DS-000347, revision 1.6; section numbers refer to it): user bank
//! 0, the sample path and the interrupt status. Other banks read as zero, and the FIFO is not modelled. The
//! filter before the samples acts on a [`Vibration`] only; the motion is assumed to be slow.

use crate::bus::SpiChip;
use crate::disturbance::Disturbance;
use crate::source::{Motion, Source};
use crate::vibration::{LowPass, Vibration};

const DEVICE_CONFIG: u8 = 0x11;
const TEMP_DATA1: u8 = 0x1D;
const GYRO_DATA_Z0: u8 = 0x2A;
const INT_STATUS: u8 = 0x2D;
const INTF_CONFIG0: u8 = 0x4C;
const PWR_MGMT0: u8 = 0x4E;
const GYRO_CONFIG0: u8 = 0x4F;
const ACCEL_CONFIG0: u8 = 0x50;
const GYRO_CONFIG1: u8 = 0x51;
const GYRO_ACCEL_CONFIG0: u8 = 0x52;
const ACCEL_CONFIG1: u8 = 0x53;
const REG_BANK_SEL: u8 = 0x76;

const RESET_DONE: u8 = 0x10;
const DATA_READY: u8 = 0x08;
/// INTF_CONFIG0: the samples' high bytes come first (14.33).
const BIG_ENDIAN: u8 = 0x10;

/// Duration of a reset, microseconds (14.1).
const RESET_US: u64 = 1_000;
/// Time after switching a sensor on in which no register may be written, microseconds (14.36).
const QUIET_US: u64 = 200;
/// Time until the gyro delivers samples, microseconds (14.36).
const START_US: u64 = 45_000;
/// Standard gravity, m/s^2.
const GRAVITY_MPS2: f32 = 9.806_65;

/// Registers of bank 0 that do not reset to 0 (section 13).
const RESET_VALUES: [(u8, u8); 21] = [
    (0x13, 0x05),
    (0x1D, 0x80),
    (0x1F, 0x80),
    (0x21, 0x80),
    (0x23, 0x80),
    (0x25, 0x80),
    (0x27, 0x80),
    (0x29, 0x80),
    (0x4C, 0x30),
    (0x4D, 0x91),
    (0x4F, 0x06),
    (0x50, 0x06),
    (0x51, 0x16),
    (0x52, 0x11),
    (0x53, 0x0D),
    (0x54, 0x31),
    (0x56, 0x82),
    (0x60, 0x02),
    (0x64, 0x10),
    (0x65, 0x10),
    (0x75, 0x47),
];

/// The chip.
#[derive(Clone, Debug)]
pub struct Icm42688pModel<Surroundings> {
    /// The motion that it is subject to, sampled at the chip's own rate.
    pub motion: Surroundings,
    /// The sample path has stopped: its registers no longer change.
    pub stalled: bool,
    /// Errors of its results: specific force and rate, in the order of the axes.
    pub disturbance: Disturbance,
    /// Vibration of the airframe, added to the motion; only this goes through the model of its filter.
    pub vibration: Option<Vibration>,
    /// Writes that the datasheet forbids, within 200 us of switching a sensor on. The chip has ignored them.
    pub forbidden_writes: u32,
    registers: [u8; 128],
    ready_us: u64,
    quiet_until_us: u64,
    samples_from_us: Option<u64>,
    last_sample: u64,
    address: u8,
    reading: bool,
    position: usize,
}

impl<Surroundings: Source<Motion>> Icm42688pModel<Surroundings> {
    /// A chip without power.
    pub const fn new(motion: Surroundings) -> Self {
        Self {
            motion,
            stalled: false,
            disturbance: Disturbance::NONE,
            vibration: None,
            forbidden_writes: 0,
            registers: [0; 128],
            ready_us: 0,
            quiet_until_us: 0,
            samples_from_us: None,
            last_sample: 0,
            address: 0,
            reading: false,
            position: 0,
        }
    }

    /// A register of bank 0, to inspect or to corrupt. An address has 7 bits.
    pub const fn register_mut(&mut self, address: u8) -> &mut u8 {
        &mut self.registers[(address & 0x7F) as usize]
    }

    fn register(&self, address: u8) -> u8 {
        self.registers[usize::from(address & 0x7F)]
    }

    fn reset(&mut self, now_us: u64) {
        self.registers = [0; 128];
        for (address, value) in RESET_VALUES {
            *self.register_mut(address) = value;
        }
        *self.register_mut(INT_STATUS) = RESET_DONE;
        self.ready_us = now_us + RESET_US;
        self.samples_from_us = None;
    }

    /// Nearest counts of this motion with the configured ranges; values beyond a range saturate. In the
    /// registers' order: temperature, specific force, rate.
    pub fn raw(&self, motion: Motion) -> [i16; 7] {
        let halved = |config: u8| f32::from(1u16 << (self.register(config) >> 5).min(7));
        let per_mps2 = 32_768.0 / (16.0 * GRAVITY_MPS2) * halved(ACCEL_CONFIG0);
        let per_radps = 32_768.0 / 2_000f32.to_radians() * halved(GYRO_CONFIG0);
        let [ax, ay, az] = motion.accel_mps2.map(|value| counts(value * per_mps2));
        let [gx, gy, gz] = motion.gyro_radps.map(|value| counts(value * per_radps));
        [counts((motion.temperature_c - 25.0) * 132.48), ax, ay, az, gx, gy, gz]
    }

    /// Period of the samples by the ODR field, microseconds (14.37, 14.38).
    fn period_us(&self) -> u64 {
        match self.register(GYRO_CONFIG0) & 0xF {
            0x3 => 125,
            0x4 => 250,
            0x5 => 500,
            0x7 => 5_000,
            0x8 => 10_000,
            0x9 => 20_000,
            0xA => 40_000,
            0xB => 80_000,
            0xF => 2_000,
            _ => 1_000,
        }
    }

    /// The low pass before the samples (14.39 to 14.41). UI_FILT_BW is a fraction of the ODR, or of 400 Hz if
    /// that is higher.
    fn filter(&self, is_gyro: bool) -> LowPass {
        let bandwidths = self.register(GYRO_ACCEL_CONFIG0);
        let (field, order) = if is_gyro {
            (bandwidths & 0xF, self.register(GYRO_CONFIG1) >> 2 & 3)
        } else {
            (bandwidths >> 4, self.register(ACCEL_CONFIG1) >> 3 & 3)
        };
        let rate_hz = 1_000_000.0 / self.period_us() as f32;
        let part = match field {
            0 => 2.0,
            1 => 4.0,
            2 => 5.0,
            3 => 8.0,
            4 => 10.0,
            5 => 16.0,
            6 => 20.0,
            _ => 40.0,
        };
        let filtered_hz = if field == 0 { rate_hz } else { rate_hz.max(400.0) };
        LowPass { order: order.min(2) + 1, bandwidth_hz: filtered_hz / part }
    }

    /// The motion with the chip's errors and with the airframe's vibration after the filter.
    fn disturbed(&mut self, mut motion: Motion, sample_us: u64) -> Motion {
        let shaken = self.vibration.map(|vibration| {
            let filter = self.filter(vibration.channel >= 3);
            (vibration.channel, vibration.at(sample_us, filter))
        });
        let channels = motion.accel_mps2.iter_mut().chain(&mut motion.gyro_radps);
        for (channel, value) in channels.enumerate() {
            *value += self.disturbance.error(channel);
            if let Some((_, shake)) = shaken.filter(|(shaken, _)| *shaken == channel) {
                *value += shake;
            }
        }
        motion
    }

    fn make_sample(&mut self, now_us: u64) {
        // A sensor that a flipped bit has switched off starts again once it is on again.
        if self.register(PWR_MGMT0) & 0xF != 0xF {
            self.samples_from_us = None;
        }
        let Some(from_us) = self.samples_from_us else { return };
        if self.stalled || now_us < from_us {
            return;
        }
        let period_us = self.period_us();
        let sample = 1 + (now_us - from_us) / period_us;
        if sample == self.last_sample {
            return;
        }
        self.last_sample = sample;
        if self.disturbance.frozen {
            *self.register_mut(INT_STATUS) |= DATA_READY;
            return;
        }
        let sample_us = from_us + (sample - 1) * period_us;
        let motion = self.motion.at(sample_us);
        let motion = self.disturbed(motion, sample_us);
        for (index, value) in (0u8..).zip(self.raw(motion)) {
            let channel = usize::from(index).checked_sub(1);
            let flipped = channel.map_or(0, |channel| self.disturbance.flipped(channel));
            let [.., flipped_high, flipped_low] = flipped.to_be_bytes();
            let [high, low] = value.to_be_bytes();
            let (high, low) = (high ^ flipped_high, low ^ flipped_low);
            let is_big_endian = self.register(INTF_CONFIG0) & BIG_ENDIAN != 0;
            let (high, low) = if is_big_endian { (high, low) } else { (low, high) };
            *self.register_mut(TEMP_DATA1 + 2 * index) = high;
            *self.register_mut(TEMP_DATA1 + 2 * index + 1) = low;
        }
        *self.register_mut(INT_STATUS) |= DATA_READY;
    }

    fn write(&mut self, now_us: u64, address: u8, value: u8) {
        if now_us < self.quiet_until_us {
            self.forbidden_writes += 1;
            return;
        }
        match address {
            DEVICE_CONFIG if value & 1 != 0 => self.reset(now_us),
            // Read-only: the data, the status and the identity.
            TEMP_DATA1..=GYRO_DATA_Z0 | INT_STATUS | 0x75 => {}
            PWR_MGMT0 => {
                let both_low_noise = value & 0xF == 0xF;
                if both_low_noise && self.samples_from_us.is_none() {
                    self.samples_from_us = Some(now_us + START_US);
                    self.last_sample = 0;
                    self.quiet_until_us = now_us + QUIET_US;
                } else if !both_low_noise {
                    self.samples_from_us = None;
                }
                *self.register_mut(address) = value;
            }
            _ => *self.register_mut(address) = value,
        }
    }
}

/// The nearest count; a 16-bit converter saturates.
fn counts(value: f32) -> i16 {
    let nearest = if value < 0.0 { value - 0.5 } else { value + 0.5 };
    // A cast of a float saturates and truncates.
    nearest as i16
}

impl<Surroundings: Source<Motion>> SpiChip for Icm42688pModel<Surroundings> {
    fn select(&mut self, now_us: u64) {
        self.position = 0;
        self.make_sample(now_us);
    }

    fn exchange(&mut self, now_us: u64, mosi: u8) -> u8 {
        let first = self.position == 0;
        self.position += 1;
        if now_us < self.ready_us {
            return 0;
        }
        if first {
            self.reading = mosi & 0x80 != 0;
            self.address = mosi & 0x7F;
            return 0;
        }
        let address = self.address;
        self.address = (self.address + 1) & 0x7F;
        let other_bank = self.register(REG_BANK_SEL) & 7 != 0 && address != REG_BANK_SEL;
        if other_bank {
            return 0;
        }
        if self.reading {
            let value = self.register(address);
            if address == INT_STATUS {
                *self.register_mut(INT_STATUS) = 0;
            }
            value
        } else {
            self.write(now_us, address, mosi);
            0
        }
    }

    fn deselect(&mut self, _now_us: u64) {}

    fn power_on_reset(&mut self, now_us: u64) {
        self.quiet_until_us = 0;
        self.reset(now_us);
    }
}
