//! Tables with one column a sensor.

use comfy_table::{Attribute, Cell, CellAlignment, Color, ContentArrangement, LineStyle, Table, TableStyle};

/// A line below the column names and nothing else.
const STYLE: TableStyle = TableStyle::new().header_separator(LineStyle::new('─', '─', '─', '─'));

/// Whether a cell is good news.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Mood {
    /// Neither.
    Neutral,
    /// Good news.
    Good,
    /// Doubt.
    Doubt,
    /// Bad news.
    Bad,
}

/// A table in the making.
#[derive(Debug)]
pub(super) struct Sheet {
    table: Table,
    columns: usize,
}

impl Sheet {
    /// A table whose first column is named `corner` and holds the rows' labels.
    pub(super) fn new(corner: &str, heads: &[&str]) -> Self {
        let mut table = Table::new();
        table.load_style(STYLE).set_content_arrangement(ContentArrangement::Disabled);
        let mut header = vec![Cell::new(corner).add_attribute(Attribute::Bold)];
        header.extend(heads.iter().map(|head| Cell::new(head).set_alignment(CellAlignment::Right)));
        table.set_header(header);
        Self { table, columns: heads.len() }
    }

    /// A row; cells are right-aligned.
    pub(super) fn row(&mut self, label: &str, cells: impl Iterator<Item = (String, Mood)>) {
        let mut row = vec![Cell::new(format!("  {label}"))];
        row.extend(cells.map(|(text, mood)| {
            let cell = Cell::new(text).set_alignment(CellAlignment::Right);
            match mood {
                Mood::Neutral => cell,
                Mood::Good => cell.fg(Color::Green),
                Mood::Doubt => cell.fg(Color::Magenta),
                Mood::Bad => cell.fg(Color::Red),
            }
        }));
        self.table.add_row(row);
    }

    /// A row that titles those below it.
    pub(super) fn section(&mut self, title: &str) {
        let mut row = vec![Cell::new(title).add_attribute(Attribute::Bold)];
        row.extend((0..self.columns).map(|_| Cell::new("")));
        self.table.add_row(row);
    }

    /// The table's lines, without a line break at the end.
    pub(super) fn render(mut self, colour: bool) -> String {
        if colour {
            self.table.enforce_styling();
        } else {
            self.table.force_no_tty();
        }
        let text = self.table.to_string();
        let lines: Vec<&str> = text.lines().map(str::trim_end).collect();
        lines.join("\n")
    }
}
