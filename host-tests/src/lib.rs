//! Tests of the whole chain, and what they compare it with.

pub mod textbook;
