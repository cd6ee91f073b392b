//! Outliers and impossible values in captive flight: what they may cost, and that no source is locked out.

use super::*;

/// Ticks of the first calibrated reading and of the launch.
const FIRST: u64 = 400;
const LAUNCH: u64 = 6_000;

fn add_to_baro(input: &mut TickInput, error_m: f32) {
    if let Some(BaroReading::AltitudeM(altitude_m)) = &mut input.baro {
        *altitude_m += error_m;
    }
}

fn add_to_fix(input: &mut TickInput, error_m: f32) {
    if let Some(fix) = &mut input.gps {
        fix.altitude_m += error_m;
    }
}

fn flown(change: impl FnMut(u64, &mut TickInput)) -> Dense {
    fly(&config(true), change, |_, output| {
        assert!(output.altitude_m.is_finite() && output.altitude_variance_m2 >= 0.0, "{output:?}");
        for sensor in output.sensors {
            assert!(sensor.bias_m.is_finite() && sensor.bias_variance_m2 >= 0.0, "{sensor:?}");
        }
    })
}

/// Biases within a quarter of their own sigma of the clean flight's, alarm limits within a factor of 1.3.
fn assert_as_clean(mission: &Dense, clean: &Dense, what: &str) {
    let (latch, clean) = (mission.latch().unwrap(), clean.latch().unwrap());
    for (sensor, clean) in latch.sensors.iter().zip(&clean.sensors) {
        let apart_m = (sensor.bias_m - clean.bias_m).abs();
        assert!(apart_m < 0.25 * clean.bias_variance_m2.sqrt(), "{what}: {sensor:?} {clean:?}");
        let bounds = sensor.bound_m() / clean.bound_m();
        assert!((1.0 / 1.3..1.3).contains(&bounds), "{what}: {bounds}");
    }
}

#[test]
fn one_reading_of_kilometres_moves_neither_bias_nor_bound_wherever_it_comes() {
    let clean = flown(|_, _| {});
    for at in [FIRST, FIRST + 4, FIRST + 8, 3_000, LAUNCH - 100, LAUNCH - 4] {
        for error_m in [4_000.0, -1_500.0, 300.0] {
            let mission = flown(|k, input| {
                if k == at {
                    add_to_baro(input, error_m);
                }
            });
            let what = format!("{error_m} m at tick {at}");
            assert_as_clean(&mission, &clean, &what);
            assert_eq!(failed(&mission), [""; 0], "{what}");
            assert!(
                (1..10).contains(&mission.counters().sensors[2].gated),
                "{what}: {:?}",
                mission.counters()
            );
        }
    }
}

#[test]
fn one_fix_that_is_wrong_moves_nothing_wherever_it_comes() {
    let clean = flown(|_, _| {});
    for at in [FIRST, FIRST + 40, 3_000, LAUNCH - 80, LAUNCH - 40] {
        for (error_m, error_mps) in [(4_000.0, 0.0), (-150.0, 0.0), (0.0, 300.0), (20.0, -40.0)] {
            let mission = flown(|k, input| {
                if k == at {
                    add_to_fix(input, error_m);
                    if let Some(down_mps) = input.gps.as_mut().and_then(|fix| fix.velocity_down_mps.as_mut())
                    {
                        *down_mps += error_mps;
                    }
                }
            });
            let what = format!("{error_m} m, {error_mps} m/s at tick {at}");
            assert_as_clean(&mission, &clean, &what);
            assert_eq!(failed(&mission), [""; 0], "{what}");
        }
    }
}

/// A climb rate that is wrong for a second is not the carrier's: none of its five fixes may shift the
/// altitude.
#[test]
fn a_climb_rate_that_leaps_for_a_second_is_refused_as_long() {
    let clean = flown(|_, _| {});
    for error_mps in [15.0, -15.0, 60.0] {
        let mission = flown(|k, input| {
            let fix = input.gps.as_mut().filter(|_| (LAUNCH - 400..LAUNCH - 200).contains(&k));
            if let Some(down_mps) = fix.and_then(|fix| fix.velocity_down_mps.as_mut()) {
                *down_mps += error_mps;
            }
        });
        assert_as_clean(&mission, &clean, &format!("{error_mps} m/s"));
        assert_eq!(mission.counters().gps.gated, 5, "{error_mps}");
    }
}

