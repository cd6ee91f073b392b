//! The results of the command line's commands, by the same functions.

use std::sync::Mutex;

use analysis::batch::{DiagnoseResult, batch};
use analysis::compare::{Comparison, Options, compare};
use analysis::diagnose::{NamedReplay, WantedEffect, diagnose_further};
use analysis::discover::{discover, id};
use analysis::learn::{Ladder, NamedFlight, Remembered, Request, add_remembering, ladder_by};
use kf_core::effect::Clock;
use model::Model;
use replay::{GivenTimes, Replay};
use serde::Serialize;
use time::{Date, Month};

use crate::engine::{Attachments, Engine, Progress, Refused, counting, given, parsed, refused, replay};
use crate::headline;
use crate::protocol::{
    AddRequest, Added, CompareRequest, Compared, DiagnoseRequest, Diagnosed, DiscoverRequest, Discovered,
    Exported, Exports, LadderRequest, ModelText, TimesByFlight,
};

/// How well a model agrees with a flight.
pub fn compared(
    engine: &Engine,
    request: &CompareRequest,
    progress: &mut Progress<'_>,
) -> Result<Compared, Refused> {
    let comparison = comparison(engine, request, progress)?;
    Ok(Compared { headline: headline::of_comparison(&comparison), comparison })
}

fn comparison(
    engine: &Engine,
    request: &CompareRequest,
    progress: &mut Progress<'_>,
) -> Result<Comparison, Refused> {
    let open = engine.flight(&request.flight)?;
    let replay = replay(open, &request.model, request.times)?;
    let rows = open.flight.rows() as u64;
    let mut flying = |done| progress("flying", done, rows);
    let (mut comparison, _) = compare(&replay, &Options::default(), &mut flying, engine.executor)
        .map_err(|error| refused(format!("{}: {error}", open.file)))?;
    comparison.flight.file.clone_from(&open.file);
    comparison.model.clone_from(&request.model.name);
    comparison.warnings.splice(0..0, open.notes.iter().map(ToString::to_string));
    Ok(comparison)
}

/// Which effect a model lacks.
pub fn diagnosed(
    engine: &mut Engine,
    request: &DiagnoseRequest,
    progress: &mut Progress<'_>,
) -> Result<Diagnosed, Refused> {
    let DiagnoseResult { together, one_by_one, .. } = results(engine, request, progress)?;
    let diagnosis = together.unwrap_or_default();
    Ok(Diagnosed { headline: headline::of_diagnosis(&diagnosis), diagnosis, batch: one_by_one })
}

fn results(
    engine: &mut Engine,
    request: &DiagnoseRequest,
    progress: &mut Progress<'_>,
) -> Result<DiagnoseResult, Refused> {
    if request.flights.is_empty() {
        return Err(refused("no flight to diagnose"));
    }
    let learned = to_diagnose(engine, &request.flights, &request.model, &request.times)?;
    let held = to_diagnose(engine, &request.hold_outs, &request.model, &request.times)?;
    let found = diagnose_further(&learned, &held, &mut counting("diagnosing", progress), engine.executor);
    let (mut together, further) = found.map_err(refused)?;
    let one_by_one = (learned.len() > 1).then(|| {
        let done = Mutex::new((0, progress));
        let step = || {
            if let Ok(mut done) = done.lock() {
                done.0 += 1;
                let (count, progress) = &mut *done;
                progress("diagnosing one by one", *count, learned.len() as u64);
            }
        };
        batch(&learned, Some(&together), &step, engine.executor)
    });
    together.model.clone_from(&request.model.name);
    let mut notes = Vec::new();
    for name in request.flights.iter().chain(&request.hold_outs) {
        let open = engine.flight(name)?;
        notes.extend(open.notes.iter().map(|note| format!("{}: {note}", open.file)));
    }
    // Planning the next flight and learning coefficients use these further results.
    if let Some(further) = further {
        engine.keep_further(engine.diagnosis_key(request)?, further);
    }
    together.warnings.splice(0..0, notes);
    Ok(DiagnoseResult { together: Some(together), failed: None, one_by_one })
}

