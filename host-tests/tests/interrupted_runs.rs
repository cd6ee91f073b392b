//! A flight computer on the host that is interrupted at every word that it writes, and continues with the
//! firmware's code.
#![allow(clippy::unwrap_used)]

mod ticks;

use drivers::{Device, Faults, Sensors};
use flight_computer::{Interruptible, ResetFacts, Step};
use kf_core::input::{LaunchDoubt, TickInput};
use kf_core::latch::LatchRecord;
use kf_core::output::Phase;
use kf_core::quality::{Check, FailedChecks};
use model::Model;
use pylon::replay::{AnyMission, mission};
use survival::{Cause, CrashRecord, ResetSource, RestartReport, RetainedImage, Start, keep_crash};
use ticks::{LAUNCH, TICK_US, TICKS, flight, prompt};

const MODEL: u64 = 7;
/// How long a launch is suspected before its confirmation, ticks: the debounce.
const DEBOUNCE: usize = 4;

/// The flight of a recording, whose launch is suspected before it is confirmed.
struct Recording {
    inputs: Vec<TickInput>,
    next: usize,
}

impl Sensors for &mut Recording {
    fn poll_each(&mut self, now_us: u64, _: &mut impl FnMut(Device)) -> TickInput {
        let input = self.inputs[self.next];
        self.next += 1;
        assert_eq!(input.time_us, now_us);
        input
    }

    fn faults(&self) -> Faults {
        Faults::default()
    }

    fn wire(&self) -> Option<bool> {
        None
    }

    fn decided(&mut self, _: bool) {}
}

type Run<'a> = Interruptible<&'a mut Recording, Box<dyn AnyMission>>;

/// A flight, its retained memory, and its results.
struct Flight {
    recording: Recording,
    memory: RetainedImage,
    reports: Vec<RestartReport>,
    last: Option<Step>,
}

impl Flight {
    fn new() -> Self {
        let mut inputs = flight();
        for (k, input) in inputs.iter_mut().enumerate().skip(LAUNCH - DEBOUNCE) {
            input.launch_doubt = if k < LAUNCH { LaunchDoubt::Suspected } else { LaunchDoubt::Unconfirmed };
        }
        let recording = Recording { inputs, next: 0 };
        Self { recording, memory: RetainedImage::default(), reports: Vec::new(), last: None }
    }

    /// Starts and flies up to tick `end`; the last tick's writing is cut off after that many words.
    fn run(&mut self, source: ResetSource, end: usize, cut: Option<u32>) -> Option<LatchRecord> {
        self.fly(source, |_| end, cut)
    }

    /// As [`Self::run`], to an end that depends on the first tick after the start.
    fn fly(
        &mut self,
        source: ResetSource,
        end: impl FnOnce(usize) -> usize,
        cut: Option<u32>,
    ) -> Option<LatchRecord> {
        self.memory.restore_supply();
        let model = prompt(Model::default());
        let facts = ResetFacts::host(source, Some(self.recording.next + DEBOUNCE >= LAUNCH));
        let mission = mission(&model).unwrap();
        let mut run: Run<'_> =
            Interruptible::start(&mut self.recording, mission, None, &mut self.memory, MODEL, facts).unwrap();
        self.reports.extend(run.report());
        let from_us = run.report().map_or(0, |report| report.resumed_us);
        let recording = &mut run.computer.sensors;
        recording.next = recording.inputs.partition_point(|input| input.time_us < from_us);
        let end = end(recording.next);
        while run.computer.sensors.next < end {
            let now = run.computer.sensors.next;
            if let Some(words) = cut.filter(|_| now + 1 == end) {
                self.memory.cut_after(words);
            }
            let now_us = run.computer.sensors.inputs[now].time_us;
            self.last = Some(run.tick(&mut self.memory, now_us));
        }
        run.computer.mission.latch().cloned()
    }

    fn last_output(&self) -> &kf_core::output::TickOutput {
        &self.last.as_ref().unwrap().output
    }
}

fn undisturbed() -> LatchRecord {
    Flight::new().run(ResetSource::Supply, TICKS, None).unwrap()
}

/// Whether a latch is the same except for checks that had not been made when it was interrupted.
fn is_same_calibration(latch: &LatchRecord, whole: &LatchRecord) -> bool {
    *latch == LatchRecord { failed_checks: latch.failed_checks, ..whole.clone() }
}

/// A mark is five words; the sixth word that a tick and its task write begins a snapshot.
const MARK_WORDS: u32 = 5;

