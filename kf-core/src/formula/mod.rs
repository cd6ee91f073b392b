//! A model's own laws: a regressor as a short program, written as text in a model file.
//!
//! `model::formula` turns the text into a [`Program`]; this module runs it, on the aircraft, in QEMU, at the
//! desk and in a browser, with the same bits: f32, IEEE-754 operations and `libm`, no heap, no clock, a
//! bounded number of operations and of state.
//!
//! At every tick a [`Frame`] takes what is new; [`step()`] runs the program over it and keeps what the
//! program remembers (integrals, low passes, delays, means) in a slice of [`Program::state_words`] numbers.
//! An [`Evaluation`] combines both.
//!
//! An invalid number (a signal that has not been seen, a division by zero, the root of a negative, an
//! overflow) makes the effect silent for that tick; [`Silent`] gives the reason. It never enters the state: a
//! function with memory waits until its argument is a number again, and then continues from where it was,
//! with a straight line over the time between.

mod delay;
mod fast_path;
mod frame;
mod program;
mod signal;
mod step;
mod words;

pub use frame::Frame;
pub use program::{MAX_DEPTH, MAX_MASKS, MAX_OPS, MAX_STATE_WORDS, Op, Program, TOP};
pub(crate) use signal::uses;
pub use signal::{MAX_COLUMNS, SIGNALS, Signal};
pub use step::{Evaluation, Silent, Stack, step};

#[cfg(test)]
mod tests;
