//! The effect whose coefficient is wanted.

use kf_core::effect::{Clock, EffectId, Regressor};

use super::candidates::Candidate;

/// The effect whose coefficient is wanted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WantedEffect {
    /// The effect's id.
    pub effect: EffectId,
    /// Its time constant, seconds; `None`: the one of the grid that fits best.
    pub time_constant_s: Option<f32>,
    /// Start of its clock; `None`: whichever fits best.
    pub since: Option<Clock>,
}

/// Which part of the catalogue a study tries.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tried<'a> {
    /// The effect to learn.
    pub wanted: WantedEffect,
    /// Time constants to try for it, seconds; if empty, the catalogue's grid.
    pub time_constants_s: &'a [f32],
    /// The only other candidates, if an earlier search has chosen them; `None`: the whole catalogue.
    pub others: Option<&'a [Candidate]>,
}

impl Tried<'_> {
    /// Keeps only the candidates to be tried.
    pub(super) fn narrow(&self, candidates: &mut Vec<Candidate>) {
        if let Some(others) = self.others {
            candidates
                .retain(|candidate| candidate.effect() == self.wanted.effect || others.contains(candidate));
        }
        self.wanted.narrow(candidates, self.time_constants_s);
    }
}

impl WantedEffect {
    /// Keeps only the wanted ones of the effect's candidates, with these time constants if there are any.
    pub(super) fn narrow(&self, candidates: &mut Vec<Candidate>, time_constants_s: &[f32]) {
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
        // They are inserted in the same place: the search expects an effect's columns side by side.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::delay::DelayShape;

    /// Candidates of a lag in two shapes, of a drift with two clocks and two time constants, and of a scale.
    fn candidates() -> Vec<Candidate> {
        let of = |id, time_constant_s, since, delay| Candidate {
            delay,
            ..Candidate::of(Regressor { id, time_constant_s, since })
        };
        vec![
            of(EffectId::BaroLag, 0.0, Clock::Launch, DelayShape::Slope),
            of(EffectId::BaroLag, 0.0, Clock::Launch, DelayShape::LowPass(2.0)),
            of(EffectId::BaroWarmUp, 60.0, Clock::Launch, DelayShape::Slope),
            of(EffectId::BaroWarmUp, 200.0, Clock::Launch, DelayShape::Slope),
            of(EffectId::BaroWarmUp, 60.0, Clock::Start, DelayShape::Slope),
            of(EffectId::BaroScale, 0.0, Clock::Launch, DelayShape::Slope),
        ]
    }

    fn narrowed(
        effect: EffectId,
        since: Option<Clock>,
        times_s: &[f32],
    ) -> Vec<(EffectId, f32, Clock, DelayShape)> {
        let mut candidates = candidates();
        WantedEffect { effect, time_constant_s: None, since }.narrow(&mut candidates, times_s);
        let facts = |c: Candidate| (c.effect(), c.regressor.time_constant_s, c.regressor.since, c.delay);
        candidates.into_iter().map(facts).collect()
    }

    /// Of the wanted effect, those of another clock are removed; its shapes, and the other effects, are what a
    /// diagnosis tries.
    #[test]
    fn only_what_is_wanted_of_the_effect_is_kept() {
        let lag = narrowed(EffectId::BaroLag, None, &[]);
        assert_eq!(lag.len(), 6);
        let warm_up = narrowed(EffectId::BaroWarmUp, Some(Clock::Start), &[]);
        assert_eq!(warm_up.iter().filter(|(effect, ..)| *effect == EffectId::BaroWarmUp).count(), 1);
        assert_eq!(warm_up.iter().filter(|(effect, ..)| *effect == EffectId::BaroLag).count(), 2);
    }

    /// The given times replace the grid's, for each clock, side by side where the effect's columns were.
    #[test]
    fn given_times_take_the_grids_place() {
        let found = narrowed(EffectId::BaroWarmUp, None, &[10.0, 20.0, 30.0]);
        let effects: Vec<EffectId> = found.iter().map(|(effect, ..)| *effect).collect();
        let (lag, warm_up) = (EffectId::BaroLag, EffectId::BaroWarmUp);
        assert_eq!(
            effects,
            [lag, lag, warm_up, warm_up, warm_up, warm_up, warm_up, warm_up, EffectId::BaroScale]
        );
        let times: Vec<(f32, Clock)> =
            found[2..8].iter().map(|(_, time_s, since, _)| (*time_s, *since)).collect();
        assert_eq!(times[..3], [10.0, 20.0, 30.0].map(|time_s| (time_s, Clock::Launch)));
        assert_eq!(times[3..], [10.0, 20.0, 30.0].map(|time_s| (time_s, Clock::Start)));
    }
}
