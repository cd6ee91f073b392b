//! Reads a log as columns of numbers, whatever program wrote it; splits a text of separated values into
//! columns.

use super::cell::{Cell, cell};

/// The separator between two cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Separator {
    /// One character.
    Char(u8),
    /// Any number of spaces and tabs.
    Spaces,
}

impl Separator {
    /// From its name in a mapping file.
    pub fn from_name(name: &str) -> Option<Self> {
        match name {
            "," | "comma" => Some(Self::Char(b',')),
            ";" | "semicolon" => Some(Self::Char(b';')),
            "\t" | "tab" => Some(Self::Char(b'\t')),
            "|" => Some(Self::Char(b'|')),
            " " | "spaces" => Some(Self::Spaces),
            _ => None,
        }
    }

    /// Its name in a mapping file.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Char(b';') => ";",
            Self::Char(b'\t') => "tab",
            Self::Char(b'|') => "|",
            Self::Char(_) => ",",
            Self::Spaces => "spaces",
        }
    }
}

/// Layout of a text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Layout {
    /// Between two cells.
    pub separator: Separator,
    /// Whether numbers are written with a decimal comma, as 12,5.
    pub decimal_comma: bool,
    /// Line number of the column names, from 1; 0 if there is none.
    pub names_line: usize,
    /// Line number of the first values, from 1.
    pub first_line: usize,
}

/// One column.
#[derive(Clone, Debug, Default)]
pub struct Cells {
    /// Numbers; NaN for a cell without one. Times of day are seconds since midnight, dates seconds since
    /// 1970.
    pub values: Vec<f64>,
    /// Number of cells that are numbers.
    pub numbers: usize,
    /// Number of times of day.
    pub clocks: usize,
    /// Number of dates with their time.
    pub dates: usize,
    /// Number of words.
    pub words: usize,
}

impl Cells {
    /// Stores a cell in a row that has none yet.
    pub fn put(&mut self, row: usize, cell: Cell) {
        let (value, count) = match cell {
            Cell::Number(value) if value.is_finite() => (value, &mut self.numbers),
            Cell::Clock(value) => (value, &mut self.clocks),
            Cell::Date(value) => (value, &mut self.dates),
            Cell::Word => (f64::NAN, &mut self.words),
            Cell::Number(_) | Cell::Empty => return,
        };
        *count += 1;
        if let Some(slot) = self.values.get_mut(row) {
            *slot = value;
        }
    }
}

/// The columns of a log.
#[derive(Clone, Debug)]
pub struct LoggedTable {
    /// Its layout, if it is text.
    pub layout: Option<Layout>,
    /// Names of the columns; without a line of names "column 1" and so on.
    pub names: Vec<String>,
    /// The units in a line under the names.
    pub units: Vec<String>,
    /// The columns.
    pub columns: Vec<Cells>,
    /// Line number of each row, from 1; without text, the row's number.
    pub lines: Vec<usize>,
    /// Lines after the first values that have another number of cells, or a quote that is never closed.
    pub unread: usize,
    /// Line number of the first of them.
    pub first_unread: usize,
    /// Notes on what else could not be read.
    pub notes: Vec<String>,
}

/// Number of lines at the beginning that are used to detect the layout.
const HEAD: usize = 400;
/// Largest number of columns of a plausible log.
pub const MOST_COLUMNS: usize = 4_096;

/// The lines of a text with their numbers, from 1, without empty ones.
fn lines(text: &[u8]) -> impl Iterator<Item = (usize, &[u8])> {
    let text = text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(text);
    // Old programs end lines with only a carriage return.
    let end = if memchr::memchr(b'\n', text).is_some() { b'\n' } else { b'\r' };
    let numbered = text.split(move |byte| *byte == end).map(<[u8]>::trim_ascii).zip(1..);
    numbered.filter(|(line, _)| !line.is_empty()).map(|(line, number)| (number, line))
}

fn is_remark(line: &[u8]) -> bool {
    line.starts_with(b"#") || line.starts_with(b"%") || line.starts_with(b"//")
}

/// The cells of a line; `None` if a quote is never closed.
fn split(line: &[u8], separator: Separator) -> Option<Vec<&[u8]>> {
    let mut cells = Vec::new();
    let mut quoted = false;
    let mut start = 0;
    let is_end = |byte: u8| match separator {
        Separator::Char(separator) => byte == separator,
        Separator::Spaces => matches!(byte, b' ' | b'\t'),
    };
    for (at, byte) in line.iter().copied().enumerate() {
        if byte == b'"' {
            quoted = !quoted;
        } else if !quoted && is_end(byte) {
            cells.push(line.get(start..at).unwrap_or_default());
            start = at + 1;
        }
    }
    cells.push(line.get(start..).unwrap_or_default());
    if separator == Separator::Spaces {
        cells.retain(|cell| !cell.is_empty());
    }
    (!quoted).then_some(cells)
}

