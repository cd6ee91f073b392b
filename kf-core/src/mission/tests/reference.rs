//! The monitor in free flight: transients, gaps, and faults of the reference that resemble faults of the
//! sensors.

use super::*;
use crate::snapshot::MAX_SNAPSHOT_BYTES;

/// Tick of the launch.
const LAUNCH: u64 = 6_000;
const SLAVE: usize = 1;
const BARO: usize = 2;

/// Outcome of a flight.
#[derive(Clone, Debug, Default, PartialEq)]
struct Seen {
    /// When the inertial altitude and the barometer first became doubtful and untrustworthy, seconds after
    /// launch.
    flags_s: [[Option<f32>; 2]; 2],
    /// Trust of both at every tick of free flight.
    trust: Vec<[Trust; 2]>,
    /// Ticks at which the two were checked against each other, and the last result.
    cross_checks: u32,
    agreement: Option<crate::output::Agreement>,
}

impl Seen {
    fn take(&mut self, k: u64, output: &TickOutput) {
        if k < LAUNCH {
            return;
        }
        let trust = [output.sensors[SLAVE].trust, output.sensors[BARO].trust];
        for (flags_s, trust) in self.flags_s.iter_mut().zip(trust) {
            let level = match trust {
                Trust::Doubtful => 1,
                Trust::Untrustworthy => 2,
                _ => 0,
            };
            for flag_s in &mut flags_s[..level] {
                flag_s.get_or_insert((k - LAUNCH) as f32 * 0.005);
            }
        }
        self.trust.push(trust);
        if let Some(said) = output.cross_check {
            self.cross_checks += 1;
            self.agreement = Some(said.agreement);
        }
    }

    /// Trust of both, `after_s` seconds after launch.
    fn at(&self, after_s: f32) -> [Trust; 2] {
        self.trust[(after_s * 200.0) as usize]
    }
}

fn flown(config: &MissionConfig<0>, change: impl Fn(f32, &mut TickInput)) -> (Seen, Counters) {
    let mut seen = Seen::default();
    let change = |k: u64, input: &mut TickInput| change((k as f32 - LAUNCH as f32) * 0.005, input);
    let mission = fly::<0, 4, 0>(config, change, |k, output| seen.take(k, output));
    (seen, *mission.counters())
}

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

const NO_FLAG: [[Option<f32>; 2]; 2] = [[None; 2]; 2];

#[test]
fn three_readings_of_a_transient_at_release_or_after_a_gap_make_doubtful_only() {
    for start_s in [0.0, 0.1, 2.3, 6.5] {
        let (seen, _) = flown(&config(true), |time_s, input| {
            if (6.0..6.5).contains(&time_s) {
                input.baro = None;
            }
            if (start_s..start_s + 0.055).contains(&time_s) {
                add_to_baro(input, 20.0);
            }
        });
        let [slave, baro] = seen.flags_s;
        assert_eq!((slave, baro[1]), ([None; 2], None), "{start_s}");
        assert!(baro[0].is_some(), "{start_s}");
    }
}

#[test]
fn a_transient_of_a_second_costs_no_sensor_its_flight_and_no_other_anything() {
    for (size_m, start_s, end_s) in [(4e3, 3.0, 3.015), (4e3, 0.0, 0.015), (200.0, 3.0, 4.0)] {
        let (seen, _) = flown(&config(true), |time_s, input| {
            if (start_s..end_s).contains(&time_s) {
                add_to_baro(input, size_m);
            }
        });
        assert_eq!(seen.flags_s[0], [None; 2], "{size_m} {start_s}");
        assert!(seen.flags_s[1][0].is_some() && seen.flags_s[1][1].is_none(), "{size_m} {start_s}");
    }
}

#[test]
fn a_step_at_release_is_flagged_as_soon_as_one_later() {
    let delay_s = |start_s: f32| {
        let (seen, _) = flown(&config(true), |time_s, input| {
            if time_s >= start_s {
                add_to_baro(input, 25.0);
            }
        });
        assert_eq!(seen.flags_s[0], [None; 2]);
        seen.flags_s[1][1].unwrap() - start_s
    };
    // The alarm limit of about 8.9 m is 0.36 of 25 m: 0.72 s. It must last for 1.25 s.
    for start_s in [0.0, 0.5, 5.0] {
        assert!((1.2..1.35).contains(&delay_s(start_s)), "{start_s}: {}", delay_s(start_s));
    }
}

