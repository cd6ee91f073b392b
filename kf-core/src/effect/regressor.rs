//! Parameters of a regressor beside the signals.

use serde::{Deserialize, Serialize};

use super::EffectId;

/// Start of an effect's time `t`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Clock {
    /// At launch; `t` is 0 before it.
    #[default]
    Launch,
    /// At the first tick: power-on. For effects with a time constant only.
    Start,
}

impl Clock {
    /// The name used in model files.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Launch => "launch",
            Self::Start => "start",
        }
    }
}

/// An effect's regressor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Regressor {
    /// Which effect.
    pub id: EffectId,
    /// Its time constant, seconds; only used where [`EffectId::has_time_constant`].
    pub time_constant_s: f32,
    /// Start of its time; only used where [`EffectId::has_time_constant`].
    pub since: Clock,
}

impl Regressor {
    /// The regressor with a time constant of a minute, where it has one, and time from launch.
    #[must_use]
    pub const fn new(id: EffectId) -> Self {
        Self { id, time_constant_s: 60.0, since: Clock::Launch }
    }
}
