//! Adding an effect to a model.
//!
//! 1. `crate::diagnose::study` determines what the effect's coefficient is learned from.
//! 2. `filter` learns it with the core's own filter.
//! 3. `document` writes it into the model's text, which otherwise stays as it was.
//! 4. `score` flies the mission before and after.
//! 5. `addition` puts these together, and `concerns` collects the evidence against it.
//! 6. `ladder` scores every revision of a model.

mod add_error;
mod addition;
mod concerns;
mod document;
mod filter;
mod ladder;
mod score;

pub use add_error::AddError;
pub use addition::{Addition, FlightChange, NamedFlight, Remembered, Request, add, add_remembering};
pub use concerns::JudgedOn;
pub use document::DocumentError;
pub use filter::{LearnError, Learned, learn};
pub(crate) use ladder::numbers;
pub use ladder::{Ladder, LadderError, LadderRevision, RevisionFlight, ladder, ladder_by};
pub(crate) use score::{ScoreTally, Scoring};
pub use score::{Scorer, Scores, SensorScore, flown, pooled_rms_m, score};
