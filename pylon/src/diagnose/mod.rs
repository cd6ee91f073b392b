//! Which physical effect a model lacks.
//!
//! The residuals of all sensors are one likelihood: the reference's wander is in all of them, each has
//! its own wander and white noise besides, and all of these are estimated together with the effects, anew
//! for every set of effects that is looked at. That likelihood is a Kalman filter's innovations
//! (`whitener`), so it is linear in the length of the flight.
//!
//! `work` does it:
//!
//! 1. `epochs`: a flight's ticks become block means of residuals and of every candidate's regressor.
//! 2. `search`: the most probable set of effects.
//! 3. `repeatability`: whether its coefficients repeat from part to part of the flight.
//! 4. `rivals`: what could act in its place.
//! 5. `unknown`: what nothing in the catalogue explains.
//! 6. `excitation`, `advice`: what the flight could not have shown, and what to fly.
//! 7. `judge`: the verdicts.
//! 8. `lesson`: what one effect's coefficient is learned from (by `crate::learn`).

mod advice;
mod blocks;
mod candidates;
mod column_noise;
mod diagnosis;
mod dump;
mod envelope;
mod epochs;
mod evidence;
mod excitation;
mod follower;
mod glitches;
mod held_out;
mod information;
mod judge;
mod lesson;
mod long_run;
mod manoeuvres;
mod noise;
mod problem;
mod quasi_newton;
mod reference_path;
mod repeatability;
mod rivals;
mod roughness;
mod search;
mod series;
mod signals;
mod smoothed_climb;
pub(crate) mod text;
mod unknown;
mod unknown_columns;
mod whitener;
mod wind;
mod work;

pub use diagnosis::{
    CandidateFacts, DiagnosedFlight, Diagnosis, Follows, NoiseFacts, SensorDiagnosis, Untested, Verdict,
};
pub use dump::dump;
pub use envelope::envelope_m;
pub use evidence::{Evidence, Folds};
pub use lesson::{Lesson, Nuisance, Term, Wish, study};
pub use noise::{GaussMarkov, Noise, SensorNoise};
pub use series::{BySensor, Series};
pub use text::text;
pub use work::{NamedReplay, diagnose};
