use chip_models::flown::ChipFault;
use kf_core::latch::{LatchRecord, SensorLatch};
use kf_core::sensor::SENSORS;
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use survival::{Cause, RestartReport};

use super::super::plan::Plan;
use super::super::run::{Failure, FailureKind};
use super::*;

/// A flight of two hundred seconds without a fault, in which a sensor fails.
fn case(failure: Option<Failure>) -> Case {
    let mut plan = Plan::draw(&mut ChaCha8Rng::seed_from_u64(1), false);
    plan.own_unit = None;
    Case { index: 0, plan, faults: Vec::new(), failure }
}

fn seen(true_error_m: f32) -> Seen {
    Seen {
        trust: [Trust::Trusted; SENSORS],
        fresh: u8::MAX,
        true_error_m: [true_error_m; SENSORS],
        error_m: [None; SENSORS],
        average_m: [None; SENSORS],
        fix_error_m: None,
    }
}

/// Restarts at these ticks, each reported or not.
fn restarted(restarts: &[(usize, bool)]) -> Vec<Invariant> {
    let report = RestartReport {
        start: Start::Resumed,
        cause: Cause::Supply,
        crash: None,
        mark: None,
        snapshot_us: None,
        refused: [None, None],
        resumed_us: 0,
        restarts: 1,
        pause_us: 0,
    };
    let restarts = restarts.iter().map(|(tick, is_reported)| Restarted {
        tick: *tick,
        report: Some(report),
        is_reported: *is_reported,
    });
    let mut faulty = Watched::default();
    faulty.restarts = restarts.collect();
    let verdict = judge(&case(None), &Flown { clean: Watched::default(), faulty });
    verdict.violations.iter().map(|violation| violation.invariant).collect()
}

#[test]
fn a_restart_is_told_by_its_text_or_by_the_number_of_any_within_a_second() {
    assert_eq!(restarted(&[(1_000, true)]), []);
    assert_eq!(restarted(&[(1_000, false)]), [Invariant::RestartReported]);
    assert_eq!(restarted(&[(1_000, false), (1_010, false), (1_048, true)]), []);
    assert_eq!(restarted(&[(1_000, false), (1_201, true)]), [Invariant::RestartReported]);
    assert_eq!(restarted(&[(1_000, true), (1_010, false)]), [Invariant::RestartReported]);
}

fn latched(bound_m2: f32) -> LatchRecord {
    let sensor = SensorLatch {
        bias_m: 0.0,
        bias_variance_m2: 1.0,
        readings: 1_000,
        residual_variance_m2: 1.0,
        mean_variance_m2: 0.0,
        bound_m2,
    };
    LatchRecord {
        time_us: 0,
        duration_s: 60.0,
        failed_checks: 0,
        sensors: [sensor; SENSORS],
        state: heapless::Vec::new(),
        covariance: heapless::Vec::new(),
    }
}

/// A flight in which a sensor's error grows by 2 m/s from a tick on, while the flight computer is away for
/// some time.
fn drifting(from: usize, away: &std::ops::Range<usize>) -> Watched {
    let error_m = |tick: usize| 0.01 * tick.saturating_sub(from) as f32;
    let mut watched = Watched::default();
    watched.ticks = (0..20_000).map(|tick| (!away.contains(&tick)).then(|| seen(error_m(tick)))).collect();
    watched.latch = Some(latched(49.0));
    watched
}

/// The integrated altitude is pushed at tick 12,000.
fn broken(clean: Watched, faulty: Watched) -> Vec<Invariant> {
    let failure = Failure { sensor: Sensor::ImuSlave, kind: FailureKind::Drift, tick: 12_000, sign: 1.0 };
    let verdict = judge(&case(Some(failure)), &Flown { clean, faulty });
    verdict.violations.iter().map(|violation| violation.invariant).collect()
}

fn flagged_at(mut watched: Watched, tick: usize) -> Watched {
    watched.flagged[Sensor::ImuSlave.index()] = Some(Flagged { tick, true_error_m: 9.0 });
    watched
}

/// Flagged at 13,000 in the clean flight and never in the faulty one, where the flight computer is away until
/// a tick.
fn pushed(away_until: usize) -> Vec<Invariant> {
    broken(flagged_at(drifting(12_000, &(0..0)), 13_000), drifting(12_000, &(11_990..away_until)))
}

