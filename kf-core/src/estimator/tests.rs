//! A tick taken at once equals the tick taken one reading at a time.

use super::*;
use crate::config::{
    MonitorConfig, QualityConfig, ReferenceConfig, SecondCorrection, SensorConfig, SigmaSource,
};
use crate::effect::{EffectId, EffectTerm};
use proptest::prelude::*;

fn config<const E: usize>() -> MissionConfig<E> {
    let sensor = |sigma_m, prior_sigma_m| SensorConfig {
        sigma_m,
        correlation_time_s: 0.0,
        prior_bias_m: 0.0,
        prior_sigma_m,
        wander_m_per_sqrt_s: 0.0,
    };
    MissionConfig {
        settling_s: 10.0,
        reference: ReferenceConfig {
            sigma_m: 25.0,
            correlation_time_s: 0.0,
            prior_altitude_m: Some(2100.0),
            prior_sigma_m: 50.0,
            climb_rate: None,
            lost_after_s: 2.0,
        },
        latitude_deg: 45.0,
        sensors: [sensor(50.0, 100.0), sensor(70.0, 150.0), sensor(150.0, 300.0)],
        monitor: MonitorConfig {
            sigma: SigmaSource::Residual,
            multiplier: 1.0,
            window_s: 3.0,
            persistence_s: 0.0,
            reference_check: false,
        },
        second_correction: SecondCorrection::Off,
        quality: QualityConfig {
            minimum_duration_s: 30.0,
            trimmed_altitude_m: 10.0,
            trimmed_airspeed_mps: 3.0,
            reference_drift_m: 5.0,
            minimum_satellites: 5,
            vertical_accuracy_m: 10.0,
            bias_drift_sigmas: 1.0,
            implausible_share: 0.05,
        },
        estimated_effects: [EffectTerm::new(EffectId::BaroDynamicPressure, 0.0, 0.5); E],
        constant_effects: heapless::Vec::new(),
    }
}

fn noise(variance_m2: f32) -> MeasurementNoise {
    MeasurementNoise::from_variance_m2(variance_m2).unwrap()
}

fn together_is_one_by_one<const HEAD: usize, const TAIL: usize, const E: usize>(ticks: &[([f32; 4], f32)]) {
    let mut together = Estimator::<HEAD, TAIL, E>::new(&config(), 2100.0).unwrap();
    let mut one_by_one = together.clone();
    let n = [noise(2500.0), noise(4900.0), noise(22500.0)];
    for (y, phi) in ticks {
        let own = [[0.0; E], [0.0; E], [*phi; E]];
        // An effect on the reference too; zero selects the row without effects.
        let reference = [if *phi < 100.0 { 0.0 } else { *phi - 300.0 }; E];
        let all = together
            .update_together(y[0], &reference, noise(625.0), &[y[1], y[2], y[3]], &own, &n, |_| true)
            .unwrap();
        let each = (
            one_by_one.update_reference(y[0], &reference, noise(625.0)).unwrap(),
            [
                one_by_one.update_sensor(Sensor::ImuMaster, y[1], &own[0], n[0], None).unwrap(),
                one_by_one.update_sensor(Sensor::ImuSlave, y[2], &own[1], n[1], None).unwrap(),
                one_by_one.update_sensor(Sensor::Baro, y[3], &own[2], n[2], None).unwrap(),
            ],
        );
        one_by_one.fold();
        assert_eq!(all, each);
        assert_eq!(together, one_by_one);
        let states = HEAD + TAIL;
        let entries = (0..states).flat_map(|row| (row..states).map(move |column| (row, column)));
        let entries: Vec<u32> = entries.map(|(i, j)| together.covariance(i, j).to_bits()).collect();
        let triangle: Vec<u32> = together.covariance_triangle().iter().map(|entry| entry.to_bits()).collect();
        assert_eq!(triangle, entries);
    }
}

proptest! {
    #[test]
    fn a_tick_at_once_is_the_tick_one_by_one(
        ticks in prop::collection::vec((prop::array::uniform4(1_500.0_f32..2_500.0), 0.0_f32..500.0), 1..50),
    ) {
        together_is_one_by_one::<3, 1, 0>(&ticks);
        together_is_one_by_one::<3, 2, 1>(&ticks);
        together_is_one_by_one::<0, 4, 0>(&ticks);
        together_is_one_by_one::<0, 5, 1>(&ticks);
    }

    #[test]
    fn a_tick_with_anything_not_finite_changes_nothing(
        bad in prop_oneof![Just(f32::NAN), Just(f32::INFINITY), Just(f32::NEG_INFINITY), Just(3e38_f32)],
        place in 0_usize..6,
    ) {
        let mut estimator = Estimator::<3, 2, 1>::new(&config(), 2100.0).unwrap();
        let n = [noise(2500.0), noise(4900.0), noise(22500.0)];
        estimator.update_together(2100.0, &[3.0], noise(625.0), &[2110.0, 2030.0, 1980.0], &[[0.0], [0.0], [9.0]], &n, |_| true).unwrap();
        let before = estimator.clone();
        let mut y = [2100.0, 2110.0, 2030.0, 1980.0];
        let (mut phi, mut psi) = (9.0, 3.0);
        match place {
            4 => phi = bad,
            5 => psi = bad,
            i => y[i] = bad,
        }
        let result =
            estimator.update_together(y[0], &[psi], noise(625.0), &[y[1], y[2], y[3]], &[[0.0], [0.0], [phi]], &n, |_| true);
        // A reading of 3e38 m is absurd but finite: scaled down, it can be taken. As a regressor, its square
        // overflows.
        if bad == 3e38 && place < 4 {
            prop_assert!(result.is_ok());
        } else {
            prop_assert_eq!(result, Err(FilterError::NotFinite));
            prop_assert_eq!(&estimator, &before);
        }
    }
}

#[test]
fn the_outside_sees_the_papers_order_and_units() {
    for covariance in [
        Estimator::<3, 2, 1>::new(&config(), 2100.0).map(|e| core::array::from_fn(|i| e.covariance(i, i))),
        Estimator::<0, 5, 1>::new(&config(), 2100.0).map(|e| core::array::from_fn(|i| e.covariance(i, i))),
    ] {
        let expected: [f32; 5] = [2500.0, 10_000.0, 22_500.0, 90_000.0, 0.25];
        let covariance: [f32; 5] = covariance.unwrap();
        for (got, expected) in covariance.into_iter().zip(expected) {
            assert!((got - expected).abs() < 1e-5 * expected, "{got} {expected}");
        }
    }
}

#[test]
fn a_shape_that_does_not_fit_is_refused() {
    assert_eq!(Estimator::<3, 1, 1>::new(&config(), 0.0), Err(ConfigError::Shape));
    assert_eq!(Estimator::<1, 3, 0>::new(&config(), 0.0), Err(ConfigError::Shape));
    assert_eq!(Estimator::<3, 1, 0>::new(&config(), f32::NAN), Err(ConfigError::OutOfRange));
}
