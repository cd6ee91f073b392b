//! Errors in a formula, and their place.

use std::fmt;
use std::ops::Range;

/// A formula that cannot be used. Displays as the error, then the formula with carets under the place.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FormulaError {
    /// What is wrong.
    pub message: String,
    /// The part of the text concerned, in bytes.
    pub span: Range<usize>,
    /// The formula.
    pub text: String,
}

impl FormulaError {
    pub(super) fn new(text: &str, span: Range<usize>, message: impl Into<String>) -> Self {
        Self { message: message.into(), span, text: text.to_owned() }
    }
}

impl fmt::Display for FormulaError {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        /// Fits into a line of a terminal with some room to spare.
        const SHOWN: usize = 96;
        let before = self.text.get(..self.span.start).unwrap_or(&self.text);
        let inside = self.text.get(self.span.clone()).unwrap_or_default();
        // A formula over several lines is shown in one; a long one from near the place on.
        let flat = |text: &str| text.replace(['\n', '\r', '\t'], " ");
        let column = before.chars().count();
        let skipped = if column + 8 > SHOWN { column.saturating_sub(SHOWN / 2) } else { 0 };
        let line: String = flat(&self.text).chars().skip(skipped).take(SHOWN).collect();
        let room = SHOWN.saturating_sub(column - skipped);
        let carets = inside.chars().count().clamp(1, room.max(1));
        let indent = " ".repeat(column - skipped);
        write!(formatter, "{}\n  {line}\n  {indent}{}", self.message, "^".repeat(carets))
    }
}

impl std::error::Error for FormulaError {}
