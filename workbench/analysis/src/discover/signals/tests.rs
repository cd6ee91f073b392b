use super::*;

/// Blocks of 2 s, the first two captive, with these signals.
fn blocks(values: &[&[f64]]) -> Blocks {
    let count = values[0].len();
    Blocks {
        time_s: (0..count).map(|k| 100.0 + 2.0 * k as f64).collect(),
        free: (0..count).map(|k| k >= 2).collect(),
        values: values.iter().map(|values| values.to_vec()).collect(),
        heading: None,
    }
}

fn factor(operator: Operator, power: Power, is_signed: bool) -> Factor {
    Factor { signal: 0, operator, power, is_signed }
}

fn made(values: &[f64], operator: Operator) -> Vec<f64> {
    blocks(&[values]).factor(&factor(operator, Power::One, true)).unwrap()
}

fn assert_near(found: &[f64], wanted: &[f64]) {
    assert_eq!(found.len(), wanted.len());
    for (one, other) in found.iter().zip(wanted) {
        // Rounding.
        assert!((one - other).abs() < 1e-12 * other.abs().max(1.0), "{found:?} {wanted:?}");
    }
}

/// A power is that power of every block; a magnitude for a signal with both signs, else the root; no inverse
/// of zero.
#[test]
fn powers_are_powers() {
    let of = |values: &[f64], power, is_signed| {
        blocks(&[values]).factor(&factor(Operator::Itself, power, is_signed))
    };
    let both = [-2.0, 4.0, 9.0];
    assert_eq!(of(&both, Power::One, true).unwrap(), both);
    assert_eq!(of(&both, Power::Two, true).unwrap(), [4.0, 16.0, 81.0]);
    assert_eq!(of(&both, Power::Three, true).unwrap(), [-8.0, 64.0, 729.0]);
    assert_eq!(of(&both, Power::MagnitudeOrRoot, true).unwrap(), [2.0, 4.0, 9.0]);
    assert_eq!(of(&both, Power::MagnitudeOrRoot, false).unwrap(), [0.0, 2.0, 3.0]);
    assert_eq!(of(&both, Power::Inverse, true).unwrap(), [-0.5, 0.25, 1.0 / 9.0]);
    assert_eq!(of(&[1.0, 0.0], Power::Inverse, true), None);
}

/// The deviation is from captive flight's mean, the rate is the difference of the neighbours over their time,
/// and the integral begins with free flight, by the trapezium rule, which is exact for a straight line.
#[test]
fn deviation_rate_and_integral_are_what_they_are_called() {
    assert_near(&made(&[1.0, 3.0, 7.0, 2.0], Operator::Deviation), &[-1.0, 1.0, 5.0, 0.0]);
    // Squares of the time since the beginning: twice the time, and at the ends the one neighbour's slope.
    assert_near(&made(&[0.0, 4.0, 16.0, 36.0], Operator::Rate), &[2.0, 4.0, 8.0, 10.0]);
    assert_near(&made(&[5.0], Operator::Rate), &[0.0]);
    // Three times the time: the integral from 2 s on is 1.5 (t^2 - 4).
    assert_near(&made(&[0.0, 6.0, 12.0, 18.0], Operator::Integral), &[0.0, 0.0, 18.0, 48.0]);
}

/// A low pass follows a step exponentially, however long the blocks are; a delay gives the earlier value, and
/// at the beginning the first value.
#[test]
fn low_pass_and_delay_are_exact_for_a_step_and_a_line() {
    let mut irregular = blocks(&[&[0.0, 1.0, 1.0, 1.0]]);
    irregular.time_s = vec![100.0, 101.0, 104.0, 110.0];
    let passed = irregular.factor(&factor(Operator::LowPass(5.0), Power::One, true)).unwrap();
    assert_near(&passed, &[0.0, 1.0, 4.0, 10.0].map(|since_s: f64| 1.0 - libm::exp(-since_s / 5.0)));
    assert_near(&made(&[3.0; 4], Operator::LowPass(5.0)), &[3.0; 4]);
    let line = [0.0, 6.0, 12.0, 18.0, 24.0];
    assert_near(&made(&line, Operator::Delay(1.5)), &[0.0, 1.5, 7.5, 13.5, 19.5]);
    assert_near(&made(&line, Operator::Delay(2.0)), &[0.0, 0.0, 6.0, 12.0, 18.0]);
    assert_near(&made(&line, Operator::Delay(5.0)), &[0.0, 0.0, 0.0, 3.0, 9.0]);
}

