//! Adds one effect to a model: learns it, flies before and after, and collects the evidence against it.

use std::collections::BTreeMap;

use kf_core::effect::{EffectTerm, Regressor};
use model::{Effect, Model};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use time::Date;

use super::add_error::AddError;
use super::concerns::{JudgedOn, concerns, doubts, undecided};
use super::document::{RevisionErrors, decimal, with_effect, with_low_pass, with_revision, without_effect};
use super::filter::learn;
use crate::name::Name;

use super::score::{Scorer, Scores, SensorScore, flown, pooled_rms_m};
use crate::diagnose::{
    HeldOutVerdict, LowPassDelay, NamedReplay, WantedEffect, Work, envelope_m, is_same_effect,
    study_remembering,
};
use crate::progress::{Progress, step};
use executor::Executor;
use flight_data::Flight;
use replay::{GivenTimes, Replay, ReplayError, missing_columns};

/// A flight and what the user specifies about it.
#[derive(Clone, Debug)]
pub struct NamedFlight<'a> {
    /// The user's name for it.
    pub file: String,
    /// The flight.
    pub flight: &'a Flight,
    /// Where to calibrate and when it was in the air, if the flight's own data should not decide.
    pub given: GivenTimes,
}

impl<'a> NamedFlight<'a> {
    /// A flight whose own data decide where it is calibrated and when it was in the air.
    #[must_use]
    pub fn new(file: impl Into<String>, flight: &'a Flight) -> Self {
        Self { file: file.into(), flight, given: GivenTimes::default() }
    }
}

/// What to add to which model.
#[derive(Clone, Debug)]
pub struct Request<'a> {
    /// The model file's text.
    pub text: &'a str,
    /// The wanted effect.
    pub wanted: WantedEffect,
    /// Whether the coefficient is to be a state of the filter; an effect that is already a state stays one.
    pub estimate: bool,
    /// The date of the revision.
    pub date: Date,
    /// Flights to learn from.
    pub learning: Vec<NamedFlight<'a>>,
    /// Flights to judge by.
    pub held_out: Vec<NamedFlight<'a>>,
}

/// A sensor on a flight without and with the effect.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct SensorChange {
    /// With the original model.
    pub before: SensorScore,
    /// With the new one.
    pub after: SensorScore,
}

/// A flight without and with the effect.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct FlightChange {
    /// The file.
    pub file: String,
    /// Every sensor by name.
    pub sensors: BTreeMap<Name, SensorChange>,
}

/// An effect added: the keys of `pylon add --json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Addition {
    /// Version of the keys' meaning. It increases where a key changes its meaning or is removed.
    pub version: u32,
    /// Its id.
    pub effect: Name,
    /// The catalogue's effect of which it is another form: a delay that acts as a low pass is written as one,
    /// by a definition in the model.
    pub instead_of: Option<Name>,
    /// The learned coefficient, as it was written.
    pub coefficient: f32,
    /// Its sigma.
    pub sigma: f32,
    /// Unit of both.
    pub unit: Name,
    /// Root mean square error of the sensors concerned before the addition, on the data named by `judged_on`,
    /// metres.
    pub rms_before_m: Option<f64>,
    /// The same after the addition, metres.
    pub rms_after_m: Option<f64>,
    /// The data to which these two and the verdict refer.
    pub judged_on: JudgedOn,
    /// The likelihood of the held-out data, which accounts for the wander. It decides, rather than the two
    /// errors.
    pub held_out_verdict: HeldOutVerdict,
    /// Root mean square error of the sensors concerned on the learning flights, before and after, metres.
    pub learning_rms_m: [Option<f64>; 2],
    /// The coefficient by the diagnosis' own fit, in double precision, and its sigma.
    pub diagnosed: [f64; 2],
    /// Time constant of its regressor, seconds, where it has one.
    pub time_constant_s: Option<f64>,
    /// When that regressor's clock starts.
    pub since: Option<Name>,
    /// The range of its regressor in the learning flights, metres per unit of coefficient.
    pub envelope_m: Option<[f32; 2]>,
    /// Whether it is a state of the filter.
    pub estimate: bool,
    /// The coefficient that it replaces.
    pub replaced_coefficient: Option<f32>,
    /// The revision's number.
    pub revision: u32,
    /// The learning flights, before and after.
    pub learning: Vec<FlightChange>,
    /// The held-out flights, before and after.
    pub held_out: Vec<FlightChange>,
    /// Evidence against it: nothing should be written unless the user insists.
    pub concerns: Vec<String>,
    /// What else the user should know.
    pub warnings: Vec<String>,
    /// The model's new text.
    #[serde(skip)]
    pub text: String,
}

impl Addition {
    /// The version that this program writes.
    pub const VERSION: u32 = 1;
}

/// What the caller kept from earlier work. It must be of the same flights and the same model as the
/// [`Request`]. The results do not change, they are only found sooner.
pub struct Remembered<'a> {
    /// The work of a diagnosis.
    pub work: Option<&'a Work>,
    /// Scores a model on a flight.
    pub scorer: &'a mut Scorer<'a>,
}

