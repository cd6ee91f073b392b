//! Gaps of free flight that fixes mend, and channels that a restart continues.

use super::*;
use crate::strapdown::bridge;
use crate::strapdown::kept::KeptChannel;

fn resumed(kept: &KeptChannel, unknown_s: f32) -> Option<VerticalChannel> {
    let mut channel = VerticalChannel::new(Config::MEMS);
    channel.resume(kept, unknown_s).then_some(channel)
}

fn rest() -> ImuSample {
    sample([0.0, 0.0, -G], [0.0; 3])
}

/// A channel in free flight after a gap of a second, with a climb rate that has since been off by this much.
fn after_gap(off_mps: f32) -> Rig {
    let mut rig = Rig::captive(60);
    rig.channel.launch();
    rig.tick += 199;
    rig.step(&rest());
    rig.channel.climb_rate.add(off_mps);
    rig
}

/// Continues at rest at 1,000 m with ten fixes a second, of this altitude.
fn fly(rig: &mut Rig, seconds: u64, fix_m: impl Fn(u64) -> Option<f32>) -> u32 {
    let mut taken = 0;
    for tick in 0..seconds * SECOND {
        rig.step(&rest());
        if let (true, Some(altitude_m)) = (tick.is_multiple_of(20), fix_m(tick)) {
            taken += u32::from(rig.channel.reference(rig.time_us(), altitude_m).is_ok());
        }
    }
    taken
}

#[test]
fn a_gap_of_a_second_is_mended_within_half_a_minute() {
    for off_mps in [-2.5, -1.3, 0.0, 1.3, 2.5] {
        let mut rig = after_gap(off_mps);
        assert!(rig.channel.is_mending() && rig.channel.altitude_m().is_some());
        let taken = fly(&mut rig, 40, |_| Some(1_000.0));
        // Until the remaining error is a unit's normal drift, and no longer: the channel must be monitored.
        assert!((100..300).contains(&taken) && !rig.channel.is_mending(), "{off_mps}: {taken}");
        let climb_mps = rig.channel.climb_rate.value();
        assert!(climb_mps.abs() < 3.0 * 0.5, "{off_mps}: {climb_mps}");
        assert!((rig.channel.altitude.value() - 1_000.0).abs() < 20.0 * 0.5);
    }
}

/// A receiver that measures its climb rate mends a gap at any fix rate, and is trusted no further than the
/// possible cost of the gap.
#[test]
fn a_gap_that_a_measured_climb_rate_mends_leaves_less_of_it() {
    for ticks_of_a_fix in [20, 40, 200, 280] {
        for off_mps in [-2.5, 0.0, 2.5] {
            let mut rig = after_gap(off_mps);
            let mut fixes = 0;
            while rig.channel.is_mending() && fixes < 1_000 {
                (0..ticks_of_a_fix).for_each(|_| rig.step(&rest()));
                rig.channel.reference(rig.time_us(), 1_000.0).unwrap();
                rig.channel.climb_rate_fix(rig.time_us(), 0.0).unwrap();
                fixes += 1;
            }
            // One measures to 0.25 (m/s)^2: from an unknown climb rate, twelve reduce it to 0.02.
            let seconds = fixes * ticks_of_a_fix / SECOND;
            assert!(fixes >= 12 && seconds <= 60, "{off_mps} at {ticks_of_a_fix}: {fixes} in {seconds} s");
            let climb_mps = rig.channel.climb_rate.value();
            assert!(climb_mps.abs() < 3.0 * 0.14, "{off_mps} at {ticks_of_a_fix}: {climb_mps}");
            assert_eq!(rig.channel.climb_rate_fix(rig.time_us(), 0.0), Err(StrapdownError::Launched));
        }
    }
    let mut rig = after_gap(0.0);
    rig.step(&rest());
    let before = rig.channel.clone();
    assert_eq!(rig.channel.climb_rate_fix(rig.time_us(), 0.0), Err(StrapdownError::OutOfOrder));
    assert_eq!(rig.channel.climb_rate_fix(rig.time_us(), f32::NAN), Err(StrapdownError::NotFinite));
    assert_eq!(rig.channel.climb_rate.value(), before.climb_rate.value());
    rig.channel.reference(rig.time_us(), 1_000.0).unwrap();
    let climb_mps = rig.channel.climb_rate.value();
    assert_eq!(rig.channel.climb_rate_fix(rig.time_us(), 40.0), Err(StrapdownError::Outlier));
    assert_eq!(rig.channel.climb_rate.value(), climb_mps);
}

