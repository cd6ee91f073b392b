//! Logs of other programs as flights, and flights in the formats of other programs; on bytes.
//!
//! One file or folder a format. What the bytes are read from and written to is the program's matter.

pub mod export;
pub mod import;