#[test]
fn a_dip_at_any_word_from_the_first_edge_to_free_flight_keeps_the_calibration_from_the_first_whole_snapshot_on()
 {
    let whole = undisturbed();
    let words = |tick: usize| {
        // Every word of the marks, the first and last words of the first snapshot, and some between.
        let all: Vec<u32> = (0..=MARK_WORDS + 8).chain((20..520).step_by(37)).collect();
        all.into_iter().map(move |word| (tick, word))
    };
    for (tick, word) in (LAUNCH - DEBOUNCE..=LAUNCH + 2).flat_map(words) {
        let mut flight = Flight::new();
        flight.run(ResetSource::Supply, tick + 1, Some(word));
        let latch = flight.run(ResetSource::Supply, TICKS, None).unwrap();
        let report = flight.reports[0];
        assert_eq!((report.cause, report.restarts, flight.reports.len()), (Cause::Supply, 1, 1));
        let expected = match tick {
            // The edge's own tick: the task keeps what it holds, complete or not.
            tick if tick == LAUNCH - DEBOUNCE && word < MARK_WORDS => {
                assert_eq!(report.start, Start::Captive, "{tick} {word}");
                continue;
            }
            tick if tick == LAUNCH - DEBOUNCE => [Start::Suspected, Start::Captive],
            tick if tick < LAUNCH || tick == LAUNCH && word < MARK_WORDS => [Start::Suspected; 2],
            _ => [Start::Resumed; 2],
        };
        assert!(expected.contains(&report.start), "{tick} {word}: {report:?}");
        if report.start == Start::Captive {
            assert!(report.refused.iter().all(|refusal| refusal.is_some()), "{tick} {word}: {report:?}");
            assert!(
                FailedChecks::from_bits(latch.failed_checks).contains(Check::LongEnough),
                "{tick} {word}"
            );
        } else {
            assert!(is_same_calibration(&latch, &whole), "{tick} {word}");
            assert_eq!(flight.last_output().phase, Phase::FreeFlight);
        }
    }
}

/// The separation itself may disturb the supply.
#[test]
fn any_number_of_dips_ends_no_mission_and_costs_no_latch() {
    let whole = undisturbed();
    let mut flight = Flight::new();
    flight.run(ResetSource::Supply, LAUNCH + 3, Some(2));
    for dip in 1..=20 {
        let next = flight.recording.next + 8;
        let latch = flight.run(ResetSource::Supply, next, Some(dip)).unwrap();
        assert_eq!(latch, whole, "{dip}");
    }
    let latch = flight.run(ResetSource::Supply, TICKS, None).unwrap();
    assert_eq!(latch, whole);
    assert_eq!(flight.reports.len(), 21);
    for (report, restarts) in flight.reports.iter().zip(1..) {
        assert_eq!((report.start, report.pause_us, report.restarts), (Start::Resumed, 0, restarts));
    }
}

/// A program that crashes as soon as it runs stands by for increasing times, and continues with the latch
/// whenever it tries.
#[test]
fn crashes_in_a_row_back_off_and_the_latch_is_there_when_they_end() {
    let whole = undisturbed();
    let mut flight = Flight::new();
    let again = flight.recording.inputs[TICKS - 40..].to_vec();
    flight.recording.inputs.extend(
        (TICKS..24_000).map(|k| TickInput { time_us: 1_000_000 + k as u64 * TICK_US, ..again[k % 40] }),
    );
    flight.run(ResetSource::Supply, LAUNCH + 3, None);
    let mut pauses_s = Vec::new();
    for _ in 0..10 {
        let last_us = flight.last_output().time_us;
        let crash = CrashRecord { count: last_us as u32 + 1_000, ..CrashRecord::new(Cause::Panic) };
        keep_crash(&mut flight.memory, crash);
        let latch = flight.fly(ResetSource::Software, |first| first + 10, None).unwrap();
        assert_eq!(latch, whole);
        let report = flight.reports.last().unwrap();
        assert_eq!((report.start, report.cause), (Start::Resumed, Cause::Panic));
        // 1 ms until it crashed, and 15 ms for the restart.
        assert_eq!(report.resumed_us, last_us + 1_000 + 15_000 + report.pause_us);
        pauses_s.push(report.pause_us / 1_000_000);
    }
    assert_eq!(pauses_s, [0, 0, 0, 1, 2, 4, 8, 16, 16, 16]);
    // After four seconds without a crash, the next one counts as the first again.
    flight.fly(ResetSource::Pin, |first| first + 800, None);
    let crash = CrashRecord { count: flight.last_output().time_us as u32, ..CrashRecord::new(Cause::Stuck) };
    keep_crash(&mut flight.memory, crash);
    assert_eq!(flight.fly(ResetSource::Software, |first| first + 10, None).unwrap(), whole);
    let report = flight.reports.last().unwrap();
    assert_eq!((report.pause_us, report.restarts), (0, 12));
}
