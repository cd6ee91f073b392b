//! Trials on real tracks: how often a diagnosis of a real log is right.
//!
//! The logs lie where [`crate::real_logs`] has them. Each is diagnosed as it is and by its halves; the track
//! that it flew, with noise of its own level and of another family than the estimator's, makes flights in
//! which nothing is wrong, and flights and logs with one effect added say whether that is named.

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
