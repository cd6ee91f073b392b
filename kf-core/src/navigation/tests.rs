//! Which altitude the mission gets, and which fixes the channel gets.

use super::*;
use crate::input::ImuSample;

const TICK_US: u64 = 5_000;
const G: f32 = 9.806_65;

/// At rest at 1,000 m, an inertial sample each tick, a fix ten times a second.
fn tick(k: u64) -> TickInput {
    let imu = Some(ImuSample { accel_mps2: [0.0, 0.0, -G], gyro_radps: [0.0; 3] });
    let fix = |k: u64| GpsFix { altitude_m: 1_000.0, fix_time_us: Some(k), ..GpsFix::default() };
    TickInput { time_us: k * TICK_US, imu, gps: k.is_multiple_of(20).then(|| fix(k)), ..TickInput::default() }
}

/// Flies for so many seconds; returns the altitudes that the mission would get, with their ticks.
fn fly(seconds: u64, change: impl Fn(u64, &mut TickInput)) -> (InertialAltitude, Vec<(u64, f32)>) {
    let mut navigation = InertialAltitude::new(Config::MEMS);
    let mut said = Vec::new();
    for k in 1..=seconds * 200 {
        let mut input = tick(k);
        change(k, &mut input);
        navigation.tick(&mut input);
        said.extend(input.imu_slave_altitude_m.map(|altitude_m| (k, altitude_m)));
    }
    (navigation, said)
}

#[test]
fn an_aligned_channel_speaks_twenty_times_a_second() {
    let (navigation, said) = fly(60, |k, input| input.launch = k >= 8_000);
    assert_eq!(navigation.source(), AltitudeSource::Channel);
    // From 20 s after the first fix on.
    let (first, _) = said[0];
    assert!((4_000..4_200).contains(&first), "{first}");
    assert!(said.windows(2).all(|pair| pair[1].0 - pair[0].0 == 10));
    assert!(said.iter().all(|(_, altitude_m)| (altitude_m - 1_000.0).abs() < 0.01));
    assert_eq!(navigation.counts().delivered as usize, said.len());
    assert_eq!(
        *navigation.counts(),
        NavigationCounts { delivered: said.len() as u32, ..NavigationCounts::default() }
    );
}

#[test]
fn an_altitude_from_outside_is_left_alone() {
    let (navigation, said) = fly(60, |k, input| {
        if k >= 3_000 && k.is_multiple_of(7) {
            input.imu_slave_altitude_m = Some(k as f32);
        }
    });
    assert_eq!(navigation.source(), AltitudeSource::Outside);
    assert!(said.iter().all(|(k, altitude_m)| *altitude_m == *k as f32 && k.is_multiple_of(7)));
    assert_eq!((said.len(), *navigation.counts()), (12_000 / 7 - 2_999 / 7, NavigationCounts::default()));
}

#[test]
fn one_that_comes_after_the_channel_spoke_is_counted_and_not_used() {
    let (navigation, said) = fly(60, |k, input| {
        if k >= 6_000 {
            input.imu_slave_altitude_m = Some(-5.0);
        }
    });
    assert_eq!(navigation.source(), AltitudeSource::Channel);
    assert!(said.iter().all(|(_, altitude_m)| (altitude_m - 1_000.0).abs() < 0.01));
    assert_eq!(navigation.counts().outside_ignored, 6_001);
}

