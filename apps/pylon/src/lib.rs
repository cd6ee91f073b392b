//! The workbench of Pylon: it compares the results of the estimator in [`kf_core`] with measured flights.

pub mod batch;
pub mod compare;
pub mod diagnose;
pub mod discover;
pub mod effect_guide;
pub mod flight;
pub mod import;
pub mod learn;
pub mod output_file;
pub mod overview;
pub mod plan;
pub mod plots;
pub mod report;
pub mod results;
pub mod simulate;
pub mod survey;
mod threads;
mod whole_file;

pub use ::emulate::{self as fly, downlink};
pub use ::executor::contained;
pub use ::formats::export;
pub use ::replay::{self, airborne};
pub use ::statistics;
