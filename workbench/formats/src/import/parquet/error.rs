//! Why a Parquet file could not be read.

use executor::contained::Panicked;
use thiserror::Error;

/// Why a Parquet file could not be read; displays as one line, without the file's name.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ParquetError {
    /// The end is missing, where all that is in it is listed.
    #[error(
        "Parquet that is cut off, or still being written: its end is missing, where its columns are listed; without it nothing \
         of it can be read, so copy or export it again"
    )]
    Cut,
    /// It is encrypted.
    #[error("an encrypted Parquet file, expected one that is not")]
    Encrypted,
    /// The list of columns is damaged.
    #[error(
        "Parquet whose list of columns is damaged ({0}): nothing of it can be read, so copy or export it again"
    )]
    Footer(#[from] FooterError),
    /// It says that it has more than there can be in so few bytes.
    #[error(
        "Parquet of {bytes} bytes that says it has {rows} rows of {columns} columns, expected at most {most} cells in so few \
         bytes: it is damaged, or contains nothing but repetitions"
    )]
    TooMany {
        /// The file's length.
        bytes: usize,
        /// Rows that it says it has.
        rows: i64,
        /// Columns.
        columns: usize,
        /// Cells that it may have.
        most: usize,
    },
    /// There is no row, or no column that has one value a row.
    #[error("Parquet without a row of numbers, expected columns with a value a row")]
    Nothing,
    /// A flight of Pylon's without what every flight has.
    #[error("Pylon's Parquet without {what}, expected a flight of 'pylon export FLIGHT --format parquet'")]
    NoFlight {
        /// What is missing.
        what: &'static str,
    },
}

/// What is wrong with a list of columns.
#[derive(Debug, Error)]
pub enum FooterError {
    /// It contradicts itself.
    #[error("{0}")]
    Damaged(&'static str),
    /// The decoder refuses it.
    #[error(transparent)]
    Decode(#[from] parquet::errors::ParquetError),
    /// The decoder panics on it.
    #[error(transparent)]
    Panicked(#[from] Panicked),
}

/// Why a group of a column's rows could not be read.
#[derive(Debug, Error)]
#[error("rows {first} to {last}: {why}")]
pub struct GroupError {
    /// Its first row, from 1.
    pub first: usize,
    /// Its last row.
    pub last: usize,
    /// Why.
    #[source]
    pub why: ChunkError,
}

/// What is wrong with the bytes of a column in one group.
#[derive(Debug, Error)]
pub enum ChunkError {
    /// They are beyond the file's end.
    #[error("it is not there")]
    Missing,
    /// They contradict themselves.
    #[error("{0}")]
    Damaged(&'static str),
    /// They are compressed in a way that is not read.
    #[error("it is compressed by {found}, expected one of {known}")]
    Codec {
        /// The way.
        found: &'static str,
        /// Those that are read, with commas between them.
        known: String,
    },
    /// The values are encoded in a way that is not read.
    #[error("its values are encoded in a way that is not read (number {0})")]
    Encoding(i64),
    /// A page cannot have so many bytes.
    #[error("a page of {values} values is said to have {bytes} bytes")]
    PageSize {
        /// Its values.
        values: usize,
        /// What it says.
        bytes: usize,
    },
    /// There are fewer rows than the group has.
    #[error("it ends after {rows} of them")]
    Short {
        /// Rows.
        rows: usize,
    },
    /// The decoder refuses them.
    #[error(transparent)]
    Decode(#[from] parquet::errors::ParquetError),
    /// The decoder panics on them.
    #[error("it does not decode ({0})")]
    Panicked(#[from] Panicked),
}
