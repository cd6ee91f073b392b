//! The laws that are searched, and the length of each.
//!
//! A law is a product of at most three factors and at most one term. A factor is a power of a signal, or of
//! its rate, integral, lag, low pass or deviation from its captive mean; the term is a threshold or a
//! periodic function of a signal. The length of a law is the number of bits of the code below. Its prior is
//! two to the power of minus that, so a law that is longer by a bit must explain twice as much. Every choice
//! among n equal options costs log2 n bits:
//!
//! - what it acts on: among the sensors that are searched;
//! - a bit before each factor and after the last, and a bit for whether there is a term. Two orders of the
//!   same factors are one law, which gives log2 2! or log2 3! bits back;
//! - a factor: which signal; a bit if it is the signal itself, else two bits more for one of the four groups
//!   (deviation, rate, integral, memory) and, for the memory, which of the delays and low passes of the grid;
//!   a bit if its power is 1, else two bits more;
//! - a term: its kind, its signal, its constant among those of the grid;
//! - a constant that was moved off its grid: two bits for the quarter of its cell that it ended in.
//!
//! The codes are prefix-free, so the priors of all laws add up to at most one (Kraft's inequality; Rissanen,
//! "Modeling by shortest data description", Automatica 14, 1978).

use std::fmt::Write as _;

/// Time constants of the low passes that are tried first, seconds: a factor of three apart, as in the
/// catalogue.
pub const LOW_PASSES_S: [f64; 4] = [2.0, 6.0, 20.0, 60.0];
/// Delays that are tried first, seconds.
pub const DELAYS_S: [f64; 2] = [1.0, 3.0];
/// Thresholds that are tried first: this many quantiles of the signal in free flight, and as many even steps
/// of its range.
pub const QUANTILES: usize = 9;
/// Phases of a periodic term that are tried first, over half a turn.
pub const PHASES: usize = 4;
/// Maximum number of factors of a law.
pub const MOST_FACTORS: usize = 3;
/// Maximum number of factors and terms of a law.
pub const MOST_PARTS: usize = 3;
/// Bits of a constant that was moved off its grid.
pub const OFF_GRID_BITS: f64 = 2.0;

/// The operation on a signal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Operator {
    /// The signal itself.
    Itself,
    /// Its deviation from its mean in captive flight.
    Deviation,
    /// Its change per second.
    Rate,
    /// Its integral from launch.
    Integral,
    /// A first-order low pass with this time constant, seconds.
    LowPass(f64),
    /// The signal this many seconds ago.
    Delay(f64),
}

/// A power.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Power {
    /// The number itself.
    One,
    /// Its square.
    Two,
    /// Its third power.
    Three,
    /// The magnitude, for signals that have both signs; else the square root.
    MagnitudeOrRoot,
    /// The inverse, for signals that stay away from zero.
    Inverse,
}

impl Power {
    /// All of them.
    pub const ALL: [Self; 5] = [Self::One, Self::Two, Self::Three, Self::MagnitudeOrRoot, Self::Inverse];
}

/// A power of a signal, or of the result of an operation on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Factor {
    /// Index of the signal.
    pub signal: usize,
    /// The operation on it.
    pub operator: Operator,
    /// The power.
    pub power: Power,
    /// Whether its values have both signs.
    pub is_signed: bool,
}

/// The function that a term applies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TermKind {
    /// One above the constant, else zero.
    Above,
    /// One where the magnitude is above the constant, else zero.
    Beyond,
    /// The excess over the constant, else zero.
    Excess,
    /// The shortfall below the constant, else zero.
    Lack,
    /// The signal, limited to the constant.
    Capped,
    /// The excess of its magnitude over the constant, else zero.
    ExcessEitherWay,
    /// The cosine of an angle less the constant.
    Cosine,
    /// The cosine of twice the angle less the constant.
    SecondCosine,
}

impl TermKind {
    /// Number of kinds that a term chooses from.
    pub const COUNT: usize = 8;
}

/// A threshold or a periodic function of a signal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Term {
    /// Index of the signal.
    pub signal: usize,
    /// Its kind.
    pub kind: TermKind,
    /// The threshold, in the signal's unit, or the phase, rad.
    pub constant: f64,
}

/// A law.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Law {
    /// Its factors.
    pub factors: Vec<Factor>,
    /// Its term.
    pub term: Option<Term>,
    /// Number of constants that were moved off their grid.
    pub off_grid: usize,
}

/// A signal's name in formulas.
#[derive(Clone, Debug, PartialEq)]
pub struct Name {
    /// Its name in a formula.
    pub name: String,
    /// Its unit in a formula; `1` for a plain number.
    pub unit: String,
}

impl Factor {
    /// Length in bits.
    #[must_use]
    pub fn bits(&self, signals: usize) -> f64 {
        let memories = (LOW_PASSES_S.len() + DELAYS_S.len()) as f64;
        let operator = match self.operator {
            Operator::Itself => 1.0,
            Operator::Deviation | Operator::Rate | Operator::Integral => 3.0,
            Operator::LowPass(_) | Operator::Delay(_) => 3.0 + libm::log2(memories),
        };
        let power = if self.power == Power::One { 1.0 } else { 3.0 };
        libm::log2(signals as f64) + operator + power
    }

