//! What the flight computer does at each of its ticks, 200 times a second: polls its sensors, and gives what is new to
//! the mission. The firmware and the workbench run this same code, the one on the board's drivers (or on the
//! emulated board's), the other beside it to compare the bits.
//!
//! It owns no clock, no bus and no interrupt: the time of a tick comes in as an argument, and the sensors are whatever
//! implements [`drivers::Sensors`].
#![no_std]
#![forbid(unsafe_code)]

mod computer;
mod estimation;
mod onboard;
mod part;

pub use computer::{FlightComputer, Step};
pub use estimation::Estimation;
pub use onboard::Onboard;
pub use part::{PARTS, Part};
