//! A sample of the fault campaign in QEMU: short flights with their faults, every tick with the host's bits,
//! and none over the budget. Ten runs; `cargo xtask campaign --qemu 50` flies more.
//!
//! Needs qemu-system-arm and the Rust target; without them the test fails and says what to install
//! (`cargo xtask test` installs it).
#![allow(clippy::unwrap_used, clippy::panic)]

use std::env;
use std::sync::atomic::{AtomicUsize, Ordering};

use flight_computer::{Estimation as _, Retainable as _, mission_mark};
use flight_record::{Blow, ExitStatus, MAX_STUFFED, Strike, TickRecord};
use host_tests::budget::Budgets;
use host_tests::campaign::fault::{DipTick, Drawn, Place};
use host_tests::campaign::flight::{FIRST_US, TICK_US};
use host_tests::campaign::run::Case;
use kf_core::input::TickInput;
use kf_core::output::TickOutput;
use kf_core::snapshot::MAX_SNAPSHOT_BYTES;
use model::Model;
use pylon::fly::{
    FlyOptions, PlannedFault, RawFlight, SensorSource, fly_inputs, fly_on_host, fly_struck_on_chips,
};
use pylon::replay::mission;

/// Ticks from the wire's opening to the confirmed launch in nearly every flight: the debounce.
const LATCH_TICKS: usize = 4;

fn number(name: &str, default: u64) -> u64 {
    env::var(name)
        .map_or(default, |text| text.parse().unwrap_or_else(|_| panic!("{name}={text} is no number")))
}

fn seconds(tick: usize) -> f64 {
    (FIRST_US + tick as u64 * TICK_US) as f64 * 1e-6
}

/// The faults of chips in a flight record's form.
fn planned(faults: &[Drawn]) -> Vec<PlannedFault> {
    let mut planned: Vec<PlannedFault> = Vec::new();
    for fault in faults {
        for (place, (tick, event)) in fault.events.iter().enumerate() {
            if event.fault == chip_models::flown::Fault::None {
                continue;
            }
            let next = fault.events.get(place + 1).map_or(fault.to, |(tick, _)| *tick);
            let end = (!event.fault.is_once()).then_some(seconds(next));
            let is_taken =
                planned.iter().any(|one| one.fault.chip == event.chip && one.start_s == seconds(*tick));
            // A record holds one event of a chip at a time.
            if !is_taken && end != Some(seconds(*tick)) {
                // A fault that lasts until the next event ends a tick before it.
                let end_s =
                    end.map(|end_s| if place + 2 < fault.events.len() { end_s - 0.005 } else { end_s });
                planned.push(PlannedFault { fault: *event, start_s: seconds(*tick), end_s });
            }
        }
    }
    planned
}

/// The dips of the supply as resets at a tick's end.
fn strikes(case: &Case) -> Vec<Strike> {
    let edge = case.plan.separation() + case.plan.slack_ticks;
    let at = |tick: DipTick| match tick {
        DipTick::At(tick) => tick,
        DipTick::Edge(after) => edge + after,
        DipTick::Latch(after) => edge + LATCH_TICKS + after,
    };
    let dips = case.faults.iter().flat_map(|fault| &fault.dips);
    dips.map(|dip| Strike { blow: Blow::Reset, time_us: FIRST_US + at(dip.tick) as u64 * TICK_US })
        .take(8)
        .collect()
}

fn bits(output: &TickOutput) -> Vec<u8> {
    let mut buffer = [0; MAX_STUFFED];
    postcard::to_slice(output, &mut buffer).unwrap().to_vec()
}

