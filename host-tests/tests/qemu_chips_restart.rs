//! Chips that fail before, while and after the emulated flight computer restarts in free flight. In all cases
//! it resumes with its latch; dead chips are counted and silent, the others are monitored, and each recovers.
//!
//! Needs qemu-system-arm and the Rust target; without them the tests fail and say what to install
//! (`cargo xtask test` installs it).
#![allow(clippy::unwrap_used, clippy::panic)]

mod restarts;
mod ticks;

use flight_record::{Blow, ExitStatus, Strike, TickRecord};
use kf_core::input::{BaroReading, TickInput};
use kf_core::output::{Phase, SensorOutput, Trust};
use pylon::fly::{FlyOptions, PlannedFault, RawFlight, SensorSource, fly_on_host, fly_struck_on_chips};

use restarts::{at, model, resumed};
use ticks::{LAUNCH, flight, must};

/// The tick at which the reset strikes: 24.5 s. The first one after it is at 24.6 s.
const STRUCK: usize = LAUNCH + 700;
const BACK_S: f64 = 24.6;
/// Time from a fault's end, or the restart, until a sensor has recovered: an initialisation takes a tenth of
/// that.
const RECOVERY_S: f64 = 1.2;
const SLAVE: usize = 1;
const BARO: usize = 2;

/// The flight without the errors of its free part, so that it raises no lasting flag.
fn sound() -> Vec<TickInput> {
    let mut inputs = flight();
    for (k, input) in inputs.iter_mut().enumerate().skip(LAUNCH) {
        let free_s = (k - LAUNCH) as f32 * 0.005;
        let airspeed_mps = 60.0 + 4.0 * free_s;
        let error_m = 0.04 * (airspeed_mps * airspeed_mps - 3_600.0) / 19.6;
        input.baro = input.baro.map(|reading| match reading {
            BaroReading::PressurePa(pressure_pa) => BaroReading::PressurePa(pressure_pa + 9.87 * error_m),
            other => other,
        });
        input.imu_slave_altitude_m =
            input.imu_slave_altitude_m.map(|altitude_m| altitude_m - free_s * free_s);
    }
    // The dive has its full rate from the first tick on.
    inputs[LAUNCH].gps.as_mut().unwrap().velocity_down_mps = Some(30.0);
    inputs
}

/// A premise of the tests: without a fault and a restart no sensor is flagged.
#[test]
fn the_flight_is_sound() {
    let options = FlyOptions { sensors: SensorSource::Chips, ..FlyOptions::default() };
    let mut watched = 0;
    fly_on_host(sound().into_iter(), &model(), &options, &mut |step, _| {
        if step.output.phase == Phase::FreeFlight {
            let trusts = [SLAVE, BARO].map(|sensor| step.output.sensors[sensor].trust);
            assert_eq!(trusts, [Trust::Trusted; 2], "at {}", step.output.time_us);
            watched += 1;
        }
    })
    .unwrap();
    // Ten seconds, less what it takes to confirm the launch.
    assert!(watched > 1_800, "{watched}");
}

/// Flies with these faults and one reset.
fn fly(faults: &[&str]) -> RawFlight {
    let planned: Vec<PlannedFault> = faults.iter().map(|fault| fault.parse().unwrap()).collect();
    let strike = Strike { blow: Blow::Reset, time_us: at(STRUCK) };
    let flown = must(fly_struck_on_chips(sound().into_iter(), &model(), &planned, &[strike]));
    assert_eq!(flown.status, Some(ExitStatus::Finished), "{faults:?}: {:?}", flown.log);
    assert_eq!(flown.restarts.len(), 1, "{faults:?}: {:?}", flown.log);
    // The same latch, every tick with the host's bits, free flight from the first tick on.
    let (_, first) = resumed(&flown);
    assert_eq!(first.output.time_us, microseconds(BACK_S), "{faults:?}");
    flown
}

fn microseconds(time_s: f64) -> u64 {
    (time_s * 1e6).round() as u64
}

/// The ticks of a span of the flight.
fn span(flown: &RawFlight, from_s: f64, to_s: f64) -> impl Iterator<Item = &TickRecord> {
    let is_in = move |time_us: u64| (microseconds(from_s)..microseconds(to_s)).contains(&time_us);
    flown.ticks.iter().filter(move |tick| is_in(tick.output.time_us))
}

