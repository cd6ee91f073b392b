//! A flight of the campaign, tick by tick: the inputs of the chips, and the true altitude.
//!
//! Its physics is its own: neither the simulator's nor the estimator's assumptions.

use kf_core::input::{BaroReading, GpsFix, ImuSample, Signals, TickInput};
use rand::Rng;
use rand_distr::{Distribution as _, StandardNormal, StudentT};

use super::plan::{Plan, Spread};

/// Length of a tick, microseconds.
pub const TICK_US: u64 = 5_000;
/// Start of a flight's clock, microseconds.
pub const FIRST_US: u64 = 1_000_000;
/// Ticks a second.
pub const TICKS_PER_S: f64 = 200.0;

const DT_S: f64 = 0.005;
const GRAVITY_MPS2: f64 = 9.806_65;

/// One tick of a flight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// The flight's input at the tick; `launch` is the wire.
    pub input: TickInput,
    /// The true altitude, metres.
    pub altitude_m: f32,
}

/// Flies a plan.
pub fn fly(plan: &Plan, random: &mut impl Rng) -> Vec<Row> {
    let mut vehicle = Vehicle::new(plan);
    let mut sensors = Noise::new(plan);
    (0..plan.ticks())
        .map(|tick| {
            let motion = vehicle.step(plan, tick, random);
            sensors.row(plan, tick, &motion, random)
        })
        .collect()
}

fn normal(random: &mut impl Rng) -> f64 {
    StandardNormal.sample(random)
}

/// A first-order Gauss-Markov process.
#[derive(Clone, Copy, Debug, Default)]
struct Wander {
    value: f64,
}

impl Wander {
    fn step(&mut self, sigma: f64, tau_s: f64, dt_s: f64, random: &mut impl Rng) -> f64 {
        let keep = (-dt_s / tau_s).exp();
        self.value = keep * self.value + sigma * (1.0 - keep * keep).sqrt() * normal(random);
        self.value
    }
}

/// The motion at a tick.
struct Motion {
    altitude_m: f64,
    velocity_ned_mps: [f64; 3],
    force_mps2: [f64; 3],
    rate_radps: [f64; 3],
    airspeed_mps: f64,
}

/// The mother ship, and the vehicle after separation.
struct Vehicle {
    altitude_m: f64,
    climb_mps: f64,
    attitude: [f64; 3],
    velocity_ned_mps: Option<[f64; 3]>,
    gust: Wander,
    smooth_gust_mps: f64,
    /// Climb rate without gusts, after the separation.
    free_climb_mps: f64,
}

impl Vehicle {
    fn new(plan: &Plan) -> Self {
        Self {
            altitude_m: plan.altitude_m,
            climb_mps: 0.0,
            attitude: [0.0, 0.03, 1.0],
            velocity_ned_mps: None,
            gust: Wander::default(),
            smooth_gust_mps: 0.0,
            free_climb_mps: 0.0,
        }
    }

