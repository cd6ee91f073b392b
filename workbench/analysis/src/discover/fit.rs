//! Laws with the noise fitted again for each: the likelihood of the diagnosis.

use std::sync::Arc;

use kf_core::sensor::SENSORS;

use super::grammar::{Law, MOST_PARTS};
use super::screen::{Column, Subject};
use super::search::{Scored, Search};
use super::weigh::{SIZE_M, Weight};
use crate::diagnose::HeldOutVerdict;
use crate::diagnose::parts::{
    BySensor, Candidate, Explanation, Fitted as Term, HeldOut, NoiseFit, Prepared, Problem, Series, Suspects,
    Trim, flights, inflation, manoeuvres, of_flights, of_folds,
};

/// Correlation (of the columns themselves) above which two laws are the same: they share all but 0.2 % of
/// their squares. A formula's shape is not accurate to that, so the likelihood does not choose between them,
/// and the shortest represents all.
const SAME: f64 = 0.999;

/// A law with its noise.
#[derive(Clone, Debug)]
pub struct Fitted {
    /// The law.
    pub law: Law,
    /// What it acts on.
    pub subject: Subject,
    /// Effects of the catalogue that are estimated with it.
    pub beside: Vec<usize>,
    /// The noise.
    pub fit: NoiseFit,
    /// Its weight.
    pub weight: Weight,
    /// Its column in the learning flights.
    pub column: Column,
    /// Its coefficient.
    pub coefficient: f64,
    /// One sigma of it.
    pub sigma: f64,
    /// Factor by which the coefficient's variance exceeds that of the fit.
    pub inflation: f64,
    /// Spread of the column in free flight, metres per unit of the coefficient.
    pub spread: f64,
}

impl Fitted {
    /// Twice the logarithm of its odds against no law.
    pub fn merit(&self) -> f64 {
        self.weight.twice_log_odds()
    }
}

/// What laws are fitted on.
pub struct Bench<'a> {
    /// The flights and the noise's prior.
    pub problem: &'a Problem<'a>,
    /// The flights held out.
    pub held: Option<&'a Problem<'a>>,
    /// Candidates and columns.
    pub prepared: &'a Prepared,
    /// What is known about the candidates.
    pub suspects: &'a Suspects<'a>,
    /// The signals.
    pub search: &'a Search<'a>,
    /// What the catalogue explains.
    pub explanation: &'a Explanation,
    /// The aircraft's trim in flight.
    pub trim: Trim,
}

/// Held-out errors, without a law and with it.
#[derive(Clone, Copy, Debug)]
pub struct OnHeldOut {
    /// Root mean square of the errors without it, m.
    pub rms_before_m: Option<f64>,
    /// The same with the law, m.
    pub rms_after_m: Option<f64>,
    /// The stretches of the learning flights, each with the coefficient of the others.
    pub stretches: HeldOutVerdict,
    /// The flights held out.
    pub flights: Option<HeldOutVerdict>,
}

