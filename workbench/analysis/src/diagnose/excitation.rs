//! What a flight could have shown.

use kf_core::effect::EffectId;
use statistics::normal_above;

use super::candidates::Candidate;
use super::information::Information;

/// Probability with which an effect is to be found for a flight to have shown it.
const POWER: f64 = 0.9;
/// A flight excites a sensor enough if it would have shown this share of the effects that could act on it.
const ENOUGH: f64 = 0.5;

/// Probability that an effect of this size, in sigmas of its coefficient, is found: that its square, with the
/// noise's scatter of one sigma, exceeds what the search demands (`Suspects::penalty`).
#[must_use]
pub fn detection(sigmas: f64, penalty: f64) -> f64 {
    normal_above(penalty.sqrt() - sigmas)
}

/// Whether a flight would have shown a coefficient of this size.
#[must_use]
pub fn is_seen(sigmas: f64, penalty: f64) -> bool {
    detection(sigmas, penalty) >= POWER
}

/// Which of a sensor's effects a flight would have shown at a physically possible size.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Excitation {
    /// Columns that would have been seen.
    pub seen: Vec<usize>,
    /// Columns that would not have been seen.
    pub unseen: Vec<usize>,
    /// Whether one of those seen needs more than time. Hours on the ground show a drift and a warming up, and
    /// nothing of what a flight does to a sensor.
    pub has_flown: bool,
}

impl Excitation {
    /// Whether the flight would have shown enough of the effects.
    #[must_use]
    pub fn is_enough(&self) -> bool {
        let all = self.seen.len() + self.unseen.len();
        self.has_flown && self.seen.len() as f64 >= ENOUGH * all as f64
    }
}

/// Judges the candidates among `columns` (with their positions in `information`), each alone with the chosen
/// effects; the search demands `penalty` of an effect in twice the log likelihood.
#[must_use]
pub fn excitation(
    information: &Information,
    candidates: &[Candidate],
    columns: &[(usize, usize)],
    chosen: &[usize],
    penalty: f64,
) -> Excitation {
    let mut excitation = Excitation::default();
    for (column, position) in columns {
        let effect = candidates[*column].effect();
        let largest = effect.plausible().iter().fold(0.0_f64, |most, bound| most.max(f64::from(bound.abs())));
        let others: Vec<usize> = chosen.iter().copied().filter(|other| other != position).collect();
        let picks: Vec<usize> = others.iter().copied().chain([*position]).collect();
        let sigma =
            information.solve(&picks).and_then(|solution| solution.covariance.last().map(|v| v.sqrt()));
        if sigma.is_some_and(|sigma| is_seen(largest / sigma, penalty)) {
            excitation.seen.push(*column);
            excitation.has_flown |= !matches!(effect, EffectId::BaroDrift | EffectId::BaroWarmUp);
        } else {
            excitation.unseen.push(*column);
        }
    }
    excitation
}
