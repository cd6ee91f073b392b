//! Drafts the mapping of a table whose columns have no known meaning.
//!
//! A guess is based on a column's name, its values and physics: which column is the derivative of which, what
//! follows the standard atmosphere, which vector is one g long. Each guess gives its reason. A guess that
//! rests on one name alone, or that its values contradict, is doubtful and commented out in the draft.
//! Nothing is applied here: the result is a mapping file.

mod board;
mod draft;
mod heights;
mod inertial;
mod names;
mod others;
mod position;
mod relate;
mod time_base;
mod units;

use self::board::Board;
#[cfg(feature = "parquet")]
use super::Importer as _;
use super::mapping::quantity::Quantity;
use super::mapping::{self, Fault, LoggedTable, TableError, changes};

pub use board::{Guess, TimeGuess};
pub use draft::Draft;

/// Mean number of rows over which a sample is repeated, from which on a column counts as held.
const HELD_ROWS: f64 = 1.8;

/// Drafts a mapping of a log from its bytes.
///
/// # Errors
/// [`Fault`] for a log that is not a table of numbers.
pub fn guess_log(log: &[u8]) -> Result<Draft, Fault> {
    // To a table, a flight's own header lines are remarks.
    let no_table = || {
        let known = super::IMPORTERS.iter().find(|importer| importer.recognises(log));
        Fault::from(
            known.map_or(TableError::NoTable, |importer| TableError::Known { format: importer.name() }),
        )
    };
    #[cfg(feature = "parquet")]
    if super::parquet::Parquet.recognises(log) {
        return Err(no_table());
    }
    Ok(guess(&mapping::table(log, |found| found.ok_or_else(no_table))?))
}

/// Drafts a mapping of a table.
#[must_use]
pub fn guess(table: &LoggedTable) -> Draft {
    let mut board = Board::new(table);
    time_base::find(&mut board);
    if board.time.is_some() {
        position::find_position(&mut board);
        position::find_horizontal(&mut board);
        heights::find(&mut board);
        position::find_vertical(&mut board);
        inertial::find(&mut board);
        others::find(&mut board);
        find_held(&mut board);
    }
    Draft::new(board)
}

/// Marks the guesses whose columns repeat a sample until the next one.
fn find_held(board: &mut Board<'_>) {
    let table = board.table;
    let is_of_fix = |name: &str| name.starts_with("gps_") || matches!(name, "latitude_deg" | "longitude_deg");
    let mut rows = vec![false; table.lines.len()];
    let mut filled = 0;
    for guess in board.guesses.iter().filter(|guess| is_of_fix(&guess.destination)) {
        let values = table.values(guess.column);
        filled = filled.max(values.iter().filter(|value| value.is_finite()).count());
        for (slot, is_new) in rows.iter_mut().zip(changes(values)) {
            *slot |= is_new;
        }
    }
    let fixes = rows.iter().filter(|is_new| **is_new).count();
    let is_fix_held = fixes >= 5 && filled as f64 > HELD_ROWS * fixes as f64;
    let apart: Vec<usize> = board
        .guesses
        .iter()
        .map(|guess| guess.column)
        .filter(|column| board.moves_with_fix(*column) == Some(false))
        .collect();
    for guess in &mut board.guesses {
        let values = table.values(guess.column);
        let per_sample = if is_of_fix(&guess.destination) {
            (is_fix_held && !apart.contains(&guess.column)).then(|| filled as f64 / fixes as f64)
        } else if matches!(Quantity::of(&guess.destination), Some(Quantity::Pressure | Quantity::Length)) {
            repeats_evenly(values)
        } else {
            None
        };
        if let Some(per_sample) = per_sample {
            guess.held = true;
            guess.evidence += &format!("; each sample is repeated over {per_sample:.1} rows, and taken once");
        }
    }
}

/// The number of rows over which each value is repeated, if it is about the same each time: a rounded value
/// stays the same for a varying time.
fn repeats_evenly(values: &[f64]) -> Option<f64> {
    let known: Vec<f64> = values.iter().copied().filter(|value| value.is_finite()).collect();
    let places: Vec<usize> =
        changes(&known).enumerate().filter_map(|(place, is_new)| is_new.then_some(place)).collect();
    let mut runs: Vec<usize> = places
        .windows(2)
        .filter_map(|pair| pair.last().zip(pair.first()).map(|(to, from)| to - from))
        .collect();
    runs.sort_unstable();
    let usual = *runs.get(runs.len() / 2)?;
    let even = runs.iter().filter(|run| run.abs_diff(usual) <= 1).count();
    (runs.len() >= 10 && usual >= 2 && even * 10 >= runs.len() * 8).then_some(usual as f64)
}

#[cfg(test)]
mod tests;