    fn write(&self, text: &mut String, names: &[Name]) {
        let Some(name) = names.get(self.signal).map(|name| name.name.as_str()) else { return };
        let inner = match self.operator {
            Operator::Itself => name.to_owned(),
            Operator::Deviation => format!("({name} - captive({name}))"),
            Operator::Rate => format!("rate({name})"),
            Operator::Integral => format!("integral({name})"),
            Operator::LowPass(time_s) => format!("lowpass({name}, {}[s])", number(time_s)),
            Operator::Delay(time_s) => format!("delay({name}, {}[s])", number(time_s)),
        };
        // Writing to a string cannot fail.
        let _ = match self.power {
            Power::One => write!(text, "{inner}"),
            Power::Two => write!(text, "{inner}^2"),
            Power::Three => write!(text, "{inner}^3"),
            Power::MagnitudeOrRoot if self.is_signed => write!(text, "abs({inner})"),
            Power::MagnitudeOrRoot => write!(text, "sqrt({inner})"),
            Power::Inverse => write!(text, "(1/{inner})"),
        };
    }
}

impl Term {
    /// Length in bits.
    #[must_use]
    pub fn bits(&self, signals: usize) -> f64 {
        let constants = match self.kind {
            TermKind::Cosine | TermKind::SecondCosine => PHASES,
            _ => 2 * QUANTILES,
        };
        libm::log2(TermKind::COUNT as f64) + libm::log2(signals as f64) + libm::log2(constants as f64)
    }

    fn write(&self, text: &mut String, names: &[Name]) {
        let Some(Name { name, unit }) = names.get(self.signal) else { return };
        let with_unit = |value: f64| match unit.as_str() {
            "1" => number(value),
            unit => format!("{}[{unit}]", number(value)),
        };
        let constant = match with_unit(self.constant) {
            negative if self.constant < 0.0 => format!("({negative})"),
            positive => positive,
        };
        // Writing to a string cannot fail.
        let _ = match self.kind {
            TermKind::Above => write!(text, "step({name} > {constant})"),
            TermKind::Beyond => write!(text, "step(abs({name}) > {constant})"),
            TermKind::Excess => write!(text, "max({name} - {constant}, {})", with_unit(0.0)),
            TermKind::Lack => write!(text, "max({constant} - {name}, {})", with_unit(0.0)),
            TermKind::Capped => write!(text, "min({name}, {constant})"),
            TermKind::ExcessEitherWay => write!(text, "max(abs({name}) - {constant}, {})", with_unit(0.0)),
            TermKind::Cosine => write!(text, "cos({name} - {constant})"),
            TermKind::SecondCosine => write!(text, "cos(2*({name} - {constant}))"),
        };
    }
}

impl Law {
    /// Length in bits, with this many signals on one of this many sensors.
    #[must_use]
    pub fn bits(&self, signals: usize, subjects: usize) -> f64 {
        let n = self.factors.len();
        let same: f64 = (1..=n).map(|k| k as f64).product();
        let factors: f64 = self.factors.iter().map(|factor| factor.bits(signals)).sum();
        let term = self.term.map_or(0.0, |term| term.bits(signals));
        libm::log2(subjects as f64) + (n + 2) as f64 - libm::log2(same)
            + factors
            + term
            + OFF_GRID_BITS * self.off_grid as f64
    }

    /// Number of factors and terms.
    #[must_use]
    pub fn parts(&self) -> usize {
        self.factors.len() + usize::from(self.term.is_some())
    }

    /// Whether it uses a signal.
    #[must_use]
    pub fn uses(&self, signal: usize) -> bool {
        self.factors.iter().any(|factor| factor.signal == signal)
            || self.term.is_some_and(|term| term.signal == signal)
    }

    /// The law as the regressor of an effect definition.
    #[must_use]
    pub fn formula(&self, names: &[Name]) -> String {
        let mut text = String::new();
        for factor in &self.factors {
            if !text.is_empty() {
                text.push_str(" * ");
            }
            factor.write(&mut text, names);
        }
        if let Some(term) = self.term {
            if !text.is_empty() {
                text.push_str(" * ");
            }
            term.write(&mut text, names);
        }
        text
    }
}

/// A constant with the digits to which it is known: three.
pub fn number(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return "0".to_owned();
    }
    let digits = 2 - libm::floor(libm::log10(value.abs())) as i32;
    let text = format!("{value:.*}", digits.clamp(0, 12) as usize);
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text,
    }
}

#[cfg(test)]
mod tests {
    use model::formula::{Columns, Formula};

    use super::*;

    fn names() -> Vec<Name> {
        [("tas_mps", "m/s"), ("flap", "1"), ("yaw_rad", "rad"), ("baro_temp_c", "K")]
            .map(|(name, unit)| Name { name: name.to_owned(), unit: unit.to_owned() })
            .into()
    }

