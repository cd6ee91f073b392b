//! Compiles a syntax tree to a program: names, dimensions, operations.

use std::ops::Range;

use crc::{CRC_64_ECMA_182, Crc};
use kf_core::formula::{MAX_COLUMNS, MAX_MASKS, MAX_OPS, MAX_STATE_WORDS, Op, Program, Signal, TOP};

use super::FormulaError;
use super::ast::{Expression, Kind, Operator};
use super::columns::Columns;
use super::dimension::{Dimension, Ratio};
use super::functions::{CONSTANTS, FUNCTIONS, Function};
use super::parse::parse;

const CRC: Crc<u64> = Crc::<u64>::new(&CRC_64_ECMA_182);

/// Longest delay, seconds.
const LONGEST_DELAY_S: f64 = 60.0;

/// A formula, compiled and ready to run.
#[derive(Clone, Debug, PartialEq)]
pub struct Formula {
    text: String,
    canonical: String,
    dimension: Dimension,
    program: Program,
    signals: Vec<Signal>,
    columns: Vec<String>,
}

impl Formula {
    /// The formula from a text; columns that the estimator does not know are added to `columns`.
    ///
    /// # Errors
    /// [`FormulaError`], with the place.
    pub fn compile(text: &str, columns: &mut Columns) -> Result<Self, FormulaError> {
        Self::of_expression(text, &parse(text)?, columns)
    }

    /// The formula from a tree; its spans refer to `text`.
    ///
    /// # Errors
    /// [`FormulaError`], with the place.
    pub fn of_expression(
        text: &str,
        expression: &Expression,
        columns: &mut Columns,
    ) -> Result<Self, FormulaError> {
        let mut compiler = Compiler { text, columns, ops: Vec::new(), masks: Vec::new(), words: 0 };
        let part = compiler.part(expression)?;
        let whole = expression.span.clone();
        let (ops, masks, words) = (compiler.ops, compiler.masks, compiler.words);
        let too_long = |what: &str, found: usize, most: usize| {
            let message = format!(
                "the formula takes {found} {what}, the flight computer has room for {most}: split it into two definitions, or make it shorter"
            );
            Err(FormulaError::new(text, whole.clone(), message))
        };
        if ops.len() > MAX_OPS {
            return too_long("operations", ops.len(), MAX_OPS);
        }
        if words > MAX_STATE_WORDS {
            return too_long("numbers of memory", words, MAX_STATE_WORDS);
        }
        if masks.len() > MAX_MASKS {
            return too_long("sets of signals to wait for", masks.len(), MAX_MASKS);
        }
        let Some(program) = Program::new(&ops, &masks) else {
            return Err(FormulaError::new(
                text,
                whole,
                "the formula is nested too deeply, expected 16 levels at most",
            ));
        };
        let used = program.signals();
        let signals = Signal::ALL.iter().copied().filter(|signal| used & signal.bit() != 0).collect();
        let numbered = columns.iter().zip(0..);
        let columns = numbered
            .filter(|(_, number)| used >> Signal::column_place(*number) & 1 == 1)
            .map(|(column, _)| column.name().to_owned())
            .collect();
        Ok(Self {
            text: text.to_owned(),
            canonical: expression.to_string(),
            dimension: part.dimension.unwrap_or(Dimension::ONE),
            program,
            signals,
            columns,
        })
    }

    /// The text.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The text with every parenthesis and no more space than needed.
    #[must_use]
    pub fn canonical(&self) -> &str {
        &self.canonical
    }

    /// Dimension of the formula's value.
    #[must_use]
    pub const fn dimension(&self) -> Dimension {
        self.dimension
    }

    /// The program.
    #[must_use]
    pub const fn program(&self) -> &Program {
        &self.program
    }

    /// Signals that it reads and the estimator knows.
    #[must_use]
    pub fn signals(&self) -> &[Signal] {
        &self.signals
    }

    /// Columns that it reads and the estimator does not know.
    #[must_use]
    pub fn columns(&self) -> &[String] {
        &self.columns
    }

    /// Unit of the coefficient that converts its value to metres.
    #[must_use]
    pub fn coefficient_unit(&self) -> Dimension {
        Dimension::METRE.over(self.dimension)
    }

