//! The signals of flights as laws take them: block means in SI units, and what factors and terms make of these.

use model::formula::Column;

use super::grammar::{Factor, Law, Name, Operator, Power, Term, TermKind};
use crate::diagnose::parts::Series;

/// One flight's signals in blocks.
#[derive(Clone, Debug, Default)]
pub struct Blocks {
    time_s: Vec<f64>,
    free: Vec<bool>,
    /// Block means, by signal.
    values: Vec<Vec<f64>>,
    /// Block means of the sine and cosine of the heading.
    heading: Option<[Vec<f64>; 2]>,
}

/// What a signal is.
#[derive(Clone, Debug, PartialEq)]
pub struct Signal {
    /// Its name and unit.
    pub name: Name,
    /// Whether it has both signs in these flights.
    pub is_signed: bool,
    /// Whether its values stay away from zero: their least is more than a twentieth of their largest.
    pub is_away: bool,
    /// Whether only its sine and cosine are there.
    pub is_heading: bool,
    /// Its quantiles in free flight, and those of its magnitude.
    pub quantiles: [Vec<f64>; 2],
    /// Its mean in the learning flights.
    pub mean: f64,
    /// Its least and its largest there.
    pub range: [f64; 2],
    /// Whether it is a column that the workbench does not know.
    pub is_unknown: bool,
    /// Where it stands among the signals of the blocks, and what is added to them.
    source: Option<(usize, f64)>,
}

/// Where each signal of formulas stands among the signals of the blocks, its unit there, and what is added to the block's value.
/// The altitude is not among them: it is the path, whose error the residual has too.
const KNOWN: [(usize, &str, &str, f64); 18] = [
    (0, "tas_mps", "m/s", 0.0),
    (1, "climb_rate_mps", "m/s", 0.0),
    (3, "load_factor", "1", 0.0),
    (4, "roll_rad", "rad", 0.0),
    (5, "pitch_rad", "rad", 0.0),
    (8, "aoa_rad", "rad", 0.0),
    (9, "sideslip_rad", "rad", 0.0),
    (10, "throttle", "1", 0.0),
    (11, "accel_x_mps2", "m/s^2", 0.0),
    (12, "accel_y_mps2", "m/s^2", 0.0),
    (13, "gyro_x_radps", "rad/s", 0.0),
    (14, "gyro_y_radps", "rad/s", 0.0),
    (15, "gyro_z_radps", "rad/s", 0.0),
    (16, "baro_temp_c", "K", 273.15),
    (17, "oat_c", "K", 273.15),
    (18, "ground_speed_mps", "m/s", 0.0),
    (19, "gps_vn_mps", "m/s", 0.0),
    (20, "gps_ve_mps", "m/s", 0.0),
];
/// Where the heading's sine and cosine stand.
const HEADING: [usize; 2] = [6, 7];
/// How many signals of the blocks are known; the unknown columns come after them.
const KNOWN_SIGNALS: usize = 21;
/// A signal that lacks more than this share of its values is not there.
const MOST_MISSING: f64 = 0.1;
/// The least share of its largest that a signal stays away from zero by.
const AWAY: f64 = 0.05;

/// What is searched: the signals, and every flight's blocks of them.
#[derive(Clone, Debug, Default)]
pub struct Signals {
    /// What each is.
    pub signals: Vec<Signal>,
    /// By flight.
    pub flights: Vec<Blocks>,
    /// Columns that a formula cannot name.
    pub unnamed: Vec<String>,
    /// Columns of no known unit, which count as plain numbers.
    pub without_unit: Vec<String>,
}

/// A column of the flight before it is a signal.
struct Source {
    at: usize,
    name: Name,
    /// What is added to a known one's block means.
    offset: Option<f64>,
    /// A cell in SI units.
    si: Box<dyn Fn(f64) -> f64>,
}

