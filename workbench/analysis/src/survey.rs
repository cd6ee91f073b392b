//! All that a report needs of a flight, from one pass over its ticks: the comparison, the scores of every
//! revision of the model, and what a diagnosis measures.

use executor::Executor;
use kf_core::output::TickOutput;
use model::Model;
use replay::{Observer, Replay, ReplayError};

use crate::compare::{Companions, Compared, Comparison, Options, Traces, compare_with};
use crate::diagnose::NamedReplay;
use crate::learn::{NamedFlight, ScoreTally, Scores, Scoring, flown, numbers};

/// The results of flights that were surveyed, and what a ladder needs of them.
#[derive(Debug)]
pub struct Survey<'a> {
    revisions: Vec<Model>,
    answers: Vec<Answer<'a>>,
}

/// A model's scores on a flight.
#[derive(Debug)]
struct Answer<'a> {
    flight: NamedFlight<'a>,
    revision: usize,
    scores: Scores,
}

/// Revisions that fly together with the model that is compared.
type Others = Vec<(usize, Scoring)>;

impl<'a> Survey<'a> {
    /// A survey of flights with a model and its earlier revisions.
    #[must_use]
    pub fn new(model: &Model) -> Self {
        Self {
            revisions: numbers(model).map(|number| model.at_revision(number)).collect(),
            answers: Vec::new(),
        }
    }

    /// Compares a flight. `replay` is its calibrated part and `diagnosed` the diagnosis' own; `progress`
    /// receives the number of rows done.
    ///
    /// A diagnosis that uses other ticks (without wild values, or of the whole of a flight that is calibrated
    /// in the air) makes its own pass over them.
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
        executor: &dyn Executor,
    ) -> Result<(Comparison, Option<Box<Traces>>), ReplayError> {
        let (own, mut others) = self.scorings(replay);
        let mut measured = measuring(diagnosed, replay);
        let mut tally = ScoreTally::default();
        let mut on_output = |output: &TickOutput| tally.take(output);
        let mut companions = Companions::default();
        if own.is_some() {
            companions.output = Some(&mut on_output);
        }
        companions.observers.extend(measured.iter_mut().map(|measured| -> &mut dyn Observer { measured }));
        companions.observers.extend(others.iter_mut().map(|(_, scoring)| -> &mut dyn Observer { scoring }));
        let compared = compare_with(replay, options, progress, companions, executor)?;
        let Compared { comparison, traces, summary } = compared;
        if let Some(revision) = own {
            let scores = tally.scores(summary.latch.as_ref());
            self.answers.push(Answer { flight: flight.clone(), revision, scores });
        }
        self.remember(flight, others);
        if let Some(measured) = measured {
            diagnosed.keep(measured, executor);
        }
        Ok((comparison, traces))
    }

    /// Processes a flight that is held out. One that cannot be flown is left to the ladder, which reports
    /// why.
    pub fn hold_out(
        &mut self,
        flight: &NamedFlight<'a>,
        model: &Model,
        diagnosed: &NamedReplay<'a>,
        executor: &dyn Executor,
    ) {
        let Ok(replay) = Replay::new(flight.flight, model, flight.given) else { return };
        let (own, mut scorings) = self.scorings(&replay);
        if let (Some(revision), Ok(scoring)) = (own, Scoring::new(replay.model())) {
            scorings.push((revision, scoring));
        }
        let mut measured = measuring(diagnosed, &replay);
        let mut observers: Vec<&mut dyn Observer> = Vec::new();
        observers.extend(measured.iter_mut().map(|measured| -> &mut dyn Observer { measured }));
        observers.extend(scorings.iter_mut().map(|(_, scoring)| -> &mut dyn Observer { scoring }));
        replay.pass(&mut observers, executor);
        self.remember(flight, scorings);
        if let Some(measured) = measured {
            diagnosed.keep(measured, executor);
        }
    }

    /// A model's scores on a flight: known ones, or new ones.
    ///
    /// # Errors
    /// As those of [`flown`].
    pub fn scores(&self, flight: &NamedFlight<'_>, model: &Model) -> Result<Scores, ReplayError> {
        let is_asked = |answer: &&Answer<'a>| {
            std::ptr::eq(answer.flight.flight, flight.flight)
                && answer.flight.given == flight.given
                && self.revisions.get(answer.revision) == Some(model)
        };
        match self.answers.iter().find(is_asked) {
            Some(answer) => Ok(answer.scores.clone()),
            None => flown(flight, model),
        }
    }

    /// Which revision the replay's own model is, and missions of the others that fly over the same ticks. One
    /// that cannot fly is left to the ladder.
    fn scorings(&self, replay: &Replay<'_>) -> (Option<usize>, Others) {
        let mut own = None;
        let mut others = Vec::new();
        for (revision, model) in self.revisions.iter().enumerate() {
            let Some(by_model) = replay.by_model(model) else { continue };
            if own.is_none() && by_model.model() == replay.model() {
                own = Some(revision);
            } else if let Ok(scoring) = Scoring::new(by_model.model()) {
                others.push((revision, scoring));
            }
        }
        (own, others)
    }

    fn remember(&mut self, flight: &NamedFlight<'a>, scorings: Others) {
        let answers = scorings.into_iter().map(|(revision, scoring)| Answer {
            flight: flight.clone(),
            revision,
            scores: scoring.scores(),
        });
        self.answers.extend(answers);
    }
}

