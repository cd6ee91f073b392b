//! An engine: holds opened flights and answers requests about them.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::fmt::Display;
use std::ops::ControlFlow;
use std::rc::Rc;

use analysis::diagnose::Further;
use analysis::learn::{NamedFlight, Scores, flown};
use executor::Executor;
use flight_data::{Flight, Note};
use model::Model;
use replay::{CalibrationWindow, GivenAirborne, GivenTimes, Replay, ReplayError};
use serde::Serialize;
use thiserror::Error;

use crate::curve::Curve;
use crate::protocol::{Airborne, DiagnoseRequest, ModelText, Numbers, Request, Times, Window};
use crate::recording::Recording;
use crate::{catalogue, correlate, formula, opening, pairs, plan, results, ribbons, samples, series};

/// Recordings kept: before and after, for two flights.
const RECORDINGS: usize = 4;
/// Diagnoses whose work is kept: with the current model, and with the model before its newest revision.
const DIAGNOSES: usize = 2;
/// Scores kept: five revisions on forty flights.
const SCORES: usize = 200;
/// Curves kept: a curve made for one picture is needed again for the next when the picture is panned.
const CURVES: usize = 8;

/// Receives what is being done, the number of steps done and their total; 0 if the total is not known.
pub type Progress<'a> = dyn FnMut(&str, u64, u64) + Send + 'a;

/// Why a request has no answer: one line, for the user.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{0}")]
pub struct Refused(String);

/// Turns any error into a refusal.
pub(crate) fn refused(error: impl Display) -> Refused {
    Refused(error.to_string())
}

/// An answer.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Reply {
    /// `{"ok": ANSWER}` or `{"error": "one line"}`.
    pub json: String,
    /// The arrays that the answer refers to ([`Numbers`]).
    pub numbers: Vec<f64>,
    /// The bytes of a file.
    pub bytes: Vec<u8>,
}

/// The parts of an answer as it is assembled.
#[derive(Debug, Default)]
pub(crate) struct Attachments {
    numbers: Vec<f64>,
    pub(crate) bytes: Vec<u8>,
}

impl Attachments {
    /// Attaches an array to the answer.
    pub(crate) fn put(&mut self, values: impl IntoIterator<Item = f64>) -> Numbers {
        let start = self.numbers.len();
        self.numbers.extend(values);
        Numbers { start: start as u32, length: (self.numbers.len() - start) as u32 }
    }
}

/// An opened flight.
#[derive(Debug)]
pub(crate) struct OpenFlight {
    pub(crate) file: String,
    pub(crate) format: String,
    pub(crate) flight: Flight,
    pub(crate) notes: Vec<Note>,
    /// Serial number of this opening, because a name may be used again.
    number: u64,
}

/// Times in a form that compares bit for bit.
pub(crate) type TimesKey = (Option<[u64; 2]>, Option<[Option<u64>; 2]>);

pub(crate) fn times_key(Times { window, airborne }: Times) -> TimesKey {
    let bits = |end: Option<f64>| end.map(f64::to_bits);
    (
        window.map(|window| [window.start_s.to_bits(), window.end_s.to_bits()]),
        airborne.map(|airborne| [bits(airborne.take_off_s), bits(airborne.landing_s)]),
    )
}

type RecordingKey = (u64, String, TimesKey);

/// The key of a diagnosis: the flights learned from and the held-out ones, with their times, and the model.
pub(crate) type DiagnosisKey = (Vec<(u64, TimesKey)>, Vec<(u64, TimesKey)>, String);

type ScoresKey = (u64, GivenTimes, Model);

/// Opened flights, and the executor that works on them.
pub struct Engine {
    flights: BTreeMap<String, OpenFlight>,
    opened: u64,
    /// Kept recordings; the most recently used comes last.
    recordings: Vec<(RecordingKey, Rc<Recording>)>,
    /// Kept curves, in the same order.
    curves: Vec<((RecordingKey, String), Rc<Curve>)>,
    /// Further results of the last diagnoses, beyond their answers.
    further: Vec<(DiagnosisKey, Rc<Further>)>,
    /// Scores of models on flights.
    scores: RefCell<Vec<(ScoresKey, Rc<Scores>)>>,
    pub(crate) executor: &'static dyn Executor,
}

impl Engine {
    /// An engine without flights.
    #[must_use]
    pub fn new(executor: &'static dyn Executor) -> Self {
        Self {
            flights: BTreeMap::new(),
            opened: 0,
            recordings: Vec::new(),
            curves: Vec::new(),
            further: Vec::new(),
            scores: RefCell::new(Vec::new()),
            executor,
        }
    }

