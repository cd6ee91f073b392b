//! The ICM-42688-P driver against the chip's model.
#![allow(clippy::unwrap_used, clippy::panic)]

mod bench;

use bench::{Bench, Driver, TICK_US};
use chip_models::bus::{ChipOnBus, WireFault};
use chip_models::icm42688p::Icm42688pModel;
use chip_models::source::{Held, Motion};
use chip_models::vibration::Vibration;
use drivers::icm42688p::{AccelRange, Config, GyroRange, Icm42688p, MAX_POLL_BYTES, Mounting};
use drivers::{InertialUnit, SensorError};
use embedded_hal::spi::{Operation, SpiDevice};
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

    /// A correct sample every tick again within a quarter of a second.
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
    /// For every range, what goes in comes out within half a count.
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

/// A reset in flight costs as much as a start: the driver does not wait before it resets the chip again.
#[test]
fn after_a_reset_in_flight_samples_come_as_soon_as_after_a_start() {
    let polls_to_a_sample = |bench: &mut Bench<Chip>| (1..).find(|_| bench.poll().unwrap().is_some());
    let mut bench = Bench::new(CONFIG, LEVEL);
    let from_start = polls_to_a_sample(&mut bench);
    bench.driver.bus_mut().power_dip();
    assert_eq!(bench.next_error(1), SensorError::ConfigurationLost);
    assert_eq!(polls_to_a_sample(&mut bench), from_start);
}

/// Bytes of a poll: address and burst, and address and configuration.
const BURST_BYTES: u32 = 18;
const CONFIGURED: u32 = 8;

/// A bit that flips while the configuration is read back costs no sample, let alone a reset.
#[test]
fn a_flipped_read_back_costs_nothing() {
    for byte in 0..CONFIGURED {
        for bit in 0..8 {
            let mut bench = Bench::running();
            bench.driver.bus_mut().fault =
                Some(WireFault::FlipBits { after_bytes: BURST_BYTES + 1 + byte, mask: 1 << bit });
            for _ in 0..20 {
                assert!(bench.poll().unwrap().is_some(), "byte {byte}, bit {bit}");
            }
            let health = bench.driver.health();
            assert_eq!((health.asked_again, health.errors, health.initialisations), (1, 0, 1));
        }
    }
}

/// Nor does a flipped bit that reports a reset of the chip.
#[test]
fn a_flipped_status_costs_nothing() {
    let mut bench = Bench::running();
    bench.driver.bus_mut().fault = Some(WireFault::FlipBits { after_bytes: BURST_BYTES - 1, mask: 0x10 });
    for _ in 0..20 {
        assert!(bench.poll().unwrap().is_some());
    }
    assert_eq!((bench.driver.health().asked_again, bench.driver.health().initialisations), (1, 1));
}

/// A bit that flips in the chip: no sample made with it is used, one sample is lost, and the register is
/// written again.
#[test]
fn a_register_that_changes_costs_one_sample() {
    for register in 0x4C..=0x53u8 {
        for bit in 0..8 {
            let mut bench = Bench::running();
            *bench.driver.bus_mut().chip.register_mut(register) ^= 1 << bit;
            assert_eq!(bench.poll(), Err(SensorError::ConfigurationLost), "{register:#x}, bit {bit}");
            // Sensors that were switched off start again: 45 ms.
            let switched_off = register == 0x4E && bit < 4;
            let polls = (1..).find(|_| bench.poll().unwrap().is_some()).unwrap();
            assert!(polls <= if switched_off { 12 } else { 1 }, "{register:#x}, bit {bit}: {polls}");
            bench.assert_recovers();
            assert_eq!(bench.driver.health().initialisations, 1);
        }
    }
}

/// All registers at once.
#[test]
fn several_registers_that_change_are_mended_at_once() {
    let mut bench = Bench::running();
    for register in 0x4C..=0x53u8 {
        *bench.driver.bus_mut().chip.register_mut(register) ^= 0x03;
    }
    assert_eq!(bench.next_error(1), SensorError::ConfigurationLost);
    // The board's wait for the bus is derived from this bound, so the bound must be exact.
    assert_eq!(bench.most_moved, MAX_POLL_BYTES);
    bench.assert_recovers();
    assert_eq!(bench.driver.health().initialisations, 1);
}

/// A flipped bank, which has nothing to read.
#[test]
fn another_bank_is_left() {
    let mut bench = Bench::running();
    *bench.driver.bus_mut().chip.register_mut(0x76) = 2;
    assert_eq!(bench.next_error(1), SensorError::StuckBus);
    assert!(bench.poll().unwrap().is_some());
}

