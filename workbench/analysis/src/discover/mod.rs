//! Laws that are in no catalogue: where nothing in the catalogue explains a misfit, which product of the
//! recorded signals does.
//!
//! 1. The diagnosis comes first: what it identifies, and what the model already has, is estimated together
//!    with every law.
//! 2. `signals` are the block means of all that was recorded; `grammar` defines the laws and the length of
//!    each.
//! 3. `screen` scores hundreds of thousands of them under a fixed noise; `search` keeps the best, moves their
//!    constants, and fits the noise again for the few that are left, by the likelihood of the diagnosis.
//! 4. `weigh` computes posterior probabilities from likelihoods and lengths; the held-out data has a veto.

mod advice;
mod definition;
mod discovery;
mod dump;
mod fit;
mod grammar;
mod judge;
mod length;
mod picture;
mod screen;
mod search;
mod signals;
#[cfg(test)]
mod small_flights;
mod weigh;
mod work;

pub use definition::{
    DefinitionError, NewDefinition, id, largest_plausible, with_definition, with_new_definition,
};
pub use discovery::{Discovery, Equal, FoundLaw, Rejected, Why};
pub use dump::dump;
pub use picture::{Picture, PictureSignal};
pub use work::discover;