#[test]
fn a_short_jump_of_the_receiver_is_bridged_and_costs_no_sensor_anything() {
    for jump_m in [100.0, -100.0, 25.0, 5e4] {
        let (seen, counters) = flown(&config(true), |time_s, input| {
            if (3.0..4.0).contains(&time_s) {
                add_to_fix(input, jump_m);
            }
        });
        assert_eq!(seen.flags_s, NO_FLAG, "{jump_m}");
        assert!(seen.trust.iter().all(|trust| *trust == [Trust::Trusted; 2]), "{jump_m}");
        assert_eq!((counters.gps.gated, counters.readings_unjudged), (5, 0), "{jump_m}");
    }
}

#[test]
fn a_jump_that_lasts_leaves_the_sensors_unmonitored_until_it_ends() {
    let (seen, counters) = flown(&config(true), |time_s, input| {
        if (2.0..7.0).contains(&time_s) {
            add_to_fix(input, 100.0);
        }
    });
    assert_eq!(seen.flags_s, NO_FLAG);
    // Carried forward for the 2 s after which a reference counts as lost.
    assert_eq!(seen.at(3.7), [Trust::Trusted; 2]);
    assert_eq!(seen.at(5.0), [Trust::Unmonitored; 2]);
    assert_eq!(seen.at(7.1), [Trust::Trusted; 2]);
    assert!(seen.cross_checks > 100 && seen.agreement == Some(crate::output::Agreement::Agree));
    assert_eq!(counters.gps.gated, 25);
    assert!(counters.readings_unjudged > 200);
}

#[test]
fn a_jump_from_before_the_launch_that_ends_after_it_is_nobodys_but_the_receivers() {
    let (seen, _) = flown(&config(true), |time_s, input| {
        if (-0.5..1.0).contains(&time_s) {
            add_to_fix(input, 100.0);
        }
    });
    // The captive gate has refused the jump, so the check in free flight uses the altitude from before it.
    assert_eq!(seen.flags_s, NO_FLAG);
    assert_eq!(seen.at(0.5), [Trust::Trusted; 2]);
    assert_eq!(seen.at(1.1), [Trust::Trusted; 2]);
}

#[test]
fn a_jump_without_a_climb_rate_is_the_receivers_if_both_sensors_say_so() {
    let (seen, counters) = flown(&config(true), |time_s, input| {
        if let Some(fix) = &mut input.gps {
            fix.velocity_down_mps = None;
        }
        if (3.0..4.0).contains(&time_s) {
            add_to_fix(input, 40.0);
        }
    });
    assert_eq!(seen.flags_s, NO_FLAG);
    assert_eq!(seen.at(3.5), [Trust::Unmonitored; 2]);
    assert_eq!(seen.at(4.1), [Trust::Trusted; 2]);
    assert_eq!(counters.gps.gated, 0);
    // One second of both sensors.
    assert_eq!(counters.readings_unjudged, 100);
}

#[test]
fn a_single_sensor_is_not_blamed_for_a_jump_that_the_climb_rate_denies() {
    for end_s in [4.0, 20.0] {
        let (seen, _) = flown(&config(true), |time_s, input| {
            input.imu_slave_altitude_m = None;
            if (3.0..end_s).contains(&time_s) {
                add_to_fix(input, 100.0);
            }
        });
        assert_eq!(seen.flags_s, NO_FLAG);
        assert_eq!(seen.at(3.5)[1], Trust::Trusted);
        assert_eq!(seen.at(9.0)[1], if end_s > 10.0 { Trust::Unmonitored } else { Trust::Trusted });
    }
}

#[test]
fn a_reference_that_drifts_away_from_both_is_suspect_and_with_the_check_off_both_sensors_are() {
    let drift = |time_s: f32, input: &mut TickInput| add_to_fix(input, 5.0 * time_s.clamp(0.0, 6.0));
    let (seen, _) = flown(&config(true), drift);
    assert!(seen.flags_s.iter().all(|flags_s| flags_s[1].is_none()), "{:?}", seen.flags_s);
    assert_eq!(seen.at(6.0), [Trust::Unmonitored; 2]);
    assert!(seen.cross_checks > 50 && seen.agreement == Some(crate::output::Agreement::Agree));
    let mut papers = config(true);
    papers.monitor.reference_check = false;
    let (seen, counters) = flown(&papers, drift);
    assert_eq!(seen.at(6.0), [Trust::Untrustworthy; 2]);
    assert_eq!((counters.gps.gated, counters.readings_unjudged), (0, 0));
}

