//! Evaluation of a program at one tick.

use super::program::{MAX_DEPTH, MAX_MASKS, MAX_STATE_WORDS, Op, Program, TOP};
use super::words::{at_calibration, at_launch, captive, double_integral, integral, low_pass, rate, words};
use super::{Frame, delay, fast_path};
use crate::atmosphere::{
    AIR_GAS_CONSTANT, LAPSE_RATE_K_PER_M, SEA_LEVEL_TEMPERATURE_K, TROPOPAUSE_ALTITUDE_M,
    pressure_altitude_m, static_pressure_pa,
};
use crate::root::reciprocal_root;
use crate::trigonometry::sine_and_cosine;

/// Why a formula has no value at a tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Silent {
    /// A signal has not been seen yet, or a function of the past has too little history.
    NotYet,
    /// A division by zero.
    DivisionByZero,
    /// A root, a logarithm or a non-integer power of a number for which it is undefined.
    NoRoot,
    /// An angle, altitude, pressure or time outside its function's range.
    OutOfRange,
    /// A result that is too large.
    Overflow,
}

impl Silent {
    /// The reason, in a few words.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::NotYet => "a signal not seen yet",
            Self::DivisionByZero => "a division by zero",
            Self::NoRoot => "a root or logarithm of a negative number",
            Self::OutOfRange => "an argument out of range",
            Self::Overflow => "a number too large",
        }
    }
}

/// Scratch memory for the stack of one tick. Its content does not outlive the tick. The caller owns it
/// because clearing it at every tick would cost as much as an operation.
#[derive(Clone, Copy, Debug, Default)]
pub struct Stack([f32; MAX_DEPTH]);

/// A program and its memory.
#[derive(Clone, Copy, Debug)]
pub struct Evaluation {
    program: Program,
    time_constant_s: f32,
    state: [f32; MAX_STATE_WORDS],
    stack: Stack,
}

impl Evaluation {
    /// The state before the first tick.
    #[must_use]
    pub const fn new(program: &Program, time_constant_s: f32) -> Self {
        Self {
            program: *program,
            time_constant_s,
            state: [0.0; MAX_STATE_WORDS],
            stack: Stack([0.0; MAX_DEPTH]),
        }
    }

    /// The formula's value at a tick.
    ///
    /// # Errors
    /// [`Silent`]: the formula has no value.
    pub fn step(&mut self, frame: &Frame) -> Result<f32, Silent> {
        step(&self.program, &mut self.state, &mut self.stack, frame, self.time_constant_s)
    }

    /// The program.
    #[must_use]
    pub const fn program(&self) -> &Program {
        &self.program
    }

    /// The program's memory; finite numbers.
    #[must_use]
    pub const fn state(&self) -> &[f32; MAX_STATE_WORDS] {
        &self.state
    }
}

