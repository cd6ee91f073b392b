//! Manoeuvres that advice may ask for, flown by a point mass, so that their information can be computed
//! before they are flown.

use kf_core::input::{GpsFix, ImuSample, Signals, TickInput};

const GRAVITY: f64 = 9.806_65;
/// Pull-ups and push-overs: the climb rate's amplitude over the cruise speed, and its angular frequency,
/// rad/s (a period of 6 s).
const PULL: f64 = 0.08;
const PULL_RATE: f64 = 1.05;
/// Ticks per second.
const RATE: f64 = 10.0;
/// Straight and level before every manoeuvre, as in captive flight, seconds.
pub const CAPTIVE_S: f64 = 60.0;
/// Length of a manoeuvre, seconds.
pub const LENGTH_S: f64 = 120.0;

/// A manoeuvre: what the pilot or autopilot commands as a function of the time since its start.
pub struct Manoeuvre {
    /// What to fly, with `{slow}`, `{cruise}` and `{fast}` for speeds in m/s, and `{light}` and `{heavy}` for
    /// the load factors of a pull-up.
    say: &'static str,
    /// Speed over the cruise speed.
    speed: fn(f64) -> f64,
    /// Climb rate over the cruise speed.
    climb: fn(f64) -> f64,
    /// Bank, rad.
    bank: fn(f64) -> f64,
    /// Sideslip, rad.
    sideslip: fn(f64) -> f64,
    /// Throttle in addition to what drag and acceleration need.
    power: fn(f64) -> f64,
}

fn none(_: f64) -> f64 {
    0.0
}

fn steady(_: f64) -> f64 {
    1.0
}

/// Steps up and down between -1 and 1, staying at each for a quarter of the period.
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

/// The manoeuvres that the advice chooses from.
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
        say: "pull-ups and push-overs of 3 s each between {light} and {heavy} g at {cruise} m/s",
        speed: |t| 1.0 - 0.03 * libm::cos(t * PULL_RATE),
        climb: |t| -PULL * libm::cos(t * PULL_RATE),
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

