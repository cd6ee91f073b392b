//! The channel with motions of known result.

use super::*;

mod gaps;
mod mending;
mod reference;

const STEP_US: u64 = 5_000;
const STEP_S: f64 = 0.005;
const G: f64 = GRAVITY_MPS2 as f64;
/// A second of ticks.
const SECOND: u64 = 200;

type Vector64 = [f64; 3];

/// Down in body axes for a roll and a pitch.
fn down_of(roll: f64, pitch: f64) -> Vector64 {
    [-pitch.sin(), roll.sin() * pitch.cos(), roll.cos() * pitch.cos()]
}

/// Reading of an inertial unit, errors included.
fn sample(force: Vector64, rate: Vector64) -> ImuSample {
    ImuSample { accel_mps2: force.map(|part| part as f32), gyro_radps: rate.map(|part| part as f32) }
}

/// Specific force of unaccelerated flight.
fn at_rest(down: Vector64) -> Vector64 {
    down.map(|part| -G * part)
}

#[derive(Clone)]
struct Rig {
    channel: VerticalChannel,
    tick: u64,
}

impl Rig {
    fn new() -> Self {
        Self { channel: VerticalChannel::new(Config::MEMS), tick: 0 }
    }

    fn time_us(&self) -> u64 {
        self.tick * STEP_US
    }

    fn time_s(&self) -> f64 {
        self.tick as f64 * STEP_S
    }

    fn step(&mut self, sample: &ImuSample) {
        self.tick += 1;
        self.channel.inertial(self.time_us(), sample).unwrap();
    }

    /// Captive flight for so long, level and at rest at 1000 m, with ten fixes a second.
    fn captive(seconds: u64) -> Self {
        let mut rig = Self::new();
        for _ in 0..seconds * SECOND {
            rig.step(&sample([0.0, 0.0, -G], [0.0; 3]));
            if rig.tick.is_multiple_of(20) {
                rig.channel.reference(rig.time_us(), 1_000.0).unwrap();
            }
        }
        rig
    }

    /// Free flight from a level rest: the altitude's error after so long with this constant reading.
    fn free(mut self, seconds: u64, reading: &ImuSample) -> f64 {
        self.channel.launch();
        for _ in 0..seconds * SECOND {
            self.step(reading);
        }
        f64::from(self.channel.altitude_m().unwrap()) - 1_000.0
    }
}

/// Asserts equality within a fraction of the value.
fn assert_near(found: f64, wanted: f64, part: f64) {
    assert!((found - wanted).abs() <= part * wanted.abs(), "{found}, not {wanted}");
}

#[test]
fn rest_stays_rest() {
    // Half the last bit of 9.8 m/s^2 in f32 is 4.8e-7: 0.09 m in ten minutes.
    let error = Rig::captive(60).free(600, &sample([0.0, 0.0, -G], [0.0; 3]));
    assert!(error.abs() < 0.1, "{error}");
}

#[test]
fn an_accelerometer_bias_grows_with_the_square_of_time() {
    for seconds in [20u64, 40, 80] {
        let error = Rig::captive(60).free(seconds, &sample([0.0, 0.0, -G + 0.01], [0.0; 3]));
        assert_near(error, -0.005 * (seconds * seconds) as f64, 0.001);
    }
}

#[test]
fn a_wrong_climb_rate_grows_with_time() {
    for seconds in [20u64, 40, 80] {
        let mut rig = Rig::captive(60);
        rig.channel.climb_rate.add(0.05);
        let error = rig.free(seconds, &sample([0.0, 0.0, -G], [0.0; 3]));
        assert_near(error, 0.05 * seconds as f64, 0.001);
    }
}

