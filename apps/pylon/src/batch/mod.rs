//! Several flights, one by one: [`analysis::batch`] run on the machine's threads, and its text.

mod text;

use crate::diagnose::{Diagnosis, NamedReplay};
use crate::threads::Threads;

pub use analysis::batch::*;
pub use text::text;

/// Diagnoses every flight by itself. `together` is the diagnosis of all flights; `progress` is called once a
/// flight. If the diagnosis panics on one flight, the others are unaffected.
#[must_use]
pub fn batch(
    flights: &[NamedReplay<'_>],
    together: Option<&Diagnosis>,
    progress: &(dyn Fn() + Sync),
) -> Batch {
    analysis::batch::batch(flights, together, progress, &Threads)
}
