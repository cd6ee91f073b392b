//! What `cargo xtask` is made of.

pub mod bench;
pub mod budget;