#[test]
fn a_tilt_grows_with_the_double_integral_of_horizontal_acceleration() {
    let (tilt, acceleration) = (0.002f32, 2.0);
    for seconds in [20u64, 40] {
        let mut rig = Rig::captive(60);
        rig.channel.launch();
        let mut down = rig.channel.down.unwrap();
        down.rotate([0.0, tilt, 0.0]);
        rig.channel.down = Some(down);
        let error = rig.free(seconds, &sample([acceleration, 0.0, -G], [0.0; 3]));
        // From the tilt itself, and from gravity's cosine.
        let tilt = f64::from(tilt);
        let upward = -acceleration * tilt + G * (tilt.cos() - 1.0);
        assert_near(error, 0.5 * upward * (seconds * seconds) as f64, 0.005);
    }
}

#[test]
fn a_gyro_bias_grows_with_the_double_integral_of_that_times_time() {
    let (bias, acceleration) = (1e-4, 2.0);
    for seconds in [20u64, 40] {
        let error = Rig::captive(60).free(seconds, &sample([acceleration, 0.0, -G], [0.0, bias, 0.0]));
        // Tilt b t: -a b t^3/6, and from gravity's cosine -g b^2 t^4/24.
        let t = seconds as f64;
        let wanted = acceleration * bias * t.powi(3) / 6.0 - G * bias * bias * t.powi(4) / 24.0;
        assert_near(error, wanted, 0.005);
    }
}

/// Roll and pitch wander with gusts, no acceleration, and the gyros have a bias.
#[test]
fn level_and_gyro_bias_are_found() {
    let bias = [0.004, -0.003, 0.002];
    let angles =
        |t: f64| (0.05 + 0.03 * (0.9 * t).sin() + 0.02 * (2.3 * t).sin(), -0.08 + 0.02 * (1.3 * t).cos());
    let mut rig = Rig::new();
    for _ in 0..60 * SECOND {
        let t = rig.time_s() + STEP_S;
        let ((roll, pitch), (later_roll, later_pitch), (earlier_roll, earlier_pitch)) =
            (angles(t), angles(t + 1e-4), angles(t - 1e-4));
        let roll_rate = (later_roll - earlier_roll) / 2e-4;
        let pitch_rate = (later_pitch - earlier_pitch) / 2e-4;
        // Euler's kinematics with a constant heading (Titterton and Weston, section 3.6.2).
        let rate = [roll_rate, pitch_rate * roll.cos(), -pitch_rate * roll.sin()];
        let read = [0, 1, 2].map(|axis| rate[axis] + bias[axis]);
        rig.step(&sample(at_rest(down_of(roll, pitch)), read));
    }
    let (roll, pitch) = angles(rig.time_s());
    for (found, wanted) in rig.channel.down_body().unwrap().into_iter().zip(down_of(roll, pitch)) {
        assert!((f64::from(found) - wanted).abs() < 1e-5, "{found} {wanted}");
    }
    for (found, wanted) in rig.channel.gyro_bias_radps().into_iter().zip(bias) {
        assert!((f64::from(found) - wanted).abs() < 2e-5, "{found} {wanted}");
    }
    assert_eq!(rig.channel.counts().untrimmed, 0);
}

/// Straight flight with horizontal accelerations of a phugoid and of gusts, a wandering attitude, a wind that
/// turns the track away from the heading, and gyros with a bias.
struct Carried {
    rig: Rig,
    heading: f64,
    gyro_bias: Vector64,
    noise_mps: f64,
    seed: u64,
}

impl Carried {
    fn new(heading: f64, gyro_bias: Vector64) -> Self {
        Self { rig: Rig::new(), heading, gyro_bias, noise_mps: 0.0, seed: 1 }
    }

    /// Sum of twelve uniform numbers: of variance 1.
    fn normal(&mut self) -> f64 {
        (0..12).fold(-6.0, |sum, _| {
            self.seed =
                self.seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            sum + (self.seed >> 40) as f64 / (1u64 << 24) as f64
        })
    }

    /// Roll and pitch.
    fn angles(t: f64) -> [f64; 2] {
        [0.05 + 0.03 * (0.9 * t).sin() + 0.02 * (2.3 * t).sin(), -0.08 + 0.02 * (1.3 * t).cos()]
    }

