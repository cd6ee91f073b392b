//! The workbench for a web page: the page's requests ([`protocol`]) and their answers ([`Engine::ask`]).
//!
//! As a WebAssembly module it has a C interface ([`wasm`]); one module handles one request at a time.

mod beyond;
mod catalogue;
mod correlate;
mod curve;
mod engine;
mod formula;
mod headline;
mod opening;
mod pairs;
mod plan;
pub mod protocol;
mod recording;
mod results;
mod ribbons;
mod samples;
mod series;
pub mod wasm;

pub use engine::{Engine, Progress, Refused, Reply};
