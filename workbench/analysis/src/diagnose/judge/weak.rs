//! Effects that may act on sensors for which the search chose none.
//!
//! Where the climb rate is measured, the search chooses an effect that gains some 22 in twice the log
//! likelihood (`Suspects::penalty`), so that it is seldom chance. To report that nothing is missing would then
//! deny effects that are more probable than not. So every effect has odds against nothing, from its gain with
//! the noise fitted again, the power that errors of shapes and the parts of the flight leave to the
//! likelihood, its prior odds and Occam's factor. Where nothing is the less probable, the effects are reported
//! as a set, with the probability of nothing.
//!
//! How probable an effect is within the set depends on the gains alone, as in `rivals.rs`: how large an effect
//! can be does not show which of two acts.

use super::probable::EMPTY;
use super::{Findings, Judge, Set, with};
use crate::diagnose::repeatability::{inflation, repeatability};
use crate::diagnose::rivals::{Rivals, price};
use crate::diagnose::search::{Explanation, Search};
use crate::diagnose::shape_error;
use crate::diagnose::weigher::POWER;
use crate::progress::{Cancelled, Progress, step};

/// Factor of the odds of an effect that the search did not choose. With it and the whole likelihood, of what
/// is reported with some probability that share acts; with one and the power of `weigher.rs`, more acted of
/// what was reported, and less of what was not (docs/blind-trials-history.md, "How probable weak effects are").
const PRIOR: f64 = 0.4;

/// An effect in addition to the chosen ones.
struct Weak {
    column: usize,
    /// Odds against nothing.
    odds: f64,
    /// Logarithm of its weight among the effects.
    log_weight: f64,
    /// What it gains in twice the log likelihood.
    gain: f64,
}

impl Judge<'_> {
    /// What may act where nothing was chosen. The most probable place comes first, and the next one is beside
    /// what acts there: the reference's wander is in all sensors, so an effect on one of them looks like a
    /// smaller one on the others. Where the climb rate is not measured there is nothing to add: every set of
    /// effects has a probability.
    pub(super) fn weak(
        &self,
        search: &mut Search<'_>,
        findings: &Findings,
        progress: &mut Progress<'_>,
    ) -> Result<Vec<Rivals>, Cancelled> {
        if !self.has_climb_rate {
            return Ok(Vec::new());
        }
        let mut found: Vec<Rivals> = Vec::new();
        let mut beside = findings.explanation.clone();
        while let Some(place) = self.weak_place(search, findings, &beside, &found, progress)? {
            let columns = with(&beside.columns, place.column);
            let fit = search.fit(&columns, &beside.fit.values);
            beside = Explanation { columns, fit };
            found.push(place);
        }
        Ok(found)
    }

    /// The place of the most probable effect in addition to these, if more probably something acts there than
    /// nothing.
    fn weak_place(
        &self,
        search: &mut Search<'_>,
        findings: &Findings,
        beside: &Explanation,
        found: &[Rivals],
        progress: &mut Progress<'_>,
    ) -> Result<Option<Rivals>, Cancelled> {
        let mut left = Vec::new();
        for some in self.addable(findings, beside, found).chunks(self.problem.width()) {
            let sets: Vec<Vec<usize>> =
                some.iter().map(|(column, _)| with(&beside.columns, *column)).collect();
            search.look_at(&sets, &beside.fit.values);
            for (column, share) in some {
                left.extend(self.weigh(search, beside, *column, *share));
                step(progress)?;
            }
        }
        left.sort_by(|a, b| b.odds.total_cmp(&a.odds));
        while let Some(first) = left.first() {
            let subject = self.candidates[first.column].sensor();
            // Effects of the reference are on every sensor.
            let is_here = |weak: &Weak| {
                let own = self.candidates[weak.column].sensor();
                subject.is_none() || own.is_none() || own == subject
            };
            let (here, rest) = left.into_iter().partition(is_here);
            left = rest;
            if let Some(place) = place(here) {
                return Ok(Some(place));
            }
        }
        Ok(None)
    }

    /// The effects that could act on sensors for which none was chosen: the column of each that fits best
    /// under the chosen noise, and the share of its columns that fit as well.
    fn addable(&self, findings: &Findings, beside: &Explanation, found: &[Rivals]) -> Vec<(usize, f64)> {
        let information = self.suspects.information(self.problem, &beside.fit.noise);
        let sets: Vec<Set> = findings.rivals.iter().chain(found).map(|rivals| self.set(rivals)).collect();
        let is_wanted = |column: usize| {
            let sensor = self.candidates[column].sensor();
            !sets.iter().any(|set| set.concerns(sensor)) && (sensor.is_some() || found.is_empty())
        };
        let additional = self.additional(&information, &beside.columns, is_wanted);
        additional.into_iter().map(|additional| (additional.column, additional.share)).collect()
    }

    /// Weighs an effect, of whose columns this is the best one, against nothing. `None` where it gains
    /// nothing, is physically impossible or cannot be told from the chosen ones.
    fn weigh(
        &self,
        search: &mut Search<'_>,
        before: &Explanation,
        column: usize,
        share: f64,
    ) -> Option<Weak> {
        let set = with(&before.columns, column);
        let fit = search.fit(&set, &before.fit.values);
        let gain = fit.twice_log_posterior - before.fit.twice_log_posterior;
        let information = self.suspects.information(self.problem, &fit.noise);
        let solution = information.solve(&self.suspects.positions(&set))?;
        if gain <= 0.0 || !self.suspects.is_possible(&set, &solution) {
            return None;
        }
        let at = set.iter().position(|other| *other == column)?;
        let repeat = repeatability(self.problem, &fit.noise, &set);
        let inflation = inflation(self.problem, &fit.noise, &set, &repeat).get(at).copied()?;
        let of_shapes = shape_error::variance(
            self.problem,
            self.suspects,
            &before.fit.noise,
            &before.columns,
            &[column],
        )?;
        let power = 1.0 / (inflation.max(1.0 / POWER) + of_shapes);
        let log_weight = 0.5 * power * gain;
        let price = price(self.candidates[column].effect(), &solution, at) + libm::log(share);
        Some(Weak { column, odds: PRIOR * libm::exp(log_weight / POWER + price), log_weight, gain })
    }
}

/// The set of effects of which one may act in one place, unless nothing does more probably.
fn place(mut effects: Vec<Weak>) -> Option<Rivals> {
    let odds: f64 = effects.iter().map(|weak| weak.odds).sum();
    if 1.0 / (1.0 + odds) > EMPTY {
        return None;
    }
    effects.sort_by(|a, b| b.log_weight.total_cmp(&a.log_weight));
    let (first, others) = effects.split_first()?;
    let weight = |weak: &Weak| libm::exp(weak.log_weight - first.log_weight);
    let total: f64 = effects.iter().map(weight).sum();
    Some(Rivals {
        column: first.column,
        others: others.iter().map(|weak| weak.column).collect(),
        odds: others.iter().map(weight).collect(),
        explained: first.gain,
        acts: None,
        odds_of_nothing: total / odds,
        is_stand_in: false,
        is_part_of_lift: false,
        is_weak: true,
    })
}
