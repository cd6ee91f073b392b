//! `diagnose` on a log of one barometer and one receiver, with a fix a second in whole metres and no climb
//! rate: the most common kind. It shows only the difference of the two delays, whose sign names the sensor.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use std::f64::consts::TAU;

use model::Model;
use pylon::diagnose::{Diagnosis, NamedReplay, diagnose, text};
use pylon::flight::{Channel, Column, Flight};
use pylon::replay::Replay;
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution as _, StandardNormal};

/// Circles in thermals, and glides between them, metres.
fn altitude_m(time_s: f64) -> f64 {
    let sine = |size_m: f64, period_s: f64| size_m * (TAU * time_s / period_s).sin();
    1500.0 + sine(300.0, 1500.0) + sine(40.0, 140.0) + sine(6.0, 26.0)
}

/// Forty minutes, with the barometer and the receiver late by these delays, seconds.
fn log(seed: u64, baro_s: f64, receiver_s: f64) -> Flight {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut normal = move || -> f64 { StandardNormal.sample(&mut random) };
    let mut flight = Flight::default();
    let (mut receiver, mut baro) = (Column::default(), Column::default());
    let (mut wander_m, mut filtered_m) = (0.0, 0.0);
    for second in 0..2400 {
        let time_s = f64::from(second);
        wander_m = 0.99 * wander_m + 0.3 * normal();
        filtered_m = 0.6 * filtered_m + 0.8 * normal();
        flight.time_s.push(time_s);
        receiver.push(Some((altitude_m(time_s - receiver_s) + wander_m + filtered_m).round() as f32));
        baro.push(Some((altitude_m(time_s - baro_s) - 25.0 + 0.4 * normal()).round() as f32));
    }
    flight.set_channel(Channel::GpsAltM, receiver);
    flight.set_channel(Channel::BaroAltM, baro);
    flight
}

fn diagnosed(flight: &Flight) -> Diagnosis {
    let model = Model::default();
    let replay = Replay::to_diagnose(flight, &model, None).unwrap();
    let diagnosis = diagnose(&[NamedReplay::new("log".to_owned(), replay)], &[], &mut || ());
    println!("{}", text(&diagnosis, false));
    diagnosis
}

fn identified(diagnosis: &Diagnosis) -> Vec<&str> {
    diagnosis.missing().collect()
}

#[test]
fn of_a_log_without_errors_but_noise_nothing_is_claimed() {
    for seed in 1..4 {
        let diagnosis = diagnosed(&log(seed, 0.0, 0.0));
        assert_eq!(identified(&diagnosis), Vec::<&str>::new());
        assert!(
            diagnosis.sensors.values().all(|sensor| sensor.indistinguishable.is_empty()),
            "{diagnosis:?}"
        );
    }
}

/// Only the late sensor is named, with its delay to within two of the stated sigmas.
#[test]
fn a_late_sensor_and_a_late_receiver_are_delays_and_nothing_else() {
    for (seed, baro_s, receiver_s, late) in [
        (5, 2.0, 0.0, "baro.lag"),
        (6, 0.0, 1.5, "gps.latency"),
        (9, 4.0, 0.0, "baro.lag"),
        (10, 0.0, 2.5, "gps.latency"),
    ] {
        let diagnosis = diagnosed(&log(seed, baro_s, receiver_s));
        assert_eq!(identified(&diagnosis), [late]);
        assert_eq!(diagnosis.suspects().count(), 0, "{diagnosis:?}");
        let mut candidates = diagnosis.sensors.values().flat_map(|sensor| &sensor.candidates);
        let found = candidates.find(|candidate| candidate.effect == late).unwrap();
        let off_s = found.coefficient - (baro_s + receiver_s);
        assert!(off_s.abs() < 2.0 * found.sigma && found.sigma < 0.15 * found.coefficient, "{found:?}");
    }
}

