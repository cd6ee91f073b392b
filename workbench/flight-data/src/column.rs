//! One channel's cells.

/// Bit pattern of an empty cell: a NaN that arithmetic and parsers do not produce.
const EMPTY: u32 = 0x7fc0_dead;
/// The same for a cell in double precision.
const EMPTY_DOUBLE: u64 = 0x7ff8_0000_0000_dead;

/// Cells of one channel, one a row; an empty cell means "no new sample at that time", which is not
/// the same as a sample that is NaN.
///
/// Cells are in single precision, as in the estimator; positions are in double precision, because f32 would
/// round a degree to a metre.
#[derive(Clone, Debug)]
pub struct Column(Cells);

#[derive(Clone, Debug)]
enum Cells {
    Single(Vec<f32>),
    Double(Vec<f64>),
}

impl Default for Column {
    fn default() -> Self {
        Self(Cells::Single(Vec::new()))
    }
}

impl Column {
    /// A column of `rows` empty cells.
    #[must_use]
    pub fn empty(rows: usize) -> Self {
        Self(Cells::Single(vec![f32::from_bits(EMPTY); rows]))
    }

    /// A column of `rows` empty cells in double precision.
    #[must_use]
    pub fn empty_double(rows: usize) -> Self {
        Self(Cells::Double(vec![f64::from_bits(EMPTY_DOUBLE); rows]))
    }

    /// A column of `rows` empty cells, with the precision for a column of that name: see
    /// [`Self::is_double_named`].
    #[must_use]
    pub fn empty_named(name: &str, rows: usize) -> Self {
        if Self::is_double_named(name) { Self::empty_double(rows) } else { Self::empty(rows) }
    }

    /// Whether a column of that name has double precision: positions, whose names end with `latitude_deg` or
    /// `longitude_deg`.
    #[must_use]
    pub fn is_double_named(name: &str) -> bool {
        name.ends_with("latitude_deg") || name.ends_with("longitude_deg")
    }

    /// A column without cells, with room for `rows` of them.
    #[must_use]
    pub fn with_capacity(rows: usize) -> Self {
        Self(Cells::Single(Vec::with_capacity(rows)))
    }

    /// A column without cells in double precision, with room for `rows` of them.
    #[must_use]
    pub fn double_with_capacity(rows: usize) -> Self {
        Self(Cells::Double(Vec::with_capacity(rows)))
    }

    /// A column of cells made by [`Self::cell`].
    pub(super) const fn from_cells(cells: Vec<f32>) -> Self {
        Self(Cells::Single(cells))
    }

    /// A column of cells made by [`Self::double_cell`].
    pub(super) const fn from_double_cells(cells: Vec<f64>) -> Self {
        Self(Cells::Double(cells))
    }

    /// The stored form of a cell.
    #[inline]
    pub(super) fn cell(cell: Option<f32>) -> f32 {
        cell.unwrap_or(f32::from_bits(EMPTY))
    }

    /// The stored form of a cell in double precision.
    #[inline]
    pub(super) fn double_cell(cell: Option<f64>) -> f64 {
        cell.unwrap_or(f64::from_bits(EMPTY_DOUBLE))
    }

    /// Whether the cells have double precision.
    #[must_use]
    pub const fn is_double(&self) -> bool {
        matches!(self.0, Cells::Double(_))
    }

    /// Cells in single and in double precision; one of the two is empty.
    fn parts(&self) -> (&[f32], &[f64]) {
        match &self.0 {
            Cells::Single(cells) => (cells, &[]),
            Cells::Double(cells) => (&[], cells),
        }
    }

    /// Appends a cell.
    #[inline]
    pub fn push(&mut self, cell: Option<f32>) {
        match &mut self.0 {
            Cells::Single(cells) => cells.push(Self::cell(cell)),
            Cells::Double(cells) => cells.push(Self::double_cell(cell.map(f64::from))),
        }
    }

    /// Appends a cell in the column's precision.
    #[inline]
    pub fn push_f64(&mut self, cell: Option<f64>) {
        match &mut self.0 {
            Cells::Single(cells) => cells.push(Self::cell(cell.map(|value| value as f32))),
            Cells::Double(cells) => cells.push(Self::double_cell(cell)),
        }
    }

    /// Inserts a cell before that of a row, or at the end if there is no such row yet.
    pub fn insert(&mut self, row: usize, cell: Option<f32>) {
        match &mut self.0 {
            Cells::Single(cells) => cells.insert(row.min(cells.len()), Self::cell(cell)),
            Cells::Double(cells) => {
                cells.insert(row.min(cells.len()), Self::double_cell(cell.map(f64::from)));
            }
        }
    }

    /// Appends empty cells until there are `rows` of them.
    pub fn fill_up(&mut self, rows: usize) {
        match &mut self.0 {
            Cells::Single(cells) => cells.resize(rows.max(cells.len()), f32::from_bits(EMPTY)),
            Cells::Double(cells) => cells.resize(rows.max(cells.len()), f64::from_bits(EMPTY_DOUBLE)),
        }
    }

    /// Sets the cell of a row; returns false if there is no such row.
    #[inline]
    pub fn set(&mut self, row: usize, cell: Option<f32>) -> bool {
        match &mut self.0 {
            Cells::Single(cells) => cells.get_mut(row).map(|slot| *slot = Self::cell(cell)),
            Cells::Double(cells) => {
                cells.get_mut(row).map(|slot| *slot = Self::double_cell(cell.map(f64::from)))
            }
        }
        .is_some()
    }