    /// Answers a request; `bytes` come with it.
    pub fn ask(&mut self, request: &[u8], bytes: &[u8], progress: &mut Progress<'_>) -> Reply {
        let mut attachments = Attachments::default();
        // Via a `Value`: a request identified by its tag loses numbers if a dependency makes `serde_json`
        // keep their digits.
        let json = serde_json::from_slice::<serde_json::Value>(request)
            .and_then(serde_json::from_value)
            .map_err(|error| refused(format!("invalid request: {error}")))
            .and_then(|request| self.answer(request, bytes, &mut attachments, progress));
        match json {
            Ok(json) => Reply {
                json: format!("{{\"ok\":{json}}}"),
                numbers: attachments.numbers,
                bytes: attachments.bytes,
            },
            Err(Refused(why)) => {
                Reply { json: serde_json::json!({ "error": why }).to_string(), ..Reply::default() }
            }
        }
    }

    fn answer(
        &mut self,
        request: Request,
        bytes: &[u8],
        attachments: &mut Attachments,
        progress: &mut Progress<'_>,
    ) -> Result<String, Refused> {
        match request {
            Request::Open(open) => {
                progress("reading", 0, 0);
                json(&opening::open(self, open, bytes)?)
            }
            Request::Samples(_) => json(&samples::list()),
            Request::OpenSample(open) => {
                progress("simulating", 0, 0);
                json(&samples::open(self, open)?)
            }
            Request::Flight(of) => json(&opening::opened(self.flight(&of.flight)?, of.times)?),
            Request::Close(close) => {
                let was_open = self.flights.remove(&close.flight).is_some();
                json(&crate::protocol::Closed { was_open })
            }
            Request::Presets(_) => json(&catalogue::presets()),
            Request::Model(of) => json(&catalogue::facts(&parsed(&of.model)?)),
            Request::Effects(_) => json(&catalogue::effects()),
            Request::Series(of) => json(&series::series(self, of, attachments, progress)?),
            Request::Ribbons(of) => json(&ribbons::ribbons(self, &of, attachments, progress)?),
            Request::Scatter(of) => json(&pairs::pairs(self, &of, attachments, progress)?),
            Request::Correlation(of) => json(&correlate::correlate(self, &of, attachments, progress)?),
            Request::Compare(of) => json(&results::compared(self, &of, progress)?),
            Request::Diagnose(of) => json(&results::diagnosed(self, &of, progress)?),
            Request::Plan(of) => json(&plan::planned(self, of, progress)?),
            Request::Formula(of) => json(&formula::checked(self, &of, attachments, progress)?),
            Request::Discover(of) => json(&results::discovered(self, &of, progress)?),
            Request::Add(of) => json(&results::added(self, of, progress)?),
            Request::Ladder(of) => json(&results::ladder(self, &of, progress)?),
            Request::Export(of) => json(&results::exported(self, of.export, attachments, progress)?),
        }
    }

    /// Keeps an opened flight under a name.
    pub(crate) fn keep(
        &mut self,
        name: String,
        file: String,
        format: String,
        (flight, notes): (Flight, Vec<Note>),
    ) -> &OpenFlight {
        self.opened += 1;
        let open = OpenFlight { file, format, flight, notes, number: self.opened };
        let slot = self.flights.entry(name);
        slot.insert_entry(open).into_mut()
    }

    /// Finds an opened flight.
    pub(crate) fn flight(&self, name: &str) -> Result<&OpenFlight, Refused> {
        self.flights.get(name).ok_or_else(|| refused(format!("flight '{name}' is not open")))
    }

    /// A mission over a flight, tick by tick.
    pub(crate) fn recording(
        &mut self,
        name: &str,
        model: &ModelText,
        times: Times,
        progress: &mut Progress<'_>,
    ) -> Result<Rc<Recording>, Refused> {
        let key = self.key(name, model, times)?;
        if let Some(found) = kept(&mut self.recordings, &key) {
            return Ok(found);
        }
        let recording = Recording::take(&replay(self.flight(name)?, model, times)?, progress)?;
        Ok(keep(&mut self.recordings, RECORDINGS, key, recording))
    }