/// What a diagnosis measures, if the pass has its ticks.
fn measuring(diagnosed: &NamedReplay<'_>, replay: &Replay<'_>) -> Option<crate::diagnose::Measured> {
    if replay.has_ticks_of(&diagnosed.replay) { diagnosed.measuring() } else { None }
}

#[cfg(test)]
mod tests {
    use std::fmt::Write as _;

    use executor::Inline;
    use flight_data::Flight;

    use super::*;
    use crate::compare::compare;
    use crate::diagnose::diagnose;

    /// Two minutes at 20 Hz, launched after one. `wild`: with a value that no aircraft has.
    fn flight(wild: bool) -> Flight {
        let mut csv =
            "# pylon-flight: 1\ntime_s,launch,gps_alt_m,gps_vn_mps,gps_ve_mps,gps_vd_mps,baro_alt_m\n"
                .to_owned();
        for k in 0..2400_u32 {
            let t = 0.05 * f64::from(k);
            let (gained_m, climb_mps) = (60.0 * (1.0 - (t / 9.0).cos()), 60.0 / 9.0 * (t / 9.0).sin());
            let fix = if k % 4 == 0 {
                format!("{:.3},30,0,{:.3}", 500.0 + gained_m, -climb_mps)
            } else {
                ",,,".into()
            };
            let rough = f64::from((k * 37) % 19) / 190.0;
            let leap_m = if wild && k == 1000 { 3000.0 } else { 0.0 };
            let baro_m = 503.0 + gained_m - 0.7 * climb_mps + rough + leap_m;
            let _ = writeln!(csv, "{t:.3},{},{fix},{baro_m:.3}", u8::from(k >= 1200));
        }
        flight_data::parse(csv.as_bytes()).unwrap().0
    }

    fn model() -> Model {
        let effect = "id = \"baro.lag\"\ncoefficient = 0.4\nsigma = 0.1\n";
        let revision = "number = 1\neffect = \"baro.lag\"\ncoefficient = 0.4\nsigma = 0.1\n";
        Model::parse(&format!("[[effect]]\n{effect}[[revision]]\n{revision}")).unwrap()
    }

    fn diagnosed(named: &NamedReplay<'_>) -> String {
        let mut progress = || std::ops::ControlFlow::Continue(());
        format!("{:?}", diagnose(std::slice::from_ref(named), &[], &mut progress, &Inline).unwrap())
    }

    #[test]
    fn a_survey_says_what_each_of_its_parts_says_alone() {
        let model = model();
        for wild in [false, true] {
            let flight = flight(wild);
            let replay = Replay::new(&flight, &model, None).unwrap();
            let to_diagnose =
                || NamedReplay::new("a".to_owned(), Replay::to_diagnose(&flight, &model, None).unwrap());
            let named = NamedFlight::new("a", &flight);
            let options = Options { trace_slots: Some(100), ..Options::default() };
            let mut survey = Survey::new(&model);
            let surveyed = to_diagnose();
            let found = survey.compare(&named, &replay, &surveyed, &options, &mut |_| (), &Inline).unwrap();
            let alone = compare(&replay, &options, &mut |_| (), &Inline).unwrap();
            assert_eq!(format!("{found:?}"), format!("{alone:?}"));
            // Both revisions are known: the first without the effect, the second with it.
            for number in numbers(&model) {
                let revision = model.at_revision(number);
                let known = survey
                    .answers
                    .iter()
                    .filter(|answer| survey.revisions.get(answer.revision) == Some(&revision));
                assert_eq!(known.count(), 1, "{number}");
                assert_eq!(
                    survey.scores(&named, &revision).unwrap(),
                    flown(&named, &revision).unwrap(),
                    "{number}"
                );
            }
            assert_ne!(
                survey.scores(&named, &model.at_revision(0)).unwrap(),
                survey.scores(&named, &model.at_revision(1)).unwrap()
            );
            // The flight computer gets the wild cell and the diagnosis does not, so the diagnosis measures by
            // itself.
            assert_eq!(surveyed.measuring().is_none(), !wild);
            assert_eq!(diagnosed(&surveyed), diagnosed(&to_diagnose()));

            let mut survey = Survey::new(&model);
            let held = to_diagnose();
            survey.hold_out(&named, &model, &held, &Inline);
            assert_eq!(survey.answers.len(), 2);
            for number in numbers(&model) {
                let revision = model.at_revision(number);
                assert_eq!(survey.scores(&named, &revision).unwrap(), flown(&named, &revision).unwrap());
            }
            assert_eq!(diagnosed(&held), diagnosed(&to_diagnose()));
        }
    }
}
