//! Imports other programs' logs as flights, and exports flights to other programs' formats; works on bytes.
//!
//! One file or folder per format. Reading and writing the bytes is left to the program.
//!
//! Every format but Pylon's own CSV is a feature, and all are on by default. To read only gliders' logs,
//! build with `default-features = false, features = ["igc"]`; the crates that the other formats need are then
//! left out.

// With only some formats enabled, part of the shared code is unused.
#![cfg_attr(not(feature = "default"), allow(dead_code, unused_imports, unused_variables))]

pub mod export;
pub mod import;
