//! What an effect adds to the readings of a flight, tick by tick.

use kf_core::effect::Regressor;

use super::follower::{Follower, Phase};
use replay::Replay;

/// Coefficient times regressor at every tick that has it (times in microseconds, metres), less its mean over
/// captive flight, which the calibration takes for bias.
#[must_use]
pub fn prediction(replay: &Replay<'_>, regressor: Regressor, coefficient: f64) -> Vec<(u64, f64)> {
    let mut follower = Follower::knowing(replay.model(), [regressor]);
    let mut predicted = Vec::new();
    let (mut sum_m, mut count) = (0.0, 0_u64);
    for input in replay.mission_inputs() {
        let taken = follower.take(&input);
        if taken.phase == Phase::Ignored {
            continue;
        }
        let Some(regressor_m) = follower.value_m(regressor) else { continue };
        let metres = coefficient * f64::from(regressor_m);
        if taken.phase == Phase::Captive {
            sum_m += metres;
            count += 1;
        }
        predicted.push((input.time_us, metres));
    }
    let mean_m = if count > 0 { sum_m / count as f64 } else { 0.0 };
    predicted.iter_mut().for_each(|(_, metres)| *metres -= mean_m);
    predicted
}
