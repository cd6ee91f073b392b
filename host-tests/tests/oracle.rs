//! kf-core's f32 filter against a textbook filter in f64.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use host_tests::textbook::Textbook;
use kf_core::config::MissionConfig;
use kf_core::effect::{EffectId, EffectTerm};
use kf_core::estimator::{Estimator, MeasurementNoise};
use kf_core::sensor::Sensor;
use kf_core::ud::UdFilter;
use kf_core::ud::whitening::Whitening;
use model::Model;
use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

const NOISE_M2: [f32; 4] = [625.0, 2_500.0, 4_900.0, 22_500.0];
/// Altitude of the trimmed flight and the sensors' biases, metres.
const TRUTH_M: [f64; 4] = [2_050.0, 12.0, -72.8909, -121.8691];

/// The paper's preset with `E` effects on the barometer as states.
fn paper<const E: usize>() -> MissionConfig<E> {
    let config: MissionConfig<0> = Model::preset("paper").unwrap().mission_config().unwrap();
    MissionConfig {
        settling_s: config.settling_s,
        reference: config.reference,
        latitude_deg: config.latitude_deg,
        sensors: config.sensors,
        monitor: config.monitor,
        second_correction: config.second_correction,
        quality: config.quality,
        estimated_effects: [EffectTerm::new(EffectId::BaroDynamicPressure, 0.0, 0.5); E],
        constant_effects: config.constant_effects,
    }
}

/// One filter of each kind on the same readings.
struct Twins<const HEAD: usize, const TAIL: usize, const E: usize> {
    ours: Estimator<HEAD, TAIL, E>,
    textbook: Textbook,
    noise: [MeasurementNoise; 4],
    random: ChaCha8Rng,
}

impl<const HEAD: usize, const TAIL: usize, const E: usize> Twins<HEAD, TAIL, E> {
    fn new(seed: u64) -> Self {
        let paper_only = Textbook::paper();
        let mut covariance = DMatrix::zeros(4 + E, 4 + E);
        covariance.view_mut((0, 0), (4, 4)).copy_from(&paper_only.covariance);
        let mut state = DVector::zeros(4 + E);
        state.rows_mut(0, 4).copy_from(&paper_only.state);
        for j in 0..E {
            covariance[(4 + j, 4 + j)] = 0.25;
        }
        Self {
            ours: Estimator::new(&paper(), 2_100.0).unwrap(),
            textbook: Textbook::new(state, covariance),
            noise: NOISE_M2.map(|r| MeasurementNoise::from_variance_m2(r).unwrap()),
            random: ChaCha8Rng::seed_from_u64(seed),
        }
    }

    fn tick(&mut self, regressors_m: [f32; E]) {
        // Both get exactly the same numbers: the reading as f32.
        let mut y = [0.0_f32; 4];
        for (i, y) in y.iter_mut().enumerate() {
            let white: f64 = StandardNormal.sample(&mut self.random);
            let bias = if i == 0 { 0.0 } else { TRUTH_M[i] };
            *y = (TRUTH_M[0] + bias + f64::from(NOISE_M2[i]).sqrt() * white) as f32;
        }
        let own = [[0.0; E], [0.0; E], regressors_m];
        let noise = [self.noise[1], self.noise[2], self.noise[3]];
        self.ours
            .update_together(y[0], &[0.0; E], self.noise[0], &[y[1], y[2], y[3]], &own, &noise, |_| true)
            .unwrap();
        let h = Textbook::paper_observation(&own.map(|row| row.iter().map(|x| f64::from(*x)).collect()));
        let y = DVector::from_iterator(4, y.iter().map(|x| f64::from(*x)));
        self.textbook.update(&y, &h, &Textbook::paper_noise()).unwrap();
    }

    fn state(&self) -> Vec<f64> {
        let mut state = vec![self.ours.altitude_m()];
        state.extend(Sensor::ALL.map(|sensor| self.ours.bias_m(sensor)));
        state.extend(self.ours.coefficients());
        state.into_iter().map(f64::from).collect()
    }