    /// Checks that a coefficient of this unit converts its value to metres.
    ///
    /// # Errors
    /// [`FormulaError`] for the whole formula, with the unit that is needed.
    pub fn check_unit(&self, unit: &str) -> Result<(), FormulaError> {
        let whole = 0..self.text.len();
        let Some(given) = Dimension::of_unit(unit) else {
            let message = format!(
                "unit '{unit}' is not valid: expected a product of m, s, K, Pa, rad and 1, such as s^2/m"
            );
            return Err(FormulaError::new(&self.text, whole, message));
        };
        let (own, wanted) = (self.dimension, self.coefficient_unit());
        if given == wanted {
            return Ok(());
        }
        let message = format!(
            "the formula is in {own}: times a coefficient in {unit} that is {}, expected metres; its unit would be {wanted}",
            own.times(given)
        );
        Err(FormulaError::new(&self.text, whole, message))
    }

    /// Fingerprint of the formula's meaning, whatever its layout, of the units of its columns, and of
    /// `beside`.
    #[must_use]
    pub fn fingerprint(&self, columns: &Columns, beside: &[&str]) -> u64 {
        let mut digest = CRC.digest();
        digest.update(self.canonical.as_bytes());
        for column in columns.iter().filter(|column| self.columns.iter().any(|name| name == column.name())) {
            digest.update(format!("\n{} {}", column.name(), column.unit_said()).as_bytes());
        }
        for part in beside {
            digest.update(b"\n");
            digest.update(part.as_bytes());
        }
        digest.finalize()
    }
}

struct Compiler<'a> {
    text: &'a str,
    columns: &'a mut Columns,
    ops: Vec<Op>,
    masks: Vec<u64>,
    words: usize,
}

/// Known properties of a compiled part.
#[derive(Clone, Copy)]
struct Part {
    /// `None`: 0 or infinity of any dimension; only a bare 0 has this.
    dimension: Option<Dimension>,
    /// Its value, if it is a plain constant.
    constant: Option<f64>,
    /// The signals in it.
    signals: u64,
}

type Compiled = Result<Part, FormulaError>;

