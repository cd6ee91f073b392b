use std::f64::consts::TAU;

use nalgebra::{DMatrix, DVector};
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution as _, StandardNormal};

use super::path_model::STATES;
use super::*;

/// Parameters none of which is at its centre.
const VALUES: [f64; PARAMETERS] = [0.3, -0.4, 0.2, 0.5, 1.1, -0.3, 0.6];

/// Uneven times, and a sensor that is missing twice.
fn few() -> Vec<Sighting> {
    let at = (0..9_u32).map(|k| Sighting {
        elapsed_s: if k == 0 { 0.0 } else { 0.4 + 0.3 * f64::from(k % 4) },
        reference_m: 500.0 + f64::from(k * 37 % 11),
        sensor_m: (k % 4 != 2).then(|| 480.0 + f64::from(k * 23 % 13)),
    });
    at.collect()
}

/// Mean and covariance of climb rates and measurements, written down from the model: the climb rates first.
fn dense(sightings: &[Sighting], model: &PathModel) -> (DVector<f64>, DMatrix<f64>, DVector<f64>) {
    let (first, covariance) = model.first(sightings[0].reference_m, sightings[0].sensor_m);
    let matrix = |rows: &[[f64; STATES]; STATES]| DMatrix::from_fn(STATES, STATES, |r, c| rows[r][c]);
    let n = sightings.len();
    // All states, one instant after the other, are linear in the first one and the noises in between.
    let mut mean = DVector::zeros(n * STATES);
    let mut all = DMatrix::zeros(n * STATES, n * STATES);
    let (mut m, mut p) = (DVector::from_row_slice(&first), matrix(&covariance));
    for (k, sighting) in sightings.iter().enumerate() {
        let transition = model.over(sighting.elapsed_s);
        let f = matrix(&transition.matrix);
        m = &f * m;
        p = &f * &p * f.transpose() + matrix(&transition.noise);
        mean.rows_mut(k * STATES, STATES).copy_from(&m);
        all.view_mut((k * STATES, k * STATES), (STATES, STATES)).copy_from(&p);
        for earlier in 0..k {
            let before = all.view((earlier * STATES, (k - 1) * STATES), (STATES, STATES)) * f.transpose();
            all.view_mut((earlier * STATES, k * STATES), (STATES, STATES)).copy_from(&before);
            all.view_mut((k * STATES, earlier * STATES), (STATES, STATES)).copy_from(&before.transpose());
        }
    }
    let mut rows: Vec<Vec<usize>> = (0..n).map(|k| vec![k * STATES + 1]).collect();
    let mut measured = Vec::new();
    let mut white = vec![0.0; n];
    for (k, sighting) in sightings.iter().enumerate() {
        let both =
            [(Some(sighting.reference_m), 3, model.reference_m), (sighting.sensor_m, 4, model.sensor_m)];
        for (metres, state, sigma_m) in both {
            if let Some(metres) = metres {
                measured.push(metres);
                white.push(sigma_m * sigma_m);
                rows.push(vec![k * STATES, k * STATES + state]);
            }
        }
    }
    let picks = DMatrix::from_fn(rows.len(), n * STATES, |r, c| f64::from(u8::from(rows[r].contains(&c))));
    let covariance = &picks * all * picks.transpose() + DMatrix::from_diagonal(&DVector::from_vec(white));
    (picks * mean, covariance, DVector::from_vec(measured))
}

/// The filter's likelihood and the smoother's climb rates are those of one large normal distribution.
#[test]
fn filter_and_smoother_are_the_conditional_distribution() {
    let (sightings, model) = (few(), PathModel::of(&VALUES));
    let (mean, covariance, measured) = dense(&sightings, &model);
    let (n, m) = (sightings.len(), measured.len());
    let own = covariance.view((n, n), (m, m)).into_owned();
    let off = measured - mean.rows(n, m);
    let factor = own.cholesky().unwrap();
    let weighted = factor.solve(&off);
    let log_determinant = 2.0 * factor.l().diagonal().iter().map(|x| x.ln()).sum::<f64>();
    let expected = -off.dot(&weighted) - log_determinant;
    let likelihood = twice_log_likelihood(&sightings, &model);
    assert!((likelihood - expected).abs() < 1e-8 * expected.abs(), "{likelihood} {expected}");
    let climbs_mps = mean.rows(0, n) + covariance.view((0, n), (n, m)) * weighted;
    for (point, expected) in smoothed(&sightings, &model).iter().zip(climbs_mps.iter()) {
        assert!((point.climb_mps - expected).abs() < 1e-8, "{point:?} {expected}");
    }
}

