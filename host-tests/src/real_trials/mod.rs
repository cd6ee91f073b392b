//! Trials on real tracks: how often a diagnosis of a real log is right.
//!
//! [`crate::real_logs`] gives the logs' location. Each log is diagnosed as it is and by its halves. Its
//! track, with noise of its own level but of a different family from the estimator's, gives flights in which
//! nothing is wrong. Flights and logs with one effect added show whether that effect is named.

mod added;
mod logs;
mod made;
pub(crate) mod noise;
mod reliability;
mod score;
mod trial;

pub use logs::{Half, Log, logs};
pub use reliability::reliability;
pub use score::{Score, table};
pub use trial::{Case, Outcome, of_log, part};
