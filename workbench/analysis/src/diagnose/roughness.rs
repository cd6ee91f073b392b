//! Which regressors are known only roughly, and how roughly.

use kf_core::effect::EffectId;

use super::epochs::Epochs;
use super::signals::CLIMBED;

/// The share of a coefficient that is unsure beside its noise: signals are measured with delays and scale
/// errors of their own.
const SCALE: f64 = 0.02;

/// The same where a regressor is integrated twice from what accelerometers and attitudes say.
const SCALE_INTEGRATED: f64 = 0.05;

/// The same where the airspeed is not measured and the speed over ground stands in: wind.
const SCALE_WITHOUT_AIRSPEED: f64 = 0.2;

/// The same of a delay where the climb rate is not measured but estimated, with the delay in steps, and a low
/// pass is taken for a pure delay: the errors of the sizes that `cargo xtask real-trials` finds of delays in
/// flights made of real tracks are 0.09 of them, rms, in the development half.
const SCALE_WITHOUT_CLIMB_RATE: f64 = 0.1;

/// What a coefficient may be off by from one part of a flight to another because it is no constant, where the
/// climb rate is not measured: a pressure altitude is off by as much of the height as the air's temperature
/// is off the standard's, and within hours and kilometres that changes by a kelvin in 288. (The halves of the
/// development half's logs differ by that beside their sigmas.) A scale that may be all of that is no effect
/// that is missing.
const UNSTEADY_SCALE: f64 = 1.0 / 288.0;

/// Whether an effect's regressor is known only to some ten per cent: the airspeed is not measured, or it is
/// integrated twice from specific forces and attitudes, whose small errors grow.
pub(super) fn is_rough(epochs: &[Epochs], effect: EffectId) -> bool {
    let is_integrated = matches!(
        effect,
        EffectId::ImuAccelScale | EffectId::ImuTilt | EffectId::ImuGyroBias | EffectId::ImuVibration
    );
    is_integrated || lacks_airspeed(epochs, effect)
}

/// The share (squares) by which the shape of what an effect puts into a tenth of a flight is wrong
/// ([`super::shape_error`]).
const SHAPE: f64 = 0.01;
/// The same where a regressor is only roughly known.
const ROUGH_SHAPE: f64 = 0.03;
/// The same without an airspeed: a wind of a sixth of it makes its square wrong by a third.
const SHAPE_WITHOUT_AIRSPEED: f64 = 0.1;

/// The share (squares) by which the shape of an effect is wrong.
pub(super) fn shape(epochs: &[Epochs], effect: EffectId) -> f64 {
    if lacks_airspeed(epochs, effect) {
        SHAPE_WITHOUT_AIRSPEED
    } else if is_rough(epochs, effect) {
        ROUGH_SHAPE
    } else {
        SHAPE
    }
}

/// Whether an effect is made of the airspeed and a flight has it not measured.
pub(super) fn lacks_airspeed(epochs: &[Epochs], effect: EffectId) -> bool {
    effect.needs().contains(&"tas_mps")
        && epochs.iter().any(|epochs| epochs.signals.iter().all(|block| !block[0].is_finite()))
}

/// Whether an effect is a lag, and a flight has no climb rate.
fn lacks_climb_rate(epochs: &[Epochs], effect: EffectId) -> bool {
    matches!(effect, EffectId::BaroLag | EffectId::GpsLatency)
        && epochs.iter().any(|epochs| epochs.signals.iter().all(|block| !block[CLIMBED].is_finite()))
}

/// The share of an effect's coefficient that is unsure beside its noise.
pub(super) fn scale(epochs: &[Epochs], effect: EffectId) -> f64 {
    if lacks_airspeed(epochs, effect) {
        SCALE_WITHOUT_AIRSPEED
    } else if lacks_climb_rate(epochs, effect) {
        SCALE_WITHOUT_CLIMB_RATE
    } else if is_rough(epochs, effect) {
        SCALE_INTEGRATED
    } else {
        SCALE
    }
}

/// What an effect's coefficient is unsure by beside its noise and the share of it that is [`scale`], in its
/// unit.
pub(super) fn unsteadiness(effect: EffectId, has_climb_rate: bool) -> f64 {
    if effect == EffectId::BaroScale && !has_climb_rate { UNSTEADY_SCALE } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of all effects a scale alone is unsteady, as the air's temperature changes, and only where no climb
    /// rate tells it from the air.
    #[test]
    fn only_a_scale_without_a_climb_rate_is_unsteady() {
        assert!(unsteadiness(EffectId::BaroScale, false) > 0.0);
        assert_eq!(unsteadiness(EffectId::BaroScale, true), 0.0);
        assert_eq!(unsteadiness(EffectId::BaroLag, false), 0.0);
    }
}
