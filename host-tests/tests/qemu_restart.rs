//! The emulated flight computer is reset, crashed and poisoned in flight, and continues: with the host's
//! bits, the same latch, every flag, and a report of what happened.
//!
//! Needs qemu-system-arm and the Rust target; without them the tests fail and say what to install
//! (`cargo xtask test` installs it).
#![allow(clippy::unwrap_used, clippy::panic)]

mod mavlink_client;
mod restarts;
mod ticks;

use flight_record::{
    Blow, Encoder, End, ExitStatus, Header, MAX_STUFFED, SensorSource, Stream, Strike, TickRecord,
};
use host_tests::budget::Budgets;
use kf_core::input::{BaroReading, LaunchDoubt, TickInput};
use kf_core::latch::LatchRecord;
use kf_core::output::{Phase, TickOutput, Trust};
use kf_core::quality::{Check, FailedChecks};
use kf_core::snapshot::RaisedFlags;
use pylon::fly::{FlyOptions, RawFlight, fly_on_host, fly_struck};
use pylon::replay::mission;
use survival::{Cause, Late, Refusal, RestartReport, Start, Supervised};
use telemetry::MAX_FRAME;

use mavlink_client::{decode, gaps, of, texts, whole};
use restarts::{OUTAGE_US, at, bits, model, on_the_host, resumed, same_on_the_host};
use ticks::{LAUNCH, TICK_US, TICKS, flight, must};

/// How late anything may be before the watchdog strikes, microseconds.
const WATCHDOG_US: u64 = 250_000;

fn record(inputs: &[TickInput], sensors: SensorSource) -> Vec<u8> {
    let mut encoder = Encoder::new();
    let mut buffer = [0; MAX_STUFFED];
    let header = Header::new(Stream::Inputs, model().fingerprint().unwrap(), sensors);
    let mut bytes = encoder.encode(&header, &mut buffer).unwrap().to_vec();
    for input in inputs {
        bytes.extend(encoder.encode(input, &mut buffer).unwrap());
    }
    let end = End { inputs: u32::try_from(inputs.len()).unwrap() };
    bytes.extend(encoder.encode(&end, &mut buffer).unwrap());
    bytes
}

fn struck_on(inputs: &[TickInput], blows: &[(Blow, usize)]) -> RawFlight {
    let strikes: Vec<Strike> = blows.iter().map(|&(blow, tick)| Strike { blow, time_us: at(tick) }).collect();
    must(fly_struck(&record(inputs, SensorSource::Ideal), &model(), &strikes))
}

fn struck(blows: &[(Blow, usize)]) -> RawFlight {
    let flight = struck_on(&flight(), blows);
    assert_eq!(flight.status, Some(ExitStatus::Finished), "{:?}", flight.log);
    assert_eq!(flight.restarts.len(), blows.len(), "{:?}", flight.log);
    let summary = flight.summary.as_ref().unwrap();
    assert_eq!(summary.restarts as usize, blows.len());
    assert_eq!((summary.lost_snapshots, summary.bad_frames, summary.missed_frames), (0, 0, 0));
    assert!(!summary.input_cut, "every input was flown or passed over, and counted");
    flight
}

/// Compares the bytes on the line before and after the only restart with the host's, and returns the texts
/// from then on, with their severities, as read by pymavlink.
fn told(flown: &RawFlight) -> Vec<(i64, String)> {
    let (_, lines) = on_the_host(flown);
    let [before, after] = lines.as_slice() else { panic!("{} starts", lines.len()) };
    let sent = &flown.telemetry;
    let same = sent.iter().zip(before).take_while(|(one, other)| one == other).count();
    // The reset may have come within a frame, and both sides of it begin as every frame does.
    let split = (0..=same).rev().find(|split| after.starts_with(&sent[*split..])).unwrap();
    let waiting = [before.len() - split, after.len() - (sent.len() - split)];
    assert!(waiting.iter().all(|bytes| *bytes < 31 * MAX_FRAME), "{waiting:?}");
    let messages = decode(&sent[split..]);
    assert_eq!(gaps(&messages), 0);
    of(&messages, "STATUSTEXT")
        .into_iter()
        .map(|text| whole(text, "severity"))
        .zip(texts(&messages))
        .collect()
}