impl Bench<'_> {
    /// The effects that can be estimated with a law on a subject: all that were found, or only those on other
    /// subjects. The one chosen on this subject may only be the most similar to the law.
    pub fn variants(&self, subject: Subject) -> Vec<Vec<usize>> {
        let all = self.explanation.columns.clone();
        let is_other =
            |column: &usize| match (self.prepared.candidates.get(*column).map(Candidate::sensor), subject) {
                (Some(Some(sensor)), Subject::Sensor(own)) => sensor.index() != own,
                _ => false,
            };
        let others: Vec<usize> = all.iter().copied().filter(is_other).collect();
        if others == all { vec![all] } else { vec![all, others] }
    }

    /// The flights with these columns added after all others.
    pub fn with_columns(&self, series: &[Series], columns: &[(Subject, &Column)]) -> Vec<Series> {
        let mut more = series.to_vec();
        for (flight, series) in more.iter_mut().enumerate() {
            for (subject, column) in columns {
                let values = column.get(flight).map_or(&[] as &[f64], Vec::as_slice);
                let column = values.iter().map(|value| subject.spread(*value));
                series.columns.push(Arc::new(column.collect()));
            }
        }
        more
    }

    /// The same problem with other flights.
    pub fn problem_of<'b>(&'b self, series: &'b [Series]) -> Problem<'b> {
        Problem::new(series, self.problem.prior.clone(), self.problem.known.clone(), self.search.executor)
    }

    /// The first of some laws, the best first, without those that are the same as another; of the same ones
    /// the shortest is kept.
    pub fn different(&self, laws: &[Scored], most: usize) -> Vec<Scored> {
        let bits = |law: &Law| law.bits(self.search.signals.signals.len(), self.search.subjects);
        let mut kept: Vec<(Scored, Vec<f64>)> = Vec::new();
        for scored in laws {
            let Some(column) = self.search.column(&scored.law, 0..self.search.flights) else { continue };
            let centred = centred(&column);
            let is_same = |other: &[f64]| {
                let product: f64 = centred.iter().zip(other).map(|(a, b)| a * b).sum();
                product.abs() > SAME
            };
            let same = kept.iter().position(|(_, other)| is_same(other));
            if let Some((shortest, _)) = same.and_then(|at| kept.get_mut(at)) {
                if bits(&scored.law) < bits(&shortest.law) {
                    *shortest = scored.clone();
                }
            } else if kept.len() < most {
                kept.push((scored.clone(), centred));
            }
        }
        kept.into_iter().map(|(scored, _)| scored).collect()
    }

    /// As [`Self::different`], but always with the best two of every number of parts.
    pub fn different_by_parts(&self, laws: &[Scored], most: usize) -> Vec<Scored> {
        let mut chosen = self.different(laws, most);
        for parts in 1..=MOST_PARTS {
            let own: Vec<Scored> = laws.iter().filter(|one| one.law.parts() == parts).cloned().collect();
            let missing = self.different(&own, 2).into_iter();
            let missing: Vec<Scored> =
                missing.filter(|one| chosen.iter().all(|other| other.law != one.law)).collect();
            chosen.extend(missing);
        }
        chosen
    }

    /// Fits the noise with a law, starting near the given one.
    pub fn fit(&self, law: &Law, subject: Subject, beside: &[usize], near: &NoiseFit) -> Option<Fitted> {
        let column = self.search.column(law, 0..self.search.flights)?;
        let series = self.with_columns(self.problem.flights, &[(subject, &column)]);
        let problem = self.problem_of(&series);
        let picks: Vec<usize> = beside.iter().copied().chain([self.law_column()]).collect();
        let fit = problem.fit_noise(&self.problem.prior, &picks, &near.values);
        let all: Vec<usize> = (0..picks.len()).collect();
        let solution = problem.information(&fit.noise, &picks).solve(&all)?;
        let (coefficient, variance) = (*solution.coefficients.last()?, *solution.covariance.last()?);
        let inflation = inflation(&problem, &fit.noise, &picks).last().copied().unwrap_or(1.0);
        let spread = spread(self.problem.flights, &column);
        let signals = self.search.signals.signals.len();
        let size = SIZE_M / spread.max(f64::MIN_POSITIVE);
        let dropped = self.explanation.columns.len() - beside.len();
        let weight = Weight {
            evidence: (fit.twice_log_posterior - self.explanation.fit.twice_log_posterior) / inflation,
            bits: law.bits(signals, self.search.subjects),
            surprise: size * size / (variance * inflation),
            instead_of: self.suspects.penalty() * dropped as f64,
        };
        let sigma = (variance * inflation).sqrt();
        let (law, beside) = (law.clone(), beside.to_vec());
        Some(Fitted { law, subject, beside, fit, weight, column, coefficient, sigma, inflation, spread })
    }

    /// Index of the column of a law that was added to the flights.
    pub fn law_column(&self) -> usize {
        self.problem.flights.first().map_or(0, |flight| flight.columns.len())
    }

    /// What the law gains with its coefficient, in twice the log likelihood, where no effect of the catalogue
    /// is estimated with it on its own subject. Two columns that cancel each other can look like a third:
    /// such a law makes every flight worse if it is used alone.
    pub fn gain_alone(&self, fitted: &Fitted) -> f64 {
        let others = self.variants(fitted.subject).pop().unwrap_or_default();
        if others == fitted.beside {
            return f64::INFINITY;
        }
        let series = self.with_columns(self.problem.flights, &[(fitted.subject, &fitted.column)]);
        let problem = self.problem_of(&series);
        let noise = &fitted.fit.noise;
        let term = Term { noise, others: &others, column: self.law_column(), inflation: fitted.inflation };
        let evidence = of_flights(&problem, &term);
        fitted.coefficient * (2.0 * evidence.score - fitted.coefficient * evidence.information)
    }

    /// Whether the law with its coefficient reduces the errors of free flight about captive flight when
    /// nothing else is subtracted: squares in metres, as a user who adds the law sees them. The likelihood
    /// treats slow errors as wander, and does not notice what a law does there.
    pub fn lessens_errors(&self, fitted: &Fitted) -> bool {
        let mut change_m2 = 0.0;
        for (series, column) in self.problem.flights.iter().zip(&fitted.column) {
            let law: Vec<BySensor> =
                column.iter().map(|value| fitted.subject.spread(fitted.coefficient * value)).collect();
            for sensor in 0..SENSORS {
                let errors = series.residual_m.iter().map(|errors_m| errors_m[sensor]);
                let left = errors.clone().zip(&law).map(|(error_m, law_m)| error_m - law_m[sensor]);
                change_m2 += free_squares(series, left) - free_squares(series, errors);
            }
        }
        change_m2 < 0.0
    }

    /// Held-out errors, without a law and with it.
    pub fn held_out(&self, fitted: &Fitted) -> OnHeldOut {
        let column = self.law_column();
        let series = self.with_columns(self.problem.flights, &[(fitted.subject, &fitted.column)]);
        let problem = self.problem_of(&series);
        let noise = &fitted.fit.noise;
        let term = Term { noise, others: &fitted.beside, column, inflation: fitted.inflation };
        let stretches = HeldOutVerdict::on_stretches(&of_folds(&problem, &term));
        let picks: Vec<usize> = fitted.beside.iter().copied().chain([column]).collect();
        let before = self.explanation.columns.as_slice();
        let mut sigmas = self.suspects.prior(&fitted.beside);
        sigmas.push(SIZE_M / fitted.spread.max(f64::MIN_POSITIVE));
        let before_sigmas = self.suspects.prior(before);
        let rms = |errors: HeldOut| match fitted.subject {
            Subject::Sensor(sensor) => errors.rms_m(sensor),
            Subject::Reference => errors.rms_all_m(),
        };
        let all = self.search.signals.flights.len();
        let held_column = self.search.column(&fitted.law, self.search.flights..all);
        let Some((held, held_column)) = self.held.zip(held_column) else {
            return OnHeldOut {
                rms_before_m: rms(manoeuvres(&problem, noise, before, &before_sigmas)),
                rms_after_m: rms(manoeuvres(&problem, noise, &picks, &sigmas)),
                stretches,
                flights: None,
            };
        };
        let held_series = self.with_columns(held.flights, &[(fitted.subject, &held_column)]);
        let held = self.problem_of(&held_series);
        OnHeldOut {
            rms_before_m: rms(flights(&problem, &held, noise, before, &before_sigmas)),
            rms_after_m: rms(flights(&problem, &held, noise, &picks, &sigmas)),
            stretches,
            flights: Some(HeldOutVerdict::on_flights(&of_flights(&held, &term), fitted.coefficient)),
        }
    }
}

