//! The filter's own invariants. Agreement with a textbook f64 filter is tested in host-tests.

use super::whitening::Whitening;
use super::*;
use proptest::prelude::*;

fn noise(variance: f32) -> NoiseVariance {
    NoiseVariance::new(variance).unwrap()
}

/// The paper's problem in either shape: three biases and an altitude.
fn arrow() -> UdFilter<3, 1> {
    UdFilter::new([0.0; 3], [2.4, 5.5, 22.0], [0.0], [0.6]).unwrap()
}

fn dense() -> UdFilter<0, 4> {
    UdFilter::new([], [], [0.0; 4], [2.4, 5.5, 22.0, 0.6]).unwrap()
}

fn arrow_row(sensor: Option<usize>) -> Row<1> {
    Row { head: sensor, tail: [1.0], first: 0 }
}

fn dense_row(sensor: Option<usize>) -> Row<4> {
    let mut tail = [0.0, 0.0, 0.0, 1.0];
    if let Some(i) = sensor {
        tail[i] = 1.0;
    }
    Row { head: None, tail, first: sensor.unwrap_or(3) }
}

fn assert_valid<const H: usize, const T: usize>(filter: &UdFilter<H, T>) {
    for i in 0..H + T {
        assert!(filter.variance(i) >= 0.0);
        let exact = filter.covariance(i, i);
        assert!((filter.variance(i) - exact).abs() <= 1e-5 * exact.abs() + 1e-12);
    }
}

proptest! {
    /// Sparse and dense shapes are the same filter.
    #[test]
    fn both_shapes_agree(
        steps in prop::collection::vec((0_usize..4, -3.0_f32..3.0, 0.1_f32..10.0), 1..200),
    ) {
        let (mut arrow, mut dense) = (arrow(), dense());
        for (which, y, r) in steps {
            let sensor = which.checked_sub(1);
            let a = arrow.update(&arrow_row(sensor), y, noise(r)).unwrap();
            let d = dense.update(&dense_row(sensor), y, noise(r)).unwrap();
            prop_assert!((a.value - d.value).abs() < 1e-4);
            arrow.fold();
            dense.fold();
        }
        assert_valid(&arrow);
        assert_valid(&dense);
        for i in 0..4 {
            for j in 0..4 {
                let (a, d) = (arrow.covariance(i, j), dense.covariance(i, j));
                prop_assert!((a - d).abs() < 1e-4 * (1.0 + a.abs()), "P[{i}][{j}]: {a} {d}");
            }
        }
    }

    /// No measurement raises a variance, whatever its row.
    #[test]
    fn a_measurement_never_raises_a_variance(
        rows in prop::collection::vec((prop::array::uniform4(-2.0_f32..2.0), -5.0_f32..5.0, 0.01_f32..10.0), 1..100),
    ) {
        let mut filter = dense();
        for (tail, y, r) in rows {
            let before: Vec<f32> = (0..4).map(|i| filter.variance(i)).collect();
            filter.update(&Row { head: None, tail, first: 0 }, y, noise(r)).unwrap();
            filter.fold();
            assert_valid(&filter);
            for (i, before) in before.into_iter().enumerate() {
                prop_assert!(filter.variance(i) <= before * (1.0 + 1e-5));
            }
        }
    }

    /// Unusable input leaves no trace.
    #[test]
    fn a_refused_update_changes_nothing(
        bad in prop_oneof![Just(f32::NAN), Just(f32::INFINITY), Just(f32::NEG_INFINITY)],
        place in 0_usize..5,
        y in -1.0_f32..1.0,
    ) {
        let mut filter = dense();
        filter.update(&dense_row(Some(1)), y, noise(1.0)).unwrap();
        let before = filter.clone();
        let mut row = dense_row(Some(1));
        row.first = 0;
        let mut measurement = y;
        match place {
            4 => measurement = bad,
            i => row.tail[i] = bad,
        }
        prop_assert_eq!(filter.update(&row, measurement, noise(1.0)), Err(FilterError::NotFinite));
        prop_assert_eq!(&filter, &before);
    }

    /// Process noise adds to the covariance as in eq. 5, whichever routine adds it.
    #[test]
    fn noise_adds_to_the_covariance(
        ys in prop::collection::vec((0_usize..4, -3.0_f32..3.0), 0..30),
        index in 0_usize..4,
        q in 0.0_f32..5.0,
    ) {
        let mut filter = dense();
        for (which, y) in ys {
            filter.update(&dense_row(which.checked_sub(1)), y, noise(1.0)).unwrap();
            filter.fold();
        }
        let mut identity = [[0.0; 4]; 4];
        let mut direction = [[0.0; 1]; 4];
        direction[index][0] = 1.0;
        for (i, row) in identity.iter_mut().enumerate() {
            row[i] = 1.0;
        }
        let mut general = filter.clone();
        general.propagate(&identity, &[0.0; 4], &direction, &[q]).unwrap();
        let mut special = filter.clone();
        special.add_tail_noise(index, q).unwrap();
        for i in 0..4 {
            for j in 0..4 {
                let added = if i == index && j == index { q } else { 0.0 };
                let expected = filter.covariance(i, j) + added;
                for got in [general.covariance(i, j), special.covariance(i, j)] {
                    prop_assert!((got - expected).abs() < 2e-5 * (1.0 + expected.abs()), "{i}{j} {got} {expected}");
                }
            }
        }
    }
}

