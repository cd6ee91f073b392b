use flight_record::{
    Encoder, End, FORMAT_VERSION, Header, MAX_STUFFED, Payload, SensorSource, Stream, TickRecord,
};
use kf_core::input::{BaroReading, GpsFix, ImuSample, LaunchDoubt, TickInput};
use kf_core::latch::{LatchRecord, SensorLatch};
use kf_core::output::{Phase, SensorOutput, TickOutput, Trust};
use survival::{Cause, RestartReport, Start};

use super::*;
use crate::import;
use flight_data::{Channel, parse, to_writer};

fn input(tick: u64) -> TickInput {
    let fix = GpsFix {
        altitude_m: 2_000.25 + tick as f32,
        velocity_down_mps: Some(-0.125),
        satellites: Some(11),
        fix_time_us: Some(400_000_000_000 + tick * 5_000),
        ..GpsFix::default()
    };
    TickInput {
        time_us: 1_000_000 + tick * 5_000,
        launch: tick >= 40,
        launch_doubt: if (36..40).contains(&tick) { LaunchDoubt::Suspected } else { LaunchDoubt::None },
        gps: tick.is_multiple_of(20).then_some(fix),
        baro: tick.is_multiple_of(4).then_some(BaroReading::PressurePa(79_500.1 + tick as f32)),
        imu_slave_altitude_m: Some(2_030.0 + 0.1 * tick as f32),
        imu: Some(ImuSample { accel_mps2: [0.1, 0.2, -9.8], gyro_radps: [0.01, 0.02, 0.03] }),
        ..TickInput::default()
    }
}

fn record(tick: u64) -> TickRecord {
    let input = input(tick);
    let is_free = input.launch;
    let trust = match tick {
        ..40 => Trust::Calibrating,
        40..50 => Trust::Trusted,
        50..60 => Trust::Doubtful,
        _ => Trust::Untrustworthy,
    };
    let sensor = SensorOutput {
        bias_m: 30.0,
        bias_variance_m2: 0.25,
        innovation_m: None,
        signed_nis: None,
        error_m: None,
        moving_average_m: None,
        trust,
        rejection: None,
    };
    let output = TickOutput {
        time_us: input.time_us,
        out_of_order: false,
        phase: if is_free { Phase::FreeFlight } else { Phase::Calibrating },
        latched_now: tick == 40,
        failed_checks: if is_free { 0b100 } else { 0 },
        altitude_m: 2_000.0,
        altitude_variance_m2: 1.0,
        gps_innovation_m: None,
        gps_signed_nis: None,
        gps_rejection: None,
        sensors: [sensor; 3],
        extrapolated: 0,
        cross_check: None,
        bridged_us: None,
        coefficients: heapless::Vec::new(),
    };
    TickRecord { begun: 0, cost: 9_000, input, output }
}

fn latch() -> LatchRecord {
    let sensor = SensorLatch {
        bias_m: 30.125,
        bias_variance_m2: 0.25,
        readings: 7,
        residual_variance_m2: 4.0,
        mean_variance_m2: 0.5,
        bound_m2: 36.0,
    };
    LatchRecord {
        time_us: 1_180_000,
        duration_s: 0.18,
        failed_checks: 0b100,
        sensors: [SensorLatch::default(), sensor, sensor],
        state: heapless::Vec::new(),
        covariance: heapless::Vec::new(),
    }
}

fn restart(start: Start, resumed_us: u64) -> RestartReport {
    RestartReport {
        start,
        cause: Cause::Panic,
        crash: None,
        mark: None,
        snapshot_us: None,
        refused: [None; 2],
        resumed_us,
        restarts: 1,
        pause_us: 0,
    }
}

/// A line as sent, frame by frame.
#[derive(Default)]
struct Line {
    encoder: Encoder,
    frames: Vec<Vec<u8>>,
}

impl Line {
    fn send<P: Payload>(&mut self, payload: &P) {
        let mut buffer = [0; MAX_STUFFED];
        self.frames.push(self.encoder.encode(payload, &mut buffer).unwrap().to_vec());
    }

    /// The sender starts as the firmware does: frames are numbered from 0.
    fn start(&mut self) {
        self.encoder = Encoder::new();
        self.send(&Header::new(Stream::Outputs, 0xabcd, SensorSource::Chips));
    }

    fn ticks(&mut self, ticks: std::ops::Range<u64>) {
        for tick in ticks {
            self.send(&record(tick));
            if tick == 40 {
                self.send(&latch());
            }
        }
    }

    fn bytes(&self) -> Vec<u8> {
        self.frames.concat()
    }
}

fn whole() -> Line {
    let mut line = Line::default();
    line.start();
    line.ticks(0..100);
    line
}

fn imported(log: &[u8]) -> (Flight, Vec<String>) {
    let (flight, notes) = import::import(log).unwrap();
    (flight, notes.iter().map(|note| note.text().to_owned()).collect())
}

fn samples(flight: &Flight, channel: Channel) -> Vec<(f64, f32)> {
    let column = flight.channel(channel).unwrap();
    column.samples().map(|(row, value)| (flight.time_s[row], value)).collect()
}

