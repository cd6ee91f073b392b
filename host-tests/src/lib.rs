//! Tests of the whole chain, what they compare it with, and what the firmware may cost.

pub mod bench;
pub mod budget;
pub mod textbook;
