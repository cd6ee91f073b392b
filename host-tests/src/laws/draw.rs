//! Draws a trial from its seed.

use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;

use super::hidden::Hidden;
use crate::blind::Plan;
use crate::blind::draw::scenario;

/// A trial before it is flown.
#[derive(Clone, Debug, PartialEq)]
pub struct Case {
    /// Its seed.
    pub seed: u64,
    /// The hidden law, and its size over the residual's noise; none in a null flight.
    pub hidden: Option<(Hidden, f64)>,
    /// The scenario.
    pub scenario: String,
    /// Rms of the receiver's wander and of the barometer's, and of the barometer's fast noise, metres.
    pub noise_m: [f64; 3],
}

/// Draws a trial; one in three is a null flight.
#[must_use]
pub fn draw(seed: u64) -> Case {
    let mut random = ChaCha8Rng::seed_from_u64(seed ^ 0x1a35_0000_0000);
    let is_null = random.random_range(0..3) == 0;
    let law = Hidden::draw(&mut random);
    let size = (2.2_f64.ln() + (20.0_f64 / 2.2).ln() * random.random::<f64>()).exp();
    let noise_m =
        [random.random_range(0.4..2.0), random.random_range(0.1..0.6), random.random_range(0.1..0.5)];
    let scenario = quiet(&scenario(&mut random, Plan::Rich, seed));
    Case { seed, hidden: (!is_null).then_some((law, size)), scenario, noise_m }
}

/// The scenario with almost no noise on receiver and barometer: theirs is generated separately.
fn quiet(scenario: &str) -> String {
    let mut sensor = "";
    let mut text = String::new();
    for line in scenario.lines() {
        if let Some(name) = line.strip_prefix("[sensors.") {
            sensor = name;
        }
        let is_noise =
            line.starts_with("noise =") && (sensor.starts_with("gps") || sensor.starts_with("baro"));
        text += if is_noise { "noise = { white = 0.02, wander = 0.02, wander_time_s = 30 }" } else { line };
        text.push('\n');
    }
    text
}
