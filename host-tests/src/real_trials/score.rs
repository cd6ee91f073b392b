//! How often the diagnosis of a real track is right.

use std::fmt::Write as _;

use super::trial::{Case, Outcome};
use crate::blind::Share;

/// Number of suspects from which on a set is no help.
const LARGE_SET: usize = 4;

/// The rates.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Score {
    /// Nulls in which a cause is identified.
    pub null_identified: Share,
    /// Nulls in which a set is offered.
    pub null_sets: Share,
    /// Injections identified outright.
    pub named: Share,
    /// Injections identified, or in a set of two.
    pub named_or_two: Share,
    /// The same, where nothing counts as a member of a set, too.
    pub named_or_two_with_nothing: Share,
    /// Injections identified, or in any set.
    pub held: Share,
    /// Injections with another effect identified that the log did not show before.
    pub wrong: Share,
    /// Logs as they are with an effect identified.
    pub plain_identified: Share,
    /// Logs as they are, with a set of four suspects or more.
    pub plain_large: Share,
    /// Sets of four suspects or more, of all flights but the halves.
    pub large: Share,
    /// Flights with the lag and the latency of one free sensor identified.
    pub lag_and_latency: Share,
    /// Effects identified in a half of a log that are within two sigma of the other half's.
    pub halves_agree: Share,
    /// Coefficients of injections within 1.96 sigma of what was added.
    pub covered: Share,
}

impl Score {
    /// Counts these outcomes.
    #[must_use]
    pub fn of(outcomes: &[Outcome]) -> Self {
        let mut score = Self::default();
        for outcome in outcomes.iter().filter(|outcome| outcome.said.is_ok()) {
            score.count(outcome);
        }
        for first in outcomes.iter().filter(|outcome| outcome.case == Case::Half(0)) {
            let second = outcomes.iter().find(|o| o.case == Case::Half(1) && o.log == first.log);
            if let Some(second) = second {
                score.count_halves(first, second);
                score.count_halves(second, first);
            }
        }
        score
    }

    fn count(&mut self, outcome: &Outcome) {
        let (identified, sets) = (outcome.identified(), outcome.sets());
        let is_large = sets.iter().any(|set| set.len() >= LARGE_SET);
        let both = ["baro.lag", "gps.latency"].iter().all(|effect| identified.contains(effect));
        self.lag_and_latency.count(both);
        match outcome.case {
            Case::Half(_) => return,
            Case::Plain => {
                self.plain_identified.count(!identified.is_empty());
                self.plain_large.count(is_large);
            }
            Case::Null => {
                self.null_identified.count(!identified.is_empty());
                self.null_sets.count(!sets.is_empty());
            }
            Case::Made(injection) | Case::Added(injection) => {
                let effect = injection.effect();
                let is_named = identified.contains(&effect);
                let in_set = |most: usize| sets.iter().any(|set| set.len() <= most && set.contains(&effect));
                self.named.count(is_named);
                self.named_or_two.count(is_named || in_set(2));
                self.named_or_two_with_nothing
                    .count(is_named || outcome.fewest(effect).is_some_and(|few| few <= 2));
                self.held.count(is_named || in_set(usize::MAX));
                let is_strange = |other: &&'static str| *other != effect && !outcome.before.contains(other);
                self.wrong.count(identified.iter().any(is_strange));
                // The log's own part of the effect is not known.
                let is_made = matches!(outcome.case, Case::Made(_));
                if let (true, true, Some((coefficient, sigma))) = (is_named, is_made, outcome.fitted(effect))
                {
                    self.covered.count((coefficient - injection.coefficient()).abs() < 1.96 * sigma);
                }
            }
        }
        self.large.count(is_large);
    }

    /// Compares what one half of a log identifies with the other half.
    fn count_halves(&mut self, one: &Outcome, other: &Outcome) {
        for effect in one.identified() {
            if let (Some((a, a_sigma)), Some((b, b_sigma))) = (one.fitted(effect), other.fitted(effect)) {
                self.halves_agree.count((a - b).abs() < 2.0 * a_sigma.hypot(b_sigma));
            }
        }
    }
}

/// The score as a table, and the answers for each kind of injection.
#[must_use]
pub fn table(outcomes: &[Outcome]) -> String {
    let score = Score::of(outcomes);
    let mut text = String::new();
    for (what, share, wanted) in [
        ("nulls: a cause identified", score.null_identified, "<= 2 %"),
        ("nulls: a set offered", score.null_sets, "<= 5 %"),
        ("injections over twice the noise: named", score.named, ">= 75 %"),
        ("  named, or in a set of two", score.named_or_two, ">= 90 %"),
        ("  the same, where nothing counts as a member too", score.named_or_two_with_nothing, ""),
        ("  named, or in any set", score.held, ""),
        ("  another effect identified", score.wrong, "<= 2 %"),
        ("logs as they are: a cause identified", score.plain_identified, ""),
        ("logs as they are: a set of four or more", score.plain_large, "<= 5 %"),
        ("all but halves: a set of four or more", score.large, "<= 5 %"),
        ("lag and latency identified together", score.lag_and_latency, "0"),
        (
            "identified in one half of a log, and the other agrees within 2 sigma",
            score.halves_agree,
            ">= 85 %",
        ),
        ("coefficients of the named injections within 1.96 sigma", score.covered, "92 to 98 %"),
    ] {
        text += &share.line(what, 70, wanted);
    }
    let _ =
        writeln!(text, "\n{:<36} {:>5} {:>8} {:>8} {:>8}", "injected", "of", "named", "or two", "any set");
    for is_made in [true, false] {
        for effect in ["baro.scale", "baro.lag", "gps.latency", "baro.drift", "baro.dynamic_pressure"] {
            let own: Vec<Outcome> = outcomes
                .iter()
                .filter(|outcome| match outcome.case {
                    Case::Made(injection) => is_made && injection.effect() == effect,
                    Case::Added(injection) => !is_made && injection.effect() == effect,
                    _ => false,
                })
                .cloned()
                .collect();
            let own = Score::of(&own);
            let into = if is_made { "real track" } else { "real log" };
            let _ = writeln!(
                text,
                "{:<36} {:>5} {:>8} {:>8} {:>8}",
                format!("{effect}, {into}"),
                own.named.of,
                own.named.hits,
                own.named_or_two.hits,
                own.held.hits
            );
        }
    }
    text
}
