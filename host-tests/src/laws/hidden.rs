//! The hidden laws.

use rand::{Rng, RngExt as _};

/// The aircraft's motion at a row: true values, without the noise that is recorded with them.
#[derive(Clone, Copy, Debug)]
pub struct Moment {
    /// Time since the first row, s.
    pub time_s: f64,
    /// Roll, pitch, yaw, rad.
    pub euler_rad: [f64; 3],
    /// Body rates, rad/s.
    pub rate_radps: [f64; 3],
    /// True airspeed, m/s.
    pub airspeed_mps: f64,
    /// Throttle, 0 to 1.
    pub throttle: f64,
    /// The barometer's temperature, degrees Celsius.
    pub baro_temperature_c: f64,
    /// A flap, 0 to 1.
    pub flap: f64,
    /// The propeller's speed, 1/min.
    pub rpm: f64,
    /// Temperature of a bay with a heater, degrees Celsius.
    pub bay_c: f64,
}

/// A hidden law, with its constants. All laws act on the barometer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Hidden {
    /// The sine of the roll angle times the dynamic pressure: a port on one side.
    Roll,
    /// The sine of the heading relative to an angle (rad): a field of the vehicle's magnetism, or the sun.
    Heading(f64),
    /// A smooth threshold of the flap (place, width) times the dynamic pressure: flow separation.
    Separation(f64, f64),
    /// Play of that half-width in the flap's linkage, times the dynamic pressure.
    FlapPlay(f64),
    /// An exponential of the bay's temperature with that scale, K.
    BayExponential(f64),
    /// Throttle times airspeed: the wash of a pusher.
    Wash,
    /// Throttle under the deflected flap.
    BlownFlap,
    /// A resonance of a mount at that speed (1/min), with that quality.
    Resonance(f64, f64),
    /// The response of a hose with that period (s) and damping to the pitch rate.
    Hose(f64, f64),
    /// The magnitude of the pitch rate beyond a dead band, rad/s.
    DeadBand(f64),
}

impl Hidden {
    /// Draws a law.
    pub fn draw(random: &mut impl Rng) -> Self {
        match random.random_range(0..10) {
            0 => Self::Roll,
            1 => Self::Heading(random.random_range(0.0..std::f64::consts::TAU)),
            2 => Self::Separation(random.random_range(0.2..0.7), random.random_range(0.02..0.1)),
            3 => Self::FlapPlay(random.random_range(0.03..0.15)),
            4 => Self::BayExponential(random.random_range(4.0..15.0)),
            5 => Self::Wash,
            6 => Self::BlownFlap,
            7 => Self::Resonance(random.random_range(3400.0..4800.0), random.random_range(5.0..12.0)),
            8 => Self::Hose(random.random_range(2.0..6.0), random.random_range(0.2..0.7)),
            _ => Self::DeadBand(random.random_range(0.01..0.06)),
        }
    }

    /// Name of the law's kind, for a table.
    #[must_use]
    pub const fn kind(self) -> &'static str {
        match self {
            Self::Roll => "roll angle",
            Self::Heading(_) => "heading",
            Self::Separation(..) => "smooth threshold",
            Self::FlapPlay(_) => "hysteresis",
            Self::BayExponential(_) => "exponential of a temperature",
            Self::Wash => "throttle times airspeed",
            Self::BlownFlap => "throttle times flap",
            Self::Resonance(..) => "resonance over a speed",
            Self::Hose(..) => "resonance in time",
            Self::DeadBand(_) => "dead band",
        }
    }

    /// Its shape at every row.
    #[must_use]
    pub fn shape(self, flight: &[Moment]) -> Vec<f64> {
        let mut play = 0.0_f64;
        let (mut position, mut speed) = (0.0_f64, 0.0_f64);
        let mut last_s = flight.first().map_or(0.0, |first| first.time_s);
        let of = |now: &Moment| {
            let step_s = now.time_s - last_s;
            last_s = now.time_s;
            let pressure = now.airspeed_mps * now.airspeed_mps / (2.0 * 9.806_65);
            match self {
                Self::Roll => now.euler_rad[0].sin() * pressure,
                Self::Heading(from) => (now.euler_rad[2] - from).sin(),
                Self::Separation(at, width) => pressure / (1.0 + (-(now.flap - at) / width).exp()),
                Self::FlapPlay(half) => {
                    play = play.clamp(now.flap - half, now.flap + half);
                    play * pressure
                }
                Self::BayExponential(scale) => ((now.bay_c - 25.0) / scale).exp(),
                Self::Wash => now.throttle * now.airspeed_mps,
                Self::BlownFlap => now.throttle * now.flap,
                Self::Resonance(at, quality) => {
                    let ratio = now.rpm / at;
                    1.0 / ((1.0 - ratio * ratio).powi(2) + (ratio / quality).powi(2)).sqrt()
                }
                Self::Hose(period_s, damping) => {
                    let angular = std::f64::consts::TAU / period_s;
                    speed += step_s
                        * (angular * angular * (now.rate_radps[1] - position)
                            - 2.0 * damping * angular * speed);
                    position += step_s * speed;
                    position
                }
                Self::DeadBand(at) => (now.rate_radps[1].abs() - at).max(0.0),
            }
        };
        flight.iter().map(of).collect()
    }
}
