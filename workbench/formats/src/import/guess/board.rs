//! What is known so far about a table whose columns are being guessed.

use super::names::{Hint, Role};
use crate::import::mapping::LoggedTable;
use crate::import::mapping::quantity::Quantity;

/// One guess: this column may be that signal.
#[derive(Clone, Debug, PartialEq)]
pub struct Guess {
    /// The signal.
    pub destination: String,
    /// Index of the column, from 0.
    pub column: usize,
    /// The column's unit.
    pub unit: Option<&'static str>,
    /// Factor applied before the unit.
    pub scale: Option<f64>,
    /// Offset added before the unit.
    pub offset: Option<f64>,
    /// Whether each sample is repeated until the next one.
    pub held: bool,
    /// Whether it is more than a suspicion.
    pub is_sure: bool,
    /// The reason, as text.
    pub evidence: String,
}

/// The time base that was guessed.
#[derive(Clone, Debug, PartialEq)]
pub struct TimeGuess {
    /// The column; none where rows are only counted.
    pub column: usize,
    /// Its unit, if it holds numbers.
    pub unit: Option<&'static str>,
    /// Whether it is more than a suspicion.
    pub is_sure: bool,
    /// The reason, as text.
    pub evidence: String,
}

/// What is known so far about the table.
pub struct Board<'a> {
    /// The table.
    pub table: &'a LoggedTable,
    /// The meaning of the names.
    pub hints: Vec<Hint>,
    /// Time of each row, seconds; not available before the time base is.
    pub time_s: Vec<f64>,
    /// The time base.
    pub time: Option<TimeGuess>,
    /// The guesses.
    pub guesses: Vec<Guess>,
    /// Columns that were understood but are not used, with the reason.
    pub set_aside: Vec<(usize, String)>,
    /// Whether the altitudes are measured from the ellipsoid instead of mean sea level.
    pub is_above_ellipsoid: bool,
}

impl<'a> Board<'a> {
    /// For a table of which only the names are known.
    pub fn new(table: &'a LoggedTable) -> Self {
        let hints = table.names.iter().zip(&table.units).map(|(name, unit)| Hint::new(name, unit)).collect();
        Self {
            table,
            hints,
            time_s: Vec::new(),
            time: None,
            guesses: Vec::new(),
            set_aside: Vec::new(),
            is_above_ellipsoid: false,
        }
    }

    /// A column's name, in quotes.
    pub fn quoted(&self, column: usize) -> String {
        format!("'{}'", self.table.name(column))
    }

    /// The meaning of a column's name.
    pub fn hint(&self, column: usize) -> Hint {
        self.hints.get(column).cloned().unwrap_or_default()
    }

    /// A column's possible role by its name.
    pub fn role(&self, column: usize) -> Option<Role> {
        self.hints.get(column).and_then(|hint| hint.role)
    }

    /// Columns of numbers that are not yet assigned.
    pub fn free(&self) -> Vec<usize> {
        (0..self.table.columns.len())
            .filter(|column| self.is_free(*column) && self.is_numeric(*column))
            .collect()
    }

    /// Those whose name indicates that role.
    pub fn named(&self, role: Role) -> Vec<usize> {
        self.free().into_iter().filter(|column| self.role(*column) == Some(role)).collect()
    }

    /// Whether a column is not yet assigned.
    pub fn is_free(&self, column: usize) -> bool {
        self.time.as_ref().is_none_or(|time| time.column != column)
            && !self.guesses.iter().any(|guess| guess.column == column)
            && !self.set_aside.iter().any(|(aside, _)| *aside == column)
    }

    fn is_numeric(&self, column: usize) -> bool {
        let cells = self.table.columns.get(column);
        cells.is_some_and(|cells| cells.numbers > cells.words + cells.clocks + cells.dates)
    }

    /// A column's numbers.
    pub fn numbers(&self, column: usize) -> Vec<f64> {
        self.table.values(column).iter().copied().filter(|value| value.is_finite()).collect()
    }

    /// A column's numbers with their times, seconds, in forward time order.
    pub fn samples(&self, column: usize) -> Vec<(f64, f64)> {
        let mut latest_s = f64::NEG_INFINITY;
        let timed = self.time_s.iter().copied().zip(self.table.values(column).iter().copied());
        timed
            .filter(|(time_s, value)| {
                let is_good = value.is_finite() && *time_s > latest_s;
                if is_good {
                    latest_s = *time_s;
                }
                is_good
            })
            .collect()
    }

    /// As [`Self::samples`], without values that only repeat the sample before.
    pub fn fresh(&self, column: usize) -> Vec<(f64, f64)> {
        let mut samples = self.samples(column);
        samples.dedup_by(|later, earlier| later.1 == earlier.1);
        samples
    }

    /// Whether all values of a column are the same, or there are none.
    pub fn is_constant(&self, column: usize) -> bool {
        let mut values = self.table.values(column).iter().filter(|value| value.is_finite());
        let first = values.next();
        values.all(|value| Some(value) == first)
    }

    /// The guess for a signal.
    pub fn guess(&self, destination: &str) -> Option<&Guess> {
        self.guesses.iter().find(|guess| guess.destination == destination)
    }

    /// The samples of a signal's guess, in the signal's own unit; empty without a guess.
    pub fn converted(&self, destination: &str) -> Vec<(f64, f64)> {
        let Some(guess) = self.guess(destination) else { return Vec::new() };
        let unit = Quantity::of(destination).zip(guess.unit).and_then(|(quantity, unit)| quantity.unit(unit));
        let (factor, more) = unit.map_or((1.0, 0.0), |unit| (unit.factor, unit.offset));
        let (scale, offset) = (guess.scale.unwrap_or(1.0), guess.offset.unwrap_or(0.0));
        let mut samples = self.fresh(guess.column);
        samples.iter_mut().for_each(|(_, value)| *value = (*value * scale + offset) * factor + more);
        samples
    }

    /// Adds a guess, unless its column or its signal already has one that is as good.
    pub fn add(&mut self, guess: Guess) {
        let taken = self.guesses.iter().any(|other| {
            other.column == guess.column
                || (other.destination == guess.destination && (other.is_sure || !guess.is_sure))
        });
        if !taken && self.is_free(guess.column) {
            self.guesses.push(guess);
        }
    }

    /// Adds a guess without scale and offset.
    pub fn add_plain(
        &mut self,
        destination: &str,
        column: usize,
        unit: Option<&'static str>,
        is_sure: bool,
        evidence: String,
    ) {
        let destination = destination.to_owned();
        self.add(Guess {
            destination,
            column,
            unit,
            scale: None,
            offset: None,
            held: false,
            is_sure,
            evidence,
        });
    }

    /// Records why a column is not used.
    pub fn set_aside(&mut self, column: usize, why: impl Into<String>) {
        if self.is_free(column) {
            self.set_aside.push((column, why.into()));
        }
    }
}
