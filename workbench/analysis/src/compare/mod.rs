//! How well a model agrees with a flight.
//!
//! The estimator runs over the flight. Biases, spreads, whiteness, NIS, flags and their times are gathered in
//! one pass, and so is *where* the model fails: the manoeuvres in which the errors were largest.

mod comparator;
mod comparison;
mod cross_check;
mod envelope;
mod flags;
mod kinematics;
mod manoeuvre;
mod motion_track;
mod phase_statistics;
mod remedies;
mod rules;
mod run;
mod timeline;
mod traces;
mod warnings;
pub mod words;

pub use comparator::{Comparator, MissionEnd};
pub use comparison::{
    CalibrationFacts, Comparison, CrossCheckFacts, EffectFacts, FlightFacts, MonitorFacts, ReadingCounts,
    ReferenceComparison, SensorComparison,
};
pub use envelope::{Envelope, FIGURE_SLOTS, Slot};
pub use kinematics::MotionSources;
pub use manoeuvre::{Manoeuvre, Motion, without_minus_zero};
pub use motion_track::MotionTrack;
pub use phase_statistics::PhaseSummary;
pub use remedies::{Remedy, RemedyFigures};
pub use rules::{Recommendation, RuleRequirements, SensorRules};
pub use run::{Companions, Compared, Options, compare, compare_with};
pub use timeline::{ErrorFigures, Failures, ManoeuvreErrors, Stretch};
pub use traces::{EstimateTrace, ModelTrace, Traces};