    fn step(&mut self, plan: &Plan, tick: usize, random: &mut impl Rng) -> Motion {
        let time_s = tick as f64 * DT_S;
        let gust = self.gust.step(plan.gusts_mps, 1.5, DT_S, random);
        self.smooth_gust_mps += (gust - self.smooth_gust_mps) * DT_S / 0.3;
        let is_free = plan.separates && tick >= plan.separation();
        let mut bank_rad = 0.01 * (0.11 * time_s).sin();
        if is_free {
            let since = tick - plan.separation();
            let since_s = since as f64 * DT_S;
            let manoeuvre = manoeuvre(plan, since_s);
            bank_rad = manoeuvre.1;
            let wish_mps2 = ((manoeuvre.0 - self.free_climb_mps) / 2.0).clamp(-4.0, 6.0);
            let mut up_mps2 = -GRAVITY_MPS2 * (1.0 - plan.lift_share) * (-since_s / 0.8).exp()
                + wish_mps2 * (1.0 - (-since_s / 1.5).exp());
            if since < plan.ejector.1 as usize {
                up_mps2 -= plan.ejector.0;
            }
            self.free_climb_mps += up_mps2 * DT_S;
        } else {
            self.free_climb_mps = plan
                .swings
                .iter()
                .map(|[size_m, period_s, phase]| {
                    let rate = std::f64::consts::TAU / period_s;
                    size_m * rate * (rate * time_s + phase).cos()
                })
                .sum();
        }
        self.climb_mps = self.free_climb_mps + self.smooth_gust_mps;
        self.altitude_m += self.climb_mps * DT_S;

        let [roll, pitch, yaw] = self.attitude;
        let airspeed_mps = plan.airspeed_mps + 0.3 * (0.05 * time_s).sin();
        let next_roll = roll + (bank_rad - roll) * DT_S / 0.8;
        let wished_pitch = 0.03 + (self.free_climb_mps / airspeed_mps).clamp(-0.6, 0.6);
        let next_pitch = pitch + (wished_pitch - pitch) * DT_S / 0.8;
        let next_yaw = yaw + GRAVITY_MPS2 * next_roll.tan() / airspeed_mps * DT_S;
        let rates = [next_roll - roll, next_pitch - pitch, next_yaw - yaw].map(|step| step / DT_S);
        self.attitude = [next_roll, next_pitch, next_yaw];
        let velocity_ned_mps =
            [airspeed_mps * next_yaw.cos(), airspeed_mps * next_yaw.sin(), -self.climb_mps];
        let before = self.velocity_ned_mps.replace(velocity_ned_mps).unwrap_or(velocity_ned_mps);
        let acceleration: [f64; 3] = core::array::from_fn(|k| (velocity_ned_mps[k] - before[k]) / DT_S);
        let [north, east, down] = acceleration;
        Motion {
            altitude_m: self.altitude_m,
            velocity_ned_mps,
            force_mps2: to_body(self.attitude, [north, east, down - GRAVITY_MPS2]),
            rate_radps: body_rates(self.attitude, rates),
            airspeed_mps,
        }
    }
}

/// Climb rate and bank of the manoeuvre at that time after separation.
fn manoeuvre(plan: &Plan, since_s: f64) -> (f64, f64) {
    let mut end_s = 0.0;
    for one in &plan.manoeuvres {
        end_s += one.duration_s;
        if since_s < end_s {
            return (one.climb_mps, one.bank_rad);
        }
    }
    (0.0, 0.0)
}

/// Rotates from north-east-down to body axes; attitude: roll, pitch, yaw.
fn to_body([roll, pitch, yaw]: [f64; 3], [n, e, d]: [f64; 3]) -> [f64; 3] {
    let ((sr, cr), (sp, cp), (sy, cy)) = (roll.sin_cos(), pitch.sin_cos(), yaw.sin_cos());
    let (x, y) = (cy * n + sy * e, -sy * n + cy * e);
    let (x, z) = (cp * x - sp * d, sp * x + cp * d);
    [x, cr * y + sr * z, -sr * y + cr * z]
}

fn body_rates([roll, pitch, _]: [f64; 3], [of_roll, of_pitch, of_yaw]: [f64; 3]) -> [f64; 3] {
    let ((sr, cr), (sp, cp)) = (roll.sin_cos(), pitch.sin_cos());
    [of_roll - of_yaw * sp, of_pitch * cr + of_yaw * sr * cp, -of_pitch * sr + of_yaw * cr * cp]
}

/// The sensors' errors.
struct Noise {
    fix: Wander,
    velocity: [Wander; 3],
    baro: Wander,
    student: Option<StudentT<f64>>,
}

impl Noise {
    fn new(plan: &Plan) -> Self {
        let student = match plan.spread {
            Spread::Normal => None,
            Spread::HeavyTailed => StudentT::new(4.0).ok(),
        };
        Self { fix: Wander::default(), velocity: [Wander::default(); 3], baro: Wander::default(), student }
    }

    /// A random number of unit variance, with outliers if the plan has them.
    fn spread(&self, random: &mut impl Rng) -> f64 {
        match &self.student {
            // The variance of Student's t of n degrees of freedom is n / (n - 2).
            Some(student) => student.sample(random) / std::f64::consts::SQRT_2,
            None => normal(random),
        }
    }

