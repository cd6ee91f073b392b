//! Dimensions: products of powers of metre, second, kelvin, pascal and radian.

use std::fmt;

use winnow::ascii::{digit1, space0};
use winnow::combinator::{alt, delimited, opt, preceded, repeat, terminated};
use winnow::prelude::*;
use winnow::token::one_of;

/// An exponent: a fraction in lowest terms, its denominator positive.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Ratio {
    numerator: i32,
    denominator: i32,
}

/// Largest denominator of an exponent.
const LARGEST_DENOMINATOR: i32 = 12;

impl Ratio {
    const ZERO: Self = Self { numerator: 0, denominator: 1 };
    const ONE: Self = Self { numerator: 1, denominator: 1 };

    /// The fraction in lowest terms; `None` if the denominator is zero or a number is out of range.
    #[must_use]
    pub fn new(numerator: i32, denominator: i32) -> Option<Self> {
        let divisor = greatest_common_divisor(numerator.checked_abs()?, denominator.checked_abs()?);
        let sign = denominator.signum();
        (sign != 0).then(|| Self {
            numerator: sign * numerator / divisor,
            denominator: sign * denominator / divisor,
        })
    }

    /// The fraction with a denominator of at most twelve that equals a number to nine digits.
    #[must_use]
    pub fn near(value: f64) -> Option<Self> {
        (1..=LARGEST_DENOMINATOR).find_map(|denominator| {
            let numerator = value * f64::from(denominator);
            let whole = numerator.round();
            ((numerator - whole).abs() < 1e-9 && whole.abs() <= 1e3)
                .then(|| Self::new(whole as i32, denominator))
                .flatten()
        })
    }

    /// Its value.
    #[must_use]
    pub fn value(self) -> f64 {
        f64::from(self.numerator) / f64::from(self.denominator)
    }

    fn plus(self, other: Self) -> Self {
        let numerator = i64::from(self.numerator) * i64::from(other.denominator)
            + i64::from(other.numerator) * i64::from(self.denominator);
        Self::reduced(numerator, i64::from(self.denominator) * i64::from(other.denominator))
    }

    fn times(self, other: Self) -> Self {
        Self::reduced(
            i64::from(self.numerator) * i64::from(other.numerator),
            i64::from(self.denominator) * i64::from(other.denominator),
        )
    }

    fn reduced(numerator: i64, denominator: i64) -> Self {
        let (mut a, mut b) = (numerator.abs(), denominator.abs());
        while b != 0 {
            (a, b) = (b, a % b);
        }
        let divisor = a.max(1);
        // Texts are too short to come near the bounds.
        let bounded = |value: i64| i32::try_from(value / divisor).unwrap_or(i32::MAX);
        Self { numerator: bounded(numerator), denominator: bounded(denominator) }
    }
}

fn greatest_common_divisor(mut a: i32, mut b: i32) -> i32 {
    while b != 0 {
        (a, b) = (b, a % b);
    }
    a.max(1)
}

impl fmt::Display for Ratio {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.denominator {
            1 => write!(formatter, "{}", self.numerator),
            denominator => write!(formatter, "({}/{denominator})", self.numerator),
        }
    }
}

const NAMES: [&str; 5] = ["m", "s", "K", "Pa", "rad"];

/// Exponents of metre, second, kelvin, pascal and radian.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Dimension([Ratio; 5]);

impl Dimension {
    /// Dimension of a plain number.
    pub const ONE: Self = Self([Ratio::ZERO; 5]);
    /// Metres.
    pub const METRE: Self = Self([Ratio::ONE, Ratio::ZERO, Ratio::ZERO, Ratio::ZERO, Ratio::ZERO]);
    /// Seconds.
    pub const SECOND: Self = Self([Ratio::ZERO, Ratio::ONE, Ratio::ZERO, Ratio::ZERO, Ratio::ZERO]);
    /// Radians.
    pub const RADIAN: Self = Self([Ratio::ZERO, Ratio::ZERO, Ratio::ZERO, Ratio::ZERO, Ratio::ONE]);