#[test]
fn a_sensor_that_fails_is_flagged_as_soon_with_the_check_as_without() {
    let mut unchecked = config(true);
    unchecked.monitor.reference_check = false;
    for drift_mps in [2.0, -2.0, 4.0] {
        let drift = |time_s: f32, input: &mut TickInput| add_to_baro(input, drift_mps * time_s.max(0.0));
        let ([_, clean], [slave, baro]) =
            (flown(&unchecked, drift).0.flags_s, flown(&config(true), drift).0.flags_s);
        assert_eq!(slave, [None; 2]);
        assert!((baro[1].unwrap() - clean[1].unwrap()).abs() < 0.1, "{drift_mps}: {baro:?} {clean:?}");
        // Equally early with a jump of the receiver on the way.
        let (seen, _) = flown(&config(true), |time_s, input| {
            drift(time_s, input);
            if (1.0..2.0).contains(&time_s) {
                add_to_fix(input, -100.0);
            }
        });
        assert_eq!(seen.flags_s[0], [None; 2]);
        let jumped_s = seen.flags_s[1][1].unwrap();
        assert!((jumped_s / clean[1].unwrap() - 1.0).abs() < 0.2, "{drift_mps}: {jumped_s} {clean:?}");
    }
}

/// Two sensors that fail alike: a receiver whose climb rate agrees with its altitude is not that far off
/// itself. One that was lost in between, or measures no climb rate, may be.
#[test]
fn two_sensors_that_fail_alike_are_flagged_where_the_receiver_stands_by_its_altitude() {
    let fails = |time_s: f32, input: &mut TickInput| {
        let error_m = 4.0 * (time_s - 4.0).max(0.0);
        add_to_baro(input, error_m);
        input.imu_slave_altitude_m = input.imu_slave_altitude_m.map(|altitude_m| altitude_m + error_m);
    };
    let is_untrustworthy = |seen: &Seen| seen.flags_s.map(|flags_s| flags_s[1].is_some());
    let (seen, _) = flown(&config(true), fails);
    assert_eq!(is_untrustworthy(&seen), [true; 2], "{:?}", seen.flags_s);
    let (seen, _) = flown(&config(true), |time_s, input| {
        fails(time_s, input);
        input.gps = input.gps.filter(|_| !(0.5..3.5).contains(&time_s));
    });
    assert_eq!(is_untrustworthy(&seen), [false; 2], "lost: {:?}", seen.flags_s);
    let (seen, _) = flown(&config(true), |time_s, input| {
        fails(time_s, input);
        if let Some(fix) = &mut input.gps {
            fix.velocity_down_mps = None;
        }
    });
    assert_eq!(is_untrustworthy(&seen), [false; 2], "no climb rate: {:?}", seen.flags_s);
}

#[test]
fn an_untrustworthy_sensor_is_no_witness() {
    let (seen, _) = flown(&config(true), |time_s, input| {
        if time_s > 1.0 {
            add_to_baro(input, 40.0);
        }
        if let (true, Some(altitude_m)) = (time_s > 5.0, &mut input.imu_slave_altitude_m) {
            *altitude_m += 40.0;
        }
    });
    assert!(seen.flags_s[1][1].unwrap() < 2.5);
    assert!((6.0..6.5).contains(&seen.flags_s[0][1].unwrap()), "{:?}", seen.flags_s);
}

