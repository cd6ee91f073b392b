//! The true motion: flown by prescribing the path, not by forces.
//!
//! Flight path, bank and airspeed follow their commands as second-order systems; load factor, turn rate,
//! angle of attack, throttle and body rates follow from them by the laws of flight. Nothing of
//! `pylon simulate` is used except the record of the truth.

use std::f64::consts::{PI, TAU};

use pylon::simulate::scenario::Manoeuvre;
use pylon::simulate::{Scenario, TruthSample};
use rand::{Rng, RngExt as _};

use super::disturbance::{Gust, normal};
use crate::blind::draw::Plan;

/// Standard gravity, m/s^2.
pub(super) const GRAVITY: f64 = 9.806_65;
/// Time between rows, s.
pub(super) const STEP_S: f64 = 0.01;

/// Properties that are the same on all flights of this aircraft.
#[derive(Clone, Copy, Debug)]
pub(super) struct Airframe {
    pub cruise_mps: f64,
    /// Angle of attack at zero lift, and the increment for one g at cruise, rad.
    angle_rad: [f64; 2],
    /// Drag over weight at cruise: parasitic and induced.
    drag: [f64; 2],
    /// Full thrust over weight.
    thrust: f64,
    /// Vibration at full throttle, and of the air's buffeting at cruise, m/s^2.
    vibration_mps2: [f64; 2],
    /// Sideslip caused by a bank of one radian, rad.
    slip: f64,
    /// Time constant of the barometer's temperature, s, and its heating by its electronics and by the motor,
    /// K.
    warming: [f64; 3],
}

impl Airframe {
    pub fn draw(random: &mut impl Rng) -> Self {
        Self {
            cruise_mps: random.random_range(22.0..45.0),
            angle_rad: [random.random_range(-0.03..0.01), random.random_range(0.04..0.10)],
            drag: [random.random_range(0.03..0.07), random.random_range(0.02..0.05)],
            thrust: random.random_range(0.5..0.8),
            vibration_mps2: [random.random_range(0.2..2.0), random.random_range(0.02..0.3)],
            slip: random.random_range(-0.15..0.15),
            warming: [
                random.random_range(40.0..250.0),
                random.random_range(2.0..15.0),
                random.random_range(0.0..8.0),
            ],
        }
    }
}

/// One command: its end time, flight path and bank (rad), airspeed (m/s).
#[derive(Clone, Copy, Debug)]
struct Command {
    until_s: f64,
    path_rad: f64,
    bank_rad: f64,
    airspeed_mps: f64,
}

/// A second-order response, critically damped.
#[derive(Clone, Copy, Debug)]
struct Response {
    value: f64,
    rate: f64,
    frequency: f64,
}

impl Response {
    const fn at(value: f64, frequency: f64) -> Self {
        Self { value, rate: 0.0, frequency }
    }

    fn follow(&mut self, command: f64) {
        let w = self.frequency;
        self.rate += STEP_S * (w * w * (command - self.value) - 2.0 * w * self.rate);
        self.value += STEP_S * self.rate;
    }
}

/// What an aircraft is commanded to fly.
#[derive(Clone, Copy, Debug)]
pub(super) enum Course<'a> {
    /// A path that is drawn, as rich as this.
    Drawn(Plan),
    /// A planned flight's calibration and manoeuvres.
    Planned(&'a Scenario),
}

/// The commands of a planned flight. A load factor is not commanded: it follows from the response to the path.
fn planned(scenario: &Scenario) -> Vec<Command> {
    let mut command = Command {
        until_s: scenario.captive.duration_s,
        path_rad: 0.0,
        bank_rad: 0.0,
        airspeed_mps: scenario.captive.airspeed_mps,
    };
    let mut commands = vec![command];
    for segment in &scenario.free_flight {
        command.until_s += segment.duration_s;
        command.airspeed_mps = segment.airspeed_mps.unwrap_or(command.airspeed_mps);
        command.bank_rad = segment.bank_deg.unwrap_or(0.0).to_radians();
        command.path_rad = match segment.manoeuvre {
            Manoeuvre::LevelOff => 0.0,
            _ => segment.flight_path_deg.map_or(command.path_rad, f64::to_radians),
        };
        commands.push(command);
    }
    commands
}