    /// As [`Self::set`], in the column's precision.
    #[inline]
    pub fn set_f64(&mut self, row: usize, cell: Option<f64>) -> bool {
        match &mut self.0 {
            Cells::Single(cells) => {
                cells.get_mut(row).map(|slot| *slot = Self::cell(cell.map(|value| value as f32)))
            }
            Cells::Double(cells) => cells.get_mut(row).map(|slot| *slot = Self::double_cell(cell)),
        }
        .is_some()
    }

    /// The cell of a row: `None` when it is empty or there is no such row.
    #[must_use]
    #[inline]
    pub fn get(&self, row: usize) -> Option<f32> {
        match &self.0 {
            Cells::Single(cells) => cells.get(row).copied().filter(|value| value.to_bits() != EMPTY),
            Cells::Double(cells) => {
                let cell = cells.get(row).copied().filter(|value| value.to_bits() != EMPTY_DOUBLE);
                cell.map(|value| value as f32)
            }
        }
    }

    /// As [`Self::get`], in the column's precision.
    #[must_use]
    #[inline]
    pub fn get_f64(&self, row: usize) -> Option<f64> {
        match &self.0 {
            Cells::Single(_) => self.get(row).map(f64::from),
            Cells::Double(cells) => cells.get(row).copied().filter(|value| value.to_bits() != EMPTY_DOUBLE),
        }
    }

    /// Number of cells.
    #[must_use]
    pub fn len(&self) -> usize {
        let (single, double) = self.parts();
        single.len() + double.len()
    }

    /// Whether there is no cell at all.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Every sample with its row.
    pub fn samples(&self) -> impl Iterator<Item = (usize, f32)> + '_ {
        let (single, double) = self.parts();
        let single = single.iter().copied().enumerate().filter(|(_, value)| value.to_bits() != EMPTY);
        single.chain(double_samples(double).map(|(row, value)| (row, value as f32)))
    }

    /// As [`Self::samples`], in the column's precision.
    pub fn samples_f64(&self) -> impl Iterator<Item = (usize, f64)> + '_ {
        let (single, double) = self.parts();
        let single = single.iter().copied().enumerate().filter(|(_, value)| value.to_bits() != EMPTY);
        single.map(|(row, value)| (row, f64::from(value))).chain(double_samples(double))
    }

    /// The cells of some rows, as a column of the same precision; an empty cell for a row that does not
    /// exist.
    #[must_use]
    pub fn picked(&self, rows: impl IntoIterator<Item = usize>) -> Self {
        let rows = rows.into_iter();
        let mut found = match &self.0 {
            Cells::Single(_) => Self::with_capacity(rows.size_hint().0),
            Cells::Double(_) => Self::double_with_capacity(rows.size_hint().0),
        };
        rows.for_each(|row| found.push_f64(self.get_f64(row)));
        found
    }

    /// Sets bit `bit` in the mark of each of these rows that has a sample.
    pub(super) fn mark_samples(&self, rows: std::ops::Range<usize>, bit: u32, marks: &mut [u64]) {
        match &self.0 {
            Cells::Single(cells) => {
                for (mark, cell) in marks.iter_mut().zip(cells.get(rows).unwrap_or_default()) {
                    *mark |= u64::from(cell.to_bits() != EMPTY) << bit;
                }
            }
            Cells::Double(cells) => {
                for (mark, cell) in marks.iter_mut().zip(cells.get(rows).unwrap_or_default()) {
                    *mark |= u64::from(cell.to_bits() != EMPTY_DOUBLE) << bit;
                }
            }
        }
    }
}

fn double_samples(cells: &[f64]) -> impl Iterator<Item = (usize, f64)> + '_ {
    cells.iter().copied().enumerate().filter(|(_, value)| value.to_bits() != EMPTY_DOUBLE)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tells_an_empty_cell_from_a_nan_sample() {
        let mut column = Column::default();
        column.push(None);
        column.push(Some(f32::NAN));
        column.push(Some(1.0));
        assert_eq!(column.get(0), None);
        assert!(column.get(1).is_some_and(f32::is_nan));
        assert_eq!(column.samples().count(), 2);
        assert_eq!(column.get(3), None);
    }

    #[test]
    fn cells_move_up_for_one_that_is_put_before_them() {
        let mut column = Column::default();
        column.fill_up(2);
        column.insert(1, Some(1.0));
        column.insert(9, Some(2.0));
        column.fill_up(1);
        assert_eq!(
            (0..5).map(|row| column.get(row)).collect::<Vec<_>>(),
            [None, Some(1.0), None, Some(2.0), None]
        );
        assert_eq!(column.len(), 4);
    }

    /// 1e-7 degree of a position is a centimetre; f32 has steps of up to 15 µdeg there.
    #[test]
    fn a_column_in_double_precision_keeps_every_digit_and_what_is_empty() {
        let mut column = Column::empty_named("gps_2_longitude_deg", 2);
        assert!(column.is_double() && !Column::empty_named("gps_alt_m", 1).is_double());
        column.set_f64(1, Some(-179.123_456_7));
        column.push_f64(Some(f64::NAN));
        column.push(Some(0.5));
        column.push(None);
        assert_eq!(column.get_f64(1), Some(-179.123_456_7));
        assert_eq!(column.get(1), Some(-179.123_456_7_f64 as f32));
        assert!(column.get_f64(2).is_some_and(f64::is_nan));
        assert_eq!((column.get_f64(0), column.get(4), column.len()), (None, None, 5));
        let rows: Vec<usize> = column.samples_f64().map(|(row, _)| row).collect();
        assert_eq!(rows, [1, 2, 3]);
        let picked = column.picked([1, 0, 3, 9]);
        let cells: Vec<_> = (0..4).map(|row| picked.get_f64(row)).collect();
        assert_eq!(cells, [Some(-179.123_456_7), None, Some(0.5), None]);
    }
}
