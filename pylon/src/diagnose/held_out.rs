//! Errors on what was not learned from: manoeuvres left out of the fit, or whole flights.

use super::information::{Information, own_coefficients};
use super::noise::Noise;
use super::problem::Problem;
use super::series::{BySensor, Series};
use kf_core::sensor::SENSORS;

/// Stretches of free flight that are left out in turn.
pub(super) const FOLDS: usize = 5;

/// Sums of squares of the held-out errors, by sensor.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HeldOut {
    sum: BySensor,
    blocks: [u64; SENSORS],
}

impl HeldOut {
    /// Root mean square of one sensor's error, metres; `None` without a block.
    #[must_use]
    pub fn rms_m(&self, sensor: usize) -> Option<f64> {
        (self.blocks[sensor] > 0).then(|| (self.sum[sensor] / self.blocks[sensor] as f64).sqrt())
    }

    /// Over all sensors that fly free, metres.
    #[must_use]
    pub fn rms_all_m(&self) -> Option<f64> {
        let blocks: u64 = self.blocks.iter().sum();
        (blocks > 0).then(|| (self.sum.iter().sum::<f64>() / blocks as f64).sqrt())
    }

    fn add(&mut self, sensor: usize, error_m: f64) {
        if error_m.is_finite() {
            self.sum[sensor] += error_m * error_m;
            self.blocks[sensor] += 1;
        }
    }
}

/// The stretch of free flight that a block belongs to; `None` in captive flight.
pub(super) fn fold(flight: &Series, block: usize) -> Option<usize> {
    let first = flight.free.iter().position(|free| *free)?;
    let at = block.checked_sub(first)?;
    Some((at * FOLDS / (flight.len() - first)).min(FOLDS - 1))
}

/// Errors of stretches of free flight, each predicted from the rest of the flights.
#[must_use]
pub fn manoeuvres(problem: &Problem<'_>, noise: &Noise, picks: &[usize]) -> HeldOut {
    let mut errors = HeldOut::default();
    let all: Vec<usize> = (0..picks.len()).collect();
    for left_out in 0..FOLDS {
        let mut information = Information::new(1 + picks.len());
        let mut flights = Vec::new();
        for flight in problem.flights {
            let used = |block| fold(flight, block) != Some(left_out);
            let one = problem.products(flight, noise, &problem.columns(flight, picks), &used);
            information.add_flight(&one.products, problem.own(), one.rows, one.log_determinant);
            flights.push(one);
        }
        let common = coefficients(&information, &all);
        for (flight, one) in problem.flights.iter().zip(&flights) {
            let own = own_coefficients(&one.products, problem.own(), &common);
            let tested = |block| fold(flight, block) == Some(left_out);
            add_errors(problem, flight, picks, &own, &common, &tested, &mut errors);
        }
    }
    errors
}

/// Errors in free flight of flights that were not learned from: biases by their own captive flight,
/// coefficients by the learning flights.
#[must_use]
pub fn flights(learned: &Problem<'_>, held: &Problem<'_>, noise: &Noise, picks: &[usize]) -> HeldOut {
    let all: Vec<usize> = (0..picks.len()).collect();
    let common = coefficients(&learned.information(noise, picks), &all);
    let mut errors = HeldOut::default();
    for flight in held.flights {
        let has_captive = flight.free.iter().any(|free| !*free);
        let used = |block: usize| !has_captive || !flight.free[block];
        let one = held.products(flight, noise, &held.columns(flight, picks), &used);
        let own = own_coefficients(&one.products, held.own(), &common);
        add_errors(held, flight, picks, &own, &common, &|block| flight.free[block], &mut errors);
    }
    errors
}

/// The fit's coefficients; those that can't be told apart are not applied.
fn coefficients(information: &Information, all: &[usize]) -> Vec<f64> {
    information.solve(all).map_or_else(|| vec![0.0; all.len()], |solution| solution.coefficients)
}

fn add_errors(
    problem: &Problem<'_>,
    flight: &Series,
    picks: &[usize],
    own: &[f64],
    common: &[f64],
    tested: &dyn Fn(usize) -> bool,
    errors: &mut HeldOut,
) {
    let columns = problem.columns(flight, picks);
    for block in (0..flight.len()).filter(|block| tested(*block)) {
        for sensor in 0..SENSORS {
            let explained = own.iter().chain(common).zip(&columns[1..]);
            let explained_m: f64 = explained.map(|(value, column)| value * column[block][sensor]).sum();
            errors.add(sensor, flight.residual_m[block][sensor] - explained_m);
        }
    }
}
