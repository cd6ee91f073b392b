//! The intervals of coefficients.

use super::judge::diagnosed;
use super::*;
use crate::diagnose::diagnosis::CandidateFacts;

const BLOCKS: usize = 400;

/// The facts of an effect that is found on a flight with a measured climb rate.
fn found(small: &Small, effect: EffectId) -> CandidateFacts {
    let diagnosis = diagnosed(small, true);
    let facts = &diagnosis.sensors["baro"].candidates;
    let own = facts.iter().find(|facts| facts.effect == effect.name()).unwrap();
    assert!(own.chosen, "{facts:?}");
    own.clone()
}

/// A warming up since launch with that time constant, as a share of its end.
fn warmed(time_constant_s: f64) -> impl Fn(usize) -> f64 {
    move |block| {
        let since_s = block.saturating_sub(BLOCKS / 2) as f64;
        1.0 - (-since_s / time_constant_s).exp()
    }
}

/// Warming ups with the time constants of a grid.
fn with_grid(mut small: Small, times_s: &[f32]) -> Small {
    for time_s in times_s {
        small = small.candidate_in(EffectId::BaroWarmUp, [-100.0, 100.0], warmed(f64::from(*time_s)));
        let last = small.candidates.len() - 1;
        small.candidates[last].regressor.time_constant_s = *time_s;
    }
    small
}

/// A strong effect prefers one time constant of the grid by far, whose coefficient is still off by more than
/// the noise. The interval contains the true one, because it counts half a step of the grid. On a grid of one
/// time constant there is no step.
#[test]
fn a_time_constant_between_the_grids_is_in_the_interval() {
    const TRUE: f64 = 40.0;
    let of = |grid: &[f32], true_s: f64| {
        let small = Small::new(BLOCKS, 3).error(move |block| TRUE * warmed(true_s)(block));
        found(&with_grid(small, grid), EffectId::BaroWarmUp)
    };
    let between = of(&[30.0, 90.0, 270.0], 70.0);
    assert_eq!(between.time_constant_s, Some(90.0));
    let error = (between.coefficient - TRUE).abs();
    let alone = of(&[90.0], 90.0);
    assert!((alone.coefficient - TRUE).abs() < 3.0 * alone.sigma, "{alone:?}");
    assert!(1.96 * alone.sigma < error && error < 1.96 * between.sigma, "{error}: {between:?} {alone:?}");
}

/// Errors of the shape and of the signal's scale count where nothing else is uncertain, whatever the noise:
/// half of a tenth of the shape's share (1 %, in squares) for an effect that is spread evenly over the flight,
/// and 2 %.
#[test]
fn an_effect_far_above_the_noise_is_uncertain_by_its_shape() {
    let small = Small::new(BLOCKS, 5).candidate(EffectId::BaroAcceleration, |block| 100.0 * sine(0, block));
    let facts = found(&small.error(|block| 2.0 * 100.0 * sine(0, block)), EffectId::BaroAcceleration);
    let relative = facts.sigma / facts.coefficient;
    let expected = (0.5_f64 * 0.01 / 10.0 + 0.02 * 0.02).sqrt();
    assert!((relative / expected - 1.0).abs() < 0.1, "{relative} {expected}");
}

/// A part of another effect, too weak to be found, may hide in a coefficient that it is correlated with: the
/// interval is wider beside such a suspect than without one.
#[test]
fn an_effect_that_may_act_too_widens_the_interval() {
    let alone = || {
        let small = Small::new(BLOCKS, 7).candidate(EffectId::BaroAcceleration, |block| sine(0, block));
        small.error(|block| 0.6 * sine(0, block) + 0.25 * (sine(0, block) + sine(1, block)))
    };
    let without = found(&alone(), EffectId::BaroAcceleration);
    let both = alone().candidate(EffectId::BaroPropwash, |block| sine(0, block) + sine(1, block));
    let with = found(&both, EffectId::BaroAcceleration);
    assert!((with.coefficient - without.coefficient).abs() < 1e-9, "{with:?} {without:?}");
    assert!(with.sigma > 1.01 * without.sigma, "{} {}", with.sigma, without.sigma);
}

/// A signal of which half is noise shows half of the coefficient. The interval of a fit that takes the signal
/// for exact misses the true one; the one that knows the noise contains it, in nearly every flight. That much
/// noise is no reason to doubt the effect, so that it does not count towards zero.
#[test]
fn noise_in_a_signal_widens_the_interval() {
    const TRUE: f64 = 2.0;
    let of = |seed: u64, known_m2: f64| {
        let mut generator = ChaCha8Rng::seed_from_u64(1000 + seed);
        let mut signs = || -> f64 { StandardNormal.sample(&mut generator) };
        let (real, noise): (Vec<f64>, Vec<f64>) = (0..BLOCKS).map(|_| (signs(), signs())).unzip();
        let measured: Vec<f64> = real.iter().zip(&noise).map(|(real, noise)| real + noise).collect();
        let mut small = Small::new(BLOCKS, seed)
            .candidate(EffectId::BaroPropwash, move |block| measured[block])
            .error(move |block| TRUE * real[block]);
        small.signal_noise_m2 = known_m2;
        let facts = found(&small, EffectId::BaroPropwash);
        assert!((facts.coefficient - 0.5 * TRUE).abs() < 0.3 * TRUE, "{facts:?}");
        (facts.coefficient - TRUE).abs() < 1.96 * facts.sigma
    };
    let covered = |known_m2: f64| (0..20).filter(|seed| of(*seed, known_m2)).count();
    assert_eq!(covered(0.0), 0);
    // 95 % of 20; fewer than 16 by a chance of 3 in 1000.
    assert!(covered(1.0) >= 16, "{}", covered(1.0));
}
