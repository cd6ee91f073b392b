//! Why a table could not be read by a mapping. Each displays as one line, without the file's name.

use std::num::NonZeroUsize;

use thiserror::Error;

use crate::import::ImportError;
use crate::import::quantity::Quantity;
use flight_data::CsvProblem;

/// What is wrong, and where.
#[derive(Debug, Error)]
pub enum Fault {
    /// With the log.
    #[error(transparent)]
    Log(#[from] TableError),
    /// With the mapping.
    #[error(transparent)]
    Mapping(#[from] MappingError),
}

/// What is wrong with a log that should be a table.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum TableError {
    /// What is wrong with any log: it is empty, in UTF-16, or Parquet that cannot be read.
    #[error(transparent)]
    Log(#[from] ImportError),
    /// It is no text.
    #[error(
        "it is not text, expected a table of numbers as text (CSV) or Parquet; a log of a known program needs no mapping"
    )]
    NotText,
    /// A log of a known format.
    #[error("it is a log of a known format ({format}), which 'pylon import' reads without a mapping")]
    Known {
        /// The format.
        format: &'static str,
    },
    /// No layout was found.
    #[error(
        "no table of numbers was found in it, expected lines of at least two cells each, with the same separator"
    )]
    NoTable,
    /// No row has a time.
    #[error("no row with a time in the table, expected at least one")]
    NoTime,
    /// A column without a value.
    #[error("not one value of {name} in the table, expected some: nothing to compare with")]
    NoValue {
        /// The signal.
        name: String,
    },
}

/// What is wrong with a mapping, by itself or with this table.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum MappingError {
    /// It is not TOML, or not of a mapping's keys.
    #[error("{}{}", line.map_or_else(String::new, |line| format!("line {line}: ")), source.message())]
    Syntax {
        /// Line, from 1, where it is known.
        line: Option<NonZeroUsize>,
        /// What TOML says.
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
    /// There is no such datum.
    #[error("[flight] altitude_datum is '{0}', expected \"msl\" or \"ellipsoid\"")]
    Datum(String),
    /// There is no time base.
    #[error(
        "no [time], expected one: column = \"...\" and unit = \"s\", or rate_hz = 100 for a table without a time"
    )]
    NoTimeBase,
    /// A time base of nothing.
    #[error("[time] has neither column nor rate_hz, expected one of them")]
    EmptyTimeBase,
    /// A time base of two things.
    #[error("[time] has both column and rate_hz, expected one of them")]
    TwoTimeBases,
    /// A rate that no table has.
    #[error("[time] rate_hz is {0}, expected rows per second, above 0")]
    Rate(f64),
    /// There is no such unit of time.
    #[error("[time] unit '{0}', expected one of {names}", names = Quantity::Time.unit_names())]
    TimeUnit(String),
    /// The time's column is a number, and has no unit.
    #[error("[time] has no unit for column '{0}', expected one of {names}", names = Quantity::Time.unit_names())]
    NoTimeUnit(String),
    /// The time's column says its unit itself.
    #[error("[time] column '{0}' has times of day or dates, expected no unit")]
    UnitOfClock(String),
    /// The time's column.
    #[error("[time] {0}")]
    TimeColumn(#[source] Box<ColumnError>),
    /// There is no such separator.
    #[error("[file] separator is '{0}', expected \",\", \";\", \"tab\", \"|\" or \"spaces\"")]
    Separator(String),
    /// There is no such decimal sign.
    #[error("[file] decimal is '{0}', expected \".\" or \",\"")]
    Decimal(String),
    /// The names are not above the numbers.
    #[error("[file] names_line is not above first_line, expected it there (0: no names)")]
    NamesLine,
    /// No layout was found, and the mapping does not say one.
    #[error(
        "no table of numbers was found in the log, expected lines of cells with the same separator; if it is one, say separator, \
         names_line and first_line under [file]"
    )]
    NoLayout,
    /// A layout for what is no text.
    #[error(
        "[file] says how a text is laid out, expected no [file]: the log is Parquet, which says it itself"
    )]
    LayoutOfParquet,
    /// A name that no signal can have.
    #[error("[signals] '{}': no name for a signal", .0.escape_debug())]
    SignalName(String),
    /// A signal.
    #[error("[signals] {name}: {source}")]
    Signal {
        /// Its name.
        name: String,
        /// What is wrong with it.
        source: Box<SignalError>,
    },
    /// A signal that every flight has is missing.
    #[error("[signals] has no {name}, expected the reference's altitude among them")]
    NoReference {
        /// Its name.
        name: String,
    },
    /// The signals make no flight.
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
        /// The signal that it looks like.
        known: &'static str,
    },
    /// A signal that no unit is known of.
    #[error("a signal of your own is kept in its own unit; expected scale and offset in place of unit")]
    UnitOfOwn,
    /// A number without a unit.
    #[error("is a number without a unit, expected no unit")]
    UnitOfCount,
    /// There is no such unit of its quantity.
    #[error("unit '{unit}', expected one of {names}", names = quantity.unit_names())]
    Unit {
        /// What was given.
        unit: String,
        /// What it measures.
        quantity: Quantity,
    },
    /// There is no such datum, or the signal is no altitude.
    #[error("datum is '{0}', expected \"msl\", \"ellipsoid\" or \"pressure\", and of an altitude only")]
    Datum(String),
    /// Nothing can be multiplied by that.
    #[error("scale is {0}, expected a number other than 0")]
    Scale(f64),
    /// Nothing can be added to that.
    #[error("offset is {0}, expected a number")]
    Offset(f64),
    /// Its column.
    #[error(transparent)]
    Column(#[from] ColumnError),
}

/// A column that the table does not have, or has several times.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum ColumnError {
    /// A place beyond the last one.
    #[error("column {place} of {count}, expected 1 to {count}")]
    Place {
        /// What was given.
        place: usize,
        /// How many there are.
        count: usize,
    },
    /// There is no such name.
    #[error(
        "no column '{name}' in the table{}, expected one of: {}",
        near.as_ref().map_or_else(String::new, |near| format!(" (is it '{near}'?)")),
        names.join(", ")
    )]
    Unknown {
        /// What was given.
        name: String,
        /// What it may be a slip of.
        near: Option<String>,
        /// What there is.
        names: Vec<String>,
    },
    /// Several have that name.
    #[error(
        "several columns are named '{name}', expected the place of one of them, as column = {} (they are {})",
        places.first().copied().unwrap_or(1),
        places.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ")
    )]
    Ambiguous {
        /// The name.
        name: String,
        /// Their places, from 1.
        places: Vec<usize>,
    },
}
