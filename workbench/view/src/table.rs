//! Describes a table. `text` draws it for a terminal, `page` as HTML.

/// Edge of the column at which its texts are aligned.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Align {
    /// For words.
    #[default]
    Left,
    /// For numbers.
    Right,
}

/// Whether a cell's content is good or bad.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Tone {
    /// Neither.
    #[default]
    Neutral,
    /// Good news.
    Good,
    /// Doubtful.
    Doubt,
    /// Bad news.
    Bad,
}

/// A column.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Column {
    /// Its heading.
    pub name: String,
    /// Alignment of its heading and its cells.
    pub align: Align,
}

/// The content of one cell.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Cell {
    /// One line.
    pub text: String,
    /// Whether its content is good or bad.
    pub tone: Tone,
    /// An explanation, which only a page has room for.
    pub note: String,
}

impl Cell {
    /// Adds a tone.
    #[must_use]
    pub fn toned(text: impl Into<String>, tone: Tone) -> Self {
        Self { tone, ..Self::from(text.into()) }
    }

    /// Adds an explanation.
    #[must_use]
    pub fn explained(text: impl Into<String>, note: impl Into<String>) -> Self {
        Self { note: note.into(), ..Self::from(text.into()) }
    }
}

impl From<String> for Cell {
    fn from(text: String) -> Self {
        Self { text, ..Self::default() }
    }
}

impl From<&str> for Cell {
    fn from(text: &str) -> Self {
        Self::from(text.to_owned())
    }
}

/// A row.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Row {
    /// A title of the rows below it, in the first column.
    Section(String),
    /// One cell for each column, from the first on; the first one names the row. Columns without a cell stay
    /// empty; cells beyond the last column are not drawn.
    Cells(Vec<Cell>),
}

/// A table.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Table {
    /// From left to right.
    pub columns: Vec<Column>,
    /// From top to bottom.
    pub rows: Vec<Row>,
}

impl Table {
    /// An empty table.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a column of words.
    #[must_use]
    pub fn left(self, name: impl Into<String>) -> Self {
        self.column(name, Align::Left)
    }

    /// Adds a column of numbers.
    #[must_use]
    pub fn right(self, name: impl Into<String>) -> Self {
        self.column(name, Align::Right)
    }

    fn column(mut self, name: impl Into<String>, align: Align) -> Self {
        self.columns.push(Column { name: name.into(), align });
        self
    }

    /// Appends a title for the rows that follow.
    pub fn section(&mut self, title: impl Into<String>) {
        self.rows.push(Row::Section(title.into()));
    }

    /// Appends a row.
    pub fn row<C: Into<Cell>>(&mut self, cells: impl IntoIterator<Item = C>) {
        self.rows.push(Row::Cells(cells.into_iter().map(Into::into).collect()));
    }
}
