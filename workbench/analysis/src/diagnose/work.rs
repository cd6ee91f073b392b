//! From flights to a diagnosis: prepare, search, judge.

use executor::Executor;
use kf_core::sensor::Sensor;

use super::candidates::Candidate;
use super::diagnosis::{DiagnosedFlight, Diagnosis, Untested};
use super::epochs::Epochs;
use super::judge::{Findings, Judge};
use super::learning_problem::LearningProblem;
use super::named_replay::NamedReplay;
use super::noise::NoisePrior;
use super::prepare::Prepared;
use super::problem::Problem;
use super::search::{Explanation, Search};
use super::wanted_effect::WantedEffect;
use crate::progress::{Cancelled, Progress};
use replay::{Usage, barometer};

/// Finds what the model lacks; all replays have the same model. `progress` is called once a fit. What comes out is the same
/// whatever the executor.
///
/// # Errors
/// [`Cancelled`] when `progress` says so.
pub fn diagnose(
    flights: &[NamedReplay<'_>],
    hold_outs: &[NamedReplay<'_>],
    progress: &mut Progress<'_>,
    executor: &dyn Executor,
) -> Result<Diagnosis, Cancelled> {
    Ok(work(flights, hold_outs, None, progress, executor)?.0)
}

/// A diagnosis, and what one effect's coefficient is learned from, tried with these time constants if it has one
/// (none: the catalogue's grid).
pub(super) fn work(
    flights: &[NamedReplay<'_>],
    hold_outs: &[NamedReplay<'_>],
    wanted: Option<(WantedEffect, &[f32])>,
    progress: &mut Progress<'_>,
    executor: &dyn Executor,
) -> Result<(Diagnosis, Option<LearningProblem>), Cancelled> {
    let of = |judged: &mut Judged<'_, '_>, _: &mut Progress<'_>| {
        let findings = judged.findings.take().zip(wanted);
        Ok(findings
            .and_then(|(findings, (wanted, _))| judged.judge.problem(judged.search, findings, wanted.effect)))
    };
    let (diagnosis, problem) = judged(flights, hold_outs, wanted, progress, executor, of)?;
    Ok((diagnosis, problem.flatten()))
}

/// A diagnosis, and what it rests on.
pub(crate) struct Judged<'a, 'b> {
    pub(crate) judge: &'b Judge<'a>,
    pub(crate) prepared: &'b Prepared,
    search: &'b mut Search<'a>,
    /// There until they are taken.
    findings: Option<Findings>,
}

impl Judged<'_, '_> {
    /// What the verdicts rest on.
    pub(super) const fn findings(&self) -> Option<&Findings> {
        self.findings.as_ref()
    }

    /// The effects that explain the residuals, with the noise beside them.
    pub(crate) fn explanation(&self) -> Option<&Explanation> {
        self.findings.as_ref().map(|findings| &findings.explanation)
    }
}

/// A diagnosis, and what `then` makes of what it rests on (nothing without a flight).
pub(crate) fn judged<T>(
    flights: &[NamedReplay<'_>],
    hold_outs: &[NamedReplay<'_>],
    wanted: Option<(WantedEffect, &[f32])>,
    progress: &mut Progress<'_>,
    executor: &dyn Executor,
    then: impl FnOnce(&mut Judged<'_, '_>, &mut Progress<'_>) -> Result<T, Cancelled>,
) -> Result<(Diagnosis, Option<T>), Cancelled> {
    let Some(first) = flights.first() else { return Ok((Diagnosis::default(), None)) };
    let model = first.replay.model();
    let prepared = Prepared::new(flights, hold_outs, model, wanted, executor);
    let Prepared { candidates, epochs, .. } = &prepared;
    let mut prior = NoisePrior::new(&prepared.series, &model.reference, &model.sensors);
    if !prepared.has_climb_rate {
        prior = prior.with_slow_wander();
    }
    let problem = |series| Problem::new(series, prior.clone(), prepared.known.clone(), executor);
    let (problem, held) = (problem(&prepared.series), problem(&prepared.held));
    let suspects = prepared.suspects(&problem);
    let mut search = Search::new(&problem, &suspects);
    let explanation = if prepared.has_climb_rate { search.run(progress)? } else { search.start(progress)? };
    let judge = Judge {
        problem: &problem,
        held: (!prepared.held.is_empty()).then_some(&held),
        candidates,
        suspects: &suspects,
        epochs,
        has_climb_rate: prepared.has_climb_rate,
    };
    let (mut diagnosis, findings) = judge.verdicts(&mut search, explanation, progress)?;
    diagnosis.version = Diagnosis::VERSION;
    diagnosis.flights = flights.iter().zip(epochs).map(|(named, epochs)| facts(named, epochs)).collect();
    diagnosis.hold_outs = hold_outs.iter().map(|named| named.file.clone()).collect();
    diagnosis.untested = untested(candidates, flights, epochs);
    let findings = Some(findings);
    let mut judged = Judged { judge: &judge, prepared: &prepared, search: &mut search, findings };
    let made = then(&mut judged, progress)?;
    Ok((diagnosis, Some(made)))
}

fn facts(named: &NamedReplay<'_>, epochs: &Epochs) -> DiagnosedFlight {
    DiagnosedFlight {
        file: named.file.clone(),
        calibration: named.replay.source().to_string(),
        usage: Usage::of(&named.replay),
        blocks: epochs.series.len(),
        block_s: epochs.series.block_s,
        glitches: epochs.glitches.clone(),
        unreferenced_readings: epochs.unreferenced,
        refused_readings: epochs.refused,
        fault: barometer::check(named.replay.flight()).map(barometer::Fault::sentence),
    }
}

/// Why the effects on a UAV's inertial altitude are not tried where the flight computer makes that altitude itself: before the
/// launch it is no measurement beside the reference, and after it its error grows with the square of the time and more, where
/// every term of the noise that is fitted is stationary.
const MADE: &str = "the UAV's inertial altitude is made here from its accelerometer and gyro: until the launch it follows the \
    reference, and after it drifts without bound, so that its errors say nothing that the fitted noise could be told from";

/// Effects on sensors that the flights have, whose signals they have not; and those on an altitude that can not be judged.
fn untested(candidates: &[Candidate], flights: &[NamedReplay<'_>], epochs: &[Epochs]) -> Vec<Untested> {
    let is_made = flights.iter().any(|named| named.replay.makes_inertial_altitude());
    let mut untested: Vec<Untested> = Vec::new();
    for (column, candidate) in candidates.iter().enumerate() {
        let effect = candidate.effect();
        if untested.iter().any(|other| other.effect == effect.name()) {
            continue;
        }
        let has_sensor =
            candidate.sensor().is_none_or(|sensor| epochs.iter().any(|e| e.series.has(sensor.index())));
        if has_sensor && epochs.iter().any(|epochs| !epochs.available[column]) {
            let needs = effect.needs().iter().map(|column| (*column).into()).collect();
            untested.push(Untested { effect: effect.name().into(), needs, reason: None });
        } else if !has_sensor && is_made && candidate.sensor() == Some(Sensor::ImuSlave) {
            let reason = Some(MADE.to_owned());
            untested.push(Untested { effect: effect.name().into(), needs: Vec::new(), reason });
        }
    }
    untested
}
