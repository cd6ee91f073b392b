//! Flights on models of the sensors' chips, through their drivers, in the emulated flight computer: every
//! tick has the host's bits, the calibration matches that of ideal sensors within the chips' resolution and
//! delays, and a failing chip costs only its own samples, counted, and recovers.
//!
//! Needs qemu-system-arm and the Rust target; without them the tests fail and say what to install
//! (`cargo xtask test` installs it).
#![allow(clippy::unwrap_used, clippy::panic)]

mod ticks;

use std::path::Path;

use flight_computer::Step;
use host_tests::budget::Budgets;
use kf_core::input::{BaroReading, ImuSample, TickInput};
use kf_core::output::{Rejection, Trust};
use kf_core::quality::{Check, FailedChecks};
use model::Model;
use pylon::fly::{FlyOptions, FlyReport, PlannedFault, SensorSource, fly, fly_inputs, fly_on_host};
use pylon::replay::Replay;
use pylon::simulate::{load_scenario, simulate};

use ticks::{LAUNCH, TICK_US, TICKS, flight, must, prompt};

const BARO: usize = 2;
/// The first tick of [`flight`], seconds.
const START_S: f64 = 1.0;

fn on_chips(faults: &[&str]) -> FlyOptions {
    FlyOptions {
        sensors: SensorSource::Chips,
        faults: faults.iter().map(|fault| fault.parse::<PlannedFault>().unwrap()).collect(),
        ..FlyOptions::default()
    }
}

/// A bundled flight, with the model that it is meant for.
fn bundled(name: &str, model: &Model) -> FlyReport {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../flights").join(name);
    let scenario = load_scenario(&file).unwrap();
    let (flight, _) = simulate(&scenario, scenario.seed).unwrap();
    let replay = Replay::new(&flight, model, None).unwrap();
    must(fly(&replay, &on_chips(&[])))
}

/// Requirements for every healthy flight on chips.
fn check_healthy(name: &str, report: &FlyReport) {
    let chips = report.chips.as_ref().unwrap();
    assert_eq!(report.sensor_faults, 0, "{name}");
    assert_eq!((chips.grid.late_rows, chips.grid.superseded_samples), (0, 0), "{name}: {chips:?}");
    let latch = report.latch.as_ref().unwrap();
    assert!(latch.sensors.iter().all(|sensor| sensor.readings > 1_000), "{name}: {latch:?}");
    let agreement = chips.agreement.as_ref().unwrap();
    assert_eq!(agreement.sensors.len(), 3, "{name}");
    for sensor in &agreement.sensors {
        println!("{name}: {sensor:?}, difference {:+.4} m", sensor.difference_m());
        assert!(sensor.is_within_bound(), "{name}: {sensor:?}, difference {}", sensor.difference_m());
    }
    let budgets = Budgets::read().unwrap();
    let unexpected = budgets.unexpected(&budgets.check_flight(name, report));
    assert!(unexpected.is_empty(), "{unexpected:#?}");
    // The compared ticks are ones in which the drivers had work to do.
    for part in &report.parts {
        assert!(part.instructions_mean > 10.0, "{name}: {part:?}");
    }
}

/// `one-hour.toml` is left out: it is captive flight for a benchmark, and the others have two minutes each of
/// that.
#[test]
fn bundled_flights_have_the_hosts_bits_and_the_ideal_sensors_calibration() {
    for name in ["quickstart.toml", "clean.toml", "hidden-static-port.toml", "hidden-static-port-second.toml"]
    {
        check_healthy(name, &bundled(name, &Model::default()));
    }
}

/// A fix in every row, 200 a second, and noise of tens of metres.
#[test]
fn the_papers_flight_has_the_hosts_bits_and_the_ideal_sensors_calibration() {
    check_healthy("paper-reconstruction.toml", &bundled("paper-reconstruction.toml", &Model::paper()));
}