/// Searches for laws that are not in the catalogue.
pub fn discovered(
    engine: &Engine,
    request: &DiscoverRequest,
    progress: &mut Progress<'_>,
) -> Result<Discovered, Refused> {
    if request.flights.is_empty() {
        return Err(refused("no flight to search"));
    }
    let learned = to_diagnose(engine, &request.flights, &request.model, &request.times)?;
    let held = to_diagnose(engine, &request.hold_outs, &request.model, &request.times)?;
    let found = discover(&learned, &held, &mut counting("searching for laws", progress), engine.executor);
    let mut discovery = found.map_err(refused)?;
    discovery.model.clone_from(&request.model.name);
    let mut notes = Vec::new();
    for name in request.flights.iter().chain(&request.hold_outs) {
        let open = engine.flight(name)?;
        notes.extend(open.notes.iter().map(|note| format!("{}: {note}", open.file)));
    }
    discovery.warnings.splice(0..0, notes);
    let ids = discovery.laws.iter().map(|law| id(law, &discovery.signals)).collect();
    Ok(Discovered { ids, why_none: headline::why_no_law(&discovery), discovery })
}

pub(crate) fn to_diagnose<'a>(
    engine: &'a Engine,
    names: &[String],
    model: &ModelText,
    times: &TimesByFlight,
) -> Result<Vec<NamedReplay<'a>>, Refused> {
    let model = parsed(model)?;
    let each = names.iter().map(|name| {
        let open = engine.flight(name)?;
        let replay = Replay::to_diagnose(&open.flight, &model, given_of(times, name))
            .map_err(|error| refused(format!("{}: {error}", open.file)))?;
        Ok(NamedReplay::new(open.file.clone(), replay))
    });
    each.collect()
}

/// The user's times for one flight.
fn given_of(times: &TimesByFlight, flight: &str) -> GivenTimes {
    given(times.get(flight).copied().unwrap_or_default())
}

fn named<'a>(
    engine: &'a Engine,
    names: &[String],
    times: &TimesByFlight,
) -> Result<Vec<NamedFlight<'a>>, Refused> {
    let each = names.iter().map(|name| {
        let open = engine.flight(name)?;
        Ok(NamedFlight { file: open.file.clone(), flight: &open.flight, given: given_of(times, name) })
    });
    each.collect()
}

/// Learns an effect and adds it to the model.
pub fn added(
    engine: &mut Engine,
    request: AddRequest,
    progress: &mut Progress<'_>,
) -> Result<Added, Refused> {
    let model = parsed(&request.model)?;
    let effect = model.effect_named(&request.effect).ok_or_else(|| {
        let nearest = model.nearest_effects(&request.effect);
        refused(format!("no effect '{}' in the catalogue or the model; nearest: {nearest}", request.effect))
    })?;
    let has_time = effect.has_time_constant();
    if !has_time && (request.time_constant_s.is_some() || request.since.is_some()) {
        return Err(refused(format!("{} has no time constant", request.effect)));
    }
    let since = match request.since.as_deref() {
        None => None,
        Some("launch") => Some(Clock::Launch),
        Some("start") => Some(Clock::Start),
        Some(other) => return Err(refused(format!("no clock '{other}', expected launch or start"))),
    };
    let time_constant_s = request.time_constant_s.map(|seconds| seconds as f32);
    if time_constant_s.is_some_and(|seconds| !(seconds.is_finite() && seconds > 0.0)) {
        return Err(refused("a time constant must be above 0 s"));
    }
    if request.flights.is_empty() {
        return Err(refused("no flight to learn from"));
    }
    let key = engine.diagnosis_key(&DiagnoseRequest {
        flights: request.flights.clone(),
        hold_outs: request.hold_outs.clone(),
        model: request.model.clone(),
        times: request.times.clone(),
    })?;
    let further = engine.further(&key);
    let engine = &*engine;
    let text = &request.model.text;
    let of = Request {
        text,
        wanted: WantedEffect { effect, time_constant_s, since },
        estimate: request.estimate,
        date: date(&request.date)?,
        learning: named(engine, &request.flights, &request.times)?,
        held_out: named(engine, &request.hold_outs, &request.times)?,
    };
    let mut scorer = |named: &NamedFlight<'_>, model: &Model| engine.scored(named, model);
    let remembered = Remembered { work: further.as_ref().map(|further| &further.work), scorer: &mut scorer };
    let addition = add_remembering(&of, remembered, &mut counting("learning", progress), engine.executor);
    let addition = addition.map_err(refused)?;
    let model = ModelText { name: request.model.name.clone(), text: addition.text.clone() };
    // The newest two revisions have already been flown for the addition.
    let flights: Vec<NamedFlight<'_>> = of.learning.iter().chain(&of.held_out).cloned().collect();
    let ladder = ladder_of(engine, &model, &flights, progress).ok();
    Ok(Added { headline: headline::of_addition(&addition), addition, model, ladder })
}