/// All values of a column less their mean, with unit length.
fn centred(column: &Column) -> Vec<f64> {
    let mut values: Vec<f64> = column.iter().flatten().copied().collect();
    let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
    values.iter_mut().for_each(|value| *value -= mean);
    let length = values.iter().map(|value| value * value).sum::<f64>().sqrt().max(f64::MIN_POSITIVE);
    values.iter_mut().for_each(|value| *value /= length);
    values
}

/// Spread of a column in free flight about its captive mean, or its own where there is none.
fn spread(flights: &[Series], column: &Column) -> f64 {
    let squares: f64 =
        flights.iter().zip(column).map(|(series, values)| free_squares(series, values.iter().copied())).sum();
    let blocks: usize =
        flights.iter().map(|series| series.free.iter().filter(|is_free| **is_free).count()).sum();
    (squares / blocks.max(1) as f64).sqrt()
}

/// Squares of the finite values in free flight about their captive mean, or their own where there is none,
/// summed over the blocks.
fn free_squares(series: &Series, values: impl Iterator<Item = f64>) -> f64 {
    let there: Vec<(bool, f64)> =
        series.free.iter().copied().zip(values).filter(|(_, value)| value.is_finite()).collect();
    let of = |free: bool| there.iter().filter(move |(is_free, _)| *is_free == free).map(|(_, value)| *value);
    let base = |free: bool| of(free).sum::<f64>() / of(free).count().max(1) as f64;
    let mean = base(!there.iter().any(|(is_free, _)| !is_free));
    of(true).map(|value| (value - mean) * (value - mean)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::discover::small_flights::flight;

    /// A column without its mean and of unit length: the product of two is their correlation.
    #[test]
    fn a_centred_column_has_no_mean_and_unit_length() {
        let found = centred(&vec![vec![1.0, 2.0], vec![6.0]]);
        assert!(found.iter().sum::<f64>().abs() < 1e-12);
        assert!((found.iter().map(|value| value * value).sum::<f64>() - 1.0).abs() < 1e-12);
        assert!((found[2] / found[0] + 1.5).abs() < 1e-12, "three more than the mean against two less");
        assert_eq!(centred(&vec![vec![4.0; 3]]), [0.0; 3]);
    }

    /// Squares of free flight are taken about captive flight's mean, or their own where nothing is captive;
    /// missing values are not counted. The spread is the root of their mean over all flights.
    #[test]
    fn a_spread_is_about_captive_flight() {
        // Two blocks captive, four free.
        let six = flight(&[0.0; 6], &[]);
        let values = [1.0, 3.0, 5.0, 2.0, f64::NAN, -1.0];
        assert_eq!(free_squares(&six, values.into_iter()), 9.0 + 0.0 + 9.0);
        let mut all_free = six.clone();
        all_free.free.fill(true);
        assert_eq!(free_squares(&all_free, [1.0, 3.0, 1.0, 3.0, 1.0, 3.0].into_iter()), 6.0);
        let column = vec![vec![2.0, 2.0, 5.0, 5.0, 5.0, 5.0], vec![0.0, 0.0, 1.0, 1.0, 1.0, 1.0]];
        assert_eq!(spread(&[six.clone(), six], &column), ((4.0 * 9.0 + 4.0) / 8.0_f64).sqrt());
    }
}