/// The texts reported for a start, in the order of the flight; the time is that at which the clock continues.
fn start_texts(report: &RestartReport, texts: &[(i64, &str)]) -> Vec<(i64, String)> {
    let at = seconds(report.resumed_us);
    texts.iter().map(|(severity, text)| (*severity, format!("t={at} {text}"))).collect()
}

/// A time in the texts' form: milliseconds, truncated.
fn seconds(time_us: u64) -> String {
    format!("{}.{:03}", time_us / 1_000_000, time_us / 1_000 % 1_000)
}

/// Checks the cost of the restart; `-- --nocapture` shows it.
fn assert_keeps_budget(flown: &RawFlight) {
    let instructions = flown.summary.as_ref().unwrap().start_cost.unwrap();
    let summary = flown.summary.as_ref().unwrap();
    let budgets = Budgets::read().unwrap();
    let checks = budgets.check_restart(instructions, summary.stack_used_bytes);
    checks.iter().for_each(|check| println!("{}", check.line()));
    let unexpected = budgets.unexpected(&checks);
    assert!(unexpected.is_empty(), "{unexpected:#?}");
    // Painting the stack alone, 28 KiB, takes more than that: otherwise the counter did not count.
    assert!(instructions > 10_000, "{instructions}");
}

#[test]
fn a_reset_in_free_flight_resumes_with_the_same_latch_and_the_hosts_bits() {
    let flown = struck(&[(Blow::Reset, LAUNCH + 700)]);
    let (report, first) = resumed(&flown);
    assert_eq!((report.cause, report.crash, report.restarts), (Cause::Unrecorded, None, 1));
    assert_eq!(report.mark.unwrap().time_us, at(LAUNCH + 700));
    assert_eq!(report.resumed_us, at(LAUNCH + 700) + OUTAGE_US);
    assert_eq!(first.output.time_us, report.resumed_us);
    // The result of the struck tick was lost; 19 more precede the time at which the clock continues.
    let missing = (OUTAGE_US / TICK_US) as usize;
    assert_eq!(flown.ticks.len(), TICKS - missing);
    assert_keeps_budget(&flown);
    assert!(flown.log.iter().any(|line| line.contains("restart 1 (resumed) after a reset without a record")));
}

/// A ground station that has seen the flight receives, byte for byte as from the host, that the flight
/// computer restarted, the cause, and the length of the gap.
#[test]
fn every_restart_is_told_with_its_cause_and_its_gap() {
    for (blow, cause) in [
        (Blow::Reset, "a reset without a record"),
        (Blow::Panic, "a panic"),
        (Blow::Fault, "a hard fault"),
        (Blow::StackOverflow, "a stack overflow"),
        (Blow::HangTick, "something stuck"),
    ] {
        let flown = struck(&[(blow, LAUNCH + 700)]);
        let (report, first) = resumed(&flown);
        let gap_us = report.resumed_us - report.snapshot_us.unwrap();
        assert!(gap_us >= OUTAGE_US);
        // The first tick is the next of the grid.
        assert!((0..TICK_US).contains(&(first.output.bridged_us.unwrap() - gap_us)), "{report:?}");
        let resumed = format!("resumed, {}s not known", seconds(gap_us));
        let expected = start_texts(&report, &[(3, &format!("restart 1: {cause}")), (3, &resumed)]);
        assert_eq!(told(&flown)[..2], expected, "{blow:?}");
    }
}

#[test]
fn with_chips_the_drivers_begin_again_and_the_mission_goes_on() {
    let strike = Strike { blow: Blow::Reset, time_us: at(LAUNCH + 700) };
    let flown = must(fly_struck(&record(&flight(), SensorSource::Chips), &model(), &[strike]));
    assert_eq!(flown.status, Some(ExitStatus::Finished), "{:?}", flown.log);
    let (report, _) = resumed(&flown);
    assert_eq!(report.restarts, 1);
    let after = &flown.ticks[flown.restarts[0].0..];
    // The barometer's driver reads its chip's constants again, one word a tick and all of them twice, and
    // then measures.
    let first_reading = after.iter().position(|tick| tick.input.baro.is_some()).unwrap();
    assert!(first_reading < 2 * 8 + 10, "{first_reading}");
}