/// A threshold's terms on either side of it and on it.
#[test]
fn terms_do_what_they_are_called() {
    let of = |kind| blocks(&[&[-3.0, 0.0, 1.0, 2.5]]).term(&Term { signal: 0, kind, constant: 1.0 }).unwrap();
    assert_eq!(of(TermKind::Above), [0.0, 0.0, 0.0, 1.0]);
    assert_eq!(of(TermKind::Beyond), [1.0, 0.0, 0.0, 1.0]);
    assert_eq!(of(TermKind::Excess), [0.0, 0.0, 0.0, 1.5]);
    assert_eq!(of(TermKind::Lack), [4.0, 1.0, 0.0, 0.0]);
    assert_eq!(of(TermKind::Capped), [-3.0, 0.0, 1.0, 1.0]);
    assert_eq!(of(TermKind::ExcessEitherWay), [2.0, 0.0, 0.0, 1.5]);
}

/// The cosine of the heading less the constant, and of twice that angle, from the means of sine and cosine;
/// and the heading itself.
#[test]
fn a_headings_terms_are_its_cosines() {
    let angles = [0.3, 2.0, -2.5];
    let mut of = blocks(&[&[0.0; 3]]);
    of.values = vec![Vec::new()];
    let term = |of: &Blocks, kind| of.term(&Term { signal: 0, kind, constant: 0.7 });
    assert_eq!(term(&of, TermKind::Cosine), None, "no heading was recorded");
    assert_eq!(of.values_of(0), Vec::<f64>::new());
    of.heading = Some([angles.map(f64::sin).to_vec(), angles.map(f64::cos).to_vec()]);
    assert_near(&term(&of, TermKind::Cosine).unwrap(), &angles.map(|angle: f64| (angle - 0.7).cos()));
    let twice = angles.map(|angle: f64| (2.0 * (angle - 0.7)).cos());
    assert_near(&term(&of, TermKind::SecondCosine).unwrap(), &twice);
    assert_eq!(term(&of, TermKind::Above), None, "a heading has no threshold");
    assert_near(&of.values_of(0), &angles);
}

/// A law is the product of its factors and its term.
#[test]
fn a_law_is_the_product_of_its_parts() {
    let of = blocks(&[&[2.0, 3.0, 5.0], &[1.0, -1.0, 4.0]]);
    let itself = |signal, power| Factor { signal, operator: Operator::Itself, power, is_signed: true };
    let law = Law {
        factors: vec![itself(0, Power::Two), itself(1, Power::One)],
        term: Some(Term { signal: 1, kind: TermKind::Excess, constant: 0.5 }),
        off_grid: 0,
    };
    assert_eq!(of.law(&law).unwrap(), [4.0 * 0.5, 0.0, 25.0 * 4.0 * 3.5]);
    assert_eq!(of.law(&Law::default()), None);
    let unheard_of = Law { factors: vec![itself(7, Power::One)], ..Law::default() };
    assert_eq!(of.law(&unheard_of), None);
}

/// A missing value is the value before it, at the beginning the first; quantiles are a tenth apart, with as
/// many even steps.
#[test]
fn gaps_are_filled_and_quantiles_are_tenths() {
    assert_eq!(filled(vec![f64::NAN, 1.0, f64::NAN, 2.0, f64::NAN]), [1.0, 1.0, 1.0, 2.0, 2.0]);
    assert_eq!(filled(vec![f64::NAN; 2]), [0.0; 2]);
    // A hundred squares: the tenths are squares of tens, the even steps tenths of the range from 0 to 9,801.
    let found = quantiles((0..100).rev().map(|k| f64::from(k * k)).collect());
    let mut wanted: Vec<f64> = (1..10).map(|k| f64::from(100 * k * k)).collect();
    wanted.extend((1..10).map(|k| 980.1 * f64::from(k)));
    wanted.sort_by(f64::total_cmp);
    assert_near(&found, &wanted);
    assert_eq!(quantiles(vec![4.0; 30]), [4.0]);
    assert_eq!(quantiles(Vec::new()), Vec::<f64>::new());
}

/// A formula can name a column that begins with a letter or an underscore and continues with letters, digits
/// and underscores.
#[test]
fn names_are_what_formulas_can_name() {
    assert!(["flap", "_x", "a1_b"].into_iter().all(is_name));
    assert!(["", "1a", "flap angle", "a-b", "\u{e4}", "a.b"].into_iter().all(|name| !is_name(name)));
}

/// The names of known signals of the blocks, and two columns that the workbench does not know.
fn names() -> Vec<String> {
    (0..KNOWN_SIGNALS)
        .map(|k| format!("known{k}"))
        .chain(["flap_deg", "odd-name", "gear"].map(String::from))
        .collect()
}

fn series(count: usize) -> Series {
    Series {
        time_s: (0..count).map(|k| k as f64).collect(),
        free: (0..count).map(|k| k >= count / 2).collect(),
        ..Series::default()
    }
}