/// In the faulty flight the altitude leaves 1.4 times its bound of 7 m at tick 14,980. The clean flight flags
/// it earlier, because the receiver is off in the other direction. A flag that early is not required: the
/// average is half a window behind.
#[test]
fn a_slow_drift_is_owed_its_flag_when_the_average_can_have_left_the_bound() {
    let flagged = |tick| {
        broken(flagged_at(drifting(12_000, &(0..0)), 12_500), flagged_at(drifting(14_000, &(0..0)), tick))
    };
    assert_eq!(flagged(14_979 + HALF_WINDOW_TICKS * 3 / 2 + GRACE_TICKS), []);
    assert_eq!(flagged(14_981 + HALF_WINDOW_TICKS * 3 / 2 + GRACE_TICKS), [Invariant::Detection]);
}

/// The altitude's own drift cancels the push at 9 m, which the receiver may hide, or at 11 m, which it may
/// not.
#[test]
fn an_integrated_altitude_that_stays_near_its_bound_is_owed_no_flag() {
    let settled = |limit_m: f32| {
        let mut faulty = drifting(14_000, &(0..0));
        for seen in faulty.ticks.iter_mut().flatten() {
            seen.true_error_m = seen.true_error_m.map(|error_m| error_m.min(limit_m));
        }
        broken(flagged_at(drifting(12_000, &(0..0)), 12_500), faulty)
    };
    assert_eq!(settled(9.0), []);
    assert_eq!(settled(11.0), [Invariant::Detection]);
}

/// A healthy sensor, 3.5 m off, is flagged in the faulty flight only. Its bound is 7 m.
fn flagged_within_its_bound(fix_error_m: f32) -> Vec<Invariant> {
    let mut clean = drifting(20_000, &(0..0));
    for seen in clean.ticks.iter_mut().flatten() {
        seen.fix_error_m = Some(fix_error_m);
    }
    let mut faulty = drifting(20_000, &(0..0));
    faulty.flagged[Sensor::ImuSlave.index()] = Some(Flagged { tick: 15_000, true_error_m: 3.5 });
    let verdict = judge(&case(None), &Flown { clean, faulty });
    verdict.violations.iter().map(|violation| violation.invariant).collect()
}

/// The receiver without the fault shows the sensor 6 m off, or 5 m, or 1 m.
#[test]
fn a_flag_that_a_receiver_without_the_fault_would_raise_blames_nobody_wrongly() {
    assert_eq!(flagged_within_its_bound(-2.5), []);
    assert_eq!(flagged_within_its_bound(-1.5), [Invariant::Blame]);
    assert_eq!(flagged_within_its_bound(2.5), [Invariant::Blame]);
}

/// A receiver that was 6.5 m off during the calibration leaves a bias that is as far off. A sensor that has
/// drifted by 7 m since is flagged; one that has not drifted must not be.
#[test]
fn what_a_sensor_has_drifted_since_the_launch_is_its_own_error() {
    let flagged = |at_launch_m: f32, true_error_m: f32| {
        let mut faulty = drifting(20_000, &(0..0));
        faulty.launched = Some(13_000);
        for seen in faulty.ticks.iter_mut().flatten() {
            seen.true_error_m = [at_launch_m; SENSORS];
        }
        faulty.flagged[Sensor::ImuSlave.index()] = Some(Flagged { tick: 15_000, true_error_m });
        let mut case = case(None);
        case.plan.captive_s = 60.0;
        let verdict = judge(&case, &Flown { clean: drifting(20_000, &(0..0)), faulty });
        verdict.violations.iter().map(|violation| violation.invariant).collect::<Vec<_>>()
    };
    assert_eq!(flagged(-6.5, 0.5), []);
    assert_eq!(flagged(0.5, 0.5), [Invariant::Blame]);
}

/// A transient of the inertial unit turns the level of the integrated altitude, which drifts away for good. A
/// flag before it leaves its bound costs the time until then; the loss is the fault's doing.
#[test]
fn an_early_flag_of_an_altitude_that_a_transient_sends_away_costs_the_time_until_it_is_gone() {
    let flagged = |gone: usize, back: usize, failure: Option<Failure>| {
        let mut faulty = drifting(20_000, &(0..0));
        for (tick, seen) in faulty.ticks.iter_mut().enumerate() {
            let true_error_m = if (gone..back).contains(&tick) { 8.0 } else { 2.0 };
            *seen = seen.take().map(|seen| Seen { true_error_m: [true_error_m; SENSORS], ..seen });
        }
        faulty.flagged[Sensor::ImuSlave.index()] = Some(Flagged { tick: 15_000, true_error_m: 2.0 });
        let mut case = case(failure);
        case.faults.push(Drawn {
            name: "imu: spike",
            place: Place::Imu,
            phase: Phase::LateFree,
            from: 14_000,
            to: 14_100,
            events: Vec::new(),
            dips: Vec::new(),
            step_us: 0,
        });
        let verdict = judge(&case, &Flown { clean: drifting(20_000, &(0..0)), faulty });
        verdict.violations.iter().map(|violation| violation.invariant).collect::<Vec<_>>()
    };
    let never = usize::MAX;
    assert_eq!(flagged(15_000 + 100 + GRACE_TICKS, never, None), []);
    assert_eq!(flagged(15_001 + 100 + GRACE_TICKS, never, None), [Invariant::Transient]);
    // It comes back, or does not go before it fails by itself: the transient has cost it.
    assert_eq!(flagged(15_100, 19_000, None), [Invariant::Permanent]);
    assert_eq!(flagged(never, never, None), [Invariant::Permanent]);
    let failure = Failure { sensor: Sensor::ImuSlave, kind: FailureKind::Drift, tick: 15_050, sign: 1.0 };
    assert_eq!(flagged(15_100, never, Some(failure)), [Invariant::Permanent]);
}