/// A row of eight states: a bias, four coefficients, the altitude.
fn long_row(sensor: Option<usize>, coefficients: [f32; 4]) -> Row<8> {
    let mut tail = [0.0; 8];
    tail[3..7].copy_from_slice(&coefficients);
    tail[7] = 1.0;
    if let Some(sensor) = sensor {
        tail[sensor] = 1.0;
    }
    Row { head: None, tail, first: sensor.unwrap_or(3) }
}

proptest! {
    /// The column-by-column updates equal the others to the bit: for eight states, with and without a gate.
    #[test]
    fn column_by_column_is_the_same_to_the_bit(
        steps in prop::collection::vec(
            (
                0_usize..4,
                prop::array::uniform4(-2.0_f32..2.0),
                -5.0_f32..5.0,
                0.01_f32..10.0,
                0.0_f32..0.5,
                prop::option::of((0.5_f32..20.0, any::<bool>())),
            ),
            1..60,
        ),
    ) {
        let variances = [2.4, 5.5, 22.0, 1.0, 0.5, 0.0, 3.0, 0.6];
        let mut plain = UdFilter::<0, 8>::new([], [], [0.0; 8], variances).unwrap();
        let mut columns = plain.clone();
        for (which, coefficients, y, r, q, gate) in steps {
            let row = long_row(which.checked_sub(1), coefficients);
            let gate = gate.map(|(limit, only_judges)| Gate { limit, excess: 0.5 * r, only_judges });
            prop_assert_eq!(
                plain.take::<true>(&row, y, noise(r), gate),
                columns.take_by_columns(&row, y, noise(r), gate)
            );
            plain.fold();
            columns.fold();
            let index = if which == 0 { 7 } else { which - 1 };
            plain.add_tail_noise(index, q).unwrap();
            columns.diffuse_by_columns(index, q).unwrap();
            prop_assert_eq!(&plain, &columns);
            prop_assert_eq!(columns.tail_variances(), core::array::from_fn(|state| plain.variance(state)));
        }
    }

    /// Unusable input leaves no trace here either.
    #[test]
    fn a_refused_update_by_columns_changes_nothing(
        bad in prop_oneof![Just(f32::NAN), Just(f32::INFINITY), Just(f32::NEG_INFINITY)],
        place in 0_usize..9,
    ) {
        let mut filter = UdFilter::<0, 8>::new([], [], [0.0; 8], [1.0; 8]).unwrap();
        filter.take_by_columns(&long_row(Some(1), [0.5; 4]), 1.0, noise(1.0), None).unwrap();
        let before = filter.clone();
        let mut row = long_row(Some(0), [0.5; 4]);
        let mut measurement = 1.0;
        match row.tail.get_mut(place) {
            Some(coefficient) => *coefficient = bad,
            None => measurement = bad,
        }
        prop_assert_eq!(
            filter.take_by_columns(&row, measurement, noise(1.0), None),
            Err(FilterError::NotFinite)
        );
        for variance in [bad, 3e38] {
            prop_assert!(filter.diffuse_by_columns(7, variance).is_err());
        }
        prop_assert_eq!(filter.diffuse_by_columns(8, 1.0), Err(FilterError::Shape));
        prop_assert_eq!(&filter, &before);
    }
}