impl std::fmt::Debug for Remembered<'_> {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.debug_struct("Remembered").field("work", &self.work).finish_non_exhaustive()
    }
}

/// Learns an effect's coefficient and composes the model's new text; writes nothing.
///
/// # Errors
/// See [`AddError`].
pub fn add(
    request: &Request<'_>,
    progress: &mut Progress<'_>,
    executor: &dyn Executor,
) -> Result<Addition, AddError> {
    add_remembering(request, Remembered { work: None, scorer: &mut flown }, progress, executor)
}

/// As [`add`], without repeating earlier work.
///
/// # Errors
/// See [`AddError`].
pub fn add_remembering(
    request: &Request<'_>,
    remembered: Remembered<'_>,
    progress: &mut Progress<'_>,
    executor: &dyn Executor,
) -> Result<Addition, AddError> {
    // A delay that a model defines as a low pass is the catalogue's, in the shape that it has.
    let delay = LowPassDelay::of(request.wanted.effect);
    let id = delay.map_or(request.wanted.effect, |delay| delay.catalogues);
    let wanted = WantedEffect { effect: id, ..request.wanted };
    let before = Model::parse(request.text)?;
    let defining =
        delay.map_or_else(|| Ok(request.text.to_owned()), |delay| defining(request.text, delay))?;
    let old = before.effects.iter().find(|effect| is_same_effect(effect.term.id(), id)).cloned();
    for NamedFlight { file, flight, .. } in request.learning.iter().chain(&request.held_out) {
        let columns = missing_columns(flight, id);
        if !columns.is_empty() {
            return Err(AddError::Lacks { file: file.clone(), effect: id.name(), columns });
        }
    }

    let mut without = Model::parse(&defining)?;
    without.effects.retain(|effect| !is_same_effect(effect.term.id(), id));
    let flown = |flights| replays(flights, &without, Replay::calibrated_or_not);
    let (flown_learning, flown_held_out) = (flown(&request.learning)?, flown(&request.held_out)?);
    let not_flown = not_flown(flown_learning.iter().chain(&flown_held_out));
    let is_held_out_flown = flown_held_out.iter().all(|named| named.replay.is_calibrated());
    // What `pylon diagnose` found on a whole flight is learned from the whole flight.
    let learning = replays(&request.learning, &without, Replay::to_diagnose)?;
    let held_out = replays(&request.held_out, &without, Replay::to_diagnose)?;
    let work = remembered.work.filter(|_| old.is_none());
    let (diagnosis, problem) = study_remembering(work, &learning, &held_out, wanted, progress, executor)?;
    let files = || {
        let names: Vec<&str> = request.learning.iter().map(|named| named.file.as_str()).collect();
        names.join(", ")
    };
    let problem = problem.ok_or_else(|| AddError::NotExcited { effect: id.name(), files: files() })?;
    let learned = learn(&problem)?;
    let regressor = problem.terms.first().map_or_else(|| Regressor::new(id), |term| term.regressor);
    let text = if regressor.id == id { request.text } else { defining.as_str() };
    let other_form = old.as_ref().map(|old| old.term.id()).filter(|old| *old != regressor.id);
    let text = other_form.map_or_else(|| Ok(text.to_owned()), |old| without_effect(text, old.name()))?;

    // Digits beyond a hundredth of sigma are noise.
    let term = EffectTerm {
        regressor,
        coefficient: rounded(learned.coefficient, learned.sigma),
        sigma: rounded(learned.sigma, learned.sigma),
        envelope_m: envelope_m(learning.iter().map(|named| &named.replay), regressor),
    };
    let effect = Effect {
        term,
        estimate: request.estimate || old.as_ref().is_some_and(|old| old.estimate),
        learned_from: Some(files()),
        date: Some(request.date.to_string()),
    };
    let text = with_effect(&text, &effect, request.date)?;
    let after = Model::parse(&text)?;

    let mut changes = |flights: &[NamedFlight<'_>], flown: &[NamedReplay<'_>]| {
        changes(flights, flown, [&before, &after], remembered.scorer, progress)
    };
    let learning = changes(&request.learning, &flown_learning)?;
    let held_out = changes(&request.held_out, &flown_held_out)?;
    let rms = |flights: &[FlightChange]| -> [Option<f64>; 2] {
        [
            pooled_rms_m(&scores(flights, |change| change.before), id.subject()),
            pooled_rms_m(&scores(flights, |change| change.after), id.subject()),
        ]
    };
    let learning_rms_m = rms(&learning);
    let of_fit_m = [problem.facts.rms_before_m, problem.facts.rms_after_m];
    let (judged_on, judged_m, verdict) = match &problem.held_out {
        None => (JudgedOn::HeldOutManoeuvres, of_fit_m, HeldOutVerdict::on_stretches(&problem.folds)),
        Some(evidence) => {
            let judged_m = if is_held_out_flown { rms(&held_out) } else { of_fit_m };
            let verdict = HeldOutVerdict::on_flights(evidence, f64::from(term.coefficient));
            (JudgedOn::HeldOutFlights, judged_m, verdict)
        }
    };
    let replaced_coefficient = old.as_ref().map(|old| old.term.coefficient);
    let revision = before.next_revision();
    let errors = RevisionErrors { learning: learning_rms_m, held_out: judged_m };
    let text = with_revision(&text, revision, &effect, request.date, replaced_coefficient, &errors)?;
    // The new text must be a valid model, and this one.
    let warnings = Model::parse(&text)?.warnings();
    let concerns = concerns(&diagnosis, id, &effect, learned.sigma_to_zero, judged_on, judged_m, &verdict);
    let remarks = doubts(&diagnosis, id).into_iter().chain(undecided(judged_on, &verdict)).chain(not_flown);
    let has_time = regressor.id.has_time_constant();
    Ok(Addition {
        version: Addition::VERSION,
        effect: regressor.id.name().into(),
        instead_of: (regressor.id != id).then(|| id.name().into()),
        coefficient: term.coefficient,
        sigma: term.sigma,
        unit: id.unit().into(),
        rms_before_m: judged_m[0],
        rms_after_m: judged_m[1],
        judged_on,
        held_out_verdict: verdict,
        learning_rms_m,
        diagnosed: [problem.facts.coefficient, problem.facts.sigma],
        time_constant_s: has_time.then(|| decimal(regressor.time_constant_s)),
        since: has_time.then(|| regressor.since.name().into()),
        envelope_m: term.envelope_m,
        estimate: effect.estimate,
        replaced_coefficient,
        revision,
        learning,
        held_out,
        concerns,
        warnings: warnings.into_iter().chain(remarks).collect(),
        text,
    })
}

