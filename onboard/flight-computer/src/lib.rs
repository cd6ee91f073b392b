//! The flight computer's work at each of its ticks, 200 times a second: it polls its sensors and passes the
//! new values to the mission. The firmware and the workbench run this same code: the firmware on the board's
//! drivers (or the emulated board's), the workbench beside it to compare the results bit by bit.
//!
//! This crate also decides what is kept for a restart and how a restart continues ([`assess_restart`],
//! [`resume_mission`]).
//!
//! It owns no clock, no bus and no interrupt: the time of a tick is an argument, the sensors implement
//! [`drivers::Sensors`], and the memory that a reset leaves unchanged implements [`survival::WordMemory`].
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
