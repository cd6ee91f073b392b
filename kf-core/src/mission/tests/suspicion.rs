//! A launch that is suspected before it is confirmed, and one that is suspected and then withdrawn.

use super::*;

/// Ticks of 5 ms; the first edge.
const EDGE: u64 = 6_000;

/// Flies with a first edge at `EDGE`, suspected until it is confirmed after so many ticks. Returns the
/// outputs from the confirmation on.
fn confirmed_after<const E: usize, const T: usize>(
    config: &MissionConfig<E>,
    ticks: u64,
    change: impl Fn(u64, &mut TickInput),
) -> (Mission<0, T, E>, Vec<(u64, TickOutput)>) {
    let mut outputs = Vec::new();
    let mission = fly::<0, T, E>(
        config,
        |k, input| {
            change(k, input);
            input.launch = k >= EDGE + ticks;
            if (EDGE..EDGE + ticks).contains(&k) {
                input.launch_doubt = LaunchDoubt::Suspected;
            }
        },
        |k, output| {
            if k < EDGE + ticks {
                assert!(!output.latched_now && output.phase != Phase::FreeFlight, "tick {k}");
                assert!(output.sensors.iter().all(|sensor| sensor.trust == Trust::Calibrating));
                assert!(output.sensors.iter().all(|sensor| sensor.moving_average_m.is_none()));
                assert_eq!(output.failed_checks, 0);
            } else {
                assert_eq!(output.latched_now, k == EDGE + ticks);
                outputs.push((k, output.clone()));
            }
        },
    );
    (mission, outputs)
}

/// The time that a confirmation takes changes nothing but the time of its report: neither the latch nor
/// anything after it, to the bit.
#[test]
fn what_is_latched_does_not_depend_on_when_it_is_confirmed() {
    // The settling ends, a sensor goes bad and the reference is lost, all between edge and confirmation.
    let events = |k: u64, input: &mut TickInput| {
        if (EDGE + 100..EDGE + 105).contains(&k) {
            input.imu_slave_altitude_m = Some(f32::NAN);
        }
        if (EDGE + 60..EDGE + 560).contains(&k) {
            input.gps = None;
        }
    };
    let mut effects = config::<1>(true);
    effects.constant_effects.push(EffectTerm::new(EffectId::BaroCarrierField, 0.1, 0.01)).unwrap();
    effects.constant_effects.push(EffectTerm::new(EffectId::ImuVelocityError, 0.3, 0.01)).unwrap();
    effects.constant_effects.push(EffectTerm::new(EffectId::BaroScale, 0.5, 0.01)).unwrap();
    for settling_s in [2.0, 30.5] {
        effects.settling_s = settling_s;
        let (at_once, wanted) = confirmed_after::<1, 5>(&effects, 0, events);
        let wanted_latch = at_once.latch().unwrap();
        assert_eq!(wanted_latch.time_us, EDGE * TICK_US);
        for ticks in [1, 4, 50, 600] {
            let (mission, found) = confirmed_after::<1, 5>(&effects, ticks, events);
            assert_eq!(mission.latch(), Some(wanted_latch), "{ticks}");
            for ((k, output), (other, wanted)) in found.iter().zip(&wanted[ticks as usize..]) {
                assert_eq!(k, other);
                let wanted = TickOutput { latched_now: output.latched_now, ..wanted.clone() };
                assert_eq!(*output, wanted, "{ticks} ticks, tick {k}");
            }
            assert_eq!(mission.counters(), at_once.counters());
        }
    }
}

/// The statistics are checked in the ticks after the first edge, as many as there are: which checks fail does
/// not depend on their number, nor on what the receiver reports meanwhile.
#[test]
fn what_failed_does_not_depend_on_when_it_is_confirmed() {
    let failing = |k: u64, input: &mut TickInput| {
        let drift_m = k as f32 * 0.002;
        for altitude_m in
            [&mut input.imu_slave_altitude_m, &mut input.imu_master_altitude_m].into_iter().flatten()
        {
            *altitude_m += drift_m;
        }
        if let Some(BaroReading::AltitudeM(altitude_m)) = &mut input.baro {
            *altitude_m += 2.0 * drift_m;
        }
        input.signals.true_airspeed_mps = input.signals.true_airspeed_mps.map(|v| v + drift_m);
    };
    let poor_from = |first: u64| {
        move |k: u64, input: &mut TickInput| {
            if let Some(fix) = input.gps.as_mut().filter(|_| k >= first) {
                fix.vertical_accuracy_m = Some(50.0);
            }
        }
    };
    let outcome = |ticks, first| {
        let (mission, _) = confirmed_after::<0, 4>(&config(true), ticks, |k, input| {
            failing(k, input);
            poor_from(first)(k, input);
        });
        failed(&mission)
    };
    for ticks in [0, 1, 2, 3, 4, 5, 6, 50] {
        assert_eq!(
            outcome(ticks, EDGE + 1),
            ["trimmed_airspeed", "biases_stationary", "innovations_plausible"],
            "{ticks}"
        );
        let poor = ["trimmed_airspeed", "reference_converged", "biases_stationary", "innovations_plausible"];
        assert_eq!(outcome(ticks, EDGE - 100), poor, "{ticks}");
    }
}

