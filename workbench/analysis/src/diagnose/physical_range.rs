//! What nature allows of a coefficient, as a prior: outside of it an effect is no suspect.

use kf_core::effect::EffectId;

use super::information::Solution;
use flight_data::Channel;
use replay::Replay;

/// A fitted coefficient may be that many sigmas outside of a range and come from inside of it: 2.3 %
/// one-sided.
const SIGMAS: f64 = 2.0;

/// A range is a round number: where the climb rate is measured, a quarter beyond it is not impossible yet.
const LENIENT: f64 = 1.25;

/// By how much more than it has by itself an effect may reach that stands in for another one: an acceleration
/// for an angle of attack (6.3 a radian at 0.1 rad a g and 46 m of dynamic pressure are 29 m a g, its own
/// range is 10), a warming up for a temperature (5 m/K and 20 K are 100 m where its own is 50).
const STAND_INS: [(EffectId, f64); 2] = [(EffectId::BaroAcceleration, 3.0), (EffectId::BaroWarmUp, 2.0)];

/// The range of a coefficient: nature's, its sign included. With one free sensor all that can be seen of a
/// lag and of a latency is their difference, and its sign is what names it; with more of them, what would
/// need an impossible size is another effect. Where the climb rate is not measured it is exactly nature's.
#[must_use]
pub fn range(effect: EffectId, has_climb_rate: bool) -> [f64; 2] {
    let stand_in = STAND_INS.iter().find(|(stand_in, _)| *stand_in == effect);
    let reach = if has_climb_rate { LENIENT * stand_in.map_or(1.0, |(_, reach)| *reach) } else { 1.0 };
    effect.plausible().map(|limit| reach * f64::from(limit))
}

/// Whether a coefficient of that sigma is beyond what nature allows of the effect itself, so that the effect
/// is there for another one whose part it takes; where the climb rate is measured.
#[must_use]
pub fn stands_in(effect: EffectId, coefficient: f64, sigma: f64) -> bool {
    let [least, most] = effect.plausible().map(|limit| LENIENT * f64::from(limit));
    let slack = SIGMAS * sigma;
    STAND_INS.iter().any(|(stand_in, _)| *stand_in == effect)
        && !(least - slack..=most + slack).contains(&coefficient)
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

#[cfg(test)]
mod tests {
    use super::*;

    fn may_be(effect: EffectId, has_climb_rate: bool, coefficient: f64, sigma: f64) -> bool {
        let bounds = Bounds { range: range(effect, has_climb_rate), scale: 0.0 };
        let solution = Solution {
            coefficients: vec![coefficient],
            covariance: vec![sigma * sigma],
            log_determinant: 0.0,
            rest: 0.0,
        };
        is_possible(&[bounds], &solution)
    }

    /// Signs are part of it: a barometer is never early, and a receiver by a second at most.
    #[test]
    fn a_barometer_is_never_early() {
        for has_climb_rate in [false, true] {
            assert!(may_be(EffectId::BaroLag, has_climb_rate, 2.0, 0.1));
            assert!(may_be(EffectId::BaroLag, has_climb_rate, -0.1, 0.06));
            assert!(!may_be(EffectId::BaroLag, has_climb_rate, -0.3, 0.1));
            assert!(!may_be(EffectId::GpsLatency, has_climb_rate, -2.0, 0.1));
        }
    }

    /// A quarter beyond the range where the climb rate is measured, and three times an acceleration's for
    /// what it stands in for: not 67 m a g.
    #[test]
    fn beyond_nature_is_no_suspect() {
        assert!(may_be(EffectId::BaroLag, true, 6.2, 0.01) && !may_be(EffectId::BaroLag, true, 6.4, 0.01));
        assert!(!may_be(EffectId::BaroLag, false, 5.2, 0.01));
        assert!(may_be(EffectId::BaroAcceleration, true, -30.0, 1.0));
        assert!(!may_be(EffectId::BaroAcceleration, true, -67.0, 2.5));
        assert!(!may_be(EffectId::BaroAcceleration, false, -30.0, 1.0));
    }

    /// A warming up of more than its own 62.5 m is there for a temperature; one within two sigmas of it may
    /// be itself, and a scale is nobody else.
    #[test]
    fn what_is_beyond_its_own_range_stands_in() {
        assert!(stands_in(EffectId::BaroWarmUp, -89.5, 4.4) && stands_in(EffectId::BaroWarmUp, 70.0, 3.0));
        assert!(!stands_in(EffectId::BaroWarmUp, -40.0, 4.0) && !stands_in(EffectId::BaroWarmUp, 70.0, 4.0));
        assert!(!stands_in(EffectId::BaroScale, 5.0, 0.1));
    }
}
