//! Syntax tree of a formula before it is compiled.

use std::fmt;
use std::ops::Range;

use super::dimension::Dimension;
use super::functions::Function;

/// A part of a formula, and its bytes in the text.
#[derive(Clone, Debug, PartialEq)]
pub struct Expression {
    /// Kind of the part.
    pub kind: Kind,
    /// Position, bytes of the text.
    pub span: Range<usize>,
}

/// Kind of a part of a formula.
#[derive(Clone, Debug, PartialEq)]
pub enum Kind {
    /// A number with its unit: `20[m/s]`; without brackets it has no unit.
    Number(f64, Dimension),
    /// A signal, a constant, `tau`, or another definition's id.
    Name(String),
    /// `-a`.
    Negative(Box<Expression>),
    /// `a + b` and the like.
    Binary(Operator, Box<Expression>, Box<Expression>),
    /// A function of its arguments.
    Call(Function, Vec<Expression>),
    /// A call of an unknown function.
    Unknown(String),
}

/// An operator between two parts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Operator {
    /// `+`
    Add,
    /// `-`
    Subtract,
    /// `*`
    Multiply,
    /// `/`
    Divide,
    /// `^`
    Power,
    /// `<`
    Less,
    /// `<=`
    LessOrEqual,
    /// `>`
    More,
    /// `>=`
    MoreOrEqual,
    /// `==`
    Equal,
    /// `!=`
    NotEqual,
}

impl Operator {
    /// Its symbol in a formula.
    #[must_use]
    pub const fn symbol(self) -> &'static str {
        match self {
            Self::Add => "+",
            Self::Subtract => "-",
            Self::Multiply => "*",
            Self::Divide => "/",
            Self::Power => "^",
            Self::Less => "<",
            Self::LessOrEqual => "<=",
            Self::More => ">",
            Self::MoreOrEqual => ">=",
            Self::Equal => "==",
            Self::NotEqual => "!=",
        }
    }
}

/// Written with every parenthesis and no more space than needed: equal formulas are written the same.
impl fmt::Display for Expression {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.kind {
            Kind::Number(value, dimension) if *dimension == Dimension::ONE => write!(formatter, "{value}"),
            Kind::Number(value, dimension) => write!(formatter, "{value}[{dimension}]"),
            Kind::Name(name) | Kind::Unknown(name) => formatter.write_str(name),
            Kind::Negative(inner) => write!(formatter, "(-{inner})"),
            Kind::Binary(operator, left, right) => {
                write!(formatter, "({left} {} {right})", operator.symbol())
            }
            Kind::Call(function, arguments) => {
                write!(formatter, "{}(", function.name())?;
                for (k, argument) in arguments.iter().enumerate() {
                    if k > 0 {
                        formatter.write_str(", ")?;
                    }
                    write!(formatter, "{argument}")?;
                }
                formatter.write_str(")")
            }
        }
    }
}
