//! The rows of a flight's CSV, parsed straight into columns.
//!
//! Every cell is a number, so numbers are read in place, without first cutting the text into cells, and the
//! text can be divided at any line end and read in parts.

use executor::Executor;
use fast_float2::FastFloat;

use super::super::column::Column;
use super::super::error::CsvProblem;
use super::super::names::Meaning;
use super::super::{Channel, MAX_TIME_S};
use super::{count_lines, shorten};

/// Text shorter than this is not divided.
pub(super) const SHORTEST_PART: usize = 1 << 20;
/// From this time on, receiver times are too coarse in f32 to distinguish one fix from the next (step 0.125
/// s).
const MAX_GPS_TIME_S: f32 = 1_048_576.0;

/// The columns of the file.
pub(super) struct Layout<'a> {
    pub names: &'a [String],
    pub meanings: &'a [Meaning],
}

/// The rows: their times, and their cells by column (the time axis has an unused column).
pub(super) type Rows = (Vec<f64>, Vec<Column>);

/// Every row of the text; its first line is line `first_row` of the file.
///
/// The columns have as many rows as there are lines, and each part of the text fills its own piece of them.
pub(super) fn parse_rows(
    text: &[u8],
    layout: &Layout<'_>,
    first_row: u64,
    executor: &dyn Executor,
) -> Result<Rows, CsvProblem> {
    let parts = split_at_lines(text, executor.width().min(text.len() / SHORTEST_PART).max(1));
    let width = layout.meanings.len();
    let room = executor::map(executor, parts.iter().map(|part| move || most_rows(part, width)));
    let rows = room.iter().sum();
    let mut time_s = vec![0.0; rows];
    let mut columns: Vec<Cells> = layout
        .meanings
        .iter()
        .map(|meaning| match meaning {
            Meaning::Time => Cells::Single(Vec::new()),
            Meaning::Extra(name) if Column::is_double_named(name) => Cells::Double(vec![0.0; rows]),
            _ => Cells::Single(vec![0.0; rows]),
        })
        .collect();
    let mut pieces =
        Pieces { time_s: &mut time_s, columns: columns.iter_mut().map(Cells::as_piece).collect() };
    let pieces: Vec<Pieces<'_>> = room.iter().map(|rows| pieces.split_off(*rows)).collect();
    let jobs = parts.iter().zip(pieces).map(|(part, pieces)| move || parse_part(part, layout, pieces));
    let mut row = first_row;
    let mut filled = Vec::with_capacity(parts.len());
    for (part, result) in parts.iter().zip(executor::map(executor, jobs)) {
        filled.push(result.map_err(|problem| problem.in_file(row))?);
        row += count_lines(part);
    }
    close_gaps(&mut time_s, &room, &filled);
    let columns = columns.into_iter().map(|cells| match cells {
        Cells::Single(mut cells) => {
            close_gaps(&mut cells, &room, &filled);
            Column::from_cells(cells)
        }
        Cells::Double(mut cells) => {
            close_gaps(&mut cells, &room, &filled);
            Column::from_double_cells(cells)
        }
    });
    Ok((time_s, columns.collect()))
}

/// Largest number of rows in a text: one a line, and none is shorter than one byte a cell, whatever the line
/// ends.
fn most_rows(text: &[u8], width: usize) -> usize {
    let count = |byte| memchr::memchr_iter(byte, text).count();
    let mut ends = count(b'\n');
    // A line may end with a carriage return, as on old Macs; with a line feed it is one end.
    let returns = count(b'\r');
    if returns > 0 {
        ends += returns - memchr::memmem::find_iter(text, b"\r\n").count();
    }
    let lines = ends + usize::from(!text.ends_with(b"\n"));
    lines.min(text.len() / width + 1)
}

/// Closes the gaps that blank lines left: moves together the cells that each part has filled of its room.
fn close_gaps<T: Copy>(cells: &mut Vec<T>, room: &[usize], filled: &[usize]) {
    if cells.is_empty() {
        return;
    }
    let (mut from, mut to) = (0, 0);
    for (room, filled) in room.iter().zip(filled) {
        if from != to {
            cells.copy_within(from..from + filled, to);
        }
        from += room;
        to += filled;
    }
    cells.truncate(to);
}

