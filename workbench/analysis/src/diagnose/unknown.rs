//! What nothing in the catalogue explains: signals that the remainder follows, and wander that exists only in
//! free flight.

use kf_core::sensor::Sensor;

use super::diagnosis::Follows;
use super::epochs::Epochs;
use super::information::{Information, own_coefficients};
use super::problem::{NoiseFit, Problem};
use super::unknown_columns::{Extra, LAGS_S, PLAYS_M, Shape, Test, Times, extra_columns, spread};
use super::whitener::whiten;

/// Gain in twice the log likelihood that a signal needs beyond the best of as many by chance: more than an
/// effect of the catalogue, which physics supports.
const EVIDENCE: f64 = 16.0;
/// In addition, this share of what the effects found explain: their formulas are not more accurate than that.
pub const SHAPE: f64 = 0.05;
/// A signal that replaces the chosen effects is better than they are where its remainder is smaller by this
/// share of what they explain: as much as a right formula of measured signals may miss (as in `search`).
pub const BETTER: f64 = 0.02;
/// A signal's shape that shares this much with a candidate of the catalogue belongs to that candidate.
const IN_CATALOGUE: f64 = 0.9;
/// Number of columns that are tested in one pass.
const CHUNK: usize = 12;
/// White noise that is this many times larger in free flight than under the mother ship is not noise.
const WHITE_FACTOR: f64 = 3.0;
/// Free-flight factors below this do not matter to a user ...
const FACTOR: f64 = 1.6;
/// ... and below this gain in twice the log posterior they are not certain.
const FACTOR_EVIDENCE: f64 = 14.0;

/// Jumps are looked for where the innovation is largest: at this many blocks of a flight.
const JUMPS: usize = 12;

/// The same where the climb rate is not measured: lags are then fitted as pure delays, whose shape differs
/// from a low pass by about 15 %, which is 28 % of the squares.
pub const SHAPE_WITHOUT_CLIMB_RATE: f64 = 0.28;

/// Reasons not to attribute a remainder to a sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Doubts {
    /// No other sensor is in free flight: a jump may be the receiver's, whose satellites changed.
    pub is_alone: bool,
    /// The climb rate is measured.
    pub has_climb_rate: bool,
}

/// What the tests found on one sensor.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Unexplained {
    /// Signals that the remainder follows, the closest first.
    pub follows: Vec<Follows>,
    /// Whether one of these alone explains more than all effects chosen on the sensor together.
    pub is_better: bool,
}

/// Tests every signal and every jump time on one sensor's residual. `own` are the candidates on that sensor,
/// `explained` what the effects chosen on it explain (squares).
#[expect(clippy::too_many_arguments, reason = "one question about one sensor")]
pub fn unexplained(
    problem: &Problem<'_>,
    epochs: &[Epochs],
    fit: &NoiseFit,
    chosen: &[usize],
    own: &[usize],
    explained: f64,
    sensor: usize,
    doubts: Doubts,
) -> Unexplained {
    let mut tests = tests(problem, epochs, fit, chosen, sensor);
    if doubts.is_alone {
        tests.retain(|test| !matches!(test, Test::Jump { .. }));
    }
    for jump in known_jumps(epochs, sensor) {
        if !tests.contains(&jump) {
            tests.push(jump);
        }
    }
    let [shape, better] = if doubts.has_climb_rate { [SHAPE, BETTER] } else { [SHAPE_WITHOUT_CLIMB_RATE; 2] };
    let chance = 2.0 * libm::log(tests.len().max(1) as f64) + EVIDENCE;
    let bar = chance.max(shape * explained);
    let all: Vec<usize> = (0..chosen.len()).collect();
    let others: Vec<usize> = all.iter().copied().filter(|k| !own.contains(&chosen[*k])).collect();
    let mut found = Unexplained::default();
    for chunk in tests.chunks(CHUNK) {
        let columns = extra_columns(epochs, chunk, sensor);
        let information = information(problem, fit, chosen, &columns);
        let rest = |picks: &[usize]| information.solve(picks).map(|solution| solution.rest);
        let Some(with_all) = rest(&all) else { continue };
        let mut k = 0;
        for test in chunk {
            let first = k;
            k += test.width();
            let at = chosen.len() + first..chosen.len() + k;
            let beside: Vec<usize> = all.iter().copied().chain(at.clone()).collect();
            let Some(solution) = information.solve(&beside) else { continue };
            let evidence = with_all - solution.rest;
            let instead: Vec<usize> = others.iter().copied().chain(at).collect();
            let margin = chance.max(better * explained);
            let is_better =
                others.len() < all.len() && rest(&instead).is_some_and(|rest| with_all - rest > margin);
            let is_beside = evidence > bar && !is_in_catalogue(problem, fit, chosen, own, &columns, first);
            if is_better || is_beside {
                let coefficient: f64 = solution.coefficients[all.len()..].iter().sum();
                found.is_better |= is_better;
                let (signal, lag_s) = test.describe(epochs);
                let size_m = coefficient.abs() * spread(&columns, first);
                found.follows.push(Follows { signal, lag_s, size_m, evidence });
            }
        }
    }
    found.follows.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
    found.follows.truncate(5);
    found
}

