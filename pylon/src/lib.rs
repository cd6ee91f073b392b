//! The workbench of Pylon: it compares what the estimator in [`kf_core`] says with measured flights.

pub mod airborne;
pub mod compare;
pub mod diagnose;
pub mod downlink;
pub mod effect_guide;
pub mod export;
pub mod flight;
pub mod fly;
pub mod import;
pub mod learn;
pub mod output_file;
pub mod overview;
pub mod plots;
pub mod replay;
pub mod report;
pub mod simulate;
pub mod statistics;
mod whole_file;
