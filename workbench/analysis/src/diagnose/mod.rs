//! Which physical effect a model lacks.
//!
//! The residuals of all sensors form one likelihood. The reference's wander is in all of them, each also has
//! its own wander and white noise, and all of these are estimated together with the effects, again for every
//! set of effects that is tried. That likelihood is computed from a Kalman filter's innovations (`whitener`),
//! so its cost is linear in the length of the flight.
//!
//! `work` runs it:
//!
//! 1. `prepare`: `from_replay` makes block means of a flight's ticks: residuals and every candidate's
//!    regressor.
//! 2. `search`: the most probable set of effects among the `suspects`; `simplicity`: whether fewer suffice.
//!    Where the climb rate is not measured, `posterior`: how probable each set is.
//! 3. `repeatability`: whether its coefficients repeat from part to part of the flight.
//! 4. `rivals`: what could replace it.
//! 5. `unknown`: what nothing in the catalogue explains.
//! 6. `excitation`, `advice`: what the flight could not have shown, and what to fly.
//! 7. `judge`: the verdicts, what may act weakly where nothing was found, and the `learning_problem` that one
//!    effect's coefficient is learned from.
//!
//! Where something unknown acts on one sensor, and sets concern the reference, it does this again without that
//! sensor.
//!
//! `planner`: what one more flight would show, before it is flown.
//!
//! `study` is a diagnosis that ends in a learning problem, for `crate::learn`.

mod advice;
mod beyond_reference;
mod blocks;
mod candidates;
mod coefficient_prior;
mod column_noise;
mod delay;
mod diagnosis;
mod dump;
mod envelope;
mod epochs;
mod evidence;
mod excitation;
mod follower;
mod formulas;
mod forward_motion;
mod from_replay;
mod glitches;
mod held_out;
mod held_out_verdict;
mod information;
mod judge;
mod latent_path;
mod learning_problem;
mod long_run;
mod low_pass;
mod manoeuvres;
mod matrix;
mod named_replay;
mod noise;
mod offset_acceleration;
mod outlook;
mod physical_range;
mod planner;
mod posterior;
mod prediction;
mod prepare;
mod problem;
mod quasi_newton;
mod reference_path;
mod repeatability;
mod residuals;
mod rivals;
mod roughness;
mod score;
mod search;
mod series;
mod shape_error;
mod signal_errors;
mod signals;
mod simplicity;
#[cfg(test)]
mod small_problems;
mod study;
mod suspects;
mod unknown;
mod unknown_columns;
mod wanted_effect;
mod weigher;
mod whitener;
mod wind;
mod work;

pub use beyond_reference::{ErrorSlot, reference_wander};
pub use diagnosis::{
    CandidateFacts, DiagnosedFlight, Diagnosis, Follows, Glitch, NoiseFacts, OneOf, SensorDiagnosis,
    SensorWander, Untested, Verdict,
};
pub use dump::dump;
pub use envelope::envelope_m;
pub use evidence::{Evidence, Folds};
pub use from_replay::Measured;
pub use held_out_verdict::HeldOutVerdict;
pub use learning_problem::{LearningProblem, Nuisance, Term};
pub use low_pass::{LowPassDelay, is_same_effect};
pub use named_replay::NamedReplay;
pub use noise::{GaussMarkov, Noise, SensorNoise};
pub use outlook::{EffectOutlook, MemberOutlook, Outlook, SetOutlook};
pub use planner::{Further, Planner, diagnose_further};
pub use prediction::prediction;
pub use series::{BySensor, Series};
pub use study::{study, study_remembering};
pub use wanted_effect::WantedEffect;
pub use work::{Work, diagnose};

// Parts that `crate::discover` uses as well.
pub(crate) mod parts {
    pub(crate) use super::advice::{BLOCK_S as ADVICE_BLOCK_S, flown};
    pub(crate) use super::candidates::Candidate;
    pub(crate) use super::evidence::{Fitted, of_flights, of_folds};
    pub(crate) use super::from_replay::epochs;
    pub(crate) use super::held_out::{HeldOut, flights, manoeuvres};
    pub(crate) use super::information::own_coefficients;
    pub(crate) use super::long_run::inflation;
    pub(crate) use super::manoeuvres::{MANOEUVRES, Trim};
    pub(crate) use super::noise::Noise;
    #[cfg(test)]
    pub(crate) use super::noise::NoisePrior;
    pub(crate) use super::prepare::Prepared;
    pub(crate) use super::problem::{NoiseFit, Problem};
    pub(crate) use super::search::Explanation;
    pub(crate) use super::series::{BySensor, Series};
    pub(crate) use super::signals::SignalMeans;
    pub(crate) use super::suspects::Suspects;
    pub(crate) use super::unknown::{BETTER, SHAPE, SHAPE_WITHOUT_CLIMB_RATE};
    pub(crate) use super::whitener::{LANES, whiten_by_groups};
    pub(crate) use super::work::{Doubtful, Judged, judged};
}
