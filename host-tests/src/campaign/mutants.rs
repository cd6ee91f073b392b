//! A campaign that finds nothing proves something only if it finds what is wrong: each guard is taken out in
//! turn, and the runs whose faults it is there for are flown again.

use anyhow::Result;
use kf_core::guard::Guard;

use super::fault::{Drawn, Phase, Place};
use super::fly;
use super::judge::{Invariant, Verdict};
use super::run::Case;

/// So many runs at most for a guard.
const RUNS: usize = 120;

/// What the campaign says of a guard that is taken out.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// The guard.
    pub guard: Guard,
    /// Runs that were flown with and without it.
    pub runs: usize,
    /// Runs that break something without it which they keep with it, each with what it breaks.
    pub reports: Vec<(u64, Invariant)>,
}

/// Whether a fault is one that a guard is there for.
fn concerns(guard: Guard, fault: &Drawn) -> bool {
    let is_captive = fault.phase <= Phase::BeforeLaunch;
    let is_named = |words: &[&str]| words.iter().any(|word| fault.name.contains(word));
    let lies = is_named(&["data bits", "spike", "single fixes", "off by", "jumps", "lies", "noise"]);
    match guard {
        Guard::InnovationGate | Guard::RobustSigma => is_captive && lies,
        Guard::PlausibleReading => lies,
        Guard::FilledWindow => !is_captive && lies,
        Guard::ReferenceJump => !is_captive && fault.place == Place::Gps,
        Guard::ListenUntilDecided => is_captive && fault.place == Place::Wire,
        Guard::KnownSender => is_named(&["stranger"]),
        Guard::ClosedWireHolds => is_named(&["free fall"]),
        Guard::ReadBackAgain => is_named(&["on the bus", "configuration", "register"]) && !is_captive,
        Guard::UbxOnly => is_named(&["generation 8", "setting"]),
        Guard::TieKnowsGaps => is_captive && fault.place == Place::Gps,
        Guard::InertialBridge => fault.place == Place::Imu,
        Guard::OnlyCrashesCount => is_named(&["series"]),
        Guard::StandbyEnds => is_named(&["crashes in a row"]),
    }
}

/// Takes out a guard, and flies the runs that it is there for; `cases` and what they came to with every
/// guard.
///
/// # Errors
/// The model makes no mission.
pub fn without(
    guard: Guard,
    seed: u64,
    cases: &[Case],
    verdicts: &[Verdict],
    done: &(impl Fn() + Sync),
) -> Result<Outcome> {
    let concerned = |case: &Case| case.faults.iter().any(|fault| concerns(guard, fault));
    let (chosen, with): (Vec<Case>, Vec<&Verdict>) = cases
        .iter()
        .zip(verdicts)
        .filter(|(case, _)| concerned(case))
        .take(RUNS)
        .map(|(case, verdict)| (case.clone(), verdict))
        .unzip();
    Guard::remove_only(&[guard]);
    let without = fly(seed, &chosen, done);
    Guard::remove_only(&[]);
    let reports = chosen
        .iter()
        .zip(with.iter().zip(without?))
        .filter_map(|(case, (with, without))| {
            let is_new = |one: &Invariant| !with.violations.iter().any(|known| known.invariant == *one);
            let new = without.violations.iter().map(|violation| violation.invariant).find(is_new);
            new.map(|invariant| (case.index, invariant))
        })
        .collect();
    Ok(Outcome { guard, runs: chosen.len(), reports })
}