fn key<'a>(flight: &'a Flight, key: &str) -> Option<&'a str> {
    flight.header.other.iter().find(|(name, _)| name == key).map(|(_, value)| value.as_str())
}

fn has(notes: &[String], text: &str) -> bool {
    notes.iter().any(|note| note.contains(text))
}

#[test]
fn every_number_of_a_record_is_in_the_flight_and_comes_back_from_its_text() {
    let (flight, notes) = imported(&whole().bytes());
    assert_eq!(flight.rows(), 100);
    let mut text = Vec::new();
    to_writer(&mut text, &flight).unwrap();
    let (read, _) = parse(&text).unwrap();
    // The ticks of the file equal those of the record; only the fix's time is counted from the first fix.
    let replayed = replay::Replay::new(&read, &model::Model::default(), None).unwrap();
    let ticks: Vec<TickInput> = replayed.inputs().collect();
    for (tick, mut got) in (0..100).zip(ticks) {
        let mut sent = input(tick);
        for fix in [&mut sent.gps, &mut got.gps].into_iter().flatten() {
            fix.fix_time_us = fix.fix_time_us.map(|time_us| time_us % 400_000_000_000);
        }
        assert_eq!(got, sent);
    }
    assert_eq!(samples(&flight, Channel::Launch), [(1.0, 0.0), (1.2, 1.0)]);
    assert_eq!(samples(&flight, Channel::LaunchDoubt), [(1.0, 0.0), (1.18, 1.0), (1.2, 0.0)]);
    assert_eq!(notes.len(), 1, "{notes:?}");
}

#[test]
fn the_calibration_and_the_flags_as_flown_are_in_the_header() {
    let (flight, notes) = imported(&whole().bytes());
    for (name, value) in [
        ("flown_model_fingerprint", "000000000000abcd"),
        ("flown_latched_s", "1.18"),
        ("flown_launch_decided_s", "1.2"),
        ("flown_quality", "degraded"),
        ("flown_failed_checks", "trimmed_altitude"),
        ("flown_baro_bias_m", "30.125"),
        ("flown_baro_bias_sigma_m", "0.5"),
        ("flown_baro_residual_sigma_m", "2"),
        ("flown_baro_bound_m", "6"),
        ("flown_baro_doubtful_s", "1.25"),
        ("flown_imu_slave_untrustworthy_s", "1.3"),
    ] {
        assert_eq!(key(&flight, name), Some(value), "{name}");
    }
    assert_eq!(key(&flight, "flown_imu_master_bias_m"), None);
    assert!(has(&notes, "the calibration and the flags as flown are in the header"));
    // Without the latch's own frame, the values of the tick remain.
    let mut line = whole();
    line.frames.remove(42);
    let (flight, notes) = imported(&line.bytes());
    assert_eq!(key(&flight, "flown_baro_bias_m"), Some("30"));
    assert!(has(&notes, "the frame of the latched calibration is missing"), "{notes:?}");
    assert!(has(&notes, "frames missing between those received: 1"), "{notes:?}");
}

