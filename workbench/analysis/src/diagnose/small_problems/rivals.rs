//! Candidates that could replace each other.

use super::*;
use crate::diagnose::rivals::{Rivals, rivals};
use crate::diagnose::search::{Explanation, Search};

const BLOCKS: usize = 300;

/// The rivals of column 0, which acts with a coefficient of 2 and was chosen.
fn of_first(small: Small) -> Rivals {
    let small = small.error(|block| 2.0 * sine(0, block));
    let flights = [small.series.clone()];
    let (problem, suspects) = (problem(&flights), small.suspects());
    let mut search = Search::new(&problem, &suspects);
    let fit = search.fit(&[0], &problem.prior.means());
    let chosen = Explanation { columns: vec![0], fit };
    let mut found = rivals(&mut search, &suspects, &problem, &chosen, &[1.0]);
    assert_eq!(found.len(), 1);
    found.remove(0)
}

fn lag(seed: u64) -> Small {
    Small::new(BLOCKS, seed).candidate(EffectId::BaroLag, |block| sine(0, block))
}

#[test]
fn a_regressor_of_the_same_shape_is_a_rival_and_another_shape_is_none() {
    let alike = |block: usize| 3.0 * sine(0, block) + 0.1 * sine(1, block);
    let found = of_first(
        lag(0)
            .candidate(EffectId::BaroScale, alike)
            .candidate(EffectId::BaroAcceleration, |block| sine(2, block)),
    );
    assert_eq!((found.column, found.others.first()), (0, Some(&1)));
    let odds_of = |column| {
        found.others.iter().zip(&found.odds).find(|(other, _)| **other == column).map(|(_, odds)| *odds)
    };
    assert!(odds_of(1) > Some(0.5), "{found:?}");
    assert!(odds_of(2).unwrap_or(0.0) < 1e-3, "{found:?}");
}

/// Of three time constants only the chosen one fits, and all three are equally probable: an effect without a
/// time constant is three times as probable a rival.
#[test]
fn an_effect_that_needs_a_special_time_constant_is_less_probable() {
    let alike = |block: usize| 3.0 * sine(0, block) + 0.1 * sine(1, block);
    let odds = |further: &[usize]| {
        let small = Small::new(BLOCKS, 0)
            .candidate(EffectId::BaroWarmUp, |block| sine(0, block))
            .candidate(EffectId::BaroScale, alike);
        let small = further.iter().fold(small, |small, k| {
            let k = *k;
            small.candidate(EffectId::BaroWarmUp, move |block| sine(k, block))
        });
        of_first(small).odds[0]
    };
    let ratio = odds(&[2, 3]) / odds(&[]);
    assert!((ratio - 3.0).abs() < 1e-3, "{ratio}");
}

/// The whitened squares of the chosen column, times its coefficient's square.
#[test]
fn what_is_explained_is_the_squares_of_the_chosen_column() {
    let small = lag(1).noiseless();
    let flights = [small.series.clone()];
    let problem = problem(&flights);
    let fit = problem.fit_noise(&problem.prior, &[0], &problem.prior.means());
    let sigma = problem.information(&fit.noise, &[0]).solve(&[0]).unwrap().covariance[0].sqrt();
    assert!(sigma.is_finite());
    let found = of_first(small);
    let with = problem_of(lag(1).noiseless().error(|block| 2.0 * sine(0, block)));
    assert!((found.explained / with - 1.0).abs() < 1e-6, "{} {with}", found.explained);
}

/// The squares that column 0 explains under the noise fitted with it.
fn problem_of(small: Small) -> f64 {
    let flights = [small.series];
    let problem = problem(&flights);
    let fit = problem.fit_noise(&problem.prior, &[0], &problem.prior.means());
    let information = problem.information(&fit.noise, &[0]);
    let solution = information.solve(&[0]).unwrap();
    solution.coefficients[0].powi(2) / solution.covariance[0]
}

/// The same shape, but a coefficient of 2 is outside the physical range.
#[test]
fn an_impossible_coefficient_is_no_rival() {
    let alike = |block: usize| sine(0, block) + 0.03 * sine(1, block);
    let with_range = |range| of_first(lag(2).candidate_in(EffectId::BaroScale, range, alike)).others;
    assert_eq!(with_range([-10.0, 10.0]), [1]);
    assert_eq!(with_range([-10.0, 1.0]), [0; 0]);
}

/// Other time constants of the same effect are not its rivals.
#[test]
fn an_effect_is_no_rival_of_itself() {
    let alike = |block: usize| sine(0, block) + 0.03 * sine(1, block);
    assert_eq!(of_first(lag(3).candidate(EffectId::BaroLag, alike)).others, [0; 0]);
}

/// Exactly the same regressor: the data cannot tell which. A range limits how far an effect can reach, not
/// how large it is, and is no evidence where the likelihood is tempered.
#[test]
fn odds_are_even_where_the_shapes_are_the_same_whatever_the_ranges() {
    let odds = |range| {
        let found = of_first(lag(4).candidate_in(EffectId::BaroScale, range, |block| sine(0, block)));
        assert_eq!(found.others, [1]);
        found.odds[0]
    };
    assert!((odds([-10.0, 10.0]) - 1.0).abs() < 1e-9);
    assert!((odds([-20.0, 20.0]) - 1.0).abs() < 1e-9);
}
