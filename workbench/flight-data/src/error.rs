//! Why a flight could not be read or written.

use thiserror::Error;

/// What is wrong with a flight's CSV. `row` is the line in the file, counted from 1 as editors do.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum CsvProblem {
    /// The row of column names is not a row of CSV.
    #[error("cannot be read: {0}")]
    Names(#[source] csv::Error),
    /// The file is empty.
    #[error("the file is empty; expected a flight (first line '# pylon-flight: 1')")]
    Empty,
    /// The header does not mark it as a flight.
    #[error(
        "no '# pylon-flight: 1' line at its head; expected a flight's CSV or a log that 'pylon import' knows"
    )]
    NoVersion,
    /// A flight of another format version.
    #[error("row {row}: pylon-flight version '{found}'; this program reads version 1")]
    Version {
        /// Line in the file.
        row: u64,
        /// The text of the line.
        found: String,
    },
    /// A header line with an invalid value.
    #[error("row {row}: header key '{key}' is '{found}', expected {expected}")]
    HeaderValue {
        /// Line in the file.
        row: u64,
        /// The key.
        key: String,
        /// Its value.
        found: String,
        /// Valid values.
        expected: &'static str,
    },
    /// A header key that may occur only once.
    #[error("row {row}: header key '{key}' occurs a second time, expected once")]
    HeaderTwice {
        /// Line in the file.
        row: u64,
        /// The key.
        key: String,
    },
    /// Text that is not UTF-8 where names are expected.
    #[error("row {row}: not UTF-8 text, expected {expected}")]
    NotText {
        /// Line in the file.
        row: u64,
        /// What was expected.
        expected: &'static str,
    },
    /// Header lines only.
    #[error("no row of column names after the header lines, expected time_s, gps_alt_m and another altitude")]
    NoColumns,
    /// The cells have another separator.
    #[error("row {row}: the column names are separated by {found}, expected commas")]
    Separator {
        /// Line in the file.
        row: u64,
        /// The separator, in words.
        found: &'static str,
    },
    /// A quote in the column names that is not closed in their row.
    #[error("row {row}: quote never closed, expected plain names with commas between them")]
    OpenQuote {
        /// Row of the names, counted from 1.
        row: u64,
    },
    /// A column name that could not be written again.
    #[error(
        "row {row}: the name of column {index} has a line end or a zero byte in it, expected a plain name"
    )]
    LineEndInName {
        /// Row of the names, counted from 1.
        row: u64,
        /// Which column, counted from 1.
        index: usize,
    },
    /// A column without a name.
    #[error("row {row}: column {index} has no name, expected one (is there a comma too many?)")]
    Unnamed {
        /// Line in the file.
        row: u64,
        /// Position of the column, from 1.
        index: usize,
    },
    /// Two columns of the same name.
    #[error("row {row}, column {name}: the name occurs twice (columns {first} and {second}), expected once")]
    Duplicate {
        /// Line in the file.
        row: u64,
        /// The name.
        name: String,
        /// Position of the first, from 1.
        first: usize,
        /// Position of the second, from 1.
        second: usize,
    },
    /// A column that is a known quantity in another unit.
    #[error(
        "row {row}, column {name}: looks like {known}, but its unit is not that column's; convert the values to {known}, or rename the column if it is something else"
    )]
    Unit {
        /// Line in the file.
        row: u64,
        /// The column's name.
        name: String,
        /// The similar known column.
        known: &'static str,
    },
    /// A known column's name in a different case.
    #[error("row {row}, column {name}: expected the name in lower case, {known}")]
    LetterCase {
        /// Line in the file.
        row: u64,
        /// The column's name.
        name: String,
        /// The known column.
        known: &'static str,
    },
    /// A required column is missing.
    #[error("row {row}: no column {name}; expected it, since every flight needs one{}", ask(.similar))]
    Missing {
        /// Line in the file.
        row: u64,
        /// The required column.
        name: &'static str,
        /// A column of the file with nearly that name.
        similar: Option<String>,
    },
    /// No altitude to compare with the reference.
    #[error(
        "no altitude besides gps_alt_m: no barometer, and so nothing to calibrate; expected baro_pa, baro_alt_m, imu_slave_alt_m, imu_master_alt_m, or all three accel_ and all three gyro_ columns"
    )]
    NoSecondAltitude,
    /// Column names only.
    #[error("no row after the column names, expected at least one")]
    NoRows,
    /// A row with too few cells.
    #[error("row {row}: {found} cells, expected {expected}; the row is cut after column {last}")]
    Cut {
        /// Line in the file.
        row: u64,
        /// Cells in the row.
        found: usize,
        /// Expected number of cells.
        expected: usize,
        /// The last column that has a cell.
        last: String,
    },
    /// A row with too many cells.
    #[error("row {row}: {found} cells, expected {expected} as in the row of column names")]
    TooManyCells {
        /// Line in the file.
        row: u64,
        /// Cells in the row.
        found: usize,
        /// Expected number of cells.
        expected: usize,
    },
    /// A cell whose content does not suit its column.
    #[error("row {row}, column {column}: '{found}', expected {expected}")]
    Cell {
        /// Line in the file.
        row: u64,
        /// The column.
        column: String,
        /// The cell's text, shortened.
        found: String,
        /// Valid content.
        expected: &'static str,
    },
}

fn ask(name: &Option<String>) -> String {
    name.as_ref().map_or_else(String::new, |name| format!(" (is it '{name}'?)"))
}

/// A flight that cannot be written as CSV, because the text could not be read again.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum FlightError {
    /// A column is not as long as the time axis.
    #[error("column {column} has {found} cells, expected {expected}, one a row")]
    Ragged {
        /// The column.
        column: String,
        /// Its length.
        found: usize,
        /// The number of rows.
        expected: usize,
    },
    /// A time that a flight cannot have.
    #[error("row {index} of the flight has time {found} s, expected a finite time from 0 on")]
    Time {
        /// Position of the row, from 0.
        index: usize,
        /// Its time.
        found: f64,
    },
    /// A name or header text that would read back as something else.
    #[error("{what} '{text}' cannot be in a flight's header: {reason}")]
    Text {
        /// What kind of text it is.
        what: &'static str,
        /// The text.
        text: String,
        /// The reason.
        reason: &'static str,
    },
}
