//! How probable each set of effects is, where the climb rate is not measured.
//!
//! Sets are weighed ([`Weigher`]) as in Occam's window (Madigan and Raftery, "Model selection and accounting
//! for model uncertainty in graphical models using Occam's window", Journal of the American Statistical
//! Association 89, 1994): starting from the best one, those with one effect more, one less or another one, as
//! long as their weight is close to the best. The noise is fitted again for the nearest ones.

use std::collections::{BTreeMap, BTreeSet};

use kf_core::effect::EffectId;

use super::judge::SUSPECT;
use super::problem::Problem;
use super::rivals::Rivals;
use super::search::{Explanation, Search};
use super::suspects::Suspects;
use super::weigher::{WINDOW, Weighed, Weigher};
use crate::progress::{Cancelled, Progress, step};

/// Number of sets whose noise is fitted in a round, and number of rounds.
const REFITTED: usize = 3;
const ROUNDS: usize = 6;

/// Probabilities of sets of effects.
#[derive(Clone, Debug, Default)]
pub struct Posterior {
    /// Sets with their probabilities, the most probable first.
    sets: Vec<(Vec<usize>, f64)>,
    effects: BTreeMap<usize, EffectId>,
}

/// Weighs the sets around the one that a search found.
///
/// # Errors
/// [`Cancelled`] when `progress` requests it.
pub fn posterior(
    search: &mut Search<'_>,
    suspects: &Suspects<'_>,
    problem: &Problem<'_>,
    found: &Explanation,
    progress: &mut Progress<'_>,
) -> Result<Posterior, Cancelled> {
    let mut weigher = Weigher::new(suspects, problem);
    let mut sets: BTreeMap<Vec<EffectId>, Weighed> = BTreeMap::new();
    let mut refitted: BTreeSet<Vec<EffectId>> = BTreeSet::new();
    let start = weigher.without_scale(&found.columns);
    let basis = weigher.basis(search, &start, &found.fit.values);
    step(progress)?;
    refitted.insert(weigher.effects(&start));
    let mut best: Option<Weighed> = None;
    for (effects, weighed) in weigher.weigh(&basis, &start) {
        best = Some(weigher.heavier(best, &weighed));
        sets.insert(effects, weighed);
    }
    let Some(mut best) = best else { return Ok(Posterior::default()) };
    for round in 1..=ROUNDS {
        // First all sets around the best one under its noise, then the nearest ones with their own.
        let mut near: Vec<(f64, Vec<usize>)> = Vec::new();
        for columns in weigher.around(&best) {
            for (effects, weighed) in weigher.weigh(&best.basis, &columns) {
                if refitted.contains(&weigher.effects(&weighed.bare)) {
                    continue;
                }
                let ahead = weigher.ahead(&weighed, &best);
                if ahead > -WINDOW {
                    near.push((ahead, weighed.bare.clone()));
                }
                let slot = sets.entry(effects).or_insert_with(|| weighed.clone());
                if weighed.log_weight > slot.log_weight {
                    *slot = weighed;
                }
            }
        }
        near.sort_by(|a, b| b.0.total_cmp(&a.0));
        // The nearest of each set of effects.
        let mut nearest: Vec<(Vec<EffectId>, Vec<usize>)> = Vec::new();
        for (_, columns) in near {
            let effects = weigher.effects(&columns);
            if nearest.len() < REFITTED && nearest.iter().all(|(others, _)| *others != effects) {
                nearest.push((effects, columns));
            }
        }
        let count = nearest.len();
        let with_scale: Vec<_> = nearest.iter().map(|(_, columns)| weigher.with_scale(columns)).collect();
        let values = best.basis.fit.values.clone();
        search.look_at(&with_scale, &values);
        let before = weigher.effects(&best.bare);
        let mut next = best.clone();
        for (effects, columns) in nearest {
            let basis = weigher.basis(search, &columns, &values);
            step(progress)?;
            for (effects, weighed) in weigher.weigh(&basis, &columns) {
                next = weigher.heavier(Some(next), &weighed);
                sets.insert(effects, weighed);
            }
            refitted.insert(effects);
        }
        best = next;
        let is_settled = weigher.effects(&best.bare) == before && count < REFITTED;
        if !is_settled && round < ROUNDS {
            continue;
        }
        // Evidence for an uneven coefficient counts less, so another set may now be the best one.
        weigher.discount(&best);
        step(progress)?;
        let now = sets.values().fold(best.clone(), |most, set| weigher.heavier(Some(most), set));
        if weigher.effects(&weigher.columns(&now)) == weigher.effects(&weigher.columns(&best)) {
            break;
        }
        best = now;
    }
    Ok(Posterior::of(&weigher, &sets, &best))
}

impl Posterior {
    /// The probabilities by the sets' odds against the best one.
    fn of(weigher: &Weigher<'_>, sets: &BTreeMap<Vec<EffectId>, Weighed>, best: &Weighed) -> Self {
        let odds: Vec<f64> = sets.values().map(|set| libm::exp(weigher.ahead(set, best))).collect();
        let total: f64 = odds.iter().sum();
        let columns = sets.values().map(|set| weigher.columns(set));
        let mut found: Vec<(Vec<usize>, f64)> =
            columns.zip(odds).map(|(columns, odds)| (columns, odds / total)).collect();
        found.sort_by(|a, b| b.1.total_cmp(&a.1));
        Self { sets: found, effects: weigher.all_effects() }
    }

    /// The columns of the most probable set.
    #[must_use]
    pub fn best(&self) -> Vec<usize> {
        self.sets.first().map_or_else(Vec::new, |(columns, _)| columns.clone())
    }