    /// Largest difference of a state, in the textbook's posterior sigmas.
    fn apart_sigmas(&self) -> f64 {
        let apart = |(i, x): (usize, f64)| (x - self.textbook.state[i]).abs() / self.textbook.sigma(i);
        self.state().into_iter().enumerate().map(apart).fold(0.0, f64::max)
    }

    /// Largest relative difference of a variance; all of kf-core's must be positive.
    fn variances_apart(&self) -> f64 {
        let apart = |i: usize| {
            let ours = f64::from(self.ours.covariance(i, i));
            assert!(ours > 0.0, "variance {i} is {ours}");
            (ours / self.textbook.covariance[(i, i)] - 1.0).abs()
        };
        (0..4 + E).map(apart).fold(0.0, f64::max)
    }
}

/// Section 3.2's problem for section 3's flight: 70 s at 200 Hz, compared at every step.
///
/// The tolerance is f32's own: the altitude is 2,050 m, read out with half an ulp of 2^-13 m. Each of the k
/// updates so far rounds the scaled state, at most 5 units of 64 m, and its gain, by a few parts in 2^24; the
/// roundings add up as a random walk.
#[test]
fn the_papers_problem_agrees_at_every_step_within_rounding() {
    for seed in 0..5 {
        let mut twins = Twins::<3, 1, 0>::new(seed);
        for k in 1..=14_000_u32 {
            twins.tick([]);
            let steps = f64::from(k);
            let read_out = 2.0_f64.powi(-13);
            let walk = 8.0 * 320.0 * 2.0_f64.powi(-24) * steps.sqrt().min(64.0);
            for (i, (ours, exact)) in twins.state().iter().zip(twins.textbook.state.iter()).enumerate() {
                let apart = (ours - exact).abs();
                assert!(apart < read_out + walk, "seed {seed}, step {k}, state {i}: {ours} {exact}");
            }
            // Twelve roundings a tick end up in one entry of D, each at most 2^-24. (They are not
            // independent: a ratio near 1 rounds the same way for many ticks.)
            let variances = twins.variances_apart();
            let bound = 12.0 * steps * 2.0_f64.powi(-24) + 1e-6;
            assert!(variances < bound, "seed {seed}, step {k}: {variances} {bound}");
        }
    }
}

#[test]
fn an_hour_ends_within_a_twentieth_of_a_sigma() {
    let mut twins = Twins::<3, 1, 0>::new(1);
    for k in 0..720_000 {
        twins.tick([]);
        if k % 10_000 == 0 {
            twins.variances_apart();
        }
    }
    let apart = twins.apart_sigmas();
    println!("f32 against f64 after 720,000 ticks: {apart:.4} posterior sigma");
    assert!(apart <= 0.05, "{apart}");
}

#[test]
fn four_million_ticks_end_within_a_tenth_of_a_sigma() {
    let mut twins = Twins::<3, 1, 0>::new(2);
    let mut worst: f64 = 0.0;
    for k in 0..4_000_000 {
        twins.tick([]);
        if k % 100_000 == 99_999 {
            twins.variances_apart();
            worst = worst.max(twins.apart_sigmas());
        }
    }
    println!("f32 against f64 over 4,000,000 ticks: at worst {worst:.4} posterior sigma");
    assert!(worst <= 0.1, "{worst}");
}

