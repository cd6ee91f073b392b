//! Which physical effect a model lacks: [`analysis::diagnose`] with the machine's threads, and its text.

pub(crate) mod text;

use std::ops::ControlFlow;

use executor::Executor;

pub use analysis::diagnose::*;
pub use text::text;

use crate::threads::Threads;

/// Finds what the model lacks; all replays have the same model. `progress` is called once a fit.
#[must_use]
pub fn diagnose(
    flights: &[NamedReplay<'_>],
    hold_outs: &[NamedReplay<'_>],
    progress: &mut dyn FnMut(),
) -> Diagnosis {
    diagnose_by(&Threads, flights, hold_outs, progress)
}

/// The same, by another executor.
pub(crate) fn diagnose_by(
    executor: &dyn Executor,
    flights: &[NamedReplay<'_>],
    hold_outs: &[NamedReplay<'_>],
    progress: &mut dyn FnMut(),
) -> Diagnosis {
    let found = analysis::diagnose::diagnose(flights, hold_outs, &mut endless(progress), executor);
    found.unwrap_or_else(|_| unreachable!("it is never cancelled"))
}

/// A diagnosis of flights with a model that lacks an effect, and what that effect's coefficient is to be
/// learned from.
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

/// Progress of work that nobody ends.
pub(crate) fn endless(progress: &mut dyn FnMut()) -> impl FnMut() -> ControlFlow<()> + '_ {
    || {
        progress();
        ControlFlow::Continue(())
    }
}