    /// Dimension of a product.
    #[must_use]
    pub fn times(self, other: Self) -> Self {
        Self(std::array::from_fn(|k| self.0[k].plus(other.0[k])))
    }

    /// Dimension of a quotient.
    #[must_use]
    pub fn over(self, other: Self) -> Self {
        self.times(other.to_the(Ratio { numerator: -1, denominator: 1 }))
    }

    /// Dimension of a power.
    #[must_use]
    pub fn to_the(self, exponent: Ratio) -> Self {
        Self(self.0.map(|own| own.times(exponent)))
    }

    /// Exponents of metre, second, kelvin, pascal and radian.
    #[must_use]
    pub const fn exponents(&self) -> &[Ratio; 5] {
        &self.0
    }

    /// Dimension of a unit: `1`, `m/s^2`, `1/rad`, `m^(1/2)`, `s m`. `None` if the unit is invalid.
    #[must_use]
    pub fn of_unit(unit: &str) -> Option<Self> {
        terminated(of_unit, space0).parse(unit).ok()
    }
}

/// `a`, `a/b`, `a b`, `a*b`.
pub(super) fn of_unit(input: &mut &str) -> ModalResult<Dimension> {
    let first = preceded(space0, factor).parse_next(input)?;
    repeat(
        0..,
        alt((
            preceded((space0, '/', space0), factor).map(|unit| (unit, true)),
            preceded((space0, one_of(['*', '.', '·']), space0), factor).map(|unit| (unit, false)),
            preceded(' ', preceded(space0, factor)).map(|unit| (unit, false)),
        )),
    )
    .fold(move || first, |unit, (next, is_below)| if is_below { unit.over(next) } else { unit.times(next) })
    .parse_next(input)
}

fn factor(input: &mut &str) -> ModalResult<Dimension> {
    let unit = alt((
        "rad".value(Dimension::RADIAN),
        "Pa".value(Dimension::base(3)),
        "K".value(Dimension::base(2)),
        "Hz".value(Dimension::SECOND.to_the(Ratio { numerator: -1, denominator: 1 })),
        "s".value(Dimension::SECOND),
        "m".value(Dimension::METRE),
        "1".value(Dimension::ONE),
    ))
    .parse_next(input)?;
    Ok(opt(preceded('^', exponent)).parse_next(input)?.map_or(unit, |exponent| unit.to_the(exponent)))
}

fn exponent(input: &mut &str) -> ModalResult<Ratio> {
    alt((
        (opt('-'), digit1, opt(preceded('.', digit1)))
            .take()
            .try_map(|text: &str| text.parse::<f64>().ok().and_then(Ratio::near).ok_or(Unlikely)),
        delimited(
            '(',
            (whole, preceded('/', whole))
                .verify_map(|(numerator, denominator)| Ratio::new(numerator, denominator)),
            ')',
        ),
    ))
    .parse_next(input)
}

fn whole(input: &mut &str) -> ModalResult<i32> {
    (opt('-'), digit1).take().parse_to().parse_next(input)
}

/// An exponent that no unit has.
#[derive(Debug, thiserror::Error)]
#[error("an exponent")]
struct Unlikely;

impl Dimension {
    fn base(which: usize) -> Self {
        Self(std::array::from_fn(|k| if k == which { Ratio::ONE } else { Ratio::ZERO }))
    }
}

/// As [`Dimension::of_unit`] reads it.
impl fmt::Display for Dimension {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let power = |(name, exponent): (&str, Ratio)| {
            if exponent == Ratio::ONE { name.to_owned() } else { format!("{name}^{exponent}") }
        };
        let named = NAMES.into_iter().zip(self.0);
        let above: Vec<String> = named.clone().filter(|(_, own)| own.numerator > 0).map(power).collect();
        let below: Vec<String> = named
            .filter(|(_, own)| own.numerator < 0)
            .map(|(name, own)| power((name, Ratio { numerator: -own.numerator, ..own })))
            .collect();
        let above = if above.is_empty() { "1".to_owned() } else { above.join(" ") };
        formatter.write_str(&above)?;
        below.iter().try_for_each(|unit| write!(formatter, "/{unit}"))
    }
}