impl Signals {
    /// Those that all flights have and that move in any of them. `signals` are the block means by flight, block and signal.
    #[must_use]
    pub fn new(
        flights: &[(&Series, &[Vec<f64>])],
        names: &[String],
        more: &[(&Series, &[Vec<f64>])],
    ) -> Self {
        let mut found = Self::default();
        let mut sources: Vec<Source> = KNOWN
            .iter()
            .map(|&(at, name, unit, offset)| Source {
                at,
                name: Name { name: name.to_owned(), unit: unit.to_owned() },
                offset: Some(offset),
                si: Box::new(move |cell| cell + offset),
            })
            .collect();
        for (at, name) in names.iter().enumerate().skip(KNOWN_SIGNALS) {
            if !is_name(name) {
                found.unnamed.push(name.clone());
                continue;
            }
            let column = Column::named(name);
            if column.is_guessed() {
                found.without_unit.push(name.clone());
            }
            let unit = column.dimension().to_string();
            let si = Box::new(move |cell: f64| f64::from(column.si(cell as f32)));
            sources.push(Source { at, name: Name { name: name.clone(), unit }, offset: None, si });
        }
        let all = || flights.iter().chain(more);
        let is_there = |at: usize| {
            all().all(|(_, blocks)| {
                let missing = blocks.iter().filter(|block| !block[at].is_finite()).count();
                !blocks.is_empty() && missing as f64 <= MOST_MISSING * blocks.len() as f64
            })
        };
        found.flights = all()
            .map(|(series, _)| Blocks {
                time_s: series.time_s.clone(),
                free: series.free.clone(),
                ..Blocks::default()
            })
            .collect();
        for source in sources.into_iter().filter(|source| is_there(source.at)) {
            let values: Vec<Vec<f64>> = all()
                .map(|(_, blocks)| {
                    let of = |block: &Vec<f64>| (source.si)(block[source.at]);
                    filled(blocks.iter().map(of).collect())
                })
                .collect();
            let learned = || values[..flights.len()].iter().flatten().copied();
            let (least, most) = learned().fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), value| {
                (least.min(value), most.max(value))
            });
            if most - least <= 1e-9 * most.abs().max(least.abs()) {
                continue;
            }
            let free = || {
                let blocks = found.flights[..flights.len()].iter().zip(&values);
                blocks.flat_map(|(blocks, values)| {
                    blocks.free.iter().zip(values).filter(|(free, _)| **free).map(|(_, value)| *value)
                })
            };
            let count = learned().count().max(1) as f64;
            found.signals.push(Signal {
                mean: learned().sum::<f64>() / count,
                range: [least, most],
                is_unknown: source.offset.is_none(),
                source: source.offset.map(|offset| (source.at, offset)),
                name: source.name,
                is_signed: least < 0.0 && most > 0.0,
                is_away: least > AWAY * most || (most < 0.0 && -most > AWAY * -least),
                is_heading: false,
                quantiles: [quantiles(free().collect()), quantiles(free().map(f64::abs).collect())],
            });
            for (blocks, values) in found.flights.iter_mut().zip(values) {
                blocks.values.push(values);
            }
        }
        if HEADING.into_iter().all(is_there) {
            found.signals.push(Signal {
                name: Name { name: "yaw_rad".to_owned(), unit: "rad".to_owned() },
                is_signed: true,
                is_away: false,
                is_heading: true,
                quantiles: [Vec::new(), Vec::new()],
                mean: 0.0,
                range: [-std::f64::consts::PI, std::f64::consts::PI],
                is_unknown: false,
                source: None,
            });
            for (blocks, (_, means)) in found.flights.iter_mut().zip(flights.iter().chain(more)) {
                let of = |at: usize| filled(means.iter().map(|block| block[at]).collect());
                blocks.heading = Some(HEADING.map(of));
                blocks.values.push(Vec::new());
            }
        }
        found
    }

    /// Blocks that were not flown, of block means of the known signals: what these lack is at its mean of the flights, but for one that
    /// moves over its range, its places given as shares of it.
    #[must_use]
    pub fn planned(
        &self,
        time_s: Vec<f64>,
        free: Vec<bool>,
        means: &[Vec<f64>],
        moved: Option<(usize, &[f64])>,
    ) -> Blocks {
        let column = |at: usize| -> Vec<f64> { means.iter().map(|block| block[at]).collect() };
        let values = self.signals.iter().enumerate().map(|(number, signal)| match (signal.source, moved) {
            _ if signal.is_heading => Vec::new(),
            (_, Some((one, places))) if one == number => {
                let [least, most] = signal.range;
                places.iter().map(|place| least + place * (most - least)).collect()
            }
            (Some((at, offset)), _) if means.iter().any(|block| block[at].is_finite()) => {
                filled(column(at)).iter().map(|value| value + offset).collect()
            }
            _ => vec![signal.mean; means.len()],
        });
        let values = values.collect();
        let heading =
            self.signals.iter().any(|signal| signal.is_heading).then(|| HEADING.map(|at| filled(column(at))));
        Blocks { time_s, free, values, heading }
    }

    /// Names and units, in order.
    #[must_use]
    pub fn names(&self) -> Vec<Name> {
        self.signals.iter().map(|signal| signal.name.clone()).collect()
    }
}