    /// Level velocity and acceleration ahead of and right of the heading. 28 m/s, 6 m/s of crab.
    fn motion(t: f64) -> [[f64; 2]; 2] {
        let waves = |parts: [[f64; 2]; 2], slow: f64| {
            parts.into_iter().fold([slow, 0.0], |[v, a], [size, rate]| {
                [v + size / rate * (rate * t).sin(), a + size * (rate * t).cos()]
            })
        };
        let [[u, du], [v, dv]] =
            [waves([[0.4, 0.25], [0.3, 1.1]], 28.0), waves([[0.2, 0.17], [0.3, 0.8]], 6.0)];
        [[u, v], [du, dv]]
    }

    fn in_north_east(&self, [ahead, right]: [f64; 2]) -> [f64; 2] {
        let (sine, cosine) = self.heading.sin_cos();
        [ahead * cosine - right * sine, ahead * sine + right * cosine]
    }

    fn step(&mut self, velocities: bool) {
        let t = self.rig.time_s() + STEP_S;
        let [roll, pitch] = Self::angles(t);
        let [[later_roll, later_pitch], [earlier_roll, earlier_pitch]] =
            [Self::angles(t + 1e-4), Self::angles(t - 1e-4)];
        let (roll_rate, pitch_rate) =
            ((later_roll - earlier_roll) / 2e-4, (later_pitch - earlier_pitch) / 2e-4);
        let rate = [roll_rate, pitch_rate * roll.cos(), -pitch_rate * roll.sin()];
        let read = [0, 1, 2].map(|axis| rate[axis] + self.gyro_bias[axis]);
        let [velocity, [ahead, right]] = Self::motion(t);
        // By pitch, then roll.
        let ((sp, cp), (sr, cr)) = (pitch.sin_cos(), roll.sin_cos());
        let below = ahead * sp - G * cp;
        let force = [ahead * cp + G * sp, right * cr + below * sr, below * cr - right * sr];
        self.rig.step(&sample(force, read));
        if velocities && self.rig.tick.is_multiple_of(40) {
            let [north, east] = self.in_north_east(velocity);
            let noise = [self.normal(), self.normal()].map(|part| self.noise_mps * part);
            let fix = [north + noise[0], east + noise[1]].map(|part| part as f32);
            self.rig.channel.velocity(self.rig.time_us(), fix).unwrap();
        }
    }

    /// Largest errors of down (rad) and of the gyro's bias (rad/s).
    fn errors(&self) -> [f64; 2] {
        let [roll, pitch] = Self::angles(self.rig.time_s());
        let largest = |found: [f32; 3], wanted: Vector64| {
            found.into_iter().zip(wanted).map(|(a, b)| (f64::from(a) - b).abs()).fold(0.0, f64::max)
        };
        let channel = &self.rig.channel;
        [
            largest(channel.down_body().unwrap(), down_of(roll, pitch)),
            largest(channel.gyro_bias_radps(), self.gyro_bias),
        ]
    }

    fn run(mut self, seconds: u64, velocities: bool) -> Self {
        for _ in 0..seconds * SECOND {
            self.step(velocities);
        }
        self
    }

    /// With velocities and, once a second, the altitude.
    fn tied(self, seconds: u64) -> Self {
        (0..seconds).fold(self, |carried, _| {
            let mut carried = carried.run(1, true);
            // If the level is lost, the altitude is an outlier.
            let _ = carried.rig.channel.reference(carried.rig.time_us(), 1_000.0);
            carried
        })
    }

    /// The squares of those errors over the match's own variances.
    fn squares_over_variances(&self) -> [f64; 2] {
        let matching = self.rig.channel.matching.as_ref().unwrap();
        let variance = |state| f64::from(matching.variance(state));
        let [tilt, bias] = self.errors();
        [
            tilt * tilt / variance(2).max(variance(3)),
            bias * bias / variance(5).max(variance(6)).max(variance(7)),
        ]
    }
}

