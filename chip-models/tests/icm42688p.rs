//! The ICM-42688-P driver against the chip's model.
#![allow(clippy::unwrap_used, clippy::panic)]

mod bench;

use bench::{Bench, Driver};
use chip_models::bus::{ChipOnBus, WireFault};
use chip_models::icm42688p::Icm42688pModel;
use chip_models::source::{Held, Motion};
use drivers::icm42688p::{AccelRange, Config, GyroRange, Icm42688p, MAX_POLL_BYTES, Mounting};
use drivers::{InertialUnit, SensorError};
use kf_core::input::ImuSample;
use proptest::prelude::*;

const CONFIG: Config =
    Config { accel_range: AccelRange::G16, gyro_range: GyroRange::Dps2000, mounting: Mounting::ALIGNED };
const LEVEL: Motion =
    Motion { accel_mps2: [0.0, 0.0, -9.806_65], gyro_radps: [0.1, -0.2, 0.3], temperature_c: 40.0 };

/// The driver on its chip.
type Chip = Icm42688p<ChipOnBus<Icm42688pModel<Held<Motion>>>>;

impl Driver for Chip {
    type Chip = Icm42688pModel<Held<Motion>>;
    type Sample = ImuSample;
    const MAX_POLL_BYTES: usize = MAX_POLL_BYTES;

    fn bus(&mut self) -> &mut ChipOnBus<Self::Chip> {
        self.bus_mut()
    }

    fn poll(&mut self, now_us: u64) -> Result<Option<ImuSample>, SensorError> {
        InertialUnit::poll(self, now_us)
    }
}

impl Bench<Chip> {
    fn new(config: Config, motion: Motion) -> Self {
        Self::at(0, Icm42688p::new(ChipOnBus::new(Icm42688pModel::new(Held(motion))), config))
    }

    fn running() -> Self {
        let mut bench = Self::new(CONFIG, LEVEL);
        bench.next(60).unwrap();
        bench
    }

    /// A sample every tick again, and right, within a quarter of a second.
    fn assert_recovers(&mut self) {
        self.mend();
        for _ in 0..20 {
            let sample = self.poll().unwrap().unwrap();
            assert!((sample.accel_mps2[2] - LEVEL.accel_mps2[2]).abs() < 0.003, "{sample:?}");
            assert!((sample.gyro_radps[1] - LEVEL.gyro_radps[1]).abs() < 0.000_6, "{sample:?}");
        }
        assert_eq!(self.driver.bus_mut().chip.forbidden_writes, 0);
    }
}

fn any_config() -> impl Strategy<Value = Config> {
    use {AccelRange as A, GyroRange as G};
    (
        prop::sample::select(vec![A::G16, A::G8, A::G4, A::G2]),
        prop::sample::select(vec![G::Dps2000, G::Dps1000, G::Dps500, G::Dps250]),
    )
        .prop_map(|(accel_range, gyro_range)| Config {
            accel_range,
            gyro_range,
            mounting: Mounting::ALIGNED,
        })
}

proptest! {
    /// Every range: what goes in comes out within half a count.
    #[test]
    fn what_goes_in_comes_out(
        config in any_config(),
        accel in prop::array::uniform3(-0.999f32..0.999),
        gyro in prop::array::uniform3(-0.999f32..0.999),
        temperature_c in -40f32..85.0,
    ) {
        let accel_count = config.accel_range.mps2_per_count();
        let gyro_count = config.gyro_range.radps_per_count();
        let motion = Motion {
            accel_mps2: accel.map(|part| part * accel_count * 32_768.0),
            gyro_radps: gyro.map(|part| part * gyro_count * 32_768.0),
            temperature_c,
        };
        let mut bench = Bench::new(config, motion);
        let sample = bench.next(60).unwrap();
        // Half a count, and f32's rounding of 2^15 counts.
        for (found, set) in sample.accel_mps2.into_iter().zip(motion.accel_mps2) {
            prop_assert!((found - set).abs() <= 0.51 * accel_count, "{found} {set}");
        }
        for (found, set) in sample.gyro_radps.into_iter().zip(motion.gyro_radps) {
            prop_assert!((found - set).abs() <= 0.51 * gyro_count, "{found} {set}");
        }
        let found = bench.driver.temperature_c().unwrap();
        prop_assert!((found - temperature_c).abs() <= 0.51 / 132.48, "{found} {temperature_c}");
    }
}

#[test]
fn every_tick_has_a_sample() {
    let mut bench = Bench::running();
    for _ in 0..1_000 {
        assert!(bench.poll().unwrap().is_some());
    }
    let health = bench.driver.health();
    assert_eq!((health.samples, health.errors, health.initialisations), (1_001, 0, 1));
}

#[test]
fn a_stuck_line_is_found_and_left() {
    for fault in [WireFault::StuckLow, WireFault::StuckHigh] {
        let mut bench = Bench::running();
        bench.driver.bus_mut().fault = Some(fault);
        for _ in 0..3 {
            assert_eq!(bench.next_error(5), SensorError::StuckBus, "{fault:?}");
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
fn a_reset_in_flight_is_found_at_once_and_configured_anew() {
    let mut bench = Bench::running();
    bench.driver.bus_mut().power_dip();
    assert_eq!(bench.next_error(1), SensorError::ConfigurationLost);
    bench.assert_recovers();
    assert_eq!(bench.driver.health().initialisations, 2);
}

#[test]
fn a_register_that_changes_is_found_within_eight_polls() {
    for register in [0x4C, 0x4D, 0x4E, 0x4F, 0x50, 0x52] {
        let mut bench = Bench::running();
        *bench.driver.bus_mut().chip.register_mut(register) ^= 0x20;
        assert_eq!(bench.next_error(8), SensorError::ConfigurationLost, "{register:#x}");
        bench.assert_recovers();
    }
}

#[test]
fn a_chip_that_makes_no_samples_is_stale() {
    let mut bench = Bench::running();
    bench.driver.bus_mut().chip.stalled = true;
    let polls = (1..).find(|_| bench.poll().is_err()).unwrap();
    // 20 ms and one tick; and no old sample was passed off as a new one.
    assert_eq!(polls, 5);
    assert_eq!(bench.driver.health().last_error, Some(SensorError::Stale));
    assert_eq!(bench.driver.health().samples, 1);
    bench.driver.bus_mut().chip.stalled = false;
    bench.assert_recovers();
}

#[test]
fn a_saturated_axis_costs_its_samples_and_no_more() {
    let mut bench = Bench::running();
    for value in [200.0, -200.0] {
        bench.driver.bus_mut().chip.motion.0.accel_mps2[1] = value;
        assert_eq!(bench.poll(), Err(SensorError::Saturated));
    }
    bench.driver.bus_mut().chip.motion.0 = LEVEL;
    assert!(bench.poll().unwrap().is_some());
    assert_eq!(bench.driver.health().initialisations, 1);
}

#[test]
fn another_chip_is_refused() {
    let mut bench = Bench::new(CONFIG, LEVEL);
    // After the reset, which restores it.
    bench.poll().unwrap();
    *bench.driver.bus_mut().chip.register_mut(0x75) = 0x68;
    assert_eq!(bench.poll(), Err(SensorError::WrongDevice));
    bench.assert_recovers();
}
