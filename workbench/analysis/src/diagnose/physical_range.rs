//! The physical range of a coefficient, as a prior: outside of it an effect is not a suspect.

use kf_core::effect::EffectId;

use super::information::Solution;
use flight_data::Channel;
use replay::Replay;

/// A fitted coefficient may be this many sigmas outside a range and still come from inside it: 2.3 %
/// one-sided.
const SIGMAS: f64 = 2.0;

/// A range is a round number: where the climb rate is measured, up to a quarter beyond it is still allowed.
const LENIENT: f64 = 1.25;

/// Factor by which the range grows for an effect that stands in for another: an acceleration for an angle of
/// attack (6.3 a radian at 0.1 rad a g and 46 m of dynamic pressure are 29 m a g, its own range is 10), a
/// warming up for a temperature (5 m/K and 20 K are 100 m where its own is 50).
const STAND_INS: [(EffectId, f64); 2] = [(EffectId::BaroAcceleration, 3.0), (EffectId::BaroWarmUp, 2.0)];

/// The range of a coefficient: the physical one, its sign included. With one sensor in free flight, only the
/// difference of a lag and a latency can be seen, and its sign decides which of the two it is; with more
/// sensors, an effect that would need an impossible size is a different effect. Where the climb rate is not
/// measured, the range is exactly the physical one.
#[must_use]
pub fn range(effect: EffectId, has_climb_rate: bool) -> [f64; 2] {
    let stand_in = STAND_INS.iter().find(|(stand_in, _)| *stand_in == effect);
    let reach = if has_climb_rate { LENIENT * stand_in.map_or(1.0, |(_, reach)| *reach) } else { 1.0 };
    effect.plausible().map(|limit| reach * f64::from(limit))
}

/// Whether a coefficient with that sigma is outside the effect's own physical range, so that the effect
/// stands in for another one; where the climb rate is measured.
#[must_use]
pub fn stands_in(effect: EffectId, coefficient: f64, sigma: f64) -> bool {
    let [least, most] = effect.plausible().map(|limit| LENIENT * f64::from(limit));
    let slack = SIGMAS * sigma;
    STAND_INS.iter().any(|(stand_in, _)| *stand_in == effect)
        && !(least - slack..=most + slack).contains(&coefficient)
}

/// A coefficient's range, and the share of it that is uncertain in addition to its noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Smallest and largest value.
    pub range: [f64; 2],
    /// The uncertain share.
    pub scale: f64,
    /// What agrees with the column's own shape.
    pub consistent: [f64; 2],
}

/// Whether every coefficient of a fit may come from its range, given its reported sigma.
#[must_use]
pub fn is_possible(bounds: &[Bounds], solution: &Solution) -> bool {
    all_within(bounds, solution, |bounds| bounds.range)
}

/// Whether every coefficient of a fit may agree with its column's shape, given its reported sigma.
#[must_use]
pub fn is_consistent(bounds: &[Bounds], solution: &Solution) -> bool {
    all_within(bounds, solution, |bounds| bounds.consistent)
}

fn all_within(bounds: &[Bounds], solution: &Solution, limits: impl Fn(&Bounds) -> [f64; 2]) -> bool {
    let n = solution.coefficients.len();
    solution.coefficients.iter().zip(bounds).enumerate().all(|(k, (coefficient, bounds))| {
        let [least, most] = limits(bounds);
        let rough = bounds.scale * coefficient;
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
        let range = range(effect, has_climb_rate);
        let bounds = Bounds { range, scale: 0.0, consistent: [f64::NEG_INFINITY, f64::INFINITY] };
        let solution = Solution {
            coefficients: vec![coefficient],
            covariance: vec![sigma * sigma],
            log_determinant: 0.0,
            rest: 0.0,
        };
        is_possible(&[bounds], &solution)
    }

    /// The range includes the sign: a barometer is never early, and a receiver by a second at most.
    #[test]
    fn a_barometer_is_never_early() {
        for has_climb_rate in [false, true] {
            assert!(may_be(EffectId::BaroLag, has_climb_rate, 2.0, 0.1));
            assert!(may_be(EffectId::BaroLag, has_climb_rate, -0.1, 0.06));
            assert!(!may_be(EffectId::BaroLag, has_climb_rate, -0.3, 0.1));
            assert!(!may_be(EffectId::GpsLatency, has_climb_rate, -2.0, 0.1));
        }
    }

    /// A quarter beyond the range where the climb rate is measured, and three times the range for an
    /// acceleration that stands in for another effect: not 67 m a g.
    #[test]
    fn beyond_nature_is_no_suspect() {
        assert!(may_be(EffectId::BaroLag, true, 6.2, 0.01) && !may_be(EffectId::BaroLag, true, 6.4, 0.01));
        assert!(!may_be(EffectId::BaroLag, false, 5.2, 0.01));
        assert!(may_be(EffectId::BaroAcceleration, true, -30.0, 1.0));
        assert!(!may_be(EffectId::BaroAcceleration, true, -67.0, 2.5));
        assert!(!may_be(EffectId::BaroAcceleration, false, -30.0, 1.0));
    }

    /// A warming up of more than its own 62.5 m stands in for a temperature; one within two sigmas of that
    /// may be itself, and a scale stands in for nothing.
    #[test]
    fn what_is_beyond_its_own_range_stands_in() {
        assert!(stands_in(EffectId::BaroWarmUp, -89.5, 4.4) && stands_in(EffectId::BaroWarmUp, 70.0, 3.0));
        assert!(!stands_in(EffectId::BaroWarmUp, -40.0, 4.0) && !stands_in(EffectId::BaroWarmUp, 70.0, 4.0));
        assert!(!stands_in(EffectId::BaroScale, 5.0, 0.1));
    }
}
