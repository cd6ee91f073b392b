//! Advises what to fly to distinguish effects, or to see them at all: the manoeuvre that adds most to the
//! information matrix.

use std::sync::Arc;

use kf_core::effect::{EffectId, SignalTracker};
use kf_core::input::TickInput;
use kf_core::sensor::SENSORS;

use super::candidates::Candidate;
use super::formulas::Formulas;
use super::information::Information;
use super::manoeuvres::{MANOEUVRES, Manoeuvre, Trim};
use super::noise::Noise;
use super::problem::Problem;
use super::series::Series;

/// Length of a block, seconds.
pub const BLOCK_S: f64 = 0.5;

/// A manoeuvre and its worth.
#[derive(Clone, Debug, PartialEq)]
pub struct Advice {
    /// What to fly.
    pub manoeuvre: String,
    /// Separation of the two effects that are hardest to distinguish, or certainty of the effects that cannot
    /// be seen, after this manoeuvre: sigmas.
    pub sigmas: f64,
}

/// The manoeuvre that best distinguishes a set of effects; `sizes` are their fitted coefficients.
#[must_use]
pub fn to_separate(
    problem: &Problem<'_>,
    noise: &Noise,
    candidates: &[Candidate],
    set: &[usize],
    sizes: &[f64],
    trim: &Trim,
) -> Option<Advice> {
    best(problem, noise, candidates, set, trim, |information| {
        let mut least = f64::INFINITY;
        for (a, size) in sizes.iter().enumerate() {
            for b in (0..set.len()).filter(|b| *b != a) {
                least = least.min(apart(information, a, b, *size)?);
            }
        }
        Some(least.sqrt())
    })
}

/// The manoeuvre that best shows whether one effect acts; `size` is its fitted coefficient.
#[must_use]
pub fn to_show(
    problem: &Problem<'_>,
    noise: &Noise,
    candidates: &[Candidate],
    column: usize,
    size: f64,
    trim: &Trim,
) -> Option<Advice> {
    best(problem, noise, candidates, &[column], trim, |information| {
        Some(size.abs() / information.solve(&[0])?.covariance.first()?.sqrt())
    })
}

/// The manoeuvre that best shows the effects that a flight could not show.
#[must_use]
pub fn to_see(
    problem: &Problem<'_>,
    noise: &Noise,
    candidates: &[Candidate],
    unseen: &[usize],
    trim: &Trim,
) -> Option<Advice> {
    best(problem, noise, candidates, unseen, trim, |information| {
        let mut shown = 0.0;
        for (position, column) in unseen.iter().enumerate() {
            let plausible = candidates[*column].effect().plausible();
            let size = plausible.iter().fold(0.0_f64, |most, bound| most.max(f64::from(bound.abs())));
            let sigma =
                information.solve(&[position]).and_then(|one| one.covariance.first().map(|v| v.sqrt()));
            // An effect counts fully from five sigmas on.
            shown += sigma.map_or(0.0, |sigma| (size / sigma / 5.0).min(1.0));
        }
        Some(shown)
    })
}

/// Increase of the sum of squares with the wrong effect `b`, if the right effect `a` has the coefficient
/// `size`.
fn apart(information: &Information, a: usize, b: usize, size: f64) -> Option<f64> {
    let alone = information.solve(&[a])?;
    let left = 1.0 / alone.covariance.first()?;
    Some(size * size * left * (1.0 - information.shared(a, b, &[])?))
}

fn best(
    problem: &Problem<'_>,
    noise: &Noise,
    candidates: &[Candidate],
    set: &[usize],
    trim: &Trim,
    worth: impl Fn(&Information) -> Option<f64>,
) -> Option<Advice> {
    let mut best: Option<(f64, &Manoeuvre)> = None;
    for manoeuvre in &MANOEUVRES {
        let series = flown(&manoeuvre.fly(trim), candidates, set, problem);
        let planned =
            Problem::new(std::slice::from_ref(&series), problem.prior.clone(), Vec::new(), &executor::Inline);
        let picks: Vec<usize> = (0..set.len()).collect();
        let Some(worth) = worth(&planned.information(noise, &picks)) else { continue };
        if best.as_ref().is_none_or(|(most, _)| worth > *most) {
            best = Some((worth, manoeuvre));
        }
    }
    best.map(|(sigmas, manoeuvre)| Advice { manoeuvre: manoeuvre.describe(trim), sigmas })
}

/// A manoeuvre's blocks, with the columns of `set`; the residuals do not matter.
pub fn flown(ticks: &[TickInput], candidates: &[Candidate], set: &[usize], problem: &Problem<'_>) -> Series {
    let has: [bool; SENSORS] = std::array::from_fn(|i| problem.flights.iter().any(|flight| flight.has(i)));
    let mut tracker = SignalTracker::default();
    let mut columns = vec![Vec::new(); set.len()];
    let mut series = Series { block_s: BLOCK_S, full_block: [1.0; SENSORS], ..Series::default() };
    let mut formulas = Formulas::new(set.iter().filter_map(|pick| Some(candidates.get(*pick)?.regressor)));
    tracker.begin_calibration();
    formulas.begin_calibration();
    let mut launched = false;
    let mut next_s = 0.0;
    for input in ticks {
        if input.launch && !launched {
            launched = true;
            tracker.begin_free_flight(input.time_us);
        }
        tracker.take(input, input.gps.as_ref());
        formulas.take(input, input.gps.as_ref(), &tracker);
        let time_s = input.time_us as f64 * 1e-6;
        if time_s < next_s {
            continue;
        }
        next_s += BLOCK_S;
        series.time_s.push(time_s);
        series.fixes.push(1.0);
        series.free.push(launched);
        series.readings.push([1; SENSORS]);
        // The mother ship's own sensor does not fly free.
        series
            .residual_m
            .push(std::array::from_fn(|i| if has[i] && (i > 0 || !launched) { 0.0 } else { f64::NAN }));
        for (column, pick) in columns.iter_mut().zip(set) {
            let candidate = &candidates[*pick];
            let value = match candidate.effect() {
                EffectId::Defined(_) => formulas.value_m(candidate.regressor),
                _ => tracker.regressor_m(candidate.regressor),
            };
            let value = value.map_or(0.0, f64::from);
            column.push(std::array::from_fn(|i| match candidate.sensor() {
                None => -value,
                Some(sensor) if sensor.index() == i => value,
                Some(_) => 0.0,
            }));
        }
    }
    series.columns = columns.into_iter().map(Arc::new).collect();
    series
}
