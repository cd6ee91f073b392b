//! Which candidates could stand in an explanation's place.

use super::information::Information;
use super::problem::Problem;
use super::search::{Explanation, ROUGH_SHAPE, Search};
use super::series::BySensor;

/// A candidate stands in for another where it explains all but this share of what the other explains
/// (squares). Regressors are made of measured signals, aligned to some hundredths of a second, by formulas that leave
/// terms out: their shape is known to some 15 to 20 %, and no statistics make it better.
const SHAPE: f64 = 0.03;
/// Twice the log likelihood by which it must be worse to be excluded: odds of 150 to 1.
const CLEARLY_WORSE: f64 = 10.0;

/// The candidates that could act in place of one that was chosen.
#[derive(Clone, Debug, PartialEq)]
pub struct Rivals {
    /// The chosen column.
    pub column: usize,
    /// Columns of other effects that explain as much, the best first.
    pub others: Vec<usize>,
    /// Squares that the chosen column explains and the others chosen do not.
    pub explained: f64,
}

/// Finds the rivals of every chosen column.
pub fn rivals(search: &mut Search<'_>, problem: &Problem<'_>, chosen: &Explanation) -> Vec<Rivals> {
    let information = search.information(&chosen.fit);
    let weights = problem.weight_of_white(&chosen.fit.noise);
    let at = search.positions(&chosen.columns);
    let Some(best) = information.solve(&at) else { return Vec::new() };
    let mut all = Vec::new();
    for column in &chosen.columns {
        let without: Vec<usize> = chosen.columns.iter().copied().filter(|other| other != column).collect();
        let kept = search.positions(&without);
        let explained = information.solve(&kept).map_or(0.0, |solution| solution.rest - best.rest);
        let mut found: Vec<(f64, usize)> = Vec::new();
        for other in search.usable().to_vec() {
            let is_chosen = chosen.columns.iter().any(|column| search.same_effect(*column, other));
            if is_chosen {
                continue;
            }
            if let Some(worse) =
                is_rival(search, chosen, &information, &weights, &without, other, best.rest, explained)
            {
                found.push((worse, other));
            }
        }
        add_pairs(search, &information, &chosen.columns, &without, best.rest, &mut found);
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut others: Vec<usize> = Vec::new();
        for (_, other) in found {
            if !others.iter().any(|seen| search.same_effect(*seen, other)) {
                others.push(other);
            }
        }
        all.push(Rivals { column: *column, others, explained });
    }
    all
}

/// How much worse a candidate explains what a chosen one does, if it is not clearly worse.
#[expect(clippy::too_many_arguments, reason = "one question about one candidate")]
fn is_rival(
    search: &mut Search<'_>,
    chosen: &Explanation,
    information: &Information,
    weights: &BySensor,
    without: &[usize],
    other: usize,
    best_rest: f64,
    explained: f64,
) -> Option<f64> {
    let mut set = without.to_vec();
    set.push(other);
    set.sort_unstable();
    let solution = information.solve(&search.positions(&set))?;
    if !search.is_possible(&set, &solution.coefficients) {
        return None;
    }
    let worse = search.rest_but_noise(information, weights, &set)? - best_rest;
    let shape = if search.is_rough(other) { ROUGH_SHAPE } else { SHAPE };
    if worse < shape * explained || worse < CLEARLY_WORSE {
        return Some(worse);
    }
    // Its own noise may suit it better; what that can gain is less than what is missing by far if
    // it explains next to nothing.
    if worse > 0.7 * explained && worse > 10.0 * CLEARLY_WORSE {
        return None;
    }
    let fit = search.fit(&set, &chosen.fit.values);
    let behind = chosen.fit.twice_log_posterior - fit.twice_log_posterior;
    (behind < CLEARLY_WORSE).then_some(worse)
}

/// Two candidates that together fit better than the chosen one does are no worse an explanation for
/// being two, unless the chosen one is there too.
fn add_pairs(
    search: &Search<'_>,
    information: &Information,
    chosen: &[usize],
    without: &[usize],
    best_rest: f64,
    found: &mut Vec<(f64, usize)>,
) {
    let usable: Vec<usize> = search
        .usable()
        .iter()
        .copied()
        .filter(|other| !chosen.iter().any(|column| search.same_effect(*column, *other)))
        .collect();
    for (k, a) in usable.iter().enumerate() {
        for b in &usable[k + 1..] {
            if search.same_effect(*a, *b) {
                continue;
            }
            let set: Vec<usize> = without.iter().copied().chain([*a, *b]).collect();
            if let Some(solution) = information.solve(&search.positions(&set))
                && solution.rest < best_rest - CLEARLY_WORSE
                && search.is_possible(&set, &solution.coefficients)
            {
                found.push((0.0, *a));
                found.push((0.0, *b));
            }
        }
    }
}
