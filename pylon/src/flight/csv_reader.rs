//! Reading a flight's CSV.
//!
//! The rows are parsed straight into columns, in as many threads as there are cores: the text is divided
//! at line ends, which never lie inside a cell, since every cell is a number.

use std::fs;
use std::io::Cursor;
use std::path::Path;
use std::thread;

use csv::{ByteRecord, ReaderBuilder};

use super::column::Column;
use super::error::{Problem, ReadError};
use super::names::{self, Meaning};
use super::note::Note;
use super::{AltitudeDatum, Channel, Flight, Header, MAX_TIME_S};

/// Text shorter than this is not worth another thread.
const SHORTEST_PART: usize = 1 << 20;
/// Receiver times from here on are too coarse in f32 to tell one fix from the next (step 0.125 s).
const MAX_GPS_TIME_S: f32 = 1_048_576.0;

/// Reads a flight from a CSV file, with notes on what was odd but readable.
///
/// # Errors
/// The first thing in the file that is not as [`crate::flight`] says, with file, row and column.
pub fn read(path: &Path) -> Result<(Flight, Vec<Note>), ReadError> {
    let text = fs::read(path).map_err(|error| ReadError::new(path, Problem::Io(error.to_string())))?;
    parse(&text).map_err(|problem| ReadError::new(path, problem))
}

/// Reads a flight from the text of a CSV file.
///
/// # Errors
/// As [`read`].
pub fn parse(text: &[u8]) -> Result<(Flight, Vec<Note>), Problem> {
    let text = text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(text);
    if text.trim_ascii().is_empty() {
        return Err(Problem::Empty);
    }
    let (header, head_lines, rest) = parse_header(text)?;
    let (names, names_row, rows) = parse_names(rest, head_lines)?;
    let (meanings, mut notes) = names::resolve(&names, names_row)?;
    let layout = Layout { names: &names, meanings: &meanings };
    let (time_s, columns) = parse_rows(rows, &layout, names_row + 1)?;
    if time_s.is_empty() {
        return Err(Problem::NoRows);
    }
    if !text.ends_with(b"\n") {
        notes.push(Note::new(
            "the last row has no line end: should the file be cut there, its last cell may lack digits",
        ));
    }
    let mut flight = Flight { header, time_s, ..Flight::default() };
    for (meaning, column) in meanings.into_iter().zip(columns) {
        match meaning {
            Meaning::Time => {}
            Meaning::Known(channel) => flight.channels.push((channel, column)),
            Meaning::Extra(name) => flight.extra.push((name, column)),
        }
    }
    Ok((flight, notes))
}

/// The next line without its end, and what follows it.
fn split_line(text: &[u8]) -> (&[u8], &[u8]) {
    match memchr::memchr(b'\n', text) {
        Some(end) => {
            let (line, rest) = text.split_at(end);
            (line, rest.get(1..).unwrap_or_default())
        }
        None => (text, &[]),
    }
}

/// The header lines, how many lines they are, and the text after them.
fn parse_header(text: &[u8]) -> Result<(Header, u64, &[u8]), Problem> {
    let mut header = Header::default();
    let mut seen: Vec<&str> = Vec::new();
    let mut row = 0;
    let mut rest = text;
    loop {
        let (line, after) = split_line(rest);
        let line = line.trim_ascii();
        let is_header = line.first() == Some(&b'#');
        if !is_header && (!line.is_empty() || rest.is_empty()) {
            break;
        }
        row += 1;
        rest = after;
        if is_header {
            let line = str::from_utf8(line)
                .map_err(|_| Problem::NotText { row, expected: "a header line '# key: value'" })?;
            parse_header_line(line, row, &mut header, &mut seen)?;
        }
    }
    if seen.contains(&VERSION) { Ok((header, row, rest)) } else { Err(Problem::NoVersion) }
}

/// Header key of the format's version.
const VERSION: &str = "pylon-flight";

fn parse_header_line<'a>(
    line: &'a str,
    row: u64,
    header: &mut Header,
    seen: &mut Vec<&'a str>,
) -> Result<(), Problem> {
    let body = line.strip_prefix('#').unwrap_or(line).trim();
    let (key, value) = body.split_once(':').map_or(("", body), |(key, value)| (key.trim(), value.trim()));
    if matches!(key, VERSION | "vehicle" | "source" | "altitude_datum") {
        if seen.contains(&key) {
            return Err(Problem::HeaderTwice { row, key: key.to_owned() });
        }
        seen.push(key);
    }
    match key {
        VERSION if value == "1" => {}
        VERSION => return Err(Problem::Version { row, found: shorten(value.as_bytes()) }),
        "vehicle" => value.clone_into(&mut header.vehicle),
        "source" => value.clone_into(&mut header.source),
        "altitude_datum" => {
            header.altitude_datum = match value {
                "msl" => AltitudeDatum::Msl,
                "ellipsoid" => AltitudeDatum::Ellipsoid,
                _ => {
                    let (key, found) = (key.to_owned(), shorten(value.as_bytes()));
                    return Err(Problem::HeaderValue { row, key, found, expected: "msl or ellipsoid" });
                }
            }
        }
        _ => header.other.push((key.to_owned(), value.to_owned())),
    }
    Ok(())
}