const GYRO_BIAS: Vector64 = [0.004, -0.003, 0.005];

#[test]
fn with_velocities_an_acceleration_is_no_tilt() {
    for heading in [0.0, 0.6, 2.0, -2.5] {
        let [with, without] = [true, false].map(|on| Carried::new(heading, GYRO_BIAS).run(120, on));
        let squares = with.squares_over_variances();
        let ([tilt, bias], [tilt_without, _]) = (with.errors(), without.errors());
        println!(
            "{heading}: {tilt:.1e} rad {bias:.1e} rad/s {squares:.3?}; without velocities {tilt_without:.1e} rad"
        );
        // Without velocities, the ends of the window weigh four times: accelerations of 0.5 m/s^2 and periods
        // of 25 s leave more than a milliradian. Exact velocities leave the remaining weight of the priors,
        // well below a sigma.
        assert!(tilt_without > 1e-3 && tilt < 0.1 * tilt_without);
        assert!(squares.into_iter().all(|square| square < 0.1), "{heading}: {squares:?}");
    }
}

/// The errors match the filter's own variances, over many draws of the fixes' noise.
#[test]
fn the_matchs_variances_are_true() {
    let (mut sum, mut count) = ([0.0; 2], 0.0);
    for seed in 0..40 {
        let carried = Carried { noise_mps: 0.1, seed: 77 * seed + 1, ..Carried::new(0.6, GYRO_BIAS) };
        for (sum, square) in sum.iter_mut().zip(carried.run(60, true).squares_over_variances()) {
            *sum += square;
        }
        count += 1.0;
    }
    let [tilt, bias] = sum.map(|sum| sum / count);
    println!("squared errors over their variances: {tilt:.2} {bias:.2}");
    // Of two unit normals the larger square has mean 1.64 (variance 3.1), of three 2.1 (3.9): over 40 flights
    // no more than 2.5 and 3.0. The result is smaller because these flights have neither gyro noise nor
    // vibration, for which the variances leave room; how much smaller shows how cautious the match is.
    assert!((0.1..2.5).contains(&tilt) && (0.1..3.0).contains(&bias), "{tilt} {bias}");
}

/// A new match bridges half a minute without velocities, and the level is not lost.
#[test]
fn velocities_may_stay_away() {
    let mut carried = Carried::new(0.6, GYRO_BIAS);
    for tick in 0..200 * SECOND {
        carried.step(!(100 * SECOND..110 * SECOND).contains(&tick));
    }
    let [tilt, bias] = carried.errors();
    assert!(tilt < 1e-4 && bias < 3e-5, "{tilt} {bias}");
    for _ in 0..40 * SECOND {
        carried.step(false);
    }
    // The level found in 200 s lasts; new samples enter as an average over the window of the levelling.
    let [tilt, _] = carried.errors();
    assert!(carried.rig.channel.matching.is_none() && tilt < 0.01, "{tilt}");
    for _ in 0..120 * SECOND {
        carried.step(true);
    }
    let [tilt, bias] = carried.errors();
    assert!(tilt < 2e-4 && bias < 5e-5, "{tilt} {bias}");
}

/// One fix that is far off, and a receiver with wild velocities. A receiver whose velocities are far worse
/// than assumed does not block the channel for ever, and is matched again once it is healthy.
#[test]
fn velocities_that_contradict_the_level_are_asked_less_and_less_often() {
    let mut carried = Carried::new(0.7, [0.002, -0.001, 0.001]);
    carried.noise_mps = 2.0;
    let mut spoken_s = 0;
    for second in 0..900 {
        carried = carried.tied(1);
        spoken_s += u32::from(second >= 300 && carried.rig.channel.is_aligned());
    }
    assert!(spoken_s >= 450, "of 600 s: {spoken_s}");
    carried.noise_mps = 0.02;
    let carried = carried.tied(300);
    assert!(carried.rig.channel.is_aligned());
    assert!(carried.rig.channel.matching.as_ref().is_some_and(VelocityMatch::has_lasted));
}

