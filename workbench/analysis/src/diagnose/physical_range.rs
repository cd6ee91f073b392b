//! What nature allows of a coefficient, as a prior: outside of it an effect is no suspect.

use kf_core::effect::EffectId;

use super::information::Solution;
use flight_data::Channel;
use replay::Replay;

/// A fitted coefficient may be that many sigmas outside of a range and come from inside of it: 2.3 % one-sided.
const SIGMAS: f64 = 2.0;

/// A range is a round number: where the climb rate is measured, a quarter beyond it is not impossible yet.
const LENIENT: f64 = 1.25;

/// By how much more than it has by itself an effect may reach that stands in for another one: an acceleration for an angle of attack (6.3 a
/// radian at 0.1 rad a g and 46 m of dynamic pressure are 29 m a g, its own range is 10), a warming up for a temperature (5 m/K and 20 K are 100 m
/// where its own is 50).
const STAND_INS: [(EffectId, f64); 2] = [(EffectId::BaroAcceleration, 3.0), (EffectId::BaroWarmUp, 2.0)];

/// The range of a coefficient: nature's, its sign included. With one free sensor all that can be seen of a lag and of a latency is their
/// difference, and its sign is what names it; with more of them, what would need an impossible size is another effect. Where the climb rate is not
/// measured it is exactly nature's.
#[must_use]
pub fn range(effect: EffectId, has_climb_rate: bool) -> [f64; 2] {
    let stand_in = STAND_INS.iter().find(|(stand_in, _)| *stand_in == effect);
    let reach = if has_climb_rate { LENIENT * stand_in.map_or(1.0, |(_, reach)| *reach) } else { 1.0 };
    effect.plausible().map(|limit| reach * f64::from(limit))
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