/// A level flight without noise: only quantisation is left.
#[test]
fn without_noise_the_calibration_is_the_ideal_one_to_the_quantum() {
    let inputs = flight().into_iter().enumerate().map(|(k, input)| TickInput {
        gps: input.gps.map(|mut fix| {
            // To a millimetre: a receiver that repeats every bit of its fixes is stuck.
            fix.altitude_m = 2_000.0 + (k / 20 % 2) as f32 / 1_000.0;
            // The vehicle then falls; otherwise nothing distinguishes a launch from a torn cable.
            fix.velocity_down_mps = Some(if k >= LAUNCH { 30.0 } else { 0.0 });
            fix
        }),
        // Not quite constant, or it would count as stuck.
        baro: input.baro.map(|_| BaroReading::PressurePa(79_495.0 + (k % 8) as f32 / 128.0)),
        imu_master_altitude_m: input.imu_master_altitude_m.map(|_| 2_012.0 + (k % 8) as f32 / 1_024.0),
        imu_slave_altitude_m: input.imu_slave_altitude_m.map(|_| 1_927.0 + (k % 8) as f32 / 1_024.0),
        ..input
    });
    let report = must(fly_inputs(inputs, &prompt(Model::default()), &on_chips(&[])));
    for sensor in report.chips.unwrap().agreement.unwrap().sensors {
        // 0.04 Pa at 79.5 kPa are 4 mm, f32's rounding 10 mm, and the steps above 6 mm.
        assert!(sensor.difference_m().abs() < 0.02, "{sensor:?}");
        assert!(sensor.bound_m < 0.05, "a bound that bounds nothing: {sensor:?}");
    }
}

/// Values beyond a chip's range and invalid values: counted as errors of the driver, never a sample.
#[test]
fn what_a_chip_can_not_measure_is_counted_and_becomes_no_sample() {
    let inputs: Vec<TickInput> = flight()
        .into_iter()
        .enumerate()
        .map(|(k, mut input)| {
            match k {
                1_000..1_100 => input.baro = Some(BaroReading::PressurePa(500.0)),
                2_000..2_100 => {
                    input.imu = Some(ImuSample { accel_mps2: [0.0, 0.0, -200.0], gyro_radps: [0.0; 3] });
                }
                3_000..3_010 => input.imu_master_altitude_m = Some(f32::NAN),
                _ => {}
            }
            input
        })
        .collect();
    let model = prompt(Model::default());
    let report = must(fly_inputs(inputs.iter().copied(), &model, &on_chips(&[])));
    let truth = report.chips.unwrap().truth;
    assert_eq!((truth.baro_beyond_range, truth.imu_beyond_range, truth.not_finite), (100, 100, 10));
    assert!(report.sensor_faults >= 100, "{}", report.sensor_faults);
    let mut beyond = 0;
    fly_on_host(inputs.iter().copied(), &model, &on_chips(&[]), &mut |step, _| {
        let baro = matches!(step.input.baro, Some(BaroReading::PressurePa(pressure)) if pressure < 1_000.0);
        let imu = step.input.imu.is_some_and(|imu| imu.accel_mps2[2] < -16.0 * 9.806_65);
        beyond += u32::from(baro || imu);
    })
    .unwrap();
    assert_eq!(beyond, 0);
}

/// Readings delivered by each sensor in a span of the flight, in ticks: barometer, inertial unit, receiver,
/// umbilical.
fn delivered(steps: &[(Step, u32)], from_s: f64, to_s: f64) -> [usize; 4] {
    let span = span(steps, from_s, to_s);
    let count = |has: fn(&TickInput) -> bool| span.iter().filter(|(step, _)| has(&step.input)).count();
    [
        count(|input| input.baro.is_some()),
        count(|input| input.imu.is_some()),
        count(|input| input.gps.is_some()),
        count(|input| input.imu_master_altitude_m.is_some()),
    ]
}

fn span(steps: &[(Step, u32)], from_s: f64, to_s: f64) -> &[(Step, u32)] {
    let tick = |time_s: f64| ((time_s - START_S) * 1e6) as usize / TICK_US as usize;
    &steps[tick(from_s)..tick(to_s)]
}

/// Flies with these faults: the target has the host's bits; the host's steps are returned.
fn fly_with(faults: &[&str]) -> Vec<(Step, u32)> {
    fly_inputs_with(&flight(), faults)
}

