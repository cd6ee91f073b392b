//! The name of something in a result.

use std::borrow::Cow;

/// An effect's id, a sensor's name, a unit: one of the catalogue's own, or one read from a file.
pub type Name = Cow<'static, str>;