#[test]
fn torn_frames_and_garbage_cost_their_own_ticks_and_are_counted() {
    let frames = whole().frames;
    let garbage: Vec<u8> = (0..3_000_u32).map(|k| (k.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
    // Before the first frame, with and without a zero after it.
    for (log, rows, said) in [
        ([&garbage[..], &[0], &frames.concat()].concat(), 100, "stretches that are not frames"),
        (
            [&frames[..50].concat()[..], &garbage, &[0], &frames[50..].concat()].concat(),
            100,
            "stretches that are not frames",
        ),
        ([&frames.concat()[..], &garbage].concat(), 100, "the last frame is cut off"),
        (frames.concat()[..frames.concat().len() - 9].to_vec(), 99, "the last frame is cut off"),
        // The first half of a frame is missing, as when a recorder is attached later.
        (frames.concat()[frames[0].len() + 20..].to_vec(), 99, "recorded from the middle of a stream"),
    ] {
        let (flight, notes) = imported(&log);
        assert_eq!(flight.rows(), rows, "{said}");
        assert!(has(&notes[..2], said), "{said}: {notes:?}");
    }
    let mut flipped = frames.concat();
    let at = flipped.len() / 2;
    flipped[at] ^= 0x10;
    let (flight, notes) = imported(&flipped);
    assert!(flight.rows() >= 98, "{}", flight.rows());
    assert!(has(&notes, "ticks that are missing by their times (usually every 5.0 ms)"), "{notes:?}");
    assert_eq!(key(&flight, "record_damaged_stretches"), Some("1"));
    let (flight, notes) =
        imported(&[&frames[..30].concat()[..], &frames[29], &frames[30..].concat()].concat());
    assert_eq!(flight.rows(), 100);
    assert!(has(&notes, "frames that came twice, left out once: 1"), "{notes:?}");
}

#[test]
fn a_restart_goes_on_with_the_flight_and_is_said() {
    for (start, said) in [
        (Start::Resumed, "restart 1 (resumed) after a panic: 0.110 s without ticks after 1.340 s"),
        (Start::Captive, "the flight computer calibrated again from 1.450 s on"),
        (Start::Lost, "calibration was lost"),
    ] {
        let mut line = Line::default();
        line.start();
        line.ticks(0..70);
        let torn = line.frames.pop().unwrap();
        line.start();
        line.send(&restart(start, 1_450_000));
        line.ticks(90..120);
        let after = line.frames.split_off(71);
        // Cut by the reset, without a zero or with the one with which the firmware begins.
        for zero in [&[][..], &[0]] {
            let log = [&line.frames.concat()[..], &torn[..60], zero, &after.concat()].concat();
            let (flight, notes) = imported(&log);
            assert_eq!(flight.rows(), 99, "{start:?}");
            assert_eq!(key(&flight, "record_restarts"), Some("1"));
            assert!(has(&notes, said), "{notes:?}");
            assert!(has(&notes, "stretches that are not frames (torn"), "{notes:?}");
            assert!(flight.time_s.is_sorted());
        }
        // Header and report are lost as well: the clock shows that the flight continues.
        let log = [&line.frames.concat()[..], &torn[..60], &after[1..].concat()].concat();
        let (flight, notes) = imported(&log);
        assert_eq!(flight.rows(), 99);
        assert!(has(&notes, "a restart whose report was lost"), "{notes:?}");
    }
}

#[test]
fn a_cold_start_is_another_flight_and_the_longest_is_used() {
    let mut line = Line::default();
    line.start();
    line.ticks(0..30);
    line.start();
    line.ticks(0..100);
    line.start();
    line.send(&restart(Start::Cold, 0));
    line.ticks(110..120);
    let (flight, notes) = imported(&line.bytes());
    assert_eq!(flight.rows(), 100);
    assert!(has(&notes, "other flights in the record"), "{notes:?}");
    assert!(has(&notes, ": 2, of 40 ticks; the longest is used"), "{notes:?}");
}

#[test]
fn inputs_alone_are_a_flight_too() {
    let mut line = Line::default();
    line.send(&Header::new(Stream::Inputs, 1, SensorSource::Chips));
    for tick in 0..100 {
        line.send(&input(tick));
    }
    let (_, notes) = imported(&line.bytes());
    assert!(has(&notes, "the record of inputs has no end: it was cut"), "{notes:?}");
    line.send(&End { inputs: 100 });
    let (flight, notes) = imported(&line.bytes());
    assert_eq!((flight.rows(), notes.len()), (100, 0), "{notes:?}");
    assert!(flight.header.source.contains("inputs for a flight computer"));
    line.frames.remove(20);
    let (_, notes) = imported(&line.bytes());
    assert!(has(&notes, "the record declares 100 inputs, but has 99"), "{notes:?}");
}

#[test]
fn what_is_no_flight_is_one_line_that_says_why() {
    let error = |log: &[u8]| import::import(log).unwrap_err().to_string();
    assert_eq!(error(&[]), "an empty file: nothing was recorded");
    assert!(error(&[0; 100]).starts_with("not a log of a known format"));
    let mut line = Line::default();
    line.start();
    let only_header = line.bytes();
    assert!(error(&only_header).starts_with("flight record without a tick (1 frames read"));
    line.send(&restart(Start::Standby, 9_000_000));
    let said = error(&line.bytes());
    assert!(said.contains("the flight computer reported: restart 1 (standby) after a panic"), "{said}");

    let mut line = Line::default();
    let header =
        Header { version: FORMAT_VERSION - 1, ..Header::new(Stream::Outputs, 1, SensorSource::Ideal) };
    line.send(&header);
    line.ticks(0..3);
    let said = error(&line.bytes());
    assert!(said.contains(&format!("a flight record of version {}", FORMAT_VERSION - 1)), "{said}");
    assert!(said.contains(&format!("reads version {FORMAT_VERSION}")), "{said}");

    let mut line = Line::default();
    line.start();
    for tick in 1..9 {
        line.send(&record(tick));
    }
    assert!(error(&line.bytes()).starts_with("flight record of 8 ticks without a fix"));
}

proptest::proptest! {
    /// Whatever part of a record is replaced by other bytes, nothing panics and no tick is made up.
    #[test]
    fn any_damage_leaves_ticks_that_were_sent(
        at in 0_usize..8_000, gone in 0_usize..900, instead in proptest::collection::vec(proptest::num::u8::ANY, 0..400),
    ) {
        let bytes = whole().bytes();
        let (at, end) = (at.min(bytes.len()), (at + gone).min(bytes.len()));
        let log = [&bytes[..at], &instead, &bytes[end..]].concat();
        if let Ok((flight, _)) = import::import(&log) {
            let sent: Vec<f64> = (0..100).map(|tick| input(tick).time_us as f64 / 1e6).collect();
            proptest::prop_assert!(flight.time_s.iter().all(|time_s| sent.contains(time_s)));
            // A frame is some 150 bytes.
            proptest::prop_assert!(flight.rows() + gone / 100 + 3 >= 100, "{}", flight.rows());
        }
    }
}