/// Half a second may be the barometer's, or that of a receiver that predicts.
#[test]
fn a_small_delay_is_a_set_of_two_with_its_probabilities() {
    let diagnosis = diagnosed(&log(7, 0.6, 0.0));
    let baro = &diagnosis.sensors["baro"];
    let mut set = baro.indistinguishable[0].clone();
    set.sort_unstable();
    assert_eq!(set, ["baro.lag", "gps.latency"]);
    let probabilities = &baro.probabilities[0];
    assert!(probabilities[0] >= probabilities[1] && probabilities[1] >= 0.05, "{probabilities:?}");
    assert!(probabilities.iter().sum::<f64>() <= 1.0 + 1e-9);
}

/// A drift is named by its probability against the other effects that the flight can test; causes that no
/// column of it could distinguish from it are reported.
#[test]
fn a_drift_is_named_and_the_temperature_that_was_not_recorded_is_said() {
    let mut named = 0;
    for seed in [11, 13, 14, 15] {
        let mut flight = log(seed, 0.0, 0.0);
        let old = flight.channel(Channel::BaroAltM).unwrap();
        let mut column = Column::default();
        for (row, time_s) in flight.time_s.iter().enumerate() {
            column.push(old.get(row).map(|metres| (f64::from(metres) + 0.015 * time_s).round() as f32));
        }
        flight.set_channel(Channel::BaroAltM, column);
        let diagnosis = diagnosed(&flight);
        let baro = &diagnosis.sensors["baro"];
        let drift = baro.candidates.iter().find(|candidate| candidate.effect == "baro.drift").unwrap();
        let probability = drift.probability.unwrap();
        // Four tries at three sigma: one false alarm in a hundred choices of seeds.
        assert!((drift.coefficient - 0.015).abs() < 3.0 * drift.sigma, "{drift:?}");
        let others = baro.candidates.iter().filter(|candidate| candidate.effect != "baro.drift");
        assert!(others.clone().all(|other| other.probability < Some(0.5)), "{baro:?}");
        if identified(&diagnosis) == ["baro.drift"] {
            named += 1;
            assert!(probability >= 0.95, "{drift:?}");
            assert!(baro.advice.contains("baro_temp_c"), "{}", baro.advice);
            let said = text(&diagnosis, false);
            assert!(said.contains("missing, strongest first: baro.drift ("), "{said}");
        } else {
            // Just below the limit it is the first of a set, and no other effect is named.
            assert_eq!(identified(&diagnosis), Vec::<&str>::new());
            assert!(probability > 0.5 && baro.indistinguishable[0][0] == "baro.drift", "{baro:?}");
        }
    }
    assert!(named > 0);
}

/// A delay that no barometer has is a misfit without a name: neither the lag is named, nor the next best
/// effect.
#[test]
fn a_delay_beyond_nature_is_no_effect_and_the_next_best_is_none_either() {
    let diagnosis = diagnosed(&log(12, 7.5, 0.0));
    assert_eq!(identified(&diagnosis), Vec::<&str>::new());
    assert_eq!(diagnosis.verdict.name(), "unknown_effect");
    let said = text(&diagnosis, false);
    assert!(said.contains("its plausible range is"), "{said}");
}

fn with_barometer(of: impl Fn(usize, f32) -> f32) -> Flight {
    let mut flight = log(8, 0.0, 0.0);
    let receiver = flight.channel(Channel::GpsAltM).unwrap();
    let mut column = Column::default();
    (0..flight.rows()).for_each(|row| column.push(receiver.get(row).map(|altitude_m| of(row, altitude_m))));
    flight.set_channel(Channel::BaroAltM, column);
    flight
}

#[test]
fn a_stuck_barometer_is_refused_as_that() {
    let flight = with_barometer(|_, _| 640.0);
    let refused = Replay::to_diagnose(&flight, &Model::default(), None).map(|_| ()).unwrap_err().to_string();
    assert!(refused.starts_with("the barometer is stuck"), "{refused}");
}

#[test]
fn a_copied_barometer_is_named_as_that_and_nothing_else() {
    let flight = with_barometer(|_, altitude_m| altitude_m + 30.0);
    let refused = Replay::to_diagnose(&flight, &Model::default(), None).map(|_| ()).unwrap_err().to_string();
    assert!(refused.starts_with("no barometer: ") && refused.contains("copy of the receiver"), "{refused}");
}
