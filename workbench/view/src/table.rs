//! What a table shows, described once. `text` draws it for a terminal, `page` as HTML.

/// At which edge of their column texts stand.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Align {
    /// Words.
    #[default]
    Left,
    /// Numbers.
    Right,
}

/// Whether a cell is good news.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Tone {
    /// Neither.
    #[default]
    Neutral,
    /// Good news.
    Good,
    /// Doubt.
    Doubt,
    /// Bad news.
    Bad,
}

/// A column.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Column {
    /// Its heading.
    pub name: String,
    /// The edge at which its heading and its cells stand.
    pub align: Align,
}

/// What stands where a row crosses a column.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Cell {
    /// One line.
    pub text: String,
    /// Whether it is good news.
    pub tone: Tone,
    /// An explanation, for which only a page has room.
    pub note: String,
}

impl Cell {
    /// With a tone.
    #[must_use]
    pub fn toned(text: impl Into<String>, tone: Tone) -> Self {
        Self { tone, ..Self::from(text.into()) }
    }

    /// With an explanation.
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
    /// A cell a column, from the first on; the first one says what the row is of. Columns without a cell stay
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
    /// Without columns or rows.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// With a column of words.
    #[must_use]
    pub fn left(self, name: impl Into<String>) -> Self {
        self.column(name, Align::Left)
    }

    /// With a column of numbers.
    #[must_use]
    pub fn right(self, name: impl Into<String>) -> Self {
        self.column(name, Align::Right)
    }

    fn column(mut self, name: impl Into<String>, align: Align) -> Self {
        self.columns.push(Column { name: name.into(), align });
        self
    }

    /// Appends a title of the rows that follow.
    pub fn section(&mut self, title: impl Into<String>) {
        self.rows.push(Row::Section(title.into()));
    }

    /// Appends a row.
    pub fn row<C: Into<Cell>>(&mut self, cells: impl IntoIterator<Item = C>) {
        self.rows.push(Row::Cells(cells.into_iter().map(Into::into).collect()));
    }
}