/// Runs a program over a tick's signals. `state` holds at least [`Program::state_words`] numbers: 0 before
/// the first tick, then as the last tick left them.
///
/// # Errors
/// [`Silent`]: the first operation that left the formula without a value.
#[inline]
pub fn step(
    program: &Program,
    state: &mut [f32],
    Stack(stack): &mut Stack,
    frame: &Frame,
    time_constant_s: f32,
) -> Result<f32, Silent> {
    let mut why = None;
    let mut depth = 0_usize;
    let mut top = 0.0_f32;
    let (seconds, launched, begins) = (frame.seconds, frame.launched, frame.calibration_begins);
    // The program has been checked: every operand is there. Masks show the compiler that every index is in
    // range.
    for op in program.ops() {
        let mut under = 0.0;
        macro_rules! push {
            ($value:expr) => {{
                stack[depth & (MAX_DEPTH - 1)] = top;
                depth = depth.wrapping_add(1);
                $value
            }};
        }
        macro_rules! pop {
            () => {{
                depth = depth.wrapping_sub(1);
                under = stack[depth & (MAX_DEPTH - 1)];
                under
            }};
        }
        // A second argument that is not on the stack: checked for being a number as if it had been.
        macro_rules! constant {
            ($value:expr) => {{
                under = $value;
                under
            }};
        }
        macro_rules! signal {
            ($place:expr) => {{
                under = frame.number($place);
                under
            }};
        }
        // An operation with memory takes its argument from the stack, or first pushes a signal and takes
        // that.
        macro_rules! argument {
            ($of:expr) => {
                if $of != TOP {
                    top = push!(frame.number($of));
                }
            };
        }
        macro_rules! remembered {
            ($at:expr, |$memory:ident| $value:expr) => {
                match words(state, $at) {
                    Some($memory) => $value,
                    None => f32::NAN,
                }
            };
        }
        // The fast path if it yields a value, else the general function.
        macro_rules! remembered_fast {
            ($at:expr, $of:expr, |$memory:ident| $fast:expr, $general:expr) => {{
                argument!($of);
                remembered!($at, |$memory| {
                    match $fast {
                        Some(value) => value,
                        None => $general,
                    }
                })
            }};
        }
        let value = match *op {
            Op::Constant(value) => push!(value),
            Op::Signal(place) => push!(frame.number(place)),
            Op::TimeConstant => push!(time_constant_s),
            Op::Add => pop!() + top,
            Op::Subtract => pop!() - top,
            Op::Multiply => pop!() * top,
            Op::Divide => {
                let above = pop!();
                quotient(above, top)
            }
            Op::AddConstant(number) => top + constant!(number),
            Op::SubtractConstant(number) => top - constant!(number),
            Op::MultiplyConstant(number) => top * constant!(number),
            Op::DivideConstant(number) => quotient(top, constant!(number)),
            Op::MinConstant(number) => smaller(top, constant!(number)),
            Op::MaxConstant(number) => larger(top, constant!(number)),
            Op::AddSignal(place) => top + signal!(place),
            Op::SubtractSignal(place) => top - signal!(place),
            Op::MultiplySignal(place) => top * signal!(place),
            Op::DivideSignal(place) => quotient(top, signal!(place)),
            Op::Power(exponent) => power(top, exponent),
            Op::Negate => -top,
            Op::Absolute => top.abs(),
            Op::Not => 1.0 - top,
            Op::Step => of_number(top, truth(top > 0.0)),
            Op::Min => {
                let other = pop!();
                smaller(other, top)
            }
            Op::Max => {
                let other = pop!();
                larger(other, top)
            }
            Op::Less => {
                let other = pop!();
                of_numbers(other, top, truth(other < top))
            }
            Op::LessOrEqual => {
                let other = pop!();
                of_numbers(other, top, truth(other <= top))
            }
            Op::Equal => {
                let other = pop!();
                of_numbers(other, top, truth(other == top))
            }
            Op::LowPass { at } => {
                let argument = pop!();
                remembered!(at, |memory| low_pass(memory, argument, top, seconds))
            }
            Op::Delay { at } => {
                let argument = pop!();
                remembered!(at, |memory| delay::delay(memory, argument, top * delay::INTERVAL, seconds))
            }
            Op::LowPassBy { at, of, seconds: time_s } => remembered_fast!(
                at,
                of,
                |memory| fast_path::low_pass(memory, top, time_s, seconds),
                low_pass(memory, top, time_s, seconds)
            ),
            Op::DelayBy { at, of, interval_s } => remembered_fast!(
                at,
                of,
                |memory| fast_path::delay(memory, top, interval_s, seconds),
                delay::delay(memory, top, interval_s, seconds)
            ),
            Op::Rate { at, mask, of } => {
                let is_new = is_new(program, frame, mask);
                remembered_fast!(
                    at,
                    of,
                    |memory| fast_path::rate(memory, top, seconds, is_new),
                    rate(memory, top, seconds, is_new)
                )
            }
            Op::Integral { at, of } => remembered_fast!(
                at,
                of,
                |memory| fast_path::integral(memory, top, seconds, launched),
                integral(memory, top, seconds, launched)
            ),
            Op::DoubleIntegral { at, of } => remembered_fast!(
                at,
                of,
                |memory| fast_path::double_integral(memory, top, seconds, launched),
                double_integral(memory, top, seconds, launched)
            ),
            Op::Captive { at, mask, of } => {
                let is_new = move || is_new(program, frame, mask);
                remembered_fast!(
                    at,
                    of,
                    |memory| fast_path::captive(memory, top, is_new, launched, begins),
                    captive(memory, top, is_new, launched, begins)
                )
            }
            Op::AtCalibration { at, mask, of } => {
                argument!(of);
                remembered!(at, |memory| at_calibration(memory, top, || is_new(program, frame, mask), begins))
            }
            Op::AtLaunch { at, of } => remembered_fast!(
                at,
                of,
                |memory| fast_path::at_launch(memory, top, launched),
                at_launch(memory, top, launched)
            ),
            // Listed one by one, so that no operation is compared beyond the last.
            op @ (Op::Root
            | Op::Exponential
            | Op::Logarithm
            | Op::Sine
            | Op::Cosine
            | Op::RealPower(_)
            | Op::IsaAltitude
            | Op::IsaPressure
            | Op::IsaTemperature
            | Op::IsaDensity) => of_number(top, function(op, top)),
        };
        if value.is_finite() {
            top = value;
        } else {
            let were_numbers = !(top.is_nan() || under.is_nan());
            why = why.or(Some(reason(*op, top, under, were_numbers, value)));
            top = f32::NAN;
        }
    }
    if top.is_nan() { Err(why.unwrap_or(Silent::NotYet)) } else { Ok(top) }
}

/// `value`, or NaN where the argument is NaN.
#[inline(always)]
fn of_number(argument: f32, value: f32) -> f32 {
    if argument.is_nan() { argument } else { value }
}