/// From the first suspicion on the reference has no effect; a withdrawn suspicion ends this.
#[test]
fn what_comes_after_the_first_edge_moves_nothing() {
    let moved = |from: u64, to: u64| {
        move |k: u64, input: &mut TickInput| {
            if let (true, Some(fix)) = ((from..to).contains(&k), &mut input.gps) {
                fix.altitude_m = 1_100.0;
            }
        }
    };
    let at_once = fly(60, |k, input| {
        moved(8_000, 12_001)(k, input);
        input.launch = k >= 8_000;
    });
    let later = fly(60, |k, input| {
        moved(8_000, 12_001)(k, input);
        // Falls back, as a wire may: it is still a launch.
        input.launch = k == 8_600;
        if (8_000..8_600).contains(&k) {
            input.launch_doubt = LaunchDoubt::Suspected;
        }
    });
    assert_eq!(at_once.1, later.1);
    assert!(later.1.iter().all(|(_, altitude_m)| (altitude_m - 1_000.0).abs() < 0.01));
    let none = fly(60, |k, input| {
        moved(8_000, 8_600)(k, input);
        if (8_000..8_600).contains(&k) {
            input.launch_doubt = LaunchDoubt::Suspected;
        }
    });
    assert!(none.1.iter().all(|(_, altitude_m)| (altitude_m - 1_000.0).abs() < 0.01));
    // And afterwards it is tied again.
    let tied = fly(200, |k, input| {
        moved(8_600, 40_001)(k, input);
        if (8_000..8_600).contains(&k) {
            input.launch_doubt = LaunchDoubt::Suspected;
        }
    });
    assert!((tied.1.last().unwrap().1 - 1_100.0).abs() < 0.5, "{:?}", tied.1.last());
}

/// A receiver that holds its last fix has measured only once.
#[test]
fn a_held_fix_is_one_and_a_bad_one_is_counted() {
    let (navigation, said) = fly(60, |k, input| {
        if let (true, Some(fix)) = (k > 100, &mut input.gps) {
            fix.fix_time_us = Some(100);
        }
    });
    assert_eq!((navigation.source(), said.len()), (AltitudeSource::None, 0));
    let (navigation, _) = fly(30, |k, input| {
        if let (true, Some(fix)) = (k == 2_000, &mut input.gps) {
            fix.altitude_m = f32::NAN;
        }
        if let (true, Some(fix)) = (k == 2_020, &mut input.gps) {
            fix.velocity_north_mps = Some(f32::NAN);
            fix.velocity_east_mps = Some(0.0);
        }
    });
    assert_eq!(navigation.counts().fixes_refused, 2);
}

/// A unit that reads free fall in captive flight: none of its altitudes may be calibrated. Once it has
/// contradicted the fixes' climb rates for longer than a transient lasts, it is tied to them again, and is
/// right before the launch.
#[test]
fn a_unit_that_falls_by_itself_says_nothing_until_it_is_tied_anew() {
    let (_, said) = fly(60, |k, input| {
        if let Some(fix) = &mut input.gps {
            fix.velocity_down_mps = Some(0.0);
        }
        if let (8_000..8_400, Some(imu)) = (k, &mut input.imu) {
            imu.accel_mps2[2] += G;
        }
        input.launch = k >= 9_400;
    });
    // The error that the tie has learned from the fall, 0.02 m/s^2, is 1.7 m at the end of free flight.
    let limit_m = |k| if k < 9_400 { 1.0 } else { 2.5 };
    assert!(said.iter().all(|(k, altitude_m)| (altitude_m - 1_000.0).abs() < limit_m(*k)), "{said:?}");
    let before = said.iter().rfind(|(k, _)| *k < 8_400).unwrap();
    let after = said.iter().find(|(k, _)| *k >= 8_400).unwrap();
    assert!((8_000..8_120).contains(&before.0) && (8_400..9_200).contains(&after.0), "{before:?} {after:?}");
    assert!(said.iter().any(|(k, _)| *k >= 10_000));
}

/// The same while the tie has only begun: what it has learned from the fall is no accelerometer bias.
#[test]
fn a_unit_that_falls_while_it_aligns_begins_anew() {
    let (navigation, said) = fly(60, |k, input| {
        if let Some(fix) = &mut input.gps {
            fix.velocity_down_mps = Some(0.0);
        }
        if let (700..1_100, Some(imu)) = (k, &mut input.imu) {
            imu.accel_mps2[2] += G;
        }
    });
    assert!(said.iter().all(|(_, altitude_m)| (altitude_m - 1_000.0).abs() < 1.5), "{said:?}");
    assert!((1_100 + 2_000..7_000).contains(&said[0].0), "{:?}", said[0]);
    assert!(navigation.channel().lacking_acceleration_mps2().abs() < 0.02);
}

