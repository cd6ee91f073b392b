//! Why a table could not be read by a mapping. Each error displays as one line, without the file's name.

use std::num::NonZeroUsize;

use thiserror::Error;

use crate::import::ImportError;
use crate::import::quantity::Quantity;
use flight_data::CsvProblem;

/// The error, in the log or in the mapping.
#[derive(Debug, Error)]
pub enum Fault {
    /// In the log.
    #[error(transparent)]
    Log(#[from] TableError),
    /// In the mapping.
    #[error(transparent)]
    Mapping(#[from] MappingError),
}

/// What prevents a log from being read as a table.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum TableError {
    /// An error of any log: it is empty, in UTF-16, or Parquet that cannot be read.
    #[error(transparent)]
    Log(#[from] ImportError),
    /// It is not text.
    #[error(
        "it is not text, expected a table of numbers as text (CSV) or Parquet; a log of a known program needs no mapping"
    )]
    NotText,
    /// A log in a known format.
    #[error("it is a log of a known format ({format}), which 'pylon import' reads without a mapping")]
    Known {
        /// The format.
        format: &'static str,
    },
    /// No layout was detected.
    #[error(
        "no table of numbers was found in it, expected lines of at least two cells each, with the same separator"
    )]
    NoTable,
    /// No row has a time.
    #[error("no row with a time in the table, expected at least one")]
    NoTime,
    /// A column without a value.
    #[error("no value of {name} in the table, expected some: nothing to compare with")]
    NoValue {
        /// The signal.
        name: String,
    },
}

/// An error in a mapping, by itself or for this table.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum MappingError {
    /// It is not TOML, or has keys that a mapping does not have.
    #[error("{}{}", line.map_or_else(String::new, |line| format!("line {line}: ")), source.message())]
    Syntax {
        /// Line, from 1, if it is known.
        line: Option<NonZeroUsize>,
        /// TOML's own error.
        source: Box<toml::de::Error>,
    },
    /// It has no version.
    #[error(
        "no 'pylon-mapping = 1' in it, expected a mapping file ('pylon import LOG --guess -o mapping.toml' drafts one)"
    )]
    NotAMapping,
    /// Another version.
    #[error("pylon-mapping version {0}, this program reads version 1")]
    Version(u32),
    /// Unknown datum.
    #[error("[flight] altitude_datum is '{0}', expected \"msl\" or \"ellipsoid\"")]
    Datum(String),
    /// There is no time base.
    #[error(
        "no [time], expected one: column = \"...\" and unit = \"s\", or rate_hz = 100 for a table without a time"
    )]
    NoTimeBase,
    /// A time base with neither a column nor a rate.
    #[error("[time] has neither column nor rate_hz, expected one of them")]
    EmptyTimeBase,
    /// A time base with both.
    #[error("[time] has both column and rate_hz, expected one of them")]
    TwoTimeBases,
    /// An impossible rate.
    #[error("[time] rate_hz is {0}, expected rows per second, above 0")]
    Rate(f64),
    /// Unknown unit of time.
    #[error("[time] unit '{0}', expected one of {names}", names = Quantity::Time.unit_names())]
    TimeUnit(String),
    /// The time's column is a number and has no unit.
    #[error("[time] has no unit for column '{0}', expected one of {names}", names = Quantity::Time.unit_names())]
    NoTimeUnit(String),
    /// The time's column defines its unit itself.
    #[error("[time] column '{0}' has times of day or dates, expected no unit")]
    UnitOfClock(String),
    /// An error in the time's column.
    #[error("[time] {0}")]
    TimeColumn(#[source] Box<ColumnError>),
    /// Unknown separator.
    #[error("[file] separator is '{0}', expected \",\", \";\", \"tab\", \"|\" or \"spaces\"")]
    Separator(String),
    /// Unknown decimal sign.
    #[error("[file] decimal is '{0}', expected \".\" or \",\"")]
    Decimal(String),
    /// The names are not above the numbers.
    #[error("[file] names_line is not above first_line, expected it there (0: no names)")]
    NamesLine,
    /// No layout was detected, and the mapping gives none.
    #[error(
        "no table of numbers was found in the log, expected lines of cells with the same separator; if it is one, give separator, \
         names_line and first_line under [file]"
    )]
    NoLayout,
    /// A layout for a log that is not text.
    #[error(
        "[file] describes the layout of a text, expected no [file]: the log is Parquet, which needs none"
    )]
    LayoutOfParquet,
    /// An invalid signal name.
    #[error("[signals] '{}': no name for a signal", .0.escape_debug())]
    SignalName(String),
    /// An error in a signal.
    #[error("[signals] {name}: {source}")]
    Signal {
        /// Its name.
        name: String,
        /// What is wrong with it.
        source: Box<SignalError>,
    },
    /// A signal that every flight needs is missing.
    #[error("[signals] has no {name}, expected the reference's altitude among them")]
    NoReference {
        /// Its name.
        name: String,
    },
    /// The signals do not make a valid flight.
    #[error("[signals]: {0}")]
    Flight(#[source] Box<CsvProblem>),
}

/// What is wrong with a signal of a mapping.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum SignalError {
    /// It is the time base.
    #[error("the time base belongs under [time]")]
    IsTime,
    /// A signal's name with another unit.
    #[error(
        "looks like {known} in another unit; write {known} = {{ column = ..., unit = \"...\" }}, and the values are converted"
    )]
    OtherUnit {
        /// The signal that it resembles.
        known: &'static str,
    },
    /// A signal whose unit is not known.
    #[error("a signal of your own is kept in its own unit; expected scale and offset in place of unit")]
    UnitOfOwn,
    /// A number without a unit.
    #[error("is a number without a unit, expected no unit")]
    UnitOfCount,
    /// Unknown unit of its quantity.
    #[error("unit '{unit}', expected one of {names}", names = quantity.unit_names())]
    Unit {
        /// The unit that was given.
        unit: String,
        /// The signal's quantity.
        quantity: Quantity,
    },
    /// Unknown datum, or the signal is not an altitude.
    #[error("datum is '{0}', expected \"msl\", \"ellipsoid\" or \"pressure\", and of an altitude only")]
    Datum(String),
    /// An invalid scale.
    #[error("scale is {0}, expected a number other than 0")]
    Scale(f64),
    /// An invalid offset.
    #[error("offset is {0}, expected a number")]
    Offset(f64),
    /// An error in its column.
    #[error(transparent)]
    Column(#[from] ColumnError),
}

/// A column that the table does not have, or has several times.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum ColumnError {
    /// An index beyond the last column.
    #[error("column {place} of {count}, expected 1 to {count}")]
    Place {
        /// The index that was given.
        place: usize,
        /// The number of columns.
        count: usize,
    },
    /// Unknown name.
    #[error(
        "no column '{name}' in the table{}, expected one of: {}",
        near.as_ref().map_or_else(String::new, |near| format!(" (is it '{near}'?)")),
        names.join(", ")
    )]
    Unknown {
        /// The name that was given.
        name: String,
        /// A column that it may be a typing error of.
        near: Option<String>,
        /// The names that exist.
        names: Vec<String>,
    },
    /// Several columns have that name.
    #[error(
        "several columns are named '{name}', expected the place of one of them, as column = {} (they are {})",
        places.first().copied().unwrap_or(1),
        places.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ")
    )]
    Ambiguous {
        /// The name.
        name: String,
        /// Their indices, from 1.
        places: Vec<usize>,
    },
}
