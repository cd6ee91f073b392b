//! The MS5611 driver against the chip's model.
#![allow(clippy::unwrap_used, clippy::panic)]

mod bench;

use bench::{Bench, Driver, pressure_and_temperature};
use chip_models::bus::{ChipOnBus, WireFault};
use chip_models::ms5611::{EXAMPLE_CALIBRATION, Ms5611Model};
use chip_models::source::{Air, Held};
use drivers::ms5611::{MAX_POLL_BYTES, Ms5611};
use drivers::{Barometer, SensorError};
use proptest::prelude::*;

const GROUND: Air = Air { pressure_pa: 101_325.0, temperature_c: 25.0 };

/// The driver on its chip.
type Chip = Ms5611<ChipOnBus<Ms5611Model<Held<Air>>>>;

impl Driver for Chip {
    type Chip = Ms5611Model<Held<Air>>;
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
    fn new(calibration: [u16; 6], air: Air) -> Self {
        Self::at(0, Ms5611::new(ChipOnBus::new(Ms5611Model::new(calibration, Held(air)))))
    }

    /// Correct samples come again within a quarter of a second, whatever errors come before.
    fn assert_recovers(&mut self, air: Air) {
        self.mend();
        for _ in 0..20 {
            let (pressure, temperature) = self.next(4).unwrap();
            assert!((pressure - air.pressure_pa).abs() < 0.1, "{pressure}");
            assert!((temperature - air.temperature_c).abs() < 0.01, "{temperature}");
        }
    }
}

/// The chip's quantum of pressure: half a count of D1, SENS / 2^36; half a count of D2, which moves OFF and
/// SENS; and the rounding of the pressure to f32, once on the way in and once on the way out.
fn tolerance_pa(calibration: [u16; 6], air: Air) -> f32 {
    let [c1, _, c3, c4, _, c6] = calibration.map(f32::from);
    let dt = (air.temperature_c - 20.0) * 838_860_800.0 / c6;
    let sensitivity = c1 * 32_768.0 + c3 * dt / 256.0;
    let d1_count = sensitivity / 36f32.exp2();
    // |dP/dD2|: D1 < 2^24.
    let d2_count = (c3 / 256.0 * 8.0 + c4 / 128.0) / 32_768.0;
    0.5 * d1_count + 0.5 * d2_count + 2.0 / 128.0
}

/// Factory calibrations: within 20 % of the example, so that the whole range fits the converter.
fn calibration() -> impl Strategy<Value = [u16; 6]> {
    prop::array::uniform6(0.9f32..1.1).prop_map(|factors| {
        let mut calibration = EXAMPLE_CALIBRATION;
        for (word, factor) in calibration.iter_mut().zip(factors) {
            *word = (f32::from(*word) * factor) as u16;
        }
        calibration
    })
}

proptest! {
    /// Pressure and temperature come back within the chip's quantisation over its whole range.
    #[test]
    fn what_goes_in_comes_out(
        calibration in calibration(),
        pressure_pa in 1_010.0f32..119_900.0,
        temperature_c in -39.9f32..84.9,
    ) {
        let air = Air { pressure_pa, temperature_c };
        let mut bench = Bench::new(calibration, air);
        let raw = bench.driver.bus_mut().chip.raw(air);
        prop_assume!((2..0xFF_FFFE).contains(&raw.0) && (2..0xFF_FFFE).contains(&raw.1));
        let (pressure, temperature) = bench.next(40).unwrap();
        let tolerance = tolerance_pa(calibration, air);
        prop_assert!((pressure - pressure_pa).abs() <= tolerance, "{pressure} {pressure_pa} {tolerance}");
        // One count of D2 is c6 / 2^23 hundredths: 3.4e-5 degrees; f32 at 85 degrees: 8e-6.
        prop_assert!((temperature - temperature_c).abs() <= 5e-5, "{temperature} {temperature_c}");
    }
}

#[test]
fn the_rate_is_the_datasheets() {
    let mut bench = Bench::new(EXAMPLE_CALIBRATION, GROUND);
    bench.next(40).unwrap();
    let samples = (0..1_000).filter(|_| bench.poll().unwrap().is_some()).count();
    // 7 pressures in 8 conversions of two ticks each: 437.5 in a thousand ticks.
    assert!((437..=438).contains(&samples), "{samples}");
    let health = bench.driver.health();
    assert_eq!((health.errors, health.initialisations), (0, 1));
}