/// Where the inertial altitude is the strapdown channel's, it continues as well.
#[test]
fn a_channel_goes_on_after_a_reset() {
    // The channel needs 20 s to align, so the captive part is repeated.
    const MORE: usize = 2_000;
    let longer = flight().into_iter().take(MORE).chain(flight());
    let inputs: Vec<TickInput> = longer
        .enumerate()
        .map(|(k, input)| TickInput { time_us: at(k), imu_slave_altitude_m: None, ..input })
        .collect();
    let strike = Strike { blow: Blow::Reset, time_us: at(MORE + LAUNCH + 700) };
    let flown = must(fly_struck(&record(&inputs, SensorSource::Chips), &model(), &[strike]));
    resumed(&flown);
    let (before, after) = flown.ticks.split_at(flown.restarts[0].0);
    let has_altitude = |tick: &&TickRecord| tick.input.imu_slave_altitude_m.is_some();
    // Twenty a second.
    assert!(before[MORE + LAUNCH + 200..].iter().filter(has_altitude).count() >= 45);
    // All but those of the outage and of the time until the unit delivers again.
    let spoken = after.iter().filter(has_altitude).count();
    assert!(spoken >= after.len() / 10 - 20, "{spoken} of {}", after.len());
    // A detector that started again would wait for an edge that is over.
    assert!(after.iter().all(|tick| tick.input.launch));
    // The channel is flagged before the restart because of this dive, which no accelerometer feels; the flag
    // stays.
    assert!(after.iter().all(|tick| tick.output.sensors[1].trust == Trust::Untrustworthy));
}

#[test]
fn a_reset_in_captive_flight_starts_the_calibration_again_and_says_so() {
    let flown = struck(&[(Blow::Reset, 2_000)]);
    let (ticks, report) = flown.restarts[0];
    assert_eq!((report.start, report.snapshot_us), (Start::Captive, None));
    assert_eq!(flown.ticks[ticks].output.phase, Phase::Settling);
    let latch = same_on_the_host(&flown).unwrap();
    assert_eq!(flown.latches.as_slice(), std::slice::from_ref(&latch));
    // Ten seconds, less the restart and the settling.
    assert!((latch.duration_s - (10.0 - 0.1 - 2.0)).abs() < 0.02, "{}", latch.duration_s);
    assert!(flown.log.iter().any(|line| line.contains("the calibration starts again")));
    let expected = [(3, "restart 1: a reset without a record"), (4, "calibration starts again")];
    assert_eq!(told(&flown)[..2], start_texts(&report, &expected));
}

#[test]
fn at_any_tick_of_the_launch_and_of_free_flight_what_was_latched_is_what_is_there_after_it() {
    for tick in [LAUNCH + 1, LAUNCH + 19, LAUNCH + 20, LAUNCH + 1_337, TICKS - 60] {
        let (report, _) = resumed(&struck(&[(Blow::Reset, tick)]));
        assert_eq!(report.mark.unwrap().time_us, at(tick));
    }
}

/// A recording whose launch is not suspected before it comes, which never happens on a board. It is reset in
/// the tick that latches, before the task that keeps the first snapshot has run, and in the tick before.
/// Neither yields a valid calibration; nor does what was held when the wire bounced, ten seconds ago.
#[test]
fn a_reset_at_a_launch_that_was_never_suspected_latches_nothing_that_would_be_trusted() {
    let refused = [Some(Refusal::OtherLaunch), Some(Refusal::Empty)];
    for (tick, start, refused) in
        [(LAUNCH - 1, Start::Captive, [None, Some(Refusal::Empty)]), (LAUNCH, Start::Lost, refused)]
    {
        let flown = struck(&[(Blow::Reset, tick)]);
        let (ticks, report) = flown.restarts[0];
        assert_eq!((report.start, report.refused), (start, refused), "{:?}", flown.log);
        let latch = same_on_the_host(&flown).unwrap();
        assert!(latch.failed_checks != 0);
        assert!(trusts_nobody(&flown.ticks[ticks..]));
    }
}

/// How long a launch is suspected before its confirmation: the debounce.
const DEBOUNCE: usize = 4;

