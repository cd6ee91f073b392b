//! The catalogue's delays as low passes, defined by formula in a model.
//!
//! The catalogue's lag and latency are the climb rate itself, times the delay. That is right where the climb
//! rate changes slowly. In a manoeuvre shorter than the delay, the late altitude is behind by less than that.
//! So the coefficient that fits best is too small, and even that removes little of the error. A tube, or a
//! receiver that filters, is a low pass (`delay.rs`), which the flight computer has as a formula. A pure delay
//! is nearly one, too: the mean of the last d seconds is late by d/2.

use kf_core::effect::EffectId;

use super::delay::{AGREES, DelayShape};

/// A delay of the catalogue, and its definition as a low pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LowPassDelay {
    /// The delay in the catalogue.
    pub catalogues: EffectId,
    /// Id of the definition.
    pub id: &'static str,
    /// What it acts on, in a definition's words.
    pub on: &'static str,
}

impl LowPassDelay {
    /// The formula, in metres per second of delay; `tau` is the low pass' time constant.
    pub const REGRESSOR: &'static str = "-lowpass(climb_rate_mps, tau)";

    const ALL: [Self; 2] = [
        Self { catalogues: EffectId::BaroLag, id: "baro.low_pass_lag", on: "baro" },
        Self { catalogues: EffectId::GpsLatency, id: "gps.low_pass_latency", on: "gps" },
    ];

    /// The delay that an effect is, whether the catalogue's own or defined as a low pass.
    #[must_use]
    pub fn of(effect: EffectId) -> Option<Self> {
        Self::ALL.into_iter().find(|delay| delay.is(effect))
    }

    /// Whether an effect is this delay, in either form. A user's own formula under the definition's id is not.
    #[must_use]
    pub fn is(self, effect: EffectId) -> bool {
        let is_low_pass = || effect.formula().is_some_and(|parts| parts.law == Self::REGRESSOR);
        effect == self.catalogues || effect.name() == self.id && is_low_pass()
    }

    /// The time constant, seconds, with which a delay of this shape and size is a low pass; `None` in the
    /// catalogue's own shape.
    #[must_use]
    pub(super) fn time_constant_s(shape: DelayShape, delay_s: f64) -> Option<f64> {
        match shape {
            DelayShape::Slope => None,
            // Between two shapes of the grid it is the delay itself; where the delay is longer than that, part
            // of it is a pure one.
            DelayShape::LowPass(time_s) => {
                Some(delay_s.clamp(f64::from(time_s) / AGREES, f64::from(time_s) * AGREES))
            }
            DelayShape::Pure(_) => Some(delay_s / 2.0),
        }
    }
}

/// Whether two effects are one: the same, or the same delay in two forms.
#[must_use]
pub fn is_same_effect(one: EffectId, other: EffectId) -> bool {
    one == other || LowPassDelay::of(one).is_some_and(|delay| delay.is(other))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A first-order lag is its own time constant, between the shapes that are tried; what is later than its
    /// shape says keeps the shape's, and a pure delay has half.
    #[test]
    fn a_delay_is_a_low_pass_of_the_time_that_fits() {
        let of = |shape, delay_s| LowPassDelay::time_constant_s(shape, delay_s);
        assert_eq!(of(DelayShape::Slope, 2.0), None);
        assert_eq!(of(DelayShape::LowPass(2.8), 2.9), Some(2.9));
        assert!((of(DelayShape::LowPass(2.8), 6.0).unwrap() - 2.8 * 1.2).abs() < 1e-6);
        assert_eq!(of(DelayShape::Pure(2.0), 2.2), Some(1.1));
    }

    #[test]
    fn other_effects_are_no_delays() {
        assert_eq!(LowPassDelay::of(EffectId::BaroScale), None);
        assert!(is_same_effect(EffectId::BaroScale, EffectId::BaroScale));
        assert!(!is_same_effect(EffectId::BaroLag, EffectId::GpsLatency));
    }
}