#[test]
fn the_general_propagation_is_eqs_4_and_5() {
    let p0 = [[4.0, 1.0, 0.5], [1.0, 3.0, -0.2], [0.5, -0.2, 2.0]];
    let mut filter = UdFilter::with_covariance([1.0, -2.0, 0.5], &p0).unwrap();
    let a = [[1.0, 0.1, 0.0], [0.0, 0.9, 0.3], [-0.2, 0.0, 1.1]];
    let g = [[1.0, 0.0], [0.5, 1.0], [0.0, -1.0]];
    let q = [0.3, 0.7];
    let bu = [0.01, 0.02, -0.03];
    filter.propagate(&a, &bu, &g, &q).unwrap();
    filter.fold();
    let x0 = [1.0, -2.0, 0.5];
    for i in 0..3 {
        let x: f32 = (0..3).map(|k| a[i][k] * x0[k]).sum::<f32>() + bu[i];
        assert!((filter.tail()[i] - x).abs() < 1e-6);
        for j in 0..3 {
            let mut p = 0.0;
            for k in 0..3 {
                for l in 0..3 {
                    p += a[i][k] * p0[k][l] * a[j][l];
                }
            }
            for m in 0..2 {
                p += g[i][m] * q[m] * g[j][m];
            }
            assert!(
                (filter.covariance(i, j) - p).abs() < 1e-5,
                "P[{i}][{j}] {} {p}",
                filter.covariance(i, j)
            );
        }
    }
}

proptest! {
    /// If the transition is unit upper triangular, the short way equals the general one.
    #[test]
    fn the_upper_propagation_is_the_general_one(
        ys in prop::collection::vec((0_usize..4, -3.0_f32..3.0), 0..30),
        right in prop::array::uniform6(-1.5_f32..1.5),
    ) {
        let mut filter = dense();
        for (which, y) in ys {
            // The last step is left pending.
            filter.fold();
            filter.update(&dense_row(which.checked_sub(1)), y, noise(1.0)).unwrap();
        }
        let [a, b, c, d, e, f] = right;
        let transition = [[1.0, a, b, c], [0.0, 1.0, d, e], [0.0, 0.0, 1.0, f], [0.0, 0.0, 0.0, 1.0]];
        let mut general = filter.clone();
        general.propagate(&transition, &[0.0; 4], &[[]; 4], &[]).unwrap();
        general.fold();
        let [mut all, mut upper_rows] = [filter.clone(), filter];
        all.propagate_upper(&transition).unwrap();
        let [first, second, third, _] = transition;
        upper_rows.propagate_upper(&[first, second, third]).unwrap();
        prop_assert_eq!(&all, &upper_rows);
        all.fold();
        for i in 0..4 {
            prop_assert!((general.tail()[i] - all.tail()[i]).abs() < 1e-4);
            for j in 0..4 {
                let [one, other] = [&general, &all].map(|filter| filter.covariance(i, j));
                let scale = (general.variance(i) * general.variance(j)).sqrt();
                prop_assert!((one - other).abs() < 1e-4 * (scale + 1e-3), "{i}{j} {one} {other}");
            }
        }
    }
}

#[test]
fn a_propagation_by_what_is_no_number_says_so() {
    let mut transition = [[0.0; 4]; 4];
    transition[0][3] = f32::NAN;
    let mut filter = dense();
    assert_eq!(filter.propagate_upper(&transition), Err(FilterError::NotFinite));
}

#[test]
fn a_propagation_has_no_more_rows_than_states() {
    assert_eq!(dense().propagate_upper(&[[0.0; 4]; 5]), Err(FilterError::Shape));
    assert_eq!(dense().propagate_row(4, &[0.0; 4]), Err(FilterError::Shape));
}

#[test]
fn correlated_noise_is_the_same_as_the_vector_update() {
    // One state, two readings whose noises are correlated: P+ = 1 / (1/p + 1' R^-1 1).
    let r = [[2.0, 1.5], [1.5, 3.0]];
    let whitening = Whitening::new(&r).unwrap();
    let mut filter = UdFilter::<0, 1>::new([], [], [0.0], [4.0]).unwrap();
    let found = filter.update_vector(&[1.0, 2.0], &[[1.0], [1.0]], &whitening).unwrap();
    let det = 2.0 * 3.0 - 1.5 * 1.5;
    let information = (3.0 + 2.0 - 2.0 * 1.5) / det;
    let variance = 1.0 / (0.25 + information);
    assert!((filter.variance(0) - variance).abs() < 1e-6);
    let weighted = ((3.0 - 1.5) * 1.0 + (2.0 - 1.5) * 2.0) / det;
    assert!((filter.tail()[0] - variance * weighted).abs() < 1e-6);
    // The vector's NIS, nu' S^-1 nu with S = R + p 11'.
    let s = [[6.0, 5.5], [5.5, 7.0]];
    let det = 6.0 * 7.0 - 5.5 * 5.5;
    let nis = (s[1][1] - 2.0 * s[0][1] * 2.0 + s[0][0] * 4.0) / det;
    assert!((found.iter().map(Innovation::nis).sum::<f32>() - nis).abs() < 1e-5);
}

