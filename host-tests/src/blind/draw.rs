//! Draws the content of a trial from its seed.

use std::fmt::Write as _;

use pylon::simulate::scenario::EffectId;
use rand::{Rng, RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;

use super::outside::Outside;

/// What is hidden in a flight.
#[derive(Clone, Debug, PartialEq)]
pub enum Kind {
    /// Nothing.
    Null,
    /// Effects of the catalogue: id, time constant (s), and size over the residual's noise.
    Effects(Vec<(EffectId, Option<f64>, f64)>),
    /// A cause that is not in the catalogue, and its size over the residual's noise.
    Outside(Outside, f64),
    /// A receiver that filters its altitude with this time constant, s.
    SmoothedGps(f64),
    /// A receiver whose altitude jumps by this many metres and returns.
    Glitch(f64),
}

/// How much the free flight excites.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Plan {
    /// Dives, climbs, turns, speed changes.
    Rich,
    /// Two or three manoeuvres.
    Poor,
    /// Straight and level flight.
    Level,
}

/// The generator that flies a trial.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum Family {
    /// `pylon simulate`: forces move the aircraft; the noise is the estimator's own.
    #[default]
    Dynamic,
    /// Other motion, the effects by their physics, and noise that the estimator does not assume.
    Kinematic,
}

/// A trial before its flight.
#[derive(Clone, Debug, PartialEq)]
pub struct Case {
    /// Its generator.
    pub family: Family,
    /// Its seed.
    pub seed: u64,
    /// What is hidden.
    pub kind: Kind,
    /// How rich the flight is.
    pub plan: Plan,
    /// The scenario, without effects; for the kinematic family it contains only a name.
    pub scenario: String,
    /// Columns that were not recorded.
    pub missing: Vec<&'static str>,
}

/// Draws a trial.
#[must_use]
pub fn draw(family: Family, seed: u64) -> Case {
    match family {
        Family::Dynamic => dynamic(seed),
        Family::Kinematic => super::kinematic::draw(seed),
    }
}

fn dynamic(seed: u64) -> Case {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let plan = plan(&mut random);
    let kind = kind(&mut random);
    let missing = missing(&MAY_BE_MISSING, &mut random);
    let scenario = scenario(&mut random, plan, seed);
    Case { family: Family::Dynamic, seed, kind, plan, scenario, missing }
}

pub(super) fn plan(random: &mut impl Rng) -> Plan {
    match random.random_range(0..100) {
        0..60 => Plan::Rich,
        60..85 => Plan::Poor,
        _ => Plan::Level,
    }
}

pub(super) fn log_uniform(random: &mut impl Rng, low: f64, high: f64) -> f64 {
    (low.ln() + (high / low).ln() * random.random::<f64>()).exp()
}

pub(super) fn kind(random: &mut impl Rng) -> Kind {
    let size = |random: &mut ChaCha| log_uniform(random, 0.7, 30.0);
    let mut inner = ChaCha::seed_from_u64(random.random());
    match random.random_range(0..100) {
        0..18 => Kind::Null,
        18..22 => Kind::SmoothedGps(log_uniform(&mut inner, 0.5, 4.0)),
        22..27 => Kind::Glitch(log_uniform(&mut inner, 5.0, 60.0)),
        27..39 => {
            let outside = Outside::ALL[inner.random_range(0..Outside::ALL.len())];
            let size = size(&mut inner);
            Kind::Outside(outside, size)
        }
        which => {
            let count = if which < 82 {
                1
            } else if which < 94 {
                2
            } else {
                3
            };
            let mut effects: Vec<(EffectId, Option<f64>, f64)> = Vec::new();
            while effects.len() < count {
                let id = EffectId::ALL[inner.random_range(0..EffectId::ALL.len())];
                let is_new = effects.iter().all(|(other, ..)| *other != id);
                if id != EffectId::BaroHysteresis && is_new {
                    let has_time = matches!(id, EffectId::BaroWarmUp | EffectId::GpsConvergence);
                    let time_s = has_time.then(|| log_uniform(&mut inner, 10.0, 100.0));
                    effects.push((id, time_s, size(&mut inner)));
                }
            }
            Kind::Effects(effects)
        }
    }
}

type ChaCha = ChaCha8Rng;

/// Groups of columns that a flight may lack, with the chance per hundred.
const MAY_BE_MISSING: [(&[&str], u32); 6] = [
    (&["aoa_rad", "sideslip_rad"], 15),
    (&["tas_mps"], 8),
    (&["throttle"], 10),
    (&["baro_temp_c"], 10),
    (&["oat_c"], 30),
    (&["imu_master_alt_m"], 20),
];

/// Draws the columns that were not recorded, from groups that a flight may lack with a chance per hundred.
pub(super) fn missing(may_be: &[(&'static [&'static str], u32)], random: &mut impl Rng) -> Vec<&'static str> {
    let mut missing: Vec<&'static str> = Vec::new();
    for (columns, chance) in may_be {
        if random.random_range(0..100) < *chance {
            for column in *columns {
                if !missing.contains(column) {
                    missing.push(column);
                }
            }
        }
    }
    missing
}

