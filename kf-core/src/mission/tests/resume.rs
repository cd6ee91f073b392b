//! Missions that are interrupted and continue.

use super::*;
use crate::config::MAX_ESTIMATED_EFFECTS;
use crate::effect::{Definition, Parts, formula_words};
use crate::formula::{Op, Program, Signal, TOP};
use crate::input::ImuSample;
use crate::output::{Agreement, Trust};
use crate::snapshot::{MAX_SNAPSHOT_BYTES, MissionMark, RaisedFlags, SnapshotError};

/// The interruption: between launch at tick 6,000 and the end at 8,000.
const CUT: u64 = 7_000;

/// With every input that the effects need, and a dive after launch.
fn ticks() -> Vec<TickInput> {
    let mut flight = Flight { seed: 7, noise: 1.0 };
    (0..8_000)
        .map(|k| {
            let mut input = flight.tick(k);
            let swing = (k as f32 * 0.003).sin();
            input.imu = Some(ImuSample {
                accel_mps2: [0.5 * swing, 0.0, -9.8 + swing],
                gyro_radps: [0.0, 0.01 * swing, 0.0],
            });
            input.signals.attitude_rad = k.is_multiple_of(4).then_some([0.1 * swing, 0.05 * swing, 0.0]);
            input.signals.throttle = Some(0.5 + 0.1 * swing);
            input.signals.baro_temperature_c = k.is_multiple_of(100).then_some(25.0 + swing);
            input
        })
        .collect()
}

/// A snapshot's bytes and the mark of the same tick.
#[derive(Clone)]
struct Kept {
    bytes: Vec<u8>,
    mark: MissionMark,
}

fn kept<const H: usize, const T: usize, const E: usize>(mission: &Mission<H, T, E>) -> Kept {
    let mut bytes = [0; MAX_SNAPSHOT_BYTES];
    let length = mission.snapshot().unwrap().to_bytes(&mut bytes).unwrap();
    Kept {
        bytes: bytes[..length].to_vec(),
        mark: MissionMark { flags: RaisedFlags::default(), ..mission.mark() },
    }
}

/// A mission that continues from it, with the flags of a later mark.
fn resumed<const H: usize, const T: usize, const E: usize>(
    config: &MissionConfig<E>,
    kept: &Kept,
    flags: RaisedFlags,
) -> Result<Mission<H, T, E>, SnapshotError> {
    let mut mission = Mission::new(config).unwrap();
    mission.restore_snapshot(&kept.bytes, &MissionMark { flags, ..kept.mark })?;
    Ok(mission)
}

/// Flies to the cut, restarts from a snapshot, and compares every later output with that of a mission without
/// an interruption.
fn goes_on_to_the_bit<const H: usize, const T: usize, const E: usize>(config: &MissionConfig<E>) {
    let ticks = ticks();
    let mut whole = Mission::<H, T, E>::new(config).unwrap();
    for input in &ticks[..CUT as usize] {
        whole.tick(input);
    }
    let snapshot = kept(&whole);
    assert_eq!(whole.snapshot().unwrap().time_us(), (CUT - 1) * TICK_US);
    let mut resumed = resumed::<H, T, E>(config, &snapshot, RaisedFlags::default()).unwrap();
    assert_eq!(resumed.latch(), whole.latch());
    for (k, input) in ticks.iter().enumerate().skip(CUT as usize) {
        let expected = whole.tick(input);
        let mut got = resumed.tick(input);
        assert_eq!(got.bridged_us.take(), (k == CUT as usize).then_some(TICK_US), "tick {k}");
        // As bits: the wire form, in which NaNs and signs of zero count.
        let bytes = |output: &TickOutput| {
            let mut buffer = [0; 640];
            postcard::to_slice(output, &mut buffer).unwrap().to_vec()
        };
        assert_eq!(bytes(&got), bytes(&expected), "tick {k}");
    }
    let counters = Counters { restarts: 1, ..*whole.counters() };
    assert_eq!(*resumed.counters(), counters);
}

