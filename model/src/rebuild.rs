//! A model as it was after one of its revisions.

use std::collections::BTreeSet;

use kf_core::effect::EffectId;

use crate::{Model, Revision};

impl Model {
    /// The numbers of the model's revisions, ascending.
    #[must_use]
    pub fn revision_numbers(&self) -> Vec<u32> {
        let mut numbers: Vec<u32> = self.revisions.iter().map(|revision| revision.number).collect();
        numbers.sort_unstable();
        numbers
    }

    /// The number of the next revision.
    #[must_use]
    pub fn next_revision(&self) -> u32 {
        self.revision_numbers().last().map_or(1, |last| last.saturating_add(1))
    }

    /// The model as it was after the revision with this number; 0 (or any number below the first) is before
    /// all of them.
    ///
    /// Effects that no revision names were there from the start. An effect has the coefficient of the last
    /// revision so far that learned it. Before the first of these it has the coefficient that the first one
    /// replaced; if that replaced none, the effect was absent. Values that a revision did not record, and
    /// everything but effects, are those of today.
    #[must_use]
    pub fn at_revision(&self, number: u32) -> Self {
        let mut model = self.clone();
        model.revisions.retain(|revision| revision.number <= number);
        let mut history: Vec<&Revision> = self.revisions.iter().collect();
        history.sort_by_key(|revision| revision.number);
        let named: BTreeSet<EffectId> = history.iter().filter_map(|revision| revision.effect).collect();
        model.effects.retain_mut(|effect| {
            let id = effect.term.id();
            if !named.contains(&id) {
                return true;
            }
            let mut of_effect = history.iter().filter(|revision| revision.effect == Some(id));
            let last = of_effect.clone().rfind(|revision| revision.number <= number);
            let Some(last) = last else {
                let replaced = of_effect.next().and_then(|first| first.replaced_coefficient);
                effect.term.coefficient = replaced.unwrap_or(effect.term.coefficient);
                return replaced.is_some();
            };
            effect.estimate = last.estimate.unwrap_or(effect.estimate);
            let term = &mut effect.term;
            term.coefficient = last.coefficient.unwrap_or(term.coefficient);
            term.sigma = last.sigma.unwrap_or(term.sigma);
            term.regressor.time_constant_s = last.time_constant_s.unwrap_or(term.regressor.time_constant_s);
            term.regressor.since = last.since.unwrap_or(term.regressor.since);
            true
        });
        model
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    const HISTORY: &str = r#"
        [[effect]]
        id = "baro.lag"
        coefficient = 0.3
        [[effect]]
        id = "baro.dynamic_pressure"
        coefficient = 0.06
        sigma = 0.002
        [[effect]]
        id = "baro.warm_up"
        coefficient = 5.0
        time_constant_s = 90.0
        [[effect]]
        id = "imu.tilt"
        coefficient = 0.02
        [[revision]]
        number = 5
        effect = "baro.dynamic_pressure"
        coefficient = 0.06
        sigma = 0.002
        [[revision]]
        number = 2
        effect = "baro.dynamic_pressure"
        coefficient = 0.05
        sigma = 0.01
        [[revision]]
        number = 3
        effect = "baro.warm_up"
        coefficient = 4.0
        time_constant_s = 30.0
        [[revision]]
        number = 7
        effect = "imu.tilt"
        coefficient = 0.02
        replaced_coefficient = 0.01
    "#;

    #[test]
    fn a_revision_has_the_effects_and_coefficients_that_it_left() {
        let model = Model::parse(HISTORY).unwrap();
        assert_eq!(model.revision_numbers(), [2, 3, 5, 7]);
        assert_eq!(model.next_revision(), 8);
        let at = |number: u32| -> Vec<(&'static str, f32, f32)> {
            let model = model.at_revision(number);
            assert!(model.revisions.iter().all(|revision| revision.number <= number));
            let terms = model.effects.iter().map(|effect| effect.term);
            terms.map(|term| (term.id().name(), term.coefficient, term.sigma)).collect()
        };
        assert_eq!(at(0), [("baro.lag", 0.3, 0.0), ("imu.tilt", 0.01, 0.0)]);
        assert_eq!(
            at(2),
            [("baro.lag", 0.3, 0.0), ("baro.dynamic_pressure", 0.05, 0.01), ("imu.tilt", 0.01, 0.0)]
        );
        assert_eq!(at(4)[2], ("baro.warm_up", 4.0, 0.0));
        assert_eq!(model.at_revision(4).effects[2].term.regressor.time_constant_s, 30.0);
        assert_eq!(at(5)[1], ("baro.dynamic_pressure", 0.06, 0.002));
        assert_eq!(at(7)[3], ("imu.tilt", 0.02, 0.0));
        assert_eq!(Model::default().next_revision(), 1);
    }
}
