//! Leaps of the clock around a launch.

use super::*;

/// A clock that leaps between the opening of the wire and the last message within the slack of the cable, or
/// at any other instant around a launch, hides none and makes none, and the launch is told by the clock as it
/// is then.
#[test]
fn a_leap_of_the_clock_hides_no_launch_and_is_none() {
    for leap_us in [150_000, 2_000_000, 40_000_000, 1 << 52] {
        for leap_tick in [0, 1, 10, 30, 60, 120] {
            let mut rig = Rig::captive();
            for tick in 0..1_400 {
                rig.leapt_us += if tick == leap_tick { leap_us } else { 0 };
                // The wire parts 0.1 s before the last message.
                let now = Now { is_sending: tick < 20, ..RELEASED };
                rig.step(now);
            }
            let LaunchState::Launched(launch) = rig.state() else {
                panic!("{leap_us} at {leap_tick}: {:?}", rig.state())
            };
            assert!(launch.by == Confirmation::Force && launch.confirmed_us < rig.now_us());
            let suspected_us = launch.confirmed_us - launch.first_edge_us;
            assert!(suspected_us < 2_000_000, "{leap_us} at {leap_tick}: {suspected_us} us");

            let mut rig = Rig::captive();
            for tick in 0..1_400 {
                rig.leapt_us += if tick == leap_tick { leap_us } else { 0 };
                rig.step(Now { is_open: Some(tick < 20), ..CAPTIVE });
            }
            assert_eq!(rig.state(), LaunchState::Captive, "{leap_us} at {leap_tick}");
            // Messages go on, under a wire that stays open.
            rig.run(5.0, OPEN);
            assert_eq!((rig.state(), rig.detector.wire()), (LaunchState::Captive, WireCondition::Broken));
            assert_eq!(rig.detector.counts().messages_refused, 0);
        }
    }
}

/// A message that came before the clock leapt and is seen after it is later than the one before it all the
/// same.
#[test]
fn a_message_from_just_before_a_leap_is_not_refused() {
    let mut rig = Rig::captive();
    let received_us = rig.now_us() + 1;
    assert!(rig.last_message_us.is_some_and(|last_us| last_us < received_us));
    rig.last_message_us = Some(received_us);
    rig.leapt_us += 2_000_000;
    rig.step(Now { is_sending: false, ..CAPTIVE });
    assert_eq!(rig.detector.counts().messages_refused, 0);
}
