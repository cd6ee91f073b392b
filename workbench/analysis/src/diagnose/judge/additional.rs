//! Effects in addition to some columns: the column of each that fits best.

use std::collections::BTreeMap;

use kf_core::effect::EffectId;

use super::{Judge, with};
use crate::diagnose::information::{Information, Solution};
use crate::diagnose::rivals::share;
use crate::diagnose::weigher::POWER;

/// The column of an additional effect that fits best.
pub(super) struct Additional {
    pub(super) column: usize,
    /// The share of the effect's columns that fit as well: its time constants, and the assumed errors of its
    /// signals, are equally probable.
    pub(super) share: f64,
    /// The chosen columns and this one, ascending.
    pub(super) set: Vec<usize>,
    /// The fit of that set.
    pub(super) solution: Solution,
}

impl Judge<'_> {
    /// For each effect that is not among the chosen columns and whose columns are all wanted, its best column
    /// together with them. An effect that is physically impossible there is left out.
    pub(super) fn additional(
        &self,
        information: &Information,
        chosen: &[usize],
        is_wanted: impl Fn(usize) -> bool,
    ) -> Vec<Additional> {
        let mut effects: BTreeMap<EffectId, Vec<(f64, Option<Additional>)>> = BTreeMap::new();
        for column in self.suspects.usable().iter().copied() {
            let is_chosen = chosen.iter().any(|other| self.suspects.same_effect(*other, column));
            if is_chosen || !is_wanted(column) {
                continue;
            }
            let set = with(chosen, column);
            let solution = information.solve(&self.suspects.positions(&set));
            // A shape that states another delay is no delay of its own.
            if solution.as_ref().is_some_and(|solution| !self.suspects.is_consistent(&set, solution)) {
                continue;
            }
            let possible = solution.filter(|solution| self.suspects.is_possible(&set, solution));
            let rest = possible.as_ref().map_or(f64::INFINITY, |solution| solution.rest);
            let additional = possible.map(|solution| Additional { column, share: 1.0, set, solution });
            effects.entry(self.candidates[column].effect()).or_default().push((rest, additional));
        }
        let best = effects.into_values().filter_map(|columns| {
            let least = columns.iter().map(|(rest, _)| *rest).min_by(f64::total_cmp)?;
            let share = share(columns.iter().map(|(rest, _)| rest - least), POWER);
            let best = columns.into_iter().find(|(rest, _)| *rest <= least)?.1?;
            Some(Additional { share, ..best })
        });
        best.collect()
    }
}
