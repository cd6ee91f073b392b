//! Remarks about an input that was usable, but not entirely as it should be.

use std::fmt;

/// One line for the user: what was found in an input, and how it was handled.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Note(String);

impl Note {
    /// A note with this text; line breaks become spaces, so that a note stays one line.
    #[must_use]
    pub fn new(text: impl Into<String>) -> Self {
        Self(text.into().replace(['\n', '\r'], " "))
    }

    /// The text.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.0
    }
}

impl fmt::Display for Note {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&self.0)
    }
}