fn captive_plan(random: &mut impl Rng, cruise: f64, duration_s: f64) -> Vec<Command> {
    let mut commands = Vec::new();
    let mut now_s = 0.0;
    // One in eight mother ships manoeuvres as if to excite.
    let lively = if random.random_range(0..8) == 0 { 3.0 } else { 1.0 };
    while now_s < duration_s {
        let length_s = random.random_range(8.0..30.0_f64);
        let turns = random.random_range(0..4) == 0;
        now_s = (now_s + length_s).min(duration_s);
        commands.push(Command {
            until_s: now_s,
            path_rad: lively * 0.01 * normal(random),
            bank_rad: if turns { random.random_range(-0.3..0.3) } else { 0.0 },
            airspeed_mps: cruise * (1.0 + lively * 0.02 * normal(random)),
        });
    }
    commands
}

fn free_plan(random: &mut impl Rng, plan: Plan, cruise: f64, start_s: f64) -> Vec<Command> {
    let level = |until_s| Command { until_s, path_rad: 0.0, bank_rad: 0.0, airspeed_mps: cruise };
    let mut now_s = start_s + random.random_range(3.0..10.0);
    let mut commands = vec![level(now_s)];
    let count = match plan {
        Plan::Level => {
            commands.push(level(now_s + random.random_range(60.0..240.0)));
            return commands;
        }
        Plan::Poor => random.random_range(2..5),
        Plan::Rich => random.random_range(12..26),
    };
    for _ in 0..count {
        now_s += random.random_range(5.0..22.0);
        let path_rad = match random.random_range(0..10) {
            0..3 => random.random_range(-0.40..-0.08),
            3..6 => random.random_range(0.05..0.30),
            _ => 0.0,
        };
        let turns = random.random_range(0..10) < 4;
        commands.push(Command {
            until_s: now_s,
            path_rad,
            bank_rad: if turns { random.random_range(-1.0..1.0) } else { 0.0 },
            airspeed_mps: cruise * random.random_range(0.85..1.45),
        });
    }
    commands
}