impl Blocks {
    /// A law's block means; `None` where it has a value that is no number.
    #[must_use]
    pub fn law(&self, law: &Law) -> Option<Vec<f64>> {
        let mut product: Option<Vec<f64>> = None;
        let factors = law.factors.iter().map(|factor| self.factor(factor));
        for values in factors.chain(law.term.map(|term| self.term(&term))) {
            let values = values?;
            product = Some(match product {
                Some(product) => product.iter().zip(&values).map(|(a, b)| a * b).collect(),
                None => values,
            });
        }
        product
    }

    /// A signal's block means; a heading's between -pi and pi.
    #[must_use]
    pub fn values_of(&self, signal: usize) -> Vec<f64> {
        match (self.values.get(signal), &self.heading) {
            (Some(values), _) if !values.is_empty() => values.clone(),
            (Some(_), Some([sines, cosines])) => {
                sines.iter().zip(cosines).map(|(sine, cosine)| libm::atan2(*sine, *cosine)).collect()
            }
            _ => Vec::new(),
        }
    }

    /// A factor's block means; `None` where it has a value that is no number.
    #[must_use]
    pub fn factor(&self, factor: &Factor) -> Option<Vec<f64>> {
        let values = self.values.get(factor.signal)?;
        let mut made = match factor.operator {
            Operator::Itself => values.clone(),
            Operator::Deviation => {
                let captive: Vec<f64> = self
                    .free
                    .iter()
                    .zip(values)
                    .filter(|(free, _)| !**free)
                    .map(|(_, value)| *value)
                    .collect();
                let mean = captive.iter().sum::<f64>() / captive.len() as f64;
                values.iter().map(|value| value - mean).collect()
            }
            Operator::Rate => self.rate(values),
            Operator::Integral => self.integral(values),
            Operator::LowPass(time_s) => self.low_pass(values, time_s),
            Operator::Delay(delay_s) => self.delayed(values, delay_s),
        };
        for value in &mut made {
            *value = match factor.power {
                Power::One => *value,
                Power::Two => *value * *value,
                Power::Three => *value * *value * *value,
                Power::MagnitudeOrRoot if factor.is_signed => value.abs(),
                Power::MagnitudeOrRoot => value.max(0.0).sqrt(),
                Power::Inverse => 1.0 / *value,
            };
        }
        made.iter().all(|value| value.is_finite()).then_some(made)
    }

    /// A term's block means.
    #[must_use]
    pub fn term(&self, term: &Term) -> Option<Vec<f64>> {
        let constant = term.constant;
        if let TermKind::Cosine | TermKind::SecondCosine = term.kind {
            let [sines, cosines] = self.heading.as_ref()?;
            let of = |(sine, cosine): (&f64, &f64)| match term.kind {
                TermKind::Cosine => cosine * libm::cos(constant) + sine * libm::sin(constant),
                _ => {
                    let twice = [2.0 * sine * cosine, cosine * cosine - sine * sine];
                    twice[1] * libm::cos(2.0 * constant) + twice[0] * libm::sin(2.0 * constant)
                }
            };
            return Some(sines.iter().zip(cosines).map(of).collect());
        }
        let values = self.values.get(term.signal).filter(|values| !values.is_empty())?;
        let of = |value: &f64| match term.kind {
            TermKind::Above => f64::from(u8::from(*value > constant)),
            TermKind::Beyond => f64::from(u8::from(value.abs() > constant)),
            TermKind::Excess => (value - constant).max(0.0),
            TermKind::Capped => value.min(constant),
            TermKind::ExcessEitherWay => (value.abs() - constant).max(0.0),
            _ => (constant - value).max(0.0),
        };
        Some(values.iter().map(of).collect())
    }

