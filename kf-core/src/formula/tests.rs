//! Functions with memory: their values, how they wait for input, and what must never enter their memory.

use proptest::prelude::*;

use super::*;
use crate::effect::SignalTracker;
use crate::input::{BaroReading, GpsFix, ImuSample, Signals, TickInput};

/// A program of one operation on the throttle, or on the throttle and a number.
fn of(op: impl Fn(u8, u8) -> Op, second: Option<f32>) -> Evaluation {
    let mut ops = vec![Op::Signal(Signal::Throttle.place())];
    ops.extend(second.map(Op::Constant));
    ops.push(op(0, 0));
    Evaluation::new(&Program::new(&ops, &[Signal::Throttle.bit()]).unwrap(), 1.0)
}

/// Runs it over ticks of a tenth of a second, with the launch at tick `launch`.
fn run(evaluation: &mut Evaluation, launch: usize, values: &[Option<f32>]) -> Vec<Result<f32, Silent>> {
    let mut frame = Frame::default();
    let ticks = values.iter().enumerate();
    ticks
        .map(|(k, value)| {
            frame.begin(if k == 0 { 0.0 } else { 0.1 }, k >= launch, false);
            if let Some(value) = value {
                frame.set(Signal::Throttle.place(), *value);
            }
            evaluation.step(&frame)
        })
        .collect()
}

fn close(got: Result<f32, Silent>, expected: f32) -> bool {
    got.is_ok_and(|got| (got - expected).abs() < 1e-5 * expected.abs().max(1.0))
}

#[test]
fn integrals_begin_at_launch() {
    let ramp: Vec<_> = (0..31_u8).map(|k| Some(f32::from(k) * 0.1)).collect();
    // From 1 s to 3 s of t: (9 - 1)/2; and of t - 1 integrated twice from there: t^3/6 - t/2 + 1/3 at 3.
    assert!(close(run(&mut of(|at, _| Op::Integral { at, of: TOP }, None), 10, &ramp)[30], 4.0));
    assert!(close(
        run(&mut of(|at, _| Op::DoubleIntegral { at, of: TOP }, None), 10, &ramp)[30],
        27.0 / 6.0 - 1.5 + 1.0 / 3.0
    ));
    let values = run(&mut of(|at, _| Op::Integral { at, of: TOP }, None), 10, &ramp);
    assert!(values[..=10].iter().all(|value| *value == Ok(0.0)));
}

#[test]
fn an_hour_of_integral_loses_nothing() {
    let mut evaluation = of(|at, _| Op::Integral { at, of: TOP }, None);
    let mut frame = Frame::default();
    frame.set(Signal::Throttle.place(), 0.1);
    let mut last = Ok(0.0);
    for k in 0..=720_000 {
        frame.begin(if k == 0 { 0.0 } else { 0.005 }, true, false);
        last = evaluation.step(&frame);
    }
    // Without compensation f32 is 1 % off by then.
    assert!((last.unwrap() / 360.0 - 1.0).abs() < 3e-7, "{last:?}");
}

#[test]
fn a_rate_is_from_sample_to_sample() {
    let mut values = vec![None; 20];
    (values[0], values[5], values[10]) = (Some(1.0), Some(2.0), Some(1.0));
    let rates = run(&mut of(|at, mask| Op::Rate { at, mask, of: TOP }, None), 99, &values);
    assert!(rates[..5].iter().all(|rate| *rate == Err(Silent::NotYet)));
    assert!(rates[5..10].iter().all(|rate| close(*rate, 2.0)), "{rates:?}");
    assert!(rates[10..].iter().all(|rate| close(*rate, -2.0)));
}

#[test]
fn a_low_pass_follows_a_step_as_a_first_order_lag_does() {
    let values: Vec<_> = (0..400).map(|k| Some(if k == 0 { 0.0 } else { 1.0 })).collect();
    let filtered = run(&mut of(|at, _| Op::LowPass { at }, Some(5.0)), 99, &values);
    // Backward Euler with steps of a fiftieth of the time constant.
    let expected = 1.0 - (1.0_f32 / (1.0 + 0.1 / 5.0)).powi(50);
    assert!(close(filtered[50], expected), "{:?} {expected}", filtered[50]);
    assert!((expected - (1.0 - (-1.0_f32).exp())).abs() < 0.01);
}