/// The level error of a gap remains when its climb rate has been mended: in a turn the lacking acceleration
/// is some hundredths of a metre a second squared, and after half a minute the altitude would be at its alarm
/// limit, or hide a failure within it.
#[test]
fn what_a_level_that_is_off_lacks_is_mended_too() {
    for lacking_mps2 in [-0.08, 0.08] {
        for has_climb in [false, true] {
            let mut rig = after_gap(0.5);
            let reading = sample([0.0, 0.0, -G + lacking_mps2], [0.0; 3]);
            let mut ticks = 0;
            while rig.channel.is_mending() && ticks < 60 * SECOND {
                (0..20).for_each(|_| rig.step(&reading));
                ticks += 20;
                rig.channel.reference(rig.time_us(), 1_000.0).unwrap();
                if has_climb && rig.channel.is_mending() {
                    rig.channel.climb_rate_fix(rig.time_us(), 0.0).unwrap();
                }
            }
            assert!(ticks < 40 * SECOND, "{lacking_mps2}, {has_climb}: {ticks}");
            (0..30 * SECOND).for_each(|_| rig.step(&reading));
            // 36 m without mending the level; with it two sigmas of the possible remainder: 0.017 m/s^2, and
            // the climb rate's 0.14 or 0.5 m/s.
            let error_m = rig.channel.altitude.value() - 1_000.0;
            let left_m = if has_climb { 17.0 } else { 34.0 };
            assert!(error_m.abs() < left_m, "{lacking_mps2}, {has_climb}: {error_m} m after {ticks} ticks");
        }
    }
}

/// A second gap while the first is being mended, and no fix for a while: the next fix's climb rate is taken
/// before its altitude can end the mending. The same holds after a restart that continues a channel that was
/// being mended.
#[test]
fn after_every_gap_the_next_climb_rate_is_waited_for() {
    for is_restarted in [false, true] {
        let mut rig = after_gap(0.5);
        for _ in 0..5 {
            (0..20).for_each(|_| rig.step(&rest()));
            rig.channel.reference(rig.time_us(), 1_000.0).unwrap();
            rig.channel.climb_rate_fix(rig.time_us(), 0.0).unwrap();
        }
        (0..280).for_each(|_| rig.step(&rest()));
        rig.tick += 39;
        if is_restarted {
            let kept = rig.channel.kept().unwrap();
            rig.channel = resumed(&kept, 0.0).unwrap();
        }
        rig.step(&rest());
        rig.channel.reference(rig.time_us(), 1_000.0).unwrap();
        assert!(rig.channel.is_mending(), "{is_restarted}");
        assert_eq!(rig.channel.climb_rate_fix(rig.time_us(), 0.0), Ok(()));
    }
}

/// A restart without lost time is not a gap, and the restored channel has no earlier climb rate: it still
/// waits for the next one.
#[test]
fn a_restart_without_a_gap_waits_for_the_next_climb_rate() {
    let mut rig = after_gap(0.5);
    while rig.channel.tie.climb_m2ps2() > bridge::MENDED_M2PS2 / 2.0 {
        (0..20).for_each(|_| rig.step(&rest()));
        rig.channel.reference(rig.time_us(), 1_000.0).unwrap();
        rig.channel.climb_rate_fix(rig.time_us(), 0.0).unwrap();
    }
    assert!(rig.channel.is_mending());
    rig.channel = resumed(&rig.channel.kept().unwrap(), 0.0).unwrap();
    (0..20).for_each(|_| rig.step(&rest()));
    rig.channel.reference(rig.time_us(), 1_000.0).unwrap();
    assert!(rig.channel.is_mending());
    assert_eq!(rig.channel.climb_rate_fix(rig.time_us(), 0.0), Ok(()));
}

#[test]
fn without_fixes_it_says_what_it_has_until_that_is_nothing() {
    let mut rig = after_gap(0.0);
    let mut said = 0;
    while rig.channel.altitude_m().is_some() {
        rig.step(&rest());
        said += 1;
    }
    // 5 m, with a climb rate known to 1.3 m/s and a level known to ten degrees.
    assert!((2 * SECOND..6 * SECOND).contains(&said), "{said}");
    // It gives an altitude again with the first fixes.
    fly(&mut rig, 10, |_| Some(1_000.0));
    assert!(rig.channel.altitude_m().is_some());
}

/// In free flight the channel and the reference are a check on each other.
#[test]
fn a_receiver_that_has_jumped_mends_nothing() {
    let mut rig = after_gap(0.0);
    let altitude_m = rig.channel.altitude.value();
    let taken = fly(&mut rig, 3, |_| Some(1_100.0));
    assert_eq!(taken, 0);
    assert!((rig.channel.altitude.value() - altitude_m).abs() < 0.1);
}

/// A gap that ends just before the launch is mended after it; one that the reference had time to mend in
/// captive flight is not.
#[test]
fn a_gap_that_the_launch_leaves_no_time_to_mend_is_mended_after_it() {
    for (captive_s, is_mended_later) in [(0, true), (1, true), (60, false)] {
        let mut rig = Rig::captive(60);
        rig.tick += 199;
        rig.step(&rest());
        rig.channel.climb_rate.add(1.5);
        fly(&mut rig, captive_s, |_| Some(1_000.0));
        rig.channel.hold();
        assert_eq!(rig.channel.is_mending(), is_mended_later, "{captive_s} s");
        // The suspicion is withdrawn, and then there is a launch.
        rig.channel.resume_captive();
        rig.channel.launch();
        assert_eq!(rig.channel.is_mending(), is_mended_later, "{captive_s} s");
        let mut fixes = 0;
        while rig.channel.is_mending() && fixes < 1_000 {
            (0..40).for_each(|_| rig.step(&rest()));
            rig.channel.reference(rig.time_us(), 1_000.0).unwrap();
            rig.channel.climb_rate_fix(rig.time_us(), 0.0).unwrap();
            fixes += 1;
        }
        let climb_mps = rig.channel.climb_rate.value();
        assert!(
            fixes < 300 && climb_mps.abs() < 3.0 * 0.14,
            "{captive_s} s: {climb_mps} after {fixes} fixes"
        );
    }
}

