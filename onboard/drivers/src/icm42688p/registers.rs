//! Registers of user bank 0 (TDK InvenSense DS-000347, revision 1.6, section 13 and 14), and the values that
//! this driver writes to them.

use super::Config;

/// MSB of an address for a read.
pub(super) const READ: u8 = 0x80;

pub(super) const DEVICE_CONFIG: u8 = 0x11;
pub(super) const TEMP_DATA1: u8 = 0x1D;
pub(super) const INT_STATUS: u8 = 0x2D;
pub(super) const INTF_CONFIG0: u8 = 0x4C;
pub(super) const WHO_AM_I: u8 = 0x75;
pub(super) const REG_BANK_SEL: u8 = 0x76;

/// DEVICE_CONFIG: software reset (14.1).
pub(super) const SOFT_RESET: u8 = 0x01;
/// INT_STATUS: a reset has completed; cleared by reading (14.22).
pub(super) const RESET_DONE: u8 = 0x10;
/// INT_STATUS: a new sample; cleared by reading.
pub(super) const DATA_READY: u8 = 0x08;
/// WHO_AM_I of the ICM-42688-P (14.60).
pub(super) const IDENTITY: u8 = 0x47;

/// INTF_CONFIG0: sensor data big-endian, I2C disabled (14.33).
const BIG_ENDIAN_SPI_ONLY: u8 = 0x33;
/// INTF_CONFIG1: clock from the PLL; adaptive full scale off, as in the manufacturer's driver (the datasheet
/// leaves bits 7:6 reserved). With it on, the gyro stalls for milliseconds near 100 degrees a second.
const PLL_FIXED_SCALE: u8 = 0x51;
/// PWR_MGMT0: both sensors in low-noise mode (14.36).
pub(super) const LOW_NOISE: u8 = 0x0F;
/// ODR fields of GYRO_CONFIG0 and ACCEL_CONFIG0: 1 kHz (14.37, 14.38).
const RATE_1_KHZ: u8 = 0x06;
/// GYRO_ACCEL_CONFIG0: both filters at a fortieth of the rate, 25 Hz (14.40). A tick takes every fifth
/// sample, so a vibration near 200 Hz folds to 0 Hz, where it is integrated twice. Of 1 m/s^2 this filter
/// leaves 2 mm/s^2 there (54 dB), where 100 Hz of second order left 240 (12 dB). Its delay is 13 ms (100 Hz:
/// 2 ms), less than three ticks.
const BANDWIDTH_25_HZ: u8 = 0x77;
/// GYRO_CONFIG1 and ACCEL_CONFIG1: filters of third order (14.39, 14.41); the other bits at their reset
/// values.
const GYRO_THIRD_ORDER: u8 = 0x1A;
const ACCEL_THIRD_ORDER: u8 = 0x15;

/// Number of registers that this driver writes, all from INTF_CONFIG0 to ACCEL_CONFIG1.
pub(super) const CONFIGURED: usize = 8;
/// Index of PWR_MGMT0 among them.
pub(super) const POWER: usize = 2;

/// Their configured values.
pub(super) const fn configuration(config: &Config) -> [u8; CONFIGURED] {
    [
        BIG_ENDIAN_SPI_ONLY,
        PLL_FIXED_SCALE,
        LOW_NOISE,
        config.gyro_range.field() << 5 | RATE_1_KHZ,
        config.accel_range.field() << 5 | RATE_1_KHZ,
        GYRO_THIRD_ORDER,
        BANDWIDTH_25_HZ,
        ACCEL_THIRD_ORDER,
    ]
}

/// Their indexes in the order in which they are written: the power comes last, because no register may be
/// written for 200 us after it (14.36).
pub(super) const ORDER: [u8; CONFIGURED] = [0, 1, 3, 4, 5, 6, 7, 2];