/// A column that is being filled.
enum Cells {
    Single(Vec<f32>),
    Double(Vec<f64>),
}

impl Cells {
    fn as_piece(&mut self) -> Piece<'_> {
        match self {
            Self::Single(cells) => Piece::Single(cells),
            Self::Double(cells) => Piece::Double(cells),
        }
    }
}

/// Some rows of a column.
enum Piece<'a> {
    Single(&'a mut [f32]),
    Double(&'a mut [f64]),
}

/// The piece of the columns that one part of the text fills: its rows of every column.
struct Pieces<'a> {
    time_s: &'a mut [f64],
    columns: Vec<Piece<'a>>,
}

impl<'a> Pieces<'a> {
    /// Takes the first rows off.
    fn split_off(&mut self, rows: usize) -> Pieces<'a> {
        fn first<'a, T>(cells: &mut &'a mut [T], rows: usize) -> &'a mut [T] {
            let whole = std::mem::take(cells);
            let (first, rest) = whole.split_at_mut(rows.min(whole.len()));
            *cells = rest;
            first
        }
        Pieces {
            time_s: first(&mut self.time_s, rows),
            columns: self
                .columns
                .iter_mut()
                .map(|piece| match piece {
                    Piece::Single(cells) => Piece::Single(first(cells, rows)),
                    Piece::Double(cells) => Piece::Double(first(cells, rows)),
                })
                .collect(),
        }
    }
}

/// The text in about equal parts, each but the last ending with a line end.
pub(super) fn split_at_lines(text: &[u8], parts: usize) -> Vec<&[u8]> {
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

/// Fills the rows of a part and returns how many there are.
fn parse_part(text: &[u8], layout: &Layout<'_>, pieces: Pieces<'_>) -> Result<usize, CsvProblem> {
    let width = layout.meanings.len();
    let Pieces { time_s, mut columns } = pieces;
    let mut cells = Cursor { rest: text };
    let mut rows = 0;
    while cells.skip_line_ends() {
        let row = cells.rest;
        for (index, (column, meaning)) in columns.iter_mut().zip(layout.meanings).enumerate() {
            let before = cells.rest;
            let good = match (meaning, column) {
                (Meaning::Time, _) => match cells.number() {
                    Cell::Number(time) if (0.0..=MAX_TIME_S).contains(&time) => put(time_s, rows, time),
                    _ => false,
                },
                (_, Piece::Double(column)) => match cells.number::<f64>() {
                    Cell::Number(value) => put(column, rows, Column::double_cell(Some(value))),
                    Cell::Empty => put(column, rows, Column::double_cell(None)),
                    Cell::Text => false,
                },
                (_, Piece::Single(column)) => match cells.number::<f32>() {
                    Cell::Number(value) => {
                        put(column, rows, Column::cell(Some(value))) && is_possible(meaning, value)
                    }
                    Cell::Empty => put(column, rows, Column::cell(None)),
                    Cell::Text => false,
                },
            };
            let is_last = index + 1 == width;
            if !good || cells.comma() == is_last {
                let line = 1 + count_lines(text.get(..text.len() - row.len()).unwrap_or(text));
                return Err(bad_row(line, row, before, index, layout));
            }
        }
        rows += 1;
    }
    Ok(rows)
}

/// Stores a value; there is a place for every complete row.
#[inline]
fn put<T>(cells: &mut [T], row: usize, value: T) -> bool {
    cells.get_mut(row).map(|cell| *cell = value).is_some()
}

/// What a column requires of its numbers.
#[inline]
fn is_possible(meaning: &Meaning, value: f32) -> bool {
    match meaning {
        Meaning::Known(Channel::Launch) => value == 0.0 || value == 1.0,
        Meaning::Known(Channel::LaunchDoubt) => [0.0, 1.0, 2.0].contains(&value),
        Meaning::Known(Channel::GpsTimeS) => !(value.is_finite() && value.abs() >= MAX_GPS_TIME_S),
        _ => true,
    }
}

/// Content of a cell.
enum Cell<T> {
    Empty,
    Number(T),
    Text,
}

/// Walks over the text cell by cell.
struct Cursor<'a> {
    rest: &'a [u8],
}

