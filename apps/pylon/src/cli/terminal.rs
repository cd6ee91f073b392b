//! Standard output.

use std::io::{self, IsTerminal as _, Write as _};

use view::text::printable;

use super::failure::Failure;

/// Whether standard output takes colours: it is a terminal and `NO_COLOR` is not set
/// (<https://no-color.org>).
pub fn has_colour() -> bool {
    let refused = std::env::var_os("NO_COLOR").is_some_and(|value| !value.is_empty());
    io::stdout().is_terminal() && !refused
}

/// Writes `coloured` to a terminal that takes colours, `plain` to anything else.
pub fn write(coloured: &str, plain: &str) -> Result<(), Failure> {
    put_raw(if has_colour() { coloured } else { plain })
}

/// Writes a result as JSON.
pub fn put_json(result: &impl serde::Serialize) -> Result<(), Failure> {
    put(&(serde_json::to_string_pretty(result)? + "\n"))
}

/// Writes to standard output, with control characters escaped. A reader that stops early (`| head`) is no
/// error.
pub fn put(text: &str) -> Result<(), Failure> {
    put_raw(&printable(text))
}

/// As [`put`], for a text that has colours if [`has_colour`] returns true. The rest of it must be printable.
pub fn put_coloured(text: &str) -> Result<(), Failure> {
    if has_colour() { put_raw(text) } else { put(text) }
}

fn put_raw(text: &str) -> Result<(), Failure> {
    let mut out = io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            Err(Failure::input(format!("standard output: {error}")))
        }
        _ => Ok(()),
    }
}
