//! The effect whose coefficient is wanted.

use kf_core::effect::{Clock, EffectId, Regressor};

use super::candidates::Candidate;

/// The effect whose coefficient is wanted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WantedEffect {
    /// Which.
    pub effect: EffectId,
    /// Its time constant, seconds; `None`: that of the grid that fits best.
    pub time_constant_s: Option<f32>,
    /// Where its clock starts; `None`: whichever fits best.
    pub since: Option<Clock>,
}

/// What a study tries of the catalogue.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tried<'a> {
    /// The effect to learn.
    pub wanted: WantedEffect,
    /// Time constants to try for it, seconds; none: the catalogue's grid.
    pub time_constants_s: &'a [f32],
    /// The only other candidates, where a search before has chosen them; `None`: the whole catalogue.
    pub others: Option<&'a [Candidate]>,
}

impl Tried<'_> {
    /// Keeps what is to be tried.
    pub(super) fn narrow(&self, candidates: &mut Vec<Candidate>) {
        if let Some(others) = self.others {
            candidates
                .retain(|candidate| candidate.effect() == self.wanted.effect || others.contains(candidate));
        }
        self.wanted.narrow(candidates, self.time_constants_s);
    }
}

impl WantedEffect {
    /// Keeps only what is wanted of the effect's candidates, with these time constants if there are any.
    pub(super) fn narrow(&self, candidates: &mut Vec<Candidate>, time_constants_s: &[f32]) {
        // The core has a lag in the catalogue's own shape only.
        candidates.retain(|candidate| candidate.effect() != self.effect || candidate.smoothing_s == 0.0);
        if !self.effect.has_time_constant() {
            return;
        }
        let is_other = |candidate: &Candidate| {
            candidate.effect() == self.effect
                && self.since.is_some_and(|since| candidate.regressor.since != since)
        };
        candidates.retain(|candidate| !is_other(candidate));
        if time_constants_s.is_empty() {
            return;
        }
        let mut own: Vec<Candidate> =
            candidates.iter().copied().filter(|candidate| candidate.effect() == self.effect).collect();
        own.dedup_by_key(|candidate| candidate.regressor.since);
        // In their place: the search expects an effect's columns side by side.
        let at = candidates.iter().position(|candidate| candidate.effect() == self.effect).unwrap_or(0);
        candidates.retain(|candidate| candidate.effect() != self.effect);
        let with = |candidate: Candidate, time_constant_s| Candidate {
            regressor: Regressor { time_constant_s, ..candidate.regressor },
            ..candidate
        };
        let new = own.iter().flat_map(|own| time_constants_s.iter().map(|time_s| with(*own, *time_s)));
        candidates.splice(at..at, new);
    }
}