#[test]
fn a_mission_that_goes_on_in_the_middle_of_a_jump_says_the_same() {
    let change = |k: u64, input: &mut TickInput| {
        if (6_600..7_600).contains(&k) {
            add_to_fix(input, 100.0);
        }
        add_to_baro(input, (k as f32 - 7_000.0).max(0.0) * 0.02);
    };
    let inputs: Vec<TickInput> = {
        let mut flight = Flight { seed: 7, noise: 1.0 };
        (0..8_000)
            .map(|k| {
                let mut input = flight.tick(k);
                change(k, &mut input);
                input
            })
            .collect()
    };
    let fly = |interrupted_at: Option<usize>| {
        let mut mission = Dense::new(&config(true)).unwrap();
        inputs
            .iter()
            .enumerate()
            .map(|(k, input)| {
                if Some(k) == interrupted_at {
                    let mut bytes = [0; MAX_SNAPSHOT_BYTES];
                    let length = mission.snapshot().unwrap().to_bytes(&mut bytes).unwrap();
                    let mark = mission.mark();
                    mission = Dense::new(&config(true)).unwrap();
                    mission.restore_snapshot(&bytes[..length], &mark).unwrap();
                }
                let output = mission.tick(input);
                (
                    output.sensors.map(|sensor| (sensor.error_m, sensor.moving_average_m, sensor.trust)),
                    output.gps_rejection,
                )
            })
            .collect::<Vec<_>>()
    };
    let whole = fly(None);
    assert_eq!(whole.last().unwrap().0[BARO].2, Trust::Untrustworthy);
    // At a tick where an unmonitored sensor has just delivered, so that the first tick shows everything.
    for at in [6_300, 6_704, 7_204, 7_700] {
        assert_eq!(fly(Some(at))[at..], whole[at..], "{at}");
    }
}

/// With the barometer as the only sensor, and a receiver that is lost after 5 s.
fn flown_alone(change: impl Fn(f32, &mut TickInput)) -> Seen {
    let mut config = config(true);
    config.reference.lost_after_s = 5.0;
    let alone = |time_s: f32, input: &mut TickInput| {
        input.imu_slave_altitude_m = None;
        change(time_s, input);
    };
    flown(&config, alone).0
}

#[test]
fn what_an_old_climb_rate_carries_on_is_held_against_nobody() {
    // The vehicle falls for 4 s without a fix: by its last climb rate it flies level.
    let fallen_m = |time_s: f32| 3.0 * (time_s - 3.0).clamp(0.0, 4.0) * (time_s - 3.0).clamp(0.0, 4.0);
    let seen = flown_alone(|time_s, input| {
        add_to_baro(input, -fallen_m(time_s));
        add_to_fix(input, -fallen_m(time_s));
        if let (true, Some(fix)) = (time_s < 7.1, &mut input.gps) {
            fix.velocity_down_mps = Some(6.0 * (time_s - 3.0).max(0.0));
        }
        if (3.0..7.0).contains(&time_s) {
            input.gps = None;
        }
    });
    assert_eq!(seen.flags_s[1], [None; 2]);
    assert_eq!(seen.at(3.4)[1], Trust::Trusted);
    assert_eq!(seen.at(5.0)[1], Trust::Unmonitored);
    assert_eq!(seen.at(8.0)[1], Trust::Trusted);
}

/// A vehicle that sinks at 25 m/s from the launch on, and whose clock leaps forward by `leap_s` seconds 3 s
/// later.
fn leap(time_s: f32, input: &mut TickInput, leap_s: f32, receiver_has_a_clock: bool) {
    let climb_mps = if time_s > 0.0 { -25.0 } else { 0.0 };
    add_to_fix(input, climb_mps * time_s);
    add_to_baro(input, climb_mps * time_s);
    input.imu_slave_altitude_m = input.imu_slave_altitude_m.map(|altitude_m| altitude_m + climb_mps * time_s);
    let is_over = time_s > 3.0;
    if let Some(fix) = &mut input.gps {
        fix.velocity_down_mps = fix.velocity_down_mps.map(|down_mps| down_mps - climb_mps);
        fix.fix_time_us = receiver_has_a_clock.then_some(input.time_us);
    }
    if is_over {
        input.time_us += (leap_s * 1e6) as u64;
    }
}

#[test]
fn a_clock_that_leaps_is_seen_by_the_receivers_and_costs_no_reference() {
    let mut config = config(true);
    config.reference.lost_after_s = 5.0;
    for leap_s in [0.7, 1.5, 3.2, 20.0] {
        let (seen, counters) = flown(&config, |time_s, input| leap(time_s, input, leap_s, true));
        assert_eq!(seen.flags_s, NO_FLAG, "{leap_s}");
        assert_eq!((seen.at(3.5), seen.at(9.0)), ([Trust::Trusted; 2], [Trust::Trusted; 2]), "{leap_s}");
        assert_eq!(counters.gps.gated, 0, "{leap_s}");
    }
}