/// Twenty blocks: the airspeed rises from 20 m/s, the climb rate alternates, the air is at 15 to 34 degrees,
/// the flaps at 0 or 90 degrees; the load factor is constant, three of the throttle's cells are missing and
/// two of the angle of attack's.
fn recorded() -> Vec<Vec<f64>> {
    (0..20)
        .map(|k| {
            let mut block = vec![f64::NAN; KNOWN_SIGNALS + 3];
            let number = f64::from(k);
            block[0] = 20.0 + number;
            block[1] = if k % 2 == 0 { 3.0 } else { -1.0 };
            block[3] = 1.0;
            block[6] = (0.1 * number).sin();
            block[7] = (0.1 * number).cos();
            block[8] = if k < 2 { f64::NAN } else { 0.01 * number };
            block[10] = if k < 3 { f64::NAN } else { 0.5 + 0.01 * number };
            block[17] = 15.0 + number;
            block[KNOWN_SIGNALS] = if k < 10 { 0.0 } else { 90.0 };
            block[KNOWN_SIGNALS + 1] = number;
            block[KNOWN_SIGNALS + 2] = -number - 5.0;
            block
        })
        .collect()
}

/// Signals are those that move and lack at most a tenth of their values, in SI units, with their properties;
/// a column that no formula can name, and one without a unit, are reported.
#[test]
fn signals_are_what_is_there_and_moves() {
    let (series, blocks) = (series(20), recorded());
    let found = Signals::new(&[(&series, &blocks)], &names(), &[]);
    let name = |signal: &Signal| signal.name.name.clone();
    let all: Vec<String> = found.signals.iter().map(name).collect();
    assert_eq!(all, ["tas_mps", "climb_rate_mps", "aoa_rad", "oat_c", "flap_deg", "gear", "yaw_rad"]);
    assert_eq!(
        (found.unnamed.clone(), found.without_unit.clone()),
        (vec!["odd-name".to_owned()], vec!["gear".to_owned()])
    );
    let [airspeed, climb, _, air, flap, gear, heading] = &found.signals[..] else { panic!("{all:?}") };
    assert_eq!((airspeed.mean, airspeed.range), (29.5, [20.0, 39.0]));
    assert!(airspeed.is_away && !airspeed.is_signed && !airspeed.is_unknown);
    // Free flight is from 30 m/s to 39 m/s.
    assert_eq!(airspeed.quantiles[0].first().copied(), Some(30.9));
    assert!(climb.is_signed && !climb.is_away);
    assert_eq!((climb.quantiles[0][0], climb.quantiles[1][0]), (-1.0, 1.0));
    assert_eq!(air.range, [288.15, 307.15]);
    assert!(flap.is_unknown && (flap.range[1] - std::f64::consts::FRAC_PI_2).abs() < 1e-6 && !flap.is_away);
    assert!(gear.is_unknown && gear.is_away && !gear.is_signed, "it is from -24 to -5");
    assert!(heading.is_heading && found.flights[0].heading.is_some());
    assert_eq!(found.flights[0].values[2][..3], [0.02; 3], "filled before the first");
    assert_eq!(found.names()[3].unit, "K");
    // A signal that a held-out flight lacks is removed from all flights; the held-out values do not change
    // the other signals' means.
    let mut other = recorded();
    other.iter_mut().for_each(|block| {
        block[1] = f64::NAN;
        block[0] += 100.0;
    });
    let both = Signals::new(&[(&series, &blocks)], &names(), &[(&series, &other)]);
    assert_eq!(both.signals.len(), 6);
    assert_eq!((both.signals[0].mean, both.signals[0].range), (29.5, [20.0, 39.0]));
    assert_eq!((both.flights.len(), both.flights[1].values[0][0]), (2, 120.0));
}

/// A planned flight has the values of its blocks; what they lack is at its mean, or moves over its range.
#[test]
fn a_planned_flight_is_at_the_means_where_nothing_is_said() {
    let (series, blocks) = (series(20), recorded());
    let found = Signals::new(&[(&series, &blocks)], &names(), &[]);
    let mut means = vec![vec![f64::NAN; KNOWN_SIGNALS + 3]; 3];
    for (k, block) in means.iter_mut().enumerate() {
        block[0] = 50.0 + k as f64;
        block[17] = 10.0;
        block[6] = 0.0;
        block[7] = 1.0;
    }
    let planned =
        found.planned(vec![0.0, 1.0, 2.0], vec![false, true, true], &means, Some((4, &[0.0, 0.5, 1.0])));
    assert_eq!(planned.values[0], [50.0, 51.0, 52.0]);
    assert_near(&planned.values[1], &[1.0; 3]);
    assert_near(&planned.values[3], &[283.15; 3]);
    let most = found.signals[4].range[1];
    assert_near(&planned.values[4], &[0.0, 0.5 * most, most]);
    assert_near(&planned.values[5], &[-14.5; 3]);
    assert_near(&planned.values_of(6), &[0.0; 3]);
    assert_eq!((planned.time_s.len(), planned.free[1]), (3, true));
}