/// The flight with its launch suspected from that many ticks before its confirmation on, by the wire alone.
fn suspected(ticks: usize) -> Vec<TickInput> {
    let mut inputs = flight();
    for (k, input) in inputs.iter_mut().enumerate().skip(LAUNCH - ticks) {
        input.launch_doubt = if k < LAUNCH { LaunchDoubt::Suspected } else { LaunchDoubt::Unconfirmed };
    }
    inputs
}

/// The latch without an interruption.
fn undisturbed(inputs: &[TickInput]) -> LatchRecord {
    let mut host = mission(&model()).unwrap();
    for input in inputs {
        host.tick(input);
    }
    host.latch().unwrap().clone()
}

/// In the tick that latches, only the mark is written; what it latches was kept while the launch was
/// suspected.
#[test]
fn a_reset_in_the_tick_that_latches_resumes_with_what_it_latched() {
    let inputs = suspected(DEBOUNCE);
    let flown = struck_on(&inputs, &[(Blow::Reset, LAUNCH)]);
    let (ticks, report) = flown.restarts[0];
    assert_eq!((report.start, report.mark.unwrap().time_us), (Start::Resumed, at(LAUNCH)), "{:?}", flown.log);
    // The reset came before the latch was recorded, and nothing is latched twice.
    assert!(flown.latches.is_empty() && !flown.ticks[ticks].output.latched_now);
    let latch = undisturbed(&inputs);
    assert!(FailedChecks::from_bits(latch.failed_checks).contains(Check::LaunchConfirmed));
    assert_eq!(same_on_the_host(&flown).unwrap(), latch);
    let snapshot_us = report.snapshot_us.unwrap();
    assert!((at(LAUNCH - DEBOUNCE)..at(LAUNCH)).contains(&snapshot_us), "{report:?}");
    assert!(!trusts_nobody(&flown.ticks[ticks + 1..]));
}

/// From the tick after the first edge on; and in a suspicion that outlasts the restart. The statistics are
/// judged within three ticks after the edge; checks that a reset leaves unjudged count as failed.
#[test]
fn a_reset_while_a_launch_is_suspected_leaves_the_suspicion_and_what_it_holds() {
    let mut unjudged = FailedChecks::default();
    for check in [
        Check::TrimmedAltitude,
        Check::TrimmedAirspeed,
        Check::ReferenceConverged,
        Check::BiasesStationary,
        Check::InnovationsPlausible,
    ] {
        unjudged.note(check, false);
    }
    for (inputs, tick, unjudged) in [
        (suspected(DEBOUNCE), LAUNCH - DEBOUNCE + 1, unjudged),
        (suspected(DEBOUNCE), LAUNCH - 1, FailedChecks::default()),
        (suspected(100), LAUNCH - 50, FailedChecks::default()),
    ] {
        let flown = struck_on(&inputs, &[(Blow::Reset, tick)]);
        let (ticks, report) = flown.restarts[0];
        assert_eq!(report.start, Start::Suspected, "{:?}", flown.log);
        assert!(flown.log.iter().any(|line| line.contains("restart 1 (suspected)")), "{:?}", flown.log);
        let latch = undisturbed(&inputs);
        let latch = LatchRecord { failed_checks: latch.failed_checks | unjudged.bits(), ..latch };
        assert_eq!(same_on_the_host(&flown).as_ref(), Some(&latch), "{tick}");
        assert_eq!(flown.latches, [latch], "{tick}");
        let latched: Vec<usize> =
            (0..flown.ticks.len()).filter(|k| flown.ticks[*k].output.latched_now).collect();
        let confirmed_us = flown.ticks[ticks].output.time_us.max(at(LAUNCH));
        assert_eq!(
            latched.iter().map(|k| flown.ticks[*k].output.time_us).collect::<Vec<_>>(),
            [confirmed_us]
        );
        assert!(!trusts_nobody(&flown.ticks[latched[0] + 1..]));
        let gap_us = report.resumed_us - report.snapshot_us.unwrap();
        let texts = [
            "restart 1: a reset without a record".to_owned(),
            format!("resumed, {}s not known", seconds(gap_us)),
        ];
        assert_eq!(told(&flown)[..2], start_texts(&report, &[(3, &texts[0]), (3, &texts[1])]));
    }
}

