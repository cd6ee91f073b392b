//! Everything that a report needs from its flights: [`analysis::survey`] run on the machine's threads.

use analysis::survey;
use model::Model;
use replay::{Replay, ReplayError};

use crate::compare::{Comparison, Options, Traces};
use crate::diagnose::NamedReplay;
use crate::learn::{Ladder, LadderError, NamedFlight, ladder_by};
use crate::threads::Threads;

/// Comparisons and scores of flights. Each flight's come from one pass over its ticks, which its diagnosis
/// shares.
#[derive(Debug)]
pub struct Survey<'a>(survey::Survey<'a>);

impl<'a> Survey<'a> {
    /// A survey of flights with a model and its earlier revisions.
    #[must_use]
    pub fn new(model: &Model) -> Self {
        Self(survey::Survey::new(model))
    }

    /// Compares a flight; `progress` is called with the number of rows done. See [`survey::Survey::compare`].
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

    /// Measures and scores a held-out flight.
    pub fn hold_out(&mut self, flight: &NamedFlight<'a>, model: &Model, diagnosed: &NamedReplay<'a>) {
        self.0.hold_out(flight, model, diagnosed, &Threads);
    }

    /// The ladder of a model on flights; flies those that the survey does not have yet. `progress` is called
    /// with the number of scores done.
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
