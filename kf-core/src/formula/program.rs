//! A formula, compiled: operations of a stack machine.

use super::signal::SIGNALS;

/// Largest number of operations in a program.
pub const MAX_OPS: usize = 48;
/// Largest depth of the stack.
pub const MAX_DEPTH: usize = 16;
/// Largest number of signal sets that functions with memory wait for.
pub const MAX_MASKS: usize = 8;
/// Limit on the numbers that one program remembers.
pub const MAX_STATE_WORDS: usize = 64;
/// Powers of two, so that a mask keeps an index in range.
const _: () = assert!(MAX_DEPTH.is_power_of_two() && MAX_MASKS.is_power_of_two());
/// Value of `of` for an argument that is on the stack rather than a signal; the compiler of formulas writes
/// every operation like that.
pub const TOP: u8 = u8::MAX;

/// One operation. Arguments are taken from the stack, the last one from its top, and the result takes their
/// place. `at` is where the operation's memory begins; `mask` selects the program's set of signals at whose
/// samples it samples its argument.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Op {
    /// A number.
    Constant(f32),
    /// A signal, by its place in a [`super::Frame`].
    Signal(u8),
    /// The term's time constant, seconds.
    TimeConstant,
    /// `a + b`.
    Add,
    /// `a - b`.
    Subtract,
    /// `a b`.
    Multiply,
    /// `a / b`; silent where `b` is 0.
    Divide,
    /// The smaller.
    Min,
    /// The larger.
    Max,
    /// 1 where `a < b`, else 0.
    Less,
    /// 1 where `a <= b`, else 0.
    LessOrEqual,
    /// 1 where `a = b`, else 0.
    Equal,
    /// `-a`.
    Negate,
    /// `|a|`.
    Absolute,
    /// `1 - a`: the opposite of a comparison.
    Not,
    /// 1 where `a > 0`, else 0.
    Step,
    /// `a + c`: the constant is part of the operation, as joined by [`Program::new`]; likewise below.
    AddConstant(f32),
    /// `a - c`.
    SubtractConstant(f32),
    /// `a c`.
    MultiplyConstant(f32),
    /// `a / c`; silent where `c` is 0.
    DivideConstant(f32),
    /// The smaller of `a` and `c`.
    MinConstant(f32),
    /// The larger of `a` and `c`.
    MaxConstant(f32),
    /// `a + s`, of a signal by its place in a [`super::Frame`].
    AddSignal(u8),
    /// `a - s`.
    SubtractSignal(u8),
    /// `a s`.
    MultiplySignal(u8),
    /// `a / s`; silent where `s` is 0.
    DivideSignal(u8),
    /// [`Op::LowPass`] with a constant time constant, above 0.
    LowPassBy {
        /// Two words.
        at: u8,
        /// The signal that is its argument, or [`TOP`].
        of: u8,
        /// Its time constant, s.
        seconds: f32,
    },
    /// [`Op::Delay`] by a constant.
    DelayBy {
        /// `delay::WORDS` words.
        at: u8,
        /// The signal that is its argument, or [`TOP`].
        of: u8,
        /// Interval between the samples that are kept, s: a fraction of the delay.
        interval_s: f32,
    },
    /// Square root; silent below 0.
    Root,
    /// `exp a`.
    Exponential,
    /// Natural logarithm; silent at 0 and below.
    Logarithm,
    /// Sine of radians; silent beyond a thousand.
    Sine,
    /// Cosine of radians; silent beyond a thousand.
    Cosine,
    /// Integer power.
    Power(i8),
    /// Real power; silent below 0.
    RealPower(f32),
    /// Pressure altitude (m) of a pressure (Pa), ICAO Doc 7488.
    IsaAltitude,
    /// Pressure (Pa) of the standard atmosphere at an altitude (m).
    IsaPressure,
    /// Temperature (K) of the standard atmosphere at an altitude (m).
    IsaTemperature,
    /// Density of the standard atmosphere at an altitude (m), Pa s^2/m^2 (kg/m^3).
    IsaDensity,
    /// Rate of change, between samples of the mask's signals.
    Rate {
        /// Four words.
        at: u8,
        /// When to sample.
        mask: u8,
        /// The signal that is its argument, or [`TOP`].
        of: u8,
    },
    /// Integral over time from launch on, by trapezia; 0 before.
    Integral {
        /// Four words.
        at: u8,
        /// The signal that is its argument, or [`TOP`].
        of: u8,
    },
    /// Integral of the integral from launch on; 0 before.
    DoubleIntegral {
        /// Six words.
        at: u8,
        /// The signal that is its argument, or [`TOP`].
        of: u8,
    },
    /// First-order low pass of `a` with the time constant `b` (s), backward Euler, begun at the first value.
    LowPass {
        /// Two words.
        at: u8,
    },
    /// `a` as it was `b` seconds ago, from sixteen samples over that time joined by straight lines; silent
    /// until then.
    Delay {
        /// `delay::WORDS` words.
        at: u8,
    },
    /// Mean of `a` over the samples of the calibration (before it, over all so far); after launch, the mean
    /// of captive flight.
    Captive {
        /// Three words.
        at: u8,
        /// What counts as a sample.
        mask: u8,
        /// The signal that is its argument, or [`TOP`].
        of: u8,
    },
    /// `a` at the first sample of the calibration; before it, at the first sample of all.
    AtCalibration {
        /// Two words.
        at: u8,
        /// What counts as a sample.
        mask: u8,
        /// The signal that is its argument, or [`TOP`].
        of: u8,
    },
    /// `a` before launch; after launch, its value at launch.
    AtLaunch {
        /// Two words.
        at: u8,
        /// The signal that is its argument, or [`TOP`].
        of: u8,
    },
}