fn fly_inputs_with(inputs: &[TickInput], faults: &[&str]) -> Vec<(Step, u32)> {
    let model = prompt(Model::default());
    let options = on_chips(faults);
    let report = must(fly_inputs(inputs.iter().copied(), &model, &options));
    let mut steps = Vec::new();
    let count = fly_on_host(inputs.iter().copied(), &model, &options, &mut |step, count| {
        steps.push((step.clone(), count));
    });
    assert_eq!(count.unwrap(), report.sensor_faults, "{faults:?}");
    assert_eq!(steps.len(), TICKS, "{faults:?}");
    // Whatever fails, the latch is of the tick at which the wire opened.
    assert_eq!(report.latch.as_ref().unwrap().time_us, 1_000_000 + LAUNCH as u64 * TICK_US, "{faults:?}");
    // Either the mother ship's messages, ten a second, must be missing five times, or there is no evidence
    // for three seconds.
    let confirmed = steps.iter().position(|(step, _)| step.output.latched_now);
    assert!(
        confirmed.is_some_and(|at| (LAUNCH + 4..LAUNCH + 620).contains(&at)),
        "{faults:?}: {confirmed:?}"
    );
    assert!(steps.iter().all(|(step, _)| step.output.altitude_m.is_finite()), "{faults:?}");
    steps
}

/// Captive flight, launch (at 21 s) and free flight; the flight ends at 31 s.
const PHASES: [(f64, f64); 3] = [(8.0, 11.0), (20.5, 22.5), (24.0, 27.0)];
/// Time from a fault's end until the sensor has recovered: an initialisation takes a tenth of that.
const RECOVERY_S: f64 = 1.2;

/// A fault of one chip in each phase. It is counted each time, the other sensors' samples are as without it,
/// and its own recover afterwards.
fn check_in_each_phase(chip: usize, fault: &str, silences: bool) {
    let planned: Vec<String> = PHASES.iter().map(|(start, end)| format!("{fault} {start}..{end}")).collect();
    check(chip, &planned, silences);
}

/// As [`check_in_each_phase`], for one that happens once.
fn check_once_in_each_phase(chip: usize, fault: &str) {
    let planned: Vec<String> = PHASES.iter().map(|(start, _)| format!("{fault} {start}")).collect();
    check(chip, &planned, false);
}

fn check(chip: usize, planned: &[String], silences: bool) {
    let faults: Vec<&str> = planned.iter().map(String::as_str).collect();
    let steps = fly_with(&faults);
    let healthy = healthy();
    for (start_s, end_s) in PHASES {
        let counts = |time_s: f64| span(&steps, time_s, time_s + 0.01)[0].1;
        assert!(counts(end_s) > counts(start_s - 0.1), "{faults:?}: nothing counted at {start_s} s");
        let (during, usual) = (delivered(&steps, start_s, end_s), delivered(healthy, start_s, end_s));
        for other in (0..4).filter(|other| *other != chip) {
            assert_eq!(during[other], usual[other], "{faults:?}: sensor {other} at {start_s} s");
        }
        if silences {
            // Except the first tenth of a second: data in transit when the fault began.
            assert_eq!(delivered(&steps, start_s + 0.1, end_s)[chip], 0, "{faults:?}: at {start_s} s");
        }
        if chip != 3 || end_s < 21.0 {
            let again = delivered(&steps, end_s + RECOVERY_S, end_s + RECOVERY_S + 0.2)[chip];
            let usual = delivered(healthy, end_s + RECOVERY_S, end_s + RECOVERY_S + 0.2)[chip];
            assert!(
                again > 0 && again.abs_diff(usual) <= 1,
                "{faults:?}: {again} of {usual} after {end_s} s"
            );
        }
        // And no further faults are counted.
        assert_eq!(counts(end_s + RECOVERY_S), counts((end_s + 1.4).min(30.9)), "{faults:?} after {end_s} s");
    }
}

/// The same flight without a fault.
fn healthy() -> &'static [(Step, u32)] {
    static HEALTHY: std::sync::OnceLock<Vec<(Step, u32)>> = std::sync::OnceLock::new();
    HEALTHY.get_or_init(|| {
        let steps = fly_with(&[]);
        assert_eq!(steps.last().unwrap().1, 0);
        steps
    })
}

#[test]
fn a_barometer_that_fails_in_any_phase_is_counted_and_comes_back() {
    for fault in ["baro stuck-low", "baro stuck-high", "baro bus-error", "baro slow=3000"] {
        check_in_each_phase(0, fault, true);
    }
    for fault in ["baro reset", "baro flip-bits=0x80"] {
        // A flipped bit is detected only where it leaves the range: see onboard/chip-models/tests/ms5611.rs.
        let counted = fault == "baro reset";
        if counted {
            check_once_in_each_phase(0, fault);
        } else {
            fly_with(&["baro flip-bits=0x80 8", "baro flip-bits=0x80 21", "baro flip-bits=0x80 25"]);
        }
    }
}

