//! Whether fewer effects explain as much.

use kf_core::sensor::Sensor;

use super::problem::Problem;
use super::search::{BEAM, Explanation, extended};
use super::suspects::Suspects;

/// The share (squares) of what a set explains that a smaller one may leave. Measured signals, their
/// delays and the terms that a formula leaves out make its shape wrong by some 14 %.
pub(super) const SHAPE: f64 = 0.02;
/// The same where a regressor is only roughly known.
pub(super) const ROUGH_SHAPE: f64 = 0.1;

/// A smaller set that explains all but a small share of what a set explains on the same sensors, if there
/// is one: what the additional effects add may be the other formula's error. Effects of the reference are
/// on every sensor, so with one of them all sensors are looked at together.
#[must_use]
pub fn simpler(problem: &Problem<'_>, suspects: &Suspects<'_>, chosen: &Explanation) -> Option<Vec<usize>> {
    let information = suspects.information(problem, &chosen.fit.noise);
    let weights = problem.weight_of_white(&chosen.fit.noise);
    let rest = |set: &[usize]| suspects.rest_but_noise(&information, &weights, set);
    let best = information.solve(&suspects.positions(&chosen.columns))?.rest;
    let sensor = |column: &usize| suspects.candidate(*column).sensor();
    let is_joint = chosen.columns.iter().any(|column| sensor(column).is_none());
    let mut subjects: Vec<_> = chosen.columns.iter().map(sensor).collect();
    subjects.sort_by_key(|subject| subject.map(Sensor::index));
    subjects.dedup();
    if is_joint {
        subjects.truncate(1);
    }
    for subject in subjects {
        let is_own = |column: &usize| is_joint || sensor(column) == subject;
        let own = chosen.columns.iter().filter(|column| is_own(column)).count();
        let others: Vec<usize> = chosen.columns.iter().copied().filter(|c| !is_own(c)).collect();
        let is_rough = chosen.columns.iter().any(|column| is_own(column) && suspects.is_rough(*column));
        let shape = if is_rough { ROUGH_SHAPE } else { SHAPE };
        let Some(total) = rest(&others).map(|rest| rest - best) else { continue };
        let mut level = vec![others];
        for _ in 1..own {
            let next = extended(suspects, &information, &level);
            let first = next.first().map(|(_, set)| set.clone());
            if let Some(set) = first
                && rest(&set).is_some_and(|rest| rest - best < (shape * total).max(suspects.penalty()))
            {
                return Some(set);
            }
            level = next.into_iter().take(BEAM).map(|(_, set)| set).collect();
        }
    }
    None
}
