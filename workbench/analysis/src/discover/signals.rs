//! The signals of flights in the form that laws use: block means in SI units, and the factors and terms made
//! of them.

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

/// A signal's properties.
#[derive(Clone, Debug, PartialEq)]
pub struct Signal {
    /// Its name and unit.
    pub name: Name,
    /// Whether it has both signs in these flights.
    pub is_signed: bool,
    /// Whether its values stay away from zero: its smallest is more than a twentieth of its largest.
    pub is_away: bool,
    /// Whether only its sine and cosine are recorded.
    pub is_heading: bool,
    /// Its quantiles in free flight, and those of its magnitude.
    pub quantiles: [Vec<f64>; 2],
    /// Its mean in the learning flights.
    pub mean: f64,
    /// Its smallest and largest value in the learning flights.
    pub range: [f64; 2],
    /// Whether it is a column that the workbench does not know.
    pub is_unknown: bool,
    /// Its index among the signals of the blocks, and an offset added to them.
    source: Option<(usize, f64)>,
}

/// Index of each formula signal among the signals of the blocks, its unit in a formula, and an offset added
/// to the block's value. The altitude is not included: it is the path, whose error the residual has too.
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
/// Indices of the heading's sine and cosine.
const HEADING: [usize; 2] = [6, 7];
/// Number of known signals of the blocks; the unknown columns come after them.
const KNOWN_SIGNALS: usize = 21;
/// A signal that lacks more than this share of its values is treated as absent.
const MOST_MISSING: f64 = 0.1;
/// The smallest share of its largest value by which a signal stays away from zero.
const AWAY: f64 = 0.05;

/// What is searched: the signals, and every flight's blocks of them.
#[derive(Clone, Debug, Default)]
pub struct Signals {
    /// The properties of each signal.
    pub signals: Vec<Signal>,
    /// By flight.
    pub flights: Vec<Blocks>,
    /// Columns that a formula cannot name.
    pub unnamed: Vec<String>,
    /// Columns of no known unit, which count as plain numbers.
    pub without_unit: Vec<String>,
}

/// A column of the flight before it becomes a signal.
struct Source {
    at: usize,
    name: Name,
    /// Offset added to a known one's block means.
    offset: Option<f64>,
    /// Converts a cell to SI units.
    si: Box<dyn Fn(f64) -> f64>,
}

impl Signals {
    /// The signals that all flights have and that move in any of them. `signals` are the block means by
    /// flight, block and signal.
    /// block and signal.
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

    /// Blocks that were not flown, from block means of the known signals. A missing signal is at its mean
    /// over the flights, except one that moves over its range, with its places given as shares of the range.
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
    /// A law's block means; `None` where a value is not finite.
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

    /// A factor's block means; `None` where a value is not finite.
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

/// Fills gaps: before its first value a signal has that value; later, its last.
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

/// The inner quantiles, a tenth apart, and as many values at even steps over the range: a signal that rests
/// most of the time has its quantiles where it rests. Equal values are removed.
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
mod tests;
