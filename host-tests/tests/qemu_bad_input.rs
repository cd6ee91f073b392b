//! Bad input to the emulated flight computer: it never panics, it counts the input, and while there are ticks
//! they have the host's bits.
//!
//! Needs qemu-system-arm and the Rust target; without them the tests fail and say what to install
//! (`cargo xtask test` installs it).
#![allow(clippy::unwrap_used)]

mod ticks;

use flight_record::{Encoder, End, ExitStatus, Header, MAX_STUFFED, Payload, SensorSource, Stream};
use kf_core::input::{BaroReading, TickInput};
use kf_core::output::{Phase, Rejection, Trust};
use model::Model;
use pylon::fly::{FlyOptions, FlyReport, RawFlight, fly_bytes, fly_inputs};

use ticks::{LAUNCH, TICKS, flight, must, prompt};

fn model() -> Model {
    prompt(Model::default())
}

/// Flies the flight after a change, and compares it with the host.
fn fly_changed(change: impl FnOnce(&mut Vec<TickInput>)) -> FlyReport {
    let mut inputs = flight();
    change(&mut inputs);
    must(fly_inputs(inputs.iter().copied(), &model(), &FlyOptions::default()))
}

/// As [`fly_changed`], but returns the ticks' results.
fn fly_raw(change: impl FnOnce(&mut Vec<TickInput>)) -> RawFlight {
    let mut inputs = flight();
    change(&mut inputs);
    let mut bytes = stream(&inputs);
    bytes.extend(frame_after(&inputs, &End { inputs: u32::try_from(inputs.len()).unwrap() }));
    let flight = must(fly_bytes(&bytes, &model(), None));
    assert_eq!(flight.status, Some(ExitStatus::Finished), "{:?}", flight.log);
    flight
}

/// A stream with header and inputs, without an end.
fn stream(inputs: &[TickInput]) -> Vec<u8> {
    let mut encoder = Encoder::new();
    let mut buffer = [0; MAX_STUFFED];
    let header = Header::new(Stream::Inputs, model().fingerprint().unwrap(), SensorSource::Ideal);
    let mut bytes = encoder.encode(&header, &mut buffer).unwrap().to_vec();
    for input in inputs {
        bytes.extend(encoder.encode(input, &mut buffer).unwrap());
    }
    bytes
}

/// A stream with that frame after header and inputs.
fn frame_after<P: Payload>(inputs: &[TickInput], payload: &P) -> Vec<u8> {
    let mut encoder = Encoder::new();
    let mut buffer = [0; MAX_STUFFED];
    for _ in 0..=inputs.len() {
        encoder.encode(&End { inputs: 0 }, &mut buffer).unwrap();
    }
    encoder.encode(payload, &mut buffer).unwrap().to_vec()
}

#[test]
fn nan_and_infinities_have_the_hosts_bits_and_are_refused() {
    let change = |inputs: &mut Vec<TickInput>| {
        for (k, input) in inputs.iter_mut().enumerate() {
            let bad = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX][k % 4];
            match k % 7 {
                0 => input.baro = input.baro.map(|_| BaroReading::PressurePa(bad)),
                1 => input.imu_slave_altitude_m = input.imu_slave_altitude_m.map(|_| bad),
                2 => input.signals.true_airspeed_mps = Some(bad),
                3 => {
                    input.imu = input.imu.map(|mut imu| {
                        imu.accel_mps2 = [bad; 3];
                        imu
                    })
                }
                _ => {}
            }
            if let (Some(fix), true) = (&mut input.gps, k % 3 == 0) {
                fix.altitude_m = bad;
                fix.velocity_down_mps = Some(bad);
            }
        }
    };
    assert_eq!(fly_changed(change).ticks as usize, TICKS);
    let flight = fly_raw(change);
    let refused = flight
        .ticks
        .iter()
        .filter(|tick| tick.output.sensors[2].rejection == Some(Rejection::NotFinite))
        .count();
    assert!(refused > 100, "{refused}");
    assert!(flight.ticks.iter().all(|tick| tick.output.altitude_m.is_finite()));
}