#[test]
fn effects_as_states_agree_in_both_shapes() {
    // The airspeed is swept, so that the regressors diverge.
    fn run<const HEAD: usize, const TAIL: usize, const E: usize>() -> (f64, f64) {
        let mut twins = Twins::<HEAD, TAIL, E>::new(3);
        for k in 0..14_000_u32 {
            let phase = k as f32 * 0.005;
            let phi = core::array::from_fn(|j| 180.0 + 90.0 * libm::sinf(phase * (0.3 + j as f32 * 0.17)));
            twins.tick(phi);
        }
        (twins.apart_sigmas(), twins.variances_apart())
    }
    let results = [run::<3, 2, 1>(), run::<0, 5, 1>(), run::<3, 5, 4>(), run::<0, 8, 4>()];
    println!("apart (sigmas, variances): {results:?}");
    for (sigmas, variances) in results {
        assert!(sigmas < 0.05, "{sigmas}");
        assert!(variances < 1e-2, "{variances}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]
    /// Eqs 4 to 8 in full: any A, B u, G, Q, H and a correlated R.
    #[test]
    fn the_general_filter_is_eqs_4_to_8(seed in any::<u64>()) {
        const N: usize = 4;
        const M: usize = 3;
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut normal = |scale: f64| {
            let x: f64 = StandardNormal.sample(&mut random);
            f64::from((x * scale) as f32)
        };
        let mut positive = |n: usize, floor: f64| {
            let l = DMatrix::from_fn(n, n, |_, _| normal(1.0));
            // Through f32, so that both filters see the same numbers.
            (&l * l.transpose() + DMatrix::identity(n, n) * floor).map(|x| f64::from(x as f32))
        };
        let p0 = positive(N, 0.5);
        let r = positive(M, 0.5);
        let mut textbook = Textbook::new(DVector::zeros(N), p0.clone());
        let mut ours = UdFilter::<0, N>::with_covariance([0.0; N], &matrix(&p0)).unwrap();
        let whitening = Whitening::<M>::new(&matrix(&r)).unwrap();
        for _ in 0..50 {
            let a = DMatrix::identity(N, N) * 0.9 + DMatrix::from_fn(N, N, |_, _| normal(0.1));
            let a = a.map(|x| f64::from(x as f32));
            let g = DMatrix::from_fn(N, 2, |_, _| normal(0.5));
            let q = DMatrix::from_diagonal(&DVector::from_fn(2, |_, _| normal(0.5).abs()));
            let bu = DVector::from_fn(N, |_, _| normal(0.5));
            let h = DMatrix::from_fn(M, N, |_, _| normal(1.0));
            let y = DVector::from_fn(M, |_, _| normal(3.0));
            textbook.propagate(&a, &bu, &g, &q);
            ours.propagate(&matrix::<N, N>(&a), &vector(&bu), &matrix::<N, 2>(&g), &vector(&q.diagonal())).unwrap();
            let found = ours.update_vector(&vector(&y), &matrix::<M, N>(&h), &whitening).unwrap();
            let (innovation, s) = textbook.update(&y, &h, &r).unwrap();
            let nis = (innovation.transpose() * s.try_inverse().unwrap() * &innovation)[0];
            let ours_nis: f32 = found.iter().map(kf_core::ud::Innovation::nis).sum();
            prop_assert!((f64::from(ours_nis) / nis - 1.0).abs() < 1e-3, "{ours_nis} {nis}");
        }
        for i in 0..N {
            let sigmas = (f64::from(ours.tail()[i]) - textbook.state[i]).abs() / textbook.sigma(i);
            prop_assert!(sigmas < 1e-3, "state {i}: {sigmas} sigma");
            for j in 0..N {
                let apart = (f64::from(ours.covariance(i, j)) - textbook.covariance[(i, j)]).abs();
                prop_assert!(apart < 1e-4 * textbook.sigma(i) * textbook.sigma(j), "P[{i}][{j}]");
            }
        }
    }
}

fn matrix<const R: usize, const C: usize>(m: &DMatrix<f64>) -> [[f32; C]; R] {
    core::array::from_fn(|i| core::array::from_fn(|j| m[(i, j)] as f32))
}

fn vector<const N: usize>(v: &DVector<f64>) -> [f32; N] {
    core::array::from_fn(|i| v[i] as f32)
}
