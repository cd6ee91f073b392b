//! The free flight's plan: manoeuvres, one after the other.

use serde::Deserialize;

/// Kinds of manoeuvre.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Manoeuvre {
    /// Wings level; path and airspeed targets as before.
    Straight,
    /// Wings level, to a flight path below the horizon (`flight_path_deg` < 0).
    Dive,
    /// Wings level, to a flight path above the horizon (`flight_path_deg` > 0).
    Climb,
    /// Wings level, to a level flight path.
    LevelOff,
    /// Wings level, hard (`load_factor`) to a higher flight path.
    PullUp,
    /// Bank (`bank_deg`, positive to the right), path and airspeed targets as before.
    Turn,
    /// Wings level, to a higher airspeed.
    Accelerate,
    /// Wings level, to a lower airspeed.
    Decelerate,
}

impl Manoeuvre {
    /// Its name in a scenario.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Straight => "straight",
            Self::Dive => "dive",
            Self::Climb => "climb",
            Self::LevelOff => "level_off",
            Self::PullUp => "pull_up",
            Self::Turn => "turn",
            Self::Accelerate => "accelerate",
            Self::Decelerate => "decelerate",
        }
    }
}

/// One manoeuvre. Any segment may set a new airspeed target, which then holds until the next one.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Segment {
    /// Which manoeuvre.
    pub manoeuvre: Manoeuvre,
    /// How long it is held, s.
    pub duration_s: f64,
    /// Flight path target (dive, climb, pull_up), degrees above the horizon.
    pub flight_path_deg: Option<f64>,
    /// Airspeed target, m/s (required by accelerate and decelerate).
    pub airspeed_mps: Option<f64>,
    /// Bank (turn), degrees.
    pub bank_deg: Option<f64>,
    /// Load factor limit while the path changes: the lowest in a dive, the highest in a climb, level-off or
    /// pull-up. If missing, the airframe's.
    pub load_factor: Option<f64>,
}
