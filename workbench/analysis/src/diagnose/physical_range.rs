//! What nature allows of a coefficient, as a prior: outside of it an effect is no suspect.

use kf_core::effect::EffectId;

use super::information::Solution;
use flight_data::Channel;
use replay::Replay;

/// Where the climb rate is measured a coefficient explains nothing when it is so many times beyond its range. It is this wide because
/// the blind trials' simulated flights hide broken parts, of either sign and twice the range, and because several effects there
/// stand in for each other at sizes that none of them has.
const IMPOSSIBLE: f64 = 100.0;
/// A fitted coefficient may be that many sigmas outside of a range and come from inside of it: 2.3 % one-sided.
const SIGMAS: f64 = 2.0;

/// The range of a coefficient.
///
/// Where the climb rate is not measured it is exactly nature's, its sign included: with one free sensor all that can be seen of a
/// lag and of a latency is their difference, and its sign is what names it.
#[must_use]
pub fn range(effect: EffectId, has_climb_rate: bool) -> [f64; 2] {
    let [least, most] = effect.plausible().map(f64::from);
    if has_climb_rate {
        let largest = least.abs().max(most.abs());
        [-IMPOSSIBLE * largest, IMPOSSIBLE * largest]
    } else {
        [least, most]
    }
}

/// A coefficient's range, and the share of it that is unsure beside its noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Least and most.
    pub range: [f64; 2],
    /// The share.
    pub scale: f64,
}

/// Whether every coefficient of a fit may come from its range: by the sigma that is reported of it.
#[must_use]
pub fn is_possible(bounds: &[Bounds], solution: &Solution) -> bool {
    let n = solution.coefficients.len();
    solution.coefficients.iter().zip(bounds).enumerate().all(|(k, (coefficient, bounds))| {
        let Bounds { range: [least, most], scale } = *bounds;
        let rough = scale * coefficient;
        let slack = SIGMAS * (solution.covariance[k * n + k] + rough * rough).sqrt();
        (least - slack..=most + slack).contains(coefficient)
    })
}

/// Whether a flight has the climb rate measured, and not only as the slope of the altitude.
#[must_use]
pub fn measures_climb_rate(replay: &Replay<'_>) -> bool {
    let down = replay.flight().channel(Channel::GpsVdMps);
    down.is_some_and(|column| column.samples().next().is_some())
}
