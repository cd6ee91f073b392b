//! Manoeuvres that an advice may ask for, flown by a point mass, so that their information can be
//! computed before anyone flies them.

use kf_core::input::{GpsFix, ImuSample, Signals, TickInput};

const GRAVITY: f64 = 9.806_65;
/// Ticks a second.
const RATE: f64 = 10.0;
/// Straight and level before every manoeuvre, as in captive flight, seconds.
pub const CAPTIVE_S: f64 = 60.0;
/// Length of a manoeuvre, seconds.
pub const LENGTH_S: f64 = 120.0;

/// A manoeuvre: what the pilot or autopilot holds as a function of the time since its start.
pub struct Manoeuvre {
    /// What to fly, with `{slow}`, `{cruise}` and `{fast}` for speeds in m/s.
    say: &'static str,
    /// Speed over the cruise's.
    speed: fn(f64) -> f64,
    /// Climb rate over the cruise's speed.
    climb: fn(f64) -> f64,
    /// Bank, rad.
    bank: fn(f64) -> f64,
    /// Sideslip, rad.
    sideslip: fn(f64) -> f64,
    /// Whether it brings the load factor far from one by itself.
    power: fn(f64) -> f64,
}

fn none(_: f64) -> f64 {
    0.0
}

fn steady(_: f64) -> f64 {
    1.0
}

/// Up and down between -1 and 1, staying at each for a quarter of the period.
fn steps(time_s: f64, period_s: f64) -> f64 {
    let phase = (time_s / period_s).fract() * 4.0;
    match phase {
        p if p < 0.5 => p * 2.0,
        p if p < 1.5 => 1.0,
        p if p < 2.5 => 1.0 - (p - 1.5) * 2.0,
        p if p < 3.5 => -1.0,
        p => -1.0 + (p - 3.5) * 2.0,
    }
}

/// The manoeuvres that an advice chooses among.
pub const MANOEUVRES: [Manoeuvre; 9] = [
    Manoeuvre {
        say: "a level speed sweep from {slow} to {fast} m/s and back at constant altitude",
        speed: |t| 1.0 + 0.25 * steps(t, 60.0),
        climb: none,
        bank: none,
        sideslip: none,
        power: none,
    },
    Manoeuvre {
        say: "climbs and descents of 20 s each at constant {cruise} m/s",
        speed: steady,
        climb: |t| 0.15 * steps(t, 40.0),
        bank: none,
        sideslip: none,
        power: none,
    },
    Manoeuvre {
        say: "pull-ups and push-overs of 3 s each between 0.5 and 1.5 g at {cruise} m/s",
        speed: |t| 1.0 - 0.03 * libm::cos(t * 1.05),
        climb: |t| -0.08 * libm::cos(t * 1.05),
        bank: none,
        sideslip: none,
        power: none,
    },
    Manoeuvre {
        say: "level turns of 20 s at 30 and 60 degrees of bank at constant {cruise} m/s",
        speed: steady,
        climb: none,
        bank: |t| 0.8 * steps(t, 80.0) + 0.25 * steps(t, 27.0),
        sideslip: none,
        power: none,
    },
    Manoeuvre {
        say: "steady sideslips of 10 degrees, 10 s to each side, straight and level at {cruise} m/s",
        speed: steady,
        climb: none,
        bank: none,
        sideslip: |t| 0.17 * steps(t, 40.0),
        power: none,
    },
    Manoeuvre {
        say: "throttle steps at constant {cruise} m/s: 15 s climbing on full power, 15 s level, 15 s descending on idle",
        speed: steady,
        climb: |t| 0.08 * steps(t, 60.0),
        bank: none,
        sideslip: none,
        power: |t| 0.35 * steps(t, 60.0),
    },
    Manoeuvre {
        say: "two minutes straight and level at constant {cruise} m/s right after release",
        speed: steady,
        climb: none,
        bank: none,
        sideslip: none,
        power: none,
    },
    Manoeuvre {
        say: "a steady climb of several hundred metres at constant {cruise} m/s, two minutes level, and back down",
        speed: steady,
        climb: |t| {
            if t < 40.0 {
                0.12
            } else if t > 80.0 {
                -0.12
            } else {
                0.0
            }
        },
        bank: none,
        sideslip: none,
        power: none,
    },
    Manoeuvre {
        say: "straight legs of 30 s, each turned by 90 degrees from the last, hard acceleration and braking along each",
        speed: |t| 1.0 + 0.2 * libm::sin(t * 0.6),
        climb: none,
        bank: |t| if (t / 30.0).fract() > 0.85 { 0.8 } else { 0.0 },
        sideslip: none,
        power: none,
    },
];