/// The reference is carried forward 30 m too far, and the fixes show it. An inertial altitude silenced by the
/// leap is no evidence of that, whatever it reported before.
#[test]
fn a_sensor_that_has_not_spoken_since_is_no_witness_of_the_receivers_two_words() {
    let mut config = config(true);
    config.reference.lost_after_s = 5.0;
    let (seen, counters) = flown(&config, |time_s, input| {
        leap(time_s, input, 1.2, false);
        if time_s > 3.0 {
            input.imu_slave_altitude_m = None;
        }
    });
    assert!(counters.gps.gated > 10);
    assert_eq!(seen.flags_s[1], [None; 2]);
}

/// A sensor that has delivered since is a witness: also after a restart.
#[test]
fn a_restart_forgets_no_witness() {
    let inputs: Vec<TickInput> = {
        let mut flight = Flight { seed: 7, noise: 1.0 };
        (0..8_000)
            .map(|k| {
                let mut input = flight.tick(k);
                // The climb rate goes wrong, the altitude is right, and the barometer fails.
                if let (true, Some(fix)) = (k > LAUNCH + 100, &mut input.gps) {
                    fix.velocity_down_mps = fix.velocity_down_mps.map(|down_mps| down_mps - 3.0);
                }
                add_to_baro(&mut input, if k > LAUNCH + 1_400 { 20.0 } else { 0.0 });
                input
            })
            .collect()
    };
    let flagged_at = |interrupted_at: u64| {
        let mut mission = Dense::new(&config(true)).unwrap();
        let mut flagged = None;
        for (k, input) in (0_u64..).zip(&inputs) {
            if k == interrupted_at {
                let mut bytes = [0; MAX_SNAPSHOT_BYTES];
                let length = mission.snapshot().unwrap().to_bytes(&mut bytes).unwrap();
                let mark = mission.mark();
                mission = Dense::new(&config(true)).unwrap();
                mission.restore_snapshot(&bytes[..length], &mark).unwrap();
            }
            if mission.tick(input).sensors[BARO].trust == Trust::Untrustworthy {
                flagged.get_or_insert(k);
            }
        }
        flagged
    };
    let never = flagged_at(u64::MAX);
    assert!(never.is_some());
    assert_eq!(flagged_at(LAUNCH + 1_000), never);
}

/// The supply dips in a dive, and the flight computer's clock misses 0.3 s in which 7.5 m are lost. The
/// receiver's clock does not, so its altitude has not left its climb rate, and does not excuse a barometer
/// that fails later.
#[test]
fn what_is_climbed_in_a_restart_is_not_what_the_receiver_has_left() {
    const AWAY: u64 = 60;
    let flagged_after = |interrupted_at: Option<u64>| {
        let mut flight = Flight { seed: 7, noise: 1.0 };
        let mut mission = Dense::new(&config(true)).unwrap();
        (0..8_000).find(|k| {
            let mut input = flight.tick(*k);
            leap((*k as f32 - LAUNCH as f32) * 0.005, &mut input, 0.0, true);
            input.imu_slave_altitude_m = None;
            let away = interrupted_at.map_or(0..0, |at| at..at + AWAY);
            if *k == away.start && !away.is_empty() {
                let mut bytes = [0; MAX_SNAPSHOT_BYTES];
                let length = mission.snapshot().unwrap().to_bytes(&mut bytes).unwrap();
                let mark = mission.mark();
                mission = Dense::new(&config(true)).unwrap();
                mission.restore_snapshot(&bytes[..length], &mark).unwrap();
            }
            if away.contains(k) {
                return false;
            }
            if *k >= away.end {
                input.time_us -= 5_000 * (away.end - away.start);
            }
            if *k > LAUNCH + 1_000 {
                // Two metres more than it may be off: half of what 7.5 m would excuse.
                let bound_m2 = mission.latch().unwrap().sensors[BARO].bound_m2;
                add_to_baro(&mut input, crate::root::reciprocal_root(bound_m2) * bound_m2 + 2.0);
            }
            mission.tick(&input).sensors[BARO].trust == Trust::Untrustworthy
        })
    };
    let whole = flagged_after(None).unwrap();
    assert!((LAUNCH + 1_200..LAUNCH + 1_600).contains(&whole), "{whole}");
    let interrupted = flagged_after(Some(LAUNCH + 500)).unwrap();
    assert!(interrupted.abs_diff(whole) < 100, "{interrupted} {whole}");
}

