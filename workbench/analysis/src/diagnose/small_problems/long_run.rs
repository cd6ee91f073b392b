//! How much larger a coefficient's error is than its fit reports.

use super::*;
use crate::diagnose::long_run::{inflation, variance};

fn of(small: &Small) -> f64 {
    let flights = [small.series.clone()];
    inflation(&problem(&flights), &NOISE, &[0])[0]
}

/// Numbers of unit variance that keep their sign over some blocks: each keeps this share of the one before.
fn persistent(keep: f64, seed: u64) -> impl FnMut() -> f64 {
    let mut generator = ChaCha8Rng::seed_from_u64(seed);
    let mut state = 0.0;
    move || {
        let new: f64 = StandardNormal.sample(&mut generator);
        state = keep * state + (1.0 - keep * keep).sqrt() * new;
        state
    }
}

/// Noise as the likelihood assumes it leaves scores that are not correlated: no error is widened. An error
/// that stays correlated over some blocks, which the noise does not include, makes the coefficient of a similar
/// regressor less certain.
#[test]
fn scores_that_keep_their_sign_widen_the_error() {
    let count = 40;
    let mean = |error_m: f64| {
        let one = |seed: u64| {
            let (mut column, mut error) = (persistent(0.6, seed), persistent(0.6, 1_000 + seed));
            let small = Small::new(400, 2_000 + seed).candidate(EffectId::BaroLag, move |_| 0.0);
            let values: Vec<f64> = (0..400).map(|_| column()).collect();
            let errors: Vec<f64> = (0..400).map(|_| error_m * error()).collect();
            let mut small = small.error(|block| errors[block]);
            small.series.columns = vec![Arc::new(on_baro(values.into_iter()))];
            of(&small)
        };
        (0..count).map(one).sum::<f64>() / count as f64
    };
    // By chance the ratio is sometimes above one, never below: it is cut off there.
    let white = mean(0.0);
    assert!((1.0..1.25).contains(&white), "{white}");
    // The products of two such sequences keep 0.36 of the one before: (1 + 0.36) / (1 - 0.36) is 2.1, of
    // which the weights leave some. The error's own size adds to that: 1 m against the 0.3 m that the
    // likelihood assumes.
    let wide = mean(1.0);
    assert!(wide > 3.0 * white, "{wide}");
}

/// A long-run variance is the sum of the squares plus twice the products of neighbours, by a weight that
/// falls to zero beyond eight seconds: for a hundred ones it is nearly nine of each.
#[test]
fn a_long_run_variance_has_the_neighbours_in_it() {
    assert_eq!(variance(&[2.0, 0.0, 0.0, -3.0], 100.0), 4.0 + 9.0);
    // One lag, of weight a half.
    assert_eq!(variance(&[2.0, 1.0, 0.0, -3.0], 8.0), 14.0 + 2.0 * 0.5 * 2.0);
    let wanted: f64 =
        (1..=8).map(|lag| 2.0 * (1.0 - f64::from(lag) / 9.0) * f64::from(100 - lag)).sum::<f64>() + 100.0;
    assert!((variance(&[1.0; 100], 1.0) - wanted).abs() < 1e-9);
    assert_eq!(variance(&[], 1.0), 0.0);
}
