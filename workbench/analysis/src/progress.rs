//! How work reports its progress to its caller, and how the caller ends it.

use std::ops::ControlFlow;

use thiserror::Error;

/// The caller ended the work.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("cancelled")]
pub struct Cancelled;

/// Called once for each step of the work, whose number is not known beforehand; `Break` ends it.
pub type Progress<'a> = dyn FnMut() -> ControlFlow<()> + 'a;

/// Reports one more step.
pub(crate) fn step(progress: &mut Progress<'_>) -> Result<(), Cancelled> {
    match progress() {
        ControlFlow::Continue(()) => Ok(()),
        ControlFlow::Break(()) => Err(Cancelled),
    }
}