    fn rate(&self, values: &[f64]) -> Vec<f64> {
        let last = values.len().saturating_sub(1);
        let of = |k: usize| {
            let (from, to) = (k.saturating_sub(1), (k + 1).min(last));
            let apart_s = self.time_s[to] - self.time_s[from];
            if apart_s > 0.0 { (values[to] - values[from]) / apart_s } else { 0.0 }
        };
        (0..values.len()).map(of).collect()
    }

    fn integral(&self, values: &[f64]) -> Vec<f64> {
        let mut sum = 0.0;
        let of = |k: usize| {
            if k > 0 && self.free[k] {
                sum += 0.5 * (values[k] + values[k - 1]) * (self.time_s[k] - self.time_s[k - 1]);
            }
            sum
        };
        (0..values.len()).map(of).collect()
    }

    fn low_pass(&self, values: &[f64], time_s: f64) -> Vec<f64> {
        let mut state = values.first().copied().unwrap_or(0.0);
        let mut last_s = self.time_s.first().copied().unwrap_or(0.0);
        let filtered = self.time_s.iter().zip(values).map(|(now_s, value)| {
            let keep = libm::exp(-(now_s - last_s) / time_s);
            last_s = *now_s;
            state = keep * state + (1.0 - keep) * value;
            state
        });
        filtered.collect()
    }

    fn delayed(&self, values: &[f64], delay_s: f64) -> Vec<f64> {
        let mut k = 0;
        let of = |now_s: &f64| {
            let at_s = now_s - delay_s;
            while k + 1 < values.len() && self.time_s[k + 1] <= at_s {
                k += 1;
            }
            match (self.time_s.get(k + 1), values.get(k + 1)) {
                (Some(next_s), Some(next)) if at_s > self.time_s[k] => {
                    let share = (at_s - self.time_s[k]) / (next_s - self.time_s[k]);
                    values[k] + share * (next - values[k])
                }
                _ => values[k],
            }
        };
        self.time_s.iter().map(of).collect()
    }
}

/// Before its first value a signal has that; between, its last.
fn filled(mut values: Vec<f64>) -> Vec<f64> {
    let mut last = values.iter().copied().find(|value| value.is_finite()).unwrap_or(0.0);
    for value in &mut values {
        if value.is_finite() {
            last = *value;
        }
        *value = last;
    }
    values
}

/// The inner quantiles, a tenth apart, and as many places at even steps over the range: a signal that rests most of the time has its
/// quantiles where it rests. Those that differ.
fn quantiles(mut values: Vec<f64>) -> Vec<f64> {
    use super::grammar::QUANTILES;
    values.sort_by(f64::total_cmp);
    let at = |k: usize| values.get(k * values.len() / (QUANTILES + 1)).copied();
    let mut found: Vec<f64> = (1..=QUANTILES).filter_map(at).collect();
    if let (Some(least), Some(most)) = (values.first(), values.last()) {
        found.extend((1..=QUANTILES).map(|k| least + (most - least) * k as f64 / (QUANTILES + 1) as f64));
    }
    found.sort_by(f64::total_cmp);
    found.dedup();
    found
}

/// Whether a formula can name a column.
fn is_name(name: &str) -> bool {
    let mut letters = name.chars();
    letters.next().is_some_and(|first| first.is_ascii_alphabetic() || first == '_')
        && letters.all(|letter| letter.is_ascii_alphanumeric() || letter == '_')
}

#[cfg(test)]
mod tests {
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

    /// A power is that power of every block; a magnitude where both signs are, else the root; no inverse of
    /// nothing.
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

