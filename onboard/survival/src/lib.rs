//! What the flight computer keeps over a reset, how it supervises itself, and how it starts again.
//!
//! This crate depends on no chip: memory is accessed as plain words ([`WordMemory`]), time comes as numbers.
#![cfg_attr(not(test), no_std)]
#![forbid(unsafe_code)]

mod check;
mod clock;
mod crash;
mod history;
mod memory;
mod oscillator;
mod report;
mod slots;
mod start;
mod supervisor;
mod tick_mark;

pub use clock::WideClock;
pub use crash::{Cause, CrashRecord, PLACE_BYTES};
pub use history::{CRASHES_AT_ONCE, FIRST_PAUSE_US, History, LONGEST_PAUSE_US, STEADY_US};
pub use memory::{
    BOARD, BOARD_WORDS, RETAINED_WORDS, RetainedImage, WordMemory, captive_force, history,
    keep_captive_force, keep_crash, keep_history, take_crash,
};
pub use oscillator::{ClockTree, NoClock, Oscillator, start_clock};
pub use report::RestartReport;
pub use slots::{PAYLOAD_BYTES, Refusal, Slot, SlotError, SlotOrder, clear_slots, read_slot};
pub use start::{Found, ResetSource, Start};
pub use supervisor::{Late, Supervised, Supervisor};
pub use tick_mark::{Flight, MarkWriter, TickMark, clear_marks, newest_mark};
