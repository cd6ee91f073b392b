//! Errors of the command line.

use std::fmt::Display;
use std::io::Write as _;
use std::process::ExitCode;

use view::text::printable;

/// Host and target computed different bits.
const DIFFERS: u8 = 1;
/// Bad usage or bad input.
const BAD_INPUT: u8 = 2;

/// Why a command failed: a one-line message and the exit status.
#[derive(Debug)]
pub struct Failure {
    message: String,
    status: u8,
}

impl Failure {
    /// Bad input: exit status 2.
    pub fn input(message: impl Display) -> Self {
        Self { message: one_line(&message.to_string()), status: BAD_INPUT }
    }

    /// Host and target computed different bits: exit status 1.
    pub fn differs(message: impl Display) -> Self {
        Self { status: DIFFERS, ..Self::input(message) }
    }

    /// Bad usage, as one line: clap's own message has several.
    pub fn usage(error: &clap::Error) -> Self {
        let text = error.render().to_string();
        let first = text.split("\n\n").next().unwrap_or(&text);
        let message = one_line(first.strip_prefix("error: ").unwrap_or(first));
        Self { message: format!("{message} (see --help)"), status: BAD_INPUT }
    }

    /// The reason, in one line.
    pub fn message(&self) -> &str {
        &self.message
    }

    /// Prints the reason to standard error and returns the exit status.
    pub fn report(&self) -> ExitCode {
        // If standard error is closed too, there is nowhere left to report this.
        let _ = writeln!(std::io::stderr(), "error: {}", self.message);
        ExitCode::from(self.status)
    }
}

fn one_line(text: &str) -> String {
    printable(&text.split_whitespace().collect::<Vec<_>>().join(" ")).into_owned()
}

impl<E: std::error::Error> From<E> for Failure {
    fn from(error: E) -> Self {
        Self::input(error)
    }
}