/// In the tick of the first edge nothing of it has been kept yet. What was held when the wire bounced is
/// refused, and the UAV has left without a calibration, which is reported.
#[test]
fn a_reset_in_the_tick_of_the_first_edge_starts_the_calibration_again_and_trusts_nobody() {
    let flown = struck_on(&suspected(DEBOUNCE), &[(Blow::Reset, LAUNCH - DEBOUNCE)]);
    let (ticks, report) = flown.restarts[0];
    let refused = [Some(Refusal::OtherLaunch), Some(Refusal::Empty)];
    assert_eq!((report.start, report.refused), (Start::Captive, refused), "{:?}", flown.log);
    assert!(flown.log.iter().any(|line| line.contains("copy 0 of the snapshot is another launch's")));
    same_on_the_host(&flown);
    assert!(trusts_nobody(&flown.ticks[ticks..]));
    let expected = [
        (3, "restart 1: a reset without a record"),
        (2, "copy 0 refused: another launch's"),
        (4, "calibration starts again"),
    ];
    assert_eq!(told(&flown)[..3], start_texts(&report, &expected));
}

/// On a board the wire, the force and the messages decide: whatever confirms, the tick that latches may be
/// the last one.
#[test]
fn with_chips_a_reset_in_the_tick_that_latches_resumes_with_what_it_latched() {
    let (model, options) = (model(), FlyOptions { sensors: SensorSource::Chips, ..FlyOptions::default() });
    let mut latched_us = None;
    fly_on_host(flight().into_iter(), &model, &options, &mut |step, _| {
        latched_us = latched_us.or(step.output.latched_now.then_some(step.output.time_us));
    })
    .unwrap();
    let strike = Strike { blow: Blow::Reset, time_us: latched_us.unwrap() };
    assert!(strike.time_us > at(LAUNCH));
    let flown = must(fly_struck(&record(&flight(), SensorSource::Chips), &model, &[strike]));
    let (ticks, report) = flown.restarts[0];
    assert_eq!(
        (report.start, report.mark.unwrap().time_us),
        (Start::Resumed, strike.time_us),
        "{:?}",
        flown.log
    );
    let latch = same_on_the_host(&flown).unwrap();
    assert_eq!(latch.time_us, at(LAUNCH), "the first edge's");
    assert!(latch.sensors.iter().all(|sensor| sensor.readings > 300), "{latch:?}");
    assert!(!trusts_nobody(&flown.ticks[ticks + 1..]));
}

fn trusts_nobody(ticks: &[TickRecord]) -> bool {
    let unmonitored =
        |tick: &TickRecord| tick.output.sensors.iter().all(|sensor| sensor.trust == Trust::Unmonitored);
    ticks.iter().all(unmonitored)
}

/// The mission's microseconds exceed 32 bits 71.6 minutes after power-on; the board's own counter, of
/// nanoseconds, wraps every 4.3 s of any flight.
#[test]
fn a_clock_that_leaves_32_bits_changes_no_bit_but_the_times_and_a_restart_bears_it() {
    let wrap_at = |tick: usize| {
        let shift_us = (1 << 32) - at(tick);
        flight().into_iter().map(move |input| TickInput { time_us: input.time_us + shift_us, ..input })
    };
    let plain: Vec<Vec<u8>> = host_outputs(flight().into_iter());
    for (wrap, blow) in [(2_000, None), (LAUNCH + 500, None), (LAUNCH + 701, Some(LAUNCH + 700))] {
        let inputs: Vec<TickInput> = wrap_at(wrap).collect();
        let shift_us = inputs[0].time_us - at(0);
        let strikes = blow.map(|tick| Strike { blow: Blow::Reset, time_us: at(tick) + shift_us });
        let flown = must(fly_struck(&record(&inputs, SensorSource::Ideal), &model(), strikes.as_slice()));
        assert_eq!(flown.status, Some(ExitStatus::Finished), "{:?}", flown.log);
        if blow.is_some() {
            let (report, first) = resumed(&flown);
            assert_eq!(report.resumed_us, at(LAUNCH + 700) + shift_us + OUTAGE_US);
            assert!(report.mark.unwrap().time_us < 1 << 32 && first.output.time_us > 1 << 32);
            continue;
        }
        same_on_the_host(&flown);
        let back = |tick: &TickRecord| {
            bits(&TickOutput { time_us: tick.output.time_us - shift_us, ..tick.output.clone() })
        };
        assert!(flown.ticks.iter().map(back).eq(plain.iter().cloned()), "{wrap}");
    }
}

