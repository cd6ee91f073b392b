//! All that a report asks of its flights: [`analysis::survey`] with the machine's threads.

use analysis::survey;
use model::Model;
use replay::{Replay, ReplayError};

use crate::compare::{Comparison, Options, Traces};
use crate::diagnose::NamedReplay;
use crate::learn::{Ladder, LadderError, NamedFlight, ladder_by};
use crate::threads::Threads;

/// Comparisons and scores of flights, each from one pass over a flight's ticks, in which its diagnosis
/// measures as well.
#[derive(Debug)]
pub struct Survey<'a>(survey::Survey<'a>);

impl<'a> Survey<'a> {
    /// Of flights with a model and its earlier revisions.
    #[must_use]
    pub fn new(model: &Model) -> Self {
        Self(survey::Survey::new(model))
    }

    /// Compares a flight; `progress` is told how many rows are done. See [`survey::Survey::compare`].
    ///
    /// # Errors
    /// [`ReplayError`] for a model that no mission can be made of.
    pub fn compare(
        &mut self,
        flight: &NamedFlight<'a>,
        replay: &Replay<'a>,
        diagnosed: &NamedReplay<'a>,
        options: &Options,
        progress: &mut (dyn FnMut(u64) + Send),
    ) -> Result<(Comparison, Option<Box<Traces>>), ReplayError> {
        self.0.compare(flight, replay, diagnosed, options, progress, &Threads)
    }

    /// Looks at a flight that is held out.
    pub fn hold_out(&mut self, flight: &NamedFlight<'a>, model: &Model, diagnosed: &NamedReplay<'a>) {
        self.0.hold_out(flight, model, diagnosed, &Threads);
    }

    /// The ladder of a model on flights; flies what the survey does not know. `progress` is told how many
    /// scores are done.
    ///
    /// # Errors
    /// [`LadderError`], for the first flight that cannot be flown.
    pub fn ladder(
        &self,
        model: &Model,
        flights: &[NamedFlight<'_>],
        progress: &mut dyn FnMut(u64),
    ) -> Result<Ladder, LadderError> {
        ladder_by(&mut |flight, model| self.0.scores(flight, model), model, flights, progress)
    }
}