/// Two steps of a second equal one of two, for accelerations that last long and that hardly last.
#[test]
fn a_transition_is_made_of_shorter_ones() {
    for value in [-3.0, 0.0, 3.0] {
        let model = PathModel::of(&[0.2, value, 0.0, 0.0, 0.3, 0.1, value]);
        let matrix = |rows: [[f64; STATES]; STATES]| DMatrix::from_fn(STATES, STATES, |r, c| rows[r][c]);
        let (one, two) = (model.over(1.0), model.over(2.0));
        let (f, q) = (matrix(one.matrix), matrix(one.noise));
        let (twice_f, twice_q) = (&f * &f, &f * &q * f.transpose() + q);
        assert!((twice_f - matrix(two.matrix)).amax() < 1e-12);
        let scale = twice_q.amax();
        assert!((twice_q - matrix(two.noise)).amax() < 1e-9 * scale, "{value}");
    }
}

/// Circles in thermals with glides between them; returns the climb rate as well.
fn path(time_s: f64) -> (f64, f64) {
    let wave = |size_m: f64, period_s: f64| {
        let rate = TAU / period_s;
        (size_m * (rate * time_s).sin(), size_m * rate * (rate * time_s).cos())
    };
    let parts = [wave(300.0, 1500.0), wave(40.0, 140.0), wave(6.0, 26.0)];
    parts.iter().fold((1500.0, 0.0), |(metres, mps), part| (metres + part.0, mps + part.1))
}

/// An hour with a fix a second in whole metres, with barometer and receiver late by these times; the receiver
/// wanders and filters its noise.
fn log(seed: u64, sensor_s: f64, receiver_s: f64) -> (Vec<Fix>, Vec<(u64, f64)>) {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut normal = move || -> f64 { StandardNormal.sample(&mut random) };
    let (mut wander_m, mut filtered_m) = (0.0, 0.0);
    let (mut fixes, mut readings) = (Vec::new(), Vec::new());
    for second in 0..4000_u32 {
        let time_s = f64::from(second);
        wander_m = 0.99 * wander_m + 0.3 * normal();
        filtered_m = 0.6 * filtered_m + 0.8 * normal();
        let time_us = u64::from(second) * 1_000_000;
        let altitude_m = (path(time_s - receiver_s).0 + wander_m + filtered_m).round();
        fixes.push(Fix { time_us, altitude_m, climb_mps: None });
        readings.push((time_us, (path(time_s - sensor_s).0 - 25.0 + 0.4 * normal()).round()));
    }
    (fixes, readings)
}

/// Regression of the true difference on the estimated one: slope, and rms of the remainder.
fn regressed(fixes: &[Fix], of: &dyn Fn(usize) -> f64, truth: &dyn Fn(f64) -> f64) -> (f64, f64) {
    let (mut squares, mut products, mut off) = (0.0, 0.0, 0.0);
    let inner = 20..fixes.len() - 20;
    for k in inner.clone() {
        let (estimate, truth) = (of(k), truth(k as f64));
        squares += estimate * estimate;
        products += estimate * truth;
        off += (estimate - truth) * (estimate - truth);
    }
    (products / squares, (off / inner.len() as f64).sqrt())
}

/// The slope of the true value on the estimate is one: the estimate's error is not correlated with it,
/// whichever of the two is late. The slope on the fixes' own altitudes is biased by their noise.
#[test]
fn what_comes_out_is_off_by_nothing_that_goes_with_it() {
    for (sensor_s, receiver_s) in [(0.0, 0.0), (2.0, 0.0), (5.0, 0.0), (0.0, 3.0)] {
        let (fixes, readings) = log(3, sensor_s, receiver_s);
        let points = super::path(&fixes, &readings, 1.0, &executor::Inline).unwrap();
        let truth = |time_s: f64| {
            if sensor_s == receiver_s {
                path(time_s).1
            } else {
                (path(time_s - receiver_s).0 - path(time_s - sensor_s).0) / (sensor_s - receiver_s)
            }
        };
        let (slope, off_mps) = regressed(&fixes, &|k| points[k].climb_mps, &truth);
        let own = |k: usize| 0.5 * (fixes[k + 1].altitude_m - fixes[k - 1].altitude_m);
        let (rough, rough_mps) = regressed(&fixes, &own, &truth);
        // About 4000 s of errors that last for about 10 s, a quarter of the climb rate in size: 0.25 /
        // sqrt(400) is one sigma.
        assert!((slope - 1.0).abs() < 0.04, "{sensor_s} {receiver_s}: {slope}");
        assert!(rough < 0.92 && off_mps < 0.5 * rough_mps, "{rough} {off_mps} {rough_mps}");
    }
}

