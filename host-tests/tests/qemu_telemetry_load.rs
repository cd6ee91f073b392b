//! A telemetry line that is too slow loses frames, counts them and reports it. However full the line is, no
//! tick is missed, none has other bits, and none begins or ends later because of it.
#![allow(clippy::unwrap_used)]

mod mavlink_client;
mod telemetry_flight;
mod ticks;

use flight_computer::Part;
use flight_record::{Encoder, End, ExitStatus, Header, MAX_STUFFED, SensorSource, Stream, TickRecord};
use host_tests::budget::Budgets;
use pylon::fly::{Downlinked, FlyReport, PlantedError, Starts, fly_bytes};
use serde_json::Value;

use mavlink_client::{decode, gaps, named, of, texts, whole};
use telemetry_flight::{fly, inputs, model};
use ticks::{TICKS, must};

fn telemetry_instructions(report: &FlyReport) -> (f64, u32) {
    let part = report.parts.iter().find(|part| part.part == Part::Messages).unwrap();
    (part.instructions_mean, part.instructions_worst)
}

#[test]
fn a_slow_line_loses_frames_tells_how_many_and_costs_no_tick() {
    let (free, _) = fly(None);
    // This returns only if every tick had the host's bits.
    let (slow, Downlinked { target, .. }) = fly(Some(PlantedError::SlowLine));
    assert_eq!((slow.ticks as usize, slow.underruns, slow.stalls), (TICKS, 0, 0));
    let messages = decode(&target);
    assert_eq!(of(&messages, "BAD_DATA"), Vec::<&Value>::new());
    // 30 s at a tenth of 92160 bytes a second; less than a frame waits for the next look at the line.
    let share = target.len() as f64 / (30.0 * 9_216.0);
    assert!((0.98..=1.01).contains(&share), "{share}");
    let missing = gaps(&messages);
    assert!(missing > 1_000, "{missing}");
    let statuses = of(&messages, "SYS_STATUS");
    assert!(statuses.len() >= 29, "{}", statuses.len());
    // A status counts exactly the frames that were dropped before it: the gaps before it.
    for (position, status) in messages.iter().enumerate() {
        if status["mavpackettype"] == "SYS_STATUS" {
            assert_eq!(whole(status, "errors_comm"), gaps(&messages[..=position]), "{status}");
        }
    }
    let last = statuses.last().unwrap();
    assert!(whole(last, "drop_rate_comm") > 1_000, "{last}");
    let by_name: f32 = ["hb", "sys", "gps", "att", "imu", "alt", "nvf", "text"]
        .iter()
        .filter_map(|kind| named(&messages, &format!("d_{kind}")).last().map(|(_, count)| *count))
        .sum();
    assert!(by_name > 0.5 * missing as f32 && by_name <= missing as f32, "{by_name} {missing}");
    assert!(texts(&messages).iter().any(|text| text.starts_with("t=21.000 latched")));

    // Dropping a frame costs less than making it.
    let ((free_mean, free_worst), (slow_mean, slow_worst)) =
        (telemetry_instructions(&free), telemetry_instructions(&slow));
    println!("a tick's messages, made below it, instructions: {free_mean:.0} mean, {free_worst} worst");
    println!("on a line too slow, {missing} of its frames lost: {slow_mean:.0} mean, {slow_worst} worst");
    assert!(slow_mean <= free_mean && slow_worst <= free_worst);
    let budget = Budgets::read().unwrap().flight.messages_instructions_worst;
    assert!(free_worst <= budget, "{free_worst} of {budget}");
}

/// The records of all ticks of the flight on a line with that load.
fn ticks_on(line: PlantedError) -> Vec<TickRecord> {
    let inputs = inputs();
    let mut encoder = Encoder::new();
    let mut buffer = [0; MAX_STUFFED];
    let header = Header::new(Stream::Inputs, model().fingerprint().unwrap(), SensorSource::Ideal);
    let mut record = encoder.encode(&header, &mut buffer).unwrap().to_vec();
    for input in &inputs {
        record.extend(encoder.encode(input, &mut buffer).unwrap());
    }
    record.extend(encoder.encode(&End { inputs: TICKS as u32 }, &mut buffer).unwrap());
    let flight = must(fly_bytes(&record, &model(), Some(line)));
    assert_eq!(flight.status, Some(ExitStatus::Finished), "{:?}", flight.log);
    assert_eq!(flight.ticks.len(), TICKS);
    flight.ticks
}

fn starts(ticks: &[TickRecord]) -> Starts {
    let mut starts = Starts::default();
    ticks.iter().for_each(|tick| starts.take(tick.begun));
    starts
}

#[test]
fn a_line_that_is_never_idle_moves_no_tick() {
    let [silent, full] = [PlantedError::SilentLine, PlantedError::FullLine].map(ticks_on);
    let budget = Budgets::read().unwrap().flight.start_jitter_instructions;
    let (silent_starts, full_starts) = (starts(&silent), starts(&full));
    println!(
        "a tick begins every {} instructions; how much later on that grid one begins than another:",
        full_starts.period()
    );
    let jitters = [silent_starts.jitter(), full_starts.jitter()];
    println!("silent line: {} instructions; line never idle: {} instructions", jitters[0], jitters[1]);
    // An instruction is a nanosecond, so for the flight the emulated line has 921600 baud, and the load is
    // full.
    for starts in [&silent_starts, &full_starts] {
        assert!(starts.period().abs_diff(5_000_000) <= 1, "{}", starts.period());
    }
    assert!(jitters.iter().all(|jitter| *jitter <= budget), "beyond {budget}: {jitters:?}");
    let (mut differing, mut most) = (0, 0_u64);
    for (silent, full) in silent.iter().zip(&full) {
        assert_eq!(
            (format!("{:?}", silent.input), format!("{:?}", silent.output)),
            (format!("{:?}", full.input), format!("{:?}", full.output))
        );
        differing += u32::from(silent.cost != full.cost);
        most = most.max(silent.cost.abs_diff(full.cost).into());
    }
    // The images differ: the compiler may lay them out differently.
    assert!(most <= budget, "{most}");
    println!("what a tick takes differs in {differing} of {TICKS} ticks, by {most} instructions at most");
}
