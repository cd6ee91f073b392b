//! The range of a regressor in a flight, tick by tick as in the mission.

use kf_core::effect::Regressor;

use super::follower::Follower;
use replay::Replay;

/// The smallest and the largest value of a regressor in some flights, captive and free, metres per unit of
/// the coefficient; `None` if it never had a value.
///
/// Only the reference and the settling time of the models are used.
#[must_use]
pub fn envelope_m<'a>(
    replays: impl IntoIterator<Item = &'a Replay<'a>>,
    regressor: Regressor,
) -> Option<[f32; 2]> {
    let mut range = None;
    for replay in replays {
        let mut follower = Follower::knowing(replay.model(), [regressor]);
        for input in replay.inputs() {
            follower.take(&input);
            let value = follower.raw_m(regressor).filter(|metres| metres.is_finite());
            if let Some(value) = value {
                let [least, largest] = range.unwrap_or([value; 2]);
                range = Some([value.min(least), value.max(largest)]);
            }
        }
    }
    range
}