#[test]
fn an_inertial_unit_that_fails_in_any_phase_is_counted_and_comes_back() {
    for fault in ["imu stuck-low", "imu stuck-high", "imu bus-error", "imu stalled"] {
        check_in_each_phase(1, fault, true);
    }
    check_once_in_each_phase(1, "imu reset");
    // The chip sends no checksum of its data: a flipped bit passes, and must harm nothing else.
    fly_with(&["imu flip-bits=0x80 8", "imu flip-bits=0x80 21", "imu flip-bits=0x80 25"]);
}

#[test]
fn a_receiver_that_fails_in_any_phase_is_counted_and_comes_back() {
    check_in_each_phase(2, "gps unplugged", true);
    check_once_in_each_phase(2, "gps reset");
    fly_with(&["gps lose-bytes=30 8", "gps lose-bytes=30 21", "gps lose-bytes=30 25"]);
    fly_with(&["gps flip-bits=0x10 8", "gps flip-bits=0x10 21", "gps flip-bits=0x10 25"]);
}

#[test]
fn a_receiver_that_can_not_be_configured_at_first_is_counted_and_comes_back() {
    for fault in ["gps refuses 1..6", "gps silent 1..6"] {
        let steps = fly_with(&[fault]);
        assert!(span(&steps, 6.0, 6.1)[0].1 > 0, "{fault}");
        assert_eq!(delivered(&steps, 9.0, 12.0)[2], delivered(healthy(), 9.0, 12.0)[2], "{fault}");
    }
}

/// Its registers answer, but its measurement no longer changes: a driver cannot detect that; the mission
/// does, after two seconds.
#[test]
fn a_barometer_that_repeats_itself_is_rejected_and_counted_in_every_phase() {
    for (start_s, end_s) in [(8.0, 12.0), (18.0, 24.0), (24.0, 29.0)] {
        let inputs: Vec<TickInput> = flight()
            .into_iter()
            .map(|input| {
                let time_s = input.time_us as f64 * 1e-6;
                let frozen = (start_s..end_s).contains(&time_s);
                let baro =
                    input.baro.map(|baro| if frozen { BaroReading::PressurePa(79_300.0) } else { baro });
                TickInput { baro, ..input }
            })
            .collect();
        let steps = fly_inputs_with(&inputs, &[]);
        let of_baro = |(step, _): &&(Step, u32)| step.input.baro.is_some();
        let rejected =
            |(step, _): &(Step, u32)| step.output.sensors[BARO].rejection == Some(Rejection::Stuck);
        // Two seconds of one value, and data in transit when it began.
        let early = span(&steps, 1.0, start_s + 2.0);
        assert!(!early.iter().any(rejected), "{start_s}");
        let late = span(&steps, start_s + 2.2, end_s);
        assert!(late.iter().filter(of_baro).count() > 40, "{start_s}");
        assert!(late.iter().filter(of_baro).all(rejected), "{start_s}");
        let after = span(&steps, end_s + 0.2, 31.0);
        assert!(!after.iter().any(rejected), "{start_s}");
        // The calibration reports it; a stuck sensor is neither monitored nor trusted because of it.
        let latched = steps.iter().find(|(step, _)| step.output.latched_now).unwrap();
        let failed = FailedChecks::from_bits(latched.0.output.failed_checks);
        assert_eq!(failed.contains(Check::SensorsAlive), start_s < 20.0, "{start_s}");
    }
}

/// [`flight`] with the three seconds of free fall that it takes to reach its rate of descent: without a
/// receiver nothing else distinguishes a launch from a torn cable.
fn falling_flight() -> impl Iterator<Item = TickInput> {
    flight().into_iter().enumerate().map(|(k, mut input)| {
        if let Some(imu) = &mut input.imu
            && (LAUNCH..LAUNCH + 600).contains(&k)
        {
            imu.accel_mps2[2] += 9.8;
        }
        input
    })
}

