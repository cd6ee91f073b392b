//! One channel's cells.

/// Bit pattern of an empty cell: a NaN that no arithmetic and no parser makes.
const EMPTY: u32 = 0x7fc0_dead;

/// Cells of one channel, one a row; an empty cell means "no new sample at that time", which is not
/// the same as a sample that is NaN.
#[derive(Clone, Debug, Default)]
pub struct Column(Vec<f32>);

impl Column {
    /// A column of `rows` empty cells.
    #[must_use]
    pub fn empty(rows: usize) -> Self {
        Self(vec![f32::from_bits(EMPTY); rows])
    }

    /// A column without cells, with room for `rows` of them.
    #[must_use]
    pub fn with_capacity(rows: usize) -> Self {
        Self(Vec::with_capacity(rows))
    }

    /// A column of cells as [`Self::cell`] makes them.
    pub(super) const fn from_cells(cells: Vec<f32>) -> Self {
        Self(cells)
    }

    /// What a column holds for a cell.
    #[inline]
    pub(super) fn cell(cell: Option<f32>) -> f32 {
        cell.unwrap_or(f32::from_bits(EMPTY))
    }

    /// Appends a cell.
    #[inline]
    pub fn push(&mut self, cell: Option<f32>) {
        self.0.push(Self::cell(cell));
    }

    /// Puts a cell before that of a row, or at the end where there is no such row yet.
    pub fn insert(&mut self, row: usize, cell: Option<f32>) {
        self.0.insert(row.min(self.0.len()), Self::cell(cell));
    }

    /// Appends empty cells until there are `rows` of them.
    pub fn fill_up(&mut self, rows: usize) {
        self.0.resize(rows.max(self.0.len()), f32::from_bits(EMPTY));
    }

    /// Sets the cell of a row that exists; says whether it does.
    pub fn set(&mut self, row: usize, cell: Option<f32>) -> bool {
        self.0.get_mut(row).map(|slot| *slot = Self::cell(cell)).is_some()
    }

    /// The cell of a row: `None` when it is empty or there is no such row.
    #[must_use]
    #[inline]
    pub fn get(&self, row: usize) -> Option<f32> {
        self.0.get(row).copied().filter(|value| value.to_bits() != EMPTY)
    }

    /// Number of cells.
    #[must_use]
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Whether there is no cell at all.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Every sample with its row.
    pub fn samples(&self) -> impl Iterator<Item = (usize, f32)> + '_ {
        self.0.iter().copied().enumerate().filter(|(_, value)| value.to_bits() != EMPTY)
    }
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
}
