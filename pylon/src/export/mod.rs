//! Flights in the formats of other programs.

pub mod mcap;
