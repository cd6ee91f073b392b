//! Registers of user bank 0 (TDK InvenSense DS-000347, revision 1.6, section 13 and 14), and what this driver
//! writes into them.

use super::Config;

/// MSB of an address: a read.
pub(super) const READ: u8 = 0x80;

pub(super) const DEVICE_CONFIG: u8 = 0x11;
pub(super) const TEMP_DATA1: u8 = 0x1D;
pub(super) const INT_STATUS: u8 = 0x2D;
pub(super) const INTF_CONFIG0: u8 = 0x4C;
pub(super) const INTF_CONFIG1: u8 = 0x4D;
pub(super) const PWR_MGMT0: u8 = 0x4E;
pub(super) const GYRO_CONFIG0: u8 = 0x4F;
pub(super) const ACCEL_CONFIG0: u8 = 0x50;
pub(super) const GYRO_ACCEL_CONFIG0: u8 = 0x52;
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
/// INTF_CONFIG1: clock from the PLL; adaptive full scale off, as the manufacturer's driver has it (the datasheet
/// leaves bits 7:6 reserved). With it on the gyro stalls for milliseconds near 100 degrees a second.
const PLL_FIXED_SCALE: u8 = 0x51;
/// PWR_MGMT0: both sensors in low-noise mode (14.36).
const LOW_NOISE: u8 = 0x0F;
/// ODR fields of GYRO_CONFIG0 and ACCEL_CONFIG0: 1 kHz (14.37, 14.38).
const RATE_1_KHZ: u8 = 0x06;
/// GYRO_ACCEL_CONFIG0: both filters at a tenth of the rate, 100 Hz: what a 200 Hz tick can take without
/// aliasing (14.40).
const BANDWIDTH_100_HZ: u8 = 0x44;

/// What is written, in this order: the power comes last, because no register may be written for 200 us
/// after it (14.36).
pub(super) fn configuration(config: &Config) -> [(u8, u8); 6] {
    [
        (INTF_CONFIG0, BIG_ENDIAN_SPI_ONLY),
        (INTF_CONFIG1, PLL_FIXED_SCALE),
        (GYRO_CONFIG0, config.gyro_range.field() << 5 | RATE_1_KHZ),
        (ACCEL_CONFIG0, config.accel_range.field() << 5 | RATE_1_KHZ),
        (GYRO_ACCEL_CONFIG0, BANDWIDTH_100_HZ),
        (PWR_MGMT0, LOW_NOISE),
    ]
}