fn unquoted(cell: &[u8]) -> &[u8] {
    let cell = cell.trim_ascii();
    let inner = cell.strip_prefix(b"\"").and_then(|cell| cell.strip_suffix(b"\""));
    inner.unwrap_or(cell).trim_ascii()
}

/// Number of cells that are values, and that are words; empty ones are neither.
fn census(cells: &[&[u8]], decimal_comma: bool) -> (usize, usize) {
    let mut found = (0, 0);
    for text in cells {
        match cell(unquoted(text), decimal_comma) {
            Cell::Number(_) | Cell::Clock(_) | Cell::Date(_) => found.0 += 1,
            Cell::Word => found.1 += 1,
            Cell::Empty => {}
        }
    }
    found
}

impl Layout {
    /// Detects the layout of a text; `None` if it is not a table of at least two columns with numbers.
    pub fn find(text: &[u8]) -> Option<Self> {
        // A table of numbers has no control characters except tabs and line ends.
        let head = text.get(..65_536).unwrap_or(text);
        if head.iter().any(|byte| *byte < 9 || matches!(byte, 14..=26 | 28..=31)) {
            return None;
        }
        let head: Vec<_> = lines(text).take(HEAD).collect();
        let rows: Vec<_> = head.iter().filter(|(_, line)| !is_remark(line)).collect();
        let candidates =
            [b'\t', b';', b',', b'|'].map(Separator::Char).into_iter().chain([Separator::Spaces]);
        for separator in candidates {
            let split_rows: Vec<_> =
                rows.iter().filter_map(|(number, line)| Some((*number, split(line, separator)?))).collect();
            let Some(width) = usual_width(&split_rows) else { continue };
            // With semicolons between cells, a comma in a cell is a decimal comma.
            let decimal_comma = matches!(separator, Separator::Char(b';' | b'\t') | Separator::Spaces)
                && split_rows.iter().flat_map(|(_, cells)| cells).any(|text| {
                    matches!(cell(unquoted(text), true), Cell::Number(_)) && text.contains(&b',')
                });
            let is_values = |cells: &[&[u8]]| {
                let (values, words) = census(cells, decimal_comma);
                values > 0 && values >= words
            };
            let first = split_rows.iter().position(|(_, cells)| cells.len() == width && is_values(cells));
            let Some(first) = first else { continue };
            let first_line = split_rows.get(first).map_or(1, |(number, _)| *number);
            let names_line = names_line(&head, first_line, separator, width, decimal_comma);
            return Some(Self { separator, decimal_comma, names_line, first_line });
        }
        None
    }
}

/// The number of cells in most lines, at least two.
fn usual_width(rows: &[(usize, Vec<&[u8]>)]) -> Option<usize> {
    let mut widths: Vec<usize> = rows.iter().map(|(_, cells)| cells.len()).collect();
    widths.sort_unstable();
    let (width, count) = widths
        .chunk_by(|a, b| a == b)
        .map(|equal| (equal[0], equal.len()))
        .max_by_key(|(_, count)| *count)?;
    ((2..=MOST_COLUMNS).contains(&width) && count * 2 >= rows.len()).then_some(width)
}

/// The line of names above the first values: of several (names, then units) the upper one. It may be a
/// remark.
fn names_line(
    head: &[(usize, &[u8])],
    first_line: usize,
    separator: Separator,
    width: usize,
    decimal_comma: bool,
) -> usize {
    let above = head.iter().rev().filter(|(number, _)| *number < first_line).take(2);
    let names = above.take_while(|(_, line)| {
        let line = line.trim_ascii_start();
        split(uncommented(line), separator).is_some_and(|cells| {
            let (values, words) = census(&cells, decimal_comma);
            cells.len() == width && words > 0 && values * 4 <= words
        })
    });
    names.last().map_or(0, |(number, _)| *number)
}

fn uncommented(line: &[u8]) -> &[u8] {
    let start = line.iter().position(|byte| !matches!(byte, b'#' | b'%' | b'/' | b' ')).unwrap_or(0);
    line.get(start..).unwrap_or(line)
}

