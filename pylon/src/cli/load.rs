//! Flights and models, by what the user wrote.

use std::io::Write as _;
use std::path::Path;

use model::Model;
use pylon::flight::{Flight, Note};
use pylon::import;

use super::failure::Failure;
use super::progress::while_busy;

/// A flight, from its CSV or from any log that can be imported, and what was remarkable about it.
pub fn flight(file: &Path) -> Result<(Flight, Vec<Note>), Failure> {
    Ok(while_busy("reading", || import::open(file))?)
}

/// A model by its preset's name or its file; says on standard error what in it is unlikely.
pub fn model(name: &str) -> Result<Model, Failure> {
    let model = Model::load(name)?;
    for warning in model.warnings() {
        // Nothing is left to be told to when standard error is closed.
        let _ = writeln!(std::io::stderr(), "warning: {name}: {warning}");
    }
    Ok(model)
}

/// Says on standard error what was remarkable about an input.
pub fn write_notes(notes: &[Note]) {
    for note in notes {
        // Nothing is left to be told to when standard error is closed.
        let _ = writeln!(std::io::stderr(), "note: {note}");
    }
}
