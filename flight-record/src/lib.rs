//! flight-record
