//! Logs of other programs as flights, and flights in the formats of other programs; on bytes.
//!
//! One file or folder a format. What the bytes are read from and written to is the program's matter.
//!
//! Every format but Pylon's own CSV is a feature, and all are on by default: who reads gliders' logs alone
//! builds with `default-features = false, features = ["igc"]`, and without the crates that the others need.

// Of a part of the formats, some of what they share is not used.
#![cfg_attr(not(feature = "default"), allow(dead_code, unused_imports, unused_variables))]

pub mod export;
pub mod import;