/// While no sensor is monitored, the two that fly free are compared with each other.
#[test]
fn without_a_receiver_barometer_and_inertial_altitude_are_checked_against_each_other() {
    let cross_checks = |offset_pa: f32| {
        let inputs: Vec<TickInput> = falling_flight()
            .map(|input| {
                let is_off = input.time_us > 26_000_000;
                let baro = input.baro.map(|baro| match baro {
                    BaroReading::PressurePa(pressure) if is_off => {
                        BaroReading::PressurePa(pressure + offset_pa)
                    }
                    other => other,
                });
                TickInput { baro, ..input }
            })
            .collect();
        let steps = fly_inputs_with(&inputs, &["gps unplugged 17..31"]);
        // From the launch on: an altitude extrapolated with a climb rate from four seconds ago judges no
        // sensor.
        assert!(span(&steps, 1.0, 21.0).iter().all(|(step, _)| step.output.cross_check.is_none()));
        let at = |from_s: f64, to_s: f64| {
            let checks: Vec<_> = span(&steps, from_s, to_s)
                .iter()
                .filter_map(|(step, _)| step.output.cross_check)
                .map(|check| check.difference_m)
                .collect();
            assert!(checks.len() > 10, "{from_s}");
            checks.iter().sum::<f32>() / checks.len() as f32
        };
        at(26.5, 30.0) - at(23.0, 25.5)
    };
    // 500 Pa are 51 m of altitude at 79 kPa, whatever other difference the two have.
    let moved_m = cross_checks(500.0) - cross_checks(0.0);
    assert!((moved_m + 51.0).abs() < 2.0, "{moved_m}");
}

/// At launch the receiver has been away for longer than a reference may be: no sensor is monitored, and that
/// is reported; monitoring begins with the fixes. The wire, the messages and the free fall show the launch.
#[test]
fn without_a_receiver_in_free_flight_nobody_is_monitored_until_it_is_back() {
    let inputs: Vec<TickInput> = falling_flight().collect();
    let steps = fly_inputs_with(&inputs, &["gps unplugged 15..27"]);
    let trusts = |time_s: f64| {
        let (step, _) = &span(&steps, time_s, time_s + 0.01)[0];
        [1, BARO].map(|sensor| step.output.sensors[sensor].trust)
    };
    for time_s in [24.2, 25.5, 26.9] {
        assert_eq!(trusts(time_s), [Trust::Unmonitored; 2], "{time_s}");
    }
    assert!(trusts(28.5).iter().all(|trust| *trust != Trust::Unmonitored));
}

/// Silence before launch is a fault; from launch on it is not.
#[test]
fn an_umbilical_that_is_cut_is_counted_in_captive_flight_and_expected_at_launch() {
    let steps = fly_with(&["umbilical unplugged 8..12"]);
    assert_eq!(delivered(&steps, 8.1, 12.0)[3], 0);
    // One fault counted a second.
    assert_eq!(span(&steps, 12.0, 12.1)[0].1, 3);
    assert!(delivered(&steps, 13.0, 14.0)[3] > 45);
    assert_eq!(delivered(&steps, 21.0, 31.0)[3], 0);
    assert_eq!(steps.last().unwrap().1, 3, "nothing is counted after launch");
    for fault in ["umbilical lose-bytes=30 8", "umbilical flip-bits=0x10 8"] {
        let steps = fly_with(&[fault]);
        assert!(steps.last().unwrap().1 <= 1, "{fault}");
        assert!(delivered(&steps, 9.0, 10.0)[3] > 45, "{fault}");
    }
}

/// The comparison detects an error that only the drivers could have made.
#[test]
fn one_unit_in_the_last_place_behind_the_drivers_is_found() {
    let options = FlyOptions { host_ulp_error: true, ..on_chips(&[]) };
    let error = fly_inputs(flight().into_iter(), &prompt(Model::default()), &options).unwrap_err();
    assert!(error.to_string().contains("input.baro"), "{error}");
}

#[test]
fn faults_that_can_not_be_are_refused_in_one_line() {
    let model = Model::default();
    let fly =
        |options: &FlyOptions| fly_inputs(flight().into_iter(), &model, options).unwrap_err().to_string();
    let outside = fly(&on_chips(&["baro reset 99"]));
    assert!(outside.contains("fault at 99 s, and the flight goes from 1.000 s"), "{outside}");
    let ideal = fly(&FlyOptions { sensors: SensorSource::Ideal, ..on_chips(&["baro reset 9"]) });
    assert!(ideal.contains("ideal sensors have no chips"), "{ideal}");
}