/// The alarm limit is not usable if the receiver wanders by 40 m and its climb rate with it.
#[test]
fn a_residual_that_is_spread_beyond_its_model_watches_nothing() {
    let mut config = config(true);
    config.reference.correlation_time_s = 60.0;
    for (error_m, is_watched) in [(0.0, true), (40.0, false)] {
        let mut trust = Vec::new();
        let far = |k: u64, input: &mut TickInput| {
            if (2_000..LAUNCH).contains(&k) {
                let turn = (k - 2_000) as f32 * (core::f32::consts::TAU / 2_000.0);
                add_to_fix(input, error_m * turn.sin());
                if let Some(fix) = &mut input.gps {
                    let rate_mps = error_m * core::f32::consts::TAU / 10.0 * turn.cos();
                    fix.velocity_down_mps = fix.velocity_down_mps.map(|down_mps| down_mps - rate_mps);
                }
            }
        };
        let mission = fly::<0, 4, 0>(&config, far, |k, output| {
            if k > LAUNCH + 400 {
                trust.push(output.sensors[2].trust);
            }
        });
        let expected = if is_watched { Trust::Trusted } else { Trust::Unmonitored };
        let latch = mission.latch().unwrap();
        assert!(trust.iter().all(|trust| *trust == expected), "{error_m}: {:?}", latch.sensors[2]);
        assert_eq!(latch.failed_checks == 0, is_watched, "{error_m}");
    }
}

/// A receiver that was off by 150 m for a third of the calibration is followed there and back. Biases and
/// alarm limits are those of the level to which it returned, and the check reports that there was another.
#[test]
fn a_receiver_that_went_elsewhere_and_came_back_leaves_the_biases_that_were_right() {
    let mut config = config(true);
    config.reference.correlation_time_s = 60.0;
    let clean = fly::<0, 4, 0>(&config, |_, _| {}, |_, _| {});
    let far = |k: u64, input: &mut TickInput| {
        if (2_000..4_000).contains(&k) {
            add_to_fix(input, 150.0);
        }
    };
    let mission = fly::<0, 4, 0>(&config, far, |_, _| {});
    let (latch, clean) = (mission.latch().unwrap(), clean.latch().unwrap());
    for (sensor, clean) in latch.sensors.iter().zip(&clean.sensors) {
        let apart_m = (sensor.bias_m - clean.bias_m).abs();
        assert!(apart_m < 3.0 * sensor.bias_variance_m2.sqrt(), "{sensor:?} {clean:?}");
        let bounds = sensor.bound_m() / clean.bound_m();
        assert!((1.0 / 1.3..1.3).contains(&bounds), "{bounds}");
    }
    assert!(failed(&mission).contains(&"readings_consistent"), "{:?}", failed(&mission));
}

#[test]
fn fifty_outliers_leave_the_bound_and_are_said() {
    let clean = flown(|_, _| {});
    for (outliers, expected) in [(20, &[][..]), (50, &["readings_consistent"][..])] {
        // Of 1,400 readings, alternately on either side; 2 % may be implausible.
        let mission = flown(|k, input| {
            let turn = (k - k.min(FIRST)) / 100;
            if (FIRST..FIRST + outliers * 100).contains(&k) && k % 100 == 0 {
                add_to_baro(input, if turn % 2 == 0 { 50.0 } else { -4_000.0 });
            }
        });
        assert_as_clean(&mission, &clean, "fifty");
        let failed = failed(&mission);
        assert!(expected.iter().all(|check| failed.contains(check)), "{outliers}: {failed:?}");
        assert_eq!(failed.is_empty(), expected.is_empty(), "{outliers}: {failed:?}");
        // The very first is within the prior, and is exposed by those after it.
        let baro = mission.counters().sensors[2];
        assert!(u64::from(baro.gated + baro.implausible) + 1 >= outliers, "{baro:?}");
    }
}

