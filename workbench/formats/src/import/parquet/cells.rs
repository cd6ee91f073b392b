//! Reads the cells of a Parquet file, column by column, group by group.

use std::sync::Arc;

use bytes::Bytes;
use parquet::column::reader::{ColumnReader, ColumnReaderImpl, get_column_reader};
use parquet::data_type::{AsBytes, DataType};
use parquet::errors::Result as ParquetResult;
use parquet::file::metadata::{ParquetMetaData, ParquetMetaDataReader};
use parquet::file::reader::{ChunkReader, Length};
use parquet::file::serialized_reader::SerializedPageReader;

use super::error::{ChunkError, FooterError, GroupError, ParquetError};
use super::footer::{Footer, Group, Kind, Leaf};
use super::pages;
use crate::import::mapping::cell::{Cell, cell};
use executor::contained::contained;

/// Rows decoded at once.
const BATCH: usize = 8_192;
const DAY_S: f64 = 86_400.0;

/// A file whose footer was read.
#[derive(Debug)]
pub struct Cells<'a> {
    file: &'a [u8],
    /// Content of the footer.
    pub footer: Footer<'a>,
    metadata: ParquetMetaData,
}

impl<'a> Cells<'a> {
    /// Reads a file's footer.
    ///
    /// # Errors
    /// [`ParquetError`].
    pub fn new(file: &'a [u8]) -> Result<Self, ParquetError> {
        let footer = Footer::read(file)?;
        let metadata = contained(|| ParquetMetaDataReader::decode_metadata(footer.bytes))
            .map_err(FooterError::from)?
            .map_err(FooterError::from)?;
        if metadata.file_metadata().schema_descr().num_columns() != footer.leaves.len() {
            return Err(FooterError::Damaged("its tree of columns is invalid").into());
        }
        Ok(Self { file, footer, metadata })
    }

    /// Passes on each cell of a column that has a value, with its row. Numbers may be infinite or NaN.
    ///
    /// # Errors
    /// The groups of rows that cannot be read, with the reason. The cells of the others are passed on.
    pub fn column(&self, place: usize, take: &mut dyn FnMut(usize, Cell)) -> Result<(), Vec<GroupError>> {
        let mut problems = Vec::new();
        let mut first_row = 0;
        for (number, group) in self.footer.groups.iter().enumerate() {
            if let Err(why) = self.chunk(number, group, place, first_row, take) {
                problems.push(GroupError { first: first_row + 1, last: first_row + group.rows, why });
            }
            first_row += group.rows;
        }
        if problems.is_empty() { Ok(()) } else { Err(problems) }
    }

    fn chunk(
        &self,
        number: usize,
        group: &Group,
        place: usize,
        first_row: usize,
        take: &mut dyn FnMut(usize, Cell),
    ) -> Result<(), ChunkError> {
        let gone = || ChunkError::Missing;
        let leaf = self.footer.leaves.get(place).ok_or_else(gone)?;
        let chunk =
            group.chunks.get(place).ok_or_else(gone)?.as_ref().map_err(|why| ChunkError::Damaged(why))?;
        let bytes = self.file.get(chunk.start..chunk.start + chunk.length).ok_or_else(gone)?;
        pages::check(bytes, leaf, chunk)?;
        // The crate must own the bytes it reads: they are copied, a column of one group at a time.
        let source = Source { start: chunk.start as u64, bytes: Bytes::copy_from_slice(bytes) };
        let read = contained(|| -> ParquetResult<usize> {
            let column = self.metadata.row_group(number).column(place);
            let pages = SerializedPageReader::new(Arc::new(source), column, group.rows, None)?;
            let reader = get_column_reader(column.column_descr_ptr(), Box::new(pages));
            read(reader, leaf, column.column_descr().max_def_level(), group.rows, &mut |row, cell| {
                take(first_row + row, cell);
            })
        });
        match read {
            Ok(Ok(rows)) if rows == group.rows => Ok(()),
            Ok(Ok(rows)) => Err(ChunkError::Short { rows }),
            Ok(Err(error)) => Err(error.into()),
            Err(panicked) => Err(panicked.into()),
        }
    }
}

/// The bytes of one column, at their place in the file.
struct Source {
    start: u64,
    bytes: Bytes,
}

impl Source {
    fn from(&self, start: u64) -> Bytes {
        let at = start.checked_sub(self.start).and_then(|at| usize::try_from(at).ok());
        self.bytes.slice(at.unwrap_or(usize::MAX).min(self.bytes.len())..)
    }
}

impl Length for Source {
    fn len(&self) -> u64 {
        self.start + self.bytes.len() as u64
    }
}

impl ChunkReader for Source {
    type T = bytes::buf::Reader<Bytes>;