/// Flies the airframe; rows are [`STEP_S`] apart.
pub(super) fn fly(airframe: &Airframe, course: Course<'_>, random: &mut impl Rng) -> Vec<TruthSample> {
    let cruise = airframe.cruise_mps;
    let (captive_s, commands) = match course {
        Course::Drawn(plan) => {
            let captive_s: f64 = random.random_range(60.0..180.0);
            let mut commands = captive_plan(random, cruise, captive_s);
            commands.extend(free_plan(random, plan, cruise, captive_s));
            (captive_s, commands)
        }
        Course::Planned(scenario) => (scenario.captive.duration_s, planned(scenario)),
    };
    let end_s = commands.last().map_or(captive_s, |command| command.until_s);
    let mut path = Response::at(0.0, random.random_range(0.8..1.6));
    let mut bank = Response::at(0.0, random.random_range(1.0..2.0));
    let start_mps = match course {
        Course::Drawn(_) => cruise,
        Course::Planned(scenario) => scenario.captive.airspeed_mps,
    };
    let mut airspeed = Response::at(start_mps, random.random_range(0.3..0.6));
    let mut slip = Response::at(0.0, 1.0);
    let mut track = random.random_range(0.0..TAU);
    let drawn_m = random.random_range(900.0..2500.0);
    let start_m = match course {
        Course::Drawn(_) => drawn_m,
        Course::Planned(scenario) => scenario.captive.altitude_m,
    };
    let mut position = [0.0, 0.0, start_m];
    let wind = [random.random_range(-9.0..9.0), random.random_range(-9.0..9.0)];
    let shear = random.random_range(-0.004..0.004);
    let strength = random.random_range(0.1..1.5);
    let mut gusts = [
        Gust::new(strength, 200.0 / cruise),
        Gust::new(strength, 200.0 / cruise),
        Gust::new(0.6 * strength, 50.0 / cruise),
    ];
    let mut moved = [0.0; 3];
    let mut throttle = 0.1;
    let ground_c = random.random_range(0.0..30.0);
    let day_m = random.random_range(-150.0..150.0);
    let mut warmed = 0.0;
    let mut rows: Vec<TruthSample> = Vec::new();
    let mut at = 0;
    for row in 0..(end_s / STEP_S) as usize {
        let time_s = row as f64 * STEP_S;
        while at + 1 < commands.len() && commands[at].until_s <= time_s {
            at += 1;
        }
        let mut command = commands[at];
        // A plan must avoid the ground and thin air.
        if position[2] < 300.0 {
            command.path_rad = command.path_rad.max(0.12);
        } else if position[2] > 4000.0 {
            command.path_rad = command.path_rad.min(-0.08);
        }
        path.follow(command.path_rad);
        bank.follow(command.bank_rad);
        airspeed.follow(command.airspeed_mps);
        slip.follow(airframe.slip * bank.value);
        let (speed, gamma, phi) = (airspeed.value, path.value, bank.value);
        let load = (speed * path.rate / GRAVITY + gamma.cos()) / phi.cos();
        track += STEP_S * GRAVITY * load * phi.sin() / (speed * gamma.cos());

        let gust = gusts.each_mut().map(|gust| gust.next(random, STEP_S));
        // Lift responds to a vertical gust through the angle of attack; drag and side force respond far more
        // slowly.
        let lift_s = airframe.angle_rad[1] * cruise * cruise / (speed * GRAVITY);
        for (moved, (gust, answer_s)) in moved.iter_mut().zip(gust.into_iter().zip([5.0, 3.0, lift_s])) {
            *moved += STEP_S / answer_s * (gust - *moved);
        }
        let air =
            [speed * gamma.cos() * track.cos(), speed * gamma.cos() * track.sin(), -speed * gamma.sin()];
        let steady = [wind[0] + shear * (position[2] - start_m), wind[1], 0.0];
        let velocity: [f64; 3] = std::array::from_fn(|k| air[k] + steady[k] + moved[k]);
        let relative: [f64; 3] = std::array::from_fn(|k| air[k] + moved[k] - gust[k]);
        for k in 0..2 {
            position[k] += STEP_S * velocity[k];
        }
        position[2] -= STEP_S * velocity[2];

        let true_airspeed = relative.iter().map(|v| v * v).sum::<f64>().sqrt();
        let lifting = airframe.angle_rad[0] + airframe.angle_rad[1] * load * (cruise / speed).powi(2);
        let pitch = gamma + lifting * phi.cos();
        let angle_of_attack = lifting + gamma - (-relative[2] / true_airspeed).asin();
        let across = (relative[1] * track.cos() - relative[0] * track.sin()) / true_airspeed;
        let sideslip = slip.value + across;
        let heading = track - slip.value;

        let drag =
            airframe.drag[0] * (speed / cruise).powi(2) + airframe.drag[1] * (load * cruise / speed).powi(2);
        let wanted = (airspeed.rate / GRAVITY + gamma.sin() + drag) / airframe.thrust;
        let captive = time_s < captive_s;
        let lever = if captive { 0.1 } else { wanted.clamp(0.0, 1.0) };
        throttle += STEP_S / 0.4 * (lever - throttle);
        let air_c = ground_c - 0.0065 * position[2];
        let own =
            airframe.warming[1] * (1.0 - (-time_s / 60.0).exp()) + airframe.warming[2] * throttle * throttle;
        if row == 0 {
            warmed = air_c;
        }
        warmed += STEP_S / airframe.warming[0] * (air_c + own - warmed);
        let euler = [phi, pitch, (heading + PI).rem_euclid(TAU) - PI];
        rows.push(TruthSample {
            time_s,
            captive,
            position_m: [position[0], position[1]],
            altitude_m: position[2],
            velocity_mps: velocity,
            attitude: quaternion(euler),
            euler_rad: euler,
            specific_force_mps2: [0.0; 3],
            rate_radps: [0.0; 3],
            airspeed_mps: true_airspeed,
            angle_of_attack_rad: angle_of_attack,
            sideslip_rad: sideslip,
            throttle,
            vibration_mps2: airframe.vibration_mps2[0] * (0.1 + throttle.max(0.0).powf(1.5))
                + airframe.vibration_mps2[1] * (speed / cruise).powi(2),
            pressure_altitude_m: position[2] + day_m,
            air_temperature_c: air_c,
            baro_temperature_c: warmed,
        });
    }
    differentiate(&mut rows);
    rows
}

/// Specific force and body rates, from neighbouring rows.
fn differentiate(rows: &mut [TruthSample]) {
    let motion: Vec<([f64; 3], [f64; 3])> =
        rows.iter().map(|row| (row.velocity_mps, row.euler_rad)).collect();
    for (k, row) in rows.iter_mut().enumerate() {
        let (before, after) = (k.saturating_sub(1), (k + 1).min(motion.len() - 1));
        let span_s = (after - before).max(1) as f64 * STEP_S;
        let slope: [f64; 3] = std::array::from_fn(|i| (motion[after].0[i] - motion[before].0[i]) / span_s);
        let turn = |i: usize| {
            let change = motion[after].1[i] - motion[before].1[i];
            ((change + PI).rem_euclid(TAU) - PI) / span_s
        };
        row.specific_force_mps2 = to_body(row.euler_rad, [slope[0], slope[1], slope[2] - GRAVITY]);
        let [phi, theta, _] = row.euler_rad;
        let (phi_rate, theta_rate, psi_rate) = (turn(0), turn(1), turn(2));
        row.rate_radps = [
            phi_rate - psi_rate * theta.sin(),
            theta_rate * phi.cos() + psi_rate * theta.cos() * phi.sin(),
            psi_rate * theta.cos() * phi.cos() - theta_rate * phi.sin(),
        ];
    }
}

