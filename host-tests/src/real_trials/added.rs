//! One effect added to a flight, with a given size over its noise.

use kf_core::effect::EffectId;
use pylon::flight::{Channel, Flight};
use rand::RngExt as _;
use rand_chacha::ChaCha8Rng;

use super::made::Track;
use crate::real_logs::Injection;

/// Sizes over the noise, rms: from the smallest that must be named to the largest.
const SIZES: std::ops::Range<f64> = 2.2..6.0;

/// The injections, in units of their coefficients; a lag is a low pass like a tube, or a pure delay like a
/// wrong time stamp.
pub const UNITS: [Injection; 9] = [
    Injection::Scale(0.01),
    Injection::Scale(-0.01),
    Injection::Lag(1.0),
    Injection::LagLowPass(1.0),
    Injection::Latency(1.0),
    Injection::Drift(0.001),
    Injection::Drift(-0.001),
    Injection::DynamicPressure(0.1),
    Injection::DynamicPressure(-0.1),
];

/// An injection of that kind with a drawn size, so that its sum with the flight's own coefficient is within
/// what nature allows; `None` where that is not over twice the noise, or where the flight lacks a signal that
/// it needs.
pub fn sized(
    unit: Injection,
    own: f64,
    flight: &Flight,
    track: &Track,
    random: &mut ChaCha8Rng,
) -> Option<Injection> {
    let size = (SIZES.start.ln() + (SIZES.end / SIZES.start).ln() * random.random::<f64>()).exp();
    let mut one = flight.clone();
    unit.inject(&mut one).ok()?;
    let spread_m = spread_m(flight, &one, &track.used);
    // Effects of the climb rate change within half a minute, and only need to be distinguished from noise
    // that does so too.
    let is_fast = matches!(unit.effect(), "baro.lag" | "gps.latency");
    let noise_m = if is_fast { track.fast_m } else { track.noise_m() };
    if spread_m <= 0.0 {
        return None;
    }
    let bounds = EffectId::from_name(unit.effect())?.plausible();
    let largest = f64::from(if unit.coefficient() > 0.0 { bounds[1] } else { bounds[0] });
    let least = SIZES.start * noise_m / spread_m;
    let most = (largest - own) / unit.coefficient();
    (least <= most).then(|| unit.times((size * noise_m / spread_m).min(most)))
}

/// Rms about the mean of an injection's change of the difference of both altitudes, metres.
fn spread_m(before: &Flight, after: &Flight, used: &std::ops::Range<usize>) -> f64 {
    let mut squares = 0.0;
    for channel in [Channel::BaroAltM, Channel::GpsAltM] {
        let (Some(old), Some(new)) = (before.channel(channel), after.channel(channel)) else { continue };
        let changes: Vec<f64> = used
            .clone()
            .filter_map(|row| Some(f64::from(new.get(row)?) - f64::from(old.get(row)?)))
            .collect();
        let mean = changes.iter().sum::<f64>() / changes.len().max(1) as f64;
        squares +=
            changes.iter().map(|change| (change - mean).powi(2)).sum::<f64>() / changes.len().max(1) as f64;
    }
    squares.sqrt()
}
