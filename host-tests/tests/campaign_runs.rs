//! Runs of the fault campaign that revealed defects, now fixed: from the chips' registers, lines and wires to
//! the latch, flags and telemetry. docs/fault-campaign.md explains what each revealed.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use host_tests::campaign::judge::judge;
use host_tests::campaign::run::{Case, config};

fn violations(seed: u64, index: u64) -> Vec<String> {
    let case = Case::draw(seed, index, false);
    let flown = case.fly(seed, &config().unwrap()).unwrap();
    // A fault that is not flown cannot break anything.
    assert!(!case.faults.is_empty() && flown.clean.ticks != flown.faulty.ticks, "{seed}: {index}");
    judge(&case, &flown).violations.iter().map(|violation| violation.what.clone()).collect()
}

fn assert_no_violation(runs: &[(u64, u64)]) {
    for (seed, index) in runs {
        assert_eq!(violations(*seed, *index), [""; 0], "{seed}: {index}");
    }
}

/// The supply dips at the launch. Three quarters of a minute later a unit's altitude is 5 m too high, the
/// barometer 2 m, and the receiver 3 m too low. How far the receiver explains the two must not depend on what
/// the dip has left of its climb rate.
#[test]
fn a_dip_at_the_launch_keeps_no_sensor_from_its_flag() {
    assert_eq!(violations(7010, 1971), [""; 0]);
}

/// A receiver converges by 16 m while an integrated altitude is 3 m off in the same direction.
#[test]
fn a_receiver_that_converges_blames_no_sensor() {
    assert_eq!(violations(7010, 3008), [""; 0]);
}

/// A receiver jumps by 11 m at the release, is accepted for a long time, and comes back; meanwhile a
/// barometer drifts.
#[test]
fn a_receiver_that_comes_back_from_a_jump_flags_the_barometer() {
    assert_eq!(violations(7008, 1157), [""; 0]);
}

/// An inertial unit is saturated for a second, half a second before the release.
#[test]
fn a_unit_that_is_saturated_before_the_release_keeps_no_barometer_from_its_flag() {
    assert_eq!(violations(7008, 1940), [""; 0]);
}

/// The supply dips in flight, the wire breaks half a second after the start, and two more dips follow: the
/// wire is reported broken before they do.
#[test]
fn a_wire_that_breaks_between_dips_of_the_supply_is_no_launch() {
    assert_eq!(violations(7013, 1227), [""; 0]);
}

/// A receiver converges during the calibration and reports itself accurate: a calibration from its two levels
/// must not be trusted.
#[test]
fn a_calibration_of_two_levels_of_the_receiver_promises_nothing() {
    assert_eq!(violations(7013, 866), [""; 0]);
}

/// An altitude that is 90 m off, and flagged, stays flagged after a dip of the supply.
#[test]
fn an_altitude_that_is_far_off_is_not_silenced_by_a_dip_of_the_supply() {
    assert_eq!(violations(7014, 663), [""; 0]);
}

/// Bits of a force flip for 0.4 s, after fourteen fixes have matched the level: those are not what
/// contradicts it then.
#[test]
fn a_disturbance_of_a_level_that_is_known_does_not_begin_the_alignment_anew() {
    assert_eq!(violations(7013, 836), [""; 0]);
}

/// The supply dips while the hooks open, and again before the release is decided.
#[test]
fn a_release_while_the_supply_dips_is_seen() {
    assert_eq!(violations(7016, 545), [""; 0]);
}

/// The contacts bounce as they part, and the supply dips while the second bounce's snapshot is written.
#[test]
fn a_dip_between_two_bounces_of_the_parting_contacts_keeps_the_calibration() {
    assert_eq!(violations(7020, 1533), [""; 0]);
}

/// One of the receiver's settings flips between its first solution and its second.
#[test]
fn a_receiver_that_falls_silent_after_its_first_solution_is_configured_anew_at_once() {
    assert_eq!(violations(7019, 1395), [""; 0]);
}

