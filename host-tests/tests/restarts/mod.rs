//! Interrupted flights, compared with the host.
// Each test file uses only part of this.
#![allow(dead_code, clippy::unwrap_used)]

use flight_computer::mission_mark;
use flight_record::{MAX_STUFFED, TickRecord};
use kf_core::latch::LatchRecord;
use kf_core::output::{Phase, TickOutput};
use kf_core::snapshot::MAX_SNAPSHOT_BYTES;
use model::Model;
use pylon::downlink::Downlink;
use pylon::fly::RawFlight;
use pylon::replay::mission;
use survival::{RestartReport, Start};
use telemetry::{ComputerStatus, FrameQueue, Rates};

use crate::ticks::{TICK_US, prompt};

/// Start of the record's clock, microseconds.
pub const FIRST_US: u64 = 1_000_000;
/// Time that the emulated board skips for a restart, microseconds.
pub const OUTAGE_US: u64 = 100_000;
pub fn model() -> Model {
    prompt(Model::default())
}

pub const fn at(tick: usize) -> u64 {
    FIRST_US + tick as u64 * TICK_US
}

/// The bits of a tick's output.
pub fn bits(output: &TickOutput) -> Vec<u8> {
    let mut buffer = [0; MAX_STUFFED];
    postcard::to_slice(output, &mut buffer).unwrap().to_vec()
}

/// Repeats on the host what the flight computer reports that it did, and compares every tick with the host's
/// bits; returns the host's latch.
pub fn same_on_the_host(flown: &RawFlight) -> Option<LatchRecord> {
    on_the_host(flown).0
}

/// As [`same_on_the_host`]; also returns what the host would have sent from each start on.
pub fn on_the_host(flown: &RawFlight) -> (Option<LatchRecord>, Vec<Vec<u8>>) {
    let model = model();
    let mut host = mission(&model).unwrap();
    let mut snapshots = Vec::new();
    let mut restarts = flown.restarts.iter().peekable();
    let new_line = || Downlink::new(Box::leak(Box::new(FrameQueue::new())), &model, Rates::FULL);
    let (mut line, mut lines) = (new_line(), Vec::new());
    for (k, TickRecord { input, output, .. }) in flown.ticks.iter().enumerate() {
        while let Some((_, report)) = restarts.next_if(|(ticks, _)| *ticks == k) {
            lines.push(std::mem::replace(&mut line, new_line()).into_bytes());
            line.note_start(report);
            host = mission(&model).unwrap();
            if let Some(snapshot_us) = report.snapshot_us {
                let kept = |(time_us, _): &&(u64, Vec<u8>)| *time_us == snapshot_us;
                let (_, snapshot) = snapshots.iter().find(kept).unwrap();
                let restored = host.restore_snapshot(snapshot, &mission_mark(&report.mark.unwrap()));
                assert_eq!(restored, Ok(snapshot_us));
            }
        }
        let expected = host.tick(input);
        assert_eq!(bits(&expected), bits(output), "tick {k} at {} us", output.time_us);
        line.tell(input, output, &*host, &ComputerStatus::default());
        if let Some(snapshot) = host.snapshot() {
            let mut bytes = [0; MAX_SNAPSHOT_BYTES];
            let length = snapshot.to_bytes(&mut bytes).unwrap();
            snapshots.push((output.time_us, bytes[..length].to_vec()));
        }
    }
    lines.push(line.into_bytes());
    (host.latch().cloned(), lines)
}

/// The report of the only restart, which continues in free flight, and the first tick after it.
pub fn resumed(flown: &RawFlight) -> (RestartReport, &TickRecord) {
    let (ticks, report) = &flown.restarts[0];
    assert_eq!(report.start, Start::Resumed, "{:?}", flown.log);
    let latch = same_on_the_host(flown);
    assert_eq!(flown.latches, [latch.unwrap()], "latched once, and the same bits after the restart");
    let first = &flown.ticks[*ticks];
    assert_eq!(first.output.phase, Phase::FreeFlight);
    let snapshot_us = report.snapshot_us.unwrap();
    assert_eq!(first.output.bridged_us, Some(first.output.time_us - snapshot_us));
    let mark_us = report.mark.unwrap().time_us;
    // A snapshot is taken every 0.1 s, and the task that keeps it runs within a tick.
    assert!(mark_us - snapshot_us <= 105_000, "{report:?}");
    (*report, first)
}