#[test]
fn without_a_gap_nothing_is_mended() {
    let mut rig = Rig::captive(60);
    rig.channel.launch();
    assert_eq!(rig.channel.reference(rig.time_us() + 1, 1_000.0), Err(StrapdownError::Launched));
    assert_eq!(fly(&mut rig, 10, |_| Some(1_010.0)), 0);
    assert!((rig.channel.altitude.value() - 1_000.0).abs() < 0.1);
}

/// A stored channel continues as if uninterrupted: the same altitude, at every sample.
#[test]
fn a_channel_that_is_kept_goes_on() {
    let mut whole = Rig::captive(60);
    assert_eq!(whole.channel.kept(), None);
    whole.channel.launch();
    let reading = sample([0.3, -0.1, -G + 0.02], [0.01, -0.02, 0.03]);
    for _ in 0..10 * SECOND {
        whole.step(&reading);
    }
    let mut bytes = [0; 160];
    let bytes = postcard::to_slice(&whole.channel.kept(), &mut bytes).unwrap();
    let kept: Option<KeptChannel> = postcard::from_bytes(bytes).unwrap();
    let channel = resumed(&kept.unwrap(), 0.0).unwrap();
    let mut resumed = Rig { channel, tick: whole.tick };
    for _ in 0..10 * SECOND {
        whole.step(&reading);
        resumed.step(&reading);
        let altitudes = [&whole, &resumed].map(|rig| rig.channel.altitude_m().unwrap());
        // The rounding errors of its direction's sums are not stored: some last bits.
        assert!((altitudes[0] - altitudes[1]).abs() < 1e-3, "{altitudes:?}");
    }
}

/// A dip of the supply: the clock stands still for an unknown time.
#[test]
fn an_interruption_of_unknown_length_costs_the_altitude_until_the_next_fix() {
    let mut rig = Rig::captive(60);
    rig.channel.launch();
    rig.channel.climb_rate.add(-20.0);
    let kept = rig.channel.kept().unwrap();
    rig.channel = resumed(&kept, 1.0).unwrap();
    let altitude_m = rig.channel.altitude.value();
    rig.step(&rest());
    assert_eq!(rig.channel.altitude_m(), None);
    // In fact 0.6 s have passed: 12 m.
    let mut fallen_m = 12.0;
    for tick in 0..5 * SECOND {
        rig.step(&rest());
        fallen_m += 20.0 * 0.005;
        if tick.is_multiple_of(20) {
            rig.channel.reference(rig.time_us(), altitude_m - fallen_m).unwrap();
            assert!(rig.channel.altitude_m().is_some(), "{tick}: {:?}", rig.channel.tie);
        }
    }
    let error_m = rig.channel.altitude.value() - (altitude_m - fallen_m);
    assert!(error_m.abs() < 1.0, "{error_m}");
}

/// An altitude that was 90 m off before the interruption is still off after it, and no fix mends it: one fix
/// that contradicts it is enough to publish it, as it was published before.
#[test]
fn an_altitude_that_was_far_off_before_an_interruption_goes_on_saying_so() {
    let mut rig = Rig::captive(60);
    rig.channel.launch();
    rig.channel.climb_rate.add(-10.0);
    rig.channel.altitude.add(90.0);
    let kept = rig.channel.kept().unwrap();
    rig.channel = resumed(&kept, 1.0).unwrap();
    for fix in 0..100 {
        (0..20).for_each(|_| rig.step(&rest()));
        let truth_m = rig.channel.altitude.value() - 90.0;
        assert_eq!(rig.channel.altitude_m().is_some(), fix > 0, "{fix}");
        assert_eq!(rig.channel.reference(rig.time_us(), truth_m), Err(StrapdownError::Outlier));
        let _ = rig.channel.climb_rate_fix(rig.time_us(), -10.0);
    }
}

#[test]
fn a_suspicion_that_was_none_begins_anew_after_a_restart() {
    let mut rig = Rig::captive(60);
    rig.channel.hold();
    let kept = rig.channel.kept().unwrap();
    let mut restarted = resumed(&kept, 0.0).unwrap();
    restarted.resume_captive();
    assert!(!restarted.is_aligned() && restarted.down_body().is_none());
}

#[test]
fn a_copy_with_a_number_that_is_none_is_refused() {
    let mut rig = Rig::captive(60);
    rig.channel.launch();
    rig.channel.altitude = Sum::new(f32::NAN);
    assert_eq!(resumed(&rig.channel.kept().unwrap(), 0.0), None);
}