/// A receiver jumps by 23 m while the inertial unit is being aligned: biases refer to the level before, and
/// all of the altitude's readings to the one after.
#[test]
fn an_altitude_whose_readings_contradict_its_bias_is_not_blamed() {
    assert_eq!(violations(7018, 1744), [""; 0]);
}

/// A receiver jumps by 3 km, is refused under the pylon until the reference is lost, and is the only
/// reference at the launch.
#[test]
fn a_receiver_that_was_lost_kilometres_off_blames_no_sensor() {
    assert_eq!(violations(7025, 1178), [""; 0]);
}

/// The inertial unit reads free fall from 1.3 s before the wire breaks, which the receiver's climb rate
/// contradicts.
#[test]
fn a_wire_that_breaks_while_the_unit_reads_free_fall_is_no_launch() {
    assert_eq!(violations(7026, 961), [""; 0]);
}

/// The first two fixes are 2.6 km off.
#[test]
fn an_altitude_that_is_tied_to_wild_fixes_is_tied_anew_as_soon_as_others_outlast_them() {
    assert_eq!(violations(7027, 838), [""; 0]);
}

/// A receiver is 10 m off for 0.7 s, just as the settling time ends.
#[test]
fn a_receiver_that_is_off_as_the_calibration_begins_costs_no_sensor() {
    assert_eq!(violations(7033, 22), [""; 0]);
}

/// The inertial unit reads free fall from just before the release on, so its own departure is no evidence of
/// it.
#[test]
fn a_release_while_the_unit_reads_free_fall_is_seen() {
    assert_eq!(violations(7036, 2266), [""; 0]);
}

/// Fixes are 14 m off as the settling time ends: at 5 Hz the last of them restarts the calibration; at 10 Hz
/// they are too few to be a level.
#[test]
fn fixes_that_are_off_as_the_calibration_begins_cost_no_sensor() {
    assert_eq!(violations(7031, 791), [""; 0]);
    assert_eq!(violations(7037, 1306), [""; 0]);
}

/// The inertial unit repeats itself, for 14 s of the calibration and from the first seconds on: an altitude
/// integrated from that must not widen a bound.
#[test]
fn an_altitude_of_a_unit_that_stands_still_is_not_calibrated() {
    assert_eq!(violations(7030, 269), [""; 0]);
    assert_eq!(violations(7031, 2150), [""; 0]);
}

/// The inertial unit repeats itself, or is silent, and the cable tears: two faults that do not support a
/// release, which the receiver's climb rate does not show either.
#[test]
fn a_torn_cable_is_no_launch_when_the_unit_has_died() {
    assert_eq!(violations(7026, 186), [""; 0]);
    assert_eq!(violations(7018, 922), [""; 0]);
}

/// The inertial unit reads twelve g for a fifth of a second as it is switched on: a minute later the level
/// that a departure is judged against has forgotten that.
#[test]
fn wild_samples_at_power_on_hide_no_release() {
    assert_eq!(violations(7044, 1168), [""; 0]);
}

/// The wire is shorted from 0.15 s after the hooks open, for 0.9 s: it has opened once.
#[test]
fn a_wire_that_is_shorted_for_a_moment_after_the_release_hides_none() {
    assert_eq!(violations(7043, 1460), [""; 0]);
}

/// The wire bounces for a second, and the hooks open 1.7 s later.
#[test]
fn a_wire_that_has_bounced_hides_no_release() {
    assert_eq!(violations(7048, 838), [""; 0]);
}

/// The flight computer's clock leaps by 2 s, the receiver's does not; a barometer steps 2.5 s later.
#[test]
fn a_clock_that_leaps_keeps_no_barometer_from_its_flag() {
    assert_eq!(violations(7045, 523), [""; 0]);
}

/// The wire bounces in the release itself and ends open, without messages: it has opened.
#[test]
fn a_wire_that_bounces_in_the_release_does_not_hide_it() {
    assert_eq!(violations(7048, 1318), [""; 0]);
}

