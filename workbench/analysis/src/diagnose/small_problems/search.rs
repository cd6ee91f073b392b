//! The search for the set of effects that acts.

use std::ops::ControlFlow;

use super::*;
use crate::diagnose::search::{Explanation, Search, extended};
use crate::progress::Cancelled;

/// Three effects that do not look alike.
fn three(flight: Small) -> Small {
    flight
        .candidate(EffectId::BaroLag, |block| sine(0, block))
        .candidate(EffectId::BaroScale, |block| sine(1, block))
        .candidate(EffectId::BaroAcceleration, |block| sine(2, block))
}

fn found(small: &Small) -> Explanation {
    let flights = [small.series.clone()];
    let (problem, suspects) = (problem(&flights), small.suspects());
    Search::new(&problem, &suspects).run(&mut || ControlFlow::Continue(())).unwrap()
}

/// The coefficients of an explanation, with their sigmas.
fn coefficients(small: &Small, explanation: &Explanation) -> Vec<(f64, f64)> {
    let flights = [small.series.clone()];
    let information = problem(&flights).information(&explanation.fit.noise, &explanation.columns);
    let all: Vec<usize> = (0..explanation.columns.len()).collect();
    let solution = information.solve(&all).unwrap();
    let n = all.len();
    all.iter().map(|k| (solution.coefficients[*k], solution.covariance[k * n + k].sqrt())).collect()
}

#[test]
fn nothing_is_found_where_nothing_acts() {
    for seed in 0..5 {
        assert_eq!(found(&three(Small::new(300, seed))).columns, [0; 0], "{seed}");
    }
}

#[test]
fn what_acts_is_found_with_its_coefficient() {
    let cases: [(&[usize], &[f64]); 3] =
        [(&[1], &[-1.5]), (&[0, 2], &[1.0, 2.0]), (&[0, 1, 2], &[1.0, -1.0, 1.5])];
    for (seed, (columns, sizes)) in (10..).zip(cases) {
        let error = |block: usize| columns.iter().zip(sizes).map(|(k, size)| size * sine(*k, block)).sum();
        let small = three(Small::new(300, seed)).error(error);
        let explanation = found(&small);
        assert_eq!(explanation.columns, columns);
        for ((coefficient, sigma), size) in coefficients(&small, &explanation).into_iter().zip(sizes) {
            assert!((coefficient - size).abs() < 4.0 * sigma, "{coefficient} +- {sigma}, not {size}");
            assert!(sigma < 0.1, "{sigma}");
        }
    }
}

/// Of an effect that is tried with several time constants, one is chosen.
#[test]
fn an_effect_acts_once() {
    let error = |block| sine(0, block) + sine(1, block);
    let small = Small::new(300, 20)
        .candidate(EffectId::BaroWarmUp, |block| sine(0, block))
        .candidate(EffectId::BaroWarmUp, |block| sine(1, block))
        .error(error);
    assert_eq!(found(&small).columns.len(), 1);
    let other = Small::new(300, 20)
        .candidate(EffectId::BaroWarmUp, |block| sine(0, block))
        .candidate(EffectId::BaroScale, |block| sine(1, block))
        .error(error);
    assert_eq!(found(&other).columns, [0, 1]);
}

#[test]
fn what_nature_does_not_allow_is_not_found() {
    let with_range = |range| {
        let small = Small::new(300, 30).candidate_in(EffectId::BaroLag, range, |block| sine(0, block));
        found(&small.error(|block| -2.0 * sine(0, block))).columns
    };
    assert_eq!(with_range([-3.0, 0.0]), [0]);
    assert_eq!(with_range([0.0, 3.0]), [0; 0]);
}

/// One more column per set, the smallest sum of remainder and penalty first; no set twice.
#[test]
fn sets_are_extended_in_the_order_of_their_rest() {
    let small = three(Small::new(200, 40)).error(|block| sine(0, block) + 3.0 * sine(2, block));
    let flights = [small.series.clone()];
    let (problem, suspects) = (problem(&flights), small.suspects());
    let information = suspects.information(&problem, &NOISE);
    let sets = extended(&suspects, &information, &[vec![0], vec![2]]);
    assert_eq!(
        sets.iter().map(|(_, set)| set.as_slice()).collect::<Vec<_>>(),
        [&[0, 2][..], &[1, 2], &[0, 1]]
    );
    for (score, set) in sets {
        let rest = information.solve(&set).unwrap().rest;
        assert_eq!(score, rest + 2.0 * suspects.penalty());
    }
}

/// A maximum that was found is not lost by a fit from a worse start.
#[test]
fn a_fit_is_kept_until_a_better_one_is_found() {
    let small = three(Small::new(200, 50));
    let flights = [small.series.clone()];
    let (problem, suspects) = (problem(&flights), small.suspects());
    let mut search = Search::new(&problem, &suspects);
    let means = problem.prior.means();
    let first = search.fit(&[0], &means);
    let far: Vec<f64> = means.iter().map(|mean| mean + 6.0).collect();
    assert_eq!(search.fit(&[0], &far), first);
}

#[test]
fn a_search_ends_when_it_is_told_to() {
    let small = three(Small::new(100, 60)).error(|block| sine(0, block));
    let flights = [small.series.clone()];
    let (problem, suspects) = (problem(&flights), small.suspects());
    let mut steps = 0;
    let mut progress = || {
        steps += 1;
        if steps == 2 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let result = Search::new(&problem, &suspects).run(&mut progress);
    assert_eq!((result.err(), steps), (Some(Cancelled), 2));
}