/// Readings delivered by each sensor in a span: barometer, inertial unit, receiver.
fn delivered(flown: &RawFlight, from_s: f64, to_s: f64) -> [usize; 3] {
    let count =
        |has: fn(&TickInput) -> bool| span(flown, from_s, to_s).filter(|tick| has(&tick.input)).count();
    [
        count(|input| input.baro.is_some()),
        count(|input| input.imu.is_some()),
        count(|input| input.gps.is_some()),
    ]
}

/// The same flight with the reset, without a fault.
fn healthy() -> &'static RawFlight {
    static HEALTHY: std::sync::OnceLock<RawFlight> = std::sync::OnceLock::new();
    HEALTHY.get_or_init(|| {
        let flown = fly(&[]);
        assert_eq!(flown.summary.as_ref().unwrap().sensor_faults, 0);
        flown
    })
}

/// A fault of one chip that ends at 28 s at the latest. It is counted after the restart, silences the chip
/// during `silent_s` if given, leaves the others unchanged, and is over when it ends.
fn check(chip: usize, fault: &str, silent_s: Option<(f64, f64)>) {
    let flown = fly(&[fault]);
    let healthy = healthy();
    let summary = flown.summary.as_ref().unwrap();
    assert!(summary.sensor_faults > 0, "{fault}: nothing counted");
    for (from_s, to_s) in [(BACK_S, 26.0), (26.0, 28.0), (28.0 + RECOVERY_S, 30.9)] {
        let (now, usual) = (delivered(&flown, from_s, to_s), delivered(healthy, from_s, to_s));
        for other in (0..3).filter(|other| *other != chip) {
            assert_eq!(now[other], usual[other], "{fault}: sensor {other} from {from_s} s on");
        }
    }
    if let Some((from_s, to_s)) = silent_s {
        assert_eq!(delivered(&flown, from_s, to_s)[chip], 0, "{fault}");
    }
    let (from_s, to_s) = (28.0 + RECOVERY_S, 30.9);
    let (again, usual) = (delivered(&flown, from_s, to_s)[chip], delivered(healthy, from_s, to_s)[chip]);
    assert!(again > 0 && again.abs_diff(usual) <= 1, "{fault}: {again} of {usual} in the end");
    // The vehicle's own unit for `imu_slave` is still read, and its error monitored; without a receiver it is
    // not judged.
    let slave = |from_s, to_s, is: fn(&SensorOutput) -> bool| {
        span(&flown, from_s, to_s).filter(|tick| is(&tick.output.sensors[SLAVE])).count()
    };
    let is_watched: fn(&SensorOutput) -> bool =
        |slave| slave.moving_average_m.is_some() && slave.trust == Trust::Trusted;
    let is_unjudged: fn(&SensorOutput) -> bool = |slave| {
        slave.error_m.is_some() && slave.moving_average_m.is_none() && slave.trust == Trust::Unmonitored
    };
    match silent_s.filter(|_| chip == 2) {
        None => assert!(slave(BACK_S, 27.0, is_watched) > 100, "{fault}"),
        Some((from_s, _)) => {
            // The climb rate of the last fix carries the altitude for less than a second.
            assert!(slave(from_s + 0.5, 27.0, is_unjudged) > 80, "{fault}");
            assert_eq!(slave(from_s + 0.5, 27.0, is_watched), 0, "{fault}");
        }
    }
    assert!(slave(28.0 + RECOVERY_S, 30.9, is_watched) > 70, "{fault}");
}

#[test]
fn a_chip_that_is_dead_when_the_flight_computer_comes_back_keeps_nothing_from_resuming() {
    for fault in ["baro stuck-low", "baro stuck-high", "baro bus-error", "baro slow=3000"] {
        check(0, &format!("{fault} 23..28"), Some((BACK_S, 28.0)));
    }
    for fault in ["imu stuck-low", "imu stuck-high", "imu bus-error", "imu stalled"] {
        check(1, &format!("{fault} 23..28"), Some((BACK_S, 28.0)));
    }
    check(2, "gps unplugged 23..28", Some((BACK_S, 28.0)));
}

