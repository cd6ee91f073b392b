//! The footer of a Parquet file: its columns, its groups of rows, and where in the file they are.

use super::error::{FooterError, ParquetError};
use super::thrift::{Reader, Value};

/// First and last bytes of a Parquet file.
pub const MAGIC: &[u8] = b"PAR1";
/// The same of a file with an encrypted footer.
const ENCRYPTED: &[u8] = b"PARE";
/// Largest number of columns of a table: the same as for tables of text.
const MOST_COLUMNS: usize = crate::import::mapping::MOST_COLUMNS;
/// Largest number of cells a byte: a run of equal or missing values takes next to no space, but a time for
/// each row does.
const CELLS_PER_BYTE: usize = 32;
/// Number of cells that is always allowed, however short the file is: 8 MB as doubles.
const FEW_CELLS: usize = 1 << 20;
/// Largest nesting of groups.
const DEEPEST: usize = 16;

/// Meaning of a column's numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// Numbers or words, as they are.
    Plain,
    /// Unsigned whole numbers.
    Unsigned,
    /// Days since 1970.
    Date,
    /// Times of day, in units of this many seconds.
    Clock(f64),
    /// Times since 1970, in units of this many seconds.
    Stamp(f64),
    /// Whole numbers, in units of this.
    Decimal(f64),
    /// Floats of two bytes.
    Half,
}

/// A column.
#[derive(Clone, Debug)]
pub struct Leaf {
    /// Its name, preceded by those of its groups, separated by points.
    pub name: String,
    /// Meaning of its numbers.
    pub kind: Kind,
    /// Whether it has several values a row.
    pub is_repeated: bool,
    /// Size of one of its values, bytes; `None` for texts.
    pub width: Option<usize>,
}

/// Position of a column of one group of rows.
#[derive(Clone, Debug)]
pub struct Chunk {
    /// Its first byte in the file.
    pub start: usize,
    /// Its length, bytes.
    pub length: usize,
    /// Number of values, including nulls.
    pub values: usize,
    /// Compression, by the format's number.
    pub codec: i64,
}

/// A group of rows.
#[derive(Clone, Debug)]
pub struct Group {
    /// Number of rows.
    pub rows: usize,
    /// Position of each column, or why it has none.
    pub chunks: Vec<Result<Chunk, &'static str>>,
}

/// A file's footer.
#[derive(Clone, Debug)]
pub struct Footer<'a> {
    /// Its bytes.
    pub bytes: &'a [u8],
    /// The columns.
    pub leaves: Vec<Leaf>,
    /// The groups of rows.
    pub groups: Vec<Group>,
    /// Number of all rows.
    pub rows: usize,
    /// The file's key-value metadata.
    pub keys: Vec<(String, String)>,
}

/// The bytes of the footer of a file that begins as Parquet.
fn bytes(file: &[u8]) -> Result<&[u8], ParquetError> {
    if file.starts_with(ENCRYPTED) || file.ends_with(ENCRYPTED) {
        return Err(ParquetError::Encrypted);
    }
    let inner =
        file.strip_prefix(MAGIC).and_then(|file| file.strip_suffix(MAGIC)).ok_or(ParquetError::Cut)?;
    let (before, length) = inner.split_last_chunk::<4>().ok_or(ParquetError::Cut)?;
    let length = u32::from_le_bytes(*length) as usize;
    let start = before.len().checked_sub(length).ok_or_else(|| damaged("it is longer than the file"))?;
    Ok(before.get(start..).unwrap_or_default())
}

fn damaged(what: &'static str) -> ParquetError {
    FooterError::Damaged(what).into()
}

impl<'a> Footer<'a> {
    /// Reads a file's footer.
    ///
    /// # Errors
    /// [`ParquetError`].
    pub fn read(file: &'a [u8]) -> Result<Self, ParquetError> {
        let bytes = bytes(file)?;
        let tree = Reader::new(bytes).structure().ok_or_else(|| damaged("it is cut off"))?;
        let leaves = leaves(tree.list(2))?;
        let mut groups = Vec::new();
        let mut rows: i64 = 0;
        for group in tree.list(4) {
            let own = group
                .int(3)
                .filter(|own| *own >= 0)
                .ok_or_else(|| damaged("a group without a number of rows"))?;
            rows = rows.saturating_add(own);
            // Known to fit: checked below, before it is used.
            let own = usize::try_from(own).unwrap_or(usize::MAX);
            let columns = group.list(1);
            if columns.len() != leaves.len() {
                return Err(damaged("a group of rows without some columns"));
            }
            let chunks = columns.iter().map(|column| chunk(column, file.len() - MAGIC.len(), own)).collect();
            groups.push(Group { rows: own, chunks });
        }
        let most = file.len().saturating_mul(CELLS_PER_BYTE).max(FEW_CELLS);
        let columns = leaves.len();
        let total = usize::try_from(rows).unwrap_or(usize::MAX);
        if total.saturating_mul(columns.max(1)) > most {
            return Err(ParquetError::TooMany { bytes: file.len(), rows, columns, most });
        }
        if total == 0 || leaves.iter().all(|leaf| leaf.is_repeated) {
            return Err(ParquetError::Nothing);
        }
        let keys =
            tree.list(5).iter().filter_map(|key| Some((key.text(1)?, key.text(2).unwrap_or_default())));
        Ok(Self { bytes, leaves, groups, rows: total, keys: keys.collect() })
    }
}

