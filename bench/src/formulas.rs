//! The cost of a formula: programs that each use one kind of operation, over signals that change at every
//! tick.

use core::hint::black_box;

use kf_core::effect::{EffectId, Regressor, SignalTracker};
use kf_core::formula::{Evaluation, Frame, Op, Program, Signal, TOP};
use kf_core::input::{Signals, TickInput};

use crate::counter::{Call, Count, Counter};
use crate::{Outcome, Role, TICK_US, TICKS};

/// Duration of a tick, seconds.
const SECONDS: f32 = 0.005;

const AIRSPEED: Op = Op::Signal(Signal::Airspeed.place());
const THROTTLE: Op = Op::Signal(Signal::Throttle.place());
const LAUNCH: Op = Op::Signal(Signal::Launch.place());
const CLIMB: Op = Op::Signal(Signal::ClimbRate.place());

/// `airspeed^2 / (2 g) * throttle * step(launch)`, a typical effect of a user's own.
const HEAD: [Op; 9] = [
    AIRSPEED,
    Op::Power(2),
    Op::Constant(19.613_3),
    Op::Divide,
    THROTTLE,
    Op::Multiply,
    LAUNCH,
    Op::Step,
    Op::Multiply,
];

/// `baro.dynamic_pressure` as a formula: `airspeed^2 / (2 g)`.
const DYNAMIC_PRESSURE: [Op; 4] = [AIRSPEED, Op::Power(2), Op::Constant(19.613_3), Op::Divide];

/// All operations without a memory that are machine instructions.
const ARITHMETIC: [Op; 24] = [
    AIRSPEED,
    Op::Constant(20.0),
    Op::Subtract,
    Op::Constant(0.0),
    Op::Max,
    THROTTLE,
    Op::Multiply,
    CLIMB,
    Op::Absolute,
    Op::Add,
    Op::Power(3),
    Op::Constant(7.0),
    Op::Divide,
    Op::Constant(1.0e6),
    Op::Min,
    CLIMB,
    Op::Negate,
    THROTTLE,
    Op::Less,
    Op::Not,
    Op::Multiply,
    LAUNCH,
    Op::Step,
    Op::Multiply,
];

/// All operations with a memory.
const MEMORY: [Op; 17] = [
    AIRSPEED,
    Op::Constant(2.0),
    Op::LowPass { at: 0 },
    CLIMB,
    Op::Rate { at: 2, mask: 0, of: TOP },
    Op::Add,
    THROTTLE,
    Op::Integral { at: 6, of: TOP },
    Op::Add,
    AIRSPEED,
    Op::Captive { at: 10, mask: 0, of: TOP },
    Op::Subtract,
    THROTTLE,
    Op::Constant(1.0),
    Op::Delay { at: 13 },
    Op::Multiply,
    Op::AtLaunch { at: 34, of: TOP },
];

/// Series and roots, from libm and `kf_core::trigonometry`.
const FUNCTIONS: [Op; 9] = [
    CLIMB,
    Op::Sine,
    THROTTLE,
    Op::Exponential,
    Op::Multiply,
    AIRSPEED,
    Op::Root,
    Op::Logarithm,
    Op::Multiply,
];

/// A formula and the tick's signals.
struct Tick {
    evaluation: Evaluation,
    frame: Frame,
    tick: u32,
    value: f32,
}

impl Call for Tick {
    fn call(&mut self) {
        self.value = black_box(&mut self.evaluation).step(&self.frame).unwrap_or(f32::NAN);
    }
}

/// A compiled effect of the catalogue.
struct Compiled {
    tracker: SignalTracker,
    regressor: Regressor,
    tick: u32,
    value: f32,
}

impl Call for Compiled {
    fn call(&mut self) {
        self.value = black_box(&self.tracker).regressor_m(black_box(self.regressor)).unwrap_or(f32::NAN);
    }
}

fn compiled(counter: &Counter, name: &'static str, effect: EffectId) -> Outcome {
    let tracker = SignalTracker::for_effects([effect], 0.0);
    let mut tick = Compiled { tracker, regressor: Regressor::new(effect), tick: 0, value: 0.0 };
    let ready = |tick: &mut Compiled| {
        tick.tick += 1;
        let signals =
            Signals { true_airspeed_mps: Some(40.0 + (tick.tick % 13) as f32), ..Signals::default() };
        let input = TickInput { time_us: u64::from(tick.tick) * TICK_US, signals, ..TickInput::default() };
        tick.tracker.take(&input, None);
    };
    let count = counter.count(TICKS, &mut tick, ready);
    Outcome { role: Role::Ours, name, count, state: [tick.value, 0.0, 0.0, 0.0], variances: [0.0; 4] }
}

/// One row for each kind of operation, and one effect in both forms; `None` if a program is invalid.
pub fn outcomes(counter: &Counter) -> Option<[Outcome; 6]> {
    Some([
        compiled(counter, "compiled baro.dynamic_pressure", EffectId::BaroDynamicPressure),
        outcome(counter, "formula baro.dynamic_pressure", &DYNAMIC_PRESSURE)?,
        outcome(counter, "formula effect of 9 operations", &HEAD)?,
        outcome(counter, "formula arithmetic of 24 operations", &ARITHMETIC)?,
        outcome(counter, "formula memory of 17 operations", &MEMORY)?,
        outcome(counter, "formula functions of 9 operations", &FUNCTIONS)?,
    ])
}

fn outcome(counter: &Counter, name: &'static str, ops: &[Op]) -> Option<Outcome> {
    let mask = Signal::Airspeed.bit() | Signal::ClimbRate.bit();
    let program = Program::new(ops, &[mask])?;
    let mut tick =
        Tick { evaluation: Evaluation::new(&program, 0.0), frame: Frame::default(), tick: 0, value: 0.0 };
    let ready = |tick: &mut Tick| {
        let k = tick.tick;
        tick.tick += 1;
        let launched = k >= TICKS / 2;
        tick.frame.end();
        tick.frame.begin(SECONDS, launched, k == 10);
        tick.frame.set(Signal::Launch.place(), if launched { 1.0 } else { 0.0 });
        tick.frame.set(Signal::Airspeed.place(), 40.0 + (k % 13) as f32);
        tick.frame.set(Signal::Throttle.place(), 0.3 + 0.01 * (k % 50) as f32);
        tick.frame.set(Signal::ClimbRate.place(), 2.0 - (k % 7) as f32);
    };
    let count: Count = counter.count(TICKS, &mut tick, ready);
    Some(Outcome { role: Role::Ours, name, count, state: [tick.value, 0.0, 0.0, 0.0], variances: [0.0; 4] })
}