/// A fault that begins while the computer is away is found at the first tick; one that ends then is not even
/// detected.
#[test]
fn a_fault_that_begins_or_ends_while_the_flight_computer_is_away_is_the_flights_not_the_restarts() {
    check(0, "baro bus-error 24.55..28", Some((BACK_S, 28.0)));
    check(1, "imu stuck-high 24.55..28", Some((BACK_S, 28.0)));
    check(2, "gps unplugged 24.55..28", Some((BACK_S + 0.1, 28.0)));
    for (chip, fault) in ["baro stuck-low", "imu stalled", "gps unplugged"].into_iter().enumerate() {
        let flown = fly(&[&format!("{fault} 23..24.55")]);
        let (from_s, to_s) = (BACK_S + RECOVERY_S, 28.0);
        let (now, usual) = (delivered(&flown, from_s, to_s)[chip], delivered(healthy(), from_s, to_s)[chip]);
        assert!(now.abs_diff(usual) <= 1, "{fault}: {now} of {usual}");
    }
}

/// A chip that lost its configuration before, while and after the flight computer was reset is set up again.
/// So is one that kept it, because the drivers cannot know that.
#[test]
fn a_chip_that_was_reset_as_well_is_set_up_again() {
    for (chip, name) in ["baro", "imu", "gps"].into_iter().enumerate() {
        for time_s in [24.2, 24.55, 24.65, 25.5] {
            let fault = format!("{name} reset {time_s}");
            let flown = fly(&[&fault]);
            let (from_s, to_s) = (25.5 + RECOVERY_S, 30.9);
            let (now, usual) = (delivered(&flown, from_s, to_s), delivered(healthy(), from_s, to_s));
            for sensor in 0..3 {
                assert!(
                    now[sensor].abs_diff(usual[sensor]) <= usize::from(sensor == chip),
                    "{fault}: {now:?} {usual:?}"
                );
            }
        }
    }
    // Whatever the drivers do takes no longer than after a power-on.
    let usual = delivered(healthy(), BACK_S + RECOVERY_S, 30.9);
    assert!(usual.iter().all(|count| *count > 25), "{usual:?}");
}

/// A receiver that kept its configuration and does not accept another.
#[test]
fn a_receiver_that_can_not_be_configured_any_more_is_counted_and_comes_back() {
    for fault in ["gps refuses 24.55..28", "gps silent 24.55..28"] {
        check(2, fault, None);
    }
}

/// The time that a sensor has been silent continues over the restart: five seconds after its last sample it
/// is no longer monitored, and the other one still is.
#[test]
fn a_barometer_that_died_before_the_restart_is_unmonitored_five_seconds_after_its_last_sample() {
    let flown = fly(&["baro stuck-low 23..30.99"]);
    assert_eq!(delivered(&flown, 23.1, 31.0)[0], 0);
    let last = flown.ticks.iter().rfind(|tick| tick.input.baro.is_some());
    let last_us = last.unwrap().input.time_us;
    for tick in span(&flown, 23.2, 31.0) {
        let expected =
            if tick.output.time_us - last_us > 5_000_000 { Trust::Unmonitored } else { Trust::Trusted };
        assert_eq!(tick.output.sensors[BARO].trust, expected, "{}", tick.output.time_us);
        assert_eq!(tick.output.sensors[SLAVE].trust, Trust::Trusted, "{}", tick.output.time_us);
    }
}

/// All chips fail at once, and for good: the latch is still there, and no sensor is reported as monitored.
#[test]
fn with_every_chip_dead_it_resumes_and_says_that_nobody_is_monitored() {
    let flown = fly(&["baro bus-error 23..30.99", "imu bus-error 23..30.99", "gps unplugged 23..30.99"]);
    assert_eq!(delivered(&flown, BACK_S, 31.0), [0, 0, 0]);
    assert!(flown.summary.as_ref().unwrap().sensor_faults > 0);
    for tick in span(&flown, 29.0, 31.0) {
        // The vehicle's own unit delivers, but has no reference to have an error from.
        assert_eq!([SLAVE, BARO].map(|sensor| tick.output.sensors[sensor].trust), [Trust::Unmonitored; 2]);
        assert!(tick.output.sensors[SLAVE].error_m.is_none());
    }
}
