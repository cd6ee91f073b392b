//! A diagnosis that ends in a learning problem.

use executor::Executor;
use kf_core::effect::{Clock, EffectId, Regressor};

use super::diagnosis::Diagnosis;
use super::learning_problem::LearningProblem;
use super::low_pass::LowPassDelay;
use super::named_replay::NamedReplay;
use super::wanted_effect::{Tried, WantedEffect};
use super::work::{Doubtful, Work, judged};
use crate::progress::{Cancelled, Progress, step};

/// A diagnosis of flights with a model that lacks the effect, and what the effect's coefficient is to be
/// learned from. A time constant is refined between those of the diagnosis' grid, together with the effects
/// that the diagnosis found, and so is that of a delay which acts as a low pass, if the model defines one
/// ([`LowPassDelay`]). There is no problem where the flights lack its signals ([`Diagnosis::untested`])
/// or its regressor does not move in them.
///
/// # Errors
/// [`Cancelled`] when `progress` requests it.
pub fn study(
    flights: &[NamedReplay<'_>],
    hold_outs: &[NamedReplay<'_>],
    wanted: WantedEffect,
    progress: &mut Progress<'_>,
    executor: &dyn Executor,
) -> Result<(Diagnosis, Option<LearningProblem>), Cancelled> {
    study_remembering(None, flights, hold_outs, wanted, progress, executor)
}

/// As [`study`], without repeating what a diagnosis of the same flights and model has done.
///
/// # Errors
/// [`Cancelled`] when `progress` requests it.
pub fn study_remembering(
    work: Option<&Work>,
    flights: &[NamedReplay<'_>],
    hold_outs: &[NamedReplay<'_>],
    wanted: WantedEffect,
    progress: &mut Progress<'_>,
    executor: &dyn Executor,
) -> Result<(Diagnosis, Option<LearningProblem>), Cancelled> {
    let time_constants_s: Vec<f32> = wanted.time_constant_s.into_iter().collect();
    let tried = Tried { wanted, time_constants_s: &time_constants_s, others: None };
    let new;
    let work = match work.filter(|work| time_constants_s.is_empty() && work.serves(wanted)) {
        Some(work) => work,
        None => {
            let (diagnosis, made) = judged(
                flights,
                hold_outs,
                Some(tried),
                Doubtful::LeftOut,
                progress,
                executor,
                |_, _| Ok(()),
            )?;
            let Some(((), work)) = made else { return Ok((diagnosis, None)) };
            new = work;
            &new
        }
    };
    let diagnosis = work.diagnosis().clone();
    let Some(problem) = work.problem(wanted.effect, executor) else { return Ok((diagnosis, None)) };
    step(progress)?;
    let mut refined = |Regressor { id, time_constant_s, since }| {
        let finer = FINER.map(|factor| factor * time_constant_s);
        let tried = Tried {
            wanted: WantedEffect { effect: id, since: Some(since), ..wanted },
            time_constants_s: if time_constants_s.is_empty() { &finer } else { &time_constants_s },
            others: Some(&work.others(&problem)),
        };
        work.refined(flights, hold_outs, tried, progress, executor)
    };
    // A time constant that is asked for makes any delay a low pass.
    let low_pass_s = wanted.time_constant_s.map(f64::from).or(problem.low_pass_s);
    if let Some(regressor) = low_pass(flights, wanted.effect, low_pass_s) {
        return Ok((diagnosis, refined(regressor)?));
    }
    let fitted = problem.terms.first().map(|term| term.regressor);
    let finer = match fitted.filter(|_| time_constants_s.is_empty() && wanted.effect.has_time_constant()) {
        Some(regressor) => refined(regressor)?,
        None => None,
    };
    Ok((diagnosis, Some(finer.unwrap_or(problem))))
}

/// A delay with this time constant as the low pass that the flights' model defines.
fn low_pass(
    flights: &[NamedReplay<'_>],
    effect: EffectId,
    time_constant_s: Option<f64>,
) -> Option<Regressor> {
    let (delay, time_constant_s) = (LowPassDelay::of(effect)?, time_constant_s? as f32);
    let defined = flights.first()?.replay.model().definitions();
    let id = defined.iter().copied().find(|defined| delay.is(*defined))?;
    Some(Regressor { id, time_constant_s, since: Clock::Launch })
}

/// Time constants between those of the diagnosis' grid, as factors: between two a tenth apart, an exponential
/// differs by less than a hundredth of its size.
const FINER: [f32; 11] = [0.57, 0.64, 0.72, 0.8, 0.9, 1.0, 1.1, 1.22, 1.36, 1.52, 1.7];