fn with_effects(mut config: MissionConfig<4>) -> MissionConfig<4> {
    config.estimated_effects = [
        EffectTerm::new(EffectId::BaroDynamicPressure, 0.0, 0.2),
        EffectTerm::new(EffectId::GpsLeverArm, 0.0, 1.0),
        EffectTerm::new(EffectId::ImuVibration, 0.0, 0.1),
        EffectTerm::new(EffectId::BaroLag, 0.0, 0.1),
    ];
    for id in [
        EffectId::ImuTilt,
        EffectId::ImuGyroBias,
        EffectId::ImuAccelScale,
        EffectId::ImuEotvos,
        EffectId::ImuGravityGradient,
        EffectId::BaroWarmUp,
        EffectId::BaroCarrierField,
        EffectId::BaroTemperature,
    ] {
        config.constant_effects.push(EffectTerm::new(id, 0.01, 0.01)).unwrap();
    }
    config
}

/// One of integrals, and one of a low pass and a value stored at launch, over a signal that every tick has:
/// the frame's held values are not stored.
fn with_formulas(mut config: MissionConfig<2>) -> MissionConfig<2> {
    let load = Op::Signal(Signal::LoadFactor.place());
    let second = Op::Constant(1.0);
    let law = |name, ops: &[Op]| EffectTerm::new(formula_of(name, ops), 0.0, 0.1);
    config.estimated_effects = [
        law("a.a", &[load, Op::DoubleIntegral { at: 0, of: TOP }]),
        law(
            "a.b",
            &[load, second, Op::LowPass { at: 0 }, load, Op::AtLaunch { at: 2, of: TOP }, Op::Subtract],
        ),
    ];
    config
}

#[test]
fn a_resumed_mission_says_what_one_without_interruption_says() {
    goes_on_to_the_bit::<3, 1, 0>(&config(false));
    goes_on_to_the_bit::<0, 4, 0>(&config(true));
    goes_on_to_the_bit::<0, 8, 4>(&with_effects(config(true)));
    goes_on_to_the_bit::<0, 6, 2>(&with_formulas(config(true)));
    for second_correction in
        [SecondCorrection::MovingAverage, SecondCorrection::Kalman { wander_m_per_sqrt_s: 0.3 }]
    {
        goes_on_to_the_bit::<0, 4, 0>(&MissionConfig { second_correction, ..config(true) });
    }
}

#[test]
fn captive_flight_has_no_snapshot() {
    let mut mission = Dense::new(&config(true)).unwrap();
    for input in &ticks()[..5_999] {
        mission.tick(input);
        assert!(mission.snapshot().is_none() && mission.raised_flags() == RaisedFlags::default());
    }
}

/// A barometer that is 50 m off from a tick on.
fn off_from(first: u64) -> impl Fn(u64, &mut TickInput) {
    move |k, input| {
        if let (true, Some(BaroReading::AltitudeM(altitude_m))) = (k >= first, input.baro) {
            input.baro = Some(BaroReading::AltitudeM(altitude_m + 50.0));
        }
    }
}

#[test]
fn flags_raised_before_the_restart_outlive_it_even_if_raised_after_the_snapshot() {
    let config = config(true);
    let mut mission = Dense::new(&config).unwrap();
    let mut snapshot = None;
    for (k, mut input) in ticks().into_iter().enumerate().take(7_400) {
        off_from(6_900)(k as u64, &mut input);
        mission.tick(&input);
        if k == 6_800 {
            snapshot = Some(kept(&mission));
        }
    }
    let flags = mission.raised_flags();
    assert_eq!(flags.of(Sensor::Baro), Some(Trust::Untrustworthy));
    assert_eq!((flags.of(Sensor::ImuSlave), flags.of_cross_check()), (None, None));
    let after_restart = |flags| {
        let mut mission: Dense = resumed(&config, snapshot.as_ref().unwrap(), flags).unwrap();
        // Healthy again: only the flag still shows that there was an error.
        mission.tick(&ticks()[7_440]).sensors.map(|sensor| sensor.trust)
    };
    let kept = RaisedFlags::from_bits(flags.bits());
    assert_eq!(after_restart(kept), [Trust::Unmonitored, Trust::Trusted, Trust::Untrustworthy]);
    assert_eq!(after_restart(RaisedFlags::default()), [Trust::Unmonitored, Trust::Trusted, Trust::Trusted]);
}

