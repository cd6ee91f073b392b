//! All chips at once, as the flight computer polls them: in a climb, through either barometer.
#![allow(clippy::unwrap_used, clippy::panic)]

use chip_models::bmp390::{Bmp390Model, Trimming};
use chip_models::bus::{ChipOnBus, WireFault};
use chip_models::icm42688p::Icm42688pModel;
use chip_models::ms5611::{EXAMPLE_CALIBRATION, Ms5611Model};
use chip_models::source::{Air, Motion};
use chip_models::ublox::{ReceiverModel, Solution};
use drivers::bmp390::Bmp390;
use drivers::icm42688p::{AccelRange, GyroRange, Icm42688p, Mounting};
use drivers::ms5611::Ms5611;
use drivers::ublox::{Datum, Ublox};
use drivers::{Barometer, Faults, Replay, ReplayUmbilical, SensorError, Sensors, Suite, VehicleState};
use kf_core::input::{BaroReading, TickInput};

const TICK_US: u64 = 5_000;

fn seconds(time_us: u64) -> f32 {
    time_us as f32 * 1e-6
}

/// 5 m/s up from 1000 m: about 57 Pa/s; half a degree a minute colder.
fn air(time_us: u64) -> Air {
    Air { pressure_pa: 89_875.0 - 57.0 * seconds(time_us), temperature_c: 31.0 - seconds(time_us) / 120.0 }
}

fn motion(time_us: u64) -> Motion {
    Motion {
        accel_mps2: [0.5, -0.25, -9.8],
        gyro_radps: [0.01 * seconds(time_us), 0.0, -0.1],
        temperature_c: 35.0,
    }
}

fn solution(time_us: u64) -> Option<Solution> {
    Some(Solution {
        ellipsoid_m: 1_047.0 + 5.0 * seconds(time_us),
        mean_sea_level_m: 1_000.0 + 5.0 * seconds(time_us),
        velocity_ned_mps: [30.0, 0.0, -5.0],
        vertical_accuracy_m: 1.5,
        speed_accuracy_mps: 0.2,
        satellites: 21,
        fix_type: 3,
    })
}

/// Ten seconds of a flight with a barometer whose time is set by this function.
fn fly<Baro: Barometer>(barometer: Baro, set_time: impl Fn(&mut Baro, u64)) -> (Vec<TickInput>, Faults) {
    let imu_config = drivers::icm42688p::Config {
        accel_range: AccelRange::G16,
        gyro_range: GyroRange::Dps2000,
        mounting: Mounting::ALIGNED,
    };
    let gps_config = drivers::ublox::Config { datum: Datum::MeanSeaLevel, period_ms: 100, baud: 115_200 };
    let mut suite = Suite::new(
        Ublox::new(ReceiverModel::new(9, 115_200, solution), gps_config),
        barometer,
        Icm42688p::new(ChipOnBus::new(Icm42688pModel::new(motion)), imu_config),
        Replay::<f32>::new(),
        Replay::<f32>::new(),
        Replay::<VehicleState>::new(),
        ReplayUmbilical::new(),
    );
    let inputs = (1..=2_000u64)
        .map(|tick| {
            let now_us = tick * TICK_US;
            set_time(&mut suite.barometer, now_us);
            suite.imu.bus_mut().set_time(now_us);
            suite.receiver.port_mut().set_time(now_us);
            suite.poll(now_us)
        })
        .collect();
    (inputs, suite.faults())
}

/// From the third second on, checks how many samples of each came, and that each equals its source at the
/// time at which the chip sampled it.
fn check(inputs: &[TickInput], baro_rate_hz: f32, baro_delay_us: u64) {
    let (mut baros, mut imus, mut fixes) = (0, 0, 0);
    for input in inputs.iter().filter(|input| input.time_us > 2_000_000) {
        if let Some(BaroReading::PressurePa(pressure)) = input.baro {
            baros += 1;
            let taken = air(input.time_us - baro_delay_us);
            // Half a tick either way of 57 Pa/s, and the chip's quantum.
            assert!((pressure - taken.pressure_pa).abs() < 0.16 + 0.03, "{pressure} {taken:?}");
            assert!((input.signals.baro_temperature_c.unwrap() - taken.temperature_c).abs() < 0.002);
        }
        if let Some(imu) = input.imu {
            imus += 1;
            assert!((imu.gyro_radps[0] - 0.01 * seconds(input.time_us)).abs() < 0.000_6 + 1e-5);
            assert!((imu.accel_mps2[2] + 9.8).abs() < 0.003);
        }
        if let Some(fix) = input.gps {
            fixes += 1;
            let taken_us = fix.fix_time_us.unwrap() - 200_000_000_000;
            assert!((fix.altitude_m - solution(taken_us).unwrap().mean_sea_level_m).abs() < 0.001);
            assert!(input.time_us - taken_us < 50_000 + 9_000 + TICK_US);
        }
    }
    assert_eq!((imus, fixes), (1_600, 80));
    assert!((baros as f32 / 8.0 - baro_rate_hz).abs() < 1.0, "{baros}");
}

#[test]
fn the_chips_of_the_board() {
    let barometer = Ms5611::new(ChipOnBus::new(Ms5611Model::new(EXAMPLE_CALIBRATION, air)));
    let (inputs, faults) = fly(barometer, |barometer, now_us| barometer.bus_mut().set_time(now_us));
    assert_eq!(faults, Faults::default());
    // A conversion is read two ticks after it began; it shows the air at its middle.
    check(&inputs, 87.5, 10_000 - 4_520);
}

#[test]
fn the_other_barometer() {
    let barometer = Bmp390::new(ChipOnBus::new(Bmp390Model::new(Trimming::REAL, air)));
    let (inputs, faults) = fly(barometer, |barometer, now_us| barometer.bus_mut().set_time(now_us));
    assert_eq!(faults, Faults::default());
    // A conversion is 19 ms long and read at the next tick.
    check(&inputs, 50.0, 9_480 + TICK_US / 2);
}

/// A barometer with a dead line costs the other sensors nothing.
#[test]
fn a_dead_barometer_alone() {
    let mut bus = ChipOnBus::new(Ms5611Model::new(EXAMPLE_CALIBRATION, air));
    bus.fault = Some(WireFault::StuckHigh);
    let barometer = Ms5611::new(bus);
    let (inputs, faults) = fly(barometer, |barometer, now_us| barometer.bus_mut().set_time(now_us));
    assert_eq!(faults.last, Some(SensorError::StuckBus));
    assert!(inputs.iter().all(|input| input.baro.is_none()));
    let count = |has: fn(&TickInput) -> bool| inputs[400..].iter().filter(|input| has(input)).count();
    assert_eq!((count(|input| input.imu.is_some()), count(|input| input.gps.is_some())), (1_600, 80));
}