#[test]
fn a_velocity_that_can_not_be_is_refused() {
    let mut carried = Carried::new(0.6, GYRO_BIAS);
    for _ in 0..100 * SECOND {
        carried.step(true);
    }
    for _ in 0..SECOND {
        carried.step(false);
    }
    let before = carried.rig.channel.gyro_bias_radps();
    carried.rig.channel.velocity(carried.rig.time_us(), [100.0, 0.0]).unwrap();
    for _ in 0..3 {
        carried.step(false);
    }
    assert_eq!(carried.rig.channel.gyro_bias_radps(), before);
    let errors = [[f32::NAN, 0.0], [0.0, 2e3]].map(|bad| carried.rig.channel.velocity(u64::MAX, bad));
    assert_eq!(errors, [Err(StrapdownError::NotFinite), Err(StrapdownError::Implausible)]);
}

/// A hold that ends in a launch equals a launch at its first tick; one that does not is an interruption.
#[test]
fn a_hold_is_a_launch_until_it_is_resumed() {
    let mut carried = Carried::new(0.6, GYRO_BIAS);
    for _ in 0..60 * SECOND {
        carried.step(true);
        if carried.rig.tick.is_multiple_of(20) {
            carried.rig.channel.reference(carried.rig.time_us(), 1_000.0).unwrap();
        }
    }
    let (mut launched, mut held) = (carried.rig.channel.clone(), carried.rig.channel.clone());
    launched.launch();
    held.hold();
    for tick in 1..=600 {
        let time_us = carried.rig.time_us() + tick * STEP_US;
        let noise = if tick % 2 == 0 { 0.001 } else { -0.001 };
        let good = sample([0.0, 0.0, noise - G], [0.0; 3]);
        assert_eq!(launched.inertial(time_us, &good), held.inertial(time_us, &good));
        assert_eq!(held.reference(time_us, 5_000.0), Err(StrapdownError::Launched));
        assert_eq!(held.velocity(time_us, [9.0, 9.0]), Err(StrapdownError::Launched));
        assert_eq!(launched.altitude_m(), held.altitude_m());
        assert_eq!(launched.down_body(), held.down_body());
    }
    let mut resumed = held.clone();
    held.launch();
    assert_eq!(held, launched);
    held.resume_captive();
    assert_eq!(held, launched);
    resumed.resume_captive();
    assert_eq!(resumed.reference(carried.rig.time_us() + 601 * STEP_US, 1_000.0), Ok(()));
    assert!(resumed.is_aligned());
}

#[test]
fn the_reference_gives_altitude_climb_rate_and_accelerometer_bias() {
    let mut rig = Rig::new();
    let altitude = |t: f64| 1_200.0 + 2.0 * t;
    for _ in 0..90 * SECOND {
        rig.step(&sample([0.0, 0.0, -G + 0.05], [0.0; 3]));
        if rig.tick.is_multiple_of(20) {
            rig.channel.reference(rig.time_us(), altitude(rig.time_s()) as f32).unwrap();
        }
    }
    assert!((f64::from(rig.channel.altitude_m().unwrap()) - altitude(rig.time_s())).abs() < 0.005);
    assert!((rig.channel.climb_rate_mps().unwrap() - 2.0).abs() < 0.001);
    assert!((rig.channel.lacking_acceleration_mps2() - 0.05).abs() < 1e-4);
    // It keeps it: the bias is the body's, so it is still corrected in free flight.
    rig.channel.launch();
    for _ in 0..60 * SECOND {
        rig.step(&sample([0.0, 0.0, -G + 0.05], [0.0; 3]));
    }
    // 1e-4 m/s^2 for a minute, 1 mm/s for a minute.
    assert!((f64::from(rig.channel.altitude_m().unwrap()) - altitude(rig.time_s())).abs() < 0.18 + 0.06);
}