/// The inertial sensor's last error and trust with an effect on it, after a gap of `gap` ticks.
fn after_a_gap(gap: usize) -> (Option<f32>, Trust, Option<u64>, u32) {
    let mut config = config(true);
    config.constant_effects.push(EffectTerm::new(EffectId::ImuAccelScale, 0.05, 0.01)).unwrap();
    let ticks = ticks();
    let mut mission = Dense::new(&config).unwrap();
    ticks[..=6_200].iter().for_each(|input| {
        mission.tick(input);
    });
    let mut mission: Dense = resumed(&config, &kept(&mission), RaisedFlags::default()).unwrap();
    let mut last = (None, Trust::Calibrating, None, 0);
    for input in &ticks[6_200 + gap..] {
        let output = mission.tick(input);
        last.0 = output.sensors[1].moving_average_m.or(last.0);
        last.1 = output.sensors[1].trust;
        last.2 = last.2.or(output.bridged_us);
    }
    (last.0, last.1, last.2, mission.counters().effects_without_signal)
}

#[test]
fn a_short_gap_is_crossed_and_said_and_a_long_one_ends_what_is_integrated() {
    let (whole_m, trust, bridged_us, _) = after_a_gap(1);
    assert_eq!((trust, bridged_us), (Trust::Trusted, Some(5_000)));
    let (crossed_m, trust, bridged_us, missing) = after_a_gap(20);
    assert_eq!((trust, bridged_us, missing), (Trust::Trusted, Some(100_000), 0));
    // 0.1 s of an acceleration that turns by 0.06 rad: a straight line is off by less than 1 % of 1 m/s^2
    // times 0.1 s, for 9 s, times 0.05.
    assert!((crossed_m.unwrap() - whole_m.unwrap()).abs() < 0.01 * 0.1 * 9.0 * 0.05 + 1e-3);
    let (ended_m, trust, bridged_us, missing) = after_a_gap(500);
    assert_eq!((ended_m, trust, bridged_us), (None, Trust::Unmonitored, Some(2_500_000)));
    assert_eq!(missing, 325, "every reading without its effect is counted");
}

#[test]
fn a_long_gap_takes_no_flag_back_and_stops_no_sensor_without_such_an_effect() {
    let mut config = config(true);
    config.constant_effects.push(EffectTerm::new(EffectId::ImuAccelScale, 0.05, 0.01)).unwrap();
    let ticks = ticks();
    let mut mission = Dense::new(&config).unwrap();
    ticks[..=6_200].iter().for_each(|input| {
        mission.tick(input);
    });
    let flags = RaisedFlags::default().with_sensor(Sensor::ImuSlave, Some(Trust::Doubtful));
    let mut mission: Dense = resumed(&config, &kept(&mission), flags).unwrap();
    for input in &ticks[6_800..] {
        let trust = mission.tick(input).sensors.map(|sensor| sensor.trust);
        assert_eq!(trust[1..], [Trust::Doubtful, Trust::Trusted]);
    }
    // The next restart keeps it.
    let mut again: Dense = resumed(&config, &kept(&mission), RaisedFlags::default()).unwrap();
    let output = again.tick(&TickInput { time_us: 8_000 * TICK_US, ..ticks[7_996] });
    assert_eq!(output.sensors[1].trust, Trust::Doubtful);
    assert_eq!((output.sensors[1].moving_average_m, again.counters().restarts), (None, 2));
}

#[test]
fn a_long_gap_ends_a_formula_with_an_integral_and_no_other() {
    let config = with_formulas(config(true));
    let ticks = ticks();
    for (first, has_integral) in [(6_210, true), (6_800, false)] {
        let mut mission = Mission::<0, 6, 2>::new(&config).unwrap();
        ticks[..=6_200].iter().for_each(|input| {
            mission.tick(input);
        });
        let mut mission = resumed::<0, 6, 2>(&config, &kept(&mission), RaisedFlags::default()).unwrap();
        for input in &ticks[first..first + 400] {
            mission.tick(input);
        }
        let values_m = [0, 1].map(|effect| mission.formulas.estimated_m(effect).is_some());
        assert_eq!(values_m, [has_integral, true], "from tick {first} on");
    }
}

