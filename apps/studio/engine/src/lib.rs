//! The workbench for a page: what it asks ([`protocol`]), and what it is answered.

pub mod protocol;