impl Op {
    /// Number of arguments taken from the stack.
    #[must_use]
    pub const fn arguments(self) -> usize {
        match self {
            Self::Constant(_) | Self::Signal(_) | Self::TimeConstant => 0,
            op if op.argument_signal().is_some() => 0,
            Self::Add
            | Self::Subtract
            | Self::Multiply
            | Self::Divide
            | Self::Min
            | Self::Max
            | Self::Less
            | Self::LessOrEqual
            | Self::Equal
            | Self::LowPass { .. }
            | Self::Delay { .. } => 2,
            _ => 1,
        }
    }

    /// Start of its memory, and number of words; `None` for an operation without memory.
    #[must_use]
    pub const fn memory(self) -> Option<(u8, usize)> {
        match self {
            Self::Rate { at, .. } | Self::Integral { at, .. } => Some((at, 4)),
            Self::DoubleIntegral { at, .. } => Some((at, 6)),
            Self::LowPass { at }
            | Self::LowPassBy { at, .. }
            | Self::AtCalibration { at, .. }
            | Self::AtLaunch { at, .. } => Some((at, 2)),
            Self::Delay { at } | Self::DelayBy { at, .. } => Some((at, super::delay::WORDS)),
            Self::Captive { at, .. } => Some((at, 3)),
            _ => None,
        }
    }

    /// The signal that it reads, by its place in a [`super::Frame`].
    const fn signal(self) -> Option<u8> {
        match self {
            Self::Signal(place)
            | Self::AddSignal(place)
            | Self::SubtractSignal(place)
            | Self::MultiplySignal(place)
            | Self::DivideSignal(place) => Some(place),
            op => op.argument_signal(),
        }
    }

    /// The signal that an operation with a memory takes directly.
    const fn argument_signal(self) -> Option<u8> {
        match self {
            Self::LowPassBy { of, .. }
            | Self::DelayBy { of, .. }
            | Self::Rate { of, .. }
            | Self::Integral { of, .. }
            | Self::DoubleIntegral { of, .. }
            | Self::Captive { of, .. }
            | Self::AtCalibration { of, .. }
            | Self::AtLaunch { of, .. }
                if of != TOP =>
            {
                Some(of)
            }
            _ => None,
        }
    }

    /// Joins this operation with the one before it, which puts its last argument on the stack; `None` where
    /// no operation does both. It gives the same numbers at less than the cost of two.
    const fn joined(self, before: Self) -> Option<Self> {
        Some(match (before, self) {
            (Self::Constant(number), Self::Add) => Self::AddConstant(number),
            (Self::Constant(number), Self::Subtract) => Self::SubtractConstant(number),
            (Self::Constant(number), Self::Multiply) => Self::MultiplyConstant(number),
            (Self::Constant(number), Self::Divide) => Self::DivideConstant(number),
            (Self::Constant(number), Self::Min) => Self::MinConstant(number),
            (Self::Constant(number), Self::Max) => Self::MaxConstant(number),
            (Self::Constant(seconds), Self::LowPass { at }) if seconds > 0.0 => {
                Self::LowPassBy { at, of: TOP, seconds }
            }
            (Self::Constant(seconds), Self::Delay { at }) => {
                Self::DelayBy { at, of: TOP, interval_s: seconds * super::delay::INTERVAL }
            }
            (Self::Signal(of), Self::LowPassBy { at, of: TOP, seconds }) => {
                Self::LowPassBy { at, of, seconds }
            }
            (Self::Signal(of), Self::DelayBy { at, of: TOP, interval_s }) => {
                Self::DelayBy { at, of, interval_s }
            }
            (Self::Signal(of), Self::Rate { at, mask, of: TOP }) => Self::Rate { at, mask, of },
            (Self::Signal(of), Self::Integral { at, of: TOP }) => Self::Integral { at, of },
            (Self::Signal(of), Self::DoubleIntegral { at, of: TOP }) => Self::DoubleIntegral { at, of },
            (Self::Signal(of), Self::Captive { at, mask, of: TOP }) => Self::Captive { at, mask, of },
            (Self::Signal(of), Self::AtCalibration { at, mask, of: TOP }) => {
                Self::AtCalibration { at, mask, of }
            }
            (Self::Signal(of), Self::AtLaunch { at, of: TOP }) => Self::AtLaunch { at, of },
            (Self::Signal(place), Self::Add) => Self::AddSignal(place),
            (Self::Signal(place), Self::Subtract) => Self::SubtractSignal(place),
            (Self::Signal(place), Self::Multiply) => Self::MultiplySignal(place),
            (Self::Signal(place), Self::Divide) => Self::DivideSignal(place),
            _ => return None,
        })
    }