#[test]
fn a_delay_is_one_for_straight_lines() {
    let ramp: Vec<_> = (0..300_u16).map(|k| Some(f32::from(k) * 0.1)).collect();
    for delay_s in [0.05_f32, 0.4, 1.0, 3.3, 20.0] {
        let delayed = run(&mut of(|at, _| Op::Delay { at }, Some(delay_s)), 99, &ramp);
        let first = delayed.iter().position(Result::is_ok).unwrap();
        assert!((first as f32 * 0.1 - delay_s).abs() < 0.1 + delay_s / 16.0, "{delay_s}: {first}");
        for (k, value) in delayed.iter().enumerate().skip(first) {
            let expected = k as f32 * 0.1 - delay_s;
            assert!((value.unwrap() - expected).abs() < 2e-4, "{delay_s} at {k}: {value:?} {expected}");
        }
    }
}

#[test]
fn a_delay_crosses_a_gap_of_any_length() {
    let mut evaluation = of(|at, _| Op::Delay { at }, Some(2.0));
    let mut frame = Frame::default();
    for (k, seconds) in [0.0, 0.1, 1.0, 0.1, 30.0, 0.5, 1e6, 0.1].into_iter().enumerate() {
        frame.begin(seconds, false, false);
        frame.set(Signal::Throttle.place(), 3.0);
        let value = evaluation.step(&frame);
        assert!(if k < 4 { value == Err(Silent::NotYet) } else { close(value, 3.0) }, "{k}: {value:?}");
    }
}

#[test]
fn what_is_kept_of_captive_flight_stays_after_launch() {
    let values: Vec<_> = (0..20_u8).map(|k| Some(f32::from(k))).collect();
    let means = run(&mut of(|at, mask| Op::Captive { at, mask, of: TOP }, None), 10, &values);
    assert!(close(means[9], 4.5) && means[10..].iter().all(|mean| close(*mean, 4.5)), "{means:?}");
    let latched = run(&mut of(|at, _| Op::AtLaunch { at, of: TOP }, None), 10, &values);
    assert!(close(latched[4], 4.0) && latched[10..].iter().all(|value| close(*value, 9.0)), "{latched:?}");
    // The calibration begins at the fifth tick: earlier samples do not count.
    let mut evaluations = [
        of(|at, mask| Op::Captive { at, mask, of: TOP }, None),
        of(|at, mask| Op::AtCalibration { at, mask, of: TOP }, None),
    ];
    let mut frame = Frame::default();
    for k in 0..10_u8 {
        frame.begin(0.1, false, k == 5);
        frame.set(Signal::Throttle.place(), f32::from(k));
        let [mean, first] = evaluations.each_mut().map(|evaluation| evaluation.step(&frame));
        assert!(close(first, if k < 5 { 0.0 } else { 5.0 }), "{k}: {first:?}");
        assert!(
            close(mean, if k < 5 { f32::from(k) / 2.0 } else { f32::from(5 + k) / 2.0 }),
            "{k}: {mean:?}"
        );
    }
}

#[test]
fn what_is_no_number_waits_and_is_made_up_for() {
    // 1/throttle over twenty ticks, at seven of which the throttle is 0: nothing is known there, and a
    // straight line bridges them.
    let ops = [
        Op::Constant(1.0),
        Op::Signal(Signal::Throttle.place()),
        Op::Divide,
        Op::Integral { at: 0, of: TOP },
    ];
    let mut evaluation = Evaluation::new(&Program::new(&ops, &[]).unwrap(), 1.0);
    let values: Vec<_> = (0..21).map(|k| Some(if (5..12).contains(&k) { 0.0 } else { 0.5 })).collect();
    let integrals = run(&mut evaluation, 0, &values);
    assert!(integrals[5..12].iter().all(|value| *value == Err(Silent::DivisionByZero)));
    assert!(close(integrals[20], 4.0), "{:?}", integrals[20]);
    assert!(evaluation.state().iter().all(|word| word.is_finite()));
}

