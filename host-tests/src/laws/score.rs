//! How often the search is right.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use super::trial::Trial;
use crate::blind::Share;

/// Least correlation with the truth on the next flight for a law that predicts it.
const PREDICTS: f64 = 0.95;

/// The rates that the project promises.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Score {
    /// A law that predicts the hidden one is among those proposed.
    pub among: Share,
    /// It is the first.
    pub first: Share,
    /// Flights with a hidden law for which nothing is proposed.
    pub silent: Share,
    /// Of these, flights in which the catalogue explains part of it.
    pub by_catalogue: Share,
    /// Null flights for which a law is proposed.
    pub null_proposed: Share,
    /// A first law that increases the next flight's error, among all trials.
    pub worse: Share,
    /// By kind: among, and first.
    pub kinds: BTreeMap<&'static str, [Share; 2]>,
}

impl Trial {
    /// Whether a law that predicts the hidden one is among those proposed, and whether it is the first.
    #[must_use]
    pub fn hits(&self) -> [bool; 2] {
        let is_hit = |correlation: &f64| correlation.abs() >= PREDICTS;
        [self.correlations.iter().any(is_hit), self.correlations.first().is_some_and(is_hit)]
    }

    /// Whether the first law makes the next flight worse.
    #[must_use]
    pub fn is_worse(&self) -> bool {
        self.next_m.is_some_and(|[before, after]| after > before)
    }
}

impl Score {
    /// Counts these trials.
    #[must_use]
    pub fn of(trials: &[Trial]) -> Self {
        let mut score = Self::default();
        for trial in trials {
            score.worse.count(trial.is_worse());
            let is_silent = trial.discovery.laws.is_empty();
            let Some((hidden, _)) = trial.case.hidden else {
                score.null_proposed.count(!is_silent);
                continue;
            };
            let [among, first] = trial.hits();
            score.among.count(among);
            score.first.count(first);
            score.silent.count(is_silent);
            if is_silent {
                score.by_catalogue.count(!trial.discovery.catalogue.is_empty());
            }
            let kind = score.kinds.entry(hidden.kind()).or_default();
            kind[0].count(among);
            kind[1].count(first);
        }
        score
    }
}

/// The score as a table.
#[must_use]
pub fn table(trials: &[Trial]) -> String {
    let score = Score::of(trials);
    let mut text = String::new();
    for (what, share, wanted) in [
        ("a law that predicts the hidden one is among the five", score.among, ">= 80 %"),
        ("it is the first", score.first, ">= 60 %"),
        ("nothing is proposed for a hidden law", score.silent, ""),
        ("  of these, the catalogue explains some of it", score.by_catalogue, ""),
        ("null flights for which a law is proposed", score.null_proposed, "<= 2 %"),
        ("a first law makes the next flight worse, of all trials", score.worse, "<= 3 %"),
    ] {
        text += &share.line(what, 56, wanted);
    }
    text += "\nby hidden law: among the five, first\n";
    for (kind, [among, first]) in &score.kinds {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "  {kind:<32} {:>3} and {:>3} of {}", among.hits, first.hits, among.of);
    }
    text
}
