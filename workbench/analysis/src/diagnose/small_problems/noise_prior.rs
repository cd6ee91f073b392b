//! The noise's parameters and their priors.

use super::*;

/// A flight with the barometer in the given phases.
fn flight(captive: bool, free: bool) -> Series {
    let mut series = Small::new(20, 1).series;
    for (is_free, residual_m) in series.free.iter().zip(&mut series.residual_m) {
        if !(if *is_free { free } else { captive }) {
            residual_m[BARO] = f64::NAN;
        }
    }
    series
}

#[test]
fn the_means_are_the_models_noise() {
    let model = Model::default();
    let flights = [flight(true, true)];
    let prior = prior(&flights);
    let noise = prior.noise(&prior.means());
    let near = |found: f64, expected: f32| {
        assert!((found / f64::from(expected) - 1.0).abs() < 1e-6, "{found} {expected}");
    };
    near(noise.reference.sigma_m, model.reference.sigma_m);
    near(noise.reference.time_s, model.reference.correlation_time_s);
    near(noise.fix_sigma_m, 0.2 * model.reference.sigma_m);
    let baro = &noise.sensors[BARO];
    near(baro.wander.sigma_m, 0.6 * model.sensors[BARO].sigma_m);
    near(baro.captive_white_m, 0.3 * model.sensors[BARO].sigma_m);
    // Factors of one: the same before and after launch.
    near(baro.free_white_m, 0.3 * model.sensors[BARO].sigma_m);
    near(baro.free_flight_factor, 1.0);
    assert_eq!(noise.slow.sigma_m, 0.0);
}

/// The reference has three values; a sensor has two for its wander, and the white noise of each phase in
/// which it was flown. With both phases, the ratio of the white noises and that of the wanders.
#[test]
fn only_what_a_flight_shows_is_estimated() {
    for (captive, free, count) in [(false, false, 3), (true, false, 6), (false, true, 6), (true, true, 8)] {
        let flights = [flight(captive, free)];
        let prior = prior(&flights);
        assert_eq!(prior.means().len(), count, "{captive} {free}");
        assert_eq!(prior.with_steady_wander(BARO).is_some(), captive && free);
        assert_eq!(prior.with_steady_white(BARO).is_some(), captive && free);
        assert_eq!(prior.with_slow_wander().means().len(), count + 1);
    }
    let flights = [flight(true, true)];
    assert!(prior(&flights).with_steady_wander(Sensor::ImuSlave as usize).is_none());
}

#[test]
fn the_density_is_highest_at_the_means_and_a_held_factor_is_held() {
    let flights = [flight(true, true)];
    let prior = prior(&flights);
    let means = prior.means();
    assert_eq!(prior.log_density(&means), 0.0);
    let held = prior.with_steady_wander(BARO).unwrap();
    let mut stiffer = 0;
    for k in 0..means.len() {
        let mut moved = means.clone();
        moved[k] += 0.1;
        let (free, steady) = (prior.log_density(&moved), held.log_density(&moved));
        assert!(free < 0.0 && free > -0.5 * 0.1 * 0.1 / (0.2 * 0.2), "{k}: {free}");
        stiffer += usize::from(steady < free);
        // 0.1 is five sigmas of a factor that is held at one.
        assert!(steady == free || (steady + 12.5).abs() < 1e-9, "{k}: {steady}");
    }
    assert_eq!(stiffer, 1);
}

/// If a wander could be as fast as a block, it would replace the white noise.
#[test]
fn a_correlation_time_has_a_least_value() {
    let flights = [flight(true, true)];
    let prior = prior(&flights);
    let noise = prior.noise(&vec![-30.0; prior.means().len()]);
    assert!((noise.reference.time_s - 8.0).abs() < 1e-9, "{noise:?}");
    assert!((noise.sensors[BARO].wander.time_s - 3.0).abs() < 1e-9, "{noise:?}");
    assert!(noise.reference.sigma_m < 1e-9);
}
