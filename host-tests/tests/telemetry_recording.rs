//! A flight in the flight computer's telemetry, recorded as by a ground station, read by pymavlink and
//! imported again: what the aircraft saw can be compared and diagnosed.
#![allow(clippy::unwrap_used, clippy::panic)]

mod mavlink_client;

use std::io::Write as _;
use std::path::Path;

use kf_core::output::{Phase, Trust};
use mavlink_client::{decode_tlog, of, whole};
use model::Model;
use pylon::compare::{Comparison, Options, compare};
use pylon::diagnose::{Diagnosis, NamedReplay, diagnose};
use pylon::downlink::Downlink;
use pylon::export::tlog;
use pylon::flight::{Channel, Flight};
use pylon::fly::{Downlinked, FlyOptions, SensorSource, fly, fly_on_host};
use pylon::import;
use pylon::replay::Replay;
use pylon::simulate::{load_scenario, simulate};
use telemetry::{ComputerStatus, FrameQueue, Rates};

/// Start of the flight computer: 2026-01-01.
const START_US: u64 = 1_767_225_600_000_000;

fn flown() -> Flight {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../flights/quickstart.toml");
    simulate(&load_scenario(&file).unwrap(), 7).unwrap().0
}

/// The recording of its telemetry.
fn recorded(flight: &Flight, rates: Rates) -> Vec<u8> {
    let model = Model::default();
    let replay = Replay::new(flight, &model, None).unwrap();
    let mut mission = pylon::replay::mission(&model).unwrap();
    let mut queue = FrameQueue::new();
    let mut downlink = Downlink::new(&mut queue, &model, rates);
    for input in replay.inputs() {
        let output = mission.tick(&input);
        downlink.tell(&input, &output, &*mission, &ComputerStatus::default());
    }
    tlog::recording(&downlink.into_bytes(), START_US)
}

fn compared(flight: &Flight) -> Comparison {
    let model = Model::default();
    compare(&Replay::new(flight, &model, None).unwrap(), &Options::default(), &mut |_| ()).unwrap().0
}

fn diagnosed(flight: &Flight) -> Diagnosis {
    let replay = Replay::new(flight, &Model::default(), None).unwrap();
    diagnose(&[NamedReplay::new("flight".to_owned(), replay)], &[], &mut || ())
}

#[test]
fn every_sample_comes_back_and_the_comparison_is_the_same() {
    let flight = flown();
    let log = recorded(&flight, Rates::FULL);
    let (back, notes) = import::import(&log).unwrap();
    assert_eq!(notes.len(), 1, "{notes:?}");
    for (channel, tolerance) in [
        (Channel::GpsAltM, 0.000_8),
        (Channel::GpsVdMps, 0.0),
        (Channel::BaroPa, 0.008),
        (Channel::BaroTempC, 0.0),
        (Channel::ImuMasterAltM, 0.0),
        (Channel::ImuSlaveAltM, 0.0),
        (Channel::AccelXMps2, 0.0),
        (Channel::GyroZRadps, 0.0),
        (Channel::GpsSats, 0.0),
    ] {
        let samples = |flight: &Flight| -> Vec<(i64, f32)> {
            let column = flight.channel(channel).unwrap();
            column
                .samples()
                .map(|(row, sample)| ((flight.time_s[row] * 1e6).round() as i64, sample))
                .collect()
        };
        let (sent, got) = (samples(&flight), samples(&back));
        assert_eq!(sent.len(), got.len(), "{}", channel.name());
        for ((sent_us, sent), (got_us, got)) in sent.iter().zip(&got) {
            assert_eq!(sent_us, got_us, "{}", channel.name());
            assert!((sent - got).abs() <= tolerance, "{}: {sent} {got}", channel.name());
        }
    }
    let (sent, got) = (compared(&flight), compared(&back));
    assert_eq!(sent.launch_s, got.launch_s);
    assert_eq!(sent.calibration.failed_checks, got.calibration.failed_checks);
    for (name, sensor) in &sent.sensors {
        let other = &got.sensors[name];
        // The resolution of the line, a millimetre of a fix and half a millimetre of pressure, in a mean of
        // thousands.
        assert!((sensor.bias_m.unwrap() - other.bias_m.unwrap()).abs() < 0.001, "{name}");
        assert_eq!(sensor.doubtful_after_s, other.doubtful_after_s, "{name}");
        assert_eq!(sensor.untrustworthy_after_s, other.untrustworthy_after_s, "{name}");
    }
}