    fn get_read(&self, start: u64) -> ParquetResult<Self::T> {
        Ok(bytes::Buf::reader(self.from(start)))
    }

    fn get_bytes(&self, start: u64, length: usize) -> ParquetResult<Bytes> {
        let bytes = self.from(start);
        if length > bytes.len() {
            return Err(parquet::errors::ParquetError::EOF("a page is longer than its column".to_owned()));
        }
        Ok(bytes.slice(..length))
    }
}

/// Decodes a column of one group and returns how many rows it had.
fn read(
    reader: ColumnReader,
    leaf: &Leaf,
    full: i16,
    rows: usize,
    take: &mut dyn FnMut(usize, Cell),
) -> ParquetResult<usize> {
    let kind = leaf.kind;
    match reader {
        ColumnReader::BoolColumnReader(reader) => {
            drain(reader, full, rows, take, |value| Cell::Number(f64::from(u8::from(*value))))
        }
        ColumnReader::Int32ColumnReader(reader) => drain(reader, full, rows, take, |value| match kind {
            Kind::Unsigned => Cell::Number(f64::from(value.cast_unsigned())),
            _ => whole(kind, i64::from(*value)),
        }),
        ColumnReader::Int64ColumnReader(reader) => drain(reader, full, rows, take, |value| match kind {
            Kind::Unsigned => Cell::Number(value.cast_unsigned() as f64),
            _ => whole(kind, *value),
        }),
        ColumnReader::Int96ColumnReader(reader) => drain(reader, full, rows, take, |value| {
            let nanos = value.data().iter().zip([0, 32]).map(|(part, shift)| u64::from(*part) << shift);
            let day = value.data().get(2).map_or(0, |day| i64::from(*day)) - 2_440_588;
            Cell::Date(day as f64 * DAY_S + nanos.sum::<u64>() as f64 * 1e-9)
        }),
        ColumnReader::FloatColumnReader(reader) => {
            drain(reader, full, rows, take, |value| Cell::Number(f64::from(*value)))
        }
        ColumnReader::DoubleColumnReader(reader) => {
            drain(reader, full, rows, take, |value| Cell::Number(*value))
        }
        ColumnReader::ByteArrayColumnReader(reader) => {
            drain(reader, full, rows, take, |value| bytes_cell(kind, value.as_bytes()))
        }
        ColumnReader::FixedLenByteArrayColumnReader(reader) => {
            drain(reader, full, rows, take, |value| bytes_cell(kind, value.as_bytes()))
        }
    }
}

/// Converts a whole number to the cell it represents.
fn whole(kind: Kind, value: i64) -> Cell {
    match kind {
        Kind::Date => Cell::Date(value as f64 * DAY_S),
        Kind::Clock(unit_s) => Cell::Clock(value as f64 * unit_s),
        Kind::Stamp(unit_s) => Cell::Date(value as f64 * unit_s),
        Kind::Decimal(unit) => Cell::Number(value as f64 * unit),
        Kind::Plain | Kind::Unsigned | Kind::Half => Cell::Number(value as f64),
    }
}

/// Converts bytes to the cell they represent: a number written in them, or a text.
fn bytes_cell(kind: Kind, bytes: &[u8]) -> Cell {
    match (kind, bytes) {
        (Kind::Half, [low, high]) => Cell::Number(half::f16::from_le_bytes([*low, *high]).to_f64()),
        (Kind::Decimal(unit), [first, ..]) if bytes.len() <= 16 => {
            let sign = if first.cast_signed() < 0 { -1_i128 } else { 0 };
            let value = bytes.iter().fold(sign, |value, byte| (value << 8) | i128::from(*byte));
            Cell::Number(value as f64 * unit)
        }
        _ => cell(bytes.trim_ascii(), false),
    }
}

fn drain<T: DataType>(
    mut reader: ColumnReaderImpl<T>,
    full: i16,
    rows: usize,
    take: &mut dyn FnMut(usize, Cell),
    as_cell: impl Fn(&T::T) -> Cell,
) -> ParquetResult<usize> {
    let (mut levels, mut values) = (Vec::new(), Vec::new());
    let mut row = 0;
    while row < rows {
        levels.clear();
        values.clear();
        let (read, ..) = reader.read_records(BATCH.min(rows - row), Some(&mut levels), None, &mut values)?;
        if read == 0 {
            break;
        }
        // Without optional parts, every row has a value and no levels are written.
        let is_there = |place: usize| full == 0 || levels.get(place).is_some_and(|level| *level == full);
        let mut next = values.iter();
        for place in 0..read {
            if is_there(place)
                && let Some(value) = next.next()
            {
                take(row + place, as_cell(value));
            }
        }
        row += read;
    }
    Ok(row)
}