/// Body axes to north-east-down, by roll, pitch and yaw (Stevens and Lewis, 1.3-20).
fn rotation([phi, theta, psi]: [f64; 3]) -> [[f64; 3]; 3] {
    let ((sp, cp), (st, ct), (ss, cs)) = (phi.sin_cos(), theta.sin_cos(), psi.sin_cos());
    [
        [ct * cs, sp * st * cs - cp * ss, cp * st * cs + sp * ss],
        [ct * ss, sp * st * ss + cp * cs, cp * st * ss - sp * cs],
        [-st, sp * ct, cp * ct],
    ]
}

fn to_body(euler: [f64; 3], ned: [f64; 3]) -> [f64; 3] {
    let matrix = rotation(euler);
    std::array::from_fn(|c| (0..3).map(|r| matrix[r][c] * ned[r]).sum())
}

fn quaternion([phi, theta, psi]: [f64; 3]) -> [f64; 4] {
    let ((sp, cp), (st, ct), (ss, cs)) =
        ((phi / 2.0).sin_cos(), (theta / 2.0).sin_cos(), (psi / 2.0).sin_cos());
    [
        cp * ct * cs + sp * st * ss,
        sp * ct * cs - cp * st * ss,
        cp * st * cs + sp * ct * ss,
        cp * ct * ss - sp * st * cs,
    ]
}

#[cfg(test)]
mod tests {
    use pylon::simulate::TruthSample;
    use rand::SeedableRng as _;
    use rand_chacha::ChaCha8Rng;

    use super::*;

    fn flown(seed: u64) -> Vec<TruthSample> {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let airframe = Airframe::draw(&mut random);
        fly(&airframe, Course::Drawn(Plan::Rich), &mut random)
    }

    /// The specific force rotated by the quaternion, plus gravity, must match the motion; the body rates must
    /// match the rotation.
    #[test]
    fn force_rates_and_attitude_are_one_motion() {
        let rows = flown(5);
        for (k, pair) in rows.windows(3).enumerate().skip(1).step_by(97) {
            let [before, row, after] = [&pair[0], &pair[1], &pair[2]];
            let acceleration = row.acceleration_mps2();
            for axis in 0..3 {
                let slope = (after.velocity_mps[axis] - before.velocity_mps[axis]) / (2.0 * STEP_S);
                assert!((acceleration[axis] - slope).abs() < 1e-6, "row {k}: {acceleration:?}");
            }
            // q' = q (0, rate) / 2
            let [w, x, y, z] = row.attitude;
            let [p, q, r] = row.rate_radps;
            let turned = 0.5 * (w * p + y * r - z * q);
            let change = after.attitude[1] - before.attitude[1];
            // A yaw that wraps turns the quaternion's sign.
            if change.abs() < 0.1 {
                assert!((change / (2.0 * STEP_S) - turned).abs() < 1e-3, "row {k}: {change} {turned} {x}");
            }
        }
    }

    /// A rich plan climbs, dives, turns and changes its speed; the aircraft stays in the air.
    #[test]
    fn a_rich_plan_excites() {
        for seed in 0..10 {
            let rows = flown(seed);
            let free: Vec<&TruthSample> = rows.iter().filter(|row| !row.captive).collect();
            let span = |value: &dyn Fn(&TruthSample) -> f64| {
                let values = free.iter().map(|row| value(row));
                values.clone().fold(f64::MIN, f64::max) - values.fold(f64::MAX, f64::min)
            };
            assert!(span(&|row| row.airspeed_mps) > 5.0, "seed {seed}");
            assert!(span(&|row| row.load_factor()) > 0.3, "seed {seed}");
            assert!(span(&|row| row.climb_rate_mps()) > 3.0, "seed {seed}");
            assert!(
                rows.iter().all(|row| row.altitude_m > 50.0 && row.altitude_m.is_finite()),
                "seed {seed}"
            );
        }
    }
}
