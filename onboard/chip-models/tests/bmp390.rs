//! The BMP390 driver against the chip's model.
#![allow(clippy::unwrap_used, clippy::panic)]

mod bench;

use bench::{Bench, Driver, pressure_and_temperature};
use chip_models::bmp390::{Bmp390Model, Trimming};
use chip_models::bus::{ChipOnBus, WireFault};
use chip_models::source::{Air, Held};
use drivers::bmp390::{Bmp390, MAX_POLL_BYTES};
use drivers::{Barometer, SensorError};
use proptest::prelude::*;

const GROUND: Air = Air { pressure_pa: 101_325.0, temperature_c: 25.0 };

/// The driver on its chip.
type Chip = Bmp390<ChipOnBus<Bmp390Model<Held<Air>>>>;

impl Driver for Chip {
    type Chip = Bmp390Model<Held<Air>>;
    type Sample = (f32, f32);
    const MAX_POLL_BYTES: usize = MAX_POLL_BYTES;

    fn bus(&mut self) -> &mut ChipOnBus<Self::Chip> {
        self.bus_mut()
    }

    fn poll(&mut self, now_us: u64) -> Result<Option<(f32, f32)>, SensorError> {
        Barometer::poll(self, now_us).map(|sample| sample.map(pressure_and_temperature))
    }
}

impl Bench<Chip> {
    fn new(trimming: Trimming, air: Air) -> Self {
        // Off the chip's own raster, so that no tick coincides with the end of a conversion.
        Self::at(1_300, Bmp390::new(ChipOnBus::new(Bmp390Model::new(trimming, Held(air)))))
    }

    fn running() -> Self {
        let mut bench = Self::new(Trimming::REAL, GROUND);
        bench.next(40).unwrap();
        bench
    }

    /// Correct samples come again within a quarter of a second.
    fn assert_recovers(&mut self) {
        self.mend();
        for _ in 0..20 {
            let (pressure, temperature) = self.next(5).unwrap();
            assert!((pressure - GROUND.pressure_pa).abs() < 0.1, "{pressure}");
            assert!((temperature - GROUND.temperature_c).abs() < 0.001, "{temperature}");
        }
    }
}

/// Coefficients within 5 % of a real chip's.
fn trimming() -> impl Strategy<Value = Trimming> {
    let real = Trimming::REAL;
    (prop::array::uniform3(0.95f32..1.05), prop::collection::vec(0.95f32..1.05, 11)).prop_map(
        move |(t, p)| {
            let scaled = |value: i32, factor: f32| (value as f32 * factor) as i32;
            let mut trimming = real;
            trimming.t.iter_mut().zip(t).for_each(|(value, factor)| *value = scaled(*value, factor));
            trimming.p.iter_mut().zip(p).for_each(|(value, factor)| *value = scaled(*value, factor));
            trimming
        },
    )
}

proptest! {
    /// Pressure and temperature come back within the chip's quantisation over its whole range.
    #[test]
    fn what_goes_in_comes_out(
        trimming in trimming(),
        pressure_pa in 30_010.0f32..124_990.0,
        temperature_c in -39.9f32..84.9,
    ) {
        let air = Air { pressure_pa, temperature_c };
        let (raw_p, raw_t) = trimming.raw(air);
        prop_assume!((2..0xFF_FFFD).contains(&raw_p) && (2..0xFF_FFFD).contains(&raw_t));
        let mut bench = Bench::new(trimming, air);
        let (pressure, temperature) = bench.next(40).unwrap();
        // Half a count of pressure (at most 0.02 Pa here: (P1 - 2^14) / 2^20), f32 in and out (1/128 Pa), and
        // the temperature's truncation to 2^-20 degrees times 500 Pa a degree of the offset.
        prop_assert!((pressure - pressure_pa).abs() <= 0.010 + 1.0 / 128.0 + 0.001, "{pressure} {pressure_pa}");
        // One count of temperature is T2 / 2^30 = 1.8e-5 degrees; f32 at 85 degrees: 8e-6.
        prop_assert!((temperature - temperature_c).abs() <= 2e-5, "{temperature} {temperature_c}");
    }
}