#[test]
fn a_sensor_that_is_noisier_than_its_model_is_used_and_its_bound_is_honest() {
    for (times, most_gated) in [(3.0, 0.02), (10.0, 0.25)] {
        let mut noise = Flight { seed: 99, noise: 1.0 };
        let mission = flown(|_, input| {
            let error_m = (times - 1.0) * noise.uniform();
            add_to_baro(input, error_m);
        });
        let baro = mission.latch().unwrap().sensors[2];
        // Uniform noise of the model's 1 m and of times - 1, and the reference's of 2 m.
        let expected_m = (1.0 + (times - 1.0) * (times - 1.0) + 4.0_f32).sqrt();
        assert!(
            (0.8..1.15).contains(&(baro.residual_sigma_m() / expected_m)),
            "{times}: {baro:?} {expected_m}"
        );
        // For some seconds, until the spread is known, the readings are weighted too heavily: a third of
        // their noise.
        assert!((baro.bias_m - BIASES_M[2]).abs() < expected_m / 3.0, "{times}: {baro:?}");
        assert!(
            mission.counters().sensors[2].gated as f32 <= most_gated * 1_400.0,
            "{:?}",
            mission.counters()
        );
        assert!(failed(&mission).contains(&"innovations_plausible"), "{times}: {:?}", failed(&mission));
    }
}

#[test]
fn a_step_is_followed_and_said() {
    for error_m in [40.0, -800.0] {
        let mission = flown(|k, input| {
            if k >= 3_000 {
                add_to_baro(input, error_m);
            }
        });
        let baro = mission.latch().unwrap().sensors[2];
        assert!((baro.bias_m - BIASES_M[2] - error_m).abs() < 1.0, "{error_m}: {baro:?}");
        assert!(failed(&mission).contains(&"readings_consistent"), "{error_m}: {:?}", failed(&mission));
        // Five seconds of it were outliers; the spread is that of the new level.
        assert!((1..=260).contains(&mission.counters().sensors[2].gated), "{:?}", mission.counters());
        assert!((baro.residual_sigma_m() - 5.0_f32.sqrt()).abs() < 0.6, "{baro:?}");
    }
}

#[test]
fn a_second_of_outliers_costs_that_second_only() {
    let clean = flown(|_, _| {});
    for from in [FIRST, 3_000, LAUNCH - 240] {
        let mission = flown(|k, input| {
            if (from..from + 200).contains(&k) {
                add_to_baro(input, 700.0);
            }
        });
        assert_as_clean(&mission, &clean, &format!("from {from}"));
    }
}

#[test]
fn a_bias_beyond_its_prior_is_found_and_said() {
    let mission = flown(|_, input| add_to_baro(input, 4_000.0));
    let baro = mission.latch().unwrap().sensors[2];
    assert!((baro.bias_m - BIASES_M[2] - 4_000.0).abs() < 1.0, "{baro:?}");
    assert_eq!(failed(&mission), ["readings_consistent"]);
    assert!(mission.counters().sensors[2].gated <= 3);
}

#[test]
fn a_receiver_that_stays_elsewhere_is_followed_and_said() {
    for error_m in [100.0, -1_500.0] {
        let mission = flown(|k, input| {
            if k >= 2_000 {
                add_to_fix(input, error_m);
            }
        });
        let latch = mission.latch().unwrap();
        for (sensor, bias_m) in latch.sensors.iter().zip(BIASES_M) {
            assert!((sensor.bias_m - bias_m + error_m).abs() < 2.0, "{error_m}: {sensor:?}");
        }
        assert!(!failed(&mission).is_empty());
    }
}