#[test]
fn a_program_that_could_not_run_is_none() {
    let throttle = Op::Signal(Signal::Throttle.place());
    assert!(Program::new(&[], &[]).is_none());
    assert!(Program::new(&[Op::Add], &[]).is_none());
    assert!(Program::new(&[throttle, throttle], &[]).is_none());
    assert!(Program::new(&[Op::Signal(200)], &[]).is_none());
    assert!(Program::new(&[throttle, Op::Integral { at: 3, of: TOP }], &[]).is_none());
    assert!(Program::new(&[throttle, Op::Rate { at: 0, mask: 0, of: TOP }], &[]).is_none());
    assert!(Program::new(&[throttle; MAX_OPS + 1], &[]).is_none());
    assert!(Program::new(&[throttle; MAX_DEPTH + 1], &[]).is_none());
    // A stack of the full depth, and the operations that empty it.
    let mut deep = vec![throttle; MAX_DEPTH];
    deep.extend([Op::Add; MAX_DEPTH - 1]);
    let mut evaluation = Evaluation::new(&Program::new(&deep, &[]).unwrap(), 1.0);
    assert!(close(run(&mut evaluation, 99, &[Some(0.5)])[0], 8.0));
}

proptest! {
    #[test]
    fn a_root_is_within_a_rounding(x in prop_oneof![0.0_f32..1e-30, 1e-30_f32..1e30, Just(f32::MAX), Just(0.0)]) {
        let got = run(&mut of(|_, _| Op::Root, None), 99, &[Some(x)])[0].unwrap();
        let exact = f64::from(x).sqrt();
        prop_assert!((f64::from(got) - exact).abs() <= 1.2e-7 * exact + 1.1e-19, "{x}: {got} {exact}");
    }
}

#[test]
fn joined_operations_are_the_two_they_are_made_of() {
    let (throttle, roll) = (Signal::Throttle.place(), Signal::Roll.place());
    let constants = [Op::Add, Op::Subtract, Op::Multiply, Op::Divide, Op::Min, Op::Max];
    let signals = [Op::Add, Op::Subtract, Op::Multiply, Op::Divide];
    let numbers = [0.0, -0.0, 0.1, -3.7, 2.0e19, 3.0e38];
    let leaves = numbers
        .iter()
        .flat_map(|number| constants.map(|op| (Op::Constant(*number), op)))
        .chain(signals.map(|op| (Op::Signal(roll), op)));
    for (leaf, op) in leaves {
        let joined = Program::new(&[Op::Signal(throttle), leaf, op], &[]).unwrap();
        // Two negations change no bit, but keep the two operations from being joined.
        let apart = Program::new(&[Op::Signal(throttle), leaf, Op::Negate, Op::Negate, op], &[]).unwrap();
        assert_eq!((joined.ops().len(), apart.ops().len()), (2, 5), "{joined:?}");
        assert_eq!(joined.signals(), apart.signals());
        for first in numbers.map(Some).into_iter().chain([None]) {
            for second in numbers.map(Some).into_iter().chain([None]) {
                let mut frame = Frame::default();
                first.into_iter().for_each(|value| frame.set(throttle, value));
                second.into_iter().for_each(|value| frame.set(roll, value));
                let [joined, apart] = [joined, apart]
                    .map(|program| Evaluation::new(&program, 1.0).step(&frame).map(f32::to_bits));
                assert_eq!(joined, apart, "{leaf:?} {op:?} of {first:?}, {second:?}");
            }
        }
        let again = Program::new(joined.ops(), &[]).unwrap();
        assert_eq!(again, joined, "an operation that is joined already is one");
    }
}

