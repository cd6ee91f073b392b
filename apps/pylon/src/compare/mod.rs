//! How well a model agrees with a flight: `pylon compare`, which is [`analysis::compare`] run on the
//! machine's threads, and its text.

pub(crate) mod text;

use replay::{Replay, ReplayError};

pub use analysis::compare::*;
pub use text::text;

use crate::threads::Threads;

/// Flies the replay's model over its flight and compares; `progress` is called with the number of rows done.
///
/// The caller fills in the names of the flight's file and of the model.
///
/// # Errors
/// [`ReplayError`] for a model that no mission can be made of.
pub fn compare(
    replay: &Replay<'_>,
    options: &Options,
    progress: &mut (dyn FnMut(u64) + Send),
) -> Result<(Comparison, Option<Box<Traces>>), ReplayError> {
    analysis::compare::compare(replay, options, progress, &Threads)
}