#[test]
fn a_clock_that_did_not_go_on_is_said_at_every_tick() {
    let config = config(true);
    let mut mission = Dense::new(&config).unwrap();
    ticks()[..7_000].iter().for_each(|input| {
        mission.tick(input);
    });
    let mut mission: Dense = resumed(&config, &kept(&mission), RaisedFlags::default()).unwrap();
    let output = mission.tick(&TickInput { time_us: TICK_US, launch: true, ..TickInput::default() });
    assert!(output.out_of_order && output.bridged_us.is_none());
}

#[test]
fn a_snapshot_of_another_mission_is_refused() {
    let mut mission = Dense::new(&config(true)).unwrap();
    ticks()[..7_000].iter().for_each(|input| {
        mission.tick(input);
    });
    let kept = kept(&mission);
    let refused = |other: &MissionConfig<0>| {
        let mut fresh = Dense::new(other).unwrap();
        let restored = fresh.restore_snapshot(&kept.bytes, &kept.mark);
        assert_eq!(fresh.snapshot().is_some(), restored.is_ok());
        restored.err()
    };
    let other_mission = Some(SnapshotError::OtherMission);
    assert_eq!(refused(&config(true)), None);
    let second_correction = SecondCorrection::MovingAverage;
    assert_eq!(refused(&MissionConfig { second_correction, ..config(true) }), other_mission);
    let mut with_effect = config(true);
    with_effect.constant_effects.push(EffectTerm::new(EffectId::BaroLag, 0.1, 0.1)).unwrap();
    assert_eq!(refused(&with_effect), other_mission);
    assert_eq!(resumed::<0, 5, 1>(&config(true), &kept, RaisedFlags::default()).err(), other_mission);
}

#[test]
fn bytes_that_are_no_snapshot_are_refused() {
    let mut mission = Dense::new(&config(true)).unwrap();
    ticks()[..7_000].iter().for_each(|input| {
        mission.tick(input);
    });
    let mut bytes = [0; MAX_SNAPSHOT_BYTES];
    let length = mission.snapshot().unwrap().to_bytes(&mut bytes).unwrap();
    let mark = mission.mark();
    let refused = |bytes: &[u8]| {
        let mut fresh = Dense::new(&config(true)).unwrap();
        let refused = fresh.restore_snapshot(bytes, &mark).err();
        assert_eq!(fresh.snapshot().is_some(), refused.is_none());
        refused
    };
    assert_eq!(refused(&bytes[..length]), None);
    for cut in 1..length {
        assert_eq!(refused(&bytes[..cut]), Some(SnapshotError::Format), "{cut} of {length} bytes");
    }
    assert_eq!(refused(&bytes[..=length]), Some(SnapshotError::Format));
    assert_eq!(refused(&[]), Some(SnapshotError::Format));
    bytes[0] ^= 0x40;
    assert_eq!(refused(&bytes[..length]), Some(SnapshotError::Version));
    let mut short = [0; 100];
    assert_eq!(mission.snapshot().unwrap().to_bytes(&mut short), Err(SnapshotError::BufferTooShort));
}

#[test]
fn the_largest_snapshot_fits() {
    largest_snapshot_fits::<12, MAX_ESTIMATED_EFFECTS, false>();
}

/// With formulas that have the largest memory allowed.
#[test]
fn the_largest_snapshot_with_formulas_fits() {
    largest_snapshot_fits::<8, 4, true>();
    largest_snapshot_fits::<4, 0, true>();
}

/// A formula of `integrals` double integrals.
fn formula(name: &'static str, integrals: usize) -> EffectId {
    let mut ops = vec![Op::Constant(0.01)];
    ops.extend((0..integrals).map(|k| Op::DoubleIntegral { at: 6 * k as u8, of: TOP }));
    formula_of(name, &ops)
}

