//! Leaps of the clock around a launch.

use super::*;

/// A clock that leaps between the opening of the wire and the last message within the cable's slack, or at
/// any other instant around a launch, neither hides nor causes one, and the launch is dated by the clock
/// after the leap.
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
            // Messages continue while the wire stays open.
            rig.run(5.0, OPEN);
            assert_eq!((rig.state(), rig.detector.wire()), (LaunchState::Captive, WireCondition::Broken));
            assert_eq!(rig.detector.counts().messages_refused, 0);
        }
    }
}

/// A message that came before the clock leapt and is seen after it is still later than the previous one.
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

/// 0.7 s of ticks whose times occur a second time, while the vehicle leaves: the departure is in them. Also
/// back to the start.
#[test]
fn a_clock_that_runs_back_hides_no_launch_and_makes_none() {
    for back_us in [0.7e6 as u64, 10_000_000] {
        let mut rig = Rig::captive();
        rig.leapt_us = rig.leapt_us.wrapping_sub(back_us);
        let launch = rig.run(2.0, RELEASED).unwrap();
        let usual = Rig::captive().run(2.0, RELEASED).unwrap();
        assert_eq!(launch.by, Confirmation::Force, "{back_us}");
        let waited_us = |launch: Launch| launch.confirmed_us - launch.first_edge_us;
        assert_eq!(waited_us(launch), waited_us(usual), "{back_us}: {launch:?}");
        assert_eq!(rig.detector.counts().out_of_order, 1);

        let mut rig = Rig::captive();
        rig.run(1.0, OPEN);
        rig.leapt_us = rig.leapt_us.wrapping_sub(back_us);
        assert_eq!(rig.run(20.0, OPEN), None, "{back_us}: a broken wire");
        assert_eq!(rig.detector.wire(), WireCondition::Broken);
    }
}

#[test]
fn a_time_that_is_repeated_is_a_tick_and_counted() {
    let mut rig = Rig::captive();
    for k in 1..=3 {
        let input = LaunchInput { time_us: rig.now_us(), is_open: Some(false), ..LaunchInput::default() };
        assert_eq!(rig.detector.tick(&input), LaunchState::Captive);
        assert_eq!(rig.detector.counts().out_of_order, k);
    }
}

#[test]
fn messages_of_another_time_are_refused() {
    let mut rig = Rig::captive();
    // Messages from the future, and from before the last.
    for last_message_us in [rig.now_us() + 1_000_000, 0] {
        rig.last_message_us = Some(last_message_us);
        rig.step(Now { is_sending: false, ..CAPTIVE });
    }
    assert_eq!(rig.detector.counts().messages_refused, 2);
}
