//! A flight computer's results from a recorder, imported as a flight: from it, a mission of the same model
//! reproduces the flight computer's results to the bit.
//!
//! Needs qemu-system-arm and the Rust target, as every emulated flight.
#![allow(clippy::unwrap_used, clippy::panic)]

mod restarts;
mod ticks;

use std::collections::BTreeMap;

use flight_record::{
    Blow, Decoder, Encoder, End, Header, Kind, MAX_STUFFED, SensorSource, Stream, Strike, TickRecord,
};
use kf_core::output::TickOutput;
use pylon::compare::{Options, compare};
use pylon::flight::{self, Channel, Flight};
use pylon::fly::{FlyOptions, fly_inputs, fly_struck};
use pylon::import;
use pylon::replay::Replay;

use restarts::{at, bits, model};
use ticks::{TICKS, flight, must};

/// The flight computer's results, tick by tick.
fn said(record: &[u8]) -> Vec<TickOutput> {
    let mut decoder = Decoder::new();
    let mut said = Vec::new();
    for byte in record {
        if let Some(frame) = decoder.push(*byte).unwrap()
            && frame.kind == Kind::Tick
        {
            said.push(frame.payload::<TickRecord>().unwrap().output);
        }
    }
    said
}

/// Through a file, as a user has it.
fn imported(record: &[u8]) -> (Flight, Vec<String>) {
    let (flight, notes) = import::import(record).unwrap();
    let directory = tempfile::tempdir().unwrap();
    let file = directory.path().join("flight.csv");
    flight::write(&file, &flight).unwrap();
    (flight::read(&file).unwrap().0, notes.iter().map(|note| note.text().to_owned()).collect())
}

fn keys(flight: &Flight) -> BTreeMap<&str, &str> {
    flight.header.other.iter().map(|(key, value)| (key.as_str(), value.as_str())).collect()
}

/// Value of a key of the recorded flight, seconds.
fn seconds(keys: &BTreeMap<&str, &str>, key: &str) -> Option<f64> {
    keys.get(key).map(|text| text.parse().unwrap())
}

#[test]
fn a_recorded_flight_is_compared_as_it_was_flown_to_the_bit() {
    for sensors in [SensorSource::Ideal, SensorSource::Chips] {
        let options = FlyOptions { sensors, record: true, ..FlyOptions::default() };
        let report = must(fly_inputs(flight().into_iter(), &model(), &options));
        let (flown, latch) = (report.record.unwrap(), report.latch.unwrap());
        let said = said(&flown);
        assert_eq!(said.len(), TICKS);

        let (flight, notes) = imported(&flown);
        assert_eq!(flight.rows(), TICKS);
        assert!(notes.iter().all(|note| note.contains("flown_")), "{notes:?}");
        // The wire bounced under the pylon, and on chips the launch took some time to be decided.
        assert!(flight.channel(Channel::LaunchDoubt).is_some());
        let model = model();
        let replay = Replay::new(&flight, &model, None).unwrap();
        let mut ticks = 0;
        let summary = replay.run(&mut |_, output| {
            assert_eq!(bits(output), bits(&said[ticks]), "{sensors:?}: tick {ticks}");
            ticks += 1;
        });
        assert_eq!(ticks, TICKS);
        assert_eq!(summary.unwrap().latch.as_ref(), Some(&latch));

        // The header reports the same as `compare`.
        let (comparison, _) = compare(&replay, &Options::default(), &mut |_| ()).unwrap();
        let keys = keys(&flight);
        assert_eq!(keys["flown_quality"], comparison.calibration.quality.unwrap());
        let launch_s = comparison.launch_s.unwrap();
        assert_eq!(seconds(&keys, "flown_launch_decided_s"), Some(launch_s));
        for name in ["baro", "imu_slave"] {
            let sensor = &comparison.sensors[name];
            // The shortest text of an `f32`, compared with the same value as `f64`.
            let bias_m = keys[format!("flown_{name}_bias_m").as_str()].parse::<f32>().unwrap();
            assert_eq!(Some(f64::from(bias_m)), sensor.bias_m, "{name}");
            for (flag, after_s) in
                [("doubtful", sensor.doubtful_after_s), ("untrustworthy", sensor.untrustworthy_after_s)]
            {
                let flown_s = seconds(&keys, &format!("flown_{name}_{flag}_s"));
                let after_s = after_s.map(|after_s| ((launch_s + after_s) * 1e6).round());
                assert_eq!(flown_s.map(|flown_s| (flown_s * 1e6).round()), after_s, "{name} {flag}");
            }
        }
        // The dive, and the wander due to the barometer's static port, raised a flag.
        assert!(keys.keys().any(|key| key.ends_with("_doubtful_s")), "{keys:?}");
    }
}

#[test]
fn a_flight_computer_that_was_reset_in_free_flight_leaves_one_flight() {
    let mut encoder = Encoder::new();
    let mut buffer = [0; MAX_STUFFED];
    let header = Header::new(Stream::Inputs, model().fingerprint().unwrap(), SensorSource::Ideal);
    let mut record = encoder.encode(&header, &mut buffer).unwrap().to_vec();
    for input in flight() {
        record.extend_from_slice(encoder.encode(&input, &mut buffer).unwrap());
    }
    record.extend_from_slice(encoder.encode(&End { inputs: TICKS as u32 }, &mut buffer).unwrap());
    let flown = must(fly_struck(&record, &model(), &[Strike { blow: Blow::Panic, time_us: at(5_000) }]));
    assert_eq!(flown.restarts.len(), 1, "{:?}", flown.log);

    let (flight, notes) = imported(&flown.record);
    assert_eq!(flight.rows(), flown.ticks.len());
    assert!(notes.iter().any(|note| note.starts_with("restart 1 (resumed) after a panic: 0.1")), "{notes:?}");
    let keys = keys(&flight);
    assert_eq!(keys["record_restarts"], "1");
    let (model, sensor) = (model(), 2);
    let summary = Replay::new(&flight, &model, None).unwrap().run(&mut |_, _| ()).unwrap();
    // It was latched before the reset, so the gap does not change it.
    assert_eq!(Some(&flown.latches[0]), summary.latch.as_ref());
    assert_eq!(keys["flown_baro_bias_m"], flown.latches[0].sensors[sensor].bias_m.to_string());

    // The inputs that it was given are a flight as well.
    let (inputs, notes) = imported(&record);
    assert_eq!((inputs.rows(), notes.len()), (TICKS, 0), "{notes:?}");
}