    const fn mask(self) -> Option<u8> {
        match self {
            Self::Rate { mask, .. } | Self::Captive { mask, .. } | Self::AtCalibration { mask, .. } => {
                Some(mask)
            }
            _ => None,
        }
    }
}

/// A program; made by `model::formula`, or by hand with [`Program::new`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Program {
    ops: [Op; MAX_OPS],
    length: u8,
    state_words: u8,
    masks: [u64; MAX_MASKS],
    signals: u64,
}

impl Program {
    /// Makes a program of these operations; `masks` are sets of signals, a bit for each place in a
    /// [`super::Frame`]. `None` where it is too long, reads what is not on the stack, leaves other than one
    /// number there, needs too deep a stack, has too much memory, or has memory that is not laid out in the
    /// operations' order.
    #[must_use]
    pub const fn new(ops: &[Op], masks: &[u64]) -> Option<Self> {
        if ops.is_empty() || ops.len() > MAX_OPS || masks.len() > MAX_MASKS {
            return None;
        }
        let mut program = Self {
            ops: [Op::TimeConstant; MAX_OPS],
            length: 0,
            state_words: 0,
            masks: [0; MAX_MASKS],
            signals: 0,
        };
        let mut k = 0;
        while k < masks.len() {
            program.masks[k] = masks[k];
            k += 1;
        }
        let (mut depth, mut words, mut k) = (0, 0, 0);
        while k < ops.len() {
            let op = ops[k];
            if depth < op.arguments() {
                return None;
            }
            depth = depth + 1 - op.arguments();
            if depth > MAX_DEPTH {
                return None;
            }
            if let Some((at, count)) = op.memory() {
                if at as usize != words || words + count > MAX_STATE_WORDS {
                    return None;
                }
                words += count;
            }
            if let Some(mask) = op.mask()
                && mask as usize >= masks.len()
            {
                return None;
            }
            if let Some(place) = op.signal() {
                if place as usize >= SIGNALS {
                    return None;
                }
                program.signals |= 1 << place;
            }
            let mut op = op;
            // A low pass joins twice: the constant before it, then the signal before that.
            while program.length > 0
                && let Some(joined) = op.joined(program.ops[program.length as usize - 1])
            {
                op = joined;
                program.length -= 1;
            }
            program.ops[program.length as usize] = op;
            program.length += 1;
            k += 1;
        }
        program.state_words = words as u8;
        if depth == 1 { Some(program) } else { None }
    }

    /// The program or, without one, a program that is always 0: for a constant that is known to be a program.
    #[must_use]
    pub const fn or_nothing(program: Option<Self>) -> Self {
        match program {
            Some(program) => program,
            None => Self {
                ops: [Op::Constant(0.0); MAX_OPS],
                length: 1,
                state_words: 0,
                masks: [0; MAX_MASKS],
                signals: 0,
            },
        }
    }

    /// Its operations in order of execution, joined where two are done as one.
    #[must_use]
    pub fn ops(&self) -> &[Op] {
        self.ops.get(..usize::from(self.length)).unwrap_or(&self.ops)
    }

    /// Its sets of signals.
    #[must_use]
    pub const fn masks(&self) -> &[u64; MAX_MASKS] {
        &self.masks
    }

    /// How many numbers it remembers from one tick to the next; all are 0 at the start.
    #[must_use]
    pub const fn state_words(&self) -> usize {
        self.state_words as usize
    }

    /// The signals that it reads, a bit for each place in a [`super::Frame`].
    #[must_use]
    pub const fn signals(&self) -> u64 {
        self.signals
    }

    /// Whether it reads the term's time constant.
    #[must_use]
    pub fn has_time_constant(&self) -> bool {
        self.ops().contains(&Op::TimeConstant)
    }

    /// Whether it depends on the whole free flight, by an integral.
    #[must_use]
    pub fn is_integrated(&self) -> bool {
        self.ops().iter().any(|op| matches!(op, Op::Integral { .. } | Op::DoubleIntegral { .. }))
    }
}