fn host_outputs(inputs: impl Iterator<Item = TickInput>) -> Vec<Vec<u8>> {
    let mut host = mission(&model()).unwrap();
    inputs.map(|input| bits(&host.tick(&input))).collect()
}

#[test]
fn flags_raised_before_the_restart_are_there_after_it() {
    // The barometer is off for two seconds (an error must last) and right again a tick before the strike:
    // only the retained flags record it.
    let mut inputs = flight();
    for input in &mut inputs[LAUNCH + 290..LAUNCH + 699] {
        input.baro = input.baro.map(|_| BaroReading::AltitudeM(9_000.0));
    }
    let flown = struck_on(&inputs, &[(Blow::Reset, LAUNCH + 699)]);
    let (report, first) = resumed(&flown);
    assert_eq!(first.output.sensors[2].trust, Trust::Untrustworthy);
    assert_eq!(
        RaisedFlags::from_bits(report.mark.unwrap().flags).of(kf_core::sensor::Sensor::Baro),
        Some(Trust::Untrustworthy)
    );
}

#[test]
fn a_panic_is_kept_with_its_place_and_the_flight_goes_on() {
    let (report, _) = resumed(&struck(&[(Blow::Panic, LAUNCH + 700)]));
    let crash = report.crash.unwrap();
    assert_eq!((report.cause, crash.file()), (Cause::Panic, "re/src/strike.rs"));
    assert!(crash.line > 0);
}

#[test]
fn a_hard_fault_is_kept_with_the_programs_place_and_the_flight_goes_on() {
    let flown = struck(&[(Blow::Fault, LAUNCH + 700)]);
    let (report, _) = resumed(&flown);
    let crash = report.crash.unwrap();
    assert_eq!(report.cause, Cause::HardFault);
    // In flash, and an undefined instruction (UFSR.UNDEFINSTR), escalated (HFSR.FORCED).
    assert!((0x0800_0000..0x0810_0000).contains(&crash.pc), "{crash:x?}");
    assert_eq!((crash.cfsr >> 16 & 1, crash.hfsr >> 30 & 1), (1, 1), "{crash:x?}");
    assert!(flown.log.iter().any(|line| line.contains("after a hard fault")), "{:?}", flown.log);
}

#[test]
fn a_stack_overflow_is_caught_at_the_stacks_end_and_the_flight_goes_on() {
    let (report, _) = resumed(&struck(&[(Blow::StackOverflow, LAUNCH + 700)]));
    assert_eq!(report.cause, Cause::StackOverflow, "{report:x?}");
}

#[test]
fn a_tick_that_hangs_and_a_task_that_hangs_are_ended_by_the_watchdog() {
    for (blow, late) in [(Blow::HangTick, Supervised::Tick), (Blow::HangReport, Supervised::Report)] {
        let flown = struck(&[(blow, LAUNCH + 700)]);
        let (ticks, report) = flown.restarts[0];
        assert_eq!((report.start, report.cause), (Start::Resumed, Cause::Stuck), "{:?}", flown.log);
        let crash = report.crash.unwrap();
        assert!(Late::from_bits(crash.late).contains(late), "{crash:x?}");
        assert!((0x0800_0000..0x0810_0000).contains(&crash.pc), "{crash:x?}");
        let outage_us = flown.ticks[ticks].output.time_us - at(LAUNCH + 700);
        if blow == Blow::HangTick {
            resumed(&flown);
            // The watchdog was last fed at the last tick but one, so two ticks less of it are left.
            let range = WATCHDOG_US - 2 * TICK_US + OUTAGE_US..=WATCHDOG_US + OUTAGE_US + TICK_US;
            assert!(range.contains(&outage_us), "{outage_us}");
        } else {
            // The ticks continued until there was no room for their results.
            assert!(!Late::from_bits(crash.late).contains(Supervised::Tick), "{crash:x?}");
        }
    }
}

