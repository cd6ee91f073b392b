//! What the flight computer keeps over a reset, how it knows that it is alive, and how it starts again.
//!
//! Nothing here knows a chip: memory comes as plain words and bytes, time as numbers. The firmware lays
//! [`RetainedMemory`] over memory that a reset leaves alone (`firmware/src/retained.rs`).
#![cfg_attr(not(test), no_std)]
#![forbid(unsafe_code)]

mod check;
mod clock;
mod crash;
mod history;
mod memory;
mod report;
mod slots;
mod start;
mod supervisor;
mod tick_mark;

pub use clock::WideClock;
pub use crash::{Cause, CrashRecord, PLACE_BYTES};
pub use history::{History, LOOP_RESTARTS, LOOP_US};
pub use memory::{BOARD_WORDS, CrashCell, HistoryCell, RETAINED_BYTES, RetainedMemory};
pub use report::RestartReport;
pub use slots::{PAYLOAD_BYTES, Recovered, Refusal, SlotError, Slots};
pub use start::{Found, ResetSource, Start};
pub use supervisor::{Late, Supervised, Supervisor};
pub use tick_mark::{Flight, TickMark, TickMarks};
