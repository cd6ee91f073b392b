//! Whether fewer effects explain as much.

use kf_core::sensor::Sensor;

use super::problem::Problem;
use super::search::{BEAM, Explanation, extended};
use super::shape_error;
use super::suspects::Suspects;

/// A smaller set on the same sensors whose larger remainder may come from errors of its effects' shapes
/// ([`super::shape_error`]), if there is one: what the further effects add may be the other formula's error.
/// Effects of the reference are on every sensor, so with one of them all sensors are considered together.
#[must_use]
pub fn simpler(problem: &Problem<'_>, suspects: &Suspects<'_>, chosen: &Explanation) -> Option<Vec<usize>> {
    let information = suspects.information(problem, &chosen.fit.noise);
    let weights = problem.weight_of_white(&chosen.fit.noise);
    let rest = |set: &[usize]| suspects.rest_but_noise(&information, &weights, set);
    let best = information.solve(&suspects.positions(&chosen.columns))?.rest;
    let sensor = |column: &usize| suspects.candidate(*column).sensor();
    // The factor by which the variance from chance and shapes together exceeds that from chance alone, in
    // what distinguishes the chosen set from a smaller one.
    let by_shapes = |set: &[usize]| {
        let further: Vec<usize> = chosen.columns.iter().copied().filter(|c| !set.contains(c)).collect();
        1.0 + shape_error::variance(problem, suspects, &chosen.fit.noise, set, &further)
            .unwrap_or(f64::INFINITY)
    };
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
        let mut level = vec![others];
        for _ in 1..own {
            let next = extended(suspects, &information, &level);
            let first = next.first().map(|(_, set)| set.clone());
            if let Some(set) = first
                && rest(&set).is_some_and(|rest| rest - best < suspects.penalty() * by_shapes(&set))
            {
                return Some(set);
            }
            level = next.into_iter().take(BEAM).map(|(_, set)| set).collect();
        }
    }
    None
}