/// A barometer that reads a twentieth too much, within a few tens of metres. On the path's altitude the
/// difference of both altitudes has that slope. On the fixes' own, averaged over four seconds, the slope is
/// drawn towards -1 by their noise.
#[test]
fn of_the_paths_altitude_a_scale_has_its_size() {
    let mut random = ChaCha8Rng::seed_from_u64(4);
    let mut normal = move || -> f64 { StandardNormal.sample(&mut random) };
    let wave = |time_s: f64| 6.0 * (TAU * time_s / 40.0).sin() + 4.0 * (TAU * time_s / 140.0).cos();
    let (mut fixes, mut readings) = (Vec::new(), Vec::new());
    for second in 0..4000_u32 {
        let height_m = wave(f64::from(second));
        let time_us = u64::from(second) * 1_000_000;
        fixes.push(Fix { time_us, altitude_m: 500.0 + height_m + 3.0 * normal(), climb_mps: None });
        readings.push((time_us, 480.0 + 1.05 * height_m + 0.4 * normal()));
    }
    let points = super::path(&fixes, &readings, 1.0, &executor::Inline).unwrap();
    let inner = 20..fixes.len() - 20;
    let count = inner.len() as f64;
    let fitted = |of: &dyn Fn(usize) -> f64| {
        let difference = |k: usize| readings[k].1 - fixes[k].altitude_m;
        let mean = inner.clone().map(of).sum::<f64>() / count;
        let mean_difference = inner.clone().map(difference).sum::<f64>() / count;
        let products = inner.clone().map(|k| (of(k) - mean) * (difference(k) - mean_difference)).sum::<f64>();
        products / inner.clone().map(|k| (of(k) - mean).powi(2)).sum::<f64>()
    };
    let by_path = fitted(&|k| points[k].altitude_m);
    let by_fixes = fitted(&|k| (k - 2..=k + 2).map(|near| fixes[near].altitude_m).sum::<f64>() / 5.0);
    // 4000 differences of 3 m on 5 m: 0.01 is one sigma.
    assert!((by_path - 0.05).abs() < 0.03, "{by_path}");
    assert!(by_fixes < 0.0, "{by_fixes}");
}

#[test]
fn a_delay_is_found_and_none_is_none() {
    for seed in 1..9 {
        for (sensor_s, receiver_s) in [(0.0, 0.0), (3.0, 0.0), (0.0, 2.0)] {
            let (fixes, readings) = log(seed, sensor_s, receiver_s);
            let together = sightings(&fixes, &readings, 1.0, 0.0);
            let model = PathModel::of(&fitted(&together, &[0.0; PARAMETERS], &executor::Inline));
            let found_s = delay_s(&fixes, &readings, 1.0, &model, &executor::Inline);
            assert_eq!(found_s, sensor_s - receiver_s, "{seed}");
        }
    }
}

/// For a parabola, between fixes and at the ends of the flight.
#[test]
fn a_mean_is_that_of_the_seconds_before_or_after() {
    let fixes: Vec<Fix> =
        (0..10_u64).map(|k| Fix { time_us: k * 1_000_000, altitude_m: 0.0, climb_mps: None }).collect();
    let climbs_mps: Vec<f64> = (0..10_u32).map(f64::from).collect();
    let before = means(&fixes, &climbs_mps, 2.5);
    for (k, mean) in before.iter().enumerate() {
        let span_s = 2.5_f64.min(k as f64);
        assert!((mean - (k as f64 - 0.5 * span_s)).abs() < 1e-9, "{k}: {mean}");
    }
    let after = means(&fixes, &climbs_mps, -2.5);
    assert!((after[3] - 4.25).abs() < 1e-9 && (after[9] - 9.0).abs() < 1e-9);
}

#[test]
fn of_next_to_nothing_no_climb_rate_is_made() {
    let fix = |second: u64| Fix { time_us: second * 1_000_000, altitude_m: 100.0, climb_mps: None };
    let fixes: Vec<Fix> = (0..50).map(fix).collect();
    let readings: Vec<(u64, f64)> = fixes.iter().map(|fix| (fix.time_us, 90.0)).collect();
    assert_eq!(super::path(&fixes, &readings, 1.0, &executor::Inline), None);
    assert_eq!(super::path(&[], &[], 1.0, &executor::Inline), None);
}