/// The state in which a manoeuvre starts.
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
    pub fn describe(&self, trim: &Trim) -> String {
        let speed = |factor: f64| format!("{:.0}", trim.speed_mps * factor);
        let pull = PULL * PULL_RATE * trim.speed_mps / GRAVITY;
        self.say
            .replace("{slow}", &speed(0.75))
            .replace("{cruise}", &speed(1.0))
            .replace("{fast}", &speed(1.25))
            .replace("{light}", &format!("{:.1}", 1.0 - pull))
            .replace("{heavy}", &format!("{:.1}", 1.0 + pull))
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
            // A vibration of known size, alternating from tick to tick.
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

#[cfg(test)]
mod tests {
    use super::*;

    const TRIM: Trim = Trim { speed_mps: 40.0, altitude_m: 1_500.0, angle_of_attack_rad: 0.05 };
    /// Single-precision error of the compared values, in their own unit.
    const ROUNDING: f64 = 1e-3;

    /// The steps rise to one within an eighth of the period, stay there for a quarter, and likewise fall to
    /// minus one and return.
    #[test]
    fn steps_stay_at_their_ends_for_a_quarter() {
        let eighths = [0.0, 1.0, 1.0, 1.0, 0.0, -1.0, -1.0, -1.0];
        for (eighth, wanted) in eighths.into_iter().enumerate() {
            for turns in [0.0, 3.0] {
                let found = steps(40.0 * (turns + eighth as f64 / 8.0), 40.0);
                assert!((found - wanted).abs() < 1e-9, "{eighth} {found}");
            }
        }
        assert!((steps(2.5, 40.0) - 0.5).abs() < 1e-9 && (steps(20.0 + 2.5, 40.0) + 0.5).abs() < 1e-9);
        assert!((steps(37.5, 40.0) + 0.5).abs() < 1e-9);
    }

    /// The text names the speeds that are flown.
    #[test]
    fn the_words_have_the_speeds() {
        assert!(MANOEUVRES[0].describe(&TRIM).contains("from 30 to 50 m/s"));
        assert!(MANOEUVRES[1].describe(&TRIM).contains("at constant 40 m/s"));
    }

    /// A pull-up at such a speed takes more lift the faster the aircraft is, and the text gives what is
    /// flown.
    #[test]
    fn the_words_have_the_load_factors_of_that_speed() {
        for (speed_mps, words) in [(40.0, "between 0.7 and 1.3 g"), (80.0, "between 0.3 and 1.7 g")] {
            let trim = Trim { speed_mps, ..TRIM };
            assert!(MANOEUVRES[2].describe(&trim).contains(words), "{}", MANOEUVRES[2].describe(&trim));
            let loads = MANOEUVRES[2].fly(&trim).into_iter().filter(|tick| tick.launch).map(|tick| {
                let [_, shake, z] = tick.imu.unwrap().accel_mps2.map(f64::from);
                (shake - z) / GRAVITY
            });
            let (least, most) =
                loads.fold((f64::MAX, f64::MIN), |(least, most), load| (least.min(load), most.max(load)));
            assert_eq!(format!("between {least:.1} and {most:.1} g"), words);
        }
    }

    fn signals(tick: &TickInput) -> (f64, [f64; 3], [f64; 3]) {
        let fix = tick.gps.unwrap();
        let velocity = [fix.velocity_north_mps, fix.velocity_east_mps, fix.velocity_down_mps];
        let airspeed = f64::from(tick.signals.true_airspeed_mps.unwrap());
        let attitude = tick.signals.attitude_rad.unwrap();
        (airspeed, velocity.map(|value| f64::from(value.unwrap())), attitude.map(f64::from))
    }

    /// Three minutes at ten ticks a second, the first of which is captive, straight and level.
    #[test]
    fn a_minute_straight_and_level_comes_first() {
        for manoeuvre in &MANOEUVRES {
            let ticks = manoeuvre.fly(&TRIM);
            assert_eq!((ticks.len(), ticks[0].time_us, ticks[1].time_us), (1_800, 0, 100_000));
            assert!(ticks.iter().all(|tick| tick.launch == (tick.time_us >= 60_000_000)));
            for tick in &ticks[..599] {
                let (_, [_, east, down], [roll, ..]) = signals(tick);
                assert_eq!((east, down, roll), (0.0, 0.0, 0.0));
                assert_eq!(tick.gps.unwrap().altitude_m, 1_500.0);
            }
        }
    }

    /// A point mass: the velocity is as long as the airspeed and points along the heading; the altitude is
    /// the climb rate's integral; a bank turns by g tan(bank) / v; the lift carries the weight, the turn and
    /// the change of climb rate, and the angle of attack is the one that this lift needs.
    #[test]
    fn every_manoeuvre_is_a_point_masss() {
        for (number, manoeuvre) in MANOEUVRES.iter().enumerate() {
            let ticks = manoeuvre.fly(&TRIM);
            for pair in ticks.windows(2) {
                let [tick, next] = pair else { continue };
                let (speed, [north, east, down], [roll, pitch, yaw]) = signals(tick);
                let (next_speed, [.., next_down], [next_roll, _, next_yaw]) = signals(next);
                assert!((libm::hypot(libm::hypot(north, east), down) - speed).abs() < ROUNDING, "{number}");
                let turned = libm::remainder(libm::atan2(east, north) - yaw, std::f64::consts::TAU);
                assert!(turned.abs() < ROUNDING, "{number}");
                let climbed =
                    f64::from(next.gps.unwrap().altitude_m) - f64::from(tick.gps.unwrap().altitude_m);
                assert!((climbed + next_down * 0.1).abs() < ROUNDING, "{number} {climbed} {next_down}");
                let rate = GRAVITY * libm::tan(next_roll) / next_speed;
                assert!((next_yaw - yaw - rate * 0.1).abs() < ROUNDING, "{number}");
                let [x, y, z] = tick.imu.unwrap().accel_mps2.map(f64::from);
                let shake = y;
                let load_factor = -(z - shake) / GRAVITY;
                let lifted = load_factor * libm::cos(roll);
                assert!(
                    (lifted - 1.0 + (next_down - down) / 0.1 / GRAVITY).abs() < 0.01,
                    "{number} {lifted}"
                );
                let path = libm::asin(-down / speed);
                let along = (next_speed - speed) / 0.1;
                assert!((x - shake - along - GRAVITY * libm::sin(path)).abs() < 0.01, "{number}");
                let angle = f64::from(tick.signals.angle_of_attack_rad.unwrap());
                let of_lift = 0.05 * load_factor * (40.0 / speed) * (40.0 / speed);
                assert!((angle - of_lift).abs() < ROUNDING, "{number}");
                assert!((pitch - path - angle * libm::cos(roll)).abs() < ROUNDING, "{number}");
                let throttle = f64::from(tick.signals.throttle.unwrap());
                assert!((0.0..=1.0).contains(&throttle));
                let sign = if tick.time_us % 200_000 == 0 { 1.0 } else { -1.0 };
                assert!(
                    (shake * sign - 0.3 - throttle).abs() < ROUNDING,
                    "vibration grows with the throttle"
                );
                // The standard atmosphere's lapse rate, from 15 degrees at sea level.
                let altitude_m = f64::from(tick.gps.unwrap().altitude_m);
                let air_c = f64::from(tick.signals.outside_air_temperature_c.unwrap());
                assert!((air_c - 15.0 + 0.0065 * altitude_m).abs() < ROUNDING);
                // The barometer cools by 2 K in a hundred seconds, and by 3 K per kilometre.
                let baro_c = f64::from(tick.signals.baro_temperature_c.unwrap());
                let time_s = tick.time_us as f64 * 1e-6;
                assert!((baro_c - 20.0 + 0.003 * altitude_m + 0.02 * time_s).abs() < ROUNDING);
            }
        }
    }

    /// The throttle is half open in level cruise, and more where the aircraft accelerates, flies fast or is
    /// commanded more power.
    #[test]
    fn the_throttle_goes_with_speed_acceleration_and_power() {
        let throttle = |number: usize, tick: usize| {
            f64::from(MANOEUVRES[number].fly(&TRIM)[tick].signals.throttle.unwrap())
        };
        assert!((throttle(6, 300) - 0.5).abs() < ROUNDING && (throttle(6, 1_500) - 0.5).abs() < ROUNDING);
        // The speed sweep, a quarter faster: 0.3 of that.
        assert!((throttle(0, 600 + 150) - 0.575).abs() < ROUNDING);
        // On the way there, by 10 m/s within 7.5 s: 0.136 g; after 3.75 s an eighth faster.
        assert!((throttle(0, 600 + 37) - 0.5 - 10.0 / 7.5 / GRAVITY - 0.3 * 0.125).abs() < 0.005);
        // Full power of the throttle steps.
        assert!((throttle(5, 600 + 150) - 0.85).abs() < ROUNDING);
    }

    /// Each manoeuvre does what its text asks for: the speeds, the climb, the bank, the sideslip.
    #[test]
    fn the_manoeuvres_do_what_they_say() {
        let range = |number: usize, of: &dyn Fn(&TickInput) -> f64| {
            let ticks = MANOEUVRES[number].fly(&TRIM);
            let values = || ticks[600..].iter().map(of);
            (values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max))
        };
        let near = |found: (f64, f64), wanted: (f64, f64)| {
            assert!(
                (found.0 - wanted.0).abs() < 0.02 && (found.1 - wanted.1).abs() < 0.02,
                "{found:?} {wanted:?}"
            );
        };
        let speed = |tick: &TickInput| signals(tick).0;
        let climb = |tick: &TickInput| -signals(tick).1[2];
        let sideslip = |tick: &TickInput| f64::from(tick.signals.sideslip_rad.unwrap());
        near(range(0, &speed), (30.0, 50.0));
        near(range(0, &climb), (0.0, 0.0));
        near(range(1, &climb), (-6.0, 6.0));
        near(range(4, &sideslip), (-0.17, 0.17));
        near(range(6, &speed), (40.0, 40.0));
        near(range(7, &climb), (-4.8, 4.8));
        near(range(3, &|tick| signals(tick).2[0].abs()), (0.0, 1.05));
        let load_factor = |tick: &TickInput| {
            let [_, shake, z] = tick.imu.unwrap().accel_mps2.map(f64::from);
            -(z - shake) / GRAVITY
        };
        // Half a g either way is 0.08 of the speed at 1.05 rad/s at 58 m/s; at 40 m/s it is 0.34 g.
        let (least, most) = range(2, &load_factor);
        assert!((least - 0.66).abs() < 0.02 && (most - 1.34).abs() < 0.02, "{least} {most}");
    }
}
