//! From flights to a diagnosis: what is prepared before the search, and who judges after it.

use kf_core::effect::EffectId;

use super::candidates::{Candidate, catalogue};
use super::diagnosis::{DiagnosedFlight, Diagnosis, Untested};
use super::epochs::{Epochs, epochs};
use super::judge::Judge;
use super::lesson::{Lesson, Wish};
use super::noise::NoisePrior;
use super::problem::{Known, Problem};
use super::roughness::is_rough;
use super::search::Search;
use super::series::Series;
use super::wind::wind;
use crate::replay::{Replay, Usage};

/// A flight ready to be replayed, and what the user calls it.
pub struct NamedReplay<'a> {
    /// The file.
    pub file: String,
    /// The flight, the model and the calibration.
    pub replay: Replay<'a>,
}

/// Finds what the model lacks; all replays have the same model. `progress` is called once a fit.
#[must_use]
pub fn diagnose(
    flights: &[NamedReplay<'_>],
    hold_outs: &[NamedReplay<'_>],
    progress: &mut dyn FnMut(),
) -> Diagnosis {
    work(flights, hold_outs, None, progress).0
}

/// A diagnosis, and what one effect's coefficient is learned from, tried with these time constants if it has one
/// (none: the catalogue's grid).
pub(super) fn work(
    flights: &[NamedReplay<'_>],
    hold_outs: &[NamedReplay<'_>],
    wish: Option<(Wish, &[f32])>,
    progress: &mut dyn FnMut(),
) -> (Diagnosis, Option<Lesson>) {
    let Some(first) = flights.first() else { return (Diagnosis::default(), None) };
    let model = first.replay.model();
    let mut candidates = catalogue();
    if let Some((wish, time_constants_s)) = wish {
        wish.narrow(&mut candidates, time_constants_s);
    }
    let known_ids: Vec<EffectId> = model.effects.iter().map(|effect| effect.term.regressor.id).collect();
    candidates.retain(|candidate| !known_ids.contains(&candidate.effect()));
    let tried = candidates.len();
    let mut known = Vec::new();
    for effect in model.effects.iter().filter(|effect| effect.term.sigma > 0.0) {
        known.push(Known { column: candidates.len(), sigma: f64::from(effect.term.sigma) });
        candidates.push(Candidate { regressor: effect.term.regressor, smoothing_s: 0.0 });
    }
    let prepare = |named: &NamedReplay<'_>| epochs(&named.replay, &candidates);
    let mut epochs: Vec<Epochs> = flights.iter().map(prepare).collect();
    let mut held: Vec<Epochs> = hold_outs.iter().map(prepare).collect();
    let wind = wind(&mut epochs, &mut held);
    let held: Vec<Series> = held.into_iter().map(|epochs| epochs.series).collect();
    let series: Vec<Series> = epochs.iter().map(|epochs| epochs.series.clone()).collect();

    let available = |column: usize| epochs.iter().all(|epochs| epochs.available[column]);
    known.retain(|known| available(known.column));
    known.extend(wind);
    let prior = NoisePrior::new(&series, &model.reference, &model.sensors);
    let problem = Problem::new(&series, prior.clone(), known.clone());
    let held_problem = Problem::new(&held, prior.clone(), known);
    let tried: Vec<usize> = (0..tried).filter(|column| available(*column)).collect();
    let first_look = problem.information(&prior.noise(&prior.means()), &tried);
    let usable: Vec<usize> = tried
        .iter()
        .enumerate()
        .filter(|(position, _)| first_look.is_excited(*position))
        .map(|(_, column)| *column)
        .collect();

    let mut column_noise_m2 = vec![0.0_f64; candidates.len()];
    for epochs in &epochs {
        for (most, noise_m2) in column_noise_m2.iter_mut().zip(&epochs.column_noise_m2) {
            *most = most.max(*noise_m2);
        }
    }
    let is_rough: Vec<bool> =
        candidates.iter().map(|candidate| is_rough(&epochs, candidate.effect())).collect();
    let mut search = Search::new(&problem, &candidates, usable, &column_noise_m2, &is_rough);
    let explanation = search.run(progress);
    let judge = Judge {
        problem: &problem,
        held: (!held.is_empty()).then_some(&held_problem),
        candidates: &candidates,
        epochs: &epochs,
    };
    let (mut diagnosis, findings) = judge.verdicts(&mut search, explanation, progress);
    diagnosis.flights = flights.iter().zip(&epochs).map(|(named, epochs)| facts(named, epochs)).collect();
    diagnosis.hold_outs = hold_outs.iter().map(|named| named.file.clone()).collect();
    diagnosis.untested = untested(&candidates, &epochs);
    let lesson = wish.and_then(|(wish, _)| judge.lesson(&mut search, findings, wish.effect));
    (diagnosis, lesson)
}

fn facts(named: &NamedReplay<'_>, epochs: &Epochs) -> DiagnosedFlight {
    DiagnosedFlight {
        file: named.file.clone(),
        calibration: named.replay.source().to_string(),
        usage: Usage::of(&named.replay),
        blocks: epochs.series.len(),
        block_s: epochs.series.block_s,
        glitches_s: epochs.glitches_s.clone(),
        unreferenced_readings: epochs.unreferenced,
    }
}

/// Effects on sensors that the flights have, whose signals they have not.
fn untested(candidates: &[Candidate], epochs: &[Epochs]) -> Vec<Untested> {
    let mut untested: Vec<Untested> = Vec::new();
    for (column, candidate) in candidates.iter().enumerate() {
        let has_sensor =
            candidate.sensor().is_none_or(|sensor| epochs.iter().any(|e| e.series.has(sensor.index())));
        let is_missing = epochs.iter().any(|epochs| !epochs.available[column]);
        let effect = candidate.effect();
        if has_sensor && is_missing && !untested.iter().any(|other| other.effect == effect.name()) {
            untested.push(Untested { effect: effect.name(), needs: effect.needs().to_vec() });
        }
    }
    untested
}
