//! Compares the estimator's results with a flight: where a model holds, which effect it lacks, and what that
//! effect's coefficient is.

pub mod batch;
mod batch_result;
pub mod compare;
pub mod diagnose;
pub mod discover;
pub mod effect_guide;
pub mod json;
pub mod learn;
pub mod name;
pub mod overview;
pub mod progress;
pub mod survey;
#[cfg(test)]
mod whole_flights;