/// A transient of the receiver leaves a sensor unmonitored from the launch on, with an alarm limit or without:
/// that is a loss, unless the sensor is wrong anyway.
#[test]
fn a_sensor_that_a_transient_leaves_unmonitored_is_lost() {
    let left = |bound_m2: f32, true_error_m: f32| {
        let mut clean = drifting(20_000, &(0..0));
        let mut faulty = drifting(20_000, &(0..0));
        faulty.latch = Some(latched(bound_m2));
        (clean.launched, faulty.launched) = (Some(12_000), Some(12_000));
        for seen in faulty.ticks.iter_mut().skip(12_000).flatten() {
            seen.trust = [Trust::Unmonitored; SENSORS];
            seen.true_error_m = [true_error_m; SENSORS];
        }
        let mut case = case(None);
        case.plan.captive_s = 60.0;
        case.faults.push(Drawn {
            name: "gps: altitude jumps",
            place: Place::Gps,
            phase: Phase::Calibrating,
            from: 8_000,
            to: 8_100,
            events: Vec::new(),
            dips: Vec::new(),
            step_us: 0,
        });
        let mut verdict = judge(&case, &Flown { clean, faulty });
        // The bound is another matter.
        verdict.violations.retain(|violation| violation.invariant != Invariant::Bound);
        verdict.violations.iter().map(|violation| violation.invariant).collect::<Vec<_>>()
    };
    for bound_m2 in [49.0, 0.0, 100.0] {
        assert_eq!(left(bound_m2, 0.5), [Invariant::Permanent, Invariant::Permanent], "{bound_m2}");
        assert_eq!(left(bound_m2, 5.0), [], "{bound_m2}");
    }
}

/// Half of the default model's window.
#[test]
fn half_a_window_is_the_default_models() {
    let config = super::super::run::config().unwrap();
    assert_eq!(HALF_WINDOW_TICKS as f64, f64::from(config.monitor.window_s) / 2.0 * TICKS_PER_S);
}

#[test]
fn a_push_that_no_sample_was_taken_of_is_none_and_any_other_is_owed_its_flag() {
    assert_eq!(pushed(11_990), [Invariant::Detection]);
    assert_eq!(pushed(12_000 + PUSH_TICKS - 1), [Invariant::Detection]);
    assert_eq!(pushed(12_000 + PUSH_TICKS), []);
}

/// From a tick on, every bias is 13 m off its clean value, as the receiver is.
fn offset_from(from: usize) -> Vec<Invariant> {
    let mut faulty = drifting(20_000, &(0..0));
    for sensor in &mut faulty.latch.as_mut().unwrap().sensors {
        sensor.bias_m = 13.0;
    }
    // The first fix comes at tick 100.
    for seen in faulty.ticks.iter_mut().take(100).flatten() {
        seen.fresh = 0;
    }
    let mut case = case(None);
    let fault = Fault::Offset { quantity: Quantity::Altitude, by_milli: -13_000 };
    case.faults.push(Drawn {
        name: "gps: altitude jumps",
        place: Place::Gps,
        phase: Phase::Settling,
        from,
        to: 20_000,
        events: vec![(from, ChipFault { chip: Chip::Gps, fault })],
        dips: Vec::new(),
        step_us: 0,
    });
    let verdict = judge(&case, &Flown { clean: drifting(20_000, &(0..0)), faulty });
    let mut broken: Vec<_> = verdict.violations.iter().map(|violation| violation.invariant).collect();
    broken.dedup();
    broken
}

#[test]
fn a_receiver_that_is_off_from_before_its_first_fix_is_what_everything_is_measured_against() {
    assert_eq!(offset_from(100), []);
    assert_eq!(offset_from(101), [Invariant::Bias]);
}
