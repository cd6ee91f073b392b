//! Gaps between inertial samples, and samples that leap.

use super::*;

fn rest() -> ImuSample {
    sample([0.0, 0.0, -G], [0.0; 3])
}

#[test]
fn a_gap_restarts_the_alignment_and_ends_free_flight() {
    let mut captive = Rig::captive(30);
    assert!(captive.channel.is_aligned());
    captive.tick += 261;
    assert_eq!(captive.channel.inertial(captive.time_us(), &rest()), Err(StrapdownError::Gap));
    assert!(!captive.channel.is_aligned() && captive.channel.altitude_m().is_none());
    captive.step(&rest());

    let mut free = Rig::captive(30);
    free.channel.launch();
    // 1.3 s are bridged.
    free.tick += 259;
    free.step(&rest());
    assert!(free.channel.altitude_m().is_some());
    free.tick += 261;
    assert_eq!(free.channel.inertial(free.time_us(), &rest()), Err(StrapdownError::Gap));
    assert_eq!((free.channel.altitude_m(), free.channel.climb_rate_mps()), (None, None));
    free.tick += 1;
    assert_eq!(free.channel.inertial(free.time_us(), &rest()), Err(StrapdownError::Lost));
}

/// The reset of a unit, 105 ms: neither the alignment nor free flight ends, and its cost is known.
#[test]
fn a_reset_of_the_unit_is_bridged() {
    let mut captive = Rig::captive(60);
    let before = captive.channel.clone();
    captive.tick += 20;
    captive.step(&rest());
    assert_eq!(captive.channel.counts().bridged, 1);
    assert!(captive.channel.is_aligned() && captive.channel.gyro_bias_radps() == before.gyro_bias_radps());
    let cost = captive.channel.tie.climb_m2ps2() - before.tie.climb_m2ps2();
    assert!((0.004..0.008).contains(&cost), "{cost}");

    // In free flight every reset costs as much; once they have cost 0.14 m/s, including the one just before
    // the launch, fixes are needed.
    captive.channel.launch();
    let mut resets = 1;
    while !captive.channel.is_mending() {
        captive.tick += 20;
        captive.step(&rest());
        resets += 1;
    }
    assert!((4..6).contains(&resets), "{resets}");
    assert!(captive.channel.altitude_m().is_some());
    assert!(captive.channel.altitude_variance_m2() > before.altitude_variance_m2());
}

/// The bound that a bridge puts on the climb rate holds for accelerations and vibration of the assumed size.
#[test]
fn what_a_bridge_costs_is_what_it_says() {
    for gap in [20u64, 60, 99, 200] {
        let (mut squares, mut variance) = (0.0, 0.0);
        let mut random = 5u64;
        let mut normal = || {
            (0..12).fold(-6.0, |sum, _| {
                random =
                    random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                sum + (random >> 40) as f64 / (1u64 << 24) as f64
            })
        };
        let runs = 400;
        let start = Rig::captive(30);
        for _ in 0..runs {
            let mut rig = start.clone();
            rig.channel.launch();
            // An acceleration of 2 m/s^2 that wanders within 0.5 s, and vibration of 0.8 m/s^2 in its
            // reading.
            let (mut acceleration, mut climb) = (0.0, 0.0);
            for tick in 0..gap + 1 {
                let last = acceleration;
                if tick > 0 {
                    let kept = (-STEP_S / 0.5f64).exp();
                    acceleration = kept * acceleration + 2.0 * (1.0 - kept * kept).sqrt() * normal();
                    climb += 0.5 * STEP_S * (last + acceleration);
                }
                rig.tick += 1;
                if tick == 0 || tick == gap {
                    let read = acceleration + 0.8 * normal();
                    rig.channel.inertial(rig.time_us(), &sample([0.0, 0.0, -G - read], [0.0; 3])).unwrap();
                }
            }
            // The first interval, of one tick, contains half its vibration alone.
            squares += (f64::from(rig.channel.climb_rate.value()) - climb).powi(2);
            variance = f64::from(rig.channel.bridged_m2ps2);
        }
        let ratio = squares / f64::from(runs) / variance;
        // 400 squares: five times their spread of 7 %; the interval before the gap adds 5 % at 0.1 s, and the
        // walk's return to zero removes up to a third of the longest one.
        assert!((0.55..1.45).contains(&ratio), "{gap}: {ratio}");
    }
}

