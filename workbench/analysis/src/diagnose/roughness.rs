//! Which regressors are only roughly known, and how roughly.

use kf_core::effect::EffectId;

use super::epochs::Epochs;
use super::signals::CLIMBED;

/// The share of a coefficient that is uncertain in addition to its noise: signals have delays and scale
/// errors of their own.
const SCALE: f64 = 0.02;

/// The same where a regressor is integrated twice from accelerometers and attitudes.
const SCALE_INTEGRATED: f64 = 0.05;

/// The same where the airspeed is not measured and the speed over ground replaces it: wind.
const SCALE_WITHOUT_AIRSPEED: f64 = 0.2;

/// The same for a delay where the climb rate is not measured but estimated, with the delay in steps and a low
/// pass treated as a pure delay: the relative errors that `cargo xtask real-trials` finds for delays in
/// flights made of real tracks are 0.09, rms, in the development half.
const SCALE_WITHOUT_CLIMB_RATE: f64 = 0.1;

/// How much a scale may change from one part of a flight to another because it is not constant, where the
/// climb rate is not measured. A pressure altitude's error relative to the height equals the air
/// temperature's relative deviation from the standard, which within hours and kilometres changes by a kelvin
/// in 288. (The halves of the development half's logs differ by that in addition to their sigmas.) A scale
/// that may be entirely due to this is not a missing effect.
const UNSTEADY_SCALE: f64 = 1.0 / 288.0;

/// Whether an effect's regressor is known only to about ten per cent: the airspeed is not measured, or the
/// regressor is integrated twice from specific forces and attitudes, whose small errors grow.
fn is_rough(epochs: &[Epochs], effect: EffectId) -> bool {
    let is_integrated = matches!(
        effect,
        EffectId::ImuAccelScale | EffectId::ImuTilt | EffectId::ImuGyroBias | EffectId::ImuVibration
    );
    is_integrated || lacks_airspeed(epochs, effect)
}

/// Relative error (squares) of the shape of what an effect contributes to a tenth of a flight
/// ([`super::shape_error`]).
const SHAPE: f64 = 0.01;
/// The same where a regressor is only roughly known.
const ROUGH_SHAPE: f64 = 0.03;
/// The same without an airspeed: a wind of a sixth of it makes its square wrong by a third.
const SHAPE_WITHOUT_AIRSPEED: f64 = 0.1;

/// Relative error (squares) of an effect's shape.
pub(super) fn shape(epochs: &[Epochs], effect: EffectId) -> f64 {
    if lacks_airspeed(epochs, effect) {
        SHAPE_WITHOUT_AIRSPEED
    } else if is_rough(epochs, effect) {
        ROUGH_SHAPE
    } else {
        SHAPE
    }
}

/// Whether an effect is computed from the airspeed and a flight lacks a measured one.
pub(super) fn lacks_airspeed(epochs: &[Epochs], effect: EffectId) -> bool {
    effect.needs().contains(&"tas_mps")
        && epochs.iter().any(|epochs| epochs.signals.iter().all(|block| !block[0].is_finite()))
}

/// Whether an effect is a lag and a flight lacks the climb rate.
fn lacks_climb_rate(epochs: &[Epochs], effect: EffectId) -> bool {
    matches!(effect, EffectId::BaroLag | EffectId::GpsLatency)
        && epochs.iter().any(|epochs| epochs.signals.iter().all(|block| !block[CLIMBED].is_finite()))
}

/// The share of an effect's coefficient that is uncertain in addition to its noise.
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

/// Uncertainty of an effect's coefficient in addition to its noise and to the share [`scale`], in its unit.
pub(super) fn unsteadiness(effect: EffectId, has_climb_rate: bool) -> f64 {
    if effect == EffectId::BaroScale && !has_climb_rate { UNSTEADY_SCALE } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Only a scale is unsteady, because the air's temperature changes, and only where no climb rate
    /// distinguishes it from the air.
    #[test]
    fn only_a_scale_without_a_climb_rate_is_unsteady() {
        assert!(unsteadiness(EffectId::BaroScale, false) > 0.0);
        assert_eq!(unsteadiness(EffectId::BaroScale, true), 0.0);
        assert_eq!(unsteadiness(EffectId::BaroLag, false), 0.0);
    }
}