    fn row(&mut self, plan: &Plan, tick: usize, motion: &Motion, random: &mut impl Rng) -> Row {
        let time_s = tick as f64 * DT_S;
        let fix_dt_s = plan.fix_ticks as f64 * DT_S;
        let gps = tick.is_multiple_of(plan.fix_ticks).then(|| {
            let wander_m = self.fix.step(plan.wander.0, plan.wander.1, fix_dt_s, random);
            let error_m = wander_m + plan.fix_noise_m * self.spread(random);
            let errors = self.velocity.each_mut().map(|axis| axis.step(0.06, 3.0, fix_dt_s, random));
            let [north, east, down]: [f64; 3] =
                core::array::from_fn(|k| motion.velocity_ned_mps[k] + errors[k]);
            GpsFix {
                altitude_m: (motion.altitude_m + error_m) as f32,
                velocity_north_mps: Some(north as f32),
                velocity_east_mps: Some(east as f32),
                velocity_down_mps: Some(down as f32),
                vertical_accuracy_m: Some((1.0 + plan.wander.0) as f32),
                satellites: Some(plan.satellites),
                fix_time_us: Some(FIRST_US + tick as u64 * TICK_US),
            }
        });
        let [offset_m, white_m, correlated_m] = plan.baro_m;
        let air_m = self.baro.step(correlated_m, 0.5, DT_S, random);
        let baro_m = motion.altitude_m + offset_m + air_m + white_m * self.spread(random);
        let (vibration_mps2, frequency_hz) = plan.vibration;
        let turn = std::f64::consts::TAU * frequency_hz * time_s;
        let shake = [turn.sin(), (1.03 * turn).cos(), (0.97 * turn).sin()];
        let accel = core::array::from_fn(|k| {
            motion.force_mps2[k] + plan.imu_bias.0[k] + vibration_mps2 * shake[k] + 0.01 * normal(random)
        });
        let gyro =
            core::array::from_fn(|k| motion.rate_radps[k] + plan.imu_bias.1[k] + 0.001 * normal(random));
        let has_parted = plan.separates && tick >= plan.separation() + plan.slack_ticks;
        let since_parted = tick.saturating_sub(plan.separation() + plan.slack_ticks);
        let bounces = has_parted && since_parted < plan.bounce_ticks && since_parted % 2 == 1;
        let master = (plan.has_master && !has_parted && tick.is_multiple_of(plan.master_ticks)).then(|| {
            let slow_m = plan.master_m[1] * (0.09 * time_s).sin();
            (motion.altitude_m + plan.master_m[0] + slow_m + 0.2 * normal(random)) as f32
        });
        let slave = plan.own_unit.filter(|_| tick.is_multiple_of(10)).map(|(unit_offset_m, drift_mps2)| {
            let free_s = (time_s - plan.captive_s).max(0.0);
            (motion.altitude_m + unit_offset_m + drift_mps2 * free_s * free_s + 0.15 * normal(random)) as f32
        });
        let airspeed = (plan.has_airspeed && tick.is_multiple_of(20))
            .then(|| (motion.airspeed_mps + 0.3 * normal(random)) as f32);
        Row {
            input: TickInput {
                time_us: FIRST_US + tick as u64 * TICK_US,
                launch: has_parted && !bounces,
                gps,
                baro: Some(BaroReading::PressurePa(pressure_pa(baro_m) as f32)),
                imu_master_altitude_m: master,
                imu_slave_altitude_m: slave,
                imu: Some(ImuSample { accel_mps2: single(accel), gyro_radps: single(gyro) }),
                signals: Signals { true_airspeed_mps: airspeed, ..Signals::default() },
                ..TickInput::default()
            },
            altitude_m: motion.altitude_m as f32,
        }
    }
}

fn single(values: [f64; 3]) -> [f32; 3] {
    values.map(|value| value as f32)
}

/// The standard atmosphere (ICAO Doc 7488), troposphere.
#[must_use]
pub fn pressure_pa(altitude_m: f64) -> f64 {
    101_325.0 * (1.0 - altitude_m / 44_330.77).max(0.01).powf(5.255_88)
}