fn ends_cell(byte: u8) -> bool {
    matches!(byte, b',' | b'\n' | b'\r')
}

/// The cell at the beginning of the text.
fn first_cell(text: &[u8]) -> &[u8] {
    let end = text.iter().position(|byte| ends_cell(*byte)).unwrap_or(text.len());
    text.get(..end).unwrap_or(text)
}

impl Cursor<'_> {
    /// Moves to the next line that is not blank; false at the end of the text.
    #[inline]
    fn skip_line_ends(&mut self) -> bool {
        while let [b'\n' | b'\r', rest @ ..] = self.rest {
            self.rest = rest;
        }
        !self.rest.is_empty()
    }

    /// Skips a comma, if there is one.
    #[inline]
    fn comma(&mut self) -> bool {
        match self.rest {
            [b',', rest @ ..] => {
                self.rest = rest;
                true
            }
            _ => false,
        }
    }

    /// Skips a cell that should hold a number.
    #[inline]
    fn number<T: FastFloat>(&mut self) -> Cell<T> {
        if self.rest.first().is_none_or(|byte| ends_cell(*byte)) {
            return Cell::Empty;
        }
        if let Ok((value, length)) = fast_float2::parse_partial(self.rest)
            && let Some(rest) = self.rest.get(length..)
            && rest.first().is_none_or(|byte| ends_cell(*byte))
        {
            self.rest = rest;
            return Cell::Number(value);
        }
        self.padded_number()
    }

    /// A number with spaces around it, or in quotes, which some programs put around every cell.
    #[cold]
    fn padded_number<T: FastFloat>(&mut self) -> Cell<T> {
        let cell = first_cell(self.rest);
        self.rest = self.rest.get(cell.len()..).unwrap_or_default();
        let cell = cell.trim_ascii();
        let unquoted = cell.strip_prefix(b"\"").and_then(|cell| cell.strip_suffix(b"\""));
        match unquoted.map_or(cell, <[u8]>::trim_ascii) {
            [] => Cell::Empty,
            cell => fast_float2::parse(cell).map_or(Cell::Text, Cell::Number),
        }
    }
}

/// What is wrong with a row: its number of cells, or else the cell at `index`, which begins at `from`.
fn bad_row(row: u64, text: &[u8], from: &[u8], index: usize, layout: &Layout<'_>) -> CsvProblem {
    let line_end = text.iter().position(|byte| matches!(byte, b'\n' | b'\r')).unwrap_or(text.len());
    let line = text.get(..line_end).unwrap_or(text);
    let (found, expected) = (1 + memchr::memchr_iter(b',', line).count(), layout.meanings.len());
    if found > expected {
        return CsvProblem::TooManyCells { row, found, expected };
    }
    if found < expected {
        let last = layout.names.get(found - 1).cloned().unwrap_or_default();
        return CsvProblem::Cut { row, found, expected, last };
    }
    let expected = match layout.meanings.get(index) {
        Some(Meaning::Time) => "seconds from 0 on (up to 9e9)",
        Some(Meaning::Known(Channel::Launch)) => "0 or 1",
        Some(Meaning::Known(Channel::LaunchDoubt)) => "0, 1 or 2",
        Some(Meaning::Known(Channel::GpsTimeS)) => {
            "seconds below 1048576 (count them from the flight's start)"
        }
        _ => "a number or an empty cell",
    };
    let column = layout.names.get(index).cloned().unwrap_or_default();
    CsvProblem::Cell { row, column, found: shorten(first_cell(from).trim_ascii()), expected }
}

impl CsvProblem {
    /// The same problem, for a part whose first line is line `first_row` of the file.
    fn in_file(mut self, first_row: u64) -> Self {
        if let Self::Cut { row, .. } | Self::TooManyCells { row, .. } | Self::Cell { row, .. } = &mut self {
            *row += first_row - 1;
        }
        self
    }
}