impl Compiler<'_> {
    fn error(&self, span: &Range<usize>, message: impl Into<String>) -> FormulaError {
        FormulaError::new(self.text, span.clone(), message)
    }

    fn part(&mut self, expression: &Expression) -> Compiled {
        let from = self.ops.len();
        let part = self.unfolded(expression)?;
        if let Some(value) = part.constant {
            self.ops.truncate(from);
            let single = value as f32;
            if !single.is_finite() {
                return Err(self
                    .error(&expression.span, format!("this is {value}, expected a number that f32 holds")));
            }
            self.ops.push(Op::Constant(single));
        }
        Ok(part)
    }

    fn unfolded(&mut self, expression: &Expression) -> Compiled {
        let span = &expression.span;
        match &expression.kind {
            Kind::Number(value, dimension) => {
                let any = *value == 0.0 && *dimension == Dimension::ONE;
                Ok(Part { dimension: (!any).then_some(*dimension), constant: Some(*value), signals: 0 })
            }
            Kind::Name(name) => self.name(name, span),
            Kind::Negative(inner) => {
                let part = self.part(inner)?;
                self.ops.push(Op::Negate);
                Ok(Part { constant: part.constant.map(|value| -value), ..part })
            }
            Kind::Binary(Operator::Power, base, exponent) => self.power(base, exponent),
            Kind::Binary(operator, left, right) => self.binary(*operator, left, right, span),
            Kind::Call(function, arguments) => self.call(*function, arguments, span),
            Kind::Unknown(name) => {
                let known: Vec<&str> = FUNCTIONS.iter().map(|function| function.name()).collect();
                let nearest = crate::file::nearest(name, &known);
                Err(self.error(span, format!("no function '{name}'; nearest: {nearest}")))
            }
        }
    }

    fn name(&mut self, name: &str, span: &Range<usize>) -> Compiled {
        if let Some((_, value, unit, _)) = CONSTANTS.iter().find(|(own, ..)| *own == name) {
            return Ok(Part { dimension: Dimension::of_unit(unit), constant: Some(*value), signals: 0 });
        }
        if name == "tau" {
            self.ops.push(Op::TimeConstant);
            return Ok(Part { dimension: Some(Dimension::SECOND), constant: None, signals: 0 });
        }
        if name.contains('.') {
            return Err(self.error(
                span,
                format!("no definition '{name}' in this model, and no such effect in the catalogue"),
            ));
        }
        if let Some(function) = Function::from_name(name) {
            let about = function.about();
            return Err(self.error(
                span,
                format!("{name} is a function ({about}), expected its arguments in parentheses"),
            ));
        }
        let (place, dimension) = match Signal::from_name(name) {
            Some(signal) => (signal.place(), Dimension::of_unit(signal.unit()).unwrap_or(Dimension::ONE)),
            None => {
                let Some((number, dimension)) = self.columns.number(name) else {
                    let message = format!(
                        "'{name}' is one column too many: the formulas of a model can read {MAX_COLUMNS} columns that the estimator does not know"
                    );
                    return Err(self.error(span, message));
                };
                (Signal::column_place(number), dimension)
            }
        };
        self.ops.push(Op::Signal(place));
        Ok(Part { dimension: Some(dimension), constant: None, signals: 1 << place })
    }

    /// The dimension that two parts share.
    fn shared(
        &self,
        (left, of_left): (&Expression, Part),
        (right, of_right): (&Expression, Part),
        what: &str,
    ) -> Result<Option<Dimension>, FormulaError> {
        match (of_left.dimension, of_right.dimension) {
            (Some(left_has), Some(right_has)) if left_has != right_has => {
                let span = left.span.start..right.span.end;
                let hint = match (of_left.constant, of_right.constant) {
                    (_, Some(value)) if right_has == Dimension::ONE => {
                        format!("; a number with a unit is {value}[{left_has}]")
                    }
                    (Some(value), _) if left_has == Dimension::ONE => {
                        format!("; a number with a unit is {value}[{right_has}]")
                    }
                    _ => String::new(),
                };
                let message = format!(
                    "{what} of {left_has} and {right_has}: expected the same dimension on both sides{hint}"
                );
                Err(self.error(&span, message))
            }
            (left, right) => Ok(left.or(right)),
        }
    }

    fn binary(
        &mut self,
        operator: Operator,
        left: &Expression,
        right: &Expression,
        span: &Range<usize>,
    ) -> Compiled {
        // Greater-than is less-than with the operands swapped.
        let is_swapped = matches!(operator, Operator::More | Operator::MoreOrEqual);
        let (of_left, of_right);
        if is_swapped {
            of_right = self.part(right)?;
            of_left = self.part(left)?;
        } else {
            of_left = self.part(left)?;
            of_right = self.part(right)?;
        }
        let signals = of_left.signals | of_right.signals;
        let both = of_left.constant.zip(of_right.constant);
        let one = Dimension::ONE;
        let known = |part: Part| part.dimension.unwrap_or(one);
        let pair = ((left, of_left), (right, of_right));
        match operator {
            Operator::Add | Operator::Subtract => {
                let (what, op) = match operator {
                    Operator::Add => ("a sum", Op::Add),
                    _ => ("a difference", Op::Subtract),
                };
                let dimension = self.shared(pair.0, pair.1, what)?;
                self.ops.push(op);
                let constant = both.map(|(a, b)| if op == Op::Add { a + b } else { a - b });
                Ok(Part { dimension, constant, signals })
            }
            Operator::Multiply => {
                self.ops.push(Op::Multiply);
                let dimension = match (of_left.dimension, of_right.dimension) {
                    (Some(left), Some(right)) => Some(left.times(right)),
                    _ => None,
                };
                Ok(Part { dimension, constant: both.map(|(a, b)| a * b), signals })
            }
            Operator::Divide => {
                if of_right.constant == Some(0.0) {
                    return Err(self.error(
                        span,
                        "always a division by zero: expected a divisor that can be another number",
                    ));
                }
                self.ops.push(Op::Divide);
                let dimension = of_left.dimension.map(|left| left.over(known(of_right)));
                Ok(Part { dimension, constant: both.map(|(a, b)| a / b), signals })
            }
            _ => {
                self.shared(pair.0, pair.1, "a comparison")?;
                self.ops.push(match operator {
                    Operator::Less | Operator::More => Op::Less,
                    Operator::LessOrEqual | Operator::MoreOrEqual => Op::LessOrEqual,
                    _ => Op::Equal,
                });
                if operator == Operator::NotEqual {
                    self.ops.push(Op::Not);
                }
                Ok(Part { dimension: Some(one), constant: None, signals })
            }
        }
    }

    fn power(&mut self, base: &Expression, exponent: &Expression) -> Compiled {
        let of_base = self.part(base)?;
        let from = self.ops.len();
        let of_exponent = self.part(exponent)?;
        self.ops.truncate(from);
        let Some(value) = of_exponent.constant else {
            return Err(self.error(
                &exponent.span,
                "an exponent that changes in flight, expected a number, such as 2 or 1/2",
            ));
        };
        if of_exponent.dimension.is_some_and(|dimension| dimension != Dimension::ONE) {
            return Err(self.error(&exponent.span, "an exponent with a unit, expected a plain number"));
        }
        let dimension = match (of_base.dimension, Ratio::near(value)) {
            (Some(Dimension::ONE), _) => Some(Dimension::ONE),
            (None, _) => None,
            (Some(base), Some(ratio)) => Some(base.to_the(ratio)),
            (Some(base), None) => {
                let message = format!(
                    "{base} to the power of {value}: expected a whole number or a fraction of small ones, or a base without unit"
                );
                return Err(self.error(&exponent.span, message));
            }
        };
        const LARGEST_WHOLE: f64 = 16.0;
        self.ops.push(if value == 0.5 {
            Op::Root
        } else if value.fract() == 0.0 && value.abs() <= LARGEST_WHOLE {
            Op::Power(value as i8)
        } else {
            Op::RealPower(value as f32)
        });
        let constant = of_base.constant.map(|base| libm::pow(base, value));
        Ok(Part { dimension, constant, signals: of_base.signals })
    }

    fn call(&mut self, function: Function, arguments: &[Expression], span: &Range<usize>) -> Compiled {
        let (name, wanted) = (function.name(), function.arguments());
        if arguments.len() != wanted {
            let plural = if wanted == 1 { "" } else { "s" };
            let message = format!(
                "{name} of {} arguments, expected {wanted} argument{plural}: {}",
                arguments.len(),
                function.about()
            );
            return Err(self.error(span, message));
        }
        match (function, arguments) {
            (Function::Clamp, [x, low, high]) => {
                let of_x = self.part(x)?;
                let of_low = self.part(low)?;
                let dimension = self.shared((x, of_x), (low, of_low), "clamp")?;
                self.ops.push(Op::Max);
                let of_high = self.part(high)?;
                let dimension = self.shared((x, Part { dimension, ..of_x }), (high, of_high), "clamp")?;
                self.ops.push(Op::Min);
                Ok(Part {
                    dimension,
                    constant: None,
                    signals: of_x.signals | of_low.signals | of_high.signals,
                })
            }
            (Function::Min | Function::Max, [a, b]) => {
                let (of_a, of_b) = (self.part(a)?, self.part(b)?);
                let dimension = self.shared((a, of_a), (b, of_b), name)?;
                self.ops.push(if function == Function::Min { Op::Min } else { Op::Max });
                Ok(Part { dimension, constant: None, signals: of_a.signals | of_b.signals })
            }
            (Function::LowPass | Function::Delay, [x, time]) => self.in_time(function, x, time),
            (_, [x]) => self.unary(function, x, span),
            _ => Err(self.error(span, format!("{name} cannot be called like this"))),
        }
    }

    fn in_time(&mut self, function: Function, x: &Expression, time: &Expression) -> Compiled {
        let of_x = self.part(x)?;
        let of_time = self.part(time)?;
        let dimension = of_time.dimension;
        // A bare number is in seconds: no other meaning is possible.
        if dimension.is_some_and(|dimension| dimension != Dimension::SECOND && dimension != Dimension::ONE) {
            let message = format!("a time in {}, expected seconds", dimension.unwrap_or(Dimension::ONE));
            return Err(self.error(&time.span, message));
        }
        if of_time.signals != 0 {
            return Err(
                self.error(&time.span, "a time that changes in flight, expected a number of seconds or tau")
            );
        }
        let is_possible = match function {
            Function::Delay => {
                of_time.constant.is_none_or(|seconds| seconds > 0.0 && seconds <= LONGEST_DELAY_S)
            }
            _ => of_time.constant.is_none_or(|seconds| seconds >= 0.0),
        };
        if !is_possible {
            let most = if function == Function::Delay { " and up to 60" } else { "" };
            return Err(self.error(
                &time.span,
                format!("a time of {} s, expected one above 0{most}", of_time.constant.unwrap_or(0.0)),
            ));
        }
        self.remember(|at| if function == Function::Delay { Op::Delay { at } } else { Op::LowPass { at } });
        Ok(Part { constant: None, ..of_x })
    }

    fn unary(&mut self, function: Function, x: &Expression, span: &Range<usize>) -> Compiled {
        let part = self.part(x)?;
        let one = Some(Dimension::ONE);
        let has = part.dimension;
        let wants = |dimension: Option<Dimension>, wanted: &str| match has {
            Some(has) if Some(has) != dimension => {
                Err(self.error(&x.span, format!("{} of {has}, expected {wanted}", function.name())))
            }
            _ => Ok(()),
        };
        let per = |dimension: Dimension| has.map(|has| has.over(dimension));
        let dimension = match function {
            Function::Exponential | Function::Logarithm => wants(one, "a plain number").map(|()| one)?,
            Function::Sine | Function::Cosine => {
                if has != one {
                    wants(Some(Dimension::RADIAN), "radians")?;
                }
                one
            }
            Function::IsaAltitude => {
                wants(Dimension::of_unit("Pa"), "a pressure, Pa")?;
                Some(Dimension::METRE)
            }
            Function::IsaPressure | Function::IsaTemperature | Function::IsaDensity => {
                wants(Some(Dimension::METRE), "an altitude, m")?;
                Dimension::of_unit(match function {
                    Function::IsaPressure => "Pa",
                    Function::IsaTemperature => "K",
                    _ => "Pa s^2/m^2",
                })
            }
            Function::Step => one,
            Function::Root => Ratio::new(1, 2).and_then(|half| has.map(|has| has.to_the(half))),
            Function::Rate => per(Dimension::SECOND),
            Function::Integral => has.map(|has| has.times(Dimension::SECOND)),
            Function::DoubleIntegral => has.map(|has| has.times(Dimension::SECOND).times(Dimension::SECOND)),
            _ => has,
        };
        let mask = if matches!(function, Function::Rate | Function::Captive | Function::AtCalibration) {
            self.mask(part.signals)
        } else {
            0
        };
        match function {
            Function::Absolute => self.ops.push(Op::Absolute),
            Function::Root => self.ops.push(Op::Root),
            Function::Exponential => self.ops.push(Op::Exponential),
            Function::Logarithm => self.ops.push(Op::Logarithm),
            Function::Sine => self.ops.push(Op::Sine),
            Function::Cosine => self.ops.push(Op::Cosine),
            Function::Step => self.ops.push(Op::Step),
            Function::IsaAltitude => self.ops.push(Op::IsaAltitude),
            Function::IsaPressure => self.ops.push(Op::IsaPressure),
            Function::IsaTemperature => self.ops.push(Op::IsaTemperature),
            Function::IsaDensity => self.ops.push(Op::IsaDensity),
            Function::Rate => self.remember(|at| Op::Rate { at, mask, of: TOP }),
            Function::Integral => self.remember(|at| Op::Integral { at, of: TOP }),
            Function::DoubleIntegral => self.remember(|at| Op::DoubleIntegral { at, of: TOP }),
            Function::Captive => self.remember(|at| Op::Captive { at, mask, of: TOP }),
            Function::AtCalibration => self.remember(|at| Op::AtCalibration { at, mask, of: TOP }),
            Function::AtLaunch => self.remember(|at| Op::AtLaunch { at, of: TOP }),
            Function::Min | Function::Max | Function::Clamp | Function::LowPass | Function::Delay => {
                return Err(self.error(span, format!("{} cannot be called like this", function.name())));
            }
        }
        Ok(Part { dimension, constant: None, signals: part.signals })
    }

    /// Pushes an operation with memory.
    fn remember(&mut self, op: impl FnOnce(u8) -> Op) {
        // A memory too large for a byte is too large for a program, which is detected at the end.
        let op = op(u8::try_from(self.words).unwrap_or(u8::MAX));
        self.words += op.memory().map_or(0, |(_, words)| words);
        self.ops.push(op);
    }

    /// The number of a set of signals; an empty set becomes time, which always changes.
    fn mask(&mut self, signals: u64) -> u8 {
        let signals = if signals == 0 { Signal::Time.bit() } else { signals };
        let at = self.masks.iter().position(|mask| *mask == signals).unwrap_or_else(|| {
            self.masks.push(signals);
            self.masks.len() - 1
        });
        u8::try_from(at).unwrap_or(u8::MAX)
    }
}
