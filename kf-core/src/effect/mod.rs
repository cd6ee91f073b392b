//! Effects: physical causes that add `coefficient * regressor(signals)` to what a sensor reads.
//!
//! The catalogue ([`EffectId`]) has one row per effect; [`SignalTracker`] computes the regressors from the
//! signals, tick by tick. A model adds effects of its own by formula ([`Definition`]), which
//! [`crate::formula`] runs.

mod acting;
mod barometer;
mod catalogue;
mod definition;
mod formulas;
mod forward_error;
mod free_flight_integrals;
mod inertial;
mod inertial_altitude;
mod integral;
mod reference;
mod reference_motion;
mod regressor;
mod tracker;

pub(crate) use acting::ActingEffects;
pub use barometer::dynamic_pressure_head_m;
pub(crate) use catalogue::Uses;
pub use catalogue::{EffectId, EffectSubject};
pub use definition::{Defined, Definition, Parts};
pub(crate) use formulas::{FormulaWords, Formulas};
pub use formulas::{MAX_FORMULA_WORDS, formula_words};
pub use free_flight_integrals::AccelerationSource;
pub use regressor::{Clock, Regressor};
pub use tracker::{AirspeedSource, DEFAULT_LATITUDE_DEG, SignalTracker};

/// An effect that a model accounts for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EffectTerm {
    /// Which effect, and with which time constant and clock.
    pub regressor: Regressor,
    /// Its coefficient, in [`EffectId::unit`]; the prior mean when it is estimated.
    pub coefficient: f32,
    /// One sigma of the coefficient, same unit; the prior's when it is estimated.
    pub sigma: f32,
    /// Smallest and largest regressor seen while the coefficient was learned, metres per unit of coefficient;
    /// outside of them the coefficient is extrapolated.
    pub envelope_m: Option<[f32; 2]>,
}

impl EffectTerm {
    /// A term with the effect's standard regressor ([`Regressor::new`]) and no envelope.
    #[must_use]
    pub const fn new(id: EffectId, coefficient: f32, sigma: f32) -> Self {
        Self { regressor: Regressor::new(id), coefficient, sigma, envelope_m: None }
    }

    /// Which effect.
    #[must_use]
    pub const fn id(&self) -> EffectId {
        self.regressor.id
    }

    /// Whether its regressor is integrated from launch on, and so depends on the whole flight.
    #[must_use]
    pub(crate) fn is_integrated(&self) -> bool {
        match self.id().formula() {
            Some(formula) => formula.program.is_integrated(),
            None => self.id().row().uses.any_of(Uses::INTEGRATED.and(Uses::VIBRATION)),
        }
    }

    /// Whether a regressor (metres) lies outside the range in which the coefficient was learned.
    #[must_use]
    #[inline]
    pub fn extrapolates(&self, regressor_m: f32) -> bool {
        self.envelope_m.is_some_and(|[least, largest]| regressor_m < least || regressor_m > largest)
    }
}

#[cfg(test)]
mod tests;
