//! Several flights, one by one: [`analysis::batch`] with the machine's threads, and its text.

mod text;

use crate::diagnose::{Diagnosis, NamedReplay};
use crate::threads::Threads;

pub use analysis::batch::*;
pub use text::text;

/// Diagnoses every flight by itself. `together` is the diagnosis of all; `progress` is called once a flight.
/// A flight that the diagnosis panics on costs none of the others.
#[must_use]
pub fn batch(
    flights: &[NamedReplay<'_>],
    together: Option<&Diagnosis>,
    progress: &(dyn Fn() + Sync),
) -> Batch {
    analysis::batch::batch(flights, together, progress, &Threads)
}
