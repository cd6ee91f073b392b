//! Blind trials for laws: flights with a hidden law of the recorded signals, and how often the search finds
//! it.
//!
//! The laws have a different grammar from the search's (`hidden`), and use one to three columns that the
//! workbench does not know beside the usual ones. The noise is of a different family from the estimator's:
//! sums of sines, steps and Student's t. The search sees only one flight; another flight of the same aircraft
//! shows whether a law is right. All flights are simulated.

mod draw;
mod fly;
mod hidden;
mod score;
mod trial;

pub use draw::{Case, draw};
pub use fly::{Flown, fly};
pub use hidden::Hidden;
pub use score::{Score, table};
pub use trial::{Trial, dump, run};