#[test]
fn a_single_sensor_is_not_blamed_for_a_drift_that_the_climb_rate_denies() {
    for drift_mps in [2.0, -5.0] {
        let seen = flown_alone(|time_s, input| add_to_fix(input, drift_mps * time_s.clamp(0.0, 6.0)));
        assert_eq!(seen.flags_s[1][1], None, "{drift_mps}");
        assert_eq!(seen.at(8.0)[1], Trust::Unmonitored, "{drift_mps}");
    }
    // Nor for one that begins before the launch and passes the captive gate.
    let seen = flown_alone(|time_s, input| add_to_fix(input, 2.5 * (time_s + 4.0).clamp(0.0, 4.0)));
    assert_eq!(seen.flags_s[1][1], None);
}

#[test]
fn a_sensor_that_the_refused_fixes_agree_with_is_not_blamed_for_a_wrong_climb_rate() {
    let seen = flown_alone(|time_s, input| {
        if let (true, Some(fix)) = (time_s > 1.0, &mut input.gps) {
            fix.velocity_down_mps = Some(80.0);
        }
    });
    assert_eq!(seen.flags_s[1][1], None);
}

#[test]
fn a_single_sensor_that_fails_is_flagged_as_soon_as_without_the_check() {
    let mut unchecked = config(true);
    unchecked.monitor.reference_check = false;
    let failures: [&dyn Fn(f32) -> f32; 3] =
        [&|time_s| 2.0 * time_s.max(0.0), &|time_s| -2.0 * time_s.max(0.0), &|time_s| {
            if time_s > 2.0 { 25.0 } else { 0.0 }
        }];
    for (number, error_m) in failures.into_iter().enumerate() {
        let fail = |time_s: f32, input: &mut TickInput| add_to_baro(input, error_m(time_s));
        let clean_s = flown(&unchecked, fail).0.flags_s[1][1].unwrap();
        let alone_s = flown_alone(fail).flags_s[1][1].unwrap();
        assert!((alone_s - clean_s).abs() < 0.3, "{number}: {alone_s} {clean_s}");
    }
    // A receiver that is 10 m off does not excuse an error that is not its own.
    let seen = flown_alone(|time_s, input| {
        add_to_fix(input, (5.0 * time_s).clamp(0.0, 10.0));
        add_to_baro(input, if time_s > 4.0 { 40.0 } else { 0.0 });
    });
    assert!((5.0..6.0).contains(&seen.flags_s[1][1].unwrap()), "{:?}", seen.flags_s);
}

/// The receiver jumps by 25 m, and all readings of the inertial altitude, which is tied to it, come after the
/// jump: its bias belongs to the level before.
#[test]
fn an_altitude_whose_readings_contradict_its_bias_is_not_monitored_and_named() {
    for (jump_m, is_monitored) in [(0.0, true), (25.0, false)] {
        let mission = fly::<0, 4, 0>(
            &config(true),
            |k, input| {
                if k >= 3_000 {
                    add_to_fix(input, jump_m);
                }
                let slave_m = input.imu_slave_altitude_m.filter(|_| k >= 4_500);
                input.imu_slave_altitude_m = slave_m.map(|altitude_m| altitude_m + jump_m);
            },
            |_, _| {},
        );
        let latched = mission.latch().unwrap().sensors[SLAVE];
        assert_eq!(latched.bound_m2 > 0.0, is_monitored, "{latched:?}");
        assert_eq!(failed(&mission).contains(&"readings_consistent"), !is_monitored, "{jump_m}");
    }
}

/// A receiver is off by 3 km from 7 s before the launch on, which the captive gate refuses until the
/// reference is lost. After that it is the reference, but is no evidence about a sensor until a sensor
/// supports it.
#[test]
fn a_receiver_that_is_kilometres_off_at_the_launch_blames_nobody() {
    for until_s in [4.0, 99.0] {
        let jump = |time_s: f32, input: &mut TickInput| {
            if (-7.0..until_s).contains(&time_s) {
                add_to_fix(input, 3_000.0);
            }
            add_to_baro(input, if time_s > 8.0 { 30.0 } else { 0.0 });
        };
        let alone = flown_alone(jump);
        let mut lost = config(true);
        lost.reference.lost_after_s = 5.0;
        let both = flown(&lost, jump).0;
        for seen in [&alone, &both] {
            assert_eq!(seen.flags_s[0], [None; 2], "{until_s}");
            let flagged_s = seen.flags_s[1][1];
            // Once it has come back, it shows the barometer's step.
            assert!(flagged_s.is_none_or(|flagged_s| flagged_s > 8.0), "{until_s}: {flagged_s:?}");
        }
        assert_eq!(alone.flags_s[1][1].is_some(), until_s < 8.0, "{until_s}: {:?}", alone.flags_s);
    }
}