#[test]
fn the_rate_is_50_hz() {
    let mut bench = Bench::running();
    let samples = (0..1_000).filter(|_| bench.poll().unwrap().is_some()).count();
    assert!((249..=251).contains(&samples), "{samples}");
    let health = bench.driver.health();
    assert_eq!((health.errors, health.initialisations), (0, 1));
}

#[test]
fn a_stuck_line_is_found_and_left() {
    for fault in [WireFault::StuckLow, WireFault::StuckHigh] {
        let mut bench = Bench::running();
        bench.driver.bus_mut().fault = Some(fault);
        for _ in 0..3 {
            assert_eq!(bench.next_error(10), SensorError::StuckBus, "{fault:?}");
        }
        bench.assert_recovers();
    }
}

#[test]
fn an_error_of_the_peripheral_is_passed_on() {
    let mut bench = Bench::running();
    bench.driver.bus_mut().fault = Some(WireFault::BusError);
    assert_eq!(bench.next_error(1), SensorError::Bus);
    bench.assert_recovers();
}

#[test]
fn a_reset_in_flight_is_found_at_once() {
    let mut bench = Bench::running();
    bench.driver.bus_mut().power_dip();
    assert_eq!(bench.next_error(1), SensorError::ConfigurationLost);
    bench.assert_recovers();
    assert_eq!(bench.driver.health().initialisations, 2);
}

#[test]
fn a_register_that_changes_is_found() {
    for (register, bit) in [(0x1B, 0x01), (0x1C, 0x01), (0x1D, 0x01), (0x1F, 0x02)] {
        let mut bench = Bench::running();
        *bench.driver.bus_mut().chip.register_mut(register) ^= bit;
        assert_eq!(bench.next_error(8 * 8 + 1), SensorError::ConfigurationLost, "{register:#x}");
        assert_eq!(bench.driver.health().asked_again, 1, "wrong twice is wrong");
        // The board's wait for the bus is derived from this bound, so the bound must be exact.
        assert_eq!(bench.most_moved, MAX_POLL_BYTES);
        bench.assert_recovers();
    }
}

#[test]
fn an_error_that_the_chip_reports_resets_it() {
    let mut bench = Bench::running();
    *bench.driver.bus_mut().chip.register_mut(0x02) = 0x01;
    assert_eq!(bench.next_error(1), SensorError::ConfigurationLost);
    bench.assert_recovers();
}

#[test]
fn a_chip_that_converts_too_slowly_is_stale() {
    let mut bench = Bench::running();
    bench.driver.bus_mut().chip.slower_by_us = 200_000;
    assert_eq!(bench.next_error(60), SensorError::Stale);
    bench.driver.bus_mut().chip.slower_by_us = 0;
    bench.assert_recovers();
}

#[test]
fn a_flipped_bit_in_the_coefficients_is_found() {
    // Two bytes of reset, three of identity, two of address; then the CRC and 21 coefficients.
    for after_bytes in 7..29 {
        let mut bench = Bench::new(Trimming::REAL, GROUND);
        bench.driver.bus_mut().fault = Some(WireFault::FlipBits { after_bytes, mask: 0x04 });
        assert_eq!(bench.next_error(10), SensorError::Check, "{after_bytes}");
        bench.assert_recovers();
    }
}

#[test]
fn another_chip_is_refused() {
    let mut bench = Bench::new(Trimming::REAL, GROUND);
    bench.poll().unwrap();
    *bench.driver.bus_mut().chip.register_mut(0x00) = 0x50;
    assert_eq!(bench.poll(), Err(SensorError::WrongDevice));
    bench.assert_recovers();
}