fn formula_of(name: &'static str, ops: &[Op]) -> EffectId {
    let parts = Parts {
        name,
        subject: EffectSubject::Sensor(Sensor::Baro),
        unit: "1",
        needs: &[],
        plausible: [-1.0, 1.0],
        typical_regressor_m: 1.0,
        program: Program::new(ops, &[]).unwrap(),
        law: "",
        about: "",
        fingerprint: 0,
    };
    EffectId::Defined(Box::leak(Box::new(Definition::new(parts, false))))
}

fn largest_snapshot_fits<const TAIL: usize, const E: usize, const FORMULAS: bool>() {
    let mut largest = config::<E>(true);
    largest.second_correction = SecondCorrection::MovingAverage;
    // A window of which each part's count takes two bytes.
    largest.monitor.window_s = 60.0;
    largest.estimated_effects = [EffectTerm::new(EffectId::BaroDynamicPressure, 0.0, 0.2); E];
    for id in [EffectId::ImuTilt, EffectId::ImuVibration, EffectId::ImuEotvos, EffectId::BaroTemperature] {
        largest.constant_effects.push(EffectTerm::new(id, 0.01, 0.01)).unwrap();
    }
    if FORMULAS {
        let integrals = formula_words(E) / 6;
        for (name, integrals) in [("a.a", integrals / 2), ("a.b", integrals - integrals / 2)] {
            largest.constant_effects.push(EffectTerm::new(formula(name, integrals), 0.01, 0.01)).unwrap();
        }
    }
    let mut mission = Mission::<0, TAIL, E>::new(&largest).unwrap();
    for (k, mut input) in ticks().into_iter().enumerate() {
        // After 25 days; and the reference is lost.
        input.time_us += 1 << 41;
        if k > 7_000 {
            input.gps = None;
        }
        mission.tick(&input);
    }
    // A reading increments one of its source's counters: in a month only one of them can grow to all its
    // bytes.
    const OTHERS: u32 = u32::MAX >> 4;
    let sensor = SourceCounters {
        accepted: u32::MAX,
        not_finite: OTHERS,
        implausible: OTHERS,
        held: OTHERS,
        stuck: OTHERS,
        variance: OTHERS,
        gated: OTHERS,
    };
    // A fix can be held and a sensor stuck, never the other way round.
    let [gps, sensor] = [SourceCounters { stuck: 0, ..sensor }, SourceCounters { held: 0, ..sensor }];
    mission.counters = Counters {
        ticks: u32::MAX,
        out_of_order: u32::MAX,
        gps,
        sensors: [sensor; SENSORS],
        signals_not_finite: u32::MAX,
        effects_without_signal: u32::MAX,
        effects_silent: if FORMULAS { u32::MAX } else { 0 },
        effects_extrapolated: u32::MAX,
        launch_repeats: u32::MAX,
        // Each takes more than a tick: a month has fewer of them than ticks.
        restarts: OTHERS,
        launch_suspicions: OTHERS,
        readings_unjudged: u32::MAX,
    };
    let length = mission.snapshot().unwrap().to_bytes(&mut [0; 4_096]).unwrap();
    // Room for a second byte in the count of each part of the four windows, which longer windows need.
    assert!(length + 4 * 32 <= MAX_SNAPSHOT_BYTES, "{length}");
}