/// Where a manoeuvre starts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trim {
    /// True airspeed, m/s.
    pub speed_mps: f64,
    /// Altitude, m.
    pub altitude_m: f64,
    /// Angle of attack in level flight, rad.
    pub angle_of_attack_rad: f64,
}

impl Manoeuvre {
    /// What to fly, in words.
    #[must_use]
    pub fn say(&self, trim: &Trim) -> String {
        let speed = |factor: f64| format!("{:.0}", trim.speed_mps * factor);
        self.say
            .replace("{slow}", &speed(0.75))
            .replace("{cruise}", &speed(1.0))
            .replace("{fast}", &speed(1.25))
    }

    /// The manoeuvre's ticks, after straight and level captive flight: exact signals of a point mass.
    #[must_use]
    pub fn fly(&self, trim: &Trim) -> Vec<TickInput> {
        let ticks = ((CAPTIVE_S + LENGTH_S) * RATE) as u32;
        let dt = 1.0 / RATE;
        let mut altitude_m = trim.altitude_m;
        let mut heading = 0.0;
        let mut inputs = Vec::new();
        let at = |k: f64| {
            let time_s = k * dt - CAPTIVE_S;
            if time_s < 0.0 {
                return (
                    trim.speed_mps * (self.speed)(0.0),
                    trim.speed_mps * (self.climb)(0.0) * 0.0,
                    0.0,
                    0.0,
                    0.0,
                );
            }
            let speed = trim.speed_mps * (self.speed)(time_s);
            let climb = trim.speed_mps * (self.climb)(time_s);
            (speed, climb, (self.bank)(time_s), (self.sideslip)(time_s), (self.power)(time_s))
        };
        for tick in 0..ticks {
            let k = f64::from(tick);
            let (speed, climb, bank, sideslip, power) = at(k);
            let (next_speed, next_climb, ..) = at(k + 1.0);
            let (along, up) = ((next_speed - speed) / dt, (next_climb - climb) / dt);
            // Lift carries the weight, the turn and the change of climb rate.
            let load_factor = (1.0 + up / GRAVITY) / libm::cos(bank);
            let path = libm::asin((climb / speed).clamp(-0.9, 0.9));
            let angle_of_attack =
                trim.angle_of_attack_rad * load_factor * (trim.speed_mps / speed) * (trim.speed_mps / speed);
            let pitch = path + angle_of_attack * libm::cos(bank);
            heading += GRAVITY * libm::tan(bank) / speed * dt;
            altitude_m += climb * dt;
            let throttle =
                (0.5 + power + along / GRAVITY + 0.3 * (speed / trim.speed_mps - 1.0)).clamp(0.0, 1.0);
            let drag_free = along + GRAVITY * libm::sin(path);
            // A shake of known size, alternating from tick to tick, stands for vibration.
            let shake = (0.3 + throttle) * if tick % 2 == 0 { 1.0 } else { -1.0 };
            inputs.push(TickInput {
                time_us: (k * dt * 1e6).round() as u64,
                launch: k * dt >= CAPTIVE_S,
                gps: Some(GpsFix {
                    altitude_m: altitude_m as f32,
                    velocity_north_mps: Some((speed * libm::cos(path) * libm::cos(heading)) as f32),
                    velocity_east_mps: Some((speed * libm::cos(path) * libm::sin(heading)) as f32),
                    velocity_down_mps: Some(-climb as f32),
                    ..GpsFix::default()
                }),
                imu: Some(ImuSample {
                    accel_mps2: [
                        (drag_free + shake) as f32,
                        (shake) as f32,
                        (-load_factor * GRAVITY + shake) as f32,
                    ],
                    gyro_radps: [0.0; 3],
                }),
                signals: Signals {
                    true_airspeed_mps: Some(speed as f32),
                    angle_of_attack_rad: Some(angle_of_attack as f32),
                    sideslip_rad: Some(sideslip as f32),
                    throttle: Some(throttle as f32),
                    outside_air_temperature_c: Some((15.0 - 0.0065 * altitude_m) as f32),
                    baro_temperature_c: Some((20.0 - 0.003 * altitude_m - 0.02 * k * dt) as f32),
                    attitude_rad: Some([bank as f32, pitch as f32, heading as f32]),
                },
                ..TickInput::default()
            });
        }
        inputs
    }
}
