//! From flights to laws: diagnose, screen, fit, weigh.

use executor::Executor;
use kf_core::sensor::Sensor;

use super::discovery::Discovery;
use super::fit::{Bench, Fitted};
use super::judge::judge;
use super::screen::{Screen, Subject};
use super::search::{Scored, Search};
use super::signals::Signals;
use crate::diagnose::NamedReplay;
use crate::diagnose::parts::{Doubtful, Judged, NoiseFit, judged};
use crate::name::Name;
use crate::progress::{Cancelled, Progress, step};

/// Number of laws whose noise is fitted, for each noise that laws are screened with.
const FIRST_FITS: usize = 5;
/// Number of laws whose noise is fitted under the best law's noise.
const LAST_FITS: usize = 14;

/// Searches for laws; all replays have the same model. `progress` is called once for each step. The result
/// does not depend on the executor.
///
/// # Errors
/// [`Cancelled`] when `progress` requests it.
pub fn discover(
    flights: &[NamedReplay<'_>],
    hold_outs: &[NamedReplay<'_>],
    progress: &mut Progress<'_>,
    executor: &dyn Executor,
) -> Result<Discovery, Cancelled> {
    let then = |judged: &Judged<'_, '_>, progress: &mut Progress<'_>| laws(judged, progress, executor);
    let (diagnosis, found) = judged(flights, hold_outs, None, Doubtful::Kept, progress, executor, then)?;
    let mut discovery = found.map(|(discovery, _)| discovery).unwrap_or_default();
    discovery.version = Discovery::VERSION;
    discovery.verdict = diagnosis.verdict;
    let files = |named: &[NamedReplay<'_>]| named.iter().map(|named| named.file.clone()).collect();
    (discovery.flights, discovery.hold_outs) = (files(flights), files(hold_outs));
    Ok(discovery)
}

fn laws(
    judged: &Judged<'_, '_>,
    progress: &mut Progress<'_>,
    executor: &dyn Executor,
) -> Result<Discovery, Cancelled> {
    let (prepared, problem) = (judged.prepared, judged.judge.problem);
    let explanation = judged.explanation();
    let learned: Vec<_> =
        prepared.epochs.iter().map(|epochs| (&epochs.series, epochs.signals.as_slice())).collect();
    let held: Vec<_> =
        prepared.held.iter().zip(&prepared.held_signals).map(|(s, m)| (s, m.as_slice())).collect();
    let names = prepared.epochs.first().map(|epochs| epochs.signal_names.clone()).unwrap_or_default();
    let signals = Signals::new(&learned, &names, &held);
    let subjects = subjects(problem.flights);
    let search = Search { signals: &signals, flights: learned.len(), subjects: subjects.len(), executor };
    let judge_of = judged.judge;
    let (held, suspects) = (judge_of.held, judge_of.suspects);
    let trim = judge_of.trim();
    let bench = Bench { problem, held, prepared, suspects, search: &search, explanation, trim };
    let mut discovery = Discovery {
        signals: signals.signals.iter().map(|signal| signal.name.name.clone()).collect(),
        without_unit: signals.without_unit.clone(),
        unnamed: signals.unnamed.clone(),
        none: 1.0,
        ..Discovery::default()
    };
    let effect = |column: &usize| prepared.candidates.get(*column).map(|c| Name::from(c.effect().name()));
    discovery.catalogue = explanation.columns.iter().filter_map(effect).collect();
    if signals.signals.is_empty() {
        return Ok(discovery);
    }

    let start = problem.prior.means();
    let prior = NoiseFit {
        noise: problem.prior.noise(&start),
        values: start,
        twice_log_posterior: f64::NEG_INFINITY,
    };
    let mut fitted: Vec<Fitted> = Vec::new();
    let add =
        |law: &Scored, subject: Subject, beside: &[usize], near: &NoiseFit, fitted: &mut Vec<Fitted>| {
            let is_new = fitted
                .iter()
                .all(|one: &Fitted| one.law != law.law || one.subject != subject || one.beside != beside);
            if is_new {
                fitted.extend(bench.fit(&law.law, subject, beside, near));
            }
        };
    for subject in &subjects {
        for beside in bench.variants(*subject) {
            // Under the null's noise a slow law looks like wander; under the prior's noise it stands out.
            for near in [&explanation.fit, &prior] {
                let screen = Screen::new(problem, near.noise, &beside, *subject);
                let found = search.run(&screen, 4 * FIRST_FITS, progress)?;
                discovery.scored += found.scored;
                for law in bench.different(&found.laws, FIRST_FITS) {
                    add(&law, *subject, &beside, near, &mut fitted);
                    step(progress)?;
                }
            }
        }
    }
    // Under the best law's own noise, similar laws get their right order.
    for _ in 0..2 {
        let Some(best) = fitted.iter().max_by(|a, b| a.merit().total_cmp(&b.merit())).cloned() else { break };
        if best.merit() < 0.0 {
            break;
        }
        let screen = Screen::new(problem, best.fit.noise, &best.beside, best.subject);
        let found = search.run(&screen, 4 * LAST_FITS, progress)?;
        discovery.scored += found.scored;
        // Laws with more parts than pay here fitted only under another noise.
        let (subject, parts) = (best.subject, found.parts);
        fitted.retain(|one| one.subject != subject || one.law.parts() <= parts);
        let before = fitted.len();
        for law in bench.different_by_parts(&found.laws, LAST_FITS) {
            add(&law, best.subject, &best.beside, &best.fit, &mut fitted);
            step(progress)?;
        }
        if fitted.len() == before {
            break;
        }
    }
    discovery.fitted = fitted.len() as u64;
    judge(&bench, fitted, &mut discovery, progress)?;
    Ok(discovery)
}

/// What a law may act on: the sensors in free flight, and the reference if there are two of them.
fn subjects(flights: &[crate::diagnose::parts::Series]) -> Vec<Subject> {
    let free = Sensor::ALL.into_iter().filter(|sensor| {
        sensor.flies_free()
            && flights.iter().any(|flight| {
                flight
                    .residual_m
                    .iter()
                    .zip(&flight.free)
                    .any(|(m, free)| *free && m[sensor.index()].is_finite())
            })
    });
    let mut subjects: Vec<Subject> = free.map(|sensor| Subject::Sensor(sensor.index())).collect();
    if subjects.len() > 1 {
        subjects.push(Subject::Reference);
    }
    subjects
}