/// A suspicion that is withdrawn costs its own readings and no more: estimate, spread and checks are those of
/// the other readings.
#[test]
fn calibration_goes_on_after_a_suspicion() {
    let held = 3_000..3_400;
    let held = || held.clone();
    // Effects that are zero in captive flight.
    let mut config = config(true);
    config.constant_effects.push(EffectTerm::new(EffectId::BaroCarrierField, 0.1, 0.01)).unwrap();
    config.constant_effects.push(EffectTerm::new(EffectId::ImuVelocityError, 0.3, 0.01)).unwrap();
    let suspected = fly::<0, 4, 0>(
        &config,
        |k, input| {
            if held().contains(&k) {
                input.launch_doubt = LaunchDoubt::Suspected;
            }
        },
        |k, output| assert_eq!(output.phase == Phase::FreeFlight, k >= 6_000),
    );
    let plain = fly::<0, 4, 0>(&config, |_, _| {}, |_, _| {});
    assert_eq!(suspected.counters().launch_suspicions, 1);
    assert_eq!(failed(&suspected), [""; 0]);
    let (latch, without) = (suspected.latch().unwrap(), plain.latch().unwrap());
    assert_eq!(latch.duration_s, without.duration_s);
    for (sensor, other) in latch.sensors.iter().zip(&without.sensors) {
        // 400 of 5,600 ticks, every fourth of which has readings.
        assert_eq!((sensor.readings, other.readings), (1_300, 1_400));
        let apart = sensor.bias_m - other.bias_m;
        assert!(apart != 0.0 && apart * apart < sensor.bias_variance_m2, "{sensor:?} {other:?}");
        // A twelfth less data.
        assert!(
            (1.0..1.12).contains(&(sensor.bias_variance_m2 / other.bias_variance_m2)),
            "{sensor:?} {other:?}"
        );
    }
}

/// While a launch is suspected, the biases equal the earlier ones to the bit.
#[test]
fn nothing_is_learned_while_suspected() {
    let mut before = None;
    fly::<0, 4, 0>(
        &config(true),
        |k, input| {
            if (3_000..3_400).contains(&k) {
                input.launch_doubt = LaunchDoubt::Suspected;
                input.baro = Some(BaroReading::AltitudeM(9_000.0));
            }
        },
        |k, output| {
            let now = (output.altitude_m.to_bits(), output.sensors.map(|sensor| sensor.bias_m.to_bits()));
            match k {
                2_999 => before = Some(now),
                3_000..3_400 => assert_eq!(before, Some(now), "tick {k}"),
                _ => {}
            }
        },
    );
}

/// The reference came back while a launch was suspected: as after any loss, the altitude may be anywhere.
#[test]
fn a_reference_that_returns_in_a_suspicion_is_a_new_one() {
    let risen = |k: u64, input: &mut TickInput| {
        if (2_000..4_020).contains(&k) {
            input.gps = None;
        }
        if k >= 4_000 {
            if let Some(fix) = &mut input.gps {
                fix.altitude_m += 500.0;
            }
            for altitude in [&mut input.imu_master_altitude_m, &mut input.imu_slave_altitude_m] {
                *altitude = altitude.map(|altitude_m| altitude_m + 500.0);
            }
            if let Some(BaroReading::AltitudeM(altitude_m)) = &mut input.baro {
                *altitude_m += 500.0;
            }
        }
    };
    let mission = fly::<0, 4, 0>(
        &config(true),
        |k, input| {
            risen(k, input);
            if (4_000..4_100).contains(&k) {
                input.launch_doubt = LaunchDoubt::Suspected;
            }
        },
        |_, _| {},
    );
    let plain = fly::<0, 4, 0>(&config(true), risen, |_, _| {});
    for (found, wanted) in mission.latch().unwrap().sensors.iter().zip(&plain.latch().unwrap().sensors) {
        assert!((found.bias_m - wanted.bias_m).powi(2) < found.bias_variance_m2, "{found:?} {wanted:?}");
    }
}

#[test]
fn a_launch_that_nothing_confirmed_is_latched_as_such() {
    let mission = fly::<0, 4, 0>(
        &config(true),
        |_, input| {
            if input.launch {
                input.launch_doubt = LaunchDoubt::Unconfirmed;
            }
        },
        |_, _| {},
    );
    assert_eq!(failed(&mission), ["launch_confirmed"]);
}

/// A fix that is refused while a launch is suspected must not become captive flight's reference when the
/// suspicion is withdrawn: neither the residuals nor the alarm limit may depend on it.
#[test]
fn a_fix_that_was_refused_in_a_suspicion_is_no_reference_after_it() {
    let bounds_m = |jump_m: f32| {
        let mission = fly::<0, 4, 0>(
            &config(true),
            |k, input| {
                // With a fix inside, one every 40 ticks.
                if (5_590..5_610).contains(&k) {
                    input.launch_doubt = LaunchDoubt::Suspected;
                }
                if let Some(fix) = input.gps.as_mut().filter(|_| (5_520..5_840).contains(&k)) {
                    fix.altitude_m += jump_m;
                }
            },
            |_, _| {},
        );
        mission.latch().unwrap().sensors.map(|sensor| sensor.bound_m())
    };
    for (clean_m, found_m) in bounds_m(0.0).into_iter().zip(bounds_m(400.0)) {
        assert!((found_m / clean_m - 1.0).abs() < 0.3, "{found_m} m, not {clean_m} m");
    }
}