/// A receiver whose climb rate is wrong for a second causes no new tie.
#[test]
fn a_climb_rate_that_is_wrong_for_a_second_costs_that_second() {
    let (_, said) = fly(60, |k, input| {
        if let Some(fix) = &mut input.gps {
            fix.velocity_down_mps = Some(if (8_000..8_200).contains(&k) { 8.0 } else { 0.0 });
        }
    });
    assert!(said.iter().all(|(_, altitude_m)| (altitude_m - 1_000.0).abs() < 0.5));
    let gap = said.windows(2).map(|pair| pair[1].0 - pair[0].0).max().unwrap();
    assert!((180..230).contains(&gap), "{gap}");
}

/// A unit that has stopped: level and altitude are found again. An ideal one at rest also repeats itself, as
/// long as its velocities agree.
#[test]
fn a_unit_that_stood_still_begins_anew() {
    let first_after = |has_noise: bool, turns: bool| {
        let (_, said) = fly(60, |k, input| {
            let is_stuck = (6_000..7_800).contains(&k);
            if let Some(imu) = &mut input.imu {
                let is_still = is_stuck || (k < 7_800 && !has_noise);
                imu.accel_mps2[2] += if is_still || k.is_multiple_of(2) { 0.01 } else { -0.01 };
            }
            if let Some(fix) = &mut input.gps {
                let seconds = if is_stuck && turns { (k - 6_000) as f32 * 0.005 } else { 0.0 };
                fix.velocity_north_mps = Some(30.0);
                fix.velocity_east_mps = Some(1.5 * seconds);
                fix.velocity_down_mps = Some(0.0);
            }
        });
        said.into_iter().find(|(k, _)| *k > 7_801).unwrap().0
    };
    assert!((7_800..7_820).contains(&first_after(false, false)));
    for (has_noise, turns) in [(false, true), (true, false), (true, true)] {
        let first = first_after(has_noise, turns);
        assert!((7_800 + 4_000..7_800 + 5_000).contains(&first), "{has_noise} {turns}: {first}");
    }
}

/// A unit that repeats itself for 0.45 s in a release of 0.4 g costs 2 m/s, which no altitude can remove
/// before the first climb rate of a fix is taken.
#[test]
fn a_part_of_the_release_that_nobody_measured_is_mended_by_the_climb_rates() {
    let released_s = 40.0;
    let climbed = |time_s: f64| {
        let falling_s = (time_s - released_s).clamp(0.0, 0.5);
        let after_s = (time_s - released_s - 0.5).max(0.0);
        let speed_mps = -0.6 * f64::from(G) * falling_s;
        (0.5 * speed_mps * falling_s + speed_mps * after_s, speed_mps)
    };
    let (_, altitudes) = fly(60, |k, input| {
        let time_s = k as f64 * 0.005;
        input.launch = time_s >= released_s;
        let (climbed_m, climb_mps) = climbed(time_s);
        let is_frozen = (released_s - 0.1..released_s + 0.35).contains(&time_s);
        let is_falling = (released_s..released_s + 0.5).contains(&time_s);
        if let Some(imu) = &mut input.imu {
            imu.accel_mps2 = match (is_frozen, is_falling) {
                (true, _) => [0.0, 0.0, -G],
                (false, true) => [0.0, 0.0, -0.4 * G],
                (false, false) => imu.accel_mps2,
            };
            imu.accel_mps2[1] = if is_frozen || k % 2 == 0 { 0.0 } else { 0.01 };
        }
        if let Some(fix) = &mut input.gps {
            fix.altitude_m += climbed_m as f32;
            fix.velocity_down_mps = Some(-climb_mps as f32);
        }
    });
    for (k, altitude_m) in altitudes.iter().filter(|(k, _)| *k as f64 * 0.005 > released_s + 3.0) {
        let truth_m = 1_000.0 + climbed(*k as f64 * 0.005).0;
        assert!((f64::from(*altitude_m) - truth_m).abs() < 3.0, "{k}: {altitude_m} {truth_m}");
    }
}
