//! What a regressor is made with beside the signals.

use serde::{Deserialize, Serialize};

use super::EffectId;

/// When the time `t` of an effect starts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Clock {
    /// At launch; before it `t` is 0.
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
    /// Its time constant, seconds; only looked at where [`EffectId::has_time_constant`].
    pub time_constant_s: f32,
    /// When its time starts; only looked at where [`EffectId::has_time_constant`].
    pub since: Clock,
}

impl Regressor {
    /// The regressor with a time constant of a minute, where it has one, and time from launch.
    #[must_use]
    pub const fn new(id: EffectId) -> Self {
        Self { id, time_constant_s: 60.0, since: Clock::Launch }
    }
}