    /// The probability that an effect acts.
    #[must_use]
    pub fn inclusion(&self, effect: EffectId) -> f64 {
        self.share(|set| self.has(set, effect))
    }

    /// What could replace a column of the most probable set: the other effects, with their share of the sets
    /// without the column's effect; and the probability that the place is empty.
    ///
    /// An effect that is as probable beside the column's as without it replaces nothing. So an effect counts
    /// as a rival if it is more probable without the column's, by as much as makes a suspect, than it would
    /// be if the two were independent. Of the others only that excess counts.
    #[must_use]
    pub fn rivals(&self, column: usize, chosen: &[usize], explained: f64) -> Rivals {
        let own = self.effects.get(&column).copied();
        let lacks_own = |set: &[usize]| own.is_none_or(|own| !self.has(set, own));
        let acts = own.map_or(0.0, |own| self.inclusion(own)).max(f64::MIN_POSITIVE);
        let mut columns: BTreeMap<EffectId, usize> = BTreeMap::new();
        for (set, _) in self.sets.iter().filter(|(set, _)| lacks_own(set)) {
            for other in set {
                if let Some(effect) = self.effects.get(other).filter(|effect| !self.has(chosen, **effect)) {
                    columns.entry(*effect).or_insert(*other);
                }
            }
        }
        let mut found: Vec<(f64, usize)> = Vec::new();
        let mut rivals: Vec<EffectId> = Vec::new();
        for (effect, other) in columns {
            let without = self.share(|set| lacks_own(set) && self.has(set, effect));
            let beside = self.share(|set| !lacks_own(set) && self.has(set, effect)) / acts;
            let excess = (without - beside * (1.0 - acts)).max(0.0);
            if excess >= SUSPECT {
                rivals.push(effect);
            }
            found.push((if excess >= SUSPECT { without } else { excess }, other));
        }
        found.sort_by(|a, b| b.0.total_cmp(&a.0));
        let (others, odds) =
            found.into_iter().map(|(probability, other)| (other, probability / acts)).unzip();
        let empty = self.share(|set| lacks_own(set) && !rivals.iter().any(|rival| self.has(set, *rival)));
        let odds_of_nothing = empty / acts;
        Rivals {
            column,
            others,
            odds,
            explained,
            acts: Some(acts),
            odds_of_nothing,
            is_stand_in: false,
            is_part_of_lift: false,
            is_weak: false,
        }
    }

    fn has(&self, set: &[usize], effect: EffectId) -> bool {
        set.iter().any(|column| self.effects.get(column) == Some(&effect))
    }

    fn share(&self, of: impl Fn(&[usize]) -> bool) -> f64 {
        self.sets.iter().filter(|(set, _)| of(set)).map(|(_, probability)| probability).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sets of columns of three effects: a lag with two columns, a scale and a drift with one each.
    fn posterior() -> Posterior {
        let effects = [
            (1, EffectId::BaroLag),
            (2, EffectId::BaroLag),
            (5, EffectId::BaroScale),
            (8, EffectId::BaroDrift),
        ];
        Posterior {
            sets: vec![
                (vec![2], 0.5),
                (vec![5], 0.2),
                (vec![1, 8], 0.15),
                (vec![5, 8], 0.1),
                (Vec::new(), 0.05),
            ],
            effects: effects.into_iter().collect(),
        }
    }

    /// The best set is the first; an effect acts with the probability of all sets that contain any of its
    /// columns.
    #[test]
    fn an_effect_acts_in_the_sets_that_have_it() {
        let found = posterior();
        assert_eq!(found.best(), [2]);
        for (effect, wanted) in
            [(EffectId::BaroLag, 0.65), (EffectId::BaroScale, 0.3), (EffectId::BaroDrift, 0.25)]
        {
            assert!((found.inclusion(effect) - wanted).abs() < 1e-12, "{}", effect.name());
        }
        assert_eq!(found.inclusion(EffectId::GpsLatency), 0.0);
    }

    /// Of the sets without the lag, a scale is in those of 0.3, and never beside it; nothing is in the set of
    /// 0.05. A drift is in the others as often as beside the lag (0.15 of 0.65, and 0.1 of 0.35), so it
    /// replaces next to nothing.
    #[test]
    fn rivals_replace_the_chosen() {
        let rivals = posterior().rivals(2, &[2], 7.0);
        assert_eq!((rivals.column, rivals.explained), (2, 7.0));
        assert!(
            (rivals.acts.unwrap() - 0.65).abs() < 1e-12
                && (rivals.odds_of_nothing - 0.05 / 0.65).abs() < 1e-12,
            "{rivals:?}"
        );
        assert_eq!(rivals.others, [5, 8]);
        let wanted = [0.3 / 0.65, (0.1 - 0.15 / 0.65 * 0.35) / 0.65];
        assert!(
            rivals.odds.iter().zip(wanted).all(|(odds, wanted)| (odds - wanted).abs() < 1e-12),
            "{rivals:?}"
        );
        // For a chosen drift, only the scale is a rival.
        assert_eq!(posterior().rivals(2, &[2, 8], 7.0).others, [5]);
    }

    /// An effect that has nothing to do with the chosen one leaves its place as empty as it is.
    #[test]
    fn an_independent_effect_is_no_rival() {
        let mut posterior = posterior();
        posterior.sets = vec![(vec![2], 0.42), (vec![2, 8], 0.18), (Vec::new(), 0.28), (vec![8], 0.12)];
        let rivals = posterior.rivals(2, &[2], 7.0);
        let as_likely_empty = (rivals.odds_of_nothing - 0.4 / 0.6).abs() < 1e-12;
        assert!(as_likely_empty && rivals.odds[0].abs() < 1e-12, "{rivals:?}");
    }
}