#[test]
fn one_flipped_bit_costs_the_newest_copy_and_the_one_before_it_is_used() {
    let flown = struck(&[(Blow::FlipBit, LAUNCH + 700)]);
    let (ticks, report) = flown.restarts[0];
    assert_eq!(report.start, Start::Resumed);
    assert_eq!(report.refused.iter().flatten().collect::<Vec<_>>(), [&Refusal::Corrupt]);
    same_on_the_host(&flown);
    let bridged_us = flown.ticks[ticks].output.bridged_us.unwrap();
    assert!((OUTAGE_US + 100_000..=OUTAGE_US + 210_000).contains(&bridged_us), "{bridged_us}");
    assert!(flown.log.iter().any(|line| line.contains("is corrupt")), "{:?}", flown.log);
    let copy = report.refused.iter().position(Option::is_some).unwrap();
    let texts = [
        "restart 1: a reset without a record".to_owned(),
        format!("copy {copy} refused: corrupt"),
        format!("resumed, {}s not known", seconds(bridged_us)),
    ];
    assert_eq!(told(&flown)[..3], start_texts(&report, &[(3, &texts[0]), (2, &texts[1]), (3, &texts[2])]));
}

#[test]
fn garbage_another_models_copies_and_what_is_no_snapshot_are_refused_loudly() {
    for (blow, refusal, word) in [
        (Blow::Garbage, Refusal::Corrupt, "is corrupt"),
        (Blow::OtherModel, Refusal::OtherModel, "is another model's"),
        (Blow::NoSnapshot, Refusal::NotUnderstood, "is another version's"),
    ] {
        let flown = struck(&[(blow, LAUNCH + 700)]);
        let (ticks, report) = flown.restarts[0];
        assert_eq!((report.start, report.snapshot_us), (Start::Lost, None), "{:?}", flown.log);
        assert_eq!(report.refused, [Some(refusal); 2]);
        assert!(flown.log.iter().any(|line| line.contains(word)), "{:?}", flown.log);
        assert!(flown.log.iter().any(|line| line.contains("the latched calibration is lost")));
        // The cold start is launched at once: a latch without data, which reports that, and nothing is
        // trusted.
        same_on_the_host(&flown);
        let first = &flown.ticks[ticks].output;
        assert!(first.latched_now && first.failed_checks != 0);
        assert!(trusts_nobody(&flown.ticks[ticks..]));
        let why = refusal.name();
        let copies = [0, 1].map(|copy| format!("copy {copy} refused: {why}"));
        let expected = [
            (3, "restart 1: a reset without a record"),
            (2, &copies[0]),
            (2, &copies[1]),
            (2, "calibration lost in the restart"),
        ];
        assert_eq!(told(&flown)[..4], start_texts(&report, &expected));
    }
}

#[test]
fn three_blows_apart_are_survived_and_after_four_at_once_it_stands_by_and_goes_on() {
    let flown =
        struck(&[(Blow::Panic, LAUNCH + 400), (Blow::Fault, LAUNCH + 800), (Blow::Reset, LAUNCH + 1_200)]);
    assert!(flown.restarts.iter().all(|(_, report)| report.start == Start::Resumed));
    let latch = same_on_the_host(&flown);
    assert_eq!(flown.latches, [latch.unwrap()]);

    let looping = struck_on(
        &flight(),
        &[(Blow::Fault, 400), (Blow::Fault, 800), (Blow::Fault, 1_200), (Blow::Fault, 1_600)],
    );
    assert_eq!(looping.status, Some(ExitStatus::Finished), "{:?}", looping.log);
    let pauses: Vec<u64> = looping.restarts.iter().map(|(_, report)| report.pause_us).collect();
    assert_eq!(pauses, [0, 0, 0, 1_000_000]);
    let (ticks, report) = looping.restarts.last().unwrap();
    assert_eq!((report.start, report.restarts), (Start::Captive, 4));
    // The microsecond until the fault was recorded may cost a tick, because the record has one every 5 ms.
    let late_us = looping.ticks[*ticks].output.time_us - (at(1_600) + OUTAGE_US + 1_000_000);
    assert!(late_us <= TICK_US, "{late_us}");
    assert!(looping.log.iter().any(|line| line.contains("standby of 1000000 us")), "{:?}", looping.log);
    let told = texts(&decode(&looping.telemetry));
    // During standby, and when it has continued.
    for at_us in [report.resumed_us - report.pause_us, report.resumed_us] {
        let standby = format!("t={} standby 1s: a hard fault", seconds(at_us));
        assert!(told.contains(&standby), "{told:?}");
    }
}
