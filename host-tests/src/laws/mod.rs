//! Blind trials for laws: flights with a hidden law of the recorded signals, and how often the search finds
//! it.
//!
//! The laws are of another grammar than the search's (`hidden`), with one to three columns that the workbench
//! does not know beside the usual ones, and the noise is of another family than the estimator's: sums of
//! sines, steps and Student's t. The search sees one flight alone; whether a law is right is seen on another
//! flight of the same aircraft. All flights are simulated.

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