#[test]
fn a_stuck_line_is_found_and_left() {
    for (fault, first) in
        [(WireFault::StuckLow, SensorError::NoConversion), (WireFault::StuckHigh, SensorError::StuckBus)]
    {
        let mut bench = Bench::new(EXAMPLE_CALIBRATION, GROUND);
        bench.next(40).unwrap();
        bench.driver.bus_mut().fault = Some(fault);
        assert_eq!(bench.next_error(4), first);
        for _ in 0..3 {
            assert_eq!(bench.next_error(40), first);
        }
        bench.assert_recovers(GROUND);
        assert_eq!(bench.driver.health().errors, 4);
    }
}

#[test]
fn an_error_of_the_peripheral_is_passed_on() {
    let mut bench = Bench::new(EXAMPLE_CALIBRATION, GROUND);
    bench.next(40).unwrap();
    bench.driver.bus_mut().fault = Some(WireFault::BusError);
    assert_eq!(bench.next_error(4), SensorError::Bus);
    bench.assert_recovers(GROUND);
}

#[test]
fn a_power_dip_loses_the_conversion_and_no_more() {
    let mut bench = Bench::new(EXAMPLE_CALIBRATION, GROUND);
    bench.next(40).unwrap();
    bench.driver.bus_mut().power_dip();
    assert_eq!(bench.next_error(4), SensorError::NoConversion);
    bench.assert_recovers(GROUND);
    assert_eq!(bench.driver.health().initialisations, 2);
}

#[test]
fn a_conversion_that_is_too_slow_is_no_result() {
    let mut bench = Bench::new(EXAMPLE_CALIBRATION, GROUND);
    bench.next(40).unwrap();
    bench.driver.bus_mut().chip.slower_by_us = 3_000;
    assert_eq!(bench.next_error(6), SensorError::NoConversion);
    bench.driver.bus_mut().chip.slower_by_us = 0;
    bench.assert_recovers(GROUND);
}

#[test]
fn a_flipped_bit_in_the_calibration_is_found() {
    // The first bytes are the reset, then eight answers of 3 bytes each.
    for after_bytes in [1 + 1, 1 + 3 + 2, 1 + 7 * 3 + 1, 1 + 8 * 3 + 4] {
        let mut bench = Bench::new(EXAMPLE_CALIBRATION, GROUND);
        bench.driver.bus_mut().fault = Some(WireFault::FlipBits { after_bytes, mask: 0x04 });
        assert_eq!(bench.next_error(20), SensorError::Check, "{after_bytes}");
        bench.assert_recovers(GROUND);
    }
}

/// On a garbled line one calibration in 16 passes the 4-bit CRC. None of those is accepted, at the start or
/// later.
#[test]
fn noise_while_the_calibration_is_read_never_becomes_a_calibration() {
    for seed in 0..300 {
        let mut bench = Bench::new(EXAMPLE_CALIBRATION, GROUND);
        bench.driver.bus_mut().fault = Some(WireFault::Garbage { noise: seed });
        for _ in 0..1 + seed % 40 {
            let _ = bench.poll();
        }
        bench.assert_recovers(GROUND);
        // Once known the calibration is kept, whatever the line or the memory do later.
        bench.driver.bus_mut().chip.prom_flip = Some((3, 0x10));
        bench.driver.bus_mut().power_dip();
        bench.assert_recovers(GROUND);
    }
}

/// A memory whose bits read wrong at the start is not accepted until they read right.
#[test]
fn a_calibration_that_reads_wrong_is_not_flown() {
    let mut bench = Bench::new(EXAMPLE_CALIBRATION, GROUND);
    bench.driver.bus_mut().chip.prom_flip = Some((5, 0x20));
    for _ in 0..3 {
        assert_eq!(bench.next_error(40), SensorError::Check);
    }
    bench.driver.bus_mut().chip.prom_flip = None;
    bench.assert_recovers(GROUND);
}

/// Time from the error to the next sample.
#[test]
fn a_power_dip_costs_less_than_a_tenth_of_a_second() {
    let mut bench = Bench::new(EXAMPLE_CALIBRATION, GROUND);
    bench.next(40).unwrap();
    bench.driver.bus_mut().power_dip();
    bench.next_error(4);
    bench.next(20).unwrap();
}

#[test]
fn a_flipped_top_bit_in_a_result_leaves_the_range() {
    let mut bench = Bench::new(EXAMPLE_CALIBRATION, GROUND);
    while bench.poll().unwrap().is_none() {}
    // The next result's first byte follows its command.
    bench.driver.bus_mut().fault = Some(WireFault::FlipBits { after_bytes: 1, mask: 0x80 });
    assert_eq!(bench.next_error(4), SensorError::OutOfRange);
    bench.assert_recovers(GROUND);
}
