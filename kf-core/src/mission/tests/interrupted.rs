//! A launch that is interrupted before, at and after its confirmation.

use super::*;
use crate::quality::Check;
use crate::snapshot::{MAX_SNAPSHOT_BYTES, MissionMark, SnapshotError, Stage};

type Dense = Mission<0, 4, 0>;
const BARO: usize = 2;

/// The first edge, and the confirmation four ticks later, as set by the debounce.
const EDGE: u64 = 6_000;
const CONFIRMED: u64 = EDGE + 4;

/// A flight with a wire that bounces in captive flight, and a launch that only the wire shows.
fn ticks() -> Vec<TickInput> {
    let mut flight = Flight { seed: 7, noise: 1.0 };
    (0..8_000)
        .map(|k| {
            let mut input = flight.tick(k);
            input.launch = k >= CONFIRMED;
            input.launch_doubt = match k {
                3_000..3_003 | EDGE..CONFIRMED => LaunchDoubt::Suspected,
                CONFIRMED.. => LaunchDoubt::Unconfirmed,
                _ => LaunchDoubt::None,
            };
            input
        })
        .collect()
}

/// The stored bytes.
fn kept(mission: &Dense) -> Vec<u8> {
    let mut bytes = [0; MAX_SNAPSHOT_BYTES];
    let length = mission.snapshot().unwrap().to_bytes(&mut bytes).unwrap();
    bytes[..length].to_vec()
}

/// A mission after this many ticks.
fn after(ticks: &[TickInput]) -> Dense {
    let mut mission = Dense::new(&config(true)).unwrap();
    for input in ticks {
        mission.tick(input);
    }
    mission
}

fn restored(snapshot: &[u8], mark: &MissionMark) -> Result<Dense, SnapshotError> {
    let mut mission = Dense::new(&config(true)).unwrap();
    mission.restore_snapshot(snapshot, mark)?;
    Ok(mission)
}

#[test]
fn the_mark_says_how_far_the_launch_had_come() {
    let ticks = ticks();
    let mut mission = Dense::new(&config(true)).unwrap();
    for (k, input) in (0..).zip(&ticks) {
        mission.tick(input);
        let MissionMark { stage, suspicions, failed_checks, .. } = mission.mark();
        let expected = match k {
            // For 20 ms it may have been a bounce of parting contacts.
            3_000..3_007 | EDGE..CONFIRMED => Stage::Suspected,
            CONFIRMED.. => Stage::Launched,
            _ => Stage::Captive,
        };
        assert_eq!((stage, suspicions), (expected, u8::from(k >= 3_007)), "tick {k}");
        let is_held = stage != Stage::Captive && !(3_003..3_007).contains(&k);
        assert_eq!(mission.snapshot().is_some(), is_held, "tick {k}");
        let confirmed = FailedChecks::from_bits(failed_checks).contains(Check::LaunchConfirmed);
        assert_eq!(confirmed, stage == Stage::Launched, "tick {k}");
    }
}

/// The calibration held before the confirmation, plus the mark of the confirming tick, equals the latch to
/// the bit. Monitoring from then on equals that of an uninterrupted flight, except for the readings in
/// between.
#[test]
fn a_snapshot_from_before_the_confirmation_and_the_mark_after_it_are_the_launched_mission() {
    let ticks = ticks();
    let held = after(&ticks[..EDGE as usize + 1]);
    let whole = after(&ticks[..CONFIRMED as usize + 1]);
    let latch = whole.latch().unwrap();
    assert!(FailedChecks::from_bits(latch.failed_checks).contains(Check::LaunchConfirmed));
    let mut resumed = restored(&kept(&held), &whole.mark()).unwrap();
    assert_eq!(resumed.latch(), Some(latch));
    for input in &ticks[CONFIRMED as usize + 1..] {
        let output = resumed.tick(input);
        assert!(output.phase == Phase::FreeFlight && !output.latched_now);
        // Barometer and the UAV's inertial unit; the mother ship's does not fly free.
        assert!(output.sensors[1..].iter().all(|sensor| sensor.trust == Trust::Trusted));
    }
    let Counters { launch_repeats, launch_suspicions, restarts, .. } = *resumed.counters();
    assert_eq!((launch_repeats, launch_suspicions, restarts), (0, 1, 1));
}

/// The statistical checks take three ticks after the first edge. A check that was not evaluated by then has
/// failed, because there is no data left to evaluate it with.
#[test]
fn a_suspicion_goes_on_as_one_and_latches_what_was_held_at_its_first_edge() {
    let ticks = ticks();
    let whole = after(&ticks[..CONFIRMED as usize + 1]);
    let whole = whole.latch().unwrap();
    assert_eq!(
        FailedChecks::from_bits(whole.failed_checks).iter().collect::<Vec<_>>(),
        [Check::LaunchConfirmed]
    );
    let unjudged = [
        Check::TrimmedAltitude,
        Check::TrimmedAirspeed,
        Check::ReferenceConverged,
        Check::BiasesStationary,
        Check::InnovationsPlausible,
        Check::LaunchConfirmed,
    ];
    for judged in 0..4 {
        let interrupted = EDGE as usize + 1 + judged;
        let held = after(&ticks[..interrupted]);
        let mut resumed = restored(&kept(&held), &held.mark()).unwrap();
        assert_eq!((resumed.latch(), resumed.mark().stage), (None, Stage::Suspected));
        for (k, input) in (0..).zip(&ticks).skip(interrupted) {
            let output = resumed.tick(input);
            assert_eq!(output.latched_now, k == CONFIRMED, "tick {k}");
            assert_eq!(output.phase == Phase::FreeFlight, k >= CONFIRMED, "tick {k}");
        }
        let latch = resumed.latch().unwrap();
        let failed: Vec<_> = FailedChecks::from_bits(latch.failed_checks).iter().collect();
        let expected = if judged < 3 { &unjudged[..] } else { &unjudged[5..] };
        assert_eq!(failed, expected, "{judged}");
        assert_eq!(*latch, LatchRecord { failed_checks: latch.failed_checks, ..whole.clone() });
    }
}