/// One long interval, from no acceleration to 10 m/s^2 upward: h = (2 a0 + a1) t^2/6, v = (a0 + a1) t/2.
#[test]
fn acceleration_is_linear_over_an_interval() {
    let mut rig = Rig::captive(30);
    rig.channel.launch();
    rig.tick += 19;
    rig.step(&sample([0.0, 0.0, -G - 10.0], [0.0; 3]));
    let risen = f64::from(rig.channel.altitude_m().unwrap()) - 1_000.0;
    // An f32 holds 1000 m to 6e-5.
    assert!((risen - 10.0 * 0.01 / 6.0).abs() < 1e-4, "{risen}");
    assert!((rig.channel.climb_rate_mps().unwrap() - 0.5).abs() < 1e-5);
}

/// A rate that rotates in the body causes an attitude that no sum of its angles shows (coning).
#[test]
fn coning_is_followed() {
    let (amplitude, frequency) = (0.5, 20.0);
    let rate = |t: f64| [0.0, amplitude * (frequency * t).cos(), amplitude * (frequency * t).sin()];
    let mut rig = Rig::captive(30);
    rig.channel.launch();
    let bias = rig.channel.gyro_bias_radps().map(f64::from);
    let start = rig.time_s();
    // The first interval ends the rest: a jump of the rate is not under test.
    rig.step(&sample([0.0, 0.0, -G], [0, 1, 2].map(|axis| rate(0.0)[axis] + bias[axis])));
    let begin = rig.channel.down_body().unwrap().map(f64::from);
    let mut truth = begin;
    let first = rig.time_s();
    for _ in 0..60 * SECOND {
        // A hundred steps a tick, each of second order.
        for part in 0..100 {
            // Linear between the ticks, as the channel assumes: a chip's filter is not under test.
            let t = rig.time_s() - first;
            let share = (f64::from(part) + 0.5) / 100.0;
            let (from, to) = (rate(t), rate(t + STEP_S));
            let [p, q, r] = [0, 1, 2].map(|axis| from[axis] + share * (to[axis] - from[axis]));
            let h = STEP_S / 100.0;
            let turned = |d: Vector64| [d[1] * r - d[2] * q, d[2] * p - d[0] * r, d[0] * q - d[1] * p];
            let slope = turned(truth);
            let middle = [0, 1, 2].map(|axis| truth[axis] + 0.5 * h * slope[axis]);
            let slope = turned(middle);
            truth = [0, 1, 2].map(|axis| truth[axis] + h * slope[axis]);
        }
        let t = rig.time_s() - first + STEP_S;
        rig.step(&sample([0.0, 0.0, -G], [0, 1, 2].map(|axis| rate(t)[axis] + bias[axis])));
    }
    assert!(rig.time_s() - start > 60.0);
    // Without the coning term the drift is amplitude^2 frequency dt^2 / 12 = 1e-5 rad/s about the axis around
    // which the rate rotates, the body's x: 6e-4 rad in a minute. With it, the next order: below a tenth of
    // that.
    let apart: f64 = rig
        .channel
        .down_body()
        .unwrap()
        .into_iter()
        .zip(truth)
        .map(|(found, wanted)| (f64::from(found) - wanted).powi(2))
        .sum();
    assert!(apart.sqrt() < 6e-5, "{}", apart.sqrt());
}

