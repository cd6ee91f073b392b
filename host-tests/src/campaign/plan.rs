//! The plan of a campaign's flight, drawn from its seed and independent of the estimator's assumptions.

use rand::{Rng, RngExt as _};

/// Distribution of the reference's errors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Spread {
    /// Gaussian.
    Normal,
    /// Student's t with four degrees of freedom, scaled to the same deviation: outliers.
    HeavyTailed,
}

/// A manoeuvre in free flight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Manoeuvre {
    /// Duration, seconds.
    pub duration_s: f64,
    /// Commanded climb rate, m/s.
    pub climb_mps: f64,
    /// Commanded bank, rad.
    pub bank_rad: f64,
}

/// A flight before it is flown.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// Duration of captive flight until the hooks open, seconds.
    pub captive_s: f64,
    /// Duration of flight after that, seconds.
    pub free_s: f64,
    /// Whether the hooks open at all; if not, the mother ship continues.
    pub separates: bool,
    /// Initial altitude, metres.
    pub altitude_m: f64,
    /// Airspeed, m/s.
    pub airspeed_mps: f64,
    /// The mother ship's slow swings: amplitude (m), period (s), phase (rad).
    pub swings: [[f64; 3]; 3],
    /// Vertical gusts (1 sigma), m/s.
    pub gusts_mps: f64,
    /// Share of the vehicle's weight that its own wings carry under the pylon.
    pub lift_share: f64,
    /// Push of the ejector, m/s^2, and its duration in ticks.
    pub ejector: (f64, u32),
    /// Delay between the opening of the hooks and of the wire, ticks: the cable's slack.
    pub slack_ticks: usize,
    /// Ticks for which the parting contacts bounce.
    pub bounce_ticks: usize,
    /// The manoeuvres of free flight.
    pub manoeuvres: Vec<Manoeuvre>,
    /// Ticks between two fixes.
    pub fix_ticks: usize,
    /// Wander of the reference: sigma (m), correlation time (s).
    pub wander: (f64, f64),
    /// White noise of the reference's altitude, metres.
    pub fix_noise_m: f64,
    /// Distribution of that noise.
    pub spread: Spread,
    /// Number of satellites.
    pub satellites: u8,
    /// The barometer's offset, white and correlated noise, metres.
    pub baro_m: [f64; 3],
    /// The inertial unit's biases: specific force (m/s^2) and rate (rad/s).
    pub imu_bias: ([f64; 3], [f64; 3]),
    /// The engine's vibration at the inertial unit (m/s^2), and its frequency, Hz.
    pub vibration: (f64, f64),
    /// The mother ship's altitude: offset and slow error, metres.
    pub master_m: [f64; 2],
    /// Whether the mother ship sends messages.
    pub has_master: bool,
    /// Ticks between two of those messages.
    pub master_ticks: usize,
    /// Offset (m) and drift (m/s^2) of the vehicle's own unit that computes its inertial altitude, if it has
    /// one.
    pub own_unit: Option<(f64, f64)>,
    /// Whether there is an airspeed signal.
    pub has_airspeed: bool,
}

impl Plan {
    /// Draws a flight. `is_short`: short enough to fly in QEMU within seconds.
    pub fn draw(random: &mut impl Rng, is_short: bool) -> Self {
        let captive_s =
            if is_short { random.random_range(48.0..56.0) } else { random.random_range(60.0..120.0) };
        let free_s = if is_short { random.random_range(24.0..28.0) } else { random.random_range(40.0..60.0) };
        let mut manoeuvres = vec![Manoeuvre { duration_s: 6.0, climb_mps: -3.0, bank_rad: 0.0 }];
        while manoeuvres.iter().map(|one| one.duration_s).sum::<f64>() < free_s {
            let climb_mps = [-3.0, 0.0, 3.0, -8.0, -15.0][random.random_range(0..5)];
            let bank_rad = [0.0, 0.0, 0.35, -0.35, 0.5][random.random_range(0..5)];
            manoeuvres.push(Manoeuvre { duration_s: random.random_range(6.0..14.0), climb_mps, bank_rad });
        }
        let mut swing = |largest_m: f64| {
            [
                random.random_range(0.0..largest_m),
                random.random_range(18.0..60.0),
                random.random_range(0.0..std::f64::consts::TAU),
            ]
        };
        let swings = [swing(3.0), swing(2.0), swing(1.0)];
        let mut axes = |size: f64| core::array::from_fn(|_| random.random_range(-size..size));
        let imu_bias = (axes(0.04), axes(0.004));
        Self {
            captive_s,
            free_s,
            separates: random.random_bool(0.9),
            altitude_m: random.random_range(800.0..3_500.0),
            airspeed_mps: random.random_range(28.0..70.0),
            swings,
            gusts_mps: random.random_range(0.05..0.5),
            lift_share: random.random_range(0.1..0.6),
            ejector: (random.random_range(0.0..25.0), random.random_range(0..5)),
            slack_ticks: random.random_range(0..50),
            bounce_ticks: if random.random_bool(0.4) { random.random_range(1..5) } else { 0 },
            manoeuvres,
            fix_ticks: if random.random_bool(0.5) { 20 } else { 40 },
            wander: (random.random_range(0.3..1.8), random.random_range(20.0..120.0)),
            fix_noise_m: random.random_range(0.05..0.6),
            spread: if random.random_bool(0.4) { Spread::HeavyTailed } else { Spread::Normal },
            satellites: random.random_range(8..18),
            baro_m: [
                random.random_range(-120.0..120.0),
                random.random_range(0.05..0.3),
                random.random_range(0.05..0.5),
            ],
            imu_bias,
            vibration: (random.random_range(0.0..1.0), random.random_range(35.0..95.0)),
            master_m: [random.random_range(-60.0..60.0), random.random_range(0.0..2.0)],
            has_master: random.random_bool(0.8),
            master_ticks: random.random_range(10..=40),
            own_unit: random
                .random_bool(0.25)
                .then(|| (random.random_range(-40.0..40.0), random.random_range(-0.004..0.004))),
            has_airspeed: random.random_bool(0.5),
        }
    }

    /// The tick at which the hooks open, or would open.
    #[must_use]
    pub fn separation(&self) -> usize {
        (self.captive_s * 200.0) as usize
    }

    /// Number of ticks.
    #[must_use]
    pub fn ticks(&self) -> usize {
        self.separation() + (self.free_s * 200.0) as usize
    }
}