/// The bound that a bridge puts on the level holds for turn rates of the assumed size: 0.3 rad/s that wanders
/// within 0.5 s.
#[test]
fn what_a_bridge_costs_the_level_is_what_it_says() {
    const STEP_S: f64 = 0.001;
    let mut random = 11u64;
    let mut normal = || {
        (0..12).fold(-6.0, |sum, _| {
            random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            sum + (random >> 40) as f64 / (1u64 << 24) as f64
        })
    };
    let kept = (-STEP_S / 0.5f64).exp();
    for steps in [100u32, 300, 500, 1_000] {
        let gap_s = f64::from(steps) * STEP_S;
        let runs = 400;
        let squares: f64 = (0..runs)
            .map(|_| {
                let first = 0.3 * normal();
                let (mut rate, mut turned) = (first, 0.0);
                for _ in 0..steps {
                    let last = rate;
                    rate = kept * rate + 0.3 * (1.0 - kept * kept).sqrt() * normal();
                    turned += 0.5 * STEP_S * (last + rate);
                }
                (turned - 0.5 * gap_s * (first + rate)).powi(2)
            })
            .sum();
        let ratio = squares / f64::from(runs) / f64::from(BridgeCost::of(gap_s as f32).tilt_rad2);
        // As above: five times the spread of 400 squares, and the walk's return to zero.
        assert!((0.55..1.45).contains(&ratio), "{gap_s}: {ratio}");
    }
}

/// One or two samples with a flipped bit are refused. A change that lasts is the aircraft's.
#[test]
fn a_leap_of_two_samples_is_refused() {
    let leaps = [
        sample([0.0, 0.0, 68.0], [0.0; 3]),
        sample([157.0, 0.0, -G], [0.0; 3]),
        sample([0.0, 0.0, -G], [0.0, 34.9, 0.0]),
        sample([0.0, 0.0, -G], [2.2, 0.0, 0.0]),
    ];
    for leap in leaps {
        for length in [1, 2] {
            let mut rig = Rig::captive(30);
            rig.channel.launch();
            for _ in 0..length {
                rig.tick += 1;
                assert_eq!(rig.channel.inertial(rig.time_us(), &leap), Err(StrapdownError::Spike));
            }
            for _ in 0..30 * SECOND {
                rig.step(&rest());
            }
            let error = rig.channel.altitude_m().unwrap() - 1_000.0;
            assert!(error.abs() < 0.02 && rig.channel.counts().refused == length, "{leap:?} {error}");
        }
    }
    // A release at 6 g: seen from the third sample on; the two before are on the straight line to it.
    let mut rig = Rig::captive(30);
    rig.channel.launch();
    let ejected = sample([0.0, 0.0, 50.0], [0.0; 3]);
    let taken: Vec<_> = (0..4)
        .map(|_| {
            rig.tick += 1;
            rig.channel.inertial(rig.time_us(), &ejected)
        })
        .collect();
    assert_eq!(taken, [Err(StrapdownError::Spike), Err(StrapdownError::Spike), Ok(()), Ok(())]);
}

/// A force whose sign is flipped for a third of a second is no push; and a flipped bit of the gyro is no turn
/// of a carrier.
#[test]
fn a_flipped_bit_that_stays_is_refused_as_long() {
    let flips =
        [(true, sample([0.0, 0.0, 157.0 - G], [0.0; 3])), (false, sample([0.0, 0.0, -G], [0.0, 0.545, 0.0]))];
    for (is_free, flipped) in flips {
        let mut rig = Rig::captive(30);
        if is_free {
            rig.channel.launch();
        }
        for _ in 0..70 {
            rig.tick += 1;
            assert_eq!(rig.channel.inertial(rig.time_us(), &flipped), Err(StrapdownError::Spike));
        }
        rig.step(&rest());
        let down = rig.channel.down_body().unwrap();
        assert!(rig.channel.climb_rate.value().abs() < 0.01 && down[2] > 0.999_99, "{down:?}");
    }
}

