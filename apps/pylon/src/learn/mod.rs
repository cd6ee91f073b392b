//! Adding an effect to a model: [`analysis::learn`] run on the machine's threads, and its text.

mod text;

pub use analysis::diagnose::HeldOutVerdict;
pub use analysis::learn::*;
pub use text::{addition_text, ladder_text};

use crate::diagnose::endless;
use crate::threads::Threads;

/// Learns an effect's coefficient and returns the model's new text; writes nothing. `progress` is called once
/// a fit.
///
/// # Errors
/// See [`AddError`].
pub fn add(request: &Request<'_>, progress: &mut dyn FnMut()) -> Result<Addition, AddError> {
    analysis::learn::add(request, &mut endless(progress), &Threads)
}