/// Every function of every signal, on an inertial altitude also every signal's integrals, and a jump where the
/// sensor's innovations are largest.
fn tests(
    problem: &Problem<'_>,
    epochs: &[Epochs],
    fit: &NoiseFit,
    chosen: &[usize],
    sensor: usize,
) -> Vec<Test> {
    let signals = epochs.first().map_or(0, |first| first.signal_names.len());
    let mut tests = Vec::new();
    for signal in 0..signals {
        // An inertial altitude integrates the errors of its velocity and of its acceleration.
        if sensor == Sensor::ImuSlave.index() {
            tests.extend(Times::ALL.map(|times| Test::Integral { signal, times }));
        }
        for shape in Shape::ALL {
            for lag_s in LAGS_S {
                // The rate is the difference from a low pass, so it has a lag of its own.
                if shape != Shape::Rate || lag_s > 0.0 {
                    tests.push(Test::Signal { signal, shape, lag_s });
                }
            }
        }
    }
    tests.extend(PLAYS_M.map(|half_width_m| Test::Play { half_width_m }));
    for (flight, (series, epochs)) in problem.flights.iter().zip(epochs).enumerate() {
        let first = epochs.series.free.iter().position(|free| *free).unwrap_or(0);
        let mut largest: Vec<(f64, usize)> = Vec::new();
        let innovations = residual_innovations(problem, flight, fit, chosen);
        for (block, of_sensor, value) in innovations {
            // A jump at launch is an effect of the catalogue.
            if of_sensor == sensor && block > first + 2 && block + 3 < series.len() {
                largest.push((value.abs(), block));
            }
        }
        largest.sort_by(|a, b| b.0.total_cmp(&a.0));
        largest.truncate(JUMPS);
        tests.extend(largest.into_iter().map(|(_, block)| Test::Jump { flight, block }));
    }
    tests
}

/// The lasting steps that the sensor's own readings show: they are the sensor's, whether or not another one
/// flies with it, and may come before the launch.
fn known_jumps(epochs: &[Epochs], sensor: usize) -> Vec<Test> {
    let mut jumps = Vec::new();
    for (flight, epochs) in epochs.iter().enumerate() {
        let series = &epochs.series;
        let (Some(first_s), Some(last_s)) = (series.time_s.first(), series.time_s.last()) else { continue };
        let half_s = 0.5 * series.block_s;
        let own = epochs.steps.iter().filter(|(of, _)| of.index() == sensor);
        for (_, step_s) in own.filter(|(_, step_s)| (*first_s..=*last_s).contains(step_s)) {
            // A block's time is that of its middle.
            let block = series.time_s.partition_point(|time_s| time_s + half_s <= *step_s);
            jumps.push(Test::Jump { flight, block });
        }
    }
    jumps
}

/// Whitened residuals of a flight after the chosen effects: block, sensor, value.
fn residual_innovations(
    problem: &Problem<'_>,
    flight: usize,
    fit: &NoiseFit,
    chosen: &[usize],
) -> Vec<(usize, usize, f64)> {
    let Some(series) = problem.flights.get(flight) else { return Vec::new() };
    let columns = problem.columns(series, chosen);
    let information = problem.information(&fit.noise, chosen);
    let all: Vec<usize> = (0..chosen.len()).collect();
    let common = information.solve(&all).map(|solution| solution.coefficients).unwrap_or_default();
    let one = problem.products(series, &fit.noise, &columns, &|_| true);
    let own = own_coefficients(&one.products, problem.own(), &common);
    let mut innovations = Vec::new();
    whiten(series, &fit.noise, &columns, &|_| true, &mut |block, sensor, row| {
        let explained: f64 =
            own.iter().chain(&common).zip(&row[1..]).map(|(value, column)| value * column).sum();
        innovations.push((block, sensor, row[0] - explained));
    });
    innovations
}

/// Gain in twice the log posterior from letting a sensor's noise be larger in free flight, if it is so much
/// larger that something unexplained must act. `explained_white_m2` is the white noise that the regressors of
/// the effects found add.
pub fn free_flight_excess(
    problem: &Problem<'_>,
    fit: &NoiseFit,
    chosen: &[usize],
    sensor: usize,
    explained_white_m2: f64,
) -> Option<f64> {
    let noise = &fit.noise.sensors[sensor];
    let white_m2 = (noise.free_white_m * noise.free_white_m - explained_white_m2).max(0.0);
    let is_white = white_m2 > (WHITE_FACTOR * noise.captive_white_m) * (WHITE_FACTOR * noise.captive_white_m);
    let held = match (noise.free_flight_factor > FACTOR, is_white) {
        (_, true) => problem.prior.with_steady_white(sensor)?,
        (true, false) => problem.prior.with_steady_wander(sensor)?,
        (false, false) => return None,
    };
    let gain = fit.twice_log_posterior - problem.fit_noise(&held, chosen, &fit.values).twice_log_posterior;
    (gain > FACTOR_EVIDENCE).then_some(gain)
}

fn information(problem: &Problem<'_>, fit: &NoiseFit, picks: &[usize], extra: &Extra) -> Information {
    let extras = extra.first().map_or(0, Vec::len);
    let mut information = Information::new(1 + picks.len() + extras);
    for (flight, extra) in problem.flights.iter().zip(extra) {
        let mut columns = problem.columns(flight, picks);
        columns.extend(extra.iter().map(Vec::as_slice));
        let one = problem.products(flight, &fit.noise, &columns, &|_| true);
        information.add_flight(&one.products, problem.own(), one.rows, one.log_determinant);
    }
    information
}

/// Whether a candidate of the catalogue has that shape, given the chosen effects.
fn is_in_catalogue(
    problem: &Problem<'_>,
    fit: &NoiseFit,
    chosen: &[usize],
    rivals: &[usize],
    columns: &Extra,
    k: usize,
) -> bool {
    let one: Extra = columns.iter().map(|flight| vec![flight[k].clone()]).collect();
    let picks: Vec<usize> = chosen.iter().chain(rivals).copied().collect();
    let information = information(problem, fit, &picks, &one);
    let others: Vec<usize> = (0..chosen.len()).collect();
    let test = picks.len();
    (chosen.len()..picks.len())
        .any(|rival| information.shared(test, rival, &others).is_some_and(|shared| shared > IN_CATALOGUE))
}