#[test]
fn a_turn_does_not_level_the_channel() {
    let mut rig = Rig::captive(60);
    let before = rig.channel.gyro_bias_radps();
    // A coordinated turn at 30 degrees of bank: the accelerometer sees the body's own z.
    let (bank, speed) = (30f64.to_radians(), 30.0);
    let heading_rate = G * bank.tan() / speed;
    for tick in 0..10 * SECOND {
        // Roll in within half a second, smoothly.
        let share = ((tick + 1) as f64 / 100.0).min(1.0);
        let turn = std::f64::consts::TAU * share;
        let roll_rate = bank / 0.5 * (1.0 - turn.cos());
        let roll = bank * (share - turn.sin() / std::f64::consts::TAU);
        let force = [0.0, 0.0, -G / roll.cos()];
        let turn = if tick < 100 { 0.0 } else { heading_rate };
        rig.step(&sample(force, [roll_rate, turn * roll.sin(), turn * roll.cos()]));
    }
    let counts = rig.channel.counts();
    assert!(counts.untrimmed > 1_500, "{counts:?}");
    // Only the entry into the turn, before it is detected, pulls at the level: 120 ticks of 4/n of a mean
    // error of 0.3 rad.
    let down = rig.channel.down_body().unwrap();
    for (found, wanted) in down.into_iter().zip(down_of(bank, 0.0)) {
        assert!((f64::from(found) - wanted).abs() < 0.012, "{down:?}");
    }
    for (found, old) in rig.channel.gyro_bias_radps().into_iter().zip(before) {
        assert!((found - old).abs() < 1e-3, "{found} {old}");
    }
}

/// A gust at the very first samples: the gyro bias that the fit makes of two of them must not exclude all
/// others.
#[test]
fn a_gust_at_the_start_does_not_end_the_levelling() {
    let mut rig = Rig::new();
    for tick in 0..60 * SECOND {
        let fading = (-(tick as f64) * STEP_S / 0.3).exp();
        let noise = if tick % 2 == 0 { 0.001 } else { -0.001 };
        rig.step(&sample([0.4, -1.1 * fading, -G + 4.8 * fading + noise], [0.0, 0.0, 0.0]));
        if rig.tick.is_multiple_of(40) {
            rig.channel.reference(rig.time_us(), 1_000.0).unwrap();
        }
    }
    assert!(rig.channel.is_aligned(), "{:?}", rig.channel);
}

/// An engine shakes the unit from its first sample on, the gyro has its noise, and at one second in five a
/// gap of 0.4 s begins: the levelling takes its normal time and no more, whichever samples it begins with.
#[test]
fn an_engine_that_shakes_the_unit_does_not_delay_the_levelling() {
    for phase in 0..20 {
        let mut rig = Rig::new();
        rig.tick = phase * 3;
        let mut aligned_s = None;
        for tick in 0..40 * SECOND {
            if tick == 8 * SECOND && phase % 5 == 0 {
                rig.tick += 80;
            }
            let t = rig.time_s();
            let [x, y, z] = [383.0, 394.0, 371.0].map(|rate: f64| (rate * t).sin());
            let [p, q, r] = [0.7, 1.1, 0.9].map(|rate: f64| 0.004 + 0.004 * (rate * t).sin());
            rig.step(&sample([x, y, z - G], [p, q, r - 0.004]));
            if rig.tick.is_multiple_of(40) {
                let _ = rig.channel.reference(rig.time_us(), 1_000.0);
            }
            if rig.channel.is_aligned() && aligned_s.is_none() {
                aligned_s = Some(rig.time_s());
            }
        }
        assert!(aligned_s.is_some_and(|seconds| seconds < 22.0), "{phase}: {aligned_s:?}");
    }
}

/// A disturbance of the level for half a second must not cost a match that has long agreed with velocities a
/// new levelling or the altitude.
#[test]
fn a_brief_disturbance_of_the_level_is_matched_away() {
    let mut carried = Carried::new(0.7, [0.002, -0.001, 0.001]).tied(60);
    let mut down = carried.rig.channel.down.unwrap();
    down.rotate([0.0, 0.1, 0.0]);
    carried.rig.channel.down = Some(down);
    for second in 0..60 {
        carried = carried.tied(1);
        assert!(carried.rig.channel.altitude_m().is_some(), "{second}");
    }
    let [level, gyro] = carried.errors();
    assert!(level < 0.01 && gyro < 0.001, "{level} {gyro}");
}