impl LoggedTable {
    /// Reads a text with this layout.
    pub fn read(text: &[u8], layout: Layout) -> Self {
        let Layout { separator, decimal_comma, names_line, first_line } = layout;
        let to_text = |cell: &[u8]| String::from_utf8_lossy(unquoted(cell)).into_owned();
        let of_line = |number: usize| {
            let found = lines(text).find(|(found, _)| number > 0 && *found == number);
            let cells = found.and_then(|(_, line)| split(uncommented(line), separator)).unwrap_or_default();
            cells.into_iter().map(to_text).collect::<Vec<String>>()
        };
        let mut names = of_line(names_line);
        let width = lines(text)
            .find(|(number, _)| *number >= first_line)
            .and_then(|(_, line)| split(line, separator))
            .map_or(names.len(), |cells| if names.is_empty() { cells.len() } else { names.len() })
            .min(MOST_COLUMNS);
        names.resize(width, String::new());
        for (name, place) in names.iter_mut().zip(1..) {
            if name.is_empty() {
                *name = format!("column {place}");
            }
        }
        let between = lines(text).map(|(number, _)| number).find(|number| *number > names_line);
        let mut units = match between {
            Some(line) if names_line > 0 && line < first_line => of_line(line),
            _ => Vec::new(),
        };
        units.resize(width, String::new());
        let mut table = Self {
            layout: Some(layout),
            names,
            units,
            columns: vec![Cells::default(); width],
            lines: Vec::new(),
            unread: 0,
            first_unread: 0,
            notes: Vec::new(),
        };
        for (number, line) in lines(text).skip_while(|(number, _)| *number < first_line) {
            if !is_remark(line) {
                table.push(number, split(line, separator), decimal_comma);
            }
        }
        table
    }

    fn push(&mut self, number: usize, cells: Option<Vec<&[u8]>>, decimal_comma: bool) {
        let width = self.columns.len();
        let fits = |cells: &Vec<&[u8]>| {
            // Some programs write an additional separator at the end.
            cells.len() >= width && cells.iter().skip(width).all(|cell| cell.trim_ascii().is_empty())
        };
        let Some(cells) = cells.filter(fits) else {
            self.first_unread = if self.unread == 0 { number } else { self.first_unread };
            self.unread += 1;
            return;
        };
        self.lines.push(number);
        for (column, text) in self.columns.iter_mut().zip(cells) {
            let row = column.values.len();
            column.values.push(f64::NAN);
            column.put(row, cell(unquoted(text), decimal_comma));
        }
    }

    /// The word for one of its rows in messages.
    pub const fn row_name(&self) -> &'static str {
        if self.layout.is_some() { "line" } else { "row" }
    }

    /// A column's values; empty for an index that does not exist.
    pub fn values(&self, column: usize) -> &[f64] {
        self.columns.get(column).map_or(&[], |cells| &cells.values)
    }

    /// A column's name.
    pub fn name(&self, column: usize) -> &str {
        self.names.get(column).map_or("", String::as_str)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> LoggedTable {
        LoggedTable::read(text.as_bytes(), Layout::find(text.as_bytes()).unwrap())
    }

    #[test]
    fn finds_separators_names_units_and_what_is_above_them() {
        let table = read(
            "Logger v3\nserial,12\ntime,alt,state\ns,m,\n0.1,5,\"up, fast\"\n0.2,6,x\n0.3,,y\n0.4,8,z,\n",
        );
        assert_eq!(table.names, ["time", "alt", "state"]);
        assert_eq!(table.units, ["s", "m", ""]);
        assert_eq!(table.layout.map(|layout| (layout.names_line, layout.first_line)), Some((3, 5)));
        assert_eq!(table.values(0), [0.1, 0.2, 0.3, 0.4]);
        assert!(table.values(1)[2].is_nan());
        assert_eq!((table.columns[2].words, table.unread), (4, 0));

        let table = read("# t; h\n0,5; 1.013,25\n1,0;1012,5\n");
        assert_eq!(
            (table.names.as_slice(), table.layout.map(|layout| layout.decimal_comma)),
            (&["t".into(), "h".to_owned()][..], Some(true))
        );
        assert_eq!(table.values(0), [0.5, 1.0]);

        let table = read("   0.0e+00   4.7e+01  3\n   1.3e+02   4.7e+01  4\n");
        let layout = table.layout.unwrap();
        assert_eq!((layout.separator, layout.names_line), (Separator::Spaces, 0));
        assert_eq!((table.names[2].as_str(), table.values(2)), ("column 3", &[3.0, 4.0][..]));
    }

    #[test]
    fn lines_that_do_not_fit_are_counted_with_their_place() {
        let table = read("t,h\n0,1\n1\n2,\"3\n3,4\n\n4,5,6\n5,6\n");
        assert_eq!((table.unread, table.first_unread), (3, 3));
        assert_eq!(table.lines, [2, 5, 8]);
    }

    #[test]
    fn what_is_no_table_is_none() {
        for text in [&b"\x00\x01,2\n3,4\n"[..], b"", b"hello\nworld\n", b"a,b\nc,d\n", b"1\n2\n3\n"] {
            assert_eq!(Layout::find(text), None, "{text:?}");
        }
    }
}
