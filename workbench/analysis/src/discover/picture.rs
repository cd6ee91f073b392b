//! A law's picture on the flights: measured against law, and the remainder against each of its signals.

use super::fit::{Bench, Fitted};
use super::screen::Subject;
use crate::diagnose::parts::own_coefficients;

/// A law and the measured values, in the blocks of the learning flights.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Picture {
    /// What the law contributes to its sensor, metres.
    pub law_m: Vec<f64>,
    /// What is measured of it, metres: the residual less biases and all other effects. It includes the
    /// wander.
    pub measured_m: Vec<f64>,
    /// The signals of the law.
    pub signals: Vec<PictureSignal>,
}

/// A signal of a law.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PictureSignal {
    /// Its name in the formula.
    pub name: String,
    /// Its unit in the formula.
    pub unit: String,
    /// Its block means; for a heading, between -pi and pi.
    pub values: Vec<f64>,
}

impl Picture {
    /// The remainder that the law leaves, metres.
    #[must_use]
    pub fn rest_m(&self) -> Vec<f64> {
        self.measured_m.iter().zip(&self.law_m).map(|(measured, law)| measured - law).collect()
    }

    /// The picture of a law; empty where its coefficients cannot be solved for.
    pub(super) fn of(bench: &Bench<'_>, one: &Fitted) -> Self {
        let series = bench.with_columns(bench.problem.flights, &[(one.subject, &one.column)]);
        let problem = bench.problem_of(&series);
        let picks: Vec<usize> = one.beside.iter().copied().chain([bench.law_column()]).collect();
        let all: Vec<usize> = (0..picks.len()).collect();
        let noise = &one.fit.noise;
        let signals = bench.search.signals;
        let used = (0..signals.signals.len()).filter(|signal| one.law.uses(*signal));
        let mut picture = Self {
            signals: used
                .clone()
                .map(|signal| PictureSignal {
                    name: signals.signals[signal].name.name.clone(),
                    unit: signals.signals[signal].name.unit.clone(),
                    values: Vec::new(),
                })
                .collect(),
            ..Self::default()
        };
        let Some(common) = problem.information(noise, &picks).solve(&all) else { return picture };
        for ((flight, blocks), law) in series.iter().zip(&signals.flights).zip(&one.column) {
            let columns = problem.columns(flight, &picks);
            let products = problem.products(flight, noise, &columns, &|_| true).products;
            let own = own_coefficients(&products, problem.own(), &common.coefficients);
            let values: Vec<Vec<f64>> = used.clone().map(|signal| blocks.values_of(signal)).collect();
            for block in 0..flight.len() {
                let rest: Vec<f64> = (0..flight.residual_m[block].len())
                    .filter(|sensor| match one.subject {
                        Subject::Sensor(only) => *sensor == only,
                        Subject::Reference => true,
                    })
                    .filter(|sensor| flight.residual_m[block][*sensor].is_finite())
                    .map(|sensor| {
                        let explained = own.iter().chain(&common.coefficients).zip(&columns[1..]);
                        let explained: f64 =
                            explained.map(|(value, column)| value * column[block][sensor]).sum();
                        flight.residual_m[block][sensor] - explained
                    })
                    .collect();
                if rest.is_empty() {
                    continue;
                }
                let sign = if one.subject == Subject::Reference { -1.0 } else { 1.0 };
                let law_m = one.coefficient * law.get(block).copied().unwrap_or(0.0);
                picture.law_m.push(law_m);
                picture.measured_m.push(law_m + sign * rest.iter().sum::<f64>() / rest.len() as f64);
                for (signal, values) in picture.signals.iter_mut().zip(&values) {
                    signal.values.push(values.get(block).copied().unwrap_or(f64::NAN));
                }
            }
        }
        picture
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The remainder of a law is the measured value less the law's.
    #[test]
    fn the_rest_is_what_the_law_does_not_make() {
        let picture =
            Picture { law_m: vec![1.0, -2.0, 4.0], measured_m: vec![1.5, -3.0, 4.0], signals: Vec::new() };
        assert_eq!(picture.rest_m(), [0.5, -1.0, 0.0]);
    }
}