/// The column names, the line they are in, and the text after that line.
fn parse_names(text: &[u8], lines_before: u64) -> Result<(Vec<String>, u64, &[u8]), Problem> {
    let row = lines_before + 1;
    let mut reader = ReaderBuilder::new().has_headers(false).from_reader(Cursor::new(text));
    let mut record = ByteRecord::new();
    let not_text = |_| Problem::NotText { row, expected: "column names" };
    if !reader.read_byte_record(&mut record).map_err(|error| Problem::Io(error.to_string()))? {
        return Err(Problem::NoColumns);
    }
    let names = record
        .iter()
        .map(|name| str::from_utf8(name).map(|name| name.trim().to_owned()))
        .collect::<Result<Vec<_>, _>>()
        .map_err(not_text)?;
    if let [only] = names.as_slice() {
        for (separator, found) in [(';', "semicolons"), ('\t', "tabs"), (' ', "spaces")] {
            if only.contains(separator) {
                return Err(Problem::Separator { row, found });
            }
        }
    }
    let end = usize::try_from(reader.position().byte()).unwrap_or(usize::MAX);
    // A quoted name can hold a line end.
    let lines = count_lines(text.get(..end).unwrap_or(text));
    Ok((names, lines_before + lines.max(1), text.get(end..).unwrap_or_default()))
}

fn count_lines(text: &[u8]) -> u64 {
    memchr::memchr_iter(b'\n', text).count() as u64
}

struct Layout<'a> {
    names: &'a [String],
    meanings: &'a [Meaning],
}

/// One part of the rows: its times, and its cells by column (the time axis has an unused column).
type Part = (Vec<f64>, Vec<Column>);

