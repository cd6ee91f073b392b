//! What a flight could have shown.

use kf_core::effect::EffectId;

use super::candidates::Candidate;
use super::information::Information;

/// An effect is seen when its coefficient exceeds this many sigmas, which accounts for the number of
/// candidates tried.
pub(super) const SEEN_SIGMAS: f64 = 4.5;
/// A flight excites a sensor enough if it would have shown this share of the effects that could act on it.
const ENOUGH: f64 = 0.5;

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
/// effects.
#[must_use]
pub fn excitation(
    information: &Information,
    candidates: &[Candidate],
    columns: &[(usize, usize)],
    chosen: &[usize],
) -> Excitation {
    let mut excitation = Excitation::default();
    for (column, position) in columns {
        let effect = candidates[*column].effect();
        let largest = effect.plausible().iter().fold(0.0_f64, |most, bound| most.max(f64::from(bound.abs())));
        let others: Vec<usize> = chosen.iter().copied().filter(|other| other != position).collect();
        let picks: Vec<usize> = others.iter().copied().chain([*position]).collect();
        let sigma =
            information.solve(&picks).and_then(|solution| solution.covariance.last().map(|v| v.sqrt()));
        if sigma.is_some_and(|sigma| SEEN_SIGMAS * sigma < largest) {
            excitation.seen.push(*column);
            excitation.has_flown |= !matches!(effect, EffectId::BaroDrift | EffectId::BaroWarmUp);
        } else {
            excitation.unseen.push(*column);
        }
    }
    excitation
}
