//! What work tells its caller while it goes on, and how the caller ends it.

use std::ops::ControlFlow;

use thiserror::Error;

/// The caller ended the work.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("cancelled")]
pub struct Cancelled;

/// Is called once a step of the work, of which nobody knows beforehand how many there are; `Break` ends it.
pub type Progress<'a> = dyn FnMut() -> ControlFlow<()> + 'a;

/// One step more is done.
pub(crate) fn step(progress: &mut Progress<'_>) -> Result<(), Cancelled> {
    match progress() {
        ControlFlow::Continue(()) => Ok(()),
        ControlFlow::Break(()) => Err(Cancelled),
    }
}
