//! Flights in the formats of other programs.

pub mod mcap;
pub mod parquet;
pub mod plain_csv;
pub mod tlog;