#[test]
fn a_memory_with_a_constant_is_the_two_operations_that_it_is_made_of() {
    let memories = [Op::LowPass { at: 0 }, Op::Delay { at: 0 }];
    // Values: invalid numbers, a step, numbers so large that their difference overflows; and time constants
    // that are not positive.
    let values: Vec<_> = (0..200_u8)
        .map(|k| match k {
            50..60 => Some(0.0),
            60 => Some(3e38),
            61 => Some(-3e38),
            _ => Some(f32::from(k % 9) - 4.0),
        })
        .collect();
    let over = [Op::Constant(1.0), Op::Signal(Signal::Throttle.place()), Op::Divide];
    for (op, seconds) in memories.into_iter().flat_map(|op| [0.7, 3.0, 0.0, -1.0].map(|s| (op, s))) {
        let of = |between: &[Op]| {
            let ops = [&over, &[Op::Constant(seconds)][..], between, &[op]].concat();
            Evaluation::new(&Program::new(&ops, &[]).unwrap(), 1.0)
        };
        let (mut joined, mut apart) = (of(&[]), of(&[Op::Negate, Op::Negate]));
        // A low pass without a valid constant stays two operations, which report why it is silent.
        let are_joined = seconds > 0.0 || op == Op::Delay { at: 0 };
        assert_eq!(joined.program().ops().len() + 2 + usize::from(are_joined), apart.program().ops().len());
        let [together, parted] = [&mut joined, &mut apart].map(|evaluation| run(evaluation, 99, &values));
        assert_eq!(together, parted, "{op:?} {seconds}");
        assert_eq!(joined.state().map(f32::to_bits), apart.state().map(f32::to_bits));
    }
}

/// Ticks of a flight with every case that a memory must distinguish: a launch, a calibration that begins
/// (twice), no new sample, no number.
fn ticks() -> impl Strategy<Value = Vec<(Option<Option<f32>>, bool)>> {
    let value = prop_oneof![8 => (-50.0_f32..50.0).prop_map(Some), 1 => Just(None), 1 => Just(Some(3e38))];
    let tick = (prop_oneof![3 => value.prop_map(Some), 1 => Just(None)], proptest::bool::weighted(0.05));
    proptest::collection::vec(tick, 1..300)
}

proptest! {
    #[test]
    fn a_memory_of_a_signal_is_the_two_operations_that_it_is_made_of(ticks in ticks(), launch in 0..200_usize) {
        let place = Signal::Throttle.place();
        for op in [
            &[Op::Rate { at: 0, mask: 0, of: TOP }][..],
            &[Op::Integral { at: 0, of: TOP }],
            &[Op::DoubleIntegral { at: 0, of: TOP }],
            &[Op::Captive { at: 0, mask: 0, of: TOP }],
            &[Op::AtCalibration { at: 0, mask: 0, of: TOP }],
            &[Op::AtLaunch { at: 0, of: TOP }],
            &[Op::Constant(0.7), Op::LowPass { at: 0 }],
            &[Op::Constant(0.7), Op::Delay { at: 0 }],
        ] {
            // After a value that must still be on the stack.
            let of = |between: &[Op]| {
                let ops = [&[Op::Constant(2.0), Op::Signal(place)][..], between, op, &[Op::Subtract]].concat();
                Evaluation::new(&Program::new(&ops, &[Signal::Throttle.bit()]).unwrap(), 1.0)
            };
            let (mut joined, mut apart) = (of(&[]), of(&[Op::Negate, Op::Negate]));
            prop_assert_eq!((joined.program().ops().len(), apart.program().ops().len()), (3, 6));
            prop_assert_eq!(&Program::new(joined.program().ops(), &[Signal::Throttle.bit()]).unwrap(), joined.program());
            let mut frame = Frame::default();
            for (k, (value, begins)) in ticks.iter().enumerate() {
                frame.begin(if k == 0 { 0.0 } else { 0.05 }, k >= launch, *begins);
                match value {
                    Some(Some(value)) => frame.set(place, *value),
                    // A signal never returns to "not seen" in flight; only a newly made frame has that state.
                    Some(None) => {
                        frame = Frame::default();
                        frame.begin(0.05, k >= launch, *begins);
                    }
                    None => {}
                }
                prop_assert_eq!(joined.step(&frame).map(f32::to_bits), apart.step(&frame).map(f32::to_bits), "{:?}", op);
            }
            prop_assert_eq!(joined.state().map(f32::to_bits), apart.state().map(f32::to_bits), "{:?}", op);
        }
    }
}