    /// The deviation is from captive flight's mean, the rate the difference of the neighbours over their
    /// time, the integral begins with free flight, by the trapezium rule, which is exact for what is
    /// straight.
    #[test]
    fn deviation_rate_and_integral_are_what_they_are_called() {
        assert_near(&made(&[1.0, 3.0, 7.0, 2.0], Operator::Deviation), &[-1.0, 1.0, 5.0, 0.0]);
        // Squares of the time since the beginning: twice the time, and at the ends what one neighbour says.
        assert_near(&made(&[0.0, 4.0, 16.0, 36.0], Operator::Rate), &[2.0, 4.0, 8.0, 10.0]);
        assert_near(&made(&[5.0], Operator::Rate), &[0.0]);
        // Three times the time: the integral from 2 s on is 1.5 (t^2 - 4).
        assert_near(&made(&[0.0, 6.0, 12.0, 18.0], Operator::Integral), &[0.0, 0.0, 18.0, 48.0]);
    }

    /// A low pass goes to a step by what an exponential leaves, however long the blocks are; a delay shows
    /// what was, and before that the first value.
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
        let of =
            |kind| blocks(&[&[-3.0, 0.0, 1.0, 2.5]]).term(&Term { signal: 0, kind, constant: 1.0 }).unwrap();
        assert_eq!(of(TermKind::Above), [0.0, 0.0, 0.0, 1.0]);
        assert_eq!(of(TermKind::Beyond), [1.0, 0.0, 0.0, 1.0]);
        assert_eq!(of(TermKind::Excess), [0.0, 0.0, 0.0, 1.5]);
        assert_eq!(of(TermKind::Lack), [4.0, 1.0, 0.0, 0.0]);
        assert_eq!(of(TermKind::Capped), [-3.0, 0.0, 1.0, 1.0]);
        assert_eq!(of(TermKind::ExcessEitherWay), [2.0, 0.0, 0.0, 1.5]);
    }

    /// The cosine of the heading less the constant, once and of twice the angle, by the means of sine and
    /// cosine; the heading itself too.
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

    /// What is missing is the value before it, at the beginning the first; quantiles are a tenth apart, and
    /// as many even steps.
    #[test]
    fn gaps_are_filled_and_quantiles_are_tenths() {
        assert_eq!(filled(vec![f64::NAN, 1.0, f64::NAN, 2.0, f64::NAN]), [1.0, 1.0, 1.0, 2.0, 2.0]);
        assert_eq!(filled(vec![f64::NAN; 2]), [0.0; 2]);
        // A hundred squares: the tenths are squares of tens, the even steps tenths of the range from 0 to
        // 9,801.
        let found = quantiles((0..100).rev().map(|k| f64::from(k * k)).collect());
        let mut wanted: Vec<f64> = (1..10).map(|k| f64::from(100 * k * k)).collect();
        wanted.extend((1..10).map(|k| 980.1 * f64::from(k)));
        wanted.sort_by(f64::total_cmp);
        assert_near(&found, &wanted);
        assert_eq!(quantiles(vec![4.0; 30]), [4.0]);
        assert_eq!(quantiles(Vec::new()), Vec::<f64>::new());
    }

    /// A formula names what begins with a letter or an underscore and goes on with letters, digits and
    /// underscores.
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

    /// Twenty blocks: the airspeed rises from 20 m/s, the climb rate alternates, the air is at 15 to 34
    /// degrees, the flaps at 0 or 90 degrees; the load factor is always the same, three of the throttle's
    /// cells are missing and two of the angle of attack's.
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

    /// Signals are those that move and of which at most a tenth is missing, in SI units, with what is to be
    /// known of each; a column that no formula can name, and one of no unit, are said.
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
        assert!(
            flap.is_unknown && (flap.range[1] - std::f64::consts::FRAC_PI_2).abs() < 1e-6 && !flap.is_away
        );
        assert!(gear.is_unknown && gear.is_away && !gear.is_signed, "it is from -24 to -5");
        assert!(heading.is_heading && found.flights[0].heading.is_some());
        assert_eq!(found.flights[0].values[2][..3], [0.02; 3], "filled before the first");
        assert_eq!(found.names()[3].unit, "K");
        // A held-out flight that lacks a signal takes it from all; what it says does not move the others'
        // means.
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

    /// A planned flight has what its blocks say; what they lack is at its mean, or moves over its range.
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
}
