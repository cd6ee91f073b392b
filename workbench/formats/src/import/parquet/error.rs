//! Why a Parquet file could not be read.

use executor::contained::Panicked;
use thiserror::Error;

/// Why a Parquet file could not be read; displays as one line, without the file's name.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ParquetError {
    /// The footer, which lists the file's content, is missing.
    #[error(
        "Parquet that is cut off, or still being written: its end is missing, where its columns are listed; without it nothing \
         can be read, so copy or export it again"
    )]
    Cut,
    /// It is encrypted.
    #[error("an encrypted Parquet file, expected one that is not")]
    Encrypted,
    /// The list of columns is damaged.
    #[error(
        "Parquet whose list of columns is damaged ({0}): nothing can be read, so copy or export it again"
    )]
    Footer(#[from] FooterError),
    /// It declares more cells than so few bytes can hold.
    #[error(
        "Parquet of {bytes} bytes that declares {rows} rows of {columns} columns, expected at most {most} cells in so few \
         bytes: it is damaged, or contains nothing but repetitions"
    )]
    TooMany {
        /// The file's length.
        bytes: usize,
        /// Rows that it declares.
        rows: i64,
        /// Columns.
        columns: usize,
        /// Largest possible number of cells.
        most: usize,
    },
    /// There are no rows, or no column with one value a row.
    #[error("Parquet without a row of numbers, expected columns with a value a row")]
    Nothing,
    /// A flight of Pylon's that lacks a part which every flight has.
    #[error("Pylon's Parquet without {what}, expected a flight of 'pylon export FLIGHT --format parquet'")]
    NoFlight {
        /// What is missing.
        what: &'static str,
    },
}

/// What is wrong with a footer.
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
    /// The reason.
    #[source]
    pub why: ChunkError,
}

/// What is wrong with the bytes of a column in one group.
#[derive(Debug, Error)]
pub enum ChunkError {
    /// They are beyond the file's end.
    #[error("it is missing")]
    Missing,
    /// They contradict themselves.
    #[error("{0}")]
    Damaged(&'static str),
    /// Their compression is not supported.
    #[error("it is compressed by {found}, expected one of {known}")]
    Codec {
        /// The compression.
        found: &'static str,
        /// Those that are supported, separated by commas.
        known: String,
    },
    /// The encoding of the values is not supported.
    #[error("its values are encoded in a way that is not read (number {0})")]
    Encoding(i64),
    /// A page cannot have this size.
    #[error("a page of {values} values declares {bytes} bytes")]
    PageSize {
        /// Its values.
        values: usize,
        /// The size that it declares, bytes.
        bytes: usize,
    },
    /// There are fewer rows than the group declares.
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
