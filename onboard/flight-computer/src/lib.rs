//! What the flight computer does at each of its ticks, 200 times a second: polls its sensors, and gives what
//! is new to the mission. The firmware and the workbench run this same code, the one on the board's drivers
//! (or on the emulated board's), the other beside it to compare the bits.
//!
//! What is kept for a restart, and how one goes on, is here too ([`assess_restart`], [`resume_mission`]).
//!
//! It owns no clock, no bus and no interrupt: the time of a tick comes in as an argument, the sensors are
//! whatever implements [`drivers::Sensors`], and what a reset leaves alone is whatever implements
//! [`survival::WordMemory`].
#![no_std]
#![forbid(unsafe_code)]

mod computer;
mod estimation;
mod interruptible;
mod onboard;
mod part;
mod restart;
mod retention;

pub use computer::{FlightComputer, Step};
pub use estimation::{Estimation, Retainable};
pub use interruptible::Interruptible;
pub use onboard::Onboard;
pub use part::{PARTS, Part};
pub use restart::{Assessment, ResetFacts, assess_restart, resume_mission};
pub use retention::{Snapshot, SnapshotKeeper, keep_mark, mission_mark};
