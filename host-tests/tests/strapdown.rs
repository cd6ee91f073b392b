//! The strapdown vertical channel on simulated flights: compared with the truth and with a double-precision
//! strapdown of the whole attitude, and its errors with theory.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use std::path::Path;

use kf_core::input::ImuSample;
use kf_core::strapdown::{Config, GRAVITY_MPS2, StrapdownError, VerticalChannel};
use pylon::simulate::{TruthSample, load_scenario, simulate};
use rand::SeedableRng as _;
use rand_distr::{Distribution as _, Normal};

type Vector = [f64; 3];

/// `flights/clean.toml` (simulated), at 200 rows a second.
fn flights(seeds: std::ops::Range<u64>) -> impl Iterator<Item = Vec<TruthSample>> {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../flights/clean.toml");
    let mut scenario = load_scenario(&file).unwrap();
    scenario.rate_hz = 200.0;
    seeds.map(move |seed| simulate(&scenario, seed).unwrap().1.trajectory)
}

/// Errors of an inertial unit, from launch on or always.
#[derive(Clone, Copy, Default)]
struct Errors {
    accel: Vector,
    gyro: Vector,
    accel_after_launch: Vector,
    gyro_after_launch: Vector,
}

fn time_us(sample: &TruthSample) -> u64 {
    (sample.time_s * 1e6).round() as u64 + 1
}

fn add(a: Vector, b: Vector) -> Vector {
    [0, 1, 2].map(|axis| a[axis] + b[axis])
}

fn reading(sample: &TruthSample, errors: &Errors) -> (Vector, Vector) {
    let (mut force, mut rate) =
        (add(sample.specific_force_mps2, errors.accel), add(sample.rate_radps, errors.gyro));
    if !sample.captive {
        force = add(force, errors.accel_after_launch);
        rate = add(rate, errors.gyro_after_launch);
    }
    (force, rate)
}

/// The channel after a flight.
struct Flown {
    /// Its state after the first free row: before that the simulator changes aircraft, and the force jumps
    /// within a row.
    at_launch: VerticalChannel,
    /// Its altitudes from that row on.
    altitudes: Vec<f64>,
}

/// Readings in single precision, and until launch a reference without error ten times a second. Every fifth
/// fix has a velocity if `velocities` are given: their noise (m/s, one sigma) and its seed.
fn fly(flight: &[TruthSample], errors: &Errors, config: Config, velocities: Option<(f64, u64)>) -> Flown {
    let mut noise = velocities.map(|(sigma, seed)| {
        (Normal::new(0.0, sigma).unwrap(), rand_chacha::ChaCha8Rng::seed_from_u64(seed))
    });
    let launch = flight.iter().position(|sample| !sample.captive).unwrap();
    let mut channel = VerticalChannel::new(config);
    for (row, sample) in flight.iter().take(launch).enumerate() {
        // A gust at the very first row may hide the vertical; the next row shows it.
        let taken = channel.inertial(time_us(sample), &imu(sample, errors));
        assert!(matches!(taken, Ok(()) | Err(StrapdownError::NoVertical)), "{taken:?}");
        if row % 20 == 19 {
            let taken = channel.reference(time_us(sample), sample.altitude_m as f32);
            assert!(matches!(taken, Ok(()) | Err(StrapdownError::NoVertical)), "{taken:?}");
        }
        if let (99, Some((normal, random))) = (row % 100, &mut noise) {
            let [north, east, _] = sample.velocity_mps;
            let velocity = [north, east].map(|part| (part + normal.sample(random)) as f32);
            let taken = channel.velocity(time_us(sample), velocity);
            assert!(matches!(taken, Ok(()) | Err(StrapdownError::NoVertical)), "{taken:?}");
        }
    }
    channel.launch();
    let (mut at_launch, mut altitudes) = (None, Vec::new());
    for sample in free(flight) {
        channel.inertial(time_us(sample), &imu(sample, errors)).unwrap();
        altitudes.push(f64::from(channel.altitude_m().unwrap()));
        at_launch.get_or_insert_with(|| channel.clone());
    }
    Flown { at_launch: at_launch.unwrap(), altitudes }
}

fn imu(sample: &TruthSample, errors: &Errors) -> ImuSample {
    let (force, rate) = reading(sample, errors);
    ImuSample { accel_mps2: force.map(|v| v as f32), gyro_radps: rate.map(|v| v as f32) }
}

/// The free rows.
fn free(flight: &[TruthSample]) -> &[TruthSample] {
    &flight[flight.iter().position(|sample| !sample.captive).unwrap()..]
}