/// The filter that had calibrated is gone: after such a suspicion a new calibration begins, which settles
/// first.
#[test]
fn a_suspicion_that_comes_to_nothing_after_a_restart_starts_the_calibration_again() {
    let ticks = ticks();
    let held = after(&ticks[..EDGE as usize + 2]);
    let mut resumed = restored(&kept(&held), &held.mark()).unwrap();
    let settling = (config::<0>(true).settling_s * 200.0) as u64;
    let begun = EDGE + 2;
    for (k, mut input) in (0..).zip(ticks).skip(begun as usize) {
        (input.launch, input.launch_doubt) = (k >= 7_900, LaunchDoubt::None);
        let output = resumed.tick(&input);
        let expected = match k {
            7_900.. => Phase::FreeFlight,
            k if k >= begun + settling => Phase::Calibrating,
            _ => Phase::Settling,
        };
        assert_eq!(output.phase, expected, "tick {k}");
    }
    let latch = resumed.latch().unwrap();
    assert!(
        (latch.duration_s - (7_900 - begun - settling) as f32 * 0.005).abs() < 0.02,
        "{}",
        latch.duration_s
    );
    assert_eq!(resumed.counters().launch_suspicions, 2);
}

#[test]
fn what_was_held_for_another_suspicion_is_refused() {
    let ticks = ticks();
    let bounced = kept(&after(&ticks[..3_001]));
    let mark = after(&ticks[..CONFIRMED as usize + 1]).mark();
    assert_eq!(restored(&bounced, &mark).err(), Some(SnapshotError::OtherLaunch));
    let captive = after(&ticks[..3_000]).mark();
    assert_eq!(restored(&bounced, &captive).err(), Some(SnapshotError::OtherLaunch));
    assert!(restored(&bounced, &after(&ticks[..3_002]).mark()).is_ok());
}

/// The parting contacts bounce, and the supply dips between two bounces.
#[test]
fn what_was_held_at_a_bounce_is_what_a_restart_within_it_goes_on_from() {
    let mut ticks = ticks();
    for (k, input) in (0..).zip(&mut ticks) {
        if k == EDGE + 1 {
            input.launch_doubt = LaunchDoubt::None;
        }
    }
    let held = kept(&after(&ticks[..EDGE as usize + 1]));
    let between = after(&ticks[..EDGE as usize + 2]).mark();
    let mut resumed = restored(&held, &between).unwrap();
    assert_eq!(resumed.mark().stage, Stage::Suspected);
    for input in &ticks[EDGE as usize + 20..] {
        let input = TickInput { launch: true, ..*input };
        assert_eq!(resumed.tick(&input).phase, Phase::FreeFlight);
    }
    let latch = resumed.latch().unwrap().clone();
    assert_eq!(latch.time_us, EDGE * TICK_US);
    assert_eq!(
        resumed.tick(&TickInput { time_us: 41_000_000, ..ticks[7_999] }).sensors[BARO].bias_m,
        latch.sensors[BARO].bias_m
    );
}

/// The supply dips while the second bounce's snapshot is written: only the first one's is available. A bounce
/// of the wire ten seconds ago remains a suspicion of its own.
#[test]
fn bounces_of_one_parting_are_one_suspicion() {
    let mut ticks = ticks();
    for (k, input) in (0..).zip(&mut ticks) {
        if k == EDGE + 1 {
            input.launch_doubt = LaunchDoubt::None;
        }
    }
    let earlier = kept(&after(&ticks[..3_001]));
    let first = kept(&after(&ticks[..EDGE as usize + 1]));
    let second = after(&ticks[..EDGE as usize + 3]);
    assert_eq!(second.counters().launch_suspicions, 1);
    let mut resumed = restored(&first, &second.mark()).unwrap();
    assert_eq!(resumed.mark().stage, Stage::Suspected);
    resumed.tick(&ticks[CONFIRMED as usize]);
    assert_eq!(resumed.latch().unwrap().time_us, EDGE * TICK_US);
    assert_eq!(restored(&earlier, &second.mark()).err(), Some(SnapshotError::OtherLaunch));
}

/// A wire that opens and is found to be broken is no bounce: it raises no suspicion afterwards.
#[test]
fn a_suspicion_that_has_lasted_is_over_when_it_is_taken_back() {
    let mut ticks = ticks();
    for input in &mut ticks[3_000..3_006] {
        input.launch_doubt = LaunchDoubt::Suspected;
    }
    assert_eq!(after(&ticks[..3_006]).mark().stage, Stage::Suspected);
    assert_eq!(after(&ticks[..3_007]).mark().stage, Stage::Captive);
}