/// A unit that repeats itself gives no more information than a gap.
#[test]
fn a_unit_that_repeats_itself_is_mended_like_a_gap() {
    let mut rig = Rig::captive(30);
    rig.channel.launch();
    let noise =
        |tick: u64| sample([0.0, 0.0, if tick.is_multiple_of(2) { 0.01 } else { -0.01 } - G], [0.0; 3]);
    for tick in 0..400 {
        rig.step(&noise(tick));
    }
    assert!(!rig.channel.is_mending());
    for _ in 0..160 {
        rig.step(&noise(0));
    }
    rig.step(&noise(1));
    assert!(rig.channel.is_mending() && rig.channel.altitude_m().is_some());
}

/// A unit that has noise and repeats itself for longer than may be bridged has stopped: it gives no altitude
/// meanwhile and starts again when the readings change. One without noise is ideal and at rest.
#[test]
fn a_unit_with_noise_that_repeats_itself_for_long_has_stopped() {
    let noise =
        |tick: u64| sample([0.0, 0.0, if tick.is_multiple_of(2) { 0.01 } else { -0.01 } - G], [0.0; 3]);
    for has_noise in [true, false] {
        let mut rig = Rig::captive(30);
        if has_noise {
            (0..20).for_each(|tick| rig.step(&noise(tick)));
        }
        for tick in 1..600 {
            rig.step(&noise(0));
            let stands_still = has_noise && tick as f32 * 0.005 > Config::MEMS.longest_gap_s + 0.01;
            if tick as f32 * 0.005 < Config::MEMS.longest_gap_s - 0.01 || stands_still {
                assert_eq!(rig.channel.altitude_m().is_none(), stands_still, "{has_noise} {tick}");
            }
        }
        rig.tick += 1;
        let expected = if has_noise { Err(StrapdownError::Gap) } else { Ok(()) };
        assert_eq!(rig.channel.inertial(rig.time_us(), &noise(1)), expected);
        // The next time that it stops, it is recognised.
        (0..600).for_each(|_| rig.step(&noise(1)));
        assert_eq!(rig.channel.stands_still(), has_noise);
    }
}

/// A unit that has stopped gives no altitude, however often the alignment starts again meanwhile.
#[test]
fn a_unit_that_has_stopped_is_not_aligned_while_it_has() {
    let mut rig = Rig::captive(30);
    let turning =
        |tick: u64| sample([0.0, 1.0, -G], [0.0, 0.0, if tick < 20 { 0.001 * tick as f64 } else { 0.1 }]);
    for tick in 0..30_000 {
        rig.step(&turning(tick));
        assert!(tick < 300 || rig.channel.altitude_m().is_none(), "{tick}");
    }
}

/// A unit that is shaken leaves a wild rate as the last one taken. Neither the next wild one nor the calm
/// ones that contradict it may end the channel, or turn its level by the wild rate over the time between. The
/// calm ones lead back, so they are taken as soon as there are two of them.
#[test]
fn a_wild_rate_before_a_gap_neither_ends_the_channel_nor_turns_it() {
    let turning = |rate: f64| sample([0.0, 0.0, -G], [0.0, rate, 0.0]);
    let mut rig = Rig::captive(30);
    rig.channel.launch();
    for rate in [1.8, 3.6, 5.4] {
        rig.step(&turning(rate));
    }
    rig.tick += 40;
    assert_eq!(rig.channel.inertial(rig.time_us(), &turning(6.0)), Err(StrapdownError::Spike));
    let outcomes = (0..240).map(|_| {
        rig.tick += 1;
        rig.channel.inertial(rig.time_us(), &rest())
    });
    let refused = outcomes.take_while(|outcome| *outcome == Err(StrapdownError::Spike)).count();
    assert_eq!(refused, 1);
    // Its neighbours were used for 15 ms, and 0.04 rad.
    let down = rig.channel.down_body().unwrap();
    assert!(rig.channel.is_mending() && down[2] > 0.05_f32.cos(), "{down:?}");
}