/// Rotates a vector by a quaternion, scalar first.
fn rotate(q: [f64; 4], v: Vector) -> Vector {
    let [w, x, y, z] = q;
    let t = [2.0 * (y * v[2] - z * v[1]), 2.0 * (z * v[0] - x * v[2]), 2.0 * (x * v[1] - y * v[0])];
    [
        v[0] + w * t[0] + y * t[2] - z * t[1],
        v[1] + w * t[1] + z * t[0] - x * t[2],
        v[2] + w * t[2] + x * t[1] - y * t[0],
    ]
}

fn product([aw, ax, ay, az]: [f64; 4], [bw, bx, by, bz]: [f64; 4]) -> [f64; 4] {
    [
        aw * bw - ax * bx - ay * by - az * bz,
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
    ]
}

/// A double-precision strapdown with the whole attitude as a quaternion, starting from the truth at launch.
struct Reference {
    attitude: [f64; 4],
    altitude: f64,
    climb_rate: f64,
}

impl Reference {
    /// Altitude after each row but the first, from the same readings.
    fn fly(mut self, rows: &[(f64, Vector, Vector)]) -> Vec<f64> {
        let upward = |attitude, force| -rotate(attitude, force)[2] - f64::from(GRAVITY_MPS2);
        let mut altitudes = vec![self.altitude];
        for pair in rows.windows(2) {
            let [(from, force, rate), (to, next_force, next_rate)] = pair else { unreachable!() };
            let step = to - from;
            let before = upward(self.attitude, *force);
            // The rotation vector of two rates that vary linearly; its quaternion by sine and cosine.
            let cross = [
                rate[1] * next_rate[2] - rate[2] * next_rate[1],
                rate[2] * next_rate[0] - rate[0] * next_rate[2],
                rate[0] * next_rate[1] - rate[1] * next_rate[0],
            ];
            let angle = [0, 1, 2]
                .map(|axis| step * (0.5 * (rate[axis] + next_rate[axis]) + step / 12.0 * cross[axis]));
            let size = angle.iter().map(|part| part * part).sum::<f64>().sqrt().max(1e-300);
            let (sine, cosine) = (0.5 * size).sin_cos();
            let [x, y, z] = angle.map(|part| sine * part / size);
            self.attitude = product(self.attitude, [cosine, x, y, z]);
            let after = upward(self.attitude, *next_force);
            self.altitude += step * (self.climb_rate + step / 6.0 * (2.0 * before + after));
            self.climb_rate += 0.5 * step * (before + after);
            altitudes.push(self.altitude);
        }
        altitudes
    }
}

/// The same alignment and the same readings: only the arithmetic differs.
#[test]
fn single_precision_follows_double_precision() {
    for flight in flights(0..3) {
        let flown = fly(&flight, &Errors::default(), Config::MEMS, Some((0.0, 0)));
        let channel = &flown.at_launch;
        let down = channel.down_body().unwrap().map(f64::from);
        let bias = channel.gyro_bias_radps().map(f64::from);
        let lacking = f64::from(channel.lacking_acceleration_mps2());
        let rows: Vec<_> = free(&flight)
            .iter()
            .map(|sample| {
                let imu = imu(sample, &Errors::default());
                let force = [0, 1, 2].map(|a| f64::from(imu.accel_mps2[a]) - lacking * down[a]);
                let rate = [0, 1, 2].map(|a| f64::from(imu.gyro_radps[a]) - bias[a]);
                (sample.time_s, force, rate)
            })
            .collect();
        // Roll and pitch of that down vector, with heading zero: the heading must not matter.
        let (roll, pitch) = (down[1].atan2(down[2]), (-down[0]).asin());
        let (sr, cr) = (0.5 * roll).sin_cos();
        let (sp, cp) = (0.5 * pitch).sin_cos();
        let reference = Reference {
            attitude: [cr * cp, sr * cp, cr * sp, -sr * sp],
            altitude: flown.altitudes[0],
            climb_rate: f64::from(channel.climb_rate_mps().unwrap()),
        };
        let wanted = reference.fly(&rows);
        let worst = flown.altitudes.iter().zip(&wanted).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        println!("{} s of free flight: single precision is {worst:.5} m off", rows.len() / 200);
        // The readings are equal to the last bit. What differs is the rounding of 25,000 rotations, 6e-8 each
        // and compensated, and of as many accelerations of 6e-7 m/s^2, at random: 0.5 * 128^2 * 6e-7 /
        // sqrt(25,000) in the altitude, ten times that at worst. The sums themselves lose nothing.
        assert!(worst < 0.01, "{worst}");
    }
}

