//! Noise that is larger in free flight than it would be without an effect that was not found.

use super::*;
use crate::diagnose::unknown::free_flight_excess;

/// The gain for a flight whose white noise is this many times larger in its free half.
fn excess(factor: f64, explained_white_m2: f64, seed: u64) -> Option<f64> {
    let mut generator = ChaCha8Rng::seed_from_u64(seed);
    let mut normal = move || -> f64 { StandardNormal.sample(&mut generator) };
    let more: Vec<f64> = (0..300).map(|_| (factor * factor - 1.0).sqrt() * WHITE_M * normal()).collect();
    let flight = Small::new(300, seed + 1).error(|block| if block >= 150 { more[block] } else { 0.0 });
    let flights = [flight.series];
    let problem = problem(&flights);
    let fit = problem.fit_noise(&problem.prior, &[], &problem.prior.means());
    free_flight_excess(&problem, &fit, &[], BARO, explained_white_m2)
}

#[test]
fn steady_noise_has_no_excess() {
    assert_eq!(excess(1.0, 0.0, 70), None);
}

/// Up to three times may be due to the sensor's own propeller.
#[test]
fn only_noise_of_many_times_the_size_is_an_excess() {
    assert_eq!(excess(2.0, 0.0, 80), None);
    let gain = excess(8.0, 0.0, 80).unwrap();
    // With a factor of one, 150 blocks of each half have one sigma: the logarithm and squares of each half,
    // up to the prior's part.
    let one = (0.5_f64 * (1.0 + 64.0)).ln();
    let two = 0.5 * 64.0_f64.ln();
    let expected = 300.0 * (one - two);
    assert!((0.5..1.5).contains(&(gain / expected)), "{gain} {expected}");
}

#[test]
fn the_noise_of_the_regressors_that_were_found_is_no_excess() {
    let white_m2 = (8.0 * WHITE_M).powi(2);
    assert_eq!(excess(8.0, white_m2, 80), None);
}