/// A group of the schema whose columns follow.
struct Open {
    left: i64,
    is_repeated: bool,
    /// Length of the path before it, bytes.
    path: usize,
}

/// The columns of a schema, which is a tree written depth first.
fn leaves(schema: &[Value<'_>]) -> Result<Vec<Leaf>, ParquetError> {
    let wrong = || damaged("its tree of columns is invalid");
    let (root, elements) = schema.split_first().ok_or_else(wrong)?;
    let mut open = vec![Open { left: root.int(5).unwrap_or(0), is_repeated: false, path: 0 }];
    let mut path = String::new();
    let mut leaves = Vec::new();
    for element in elements {
        while let Some(done) = open.pop_if(|group| group.left == 0) {
            path.truncate(done.path);
        }
        let parent = open.last_mut().filter(|group| group.left > 0).ok_or_else(wrong)?;
        parent.left -= 1;
        let name = element.text(4).ok_or_else(wrong)?;
        let is_repeated = parent.is_repeated || element.int(3) == Some(2);
        match element.int(5).filter(|children| *children != 0) {
            Some(children) => {
                if children < 0 || open.len() > DEEPEST {
                    return Err(wrong());
                }
                open.push(Open { left: children, is_repeated, path: path.len() });
                path += &name;
                path.push('.');
            }
            None if leaves.len() == MOST_COLUMNS => return Err(damaged("more columns than any log has")),
            None => {
                let name = format!("{path}{name}").replace(char::is_control, " ");
                leaves.push(Leaf { name, kind: kind(element), is_repeated, width: width(element) });
            }
        }
    }
    let is_whole = open.iter().all(|group| group.left == 0);
    if is_whole { Ok(leaves) } else { Err(wrong()) }
}

/// Size of a column's values, bytes, by the format's number of the physical type.
fn width(element: &Value<'_>) -> Option<usize> {
    match element.int(1)? {
        0 => Some(0),
        1 | 4 => Some(4),
        2 | 5 => Some(8),
        3 => Some(12),
        7 => usize::try_from(element.int(2)?).ok().filter(|width| (1..=32).contains(width)),
        _ => None,
    }
}

/// Meaning of a column's numbers, by its logical type or the older converted one.
fn kind(element: &Value<'_>) -> Kind {
    let per_unit = |time: &Value<'_>| match time.field(2) {
        Some(unit) if unit.field(1).is_some() => 1e-3,
        Some(unit) if unit.field(3).is_some() => 1e-9,
        _ => 1e-6,
    };
    let decimal = || Kind::Decimal(10_f64.powi(-i32::try_from(element.int(7).unwrap_or(0)).unwrap_or(0)));
    // Julian days and nanoseconds within them: times written by old programs.
    if element.int(1) == Some(3) {
        return Kind::Stamp(1e-9);
    }
    if let Some(logical) = element.field(10) {
        if logical.field(5).is_some() {
            return decimal();
        } else if logical.field(6).is_some() {
            return Kind::Date;
        } else if let Some(time) = logical.field(7) {
            return Kind::Clock(per_unit(time));
        } else if let Some(stamp) = logical.field(8) {
            return Kind::Stamp(per_unit(stamp));
        } else if logical.field(10).is_some_and(|integer| integer.int(2) == Some(0)) {
            return Kind::Unsigned;
        } else if logical.field(15).is_some() {
            return Kind::Half;
        }
    }
    match element.int(6) {
        Some(5) => decimal(),
        Some(6) => Kind::Date,
        Some(7) => Kind::Clock(1e-3),
        Some(8) => Kind::Clock(1e-6),
        Some(9) => Kind::Stamp(1e-3),
        Some(10) => Kind::Stamp(1e-6),
        Some(11..=14) => Kind::Unsigned,
        _ => Kind::Plain,
    }
}

/// Position of a column of one group; `end` is the end of the bytes that can belong to a column.
fn chunk(column: &Value<'_>, end: usize, rows: usize) -> Result<Chunk, &'static str> {
    if column.text(1).is_some() {
        return Err("it is in another file");
    }
    let metadata = column.field(3).ok_or("it is encrypted, or its position is missing")?;
    let place = |number: i16| metadata.int(number).and_then(|value| usize::try_from(value).ok());
    let first = match metadata.int(11) {
        Some(_) => place(11),
        None => place(9),
    };
    let (start, length) = first.zip(place(7)).ok_or("its position is missing")?;
    if start < MAGIC.len() || start.checked_add(length).is_none_or(|behind| behind > end) {
        return Err("its position is outside the file");
    }
    let values = place(5).ok_or("its number of values is missing")?;
    if values != rows {
        return Err("it has another number of values than the group has rows");
    }
    let codec = metadata.int(4).ok_or("its compression is missing")?;
    Ok(Chunk { start, length, values, codec })
}