pub(crate) fn scenario(random: &mut impl Rng, plan: Plan, seed: u64) -> String {
    let mut text = String::new();
    let mut put = |line: &str| {
        let _ = writeln!(text, "{line}");
    };
    let speed = random.random_range(24.0..34.0);
    let captive_s = random.random_range(60.0..180.0);
    // A mother ship in a deep phugoid sweeps the speed.
    let sweeps = random.random_range(0..100) < 12;
    let amplitude = if sweeps { random.random_range(12.0..25.0) } else { random.random_range(0.0..4.0) };
    put(&format!("name = \"blind {seed}\"\nseed = {seed}\nlatitude_deg = 45.0"));
    put(&format!("[vehicle]\nname = \"simulated\"\nvibration_mps2 = {:.3}", random.random_range(0.1..1.5)));
    put(&format!(
        "[captive]\nduration_s = {captive_s:.1}\naltitude_m = {:.1}\nairspeed_mps = {speed:.2}\nheading_deg = {:.1}\nphugoid_amplitude_m = {amplitude:.2}\nphugoid_period_s = {:.1}\nsettling_s = 10.0",
        random.random_range(1500.0..2500.0),
        random.random_range(0.0..360.0),
        random.random_range(15.0..30.0),
    ));
    put(&format!(
        "[wind]\nnorth_mps = {:.2}\neast_mps = {:.2}\nshear_north_per_s = {:.4}",
        random.random_range(-8.0..8.0),
        random.random_range(-8.0..8.0),
        random.random_range(-0.004..0.004)
    ));
    put(&format!(
        "[turbulence]\nhorizontal_sigma_mps = {:.2}\nvertical_sigma_mps = {:.2}",
        random.random_range(0.1..1.2),
        random.random_range(0.1..0.8)
    ));
    match plan {
        Plan::Level => put(&format!(
            "[[free_flight]]\nmanoeuvre = \"straight\"\nduration_s = {:.1}",
            random.random_range(60.0..240.0)
        )),
        Plan::Poor => {
            for _ in 0..random.random_range(1..4) {
                put(&segment(random, speed));
            }
        }
        Plan::Rich => {
            for _ in 0..random.random_range(7..16) {
                put(&segment(random, speed));
            }
        }
    }
    put(&format!(
        "[sensors.gps]\nnoise = {{ white = {:.2}, wander = {:.2}, wander_time_s = {:.0} }}",
        log_uniform(random, 0.1, 1.0),
        log_uniform(random, 0.5, 3.0),
        log_uniform(random, 25.0, 150.0)
    ));
    put(&format!(
        "[sensors.baro]\nbias_m = {:.1}\nnoise = {{ white = {:.2}, wander = {:.2}, wander_time_s = {:.0} }}",
        random.random_range(-60.0..60.0),
        log_uniform(random, 0.1, 1.0),
        log_uniform(random, 0.1, 1.0),
        log_uniform(random, 5.0, 80.0)
    ));
    put(&format!(
        "[sensors.imu_slave]\nbias_m = {:.1}\nnoise = {{ white = {:.2}, wander = {:.2}, wander_time_s = {:.0} }}",
        random.random_range(-60.0..60.0),
        log_uniform(random, 0.05, 0.6),
        log_uniform(random, 0.1, 1.0),
        log_uniform(random, 10.0, 100.0)
    ));
    text
}

/// One manoeuvre; climbs follow dives often enough to keep the aircraft in the air.
fn segment(random: &mut impl Rng, cruise: f64) -> String {
    let duration_s = random.random_range(8.0..25.0);
    let (name, extra) = match random.random_range(0..8) {
        0 => (
            "dive",
            format!(
                "flight_path_deg = {:.1}\nairspeed_mps = {:.1}",
                random.random_range(-25.0..-8.0),
                cruise * 1.4
            ),
        ),
        1 => (
            "climb",
            format!("flight_path_deg = {:.1}\nairspeed_mps = {:.1}", random.random_range(5.0..11.0), cruise),
        ),
        2 => ("level_off", format!("airspeed_mps = {:.1}", cruise * random.random_range(0.95..1.2))),
        3 => (
            "pull_up",
            format!(
                "flight_path_deg = {:.1}\nload_factor = {:.2}",
                random.random_range(6.0..12.0),
                random.random_range(1.6..3.0)
            ),
        ),
        4 => ("turn", format!("bank_deg = {:.0}", random.random_range(20.0..55.0))),
        5 => ("turn", format!("bank_deg = {:.0}", random.random_range(-55.0..-20.0))),
        6 => ("accelerate", format!("airspeed_mps = {:.1}", cruise * random.random_range(1.2..1.5))),
        _ => ("decelerate", format!("airspeed_mps = {:.1}", cruise * random.random_range(0.9..1.0))),
    };
    format!("[[free_flight]]\nmanoeuvre = \"{name}\"\nduration_s = {duration_s:.1}\n{extra}")
}
