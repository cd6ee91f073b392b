//! Effects: physical causes that add `coefficient * regressor(signals)` to what a sensor reads.

use serde::{Deserialize, Serialize};

use crate::sensor::Sensor;

mod dynamic_pressure;
mod signals;

pub use dynamic_pressure::dynamic_pressure_head_m;
pub use signals::SignalHolder;

/// An effect of the catalogue.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[non_exhaustive]
pub enum EffectId {
    /// `V^2 / (2 g)`: the static port reads part of the dynamic pressure.
    BaroDynamicPressure,
}

impl EffectId {
    /// Every effect of the catalogue.
    pub const ALL: [Self; 1] = [Self::BaroDynamicPressure];

    /// The id used in model files and on the command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::BaroDynamicPressure => "baro.dynamic_pressure",
        }
    }

    /// Unit of the coefficient.
    #[must_use]
    pub const fn unit(self) -> &'static str {
        match self {
            Self::BaroDynamicPressure => "1",
        }
    }

    /// The sensor that the effect acts on.
    #[must_use]
    pub const fn sensor(self) -> Sensor {
        match self {
            Self::BaroDynamicPressure => Sensor::Baro,
        }
    }

    /// The effect of that id, or `None`.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|effect| effect.name() == name)
    }

    /// A power of two near the regressor's size in flight (metres): the coefficient's state is kept
    /// in units of its inverse, so that every state of the filter is of the same order.
    #[must_use]
    pub const fn typical_regressor_m(self) -> f32 {
        match self {
            Self::BaroDynamicPressure => 256.0,
        }
    }
}

/// An effect that a model accounts for.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct EffectTerm {
    /// Which effect.
    pub id: EffectId,
    /// Its coefficient, in [`EffectId::unit`]; the prior mean when it is estimated.
    pub coefficient: f32,
    /// One sigma of the coefficient, same unit; the prior's when it is estimated.
    pub sigma: f32,
}
