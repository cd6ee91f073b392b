//! Flights and models, by what the user wrote.

use std::path::Path;

use model::Model;
use pylon::flight::{self, Flight, Note};

use super::failure::Failure;
use super::progress::while_busy;

/// A flight and what was remarkable about its file.
pub fn flight(file: &Path) -> Result<(Flight, Vec<Note>), Failure> {
    Ok(while_busy("reading", || flight::read(file))?)
}

/// A model by its preset's name or its file.
pub fn model(name: &str) -> Result<Model, Failure> {
    Ok(Model::load(name)?)
}