#[test]
fn a_refused_sample_changes_nothing() {
    let good = sample([0.0, 0.0, -G], [0.0; 3]);
    for launched in [false, true] {
        let mut rig = Rig::captive(30);
        if launched {
            rig.channel.launch();
        }
        let before = rig.channel.clone();
        let at = rig.time_us();
        for (time_us, bad, error) in [
            (at + STEP_US, sample([0.0, f64::NAN, -G], [0.0; 3]), StrapdownError::NotFinite),
            (at + STEP_US, sample([0.0, 0.0, -G], [f64::INFINITY, 0.0, 0.0]), StrapdownError::NotFinite),
            (at + STEP_US, sample([0.0, 0.0, 1_001.0], [0.0; 3]), StrapdownError::Implausible),
            (at + STEP_US, sample([0.0, 0.0, -G], [0.0, -101.0, 0.0]), StrapdownError::Implausible),
            (at, good, StrapdownError::OutOfOrder),
            (at - 1, good, StrapdownError::OutOfOrder),
        ] {
            assert_eq!(rig.channel.inertial(time_us, &bad), Err(error), "{bad:?} {launched}");
            let unchanged = VerticalChannel { counts: before.counts, ..rig.channel.clone() };
            assert_eq!(unchanged, before);
        }
        assert_eq!(rig.channel.counts().refused, 6);
        let reference = rig.channel.reference(at, f32::NAN);
        let expected = if launched { StrapdownError::Launched } else { StrapdownError::NotFinite };
        assert_eq!(reference, Err(expected));
        assert_eq!(rig.channel.altitude_m(), before.altitude_m());
    }
}

#[test]
fn what_was_not_aligned_at_launch_never_says_an_altitude() {
    let mut rig = Rig::captive(10);
    assert_eq!(rig.channel.altitude_m(), None);
    rig.channel.launch();
    for _ in 0..60 * SECOND {
        rig.step(&sample([0.0, 0.0, -G], [0.0; 3]));
    }
    assert_eq!(rig.channel.altitude_m(), None);
}

#[test]
fn free_fall_shows_no_vertical() {
    let mut channel = VerticalChannel::new(Config::MEMS);
    assert_eq!(channel.inertial(1, &sample([0.0; 3], [0.0; 3])), Err(StrapdownError::NoVertical));
    assert_eq!(channel.reference(1, 5.0), Err(StrapdownError::NoVertical));
}

proptest::proptest! {
    /// For any input the output is finite, and down has length 1.
    #[test]
    fn any_plausible_input_stays_finite(
        steps in proptest::collection::vec(
            (1u64..15_000, proptest::array::uniform6(-1_000f32..1_000.0), proptest::option::of(-1e5f32..1e5)),
            1..200,
        ),
        scale in 0.003f32..1.0,
        launch_at in 0usize..300,
    ) {
        let config = Config { minimum_s: 0.0, ..Config::MEMS };
        let mut channel = VerticalChannel::new(config);
        let mut time_us = 1;
        channel.inertial(time_us, &sample([0.0, 0.0, -G], [0.0; 3])).unwrap();
        for (index, (step_us, [ax, ay, az, p, q, r], reference)) in steps.into_iter().enumerate() {
            time_us += step_us;
            let gyro_radps = [p, q, r].map(|rate| 0.1 * rate);
            let _ = channel.inertial(time_us, &ImuSample { accel_mps2: [ax * scale, ay * scale, az * scale - 9.8 * (1.0 - scale)], gyro_radps });
            if let Some(altitude_m) = reference {
                let _ = channel.reference(time_us, altitude_m);
            }
            if index == launch_at {
                channel.launch();
            }
            let numbers = [channel.altitude_m().unwrap_or(0.0), channel.climb_rate_mps().unwrap_or(0.0)];
            proptest::prop_assert!(numbers.into_iter().all(f32::is_finite), "{numbers:?}");
            if let Some(down) = channel.down_body() {
                proptest::prop_assert!((dot(down, down) - 1.0).abs() < 0.01, "{down:?}");
            }
        }
    }
}