/// The double integral of one acceleration per row, linear between rows.
fn double_integral(acceleration: impl Iterator<Item = f64>, step: f64) -> Vec<f64> {
    let (mut velocity, mut position, mut last) = (0.0, 0.0, None);
    acceleration
        .map(|now| {
            if let Some(before) = last.replace(now) {
                position += step * (velocity + step / 6.0 * (2.0 * before + now));
                velocity += 0.5 * step * (before + now);
            }
            position
        })
        .collect()
}

/// The altitude error that theory predicts from the errors at launch and of the unit (Titterton and Weston,
/// section 12.3): altitude, climb rate times t, and, integrated twice, the vertical part of the
/// accelerometer's remaining bias and of the force that a tilt mixes in.
///
/// The tilt is carried as the channel's down vector in axes of the earth, which would be (0, 0, 1) without
/// errors; there it moves only with the gyro's remaining bias, through every turn of the aircraft. Nothing is
/// linearised: over two minutes the products of the errors matter.
fn theory(flight: &[TruthSample], channel: &VerticalChannel, errors: &Errors) -> Vec<f64> {
    let rows = free(flight);
    let start = &rows[0];
    let mut down = rotate(start.attitude, channel.down_body().unwrap().map(f64::from));
    let found_gyro = channel.gyro_bias_radps().map(f64::from);
    let lacking = f64::from(channel.lacking_acceleration_mps2());
    let found_accel = channel.down_body().unwrap().map(|part| lacking * f64::from(part));
    let mut last = None::<Vector>;
    let upward: Vec<f64> = rows
        .iter()
        .map(|sample| {
            let (force, rate) = reading(sample, errors);
            let in_earth = |a: Vector, b: Vector| rotate(sample.attitude, [0, 1, 2].map(|i| a[i] - b[i]));
            let left = add(in_earth(rate, sample.rate_radps), in_earth([0.0; 3], found_gyro));
            if let Some(before) = last.replace(left) {
                let [x, y, z] = [0, 1, 2].map(|i| 0.002_5 * (before[i] + left[i]));
                let [a, b, c] = down;
                down = [a + b * z - c * y, b + c * x - a * z, c + a * y - b * x];
            }
            let true_force = rotate(sample.attitude, sample.specific_force_mps2);
            let taken = in_earth(force, found_accel);
            true_force[2] - (down[0] * taken[0] + down[1] * taken[1] + down[2] * taken[2])
        })
        .collect();
    let altitude = f64::from(channel.altitude_m().unwrap()) - start.altitude_m;
    let climb_rate = f64::from(channel.climb_rate_mps().unwrap()) - start.climb_rate_mps();
    double_integral(upward.into_iter(), 0.005)
        .into_iter()
        .zip(rows)
        .map(|(integral, row)| altitude + climb_rate * (row.time_s - start.time_s) + integral)
        .collect()
}

/// Through dives, pull-ups and steep turns, every error alone, and all together, grow as theory predicts.
#[test]
fn errors_grow_as_theory_says() {
    let bias = |axis: usize, size: f64| {
        let mut bias = [0.0; 3];
        bias[axis] = size;
        bias
    };
    let mut cases = vec![("perfect sensors", Errors::default())];
    for (axis, name) in ["accelerometer x", "accelerometer y", "accelerometer z"].into_iter().enumerate() {
        cases.push((name, Errors { accel_after_launch: bias(axis, 0.02), ..Errors::default() }));
    }
    for (axis, name) in ["gyro x", "gyro y", "gyro z"].into_iter().enumerate() {
        cases.push((name, Errors { gyro_after_launch: bias(axis, 3e-4), ..Errors::default() }));
    }
    let constant = Errors { accel: [0.05, -0.04, 0.08], gyro: [0.004, -0.003, 0.005], ..Errors::default() };
    cases.push(("constant biases", constant));
    for (seed, flight) in (0u32..).zip(flights(0..3)) {
        for (name, errors) in &cases {
            let flown = fly(&flight, errors, Config::MEMS, Some((0.0, 0)));
            let wanted = theory(&flight, &flown.at_launch, errors);
            let found: Vec<f64> = flown
                .altitudes
                .iter()
                .zip(free(&flight))
                .map(|(altitude, truth)| altitude - truth.altitude_m)
                .collect();
            let largest = wanted.iter().fold(0f64, |size, value| size.max(value.abs()));
            let apart = found.iter().zip(&wanted).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            println!(
                "flight {seed}, {name}: {:.1} m after {} s, {apart:.2} m from theory",
                found.last().unwrap(),
                found.len() / 200
            );
            // Due to the row's length: truth is integrated to the fourth order, this and the channel to the
            // second.
            assert!(apart < 0.1, "{name}: {apart} of {largest}");
        }
    }
}