fn parse_rows(text: &[u8], layout: &Layout<'_>, first_row: u64) -> Result<Part, Problem> {
    let threads = thread::available_parallelism().map_or(1, usize::from);
    let parts = split_at_lines(text, threads.min(text.len() / SHORTEST_PART).max(1));
    let mut results = thread::scope(|scope| {
        let handles: Vec<_> =
            parts.iter().map(|part| scope.spawn(move || parse_part(part, layout))).collect();
        handles
            .into_iter()
            .map(|handle| handle.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
            .collect::<Vec<_>>()
    })
    .into_iter();
    let mut row = first_row;
    let mut whole: Option<Part> = None;
    for part in parts {
        let Some(result) = results.next() else { break };
        let (time_s, columns) = result.map_err(|problem| problem.in_file(row))?;
        match &mut whole {
            None => whole = Some((time_s, columns)),
            Some((all_times, all_columns)) => {
                all_times.extend(time_s);
                for (all, column) in all_columns.iter_mut().zip(columns) {
                    all.append(column);
                }
            }
        }
        row += count_lines(part);
    }
    Ok(whole.unwrap_or_default())
}

/// The text in about equal parts, each but the last ending with a line end.
fn split_at_lines(text: &[u8], parts: usize) -> Vec<&[u8]> {
    let mut split = Vec::with_capacity(parts);
    let mut rest = text;
    for left in (2..=parts).rev() {
        let target = rest.len() / left;
        let Some(end) = rest.get(target..).and_then(|tail| memchr::memchr(b'\n', tail)) else { break };
        let (part, after) = rest.split_at(target + end + 1);
        split.push(part);
        rest = after;
    }
    split.push(rest);
    split
}

fn parse_part(text: &[u8], layout: &Layout<'_>) -> Result<Part, Problem> {
    let width = layout.meanings.len();
    // No row is shorter than one byte a cell, whatever the line ends say.
    let rows = (memchr::memchr_iter(b'\n', text).count() + 1).min(text.len() / width + 1);
    let mut time_s = Vec::with_capacity(rows);
    let mut columns: Vec<_> = layout
        .meanings
        .iter()
        .map(
            |meaning| if *meaning == Meaning::Time { Column::default() } else { Column::with_capacity(rows) },
        )
        .collect();
    let mut reader = ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .quoting(false)
        .buffer_capacity(1 << 16)
        .from_reader(text);
    let mut record = ByteRecord::new();
    while reader.read_byte_record(&mut record).map_err(|error| Problem::Io(error.to_string()))? {
        if record.len() != width {
            return Err(wrong_width(line(text, &record), record.len(), layout));
        }
        for ((cell, column), meaning) in record.iter().zip(&mut columns).zip(layout.meanings) {
            let cell = cell.trim_ascii();
            let good = match meaning {
                Meaning::Time => parse_time(cell).map(|time| time_s.push(time)),
                Meaning::Known(Channel::Launch) => parse_launch(cell).map(|value| column.push(value)),
                Meaning::Known(Channel::GpsTimeS) => parse_gps_time(cell).map(|value| column.push(value)),
                _ if cell.is_empty() => {
                    column.push(None);
                    Some(())
                }
                _ => parse_f32(cell).map(|value| column.push(Some(value))),
            };
            if good.is_none() {
                return Err(bad_cell(line(text, &record), cell, meaning));
            }
        }
    }
    Ok((time_s, columns))
}

/// A number, also one in quotes, which some programs put around every cell.
#[inline]
fn parse_f32(cell: &[u8]) -> Option<f32> {
    fast_float2::parse(cell).ok().or_else(|| fast_float2::parse(unquoted(cell)?).ok())
}

fn unquoted(cell: &[u8]) -> Option<&[u8]> {
    cell.strip_prefix(b"\"")?.strip_suffix(b"\"").map(<[u8]>::trim_ascii)
}

#[inline]
fn parse_time(cell: &[u8]) -> Option<f64> {
    let time: f64 = fast_float2::parse(cell).ok().or_else(|| fast_float2::parse(unquoted(cell)?).ok())?;
    (0.0..=MAX_TIME_S).contains(&time).then_some(time)
}

fn parse_optional(cell: &[u8], accept: impl Fn(f32) -> bool) -> Option<Option<f32>> {
    if cell.is_empty() || cell == b"\"\"" {
        return Some(None);
    }
    parse_f32(cell).filter(|value| accept(*value)).map(Some)
}

fn parse_launch(cell: &[u8]) -> Option<Option<f32>> {
    parse_optional(cell, |value| value == 0.0 || value == 1.0)
}

fn parse_gps_time(cell: &[u8]) -> Option<Option<f32>> {
    parse_optional(cell, |time| !(time.is_finite() && time.abs() >= MAX_GPS_TIME_S))
}

/// The record's line within the part, until [`Problem::in_file`] makes it one within the file.
///
/// The csv crate's own position is where the last record ended: before blank lines and, in files with
/// CR LF, before the LF.
fn line(text: &[u8], record: &ByteRecord) -> u64 {
    let end_of_last = record.position().map_or(0, |position| usize::try_from(position.byte()).unwrap_or(0));
    let gap = text.iter().skip(end_of_last).take_while(|byte| matches!(byte, b'\r' | b'\n')).count();
    1 + count_lines(text.get(..end_of_last + gap).unwrap_or(text))
}

fn wrong_width(row: u64, found: usize, layout: &Layout<'_>) -> Problem {
    let expected = layout.meanings.len();
    if found > expected {
        return Problem::TooManyCells { row, found, expected };
    }
    let last = layout.names.get(found.saturating_sub(1)).cloned().unwrap_or_default();
    Problem::Cut { row, found, expected, last }
}

fn bad_cell(row: u64, cell: &[u8], meaning: &Meaning) -> Problem {
    let (column, expected) = match meaning {
        Meaning::Time => (names::TIME.to_owned(), "seconds from 0 on (up to 9e9)"),
        Meaning::Known(Channel::Launch) => (Channel::Launch.name().to_owned(), "0 or 1"),
        Meaning::Known(Channel::GpsTimeS) => (
            Channel::GpsTimeS.name().to_owned(),
            "seconds below 1048576 (count them from the flight's start)",
        ),
        Meaning::Known(channel) => (channel.name().to_owned(), "a number or an empty cell"),
        Meaning::Extra(name) => (name.clone(), "a number or an empty cell"),
    };
    Problem::Cell { row, column, found: shorten(cell), expected }
}

/// Text for a message: one line, not too long, every control character visible.
fn shorten(text: &[u8]) -> String {
    const LONGEST: usize = 40;
    let text = String::from_utf8_lossy(text);
    let short: String = text.chars().take(LONGEST).flat_map(char::escape_debug).collect();
    if text.chars().nth(LONGEST).is_some() { short + "..." } else { short }
}

impl Problem {
    /// The same problem of a part whose first line is line `first_row` of the file.
    fn in_file(mut self, first_row: u64) -> Self {
        if let Self::Cut { row, .. } | Self::TooManyCells { row, .. } | Self::Cell { row, .. } = &mut self {
            *row += first_row - 1;
        }
        self
    }
}

#[cfg(test)]
mod tests;