#[test]
fn repeated_and_backward_times_have_the_hosts_bits_and_are_ignored() {
    let change = |inputs: &mut Vec<TickInput>| {
        inputs[1_000].time_us = inputs[999].time_us;
        inputs[2_000].time_us = 0;
        inputs[3_000].time_us -= 1_000_000;
    };
    assert_eq!(fly_changed(change).ticks as usize, TICKS);
    let flight = fly_raw(change);
    let ignored: Vec<usize> = (0..TICKS).filter(|&k| flight.ticks[k].output.out_of_order).collect();
    assert_eq!(ignored, [1_000, 2_000, 3_000]);
}

#[test]
fn a_clock_that_jumps_to_its_end_has_the_hosts_bits() {
    let report = fly_changed(|inputs| inputs[5_000].time_us = u64::MAX);
    assert_eq!(report.ticks as usize, TICKS);
}

#[test]
fn a_stuck_sensor_and_a_frozen_reference_have_the_hosts_bits() {
    let report = fly_changed(|inputs| {
        let fix = inputs[1_000].gps;
        for (k, input) in inputs.iter_mut().enumerate().skip(1_000) {
            input.baro = input.baro.map(|_| BaroReading::PressurePa(79_495.0));
            if k % 40 == 0 {
                input.gps = fix;
            }
        }
    });
    assert!(report.latch.unwrap().failed_checks != 0);
}

#[test]
fn no_launch_has_the_hosts_bits_and_never_latches() {
    let report = fly_changed(|inputs| inputs.iter_mut().for_each(|input| input.launch = false));
    assert_eq!(report.latch, None);
}

#[test]
fn a_launch_while_settling_has_the_hosts_bits_and_latches_loudly() {
    let report = fly_changed(|inputs| inputs.iter_mut().skip(50).for_each(|input| input.launch = true));
    assert!(report.latch.unwrap().failed_checks != 0);
}

#[test]
fn a_second_launch_has_the_hosts_bits_and_latches_nothing() {
    let change = |inputs: &mut Vec<TickInput>| {
        inputs[LAUNCH + 100..LAUNCH + 200].iter_mut().for_each(|input| input.launch = false);
    };
    fly_changed(change);
    let flight = fly_raw(change);
    assert_eq!(flight.latches.len(), 1);
    assert_eq!(flight.ticks.iter().filter(|tick| tick.output.latched_now).count(), 1);
    assert!(flight.ticks[LAUNCH..].iter().all(|tick| tick.output.phase == Phase::FreeFlight));
}

#[test]
fn a_flight_shorter_than_settling_has_the_hosts_bits() {
    let report = fly_changed(|inputs| inputs.truncate(100));
    assert_eq!((report.ticks, report.latch), (100, None));
}

#[test]
fn a_flight_without_samples_has_the_hosts_bits_and_knows_nothing() {
    let change = |inputs: &mut Vec<TickInput>| {
        for input in inputs {
            *input = TickInput { time_us: input.time_us, launch: input.launch, ..TickInput::default() };
        }
    };
    fly_changed(change);
    let last = fly_raw(change).ticks.pop().unwrap();
    assert!(last.output.sensors.iter().all(|sensor| sensor.trust == Trust::Unmonitored));
}

