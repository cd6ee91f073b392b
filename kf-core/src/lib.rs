//! The estimator of Pylon: every decision of the flight computer.
//!
//! It calibrates a UAV's altitude sensors against a reference while the UAV hangs under its mother
//! ship (captive flight), latches the calibration at launch and watches the sensors in free flight.
//! Source: Siqueira, Kuga, Souza, "Discrete Kalman filter estimation of sensor parameters"; equation
//! numbers in these docs are that paper's. (Its eq. 14 as printed drops the gain; the form used here
//! is eq. 7 with the gain of eq. 6.)
//!
//! This crate uses no clock, no hardware type, no heap and no file: time is data. Only IEEE-754 additions,
//! multiplications, divisions and `libm` functions are used, so the host and the target compute the same
//! bits.
#![cfg_attr(not(test), no_std)]
#![forbid(unsafe_code)]
// Matrix algebra is clearest with the indices of its source; the linked image is checked for panics.
#![allow(clippy::needless_range_loop)]

pub mod atmosphere;
pub mod block_statistics;
mod calibration;
pub mod config;
mod cross_check;
pub mod effect;
pub mod error;
pub mod estimator;
pub mod formula;
mod free_flight;
pub mod gauss_markov;
pub mod guard;
pub mod input;
pub mod latch;
pub mod launch;
pub mod mission;
pub mod monitor;
pub mod moving_average;
pub mod navigation;
pub mod output;
pub mod plausible;
pub mod quality;
pub mod reading;
pub mod reference;
mod reference_check;
mod root;
pub mod sensor;
pub mod snapshot;
pub mod strapdown;
pub mod time;
pub mod trigonometry;
pub mod ud;