/// Compares an interrupted flight with the host's: the whole chain up to the first restart, and from there on
/// the mission, continued from the snapshots that the flight computer reports.
fn check_struck(flown: &RawFlight, inputs: &[TickInput], faults: &[PlannedFault], what: &str) {
    let model = Model::default();
    let mut chain = Vec::new();
    let options =
        FlyOptions { sensors: SensorSource::Chips, faults: faults.to_vec(), ..FlyOptions::default() };
    fly_on_host(inputs.iter().copied(), &model, &options, &mut |step, _| chain.push(step.clone())).unwrap();
    let first_restart = flown.restarts.first().map_or(flown.ticks.len(), |(ticks, _)| *ticks);
    for (k, (host, target)) in chain.iter().zip(&flown.ticks).take(first_restart).enumerate() {
        assert_eq!(host.input, target.input, "{what}, tick {k}");
        assert_eq!(bits(&host.output), bits(&target.output), "{what}, tick {k}");
    }
    let mut host = mission(&model).unwrap();
    let mut snapshots = Vec::new();
    let mut restarts = flown.restarts.iter().peekable();
    for (k, TickRecord { input, output, .. }) in flown.ticks.iter().enumerate() {
        while let Some((_, report)) = restarts.next_if(|(ticks, _)| *ticks == k) {
            host = mission(&model).unwrap();
            if let Some(snapshot_us) = report.snapshot_us {
                let kept = |(time_us, _): &&(u64, Vec<u8>)| *time_us == snapshot_us;
                let (_, snapshot) = snapshots.iter().rfind(kept).unwrap();
                let restored = host.restore_snapshot(snapshot, &mission_mark(&report.mark.unwrap()));
                assert_eq!(restored, Ok(snapshot_us), "{what}");
            }
        }
        let expected = host.tick(input);
        assert_eq!(bits(&expected), bits(output), "{what}, tick {k} at {} us", output.time_us);
        if let Some(snapshot) = host.snapshot() {
            let mut bytes = [0; MAX_SNAPSHOT_BYTES];
            let length = snapshot.to_bytes(&mut bytes).unwrap();
            snapshots.push((output.time_us, bytes[..length].to_vec()));
        }
    }
}

/// Flies a run; returns the instructions of its most expensive tick.
fn fly(seed: u64, case: &Case) -> u32 {
    let names: Vec<_> = case.faults.iter().map(|fault| fault.name).collect();
    let what = format!("run {}, {}", case.index, names.join(" and "));
    let inputs: Vec<TickInput> = case.rows(seed).into_iter().map(|row| row.input).collect();
    let faults = planned(&case.faults);
    let strikes = strikes(case);
    let worst = if strikes.is_empty() {
        let options = FlyOptions { sensors: SensorSource::Chips, faults, ..FlyOptions::default() };
        let report = fly_inputs(inputs.iter().copied(), &Model::default(), &options)
            .unwrap_or_else(|error| panic!("{what}: {error}"));
        assert_eq!(report.ticks as usize, inputs.len(), "{what}");
        report.instructions_worst
    } else {
        let flown = fly_struck_on_chips(inputs.iter().copied(), &Model::default(), &faults, &strikes)
            .unwrap_or_else(|error| panic!("{what}: {error}"));
        assert_eq!(flown.status, Some(ExitStatus::Finished), "{what}: {:?}", flown.log);
        assert!(!flown.restarts.is_empty(), "{what}");
        check_struck(&flown, &inputs, &faults, &what);
        flown.summary.unwrap().cost_worst
    };
    println!("{what}: {worst} instructions at worst");
    worst
}

#[test]
fn a_sample_of_the_campaign_has_the_same_bits_in_qemu() {
    let (runs, seed) = (number("PYLON_CAMPAIGN_RUNS", 10) as usize, number("PYLON_CAMPAIGN_SEED", 1));
    // A record's clock does not jump: the flight computer's grid of ticks has no gaps.
    let is_possible =
        |case: &Case| case.faults.iter().all(|fault| !matches!(fault.place, Place::Clock | Place::Program));
    let cases: Vec<Case> =
        (0..).map(|index| Case::draw(seed, index, true)).filter(is_possible).take(runs).collect();
    let next = AtomicUsize::new(0);
    let (cases, next) = (&cases, &next);
    let worst = std::thread::scope(|scope| {
        let fly_some = move || {
            let mut worst = 0;
            while let Some(case) = cases.get(next.fetch_add(1, Ordering::Relaxed)) {
                worst = worst.max(fly(seed, case));
            }
            worst
        };
        let others = [scope.spawn(fly_some), scope.spawn(fly_some)];
        others.map(|one| one.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
    });
    let worst = worst.into_iter().max().unwrap();
    println!("{runs} runs, {worst} instructions at worst");
    let budgets = Budgets::read().unwrap();
    let unexpected = budgets.unexpected(&[budgets.check_campaign(worst)]);
    assert!(unexpected.is_empty(), "{unexpected:#?}");
}