/// A tick with every input, and what a frame takes from it for one signal: its value, and the signals that
/// are new in addition to those that always are.
fn taken(signal: Signal, gyro_radps: [f32; 3]) -> (Option<f32>, u64) {
    let input = TickInput {
        time_us: 5_000,
        gps: Some(GpsFix {
            altitude_m: 1_000.0,
            velocity_north_mps: Some(30.0),
            velocity_east_mps: Some(2.0),
            velocity_down_mps: Some(-1.0),
            vertical_accuracy_m: Some(1.5),
            satellites: Some(9),
            ..GpsFix::default()
        }),
        baro: Some(BaroReading::PressurePa(90_000.0)),
        imu_master_altitude_m: Some(1_001.0),
        imu_slave_altitude_m: Some(999.0),
        imu: Some(ImuSample { accel_mps2: [0.1, 0.2, -9.8], gyro_radps }),
        signals: Signals {
            true_airspeed_mps: Some(31.0),
            angle_of_attack_rad: Some(0.05),
            sideslip_rad: Some(0.01),
            throttle: Some(0.6),
            outside_air_temperature_c: Some(8.0),
            baro_temperature_c: Some(20.0),
            attitude_rad: Some([0.1, 0.05, 1.0]),
        },
        ..TickInput::default()
    };
    let (mut tracker, mut frame) = (SignalTracker::default(), Frame::default());
    // The second tick also has differences.
    for time_us in [0, 5_000] {
        let input = TickInput { time_us, ..input };
        tracker.take(&input, input.gps.as_ref());
        frame.take(signal.bit(), &input, input.gps.as_ref(), &tracker);
    }
    let always = Signal::Time.bit() | Signal::TimeOn.bit() | Signal::Launch.bit();
    (frame.value(signal.place()), frame.new & !always)
}

/// A power of a negative number has no value; a power of a large number overflows.
#[test]
fn a_power_without_a_value_says_why() {
    let at = |value| run(&mut of(|_, _| Op::RealPower(40.5), None), 0, &[Some(value)])[0];
    assert_eq!(at(-1.0), Err(Silent::NoRoot));
    assert_eq!(at(10.0), Err(Silent::Overflow));
    assert!(close(at(1.0), 1.0));
}

#[test]
fn a_frame_takes_the_signal_that_is_used_and_no_other() {
    for signal in Signal::ALL {
        let (value, new) = taken(*signal, [0.01, 0.02, 0.03]);
        assert!(value.is_some(), "{}", signal.name());
        let is_always_new = matches!(signal, Signal::Time | Signal::TimeOn | Signal::Launch);
        assert_eq!(new, if is_always_new { 0 } else { signal.bit() }, "{}", signal.name());
    }
    assert_eq!(taken(Signal::GyroZ, [0.01, 0.02, 0.03]).0, Some(0.03));
    assert_eq!(taken(Signal::ImuSlave, [0.01, 0.02, 0.03]).0, Some(999.0));
    assert_eq!(taken(Signal::Altitude, [0.01, 0.02, 0.03]).0, Some(1_000.0), "that of the tick's own fix");
}

/// No vehicle of this class turns at a hundred radians a second: nothing is taken from such a sample, not
/// even its forces.
#[test]
fn a_frame_takes_no_inertial_signal_of_a_sample_that_can_not_be() {
    for signal in [Signal::AccelX, Signal::GyroY, Signal::LoadFactor, Signal::AccelerationVariance] {
        assert_eq!(taken(signal, [100.0, 0.0, 0.0]), (None, 0), "{}", signal.name());
    }
}

/// For two independent samples, half the squared difference is on average their variance; what they have in
/// common is not vibration.
#[test]
fn the_forces_variance_is_of_its_change() {
    let used = Signal::AccelerationVariance;
    let (mut tracker, mut frame) = (SignalTracker::default(), Frame::default());
    for (time_us, accel_mps2) in [(0, [0.1, 0.2, -9.8]), (5_000, [1.1, -1.8, -7.8])] {
        let imu = Some(ImuSample { accel_mps2, gyro_radps: [0.0; 3] });
        let input = TickInput { time_us, imu, ..TickInput::default() };
        tracker.take(&input, None);
        frame.take(used.bit(), &input, None, &tracker);
    }
    // (1^2 + 2^2 + 2^2) / 2
    assert!((frame.value(used.place()).unwrap() - 4.5).abs() < 1e-5);
}