/// The cable tears, and 1.9 s later the inertial unit reads a fall that the climb rate does not show.
#[test]
fn a_torn_cable_and_a_false_fall_are_no_launch() {
    assert_eq!(violations(7046, 2351), [""; 0]);
}

/// Bits of a turn rate, or a force, flip for half a second in the first seconds; or the receiver jumps there:
/// the alignment ends when it would have ended anyway.
#[test]
fn a_transient_of_the_first_seconds_does_not_delay_the_alignment() {
    assert_eq!(violations(7051, 815), [""; 0]);
    assert_eq!(violations(7056, 2084), [""; 0]);
    assert_eq!(violations(7056, 1089), [""; 0]);
}

/// A receiver converges from 35 m, is taken again with 12 m left, and the barometer has failed: an integrated
/// altitude that is 3 m off is not blamed for the receiver's 12 m.
#[test]
fn a_receiver_that_is_taken_again_while_it_converges_blames_no_altitude() {
    assert_eq!(violations(7050, 2372), [""; 0]);
}

/// A receiver jumps by 10 m, and both sensors contradict it. Fifteen seconds later the integrated altitude
/// drifts by as much: it is no witness for the receiver.
#[test]
fn an_altitude_that_drifts_to_where_the_receiver_has_jumped_is_no_witness() {
    assert_eq!(violations(7058, 2032), [""; 0]);
}

/// A receiver jumps by 12 m, or converges from 42 m, 22 m or 52 m, and both sensors contradict it. When it is
/// taken again the other sensor has drifted towards it: that is no evidence against the healthy one.
#[test]
fn a_sensor_that_drifts_towards_a_receiver_that_is_refused_is_no_witness() {
    assert_no_violation(&[(7073, 997), (7071, 767), (7072, 127), (7056, 866)]);
}

/// A unit reads free fall from before the release until after it, and then one g again.
#[test]
fn a_unit_that_reads_free_fall_during_the_release_does_not_hide_it() {
    assert_no_violation(&[(7071, 591), (7072, 1646)]);
}

/// A receiver jumps by 16 m soon after the calibration has begun: nothing shows which level is right.
#[test]
fn a_receiver_that_leaves_the_level_of_the_settling_time_makes_no_good_calibration() {
    assert_eq!(violations(7081, 68), [""; 0]);
}

/// A cable tears while a unit is silent, and half a minute later the carrier has swung by 2 m/s: that shows no
/// release.
#[test]
fn a_cable_that_tears_while_the_unit_is_silent_is_no_launch() {
    assert_eq!(violations(7072, 2220), [""; 0]);
}

/// The program crashes between the fall that raises the suspicion and the opening of the wire, and again
/// after that; or the supply dips there: the held calibration is that of the launch.
#[test]
fn a_restart_between_the_fall_and_the_opening_keeps_the_calibration() {
    assert_eq!(violations(7060, 1193), [""; 0]);
    assert_eq!(violations(7036, 2373), [""; 0]);
}

/// The cable tears, and the supply dips once it is known that the force has not departed; in the second run
/// five times.
#[test]
fn a_torn_cable_is_no_launch_when_the_supply_dips_after_it() {
    assert_eq!(violations(7065, 519), [""; 0]);
    assert_eq!(violations(7022, 220), [""; 0]);
}

/// A unit is shaken, before or after the launch, and its last wild sample is just no leap: the calm ones after
/// it are none either.
#[test]
fn a_shaken_unit_is_silent_no_longer_than_it_is_shaken() {
    assert_no_violation(&[(7015, 1668), (7056, 1008), (7064, 337), (7064, 2388)]);
}

/// A receiver's velocity is wrong, or a force, while the level is being found by velocities.
#[test]
fn what_disturbs_a_match_with_velocities_does_not_begin_the_level_anew() {
    assert_no_violation(&[(7061, 1958), (7063, 719)]);
}