/// A fault of the wires of less than 0.2 s does not make the driver reset the chip, and the chip's next
/// answer is a sample.
#[test]
fn a_short_fault_of_the_wires_costs_what_it_lasts() {
    for fault in [WireFault::StuckLow, WireFault::StuckHigh, WireFault::BusError] {
        let mut bench = Bench::running();
        bench.driver.bus_mut().fault = Some(fault);
        for _ in 0..39 {
            assert!(bench.poll().is_err());
        }
        bench.driver.bus_mut().fault = None;
        assert!(bench.poll().unwrap().is_some(), "{fault:?}");
        assert_eq!(bench.driver.health().initialisations, 1);
    }
}

/// Noise can look like anything: any bit of the configuration, or a reset. Samples are correct within half a
/// second after it.
#[test]
fn noise_on_the_wires_is_left_behind() {
    for seed in 0..200 {
        let mut bench = Bench::running();
        bench.driver.bus_mut().fault = Some(WireFault::Garbage { noise: seed });
        for _ in 0..1 + seed {
            let _ = bench.poll();
        }
        bench.assert_recovers();
    }
}

/// Effect of a vibration of 10 m/s^2 on the vertical axis that a 200 Hz tick has folded to a tenth of a
/// hertz, with a driver's settings of the registers from 0x4F on: its amplitude at the ticks, and the
/// altitude error in 25 s, integrated twice from rest.
fn folded(registers: [u8; 5], frequency_mhz: u32) -> (f32, f32) {
    let mut chip = Icm42688pModel::new(Held(LEVEL));
    chip.vibration = Some(Vibration { channel: 2, frequency_mhz, amplitude: 10.0 });
    let mut bus = ChipOnBus::new(chip);
    bus.set_time(10_000);
    for (register, value) in (0x4F..).zip(registers) {
        bus.write(&[register, value]).unwrap();
    }
    bus.write(&[0x4E, 0x0F]).unwrap();
    let (mut largest, mut velocity, mut altitude, mut farthest) = (0.0f32, 0.0, 0.0f32, 0.0f32);
    for tick in 20..5_020u64 {
        bus.set_time(tick * TICK_US);
        let mut answer = [0; 2];
        bus.transaction(&mut [Operation::Write(&[0x80 | 0x23]), Operation::Read(&mut answer)]).unwrap();
        let accel = f32::from(i16::from_be_bytes(answer)) * (16.0 * 9.806_65 / 32_768.0) + 9.806_65;
        largest = largest.max(accel.abs());
        velocity += accel * 0.005;
        altitude += velocity * 0.005;
        farthest = farthest.max(altitude.abs());
    }
    (largest, farthest)
}

/// The filter that the driver sets against the earlier one, 100 Hz of second order.
#[test]
fn vibration_near_the_ticks_rate_is_kept_from_folding_to_zero() {
    let mut bench = Bench::running();
    let set =
        [0x4F, 0x50, 0x51, 0x52, 0x53].map(|register| *bench.driver.bus_mut().chip.register_mut(register));
    let before = [0x06, 0x06, 0x16, 0x44, 0x0D];
    for frequency_mhz in [200_100, 199_900, 400_100] {
        let (was, was_m) = folded(before, frequency_mhz);
        let (is, is_m) = folded(set, frequency_mhz);
        // Of 10 m/s^2, 2.4 remained at 200 Hz before and 0.02 now (a Butterworth of third order: 8^-3); 5
        // mm/s^2 is a count.
        assert!(is < 0.02 + 0.005, "{frequency_mhz}: {is}");
        assert!(was > 0.6, "{frequency_mhz}: {was}");
        // Integrated twice from rest, 0.1 Hz with amplitude a drifts at a / (2 pi 0.1) m/s: 40 a metres in 25
        // s.
        assert!(is_m < 1.3 && was_m > 20.0, "{frequency_mhz}: {was_m} m before, {is_m} m now");
        println!("{frequency_mhz} mHz: {was} m/s^2 and {was_m} m before, {is} m/s^2 and {is_m} m now");
    }
    // A UAV's own motion passes: 2 Hz to a third of a thousandth.
    assert!((folded(set, 2_000).0 - 10.0).abs() < 0.02);
}

#[test]
fn a_chip_that_makes_no_samples_is_stale() {
    let mut bench = Bench::running();
    bench.driver.bus_mut().chip.stalled = true;
    let polls = (1..).find(|_| bench.poll().is_err()).unwrap();
    // 20 ms and one tick; and no old sample was delivered as a new one.
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
    // After the reset, which restores the identity.
    bench.poll().unwrap();
    *bench.driver.bus_mut().chip.register_mut(0x75) = 0x68;
    assert_eq!(bench.poll(), Err(SensorError::WrongDevice));
    bench.assert_recovers();
}
