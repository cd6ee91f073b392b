//! Every revision of a model on every flight.

use model::Model;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::addition::NamedFlight;
use super::score::{Scorer, Scores, flown};
use crate::name::Name;
use replay::ReplayError;

/// The keys of `pylon ladder --json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Ladder {
    /// Version of the keys' meaning. It increases where a key changes its meaning or is removed.
    pub version: u32,
    /// The model's name.
    pub model: String,
    /// Its revisions, oldest first; the first is before all of them.
    pub revisions: Vec<LadderRevision>,
}

impl Ladder {
    /// The version that this program writes.
    pub const VERSION: u32 = 1;
}

/// One revision.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct LadderRevision {
    /// Its number; 0 is before all revisions.
    pub number: u32,
    /// The effect that it added or learned again.
    pub effect: Option<Name>,
    /// The day.
    pub date: Option<String>,
    /// The effects of the model at this revision.
    pub effects: Vec<Name>,
    /// Every flight.
    pub flights: Vec<RevisionFlight>,
}

/// One flight with one revision.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct RevisionFlight {
    /// The file.
    pub file: String,
    /// Every sensor by name.
    pub sensors: Scores,
}

/// A flight that cannot be flown.
#[derive(Debug, Error)]
#[error("{file}: {reason}")]
pub struct LadderError {
    /// The file.
    pub file: String,
    /// Why not.
    #[source]
    pub reason: ReplayError,
}

/// The revisions of a model's ladder, oldest first; 0 is before all of them.
pub(crate) fn numbers(model: &Model) -> impl Iterator<Item = u32> {
    std::iter::once(0).chain(model.revision_numbers().into_iter().filter(|number| *number > 0))
}

/// Flies every revision of a model over every flight; `progress` receives the number of runs done.
///
/// # Errors
/// [`LadderError`], for the first flight that cannot be flown.
pub fn ladder(
    model: &Model,
    flights: &[NamedFlight<'_>],
    progress: &mut dyn FnMut(u64),
) -> Result<Ladder, LadderError> {
    ladder_by(&mut flown, model, flights, progress)
}

/// As [`ladder`], with the given scores.
///
/// # Errors
/// [`LadderError`], for the first flight that cannot be flown.
pub fn ladder_by(
    scorer: &mut Scorer<'_>,
    model: &Model,
    flights: &[NamedFlight<'_>],
    progress: &mut dyn FnMut(u64),
) -> Result<Ladder, LadderError> {
    let mut revisions = Vec::new();
    let mut done = 0;
    for number in numbers(model) {
        let left = model.at_revision(number);
        let mut at_revision = Vec::new();
        for named in flights {
            let file = || named.file.clone();
            let sensors = scorer(named, &left).map_err(|reason| LadderError { file: file(), reason })?;
            at_revision.push(RevisionFlight { file: file(), sensors });
            done += 1;
            progress(done);
        }
        let revision = model.revisions.iter().find(|revision| revision.number == number && number > 0);
        revisions.push(LadderRevision {
            number,
            effect: revision.and_then(|revision| revision.effect).map(|effect| effect.name().into()),
            date: revision.and_then(|revision| revision.date.clone()),
            effects: left.effects.iter().map(|effect| effect.term.id().name().into()).collect(),
            flights: at_revision,
        });
    }
    Ok(Ladder { version: Ladder::VERSION, model: String::new(), revisions })
}
