//! A diagnosis that ends in a lesson.

use executor::Executor;
use kf_core::effect::Regressor;

use super::diagnosis::Diagnosis;
use super::lesson::Lesson;
use super::named_replay::NamedReplay;
use super::wish::Wish;
use super::work::work;
use crate::progress::{Cancelled, Progress};

/// A diagnosis of flights with a model that lacks the effect, and what the effect's coefficient is to be
/// learned from; no lesson where the flights lack its signals ([`Diagnosis::untested`]) or its regressor
/// does not move in them.
///
/// # Errors
/// [`Cancelled`] when `progress` says so.
pub fn study(
    flights: &[NamedReplay<'_>],
    hold_outs: &[NamedReplay<'_>],
    wish: Wish,
    progress: &mut Progress<'_>,
    executor: &dyn Executor,
) -> Result<(Diagnosis, Option<Lesson>), Cancelled> {
    let wished: Vec<f32> = wish.time_constant_s.into_iter().collect();
    let coarse = work(flights, hold_outs, Some((wish, &wished)), progress, executor)?;
    let fitted = coarse.1.as_ref().and_then(|lesson| lesson.terms.first()).map(|term| term.regressor);
    match fitted.filter(|_| wished.is_empty() && wish.effect.has_time_constant()) {
        Some(Regressor { time_constant_s, since, .. }) => {
            let fine = FINER.map(|factor| factor * time_constant_s);
            let there = Wish { since: Some(since), ..wish };
            work(flights, hold_outs, Some((there, &fine)), progress, executor)
        }
        None => Ok(coarse),
    }
}

/// Time constants between those of the diagnosis' grid, as factors: a tenth apart an exponential differs by less than
/// a hundredth of its size.
const FINER: [f32; 11] = [0.57, 0.64, 0.72, 0.8, 0.9, 1.0, 1.1, 1.22, 1.36, 1.52, 1.7];
