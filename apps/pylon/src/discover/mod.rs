//! Laws found without a catalogue: [`analysis::discover`] run on the machine's threads, and its text.

mod text;

pub use analysis::discover::*;
pub use text::{significant, text};

use crate::diagnose::{NamedReplay, endless};
use crate::threads::Threads;

/// Searches for laws; all replays must have the same model. `progress` is called once a step.
#[must_use]
pub fn discover(
    flights: &[NamedReplay<'_>],
    hold_outs: &[NamedReplay<'_>],
    progress: &mut dyn FnMut(),
) -> Discovery {
    let found = analysis::discover::discover(flights, hold_outs, &mut endless(progress), &Threads);
    found.unwrap_or_else(|_| unreachable!("it is never cancelled"))
}