/// A lost reference, and the sensors' check of each other.
#[test]
fn without_a_reference_nothing_is_monitored_and_the_sensors_check_each_other() {
    let run = |change: &dyn Fn(u64, &mut TickInput)| {
        let mut said = Vec::new();
        fly::<0, 4, 0>(
            &config(true),
            |k, input| {
                if (6_400..7_600).contains(&k) {
                    input.gps = None;
                }
                change(k, input);
            },
            |k, output| {
                // The last fix is that of tick 6,360 and is valid for 2 s; the altitude carried forward from
                // it counts against no sensor after 0.64 s.
                let lost = (6_761..7_600).contains(&k);
                let old = (6_489..7_600).contains(&k);
                assert_eq!(old && k % 4 == 0, output.cross_check.is_some(), "tick {k}");
                if lost {
                    assert!(output.sensors.iter().all(|sensor| sensor.trust == Trust::Unmonitored), "{k}");
                    assert!(output.sensors.iter().all(|sensor| sensor.error_m.is_none()), "{k}");
                }
                said.extend(output.cross_check.map(|check| (k, check)));
            },
        )
        .raised_flags()
        .of_cross_check()
        .map(|flag| (flag, said))
    };
    // Two healthy sensors agree: eight sigmas lie between them and the alarm limit.
    assert_eq!(run(&|_, _| {}), None);
    // 50 m off after half of it: at once beyond the alarm limit, and the average half a window later.
    let (flag, said) = run(&off_from(7_000)).unwrap();
    assert_eq!(flag, Trust::Untrustworthy);
    let first = |agreement| said.iter().find(|(_, check)| check.agreement == agreement).unwrap().0;
    assert_eq!((first(Agreement::Agree), first(Agreement::Doubtful)), (6_492, 7_000));
    let bound_m = 4.0 * (2.0 * 5.0_f32).sqrt();
    // A share of bound / 50 of the samples since the loss.
    let expected = 7_000.0 + bound_m / (50.0 - bound_m) * (7_000.0 - 6_764.0);
    assert!((first(Agreement::Disagree) as f32 - expected).abs() < 20.0, "{expected}");
    let (_, last) = said.last().unwrap();
    assert!((last.difference_m - 50.0).abs() < 2.0 * 2.0 * 1.74, "biases are off, whatever the altitude");
}

#[test]
fn the_wrap_of_a_32_bit_microsecond_timer_is_none_of_the_missions() {
    let run = |offset_us: u64| {
        let mut outputs = Vec::new();
        let mut mission = Dense::new(&config(true)).unwrap();
        for mut input in ticks() {
            input.time_us += offset_us;
            let mut output = mission.tick(&input);
            output.time_us -= offset_us;
            outputs.push(output);
        }
        outputs
    };
    let early = run(0);
    // In captive flight, at launch, and in free flight.
    for wrap_at_s in [15, 30, 35] {
        assert!(run((1 << 32) - wrap_at_s * 1_000_000) == early, "{wrap_at_s}");
    }
}

/// A fix is refused in a suspicion that is withdrawn. Captive flight then continues from the same altitude
/// whether or not there was a restart in between, although the new filter has not learned the held
/// coefficient of an effect on the reference.
#[test]
fn a_suspicion_that_comes_to_nothing_leaves_the_same_reference_after_a_restart() {
    let mut config = config::<1>(true);
    config.estimated_effects = [EffectTerm::new(EffectId::GpsLeverArm, 0.0, 10.0)];
    let mut mission = Mission::<0, 5, 1>::new(&config).unwrap();
    let mut flight = Flight { seed: 7, noise: 1.0 };
    for k in 0..5_606 {
        let mut input = flight.tick(k);
        let pitch_rad = 0.3 + 0.3 * (k as f32 * 0.005).sin();
        input.signals.attitude_rad = Some([0.0, pitch_rad, 0.0]);
        if let Some(fix) = &mut input.gps {
            fix.altitude_m += 6.0 * pitch_rad.sin() + if k >= 5_590 { 400.0 } else { 0.0 };
        }
        if k >= 5_590 {
            input.launch_doubt = LaunchDoubt::Suspected;
        }
        mission.tick(&input);
    }
    let refused_us = mission.tracker.last_fix_us();
    let refused_m = mission.tracker.altitude_m(refused_us).unwrap();
    let mut restarted = resumed(&config, &kept(&mission), RaisedFlags::default()).unwrap();
    let next = TickInput { gps: None, ..flight.tick(5_606) };
    let [gone_on_m, restarted_m] = [&mut mission, &mut restarted].map(|mission| {
        mission.tick(&next);
        mission.tracker.altitude_m(refused_us).unwrap()
    });
    assert!((refused_m - gone_on_m - 400.0).abs() < 20.0, "{refused_m} {gone_on_m}");
    assert_eq!(restarted_m, gone_on_m);
}
