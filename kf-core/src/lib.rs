//! The estimator of Pylon: everything that the flight computer decides.
//!
//! It calibrates a UAV's altitude sensors against a reference while the UAV hangs under its mother
//! ship (captive flight), latches the calibration at launch and watches the sensors in free flight.
//! Source: Siqueira, Kuga, Souza, "Discrete Kalman filter estimation of sensor parameters"; equation
//! numbers in these docs are that paper's. (Its eq. 14 as printed drops the gain; the form used here
//! is eq. 7 with the gain of eq. 6.)
//!
//! No clock, no hardware type, no heap and no file enters this crate: time is data. Only IEEE-754
//! additions, multiplications, divisions and `libm` functions are used, so the host and the target
//! compute the same bits.
#![cfg_attr(not(test), no_std)]
#![forbid(unsafe_code)]

pub mod atmosphere;
pub mod config;
pub mod effect;
pub mod input;
pub mod output;
pub mod sensor;
