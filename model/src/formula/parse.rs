//! Parses text to a syntax tree.

use std::ops::Range;

use winnow::LocatingSlice;
use winnow::ascii::multispace0;
use winnow::combinator::{
    Infix, Prefix, alt, cut_err, delimited, dispatch, expression, fail, not, opt, peek, preceded, separated,
    terminated,
};
use winnow::error::{ContextError, ErrMode, StrContext, StrContextValue};
use winnow::prelude::*;
use winnow::stream::{Location, Stream};
use winnow::token::{any, one_of, take_while};

use super::FormulaError;
use super::ast::{Expression, Kind, Operator};
use super::dimension::{Dimension, of_unit};
use super::functions::Function;

/// Longest text, bytes: far more than a program holds, and short enough that nesting cannot overflow the
/// stack.
const LONGEST: usize = 1_000;

type Input<'a> = LocatingSlice<&'a str>;

/// Parses the formula in a text.
///
/// # Errors
/// [`FormulaError`], with the place.
pub fn parse(text: &str) -> Result<Expression, FormulaError> {
    if text.len() > LONGEST {
        let message = format!("the formula has {} bytes, expected at most {LONGEST}", text.len());
        return Err(FormulaError::new(text, LONGEST..text.len(), message));
    }
    if text.trim().is_empty() {
        return Err(FormulaError::new(
            text,
            0..0,
            "the formula is empty, expected one, such as tas_mps^2 / (2*g)",
        ));
    }
    terminated(formula, multispace0).parse(LocatingSlice::new(text)).map_err(|error| {
        let at = error.offset();
        let length = text.get(at..).and_then(|rest| rest.chars().next()).map_or(1, char::len_utf8);
        FormulaError::new(text, at..at + length, message(text, at, error.inner()))
    })
}

fn message(text: &str, at: usize, error: &ContextError) -> String {
    let found = text.get(at..).and_then(|rest| rest.chars().next());
    let found = found.map_or_else(
        || "the formula ends here".to_owned(),
        |found| format!("'{found}' is not expected here"),
    );
    let expected: Vec<String> = error
        .context()
        .filter_map(|context| match context {
            StrContext::Expected(value) => Some(match value {
                StrContextValue::Description(text) => (*text).to_owned(),
                value => value.to_string(),
            }),
            _ => None,
        })
        .collect();
    match expected.first() {
        Some(expected) => format!("{found}, expected {expected}"),
        None => format!("{found}, expected an operator (+ - * / ^ < <= > >= == !=) or the end"),
    }
}

type Fault = ErrMode<ContextError>;

fn formula(input: &mut Input<'_>) -> ModalResult<Expression> {
    expression(operand)
        .prefix(preceded(multispace0, sign))
        .infix(preceded(multispace0, operator))
        .parse_next(input)
}

fn sign<'a>(input: &mut Input<'a>) -> ModalResult<Prefix<Input<'a>, Expression, Fault>> {
    '-'.value(Prefix(5, |_: &mut Input<'a>, inner: Expression| {
        let span = inner.span.start.saturating_sub(1)..inner.span.end;
        Ok(Expression { kind: Kind::Negative(Box::new(inner)), span })
    }))
    .parse_next(input)
}

fn operator<'a>(input: &mut Input<'a>) -> ModalResult<Infix<Input<'a>, Expression, Fault>> {
    macro_rules! infix {
        ($side:ident, $power:literal, $operator:ident) => {
            Infix::$side($power, |_, left, right| {
                let span = left.span.start..right.span.end;
                Ok(Expression {
                    kind: Kind::Binary(Operator::$operator, Box::new(left), Box::new(right)),
                    span,
                })
            })
        };
    }
    let symbol =
        alt((alt(("<=", ">=", "==", "!=", "<", ">")), alt(("+", "-", "*", "/", "^")))).parse_next(input)?;
    Ok(match symbol {
        "<=" => infix!(Neither, 1, LessOrEqual),
        ">=" => infix!(Neither, 1, MoreOrEqual),
        "==" => infix!(Neither, 1, Equal),
        "!=" => infix!(Neither, 1, NotEqual),
        "<" => infix!(Neither, 1, Less),
        ">" => infix!(Neither, 1, More),
        "+" => infix!(Left, 2, Add),
        "-" => infix!(Left, 2, Subtract),
        "*" => infix!(Left, 4, Multiply),
        "/" => infix!(Left, 4, Divide),
        _ => infix!(Right, 6, Power),
    })
}

