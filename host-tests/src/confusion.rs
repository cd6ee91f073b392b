//! Hidden causes against answers, for many blind trials.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use pylon::diagnose::Verdict;

use crate::blind::{Kind, Trial};

/// The answer for a trial as a whole.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum TrialAnswer {
    Identified,
    SetWithIt,
    SetWithoutIt,
    Wrong,
    Unknown,
    Insufficient,
    Quiet,
}

impl TrialAnswer {
    const ALL: [(Self, &'static str); 7] = [
        (Self::Identified, "identified"),
        (Self::SetWithIt, "set with it"),
        (Self::SetWithoutIt, "set without"),
        (Self::Wrong, "wrong"),
        (Self::Unknown, "unknown"),
        (Self::Insufficient, "not excited"),
        (Self::Quiet, "no misfit"),
    ];

    fn of(trial: &Trial) -> Self {
        if trial.is_wrong() {
            return Self::Wrong;
        }
        match trial.diagnosis.verdict {
            Verdict::NoSignificantMisfit => Self::Quiet,
            Verdict::InsufficientExcitation => Self::Insufficient,
            Verdict::Identified => Self::Identified,
            Verdict::Indistinguishable => {
                let holds = trial.truth.iter().any(|(id, _)| trial.holds(id));
                if holds { Self::SetWithIt } else { Self::SetWithoutIt }
            }
            Verdict::UnknownEffect => Self::Unknown,
        }
    }
}

/// A size over the residual's noise, in words.
const fn size(size: f64) -> &'static str {
    if size > 2.0 { "over twice the noise" } else { "smaller" }
}

fn hidden(trial: &Trial) -> String {
    match &trial.case.kind {
        Kind::Null => "nothing".to_owned(),
        Kind::Glitch(_) => "a glitch of the reference".to_owned(),
        Kind::SmoothedGps(_) => "a filtered reference".to_owned(),
        Kind::Outside(_, over_noise) => format!("outside the catalogue, {}", size(*over_noise)),
        Kind::Effects(_) => match trial.truth.as_slice() {
            [] => "an effect that this flight does not excite".to_owned(),
            [(id, over_noise)] => {
                let family = id.split('.').next().unwrap_or(id);
                format!("one {family} effect, {}", size(*over_noise))
            }
            [(_, over_noise), ..] => format!("several effects, the strongest {}", size(*over_noise)),
        },
    }
}

/// The table: rows are the hidden causes, columns the answers.
#[must_use]
pub fn confusion(trials: &[Trial]) -> String {
    let mut counts: BTreeMap<String, BTreeMap<TrialAnswer, usize>> = BTreeMap::new();
    for trial in trials {
        *counts.entry(hidden(trial)).or_default().entry(TrialAnswer::of(trial)).or_default() += 1;
    }
    let mut text = format!("{:<50}", "hidden");
    for (_, name) in TrialAnswer::ALL {
        let _ = write!(text, " {name:>11}");
    }
    for (hidden, row) in counts {
        let _ = write!(text, "\n{hidden:<50}");
        for (said, _) in TrialAnswer::ALL {
            let count = row.get(&said).map_or_else(|| "-".to_owned(), usize::to_string);
            let _ = write!(text, " {count:>11}");
        }
    }
    text.push('\n');
    text
}