/// The failed checks of a flight whose fixes have the noise of a receiver that wanders over a minute.
fn failed_with(change: impl Fn(f32, &mut TickInput)) -> Vec<&'static str> {
    let mut config = config(true);
    config.reference.correlation_time_s = 60.0;
    let change = |k: u64, input: &mut TickInput| {
        if let Some(fix) = &mut input.gps {
            fix.altitude_m = 2_000.0 + 0.2 * (fix.altitude_m - 2_000.0);
        }
        change(k as f32 * 0.005, input);
    };
    failed(&fly::<0, 4, 0>(&config, change, |_, _| {}))
}

#[test]
fn a_reference_that_jumps_in_captive_flight_degrades_the_calibration_by_name() {
    assert_eq!(failed_with(|_, _| {}), [""; 0]);
    // Also soon after the calibration begins, at 2 s: the settling time was on the first level.
    for (from_s, to_s) in [(1.0, 99.0), (2.3, 99.0), (4.0, 99.0), (12.0, 99.0), (12.0, 20.0), (26.0, 99.0)] {
        for jump_m in [7.0, -7.0] {
            let failed = failed_with(|time_s, input| {
                if (from_s..to_s).contains(&time_s) {
                    add_to_fix(input, jump_m);
                }
            });
            assert!(failed.contains(&"reference_converged"), "{from_s} {to_s} {jump_m}: {failed:?}");
        }
    }
    // A single fix that is off is no jump, and a receiver may report that it has not converged while it
    // settles.
    let spike = |time_s: f32, input: &mut TickInput| {
        if (12.0..12.1).contains(&time_s) {
            add_to_fix(input, 7.0);
        }
        // Nothing is gated while it settles.
        if (1.0..1.1).contains(&time_s) {
            add_to_fix(input, 4_000.0);
        }
    };
    assert_eq!(failed_with(spike), [""; 0]);
    let cold_start = |time_s: f32, input: &mut TickInput| {
        if let (true, Some(fix)) = (time_s < 1.0, &mut input.gps) {
            fix.altitude_m += 30.0 * (1.0 - time_s);
            fix.vertical_accuracy_m = Some(30.0);
        }
    };
    assert_eq!(failed_with(cold_start), [""; 0]);
}

/// Everything is measured against the first fix that counts. If the receiver is off at just that time, for no
/// longer than a transient, the calibration begins again and does not fail for two levels.
#[test]
fn a_reference_that_is_off_as_the_calibration_begins_is_forgotten() {
    for from_s in [1.9, 2.0] {
        for jump_m in [10.0, -14.0] {
            let failed = failed_with(|time_s, input| {
                if (from_s..from_s + 0.6).contains(&time_s) {
                    add_to_fix(input, jump_m);
                }
            });
            assert!(!failed.contains(&"reference_converged"), "{from_s} {jump_m}: {failed:?}");
        }
    }
}

#[test]
fn a_sensor_that_changes_its_level_while_the_reference_settles_degrades_the_calibration_by_name() {
    let failed = failed_with(|time_s, input| {
        if time_s > 1.0 {
            input.imu_master_altitude_m = input.imu_master_altitude_m.map(|altitude_m| altitude_m - 187.0);
        }
    });
    assert_eq!(failed, ["readings_consistent"]);
}

#[test]
fn a_single_wild_reading_while_the_reference_settles_is_no_level() {
    // The first fix that counts, and one in the middle.
    for wild_s in [0.0, 0.5] {
        let is_over = core::cell::Cell::new(false);
        let failed = failed_with(|time_s, input| {
            if time_s >= wild_s && input.imu_master_altitude_m.is_some() && !is_over.replace(true) {
                input.imu_master_altitude_m =
                    input.imu_master_altitude_m.map(|altitude_m| altitude_m - 187.0);
            }
        });
        assert_eq!(failed, [""; 0], "{wild_s}");
    }
}