fn operand(input: &mut Input<'_>) -> ModalResult<Expression> {
    preceded(
        // Operands are tried before signs.
        (multispace0, not('-')),
        cut_err(dispatch! {peek(any);
            '0'..='9' | '.' => number,
            'a'..='z' | 'A'..='Z' | '_' => name_or_call,
            '(' => parentheses,
            _ => fail,
        })
        .context(StrContext::Expected(StrContextValue::Description("a number, a signal, a function or '('"))),
    )
    .parse_next(input)
}

fn parentheses(input: &mut Input<'_>) -> ModalResult<Expression> {
    let (inner, span) = delimited('(', formula, cut_err((multispace0, ')')).context(closing()))
        .with_span()
        .parse_next(input)?;
    Ok(Expression { span, ..inner })
}

fn closing() -> StrContext {
    StrContext::Expected(StrContextValue::Description("an operator or ')'"))
}

fn number(input: &mut Input<'_>) -> ModalResult<Expression> {
    let ((value, unit), span) = (
        (
            take_while(0.., '0'..='9'),
            opt(('.', take_while(0.., '0'..='9'))),
            opt((one_of(['e', 'E']), opt(one_of(['+', '-'])), take_while(1.., '0'..='9'))),
        )
            .take()
            .parse_to::<f64>()
            .verify(|value: &f64| value.is_finite())
            .context(StrContext::Expected(StrContextValue::Description("a number"))),
        opt(unit),
    )
        .with_span()
        .parse_next(input)?;
    Ok(Expression { kind: Kind::Number(value, unit.unwrap_or(Dimension::ONE)), span })
}

/// `[m/s]`.
fn unit(input: &mut Input<'_>) -> ModalResult<Dimension> {
    (multispace0, '[').void().parse_next(input)?;
    let start = input.checkpoint();
    let text: &str = take_while(0.., |c| c != ']').parse_next(input)?;
    let Some(dimension) = terminated(of_unit, multispace0::<&str, _>).parse(text).ok() else {
        input.reset(&start);
        return cut_err(fail)
            .context(StrContext::Expected(StrContextValue::Description(
                "a unit of m, s, K, Pa, rad and 1, such as [m/s^2]",
            )))
            .parse_next(input);
    };
    cut_err(']').context(StrContext::Expected(StrContextValue::Description("']'"))).parse_next(input)?;
    Ok(dimension)
}

/// A name, or a function with its arguments.
fn name_or_call(input: &mut Input<'_>) -> ModalResult<Expression> {
    let (name, span): (&str, Range<usize>) = (
        one_of(|c: char| c.is_ascii_alphabetic() || c == '_'),
        take_while(0.., |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '.'),
    )
        .take()
        .with_span()
        .parse_next(input)?;
    if opt(peek((multispace0, '('))).parse_next(input)?.is_none() {
        return Ok(Expression { kind: Kind::Name(name.to_owned()), span });
    }
    let arguments: Vec<Expression> = delimited(
        (multispace0, '('),
        separated(0.., formula, (multispace0, ',')),
        cut_err((multispace0, ')'))
            .context(StrContext::Expected(StrContextValue::Description("an operator, ',' or ')'"))),
    )
    .parse_next(input)?;
    let span = span.start..input.previous_token_end();
    // An unknown function is reported where the message can be specific.
    Ok(match Function::from_name(name) {
        Some(function) => Expression { kind: Kind::Call(function, arguments), span },
        None => Expression { kind: Kind::Unknown(name.to_owned()), span },
    })
}
