//! Which physical effect a model lacks: [`analysis::diagnose`] run on the machine's threads, and its text.

pub(crate) mod text;

use std::ops::ControlFlow;

use executor::Executor;

pub use analysis::diagnose::*;
pub use text::text;

use crate::threads::Threads;

/// Finds what the model lacks; all replays must have the same model. `progress` is called once a fit.
#[must_use]
pub fn diagnose(
    flights: &[NamedReplay<'_>],
    hold_outs: &[NamedReplay<'_>],
    progress: &mut dyn FnMut(),
) -> Diagnosis {
    diagnose_by(&Threads, flights, hold_outs, progress)
}

/// As [`diagnose`], with another executor.
pub(crate) fn diagnose_by(
    executor: &dyn Executor,
    flights: &[NamedReplay<'_>],
    hold_outs: &[NamedReplay<'_>],
    progress: &mut dyn FnMut(),
) -> Diagnosis {
    let found = analysis::diagnose::diagnose(flights, hold_outs, &mut endless(progress), executor);
    found.unwrap_or_else(|_| unreachable!("it is never cancelled"))
}

/// Diagnoses flights with a model that lacks an effect; also returns the problem from which that effect's
/// coefficient is learned.
#[must_use]
pub fn study(
    flights: &[NamedReplay<'_>],
    hold_outs: &[NamedReplay<'_>],
    wanted: WantedEffect,
    progress: &mut dyn FnMut(),
) -> (Diagnosis, Option<LearningProblem>) {
    let found = analysis::diagnose::study(flights, hold_outs, wanted, &mut endless(progress), &Threads);
    found.unwrap_or_else(|_| unreachable!("it is never cancelled"))
}

/// Progress of work that is never cancelled.
pub(crate) fn endless(progress: &mut dyn FnMut()) -> impl FnMut() -> ControlFlow<()> + '_ {
    || {
        progress();
        ControlFlow::Continue(())
    }
}