    /// The curve that `make` returns, or a kept one for the same flight, model, times and name.
    pub(crate) fn curve(
        &mut self,
        (flight, model, times): (&str, &ModelText, Times),
        what: String,
        make: impl FnOnce(&mut Self) -> Result<Curve, Refused>,
    ) -> Result<Rc<Curve>, Refused> {
        let key = (self.key(flight, model, times)?, what);
        if let Some(found) = kept(&mut self.curves, &key) {
            return Ok(found);
        }
        let curve = make(self)?;
        Ok(keep(&mut self.curves, CURVES, key, curve))
    }

    /// The key under which a diagnosis is kept.
    pub(crate) fn diagnosis_key(&self, request: &DiagnoseRequest) -> Result<DiagnosisKey, Refused> {
        let of = |names: &[String]| {
            let key = |name: &String| {
                let times = request.times.get(name).copied().unwrap_or_default();
                Ok((self.flight(name)?.number, times_key(times)))
            };
            names.iter().map(key).collect::<Result<_, Refused>>()
        };
        Ok((of(&request.flights)?, of(&request.hold_outs)?, request.model.text.clone()))
    }

    /// Further results of a diagnosis, if it was one of the last.
    pub(crate) fn further(&mut self, key: &DiagnosisKey) -> Option<Rc<Further>> {
        kept(&mut self.further, key)
    }

    /// Keeps further results of a diagnosis.
    pub(crate) fn keep_further(&mut self, key: DiagnosisKey, further: Further) -> Rc<Further> {
        keep(&mut self.further, DIAGNOSES, key, further)
    }

    /// A model's scores on an open flight, flown only once.
    pub(crate) fn scored(&self, named: &NamedFlight<'_>, model: &Model) -> Result<Scores, ReplayError> {
        let open = self.flights.values().find(|open| std::ptr::eq(&raw const open.flight, named.flight));
        let Some(open) = open else { return flown(named, model) };
        // A model's revisions do not affect how it flies.
        let key = (open.number, named.given, Model { revisions: Vec::new(), ..model.clone() });
        if let Some(found) = kept(&mut self.scores.borrow_mut(), &key) {
            return Ok(Scores::clone(&found));
        }
        let scores = flown(named, model)?;
        keep(&mut self.scores.borrow_mut(), SCORES, key, scores.clone());
        Ok(scores)
    }

    fn key(&self, name: &str, model: &ModelText, times: Times) -> Result<RecordingKey, Refused> {
        Ok((self.flight(name)?.number, model.text.clone(), times_key(times)))
    }
}

/// The value kept under a key, which becomes the most recently used.
fn kept<K: PartialEq, T>(all: &mut Vec<(K, Rc<T>)>, key: &K) -> Option<Rc<T>> {
    let place = all.iter().position(|(other, _)| other == key)?;
    let found = all.remove(place);
    let value = Rc::clone(&found.1);
    all.push(found);
    Some(value)
}

/// Keeps a value; if there are too many, the least recently used is dropped.
fn keep<K, T>(all: &mut Vec<(K, Rc<T>)>, most: usize, key: K, value: T) -> Rc<T> {
    if all.len() >= most {
        all.remove(0);
    }
    let value = Rc::new(value);
    all.push((key, Rc::clone(&value)));
    value
}

/// An answer as JSON.
fn json(answer: &impl Serialize) -> Result<String, Refused> {
    serde_json::to_string(answer).map_err(refused)
}

/// Parses a model.
pub(crate) fn parsed(model: &ModelText) -> Result<Model, Refused> {
    Model::parse(&model.text).map_err(|error| refused(format!("{}: {error}", model.name)))
}

/// The user's times for a flight.
pub(crate) fn given(Times { window, airborne }: Times) -> GivenTimes {
    GivenTimes {
        calibration: window.map(|Window { start_s, end_s }| CalibrationWindow { start_s, end_s }),
        airborne: airborne.map(|Airborne { take_off_s, landing_s }| GivenAirborne { take_off_s, landing_s }),
    }
}

/// A flight ready to be flown by a model; refuses one that cannot be calibrated.
pub(crate) fn replay<'a>(
    open: &'a OpenFlight,
    model: &ModelText,
    times: Times,
) -> Result<Replay<'a>, Refused> {
    Replay::new(&open.flight, &parsed(model)?, given(times))
        .map_err(|error| refused(format!("{}: {error}", open.file)))
}

/// Progress of work with an unknown number of steps. Work is cancelled by ending the worker, so this never
/// stops it.
pub(crate) fn counting<'a>(
    what: &'static str,
    progress: &'a mut Progress<'_>,
) -> impl FnMut() -> ControlFlow<()> + 'a {
    let mut done = 0;
    move || {
        done += 1;
        progress(what, done, 0);
        ControlFlow::Continue(())
    }
}