#[test]
fn a_matrix_that_is_no_covariance_is_refused() {
    assert_eq!(Whitening::new(&[[1.0, 2.0], [2.0, 1.0]]), Err(FilterError::NotPositive));
    assert_eq!(Whitening::new(&[[f32::NAN]]), Err(FilterError::NotFinite));
    let filter = UdFilter::<0, 2>::with_covariance([0.0; 2], &[[1.0, 1.1], [1.1, 1.0]]);
    assert_eq!(filter, Err(FilterError::NotPositive));
    assert_eq!(NoiseVariance::new(0.0), Err(FilterError::NotPositive));
    assert_eq!(NoiseVariance::new(f32::NAN), Err(FilterError::NotFinite));
    assert_eq!(UdFilter::<0, 1>::new([], [], [0.0], [-1.0]), Err(FilterError::NotPositive));
    assert_eq!(UdFilter::<0, 1>::new([], [], [f32::NAN], [1.0]), Err(FilterError::NotFinite));
}

#[test]
fn noise_that_would_couple_head_states_is_refused() {
    let mut filter = arrow();
    assert_eq!(filter.add_tail_noise(0, 1.0), Err(FilterError::Shape));
    assert_eq!(filter.add_head_noise(3, 1.0), Err(FilterError::Shape));
    assert_eq!(filter.add_head_noise(0, -1.0), Err(FilterError::NotPositive));
    assert_eq!(filter, arrow());
    filter.add_head_noise(2, 1.5).unwrap();
    assert!((filter.variance(2) - 23.5).abs() < 1e-5);
}

#[test]
fn a_state_known_exactly_stays_so_and_harms_nothing() {
    let mut filter = UdFilter::<0, 2>::new([], [], [1.0, 0.0], [0.0, 0.0]).unwrap();
    filter.update(&Row { head: None, tail: [1.0, 1.0], first: 0 }, 5.0, noise(1.0)).unwrap();
    filter.fold();
    assert_eq!(filter.tail(), &[1.0, 0.0]);
    filter.add_tail_noise(1, 2.0).unwrap();
    assert_eq!((filter.variance(0), filter.variance(1)), (0.0, 2.0));
}

/// Near 1,000 units f32 resolves 6e-5; towards the end of an hour at 200 Hz sigma is 1.2e-3 and a step about
/// 1e-6. The readings rise by one half-way: plain accumulation does not follow.
#[test]
fn the_folded_state_keeps_what_f32_would_lose() {
    let mut filter = UdFilter::<0, 1>::new([], [], [1_000.0], [1.0]).unwrap();
    let row = Row { head: None, tail: [1.0], first: 0 };
    let (mut exact, mut variance) = (1_000.0_f64, 1.0_f64);
    let mut plain = 1_000.0_f32;
    for k in 0..720_000_u32 {
        let dither = f32::from((k.wrapping_mul(2_654_435_761) >> 16) as u16) / 65_536.0;
        let y = if k < 360_000 { 1_000.0 } else { 1_001.0 } + dither;
        filter.update(&row, y, noise(1.0)).unwrap();
        filter.fold();
        let gain = variance / (variance + 1.0);
        exact += gain * (f64::from(y) - exact);
        plain += gain as f32 * (y - plain);
        variance *= 1.0 - gain;
    }
    let sigmas = |state: f32| (f64::from(state) - exact).abs() / variance.sqrt();
    // The value read out is rounded to half of 6e-5.
    let read_out = 0.5 * f64::from(f32::EPSILON) * 1_024.0 / variance.sqrt();
    assert!(sigmas(filter.tail()[0]) < 0.05 + read_out, "{} sigma", sigmas(filter.tail()[0]));
    assert!(sigmas(plain) > 0.5, "the comparison must be able to fail: {} sigma", sigmas(plain));
}
