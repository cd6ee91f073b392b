//! Flights in the formats of other programs.

#[cfg(feature = "mcap")]
pub mod mcap;
#[cfg(feature = "parquet")]
pub mod parquet;
pub mod plain_csv;
#[cfg(feature = "tlog")]
pub mod tlog;
