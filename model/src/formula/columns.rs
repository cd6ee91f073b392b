//! Columns of a flight that the estimator does not know.

use kf_core::formula::MAX_COLUMNS;

use super::dimension::Dimension;

/// Units by the end of a column's name: SI unit, factor and offset to it. Longest first.
const SUFFIXES: [(&str, &str, f64, f64); 22] = [
    ("_radps2", "rad/s^2", 1.0, 0.0),
    ("_degps", "rad/s", std::f64::consts::PI / 180.0, 0.0),
    ("_radps", "rad/s", 1.0, 0.0),
    ("_mps2", "m/s^2", 1.0, 0.0),
    ("_kmh", "m/s", 1.0 / 3.6, 0.0),
    ("_mps", "m/s", 1.0, 0.0),
    ("_deg", "rad", std::f64::consts::PI / 180.0, 0.0),
    ("_rad", "rad", 1.0, 0.0),
    ("_hpa", "Pa", 100.0, 0.0),
    ("_kpa", "Pa", 1000.0, 0.0),
    ("_pct", "1", 0.01, 0.0),
    ("_pa", "Pa", 1.0, 0.0),
    ("_hz", "1/s", 1.0, 0.0),
    ("_km", "m", 1000.0, 0.0),
    ("_mm", "m", 1e-3, 0.0),
    ("_ms", "s", 1e-3, 0.0),
    ("_kt", "m/s", 1852.0 / 3600.0, 0.0),
    ("_ft", "m", 0.3048, 0.0),
    ("_m", "m", 1.0, 0.0),
    ("_s", "s", 1.0, 0.0),
    ("_k", "K", 1.0, 0.0),
    ("_c", "K", 1.0, 273.15),
];

/// A column of a flight, by its name, and its conversion to a signal.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    name: String,
    dimension: Dimension,
    scale: f64,
    offset: f64,
    is_declared: bool,
    is_guessed: bool,
}

impl Column {
    /// The column with the unit given by the end of its name; without such an end it is a plain number.
    #[must_use]
    pub fn named(name: &str) -> Self {
        let lower = name.to_ascii_lowercase();
        let found = SUFFIXES.iter().find(|(suffix, ..)| lower.ends_with(suffix));
        let (unit, scale, offset) =
            found.map_or(("1", 1.0, 0.0), |(_, unit, scale, offset)| (*unit, *scale, *offset));
        Self {
            name: name.to_owned(),
            dimension: Dimension::of_unit(unit).unwrap_or(Dimension::ONE),
            scale,
            offset,
            is_declared: false,
            is_guessed: found.is_none(),
        }
    }

    /// The column in this unit, whatever the end of its name.
    #[must_use]
    pub fn declared(name: &str, dimension: Dimension) -> Self {
        let name = name.to_owned();
        Self { name, dimension, scale: 1.0, offset: 0.0, is_declared: true, is_guessed: false }
    }

    /// Its name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Its dimension as a signal.
    #[must_use]
    pub const fn dimension(&self) -> Dimension {
        self.dimension
    }

    /// Whether neither the end of its name nor the model gives its unit, so that it counts as a plain number.
    #[must_use]
    pub const fn is_guessed(&self) -> bool {
        self.is_guessed
    }

    /// A cell of the column in SI units.
    #[must_use]
    pub fn si(&self, cell: f32) -> f32 {
        (f64::from(cell) * self.scale + self.offset) as f32
    }

    /// Its unit and where that comes from.
    #[must_use]
    pub fn unit_said(&self) -> String {
        match (self.is_declared, self.is_guessed) {
            (true, _) => format!("{} is in {}, as the model says", self.name, self.dimension),
            (_, true) => {
                format!(
                    "{} counts as a plain number: neither its name nor the model says its unit",
                    self.name
                )
            }
            _ => format!("{} is in {}, by the end of its name", self.name, self.dimension),
        }
    }
}

/// The columns of a model's formulas that the estimator does not know, by number.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Columns(Vec<Column>);

impl Columns {
    /// The columns in the order of their numbers.
    pub fn iter(&self) -> impl Iterator<Item = &Column> {
        self.0.iter()
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Adds a column whose unit the model gives. False if it is already there in another unit, or if there is
    /// no room.
    pub fn declare(&mut self, name: &str, dimension: Dimension) -> bool {
        match self.0.iter().find(|column| column.name == name) {
            Some(there) => there.dimension == dimension && there.is_declared,
            None if self.0.len() < MAX_COLUMNS => {
                self.0.push(Column::declared(name, dimension));
                true
            }
            None => false,
        }
    }

    /// The number and dimension of a column, which is added if it is new; `None` if there is no room.
    pub(super) fn number(&mut self, name: &str) -> Option<(u8, Dimension)> {
        let at = match self.0.iter().position(|column| column.name == name) {
            Some(at) => at,
            None if self.0.len() < MAX_COLUMNS => {
                self.0.push(Column::named(name));
                self.0.len() - 1
            }
            None => return None,
        };
        Some((at as u8, self.0.get(at)?.dimension))
    }
}
