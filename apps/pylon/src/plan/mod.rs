//! The next flight: [`planning`] on the machine's threads, and its text.

mod text;

use std::ops::ControlFlow;

use analysis::diagnose::{Diagnosis, Further, NamedReplay, Planner, diagnose_further};
use flight_data::Flight;
use model::Model;

pub use planning::shortest::{Aim, HOPELESS, RESOLVED, Shortest, shortest};
pub use planning::*;
pub use text::{is_hopeless, text};

use crate::threads::Threads;

/// Diagnoses flights, with what a plan builds on; nothing of that without a flight. `progress` is called once
/// a fit.
#[must_use]
pub fn diagnose(
    flights: &[NamedReplay<'_>],
    hold_outs: &[NamedReplay<'_>],
    progress: &mut dyn FnMut(),
) -> (Diagnosis, Option<Further>) {
    let found = diagnose_further(flights, hold_outs, &mut crate::diagnose::endless(progress), &Threads);
    found.unwrap_or_else(|_| unreachable!("it is never cancelled"))
}

/// The shortest plan that is found for these flights; `None` where no manoeuvre can be flown. `progress` is
/// called once for each plan that is simulated.
#[must_use]
pub fn suggest(
    planner: &Planner,
    learned: &[&Flight],
    model: &Model,
    progress: &mut dyn FnMut(),
) -> Option<(Shortest, Circumstances)> {
    let planning = Planning::new(planner, learned, model, &Threads);
    let found = shortest(&planning, &mut || {
        progress();
        ControlFlow::Continue(())
    });
    found.map(|found| (found, *planning.around()))
}