#[test]
fn what_the_narrow_line_carries_is_enough_to_find_the_hidden_effect() {
    let flight = flown();
    let (wide, narrow) = (recorded(&flight, Rates::FULL), recorded(&flight, Rates::NARROW));
    assert!(narrow.len() * 2 < wide.len(), "{} {}", narrow.len(), wide.len());
    let truth = 0.06;
    for log in [wide, narrow] {
        let (back, _) = import::import(&log).unwrap();
        let diagnosis = diagnosed(&back);
        let baro = &diagnosis.sensors["baro"];
        assert_eq!(baro.missing, ["baro.dynamic_pressure"], "{diagnosis:?}");
        let found = &baro.candidates[0];
        assert!((found.coefficient - truth).abs() < 4.0 * found.sigma, "{found:?}");
        // The calibration comes from fewer samples of the same flight.
        let (sent, got) = (compared(&flight), compared(&back));
        let (sent, got) = (&sent.sensors["baro"], &got.sensors["baro"]);
        let off_m = (sent.bias_m.unwrap() - got.bias_m.unwrap()).abs();
        assert!(off_m < 2.0 * sent.bias_sigma_m.unwrap(), "{off_m}");
    }
}

#[test]
fn what_qemu_sends_on_chips_comes_back_as_the_flight_that_it_flew() {
    let (flight, model) = (flown(), Model::default());
    let replay = Replay::new(&flight, &model, None).unwrap();
    let options = FlyOptions { sensors: SensorSource::Chips, telemetry: true, ..FlyOptions::default() };
    let report = fly(&replay, &options).unwrap_or_else(|error| panic!("{error}"));
    let Downlinked { target, host } = report.telemetry.unwrap();
    assert!(host.starts_with(&target) && host.len() - target.len() < 31 * 75, "{}", target.len());

    let (back, _) = import::import(&tlog::recording(&target, START_US)).unwrap();
    // The flight computer's results from its drivers' readings: when each sensor's flags rose, seconds after
    // launch.
    let mut launch_us = None;
    let mut raised_s = [[None; 2]; 3];
    fly_on_host(replay.inputs(), &model, &options, &mut |step, _| {
        if step.output.phase == Phase::FreeFlight {
            let since_s = (step.output.time_us - *launch_us.get_or_insert(step.output.time_us)) as f64 * 1e-6;
            for (sensor, raised_s) in step.output.sensors.iter().zip(&mut raised_s) {
                if matches!(sensor.trust, Trust::Doubtful | Trust::Untrustworthy) {
                    raised_s[0].get_or_insert(since_s);
                }
                if sensor.trust == Trust::Untrustworthy {
                    raised_s[1].get_or_insert(since_s);
                }
            }
        }
    })
    .unwrap();
    let (compared, latch) = (compared(&back), report.latch.unwrap());
    assert!(raised_s[2][0].is_some(), "the flight has no sensor that is doubted");
    println!("latched for {} us, confirmed at {launch_us:?} us", latch.time_us);
    for (name, k) in [("imu_slave", 1), ("baro", 2)] {
        let sensor = &compared.sensors[name];
        let off_m = (sensor.bias_m.unwrap() - f64::from(latch.sensors[k].bias_m)).abs();
        println!("{name}: bias {off_m:.4} m off, flags at {:?} s", raised_s[k]);
        // The recording has the launch at its confirmation; the flight computer latched its state at the
        // first edge.
        let sigma_m = f64::from(latch.sensors[k].bias_variance_m2.sqrt());
        assert!(off_m < sigma_m, "{name}: {off_m} of {sigma_m}");
        for (said_s, got_s) in raised_s[k].iter().zip([sensor.doubtful_after_s, sensor.untrustworthy_after_s])
        {
            assert_eq!(said_s.is_some(), got_s.is_some(), "{name}: {raised_s:?} {got_s:?}");
            // One tick: the error that rose was within half a millimetre of the bound.
            assert!((said_s.unwrap_or_default() - got_s.unwrap_or_default()).abs() < 0.006, "{name}");
        }
    }
    assert_eq!(diagnosed(&back).sensors["baro"].missing, ["baro.dynamic_pressure"]);
}

#[test]
fn another_reader_of_recordings_reads_it_too() {
    let log = recorded(&flown(), Rates::NARROW);
    let mut file = tempfile::Builder::new().suffix(".tlog").tempfile().unwrap();
    file.write_all(&log).unwrap();
    let messages = decode_tlog(file.path());
    assert_eq!(of(&messages, "BAD_DATA").len(), 0);
    let imu = of(&messages, "HIGHRES_IMU");
    assert!(imu.len() > 5_000, "{}", imu.len());
    for message in imu {
        // pymavlink keeps the time as a double of seconds: a resolution of a fourth of a microsecond in 2026.
        let late_us = whole(message, "timestamp_us") - START_US as i64 - whole(message, "time_usec");
        assert!(late_us.abs() <= 1, "{message}");
    }
}