/// A climb rate that goes wrong after the launch: altitude and climb rate disagree, and the inertial
/// altitude, which was calibrated before that, shows which of the two is right. So a barometer that fails is
/// flagged.
#[test]
fn a_wrong_climb_rate_hides_no_failure_from_two_sensors() {
    for step_m in [20.0, -20.0] {
        let (seen, _) = flown(&config(true), |time_s, input| {
            if let (true, Some(fix)) = (time_s > 0.5, &mut input.gps) {
                fix.velocity_down_mps = fix.velocity_down_mps.map(|down_mps| down_mps - 3.0);
            }
            if time_s > 7.0 {
                add_to_baro(input, step_m);
            }
        });
        let [slave, baro] = seen.flags_s;
        assert_eq!(slave, [None; 2], "{step_m}");
        assert!(baro[1].is_some_and(|flag_s| (8.0..9.0).contains(&flag_s)), "{step_m}: {baro:?}");
    }
}

/// An altitude that leaves its climb rate before the launch, as with a converging receiver: a sensor that
/// followed it is no witness against one that did not, and no sensor is blamed.
#[test]
fn what_was_calibrated_while_the_receiver_contradicted_itself_is_no_witness() {
    let (seen, _) = flown(&config(true), |time_s, input| {
        let left_m = (4.0 * (time_s + 5.0)).clamp(0.0, 20.0);
        add_to_fix(input, left_m);
        input.imu_slave_altitude_m = input.imu_slave_altitude_m.map(|altitude_m| altitude_m + left_m);
    });
    assert_eq!([seen.flags_s[0][1], seen.flags_s[1][1]], [None; 2]);
}

/// A receiver that went off so slowly that it was accepted comes back at once: altitude and climb rate agree
/// again, so it is the reference, and a barometer that fails then is flagged. One that leaps to the other
/// side is refused, and no sensor is blamed.
#[test]
fn a_fix_that_brings_altitude_and_climb_rate_together_again_is_good() {
    for (back_to_m, is_good) in [(0.0, true), (-15.0, false)] {
        let (seen, counters) = flown(&config(true), |time_s, input| {
            let off_m = if time_s < 7.0 { 5.0 * (time_s - 1.0).clamp(0.0, 3.0) } else { back_to_m };
            add_to_fix(input, off_m);
            if is_good && time_s > 7.5 {
                add_to_baro(input, 25.0);
            }
        });
        assert_eq!(seen.flags_s[0][1], None, "{back_to_m}");
        assert_eq!(counters.gps.gated == 0, is_good, "{back_to_m}: {}", counters.gps.gated);
        let is_flagged = seen.flags_s[1][1].is_some_and(|flag_s| (8.7..9.1).contains(&flag_s));
        assert_eq!(is_flagged, is_good, "{back_to_m}: {:?}", seen.flags_s[1]);
    }
}

/// A receiver that was lost and came back elsewhere: the size of its error is unknown. A barometer that fails
/// then brings no blame on the healthy sensor.
#[test]
fn a_reference_that_may_be_anywhere_blames_nobody_where_a_sensor_fails_as_well() {
    let (seen, _) = flown(&config(true), |time_s, input| {
        if time_s > -6.0 {
            add_to_fix(input, 48.0);
        }
        if (-6.0..0.5).contains(&time_s) {
            input.gps = None;
        }
        if time_s > 5.0 {
            add_to_baro(input, 25.0);
        }
    });
    assert_eq!(seen.flags_s[0][1], None);
    assert_eq!(seen.at(8.0)[0], Trust::Unmonitored);
}

/// A receiver jumps by 24 m, and both sensors contradict it. While it is refused the inertial altitude drifts
/// to where it is. Once the climb rate, which is not good, can no longer deny the jump, the two are not
/// believed against the barometer.
#[test]
fn an_altitude_that_drifts_to_a_receiver_that_is_refused_is_no_witness_when_it_is_taken_again() {
    let mut config = config(true);
    config.reference.climb_rate = Some(ClimbRate { sigma_mps: 1.0, correlation_time_s: 2.0 });
    let (seen, counters) = flown(&config, |time_s, input| {
        if time_s > 1.0 {
            add_to_fix(input, 24.0);
        }
        let drift_m = (8.0 * (time_s - 3.2)).clamp(0.0, 20.0);
        input.imu_slave_altitude_m = input.imu_slave_altitude_m.map(|altitude_m| altitude_m + drift_m);
    });
    // It is taken again some 4 s after the jump.
    assert!((10..40).contains(&counters.gps.gated), "{}", counters.gps.gated);
    assert_eq!(seen.flags_s, NO_FLAG);
    assert_eq!(seen.at(9.0), [Trust::Trusted, Trust::Unmonitored]);
}
