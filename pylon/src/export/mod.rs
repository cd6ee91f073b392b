//! Flights in the formats of other programs.

pub mod mcap;
pub mod tlog;
