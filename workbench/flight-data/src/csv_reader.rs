//! Reading a flight from CSV.

mod rows;

use std::io::Cursor;

use csv::{ByteRecord, ReaderBuilder};
use executor::{Executor, Inline};

use self::rows::{Layout, parse_rows};
use super::datum;
use super::error::CsvProblem;
use super::names::{self, Meaning};
use super::note::Note;
use super::{AltitudeDatum, Flight, Header};

/// Reads a flight from the text of a CSV file, with notes on what was unusual but readable.
///
/// # Errors
/// The first violation of the format described in [the crate](crate), with row and column.
pub fn parse(text: &[u8]) -> Result<(Flight, Vec<Note>), CsvProblem> {
    parse_with(text, &Inline)
}

/// As [`parse`], with a long text divided into as many parts as the executor can do at a time. The flight is
/// the same whatever the executor.
///
/// # Errors
/// As [`parse`].
pub fn parse_with(text: &[u8], executor: &dyn Executor) -> Result<(Flight, Vec<Note>), CsvProblem> {
    let text = text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(text);
    if text.trim_ascii().is_empty() {
        return Err(CsvProblem::Empty);
    }
    let (header, head_lines, rest) = parse_header(text)?;
    let (names, names_row, rows) = parse_names(rest, head_lines)?;
    let (meanings, mut notes) = names::resolve(&names, names_row)?;
    let layout = Layout { names: &names, meanings: &meanings };
    let (time_s, columns) = parse_rows(rows, &layout, names_row + 1, executor)?;
    if time_s.is_empty() {
        return Err(CsvProblem::NoRows);
    }
    if !matches!(text.last(), Some(b'\n' | b'\r')) {
        notes.push(Note::new(
            "the last row has no line end: if the file is cut off there, its last cell may lack digits",
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

/// The next line without its end, which is a line feed, a carriage return or both, and the text after it.
fn split_line(text: &[u8]) -> (&[u8], &[u8]) {
    match memchr::memchr2(b'\n', b'\r', text) {
        Some(end) => {
            let (line, rest) = text.split_at(end);
            let after = rest.strip_prefix(b"\r\n").or_else(|| rest.get(1..));
            (line, after.unwrap_or_default())
        }
        None => (text, &[]),
    }
}

/// The header lines, how many there are, and the text after them.
fn parse_header(text: &[u8]) -> Result<(Header, u64, &[u8]), CsvProblem> {
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
                .map_err(|_| CsvProblem::NotText { row, expected: "a header line '# key: value'" })?;
            parse_header_line(line, row, &mut header, &mut seen)?;
        }
    }
    if seen.contains(&VERSION) { Ok((header, row, rest)) } else { Err(CsvProblem::NoVersion) }
}

/// Header key of the format version.
const VERSION: &str = "pylon-flight";

fn parse_header_line<'a>(
    line: &'a str,
    row: u64,
    header: &mut Header,
    seen: &mut Vec<&'a str>,
) -> Result<(), CsvProblem> {
    let body = line.strip_prefix('#').unwrap_or(line).trim();
    let (key, value) = body.split_once(':').map_or(("", body), |(key, value)| (key.trim(), value.trim()));
    if matches!(key, VERSION | "vehicle" | "source" | "altitude_datum") {
        if seen.contains(&key) {
            return Err(CsvProblem::HeaderTwice { row, key: key.to_owned() });
        }
        seen.push(key);
    }
    match key {
        VERSION if value == "1" => {}
        VERSION => return Err(CsvProblem::Version { row, found: shorten(value.as_bytes()) }),
        "vehicle" => value.clone_into(&mut header.vehicle),
        "source" => value.clone_into(&mut header.source),
        "altitude_datum" => {
            header.altitude_datum = match value {
                "msl" => AltitudeDatum::Msl,
                "ellipsoid" => AltitudeDatum::Ellipsoid,
                _ => {
                    let (key, found) = (key.to_owned(), shorten(value.as_bytes()));
                    return Err(CsvProblem::HeaderValue { row, key, found, expected: "msl or ellipsoid" });
                }
            }
        }
        _ => {
            if datum::column_of(key).is_some() && AltitudeDatum::from_name(value).is_none() {
                let (key, found) = (key.to_owned(), shorten(value.as_bytes()));
                return Err(CsvProblem::HeaderValue {
                    row,
                    key,
                    found,
                    expected: "msl, ellipsoid or pressure",
                });
            }
            header.other.push((key.to_owned(), value.to_owned()));
        }
    }
    Ok(())
}

/// The column names, the line they are on, and the text after that line.
fn parse_names(text: &[u8], lines_before: u64) -> Result<(Vec<String>, u64, &[u8]), CsvProblem> {
    let row = lines_before + 1;
    let mut reader = ReaderBuilder::new().has_headers(false).from_reader(Cursor::new(text));
    let mut record = ByteRecord::new();
    let not_text = |_| CsvProblem::NotText { row, expected: "column names" };
    if !reader.read_byte_record(&mut record).map_err(CsvProblem::Names)? {
        return Err(CsvProblem::NoColumns);
    }
    let names = record
        .iter()
        .map(|name| str::from_utf8(name).map(|name| name.trim().to_owned()))
        .collect::<Result<Vec<_>, _>>()
        .map_err(not_text)?;
    let (first_line, _) = split_line(text);
    if first_line.iter().filter(|byte| **byte == b'"').count() % 2 == 1 {
        return Err(CsvProblem::OpenQuote { row });
    }
    if let Some(place) = names.iter().position(|name| name.contains(['\n', '\r', '\0'])) {
        return Err(CsvProblem::LineEndInName { row, index: place + 1 });
    }
    if let [only] = names.as_slice() {
        for (separator, found) in [(';', "semicolons"), ('\t', "tabs"), (' ', "spaces")] {
            if only.contains(separator) {
                return Err(CsvProblem::Separator { row, found });
            }
        }
    }
    let end = usize::try_from(reader.position().byte()).unwrap_or(usize::MAX);
    // A quoted name can contain a line end.
    let lines = count_lines(text.get(..end).unwrap_or(text));
    Ok((names, lines_before + lines.max(1), text.get(end..).unwrap_or_default()))
}

fn count_lines(text: &[u8]) -> u64 {
    memchr::memchr_iter(b'\n', text).count() as u64
}

/// Text for a message: one line, shortened, every control character visible.
fn shorten(text: &[u8]) -> String {
    const LONGEST: usize = 40;
    let text = String::from_utf8_lossy(text);
    let short: String = text.chars().take(LONGEST).flat_map(char::escape_debug).collect();
    if text.chars().nth(LONGEST).is_some() { short + "..." } else { short }
}

#[cfg(test)]
mod tests;