#[test]
fn a_garbled_record_is_flown_without_the_garbled_frames_and_they_are_counted() {
    let inputs = flight();
    let mut bytes = stream(&inputs);
    let header = stream(&[]).len();
    // One byte in each of ten frames, and garbage between two.
    let step = (bytes.len() - header) / 10;
    for k in 0..10 {
        bytes[header + k * step + 7] ^= 0x55;
    }
    bytes.extend([0xff; 3_000]);
    bytes.push(0);
    bytes.extend(frame_after(&inputs, &End { inputs: u32::try_from(TICKS).unwrap() }));
    let flight = must(fly_bytes(&bytes, &model(), None));
    assert_eq!(flight.status, Some(ExitStatus::Finished), "{:?}", flight.log);
    let summary = flight.summary.unwrap();
    // Ten garbled frames, each counted as one or (when it was the closing zero) two; and the garbage.
    assert!((11..=21).contains(&summary.bad_frames), "{summary:?}");
    assert!((10..=20).contains(&summary.missed_frames), "{summary:?}");
    assert_eq!(summary.ticks + summary.missed_frames, u32::try_from(TICKS).unwrap());
    assert_eq!(summary.bad_payloads, 0);
    assert!(summary.input_cut, "the end counts more inputs than came");
    assert_eq!(flight.ticks.len(), summary.ticks as usize);
}

#[test]
fn a_record_that_is_cut_is_flown_up_to_the_cut() {
    let bytes = stream(&flight());
    let flight = must(fly_bytes(&bytes[..bytes.len() / 2 + 3], &model(), None));
    assert_eq!(flight.status, Some(ExitStatus::Finished), "{:?}", flight.log);
    let summary = flight.summary.unwrap();
    assert!(summary.input_cut);
    assert!((2_000..4_000).contains(&summary.ticks), "{summary:?}");
    assert_eq!((summary.bad_frames, summary.missed_frames), (0, 0));
}

#[test]
fn frames_out_of_place_are_counted_and_skipped() {
    let mut bytes = stream(&[]);
    let mut encoder = Encoder::new();
    let mut buffer = [0; MAX_STUFFED];
    // The second header has the sequence number after the first's.
    encoder.encode(&End { inputs: 0 }, &mut buffer).unwrap();
    bytes.extend(encoder.encode(&Header::new(Stream::Inputs, 0, SensorSource::Ideal), &mut buffer).unwrap());
    for input in &flight()[..10] {
        bytes.extend(encoder.encode(input, &mut buffer).unwrap());
    }
    bytes.extend(encoder.encode(&End { inputs: 10 }, &mut buffer).unwrap());
    let flight = must(fly_bytes(&bytes, &model(), None));
    let summary = flight.summary.unwrap();
    assert_eq!((summary.bad_payloads, summary.ticks, summary.input_cut), (1, 10, false));
}

#[test]
fn what_is_no_record_is_refused_with_a_status_of_its_own() {
    let status = |bytes: &[u8]| fly_bytes(bytes, &model(), None).map(|flight| flight.status);
    let refused = |bytes: &[u8]| match status(bytes) {
        Err(pylon::fly::FlyError::Stopped { status, .. }) => status,
        other => panic!("{other:?}"),
    };
    assert_eq!(refused(b""), Some(ExitStatus::NoHeader));
    assert_eq!(refused(b"time_s,gps_alt_m\n0,1\n"), Some(ExitStatus::NoHeader));
    assert_eq!(refused(&[0xa5; 10_000]), Some(ExitStatus::NoHeader));
    let mut buffer = [0; MAX_STUFFED];
    let mut header = |header: Header| Encoder::new().encode(&header, &mut buffer).unwrap().to_vec();
    let fingerprint = model().fingerprint().unwrap();
    assert_eq!(
        refused(&header(Header::new(Stream::Outputs, fingerprint, SensorSource::Ideal))),
        Some(ExitStatus::NoHeader)
    );
    let later = Header { version: u16::MAX, ..Header::new(Stream::Inputs, fingerprint, SensorSource::Ideal) };
    assert_eq!(refused(&header(later)), Some(ExitStatus::NoHeader));
    let other = Header::new(Stream::Inputs, fingerprint ^ 1, SensorSource::Ideal);
    assert_eq!(refused(&header(other)), Some(ExitStatus::OtherModel));
}