#[inline(always)]
fn of_numbers(a: f32, b: f32, value: f32) -> f32 {
    of_number(a, of_number(b, value))
}

#[inline(always)]
fn quotient(above: f32, below: f32) -> f32 {
    if below == 0.0 { f32::NAN } else { above / below }
}

#[inline(always)]
fn smaller(a: f32, b: f32) -> f32 {
    of_numbers(a, b, if a < b { a } else { b })
}

#[inline(always)]
fn larger(a: f32, b: f32) -> f32 {
    of_numbers(a, b, if a > b { a } else { b })
}

#[inline(always)]
fn is_new(program: &Program, frame: &Frame, mask: u8) -> bool {
    program
        .masks()
        .get(usize::from(mask) & MAX_MASKS.wrapping_sub(1))
        .is_some_and(|mask| mask & frame.new != 0)
}

#[inline(always)]
fn truth(is_true: bool) -> f32 {
    if is_true { 1.0 } else { 0.0 }
}

#[inline(never)]
fn function(op: Op, a: f32) -> f32 {
    match op {
        Op::Root => root(a),
        Op::Exponential => libm::expf(a),
        Op::Logarithm => logarithm(a),
        Op::Sine => sine_and_cosine(a).map_or(f32::NAN, |(sine, _)| sine),
        Op::Cosine => sine_and_cosine(a).map_or(f32::NAN, |(_, cosine)| cosine),
        Op::RealPower(exponent) if a == 0.0 && exponent > 0.0 => 0.0,
        // Not `powf`: libm's version calls its square root, which is forbidden in a tick.
        Op::RealPower(exponent) => libm::expf(exponent * logarithm(a)),
        Op::IsaAltitude => pressure_altitude_m(a).unwrap_or(f32::NAN),
        Op::IsaPressure => static_pressure_pa(a).unwrap_or(f32::NAN),
        Op::IsaTemperature => temperature_k(a),
        Op::IsaDensity => static_pressure_pa(a)
            .map_or(f32::NAN, |pressure_pa| pressure_pa / (AIR_GAS_CONSTANT * temperature_k(a))),
        _ => f32::NAN,
    }
}

/// Temperature of the standard atmosphere, K.
fn temperature_k(altitude_m: f32) -> f32 {
    let in_troposphere_m =
        if altitude_m < TROPOPAUSE_ALTITUDE_M { altitude_m } else { TROPOPAUSE_ALTITUDE_M };
    SEA_LEVEL_TEMPERATURE_K - LAPSE_RATE_K_PER_M * in_troposphere_m
}

fn logarithm(a: f32) -> f32 {
    if a > 0.0 { libm::logf(a) } else { f32::NAN }
}

/// Square root, correct to rounding: one of Heron's steps after the reciprocal root.
fn root(a: f32) -> f32 {
    if a < 0.0 {
        return f32::NAN;
    }
    if a < f32::MIN_POSITIVE {
        return 0.0;
    }
    let guess = a * reciprocal_root(a);
    0.5 * (guess + a / guess)
}

/// Integer power, by repeated squaring.
#[inline]
fn power(a: f32, exponent: i8) -> f32 {
    if exponent == 2 {
        return a * a;
    }
    if exponent < 0 && a == 0.0 {
        return f32::NAN;
    }
    let mut left = exponent.unsigned_abs();
    let (mut result, mut square) = (1.0, a);
    while left != 0 {
        if left & 1 == 1 {
            result *= square;
        }
        left >>= 1;
        if left != 0 {
            square *= square;
        }
    }
    if exponent < 0 { 1.0 / result } else { result }
}

/// Why an operation gave no number. `top` is the argument from the top of the stack, `second` the other one.
#[cold]
fn reason(op: Op, top: f32, second: f32, was_number: bool, value: f32) -> Silent {
    if !was_number {
        return Silent::NotYet;
    }
    match op {
        Op::Divide if top == 0.0 => Silent::DivisionByZero,
        Op::DivideConstant(_) | Op::DivideSignal(_) if second == 0.0 => Silent::DivisionByZero,
        Op::Power(exponent) if exponent < 0 && top == 0.0 => Silent::DivisionByZero,
        Op::RealPower(exponent) if exponent < 0.0 && top == 0.0 => Silent::DivisionByZero,
        Op::Root | Op::Logarithm | Op::RealPower(_) if value.is_nan() => Silent::NoRoot,
        Op::Sine | Op::Cosine | Op::IsaAltitude | Op::IsaPressure | Op::IsaDensity => Silent::OutOfRange,
        Op::Signal(_)
        | Op::TimeConstant
        | Op::Captive { .. }
        | Op::AtCalibration { .. }
        | Op::AtLaunch { .. } => Silent::NotYet,
        Op::Rate { .. } | Op::Delay { .. } | Op::DelayBy { .. } if value.is_nan() => Silent::NotYet,
        _ => Silent::Overflow,
    }
}
