//! Apache Parquet (<https://parquet.apache.org/docs/file-format/>): a flight written by `pylon export` is
//! read back unchanged; a file of another program is a table whose meaning a mapping gives
//! ([`super::mapping`]).
//!
//! The `parquet` crate decodes the pages. It trusts a file's sizes, and panics on some wrong ones. Sizes that
//! it allocates are checked before, and a panic costs only one column of one group of rows.

mod cells;
mod error;
mod footer;
mod pages;
#[cfg(test)]
mod tests;
mod thrift;

use self::cells::Cells;
use self::footer::MAGIC;
use super::damage::percent;
use super::mapping::cell::Cell;
use super::mapping::{self, LoggedTable};
use super::own_header::{own_header, put_column};
use super::{ImportError, Importer};
use flight_data::{Column, Flight, MAX_TIME_S, Note};

use error::GroupError;
pub use error::{FooterError, ParquetError};

/// Key of the file's metadata that marks a flight of Pylon's.
const OWN: &str = "pylon-flight";

/// The importer of Pylon's own Parquet.
#[derive(Clone, Copy, Debug)]
pub struct Parquet;

/// Whether these bytes begin as a Parquet file.
#[must_use]
pub fn is_parquet(log: &[u8]) -> bool {
    log.starts_with(MAGIC) || log.starts_with(b"PARE")
}

/// Whether this is a Parquet file without its footer.
#[must_use]
pub fn is_cut(log: &[u8]) -> bool {
    log.starts_with(MAGIC) && !log.ends_with(MAGIC)
}

impl Importer for Parquet {
    fn name(&self) -> &'static str {
        "Pylon's Parquet"
    }

    fn recognises(&self, log: &[u8]) -> bool {
        // The metadata is at the end of the file, and no page of Pylon's contains text.
        is_parquet(log) && memchr::memmem::rfind(log, OWN.as_bytes()).is_some()
    }

    fn import(&self, log: &[u8]) -> Result<(Flight, Vec<Note>), ImportError> {
        flight(log).map_err(ImportError::Parquet)
    }
}

fn flight(log: &[u8]) -> Result<(Flight, Vec<Note>), ParquetError> {
    let cells = Cells::new(log)?;
    let place = |name: &str| cells.footer.leaves.iter().position(|leaf| leaf.name == name);
    let time = place("time_s").ok_or(ParquetError::NoFlight { what: "time_s" })?;
    let mut keys = cells.footer.keys.clone();
    if !keys.iter().any(|(key, _)| key == OWN) {
        return Err(ParquetError::NoFlight { what: "its header" });
    }
    keys.retain(|(key, _)| key != "pylon-units");
    let mut problems = Vec::new();
    let mut times = vec![f64::NAN; cells.footer.rows];
    let read = cells.column(time, &mut |row, cell| {
        if let (Some(slot), Cell::Number(value)) = (times.get_mut(row), cell) {
            *slot = value;
        }
    });
    problems.extend(said("time_s", read));
    // A flight's times may repeat or run backward; its reader reports it.
    let has_time = |time: &f64| (0.0..=MAX_TIME_S).contains(time);
    let places: Vec<Option<usize>> = times
        .iter()
        .scan(0, |next, time| {
            let place = *next;
            *next += usize::from(has_time(time));
            Some(has_time(time).then_some(place))
        })
        .collect();
    times.retain(has_time);
    let without = cells.footer.rows - times.len();
    let mut unnamed = Vec::new();
    let mut flight = Flight { header: own_header(keys), time_s: times, ..Flight::default() };
    for (leaf, own) in cells.footer.leaves.iter().enumerate().filter(|(leaf, _)| *leaf != time) {
        let mut column = Column::empty_named(&own.name, flight.time_s.len());
        let read = cells.column(leaf, &mut |row, cell| {
            if let (Some(Some(row)), Cell::Number(value)) = (places.get(row), cell) {
                column.set_f64(*row, Some(value));
            }
        });
        problems.extend(said(&own.name, read));
        unnamed.extend(put_column(&mut flight, &own.name, column));
    }
    let mut notes: Vec<Note> = problems.into_iter().map(Note::new).chain(unnamed).collect();
    if without > 0 {
        notes.push(Note::new(format!(
            "damaged: rows without a time from 0 on, left out: {without} ({})",
            percent(without, cells.footer.rows)
        )));
    }
    Ok((flight, notes))
}

fn said(name: &str, read: Result<(), Vec<GroupError>>) -> Option<String> {
    let problems = read.err()?;
    let more = if problems.len() > 1 {
        format!(", and {} more groups of rows", problems.len() - 1)
    } else {
        String::new()
    };
    Some(format!("damaged: column '{name}' could not be read: {}{more}; left empty there", problems.first()?))
}

/// The table in a Parquet file; its notes report what could not be read.
///
/// # Errors
/// [`ParquetError`].
pub fn table(log: &[u8]) -> Result<LoggedTable, ParquetError> {
    let cells = Cells::new(log)?;
    let rows = cells.footer.rows;
    let (mut names, mut columns, mut notes) = (Vec::new(), Vec::new(), Vec::new());
    let mut repeated = Vec::new();
    for (place, leaf) in cells.footer.leaves.iter().enumerate() {
        if leaf.is_repeated {
            repeated.push(leaf.name.as_str());
            continue;
        }
        let mut column = mapping::Cells { values: vec![f64::NAN; rows], ..mapping::Cells::default() };
        let read = cells.column(place, &mut |row, cell| column.put(row, cell));
        notes.extend(said(&leaf.name, read));
        names.push(leaf.name.clone());
        columns.push(column);
    }
    if !repeated.is_empty() {
        notes.push(format!("columns with several values a row, left out: {}", repeated.join(", ")));
    }
    Ok(LoggedTable {
        layout: None,
        units: vec![String::new(); names.len()],
        names,
        columns,
        lines: (1..=rows).collect(),
        unread: 0,
        first_unread: 0,
        notes,
    })
}