/// Parses a date such as 2026-01-31.
fn date(text: &str) -> Result<Date, Refused> {
    let parts: Vec<&str> = text.split('-').collect();
    let date = match parts.as_slice() {
        [year, month, day] => year.parse().ok().zip(month.parse::<u8>().ok()).zip(day.parse().ok()),
        _ => None,
    };
    let date = date.and_then(|((year, month), day)| {
        Date::from_calendar_date(year, Month::try_from(month).ok()?, day).ok()
    });
    date.ok_or_else(|| refused(format!("'{text}' is not a date, expected one such as 2026-01-31")))
}

/// Every revision of a model on every flight.
pub fn ladder(
    engine: &Engine,
    request: &LadderRequest,
    progress: &mut Progress<'_>,
) -> Result<Ladder, Refused> {
    let flights = named(engine, &request.flights, &request.times)?;
    ladder_of(engine, &request.model, &flights, progress)
}

fn ladder_of(
    engine: &Engine,
    of: &ModelText,
    flights: &[NamedFlight<'_>],
    progress: &mut Progress<'_>,
) -> Result<Ladder, Refused> {
    let model = parsed(of)?;
    let all = (model.revisions.len() as u64 + 1) * flights.len() as u64;
    let mut flying = |done| progress("flying", done, all);
    let mut scorer = |named: &NamedFlight<'_>, model: &Model| engine.scored(named, model);
    let mut ladder = ladder_by(&mut scorer, &model, flights, &mut flying).map_err(refused)?;
    ladder.model.clone_from(&of.name);
    Ok(ladder)
}

/// Exports a result as a file, with the answer.
pub fn exported(
    engine: &mut Engine,
    export: Exports,
    attachments: &mut Attachments,
    progress: &mut Progress<'_>,
) -> Result<Exported, Refused> {
    let (name, media) = match export {
        Exports::Compare(request) => {
            attachments.bytes = pretty(&comparison(engine, &request, progress)?)?;
            ("comparison.json", "application/json")
        }
        Exports::Diagnose(request) => {
            attachments.bytes = pretty(&results(engine, &request, progress)?)?;
            ("diagnosis.json", "application/json")
        }
        Exports::Ladder(request) => {
            attachments.bytes = pretty(&ladder(engine, &request, progress)?)?;
            ("ladder.json", "application/json")
        }
        Exports::Flight { flight } => {
            let open = engine.flight(&flight)?;
            flight_data::to_writer(&mut attachments.bytes, &open.flight).map_err(refused)?;
            ("flight.csv", "text/csv")
        }
    };
    Ok(Exported { name: name.to_owned(), media: media.to_owned() })
}

/// JSON as the command line prints it.
fn pretty(result: &impl Serialize) -> Result<Vec<u8>, Refused> {
    let mut json = serde_json::to_vec_pretty(result).map_err(refused)?;
    json.push(b'\n');
    Ok(json)
}
