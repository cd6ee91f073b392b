//! Laws that nobody wrote down: where nothing in the catalogue explains a misfit, which product of the
//! recorded signals does.
//!
//! 1. The diagnosis comes first: what it identifies, and what the model has already, stands beside every law.
//! 2. `signals` are the block means of all that was recorded; `grammar` says which laws there are and how
//!    long each is.
//! 3. `screen` scores hundreds of thousands of them under a noise that is held; `search` keeps the best,
//!    moves their constants, and fits the noise anew for the few that are left, by the likelihood of the
//!    diagnosis.
//! 4. `weigh` makes posterior probabilities of likelihoods and lengths; what was held out has a veto.

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