/// A model's text that also defines a delay as a low pass.
fn defining(text: &str, delay: LowPassDelay) -> Result<String, AddError> {
    let defining = with_low_pass(text, delay)?;
    // The one in the text may be the user's own, of another formula.
    let is_ours = Model::parse(&defining)?.definitions().iter().any(|id| delay.is(*id));
    is_ours
        .then_some(defining)
        .ok_or(AddError::DefinedOtherwise { id: delay.id, regressor: LowPassDelay::REGRESSOR })
}

/// A number rounded to a hundredth of the first digit of its sigma.
pub(super) fn rounded(value: f64, sigma: f64) -> f32 {
    let quantum = libm::pow(10.0, libm::log10(sigma).floor() - 2.0);
    let digits = -libm::log10(quantum).round();
    let rounded = if sigma > 0.0 && (0.0..=15.0).contains(&digits) {
        format!("{value:.0$}", digits as usize).parse().unwrap_or(value)
    } else {
        value
    };
    rounded as f32
}

/// How a replay is made from a flight.
type Making<'a> = fn(&'a Flight, &Model, GivenTimes) -> Result<Replay<'a>, ReplayError>;

/// The flights, ready to be replayed.
fn replays<'a>(
    flights: &[NamedFlight<'a>],
    model: &Model,
    make: Making<'a>,
) -> Result<Vec<NamedReplay<'a>>, AddError> {
    let named = flights.iter().map(|NamedFlight { file, flight, given }| {
        let replay =
            make(flight, model, *given).map_err(|error| AddError::Replay { file: file.clone(), error })?;
        Ok(NamedReplay::new(file.clone(), replay))
    });
    named.collect()
}

/// The flights over which no mission is flown.
fn not_flown<'a>(replays: impl Iterator<Item = &'a NamedReplay<'a>>) -> Vec<String> {
    let uncalibrated = replays.filter(|named| !named.replay.is_calibrated());
    uncalibrated
        .map(|named| {
            format!(
                "{}: no launch column and no quiet stretch to calibrate on, so its errors are relative to biases fitted \
                 to it and no mission was run on it; give a stretch with --calibrate START..END (seconds)",
                named.file
            )
        })
        .collect()
}

/// Scores of the two models on the flights that are calibrated.
fn changes(
    flights: &[NamedFlight<'_>],
    replays: &[NamedReplay<'_>],
    [before, after]: [&Model; 2],
    scorer: &mut Scorer<'_>,
    progress: &mut Progress<'_>,
) -> Result<Vec<FlightChange>, AddError> {
    let mut changes = Vec::new();
    for (named, _) in flights.iter().zip(replays).filter(|(_, replay)| replay.replay.is_calibrated()) {
        let failed = |error| AddError::Replay { file: named.file.clone(), error };
        let was = scorer(named, before).map_err(failed)?;
        step(progress)?;
        let is = scorer(named, after).map_err(failed)?;
        step(progress)?;
        let sensors = was.iter().filter_map(|(name, before)| {
            Some((name.clone(), SensorChange { before: *before, after: *is.get(name)? }))
        });
        changes.push(FlightChange { file: named.file.clone(), sensors: sensors.collect() });
    }
    Ok(changes)
}

fn scores(flights: &[FlightChange], side: impl Fn(&SensorChange) -> SensorScore) -> Vec<Scores> {
    let of = |flight: &FlightChange| {
        flight.sensors.iter().map(|(name, change)| (name.clone(), side(change))).collect::<Scores>()
    };
    flights.iter().map(of).collect()
}
