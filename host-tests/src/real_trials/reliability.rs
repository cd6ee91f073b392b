//! Whether the probabilities reported in these trials are right.

use super::trial::{Case, Outcome};
use crate::reliability::diagram;

/// The effects of flights whose truth is known (generated from a track, with one effect or without), by the
/// reported probability of each.
#[must_use]
pub fn reliability(outcomes: &[Outcome]) -> String {
    let mut said: Vec<(f64, bool)> = Vec::new();
    for outcome in outcomes {
        let acts = match outcome.case {
            Case::Null => None,
            Case::Made(injection) => Some(injection.effect()),
            Case::Plain | Case::Half(_) | Case::Added(_) => continue,
        };
        said.extend(outcome.probabilities().into_iter().map(|(effect, p)| (p, Some(effect) == acts)));
    }
    diagram(&said)
}