/// Of biases that are always present, the alignment finds what is observable under the pylon, whatever else
/// it takes for a bias: the difference to the flight without them is the biases.
#[test]
fn constant_biases_are_found() {
    let errors = Errors { accel: [0.05, -0.04, 0.08], gyro: [0.004, -0.003, 0.005], ..Errors::default() };
    // The mother ship flies straight, so nothing has to be kept out; and then the fits are linear.
    let config = Config { turn_limit_radps: 1.0, load_limit: 1.0, ..Config::MEMS };
    for flight in flights(8..11) {
        let [clean, flown] =
            [Errors::default(), errors].map(|errors| fly(&flight, &errors, config, None).at_launch);
        for axis in 0..3 {
            let found = f64::from(flown.gyro_bias_radps()[axis] - clean.gyro_bias_radps()[axis]);
            assert!((found - errors.gyro[axis]).abs() < 0.05 * errors.gyro[axis].abs(), "{axis}: {found}");
        }
        // The accelerometer's bias along the vertical; those across it are a tilt, 1/g each.
        let found = f64::from(flown.lacking_acceleration_mps2() - clean.lacking_acceleration_mps2());
        assert!((found - errors.accel[2]).abs() < 0.1 * errors.accel[2], "{found}");
        let g = f64::from(GRAVITY_MPS2);
        for axis in 0..2 {
            let tilt = f64::from(flown.down_body().unwrap()[axis] - clean.down_body().unwrap()[axis]);
            assert!(
                (tilt + errors.accel[axis] / g).abs() < 0.2 * errors.accel[axis].abs() / g,
                "{axis}: {tilt}"
            );
        }
    }
}

/// Errors of down at launch (rad), of the altitude at the end of free flight and of the climb rate at launch.
fn outcome(flight: &[TruthSample], flown: &Flown) -> [f64; 3] {
    let start = &free(flight)[0];
    let down = rotate(start.attitude, flown.at_launch.down_body().unwrap().map(f64::from));
    let tilt = (down[0] * down[0] + down[1] * down[1]).sqrt();
    let end = flown.altitudes.last().unwrap() - flight.last().unwrap().altitude_m;
    [tilt, end, f64::from(flown.at_launch.climb_rate_mps().unwrap()) - start.climb_rate_mps()]
}

/// With perfect sensors and a perfect reference, the error after two minutes of free flight is the
/// alignment's error at launch: the filter's own noise figures let it trust neither. A tilt of 0.2 mrad over
/// a distance of 5 km is 1 m; a bias about the vertical of 0.0002 rad/s (a crab angle known to 0.07 rad a
/// fix, over 110 fixes) tilts a banked turn of 35 s by 5 mrad. Without velocities every acceleration of the
/// mother ship is taken for a tilt.
#[test]
fn velocities_take_the_acceleration_out_of_the_level() {
    let (mut with, mut without, mut count) = ([0.0; 3], [0.0; 3], 0.0);
    for (seed, flight) in (0u32..).zip(flights(0..8)) {
        let outcomes = [Some((0.0, 0)), None]
            .map(|velocities| outcome(&flight, &fly(&flight, &Errors::default(), Config::MEMS, velocities)));
        for (sums, outcome) in [&mut with, &mut without].into_iter().zip(outcomes) {
            for (sum, part) in sums.iter_mut().zip(outcome) {
                *sum += part * part;
            }
        }
        count += 1.0;
        let [[tilt, end, climb], [tilt_without, end_without, _]] = outcomes;
        println!(
            "flight {seed}: with velocities {tilt:.1e} rad, {climb:.4} m/s, {end:.2} m after {} s; without \
             {tilt_without:.1e} rad, {end_without:.2} m",
            free(&flight).len() / 200
        );
    }
    let [with, without] = [with, without].map(|sums| sums.map(|sum: f64| (sum / count).sqrt()));
    println!("root mean square (rad, m, m/s): {with:.5?} with velocities, {without:.5?} without");
    assert!(with[0] < 0.1 * without[0] && with[1] < 0.2 * without[1]);
}