    const fn factor(signal: usize, operator: Operator, power: Power) -> Factor {
        Factor { signal, operator, power, is_signed: true }
    }

    fn laws() -> Vec<Law> {
        let operators = [
            Operator::Itself,
            Operator::Deviation,
            Operator::Rate,
            Operator::Integral,
            Operator::LowPass(2.5),
            Operator::Delay(0.77),
        ];
        let terms = [
            None,
            Some(Term { signal: 3, kind: TermKind::Above, constant: 288.1 }),
            Some(Term { signal: 1, kind: TermKind::Above, constant: -0.25 }),
            Some(Term { signal: 1, kind: TermKind::Beyond, constant: 0.25 }),
            Some(Term { signal: 0, kind: TermKind::Excess, constant: 31.0 }),
            Some(Term { signal: 0, kind: TermKind::Lack, constant: 31.0 }),
            Some(Term { signal: 0, kind: TermKind::Capped, constant: 31.0 }),
            Some(Term { signal: 0, kind: TermKind::ExcessEitherWay, constant: 31.0 }),
            Some(Term { signal: 2, kind: TermKind::Cosine, constant: 0.785 }),
            Some(Term { signal: 2, kind: TermKind::SecondCosine, constant: -0.4 }),
        ];
        let mut laws = Vec::new();
        for term in terms {
            for operator in operators {
                for power in Power::ALL {
                    let factors = vec![factor(0, operator, power), factor(1, Operator::Itself, Power::One)];
                    laws.push(Law { factors, term, off_grid: 0 });
                }
            }
        }
        laws
    }

    /// Every law of the grammar is a formula, with a unit that gives metres.
    #[test]
    fn every_law_is_a_formula_whose_dimensions_agree() {
        for law in laws() {
            let text = law.formula(&names());
            let formula = Formula::compile(&text, &mut Columns::default())
                .unwrap_or_else(|error| panic!("{text}: {error}"));
            let unit = formula.coefficient_unit().to_string();
            assert!(formula.check_unit(&unit).is_ok(), "{text} in {unit}");
        }
        let squared = Law { factors: vec![factor(0, Operator::Itself, Power::Two)], ..Law::default() };
        let formula = Formula::compile(&squared.formula(&names()), &mut Columns::default()).unwrap();
        // Metres over metres squared a second squared.
        assert!(formula.check_unit("s^2/m").is_ok());
    }

    #[test]
    fn what_is_simpler_takes_fewer_bits() {
        let bits = |law: &Law| law.bits(16, 2);
        let plain = Law { factors: vec![factor(1, Operator::Itself, Power::One)], ..Law::default() };
        let mut squared = plain.clone();
        squared.factors[0].power = Power::Two;
        let mut lagged = plain.clone();
        lagged.factors[0].operator = Operator::LowPass(2.0);
        let mut product = plain.clone();
        product.factors.push(factor(0, Operator::Itself, Power::One));
        let mut with_term = plain.clone();
        with_term.term = Some(Term { signal: 0, kind: TermKind::Above, constant: 3.0 });
        let mut moved = with_term.clone();
        moved.off_grid = 1;
        // One sensor of two, three bits for one factor and no term, a signal of 16, itself, its first power.
        assert!((bits(&plain) - (1.0 + 3.0 + 4.0 + 1.0 + 1.0)).abs() < 1e-12);
        for longer in [&squared, &lagged, &product, &with_term] {
            assert!(bits(longer) > bits(&plain), "{longer:?}");
        }
        assert!((bits(&moved) - bits(&with_term) - OFF_GRID_BITS).abs() < 1e-12);
        // Two orders of a product are the same law.
        let factors: f64 = product.factors.iter().map(|factor| factor.bits(16)).sum();
        assert!((bits(&product) - (1.0 + 4.0 - 1.0 + factors)).abs() < 1e-12);
    }

    /// The priors of all laws of up to two factors add up to at most one: no law is more probable than its
    /// length allows.
    #[test]
    fn the_priors_add_up_to_one_at_most() {
        let signals = 3;
        let mut factors = Vec::new();
        for signal in 0..signals {
            let grid = [Operator::Itself, Operator::Deviation, Operator::Rate, Operator::Integral]
                .into_iter()
                .chain(LOW_PASSES_S.map(Operator::LowPass))
                .chain(DELAYS_S.map(Operator::Delay));
            for operator in grid {
                factors.extend(Power::ALL.map(|power| factor(signal, operator, power)));
            }
        }
        let prior = |factors: &[Factor]| {
            libm::exp2(-Law { factors: factors.to_vec(), ..Law::default() }.bits(signals, 1))
        };
        let mut sum = 0.0;
        for (k, first) in factors.iter().enumerate() {
            sum += prior(&[*first]);
            sum += factors[k..].iter().map(|second| prior(&[*first, *second])).sum::<f64>();
        }
        assert!(sum > 0.05 && sum <= 1.0, "{sum}");
    }
}
