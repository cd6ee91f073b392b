//! A campaign without findings proves something only if it can detect errors: each guard is removed in turn,
//! and the runs with the faults that it is for are flown again.

use anyhow::Result;
use kf_core::guard::Guard;

use super::fault::{Drawn, Phase, Place};
use super::fly;
use super::judge::{Invariant, Verdict};
use super::run::Case;

/// Largest number of runs per guard.
const RUNS: usize = 120;

/// Result of the campaign without a guard.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// The guard.
    pub guard: Guard,
    /// Runs flown with and without it.
    pub runs: usize,
    /// Runs that break something only without the guard, each with the broken invariant.
    pub reports: Vec<(u64, Invariant)>,
}

/// Whether a guard is meant for this fault.
fn concerns(guard: Guard, fault: &Drawn) -> bool {
    let is_captive = fault.phase <= Phase::BeforeLaunch;
    let is_named = |words: &[&str]| words.iter().any(|word| fault.name.contains(word));
    let lies = is_named(&["data bits", "spike", "single fixes", "offset", "jumps", "lies", "noise"]);
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

/// Removes a guard, and flies the runs that it is meant for; `cases` and their verdicts with every guard are
/// given.
///
/// # Errors
/// The model does not make a mission.
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
