//! The chips' SPI buses, with one chip each.
//!
//! A transfer waits for its last bit. In master mode the clock is the board's own, so no chip can delay it: a
//! dead chip reads as 0, and a missing one as 1 (the pin is pulled up). The most that the drivers transfer in
//! one tick takes [`WAIT_US`] microseconds of its 5,000.

use core::convert::Infallible;

use drivers::icm42688p;
use embedded_hal::delay::DelayNs;
use embedded_hal::spi::MODE_3;
use embedded_hal_bus::spi::ExclusiveDevice;
use stm32f4xx_hal::gpio::{Output, PinState, Speed};
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::rcc::Rcc;
use stm32f4xx_hal::spi::Spi;

use super::sensors::BARO_POLL_BYTES;
use super::wiring::{
    BARO_SPI_HZ, BaroMiso, BaroMosi, BaroSck, BaroSelect, BaroSpi, CORE_MHZ, IMU_SPI_HZ, ImuMiso, ImuMosi,
    ImuSck, ImuSelect, ImuSpi,
};
use crate::tick_timer::TICK_HZ;

/// The core's cycles between two bytes: the HAL reads the status and moves the data over the peripheral bus.
const CYCLES_BETWEEN_BYTES: u32 = 100;

/// Longest time that a tick spends waiting for both buses, microseconds.
const WAIT_US: u32 = bus_us(icm42688p::MAX_POLL_BYTES, IMU_SPI_HZ) + bus_us(BARO_POLL_BYTES, BARO_SPI_HZ);

// 85 us, with a BMP390 143: for a tick in which every register of the inertial unit is written again.
const _: () = assert!(WAIT_US <= 1_000_000 / TICK_HZ * 3 / 100, "the buses take more than 3 % of a tick");

const fn bus_us(bytes: usize, hz: u32) -> u32 {
    let bytes = bytes as u32;
    (bytes * 8).div_ceil(hz / 1_000_000) + (bytes * CYCLES_BETWEEN_BYTES).div_ceil(CORE_MHZ)
}

/// The inertial unit on its bus.
pub type ImuDevice = ExclusiveDevice<Spi<ImuSpi>, ImuSelect<Output>, CycleDelay>;
/// The barometer on its bus.
pub type BaroDevice = ExclusiveDevice<Spi<BaroSpi>, BaroSelect<Output>, CycleDelay>;

/// Waits by counting the core's cycles.
pub struct CycleDelay;

impl DelayNs for CycleDelay {
    fn delay_ns(&mut self, ns: u32) {
        let cycles = u64::from(ns) * u64::from(CORE_MHZ) / 1_000 + 1;
        cortex_m::asm::delay(cycles as u32);
    }
}

/// Starts the inertial unit's bus. SPI mode 3 (DS-000347, 9.6: "data is latched on the rising edge").
pub fn imu(
    spi: ImuSpi,
    (sck, miso, mosi): (ImuSck, ImuMiso, ImuMosi),
    select: ImuSelect,
    rcc: &mut Rcc,
) -> Result<ImuDevice, Infallible> {
    let select = select.into_push_pull_output_in_state(PinState::High);
    let sck = sck.into_alternate().speed(Speed::High);
    let mosi = mosi.into_alternate().speed(Speed::High);
    let miso = miso.into_pull_up_input();
    let bus = Spi::new(spi, (Some(sck), Some(miso), Some(mosi)), MODE_3, IMU_SPI_HZ.Hz(), rcc);
    ExclusiveDevice::new(bus, select, CycleDelay)
}

/// Starts the barometer's bus. SPI mode 3 (MS5611-01BA03, "SPI mode", and BST-BMP390-DS002, 5.3: modes 0 and
/// 3).
pub fn barometer(
    spi: BaroSpi,
    (sck, miso, mosi): (BaroSck, BaroMiso, BaroMosi),
    select: BaroSelect,
    rcc: &mut Rcc,
) -> Result<BaroDevice, Infallible> {
    let select = select.into_push_pull_output_in_state(PinState::High);
    let sck = sck.into_alternate().speed(Speed::High);
    let mosi = mosi.into_alternate().speed(Speed::High);
    let miso = miso.into_pull_up_input();
    let bus = Spi::new(spi, (Some(sck), Some(miso), Some(mosi)), MODE_3, BARO_SPI_HZ.Hz(), rcc);
    ExclusiveDevice::new(bus, select, CycleDelay)
}