/// Under the pylon a force or a rate that is just no leap is taken, however wrong. What follows leaps from it,
/// but towards rest, so it is taken at once, and the wrong sample moves neither level nor climb rate.
#[test]
fn samples_that_lead_back_to_rest_under_the_pylon_are_no_leaps() {
    let wild = [sample([14.9, 0.0, -G], [0.0; 3]), sample([0.0, 0.0, -G], [0.0, 0.49, 0.0])];
    let shaken = [sample([-10.0, 0.0, -G], [0.0; 3]), sample([0.0, 0.0, -G], [0.0, -0.3, 0.0])];
    for (wild, shaken) in wild.into_iter().zip(shaken) {
        let mut rig = Rig::captive(30);
        let climb_mps = rig.channel.climb_rate.value();
        rig.step(&wild);
        rig.step(&shaken);
        rig.step(&rest());
        let down = rig.channel.down_body().unwrap();
        assert!(down[2] > 0.004_f32.cos(), "{down:?}");
        assert!((rig.channel.climb_rate.value() - climb_mps).abs() < 0.01);
        // Two wrong samples turn by 0.005 rad and climb 0.15 m/s in their own 10 ms. If the last were used over
        // the gap after it, that would be 0.1 rad and 2.9 m/s more.
        for times in [1.0, 2.0] {
            rig.step(&sample([0.0, 0.0, -G - 14.5 * times], [0.0, 0.48 * times, 0.0]));
        }
        rig.tick += 40;
        rig.step(&rest());
        let down = rig.channel.down_body().unwrap();
        assert!(down[2] > 0.009_f32.cos(), "{down:?}");
        let climbed_mps = rig.channel.climb_rate.value() - climb_mps;
        assert!(climbed_mps.abs() < 0.2, "{climbed_mps}");
        // Away from rest it is a leap for a second.
        let leaping = sample([0.0, 0.0, -G - 20.0], [0.0; 3]);
        for _ in 0..200 {
            rig.tick += 1;
            assert_eq!(rig.channel.inertial(rig.time_us(), &leaping), Err(StrapdownError::Spike));
        }
        rig.step(&leaping);
    }
}

/// In free flight a force that leads back is still a leap: the vehicle pulls 5 g, and a wire reads nothing.
#[test]
fn a_force_that_vanishes_while_the_vehicle_pulls_is_a_leap() {
    let mut rig = Rig::captive(30);
    rig.channel.launch();
    for load in [3.0, 5.0] {
        rig.step(&sample([0.0, 0.0, -load * G], [0.0; 3]));
    }
    for _ in 0..2 {
        rig.tick += 1;
        let nothing = sample([0.0, 0.0, -0.1], [0.0; 3]);
        assert_eq!(rig.channel.inertial(rig.time_us(), &nothing), Err(StrapdownError::Spike));
    }
    rig.step(&sample([0.0, 0.0, -5.0 * G], [0.0; 3]));
}

/// A rate that leaps in captive flight does not become the vehicle's because the hooks open meanwhile.
#[test]
fn a_rate_that_leaps_under_the_pylon_is_refused_over_the_release() {
    let turning = sample([0.0, 0.0, -G], [0.0, 1.77, 0.0]);
    let mut rig = Rig::captive(30);
    for tick in 0..94 {
        if tick == 5 {
            rig.channel.launch();
        }
        rig.tick += 1;
        assert_eq!(rig.channel.inertial(rig.time_us(), &turning), Err(StrapdownError::Spike), "{tick}");
    }
    rig.step(&rest());
    assert!(rig.channel.down_body().unwrap()[2] > 0.999_99);
    // In free flight it is the vehicle that turns.
    rig.step(&turning);
}