/// A receiver that is far off while the calibration begins, then is right again, and was refused for so long
/// that it counts as lost: its altitude is adopted in full, not only as far as the apparent noise of the
/// refused fixes would allow.
#[test]
fn a_receiver_that_comes_back_to_where_it_is_right_is_believed_whole() {
    // Correlated, like a receiver's error: more frequent fixes add no information.
    let mut config = config(true);
    config.reference.correlation_time_s = 30.0;
    let clean = fly::<0, 4, 0>(&config, |_, _| {}, |_, _| {});
    for error_m in [1_450.0, -600.0, 120.0] {
        let mission = fly::<0, 4, 0>(
            &config,
            |k, input| {
                if k < FIRST + 1_600 {
                    add_to_fix(input, error_m);
                }
            },
            |_, _| {},
        );
        let (latch, clean) = (mission.latch().unwrap(), clean.latch().unwrap());
        for (sensor, clean) in latch.sensors.iter().zip(&clean.sensors) {
            let apart_m = (sensor.bias_m - clean.bias_m).abs();
            assert!(apart_m < 2.0 * sensor.bias_variance_m2.sqrt(), "{error_m}: {sensor:?} {clean:?}");
        }
        assert!(failed(&mission).contains(&"readings_consistent"), "{error_m}: {:?}", failed(&mission));
    }
}

/// An outage of the receiver in which the vehicle climbs further than the altitude's prior allows: the
/// altitude after it is accepted.
#[test]
fn a_receiver_that_comes_back_far_from_where_it_was_lost_is_believed() {
    let mission = flown(|k, input| {
        if (1_000..3_000).contains(&k) {
            input.gps = None;
        }
        if k >= 3_000 {
            add_to_fix(input, 900.0);
            add_to_baro(input, 900.0);
            input.imu_slave_altitude_m = input.imu_slave_altitude_m.map(|altitude_m| altitude_m + 900.0);
        }
    });
    // Two of them are outliers until the third confirms them.
    assert_eq!(mission.counters().gps.gated, 2);
    let clean = flown(|_, _| {});
    let (latch, clean) = (mission.latch().unwrap(), clean.latch().unwrap());
    // Altitude and biases.
    for (i, wanted_m) in [(0, 900.0), (2, 0.0), (3, 0.0)] {
        let moved_m = latch.state[i] - clean.state[i];
        assert!((moved_m - wanted_m).abs() < 1.5, "{:?} {:?}", latch.state, clean.state);
    }
}

#[test]
fn impossible_values_are_refused_counted_and_touch_nothing() {
    let clean = flown(|_, _| {});
    for value in [1e38, -1e38, 3.4e38, 1e6, -1_001.0, 100_001.0] {
        let mission = flown(|k, input| {
            match k {
                // In addition to the good readings, at ticks without any.
                1_001 | 3_001 => {
                    input.baro = Some(BaroReading::AltitudeM(value));
                    input.imu_slave_altitude_m = Some(value);
                    input.imu_master_altitude_m = Some(value);
                }
                1_003 => input.gps = Some(GpsFix { altitude_m: value, ..GpsFix::default() }),
                1_005 => {
                    let velocity_down_mps = Some(value);
                    input.gps = Some(GpsFix { altitude_m: 2_000.0, velocity_down_mps, ..GpsFix::default() });
                }
                1_007 => input.signals.true_airspeed_mps = Some(value),
                _ => {}
            }
        });
        let counters = mission.counters();
        assert_eq!(counters.sensors.map(|sensor| sensor.implausible), [2; 3], "{value}");
        assert_eq!((counters.gps.implausible, counters.signals_not_finite), (2, 1), "{value}");
        let biases = |mission: &Dense| mission.latch().unwrap().sensors.map(|sensor| sensor.bias_m);
        assert_eq!(biases(&mission), biases(&clean), "{value}");
        // One implausible altitude in hundreds is no blemish; an invalid signal is a fault of the board.
        assert_eq!(failed(&mission), ["inputs_valid"], "{value}");
    }
}
