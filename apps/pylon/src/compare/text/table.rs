//! The comparison's tables: quantities in the first column, then one column per sensor.

use view::{Cell, Table};

/// A table without rows; `corner` is the heading above the labels.
pub(super) fn by_sensor(corner: &str, names: &[&str]) -> Table {
    names.iter().fold(Table::new().left(corner), |table, name| table.right(*name))
}

/// Appends a row, its label indented below the heading or the section's title.
pub(super) fn row<C: Into<Cell>>(table: &mut Table, label: &str, cells: impl Iterator<Item = C>) {
    table.row(std::iter::once(Cell::from(format!("  {label}"))).chain(cells.map(Into::into)));
}
