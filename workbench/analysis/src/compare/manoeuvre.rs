//! Classifies an aircraft's manoeuvre by its motion.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Largest climb or descent rate in level flight, m/s.
const LEVEL_MPS: f64 = 2.0;
/// Sine of the flattest descent that is a dive: 20 degrees.
const DIVE_SINE: f64 = 0.342;
/// Slowest descent that is a dive if the speed is not known, m/s.
const DIVE_MPS: f64 = 15.0;
/// Largest turn rate in straight flight: 3 degrees a second.
const TURN_RADPS: f64 = 0.052;
/// Smallest load factor of a pull-up, and largest of a push-over.
const PULL_UP_LOAD: f64 = 1.4;
const PUSH_OVER_LOAD: f64 = 0.6;
/// Largest speed at rest or in hover, if level, m/s.
const REST_MPS: f64 = 1.0;
/// Largest change of speed in steady flight, m/s^2.
const STEADY_MPS2: f64 = 1.0;

/// How the aircraft moved during one stretch of flight; `None` if the flight does not have it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Motion {
    /// Climb rate, m/s, up positive.
    pub climb_rate_mps: Option<f64>,
    /// Speed, m/s: true airspeed, or else ground speed.
    pub speed_mps: Option<f64>,
    /// Its rate of change, m/s^2.
    pub acceleration_mps2: Option<f64>,
    /// Load factor.
    pub load_factor: Option<f64>,
    /// Turn rate, rad/s, positive to the right.
    pub turn_rate_radps: Option<f64>,
}

/// A manoeuvre of the aircraft.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
#[serde(rename_all = "snake_case")]
pub enum Manoeuvre {
    /// Steady, level and straight.
    LevelFlight,
    /// Level and straight, with increasing speed.
    Acceleration,
    /// Level and straight, with decreasing speed.
    Deceleration,
    /// Climbing straight.
    Climb,
    /// Descending straight.
    Descent,
    /// Descending steeply.
    Dive,
    /// Load factor well above 1 while not turning.
    PullUp,
    /// Load factor well below 1.
    PushOver,
    /// Turning at constant altitude.
    LevelTurn,
    /// Turning while climbing.
    ClimbingTurn,
    /// Turning while descending.
    DescendingTurn,
    /// Standing, or hovering.
    AtRest,
    /// The flight has no signal to classify it by.
    Unknown,
}

impl Manoeuvre {
    /// The name used in tables.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::LevelFlight => "level flight",
            Self::Acceleration => "acceleration",
            Self::Deceleration => "deceleration",
            Self::Climb => "climb",
            Self::Descent => "descent",
            Self::Dive => "dive",
            Self::PullUp => "pull-up",
            Self::PushOver => "push-over",
            Self::LevelTurn => "level turn",
            Self::ClimbingTurn => "climbing turn",
            Self::DescendingTurn => "descending turn",
            Self::AtRest => "at rest",
            Self::Unknown => "unknown",
        }
    }

    /// The name in a sentence: "in the dive".
    #[must_use]
    pub const fn phrase(self) -> &'static str {
        match self {
            Self::LevelFlight => "in level flight",
            Self::Acceleration => "while accelerating",
            Self::Deceleration => "while decelerating",
            Self::Climb => "in the climb",
            Self::Descent => "in the descent",
            Self::Dive => "in the dive",
            Self::PullUp => "in the pull-up",
            Self::PushOver => "in the push-over",
            Self::LevelTurn => "in the level turn",
            Self::ClimbingTurn => "in the climbing turn",
            Self::DescendingTurn => "in the descending turn",
            Self::AtRest => "at rest",
            Self::Unknown => "(no signal shows what the aircraft was doing)",
        }
    }

    /// Classifies a motion. A missing signal excludes the manoeuvres that need it.
    #[must_use]
    pub fn of(motion: &Motion) -> Self {
        let climb = motion.climb_rate_mps;
        let is_known = climb.is_some()
            || motion.load_factor.is_some()
            || motion.turn_rate_radps.is_some()
            || motion.acceleration_mps2.is_some();
        if !is_known {
            return Self::Unknown;
        }
        let rises = climb.is_some_and(|climb| climb > LEVEL_MPS);
        let sinks = climb.is_some_and(|climb| climb < -LEVEL_MPS);
        let is_turning = motion.turn_rate_radps.is_some_and(|rate| rate.abs() > TURN_RADPS);
        let load = motion.load_factor;
        if load.is_some_and(|load| load < PUSH_OVER_LOAD) {
            Self::PushOver
        } else if is_turning {
            match (rises, sinks) {
                (true, _) => Self::ClimbingTurn,
                (_, true) => Self::DescendingTurn,
                _ => Self::LevelTurn,
            }
        } else if load.is_some_and(|load| load > PULL_UP_LOAD) {
            Self::PullUp
        } else if sinks {
            let limit = motion.speed_mps.map_or(DIVE_MPS, |speed| DIVE_SINE * speed);
            if climb.is_some_and(|climb| -climb > limit) { Self::Dive } else { Self::Descent }
        } else if rises {
            Self::Climb
        } else if motion.speed_mps.is_some_and(|speed| speed < REST_MPS) {
            Self::AtRest
        } else {
            match motion.acceleration_mps2 {
                Some(growth) if growth > STEADY_MPS2 => Self::Acceleration,
                Some(growth) if growth < -STEADY_MPS2 => Self::Deceleration,
                _ => Self::LevelFlight,
            }
        }
    }
}

impl std::fmt::Display for Motion {
    /// `climb -38 m/s, 62 m/s, 1.0 g, turning right 5 deg/s`; unknown quantities are omitted.
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let mut parts = Vec::new();
        if let Some(climb) = self.climb_rate_mps {
            parts.push(format!("climb {:+.0} m/s", without_minus_zero(climb)));
        }
        if let Some(speed) = self.speed_mps {
            parts.push(format!("{speed:.0} m/s"));
        }
        if let Some(load) = self.load_factor {
            parts.push(format!("{load:.1} g"));
        }
        if let Some(rate) = self.turn_rate_radps.filter(|rate| rate.abs() > TURN_RADPS) {
            let side = if rate > 0.0 { "right" } else { "left" };
            parts.push(format!("turning {side} {:.0} deg/s", rate.abs().to_degrees()));
        }
        formatter.write_str(&parts.join(", "))
    }
}

/// The value rounded to a whole number, never minus zero.
#[must_use]
pub fn without_minus_zero(value: f64) -> f64 {
    value.round() + 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn motion(climb: f64, speed: f64, load: f64, turn: f64, growth: f64) -> Motion {
        Motion {
            climb_rate_mps: Some(climb),
            speed_mps: Some(speed),
            acceleration_mps2: Some(growth),
            load_factor: Some(load),
            turn_rate_radps: Some(turn),
        }
    }

    #[test]
    fn names_what_a_pilot_would() {
        for (motion, expected) in [
            (motion(0.3, 60.0, 1.0, 0.0, 0.1), Manoeuvre::LevelFlight),
            (motion(-38.0, 62.0, 1.0, 0.0, 3.0), Manoeuvre::Dive),
            (motion(-5.0, 62.0, 1.0, 0.0, 0.0), Manoeuvre::Descent),
            (motion(6.0, 62.0, 1.1, 0.01, 0.0), Manoeuvre::Climb),
            (motion(-30.0, 90.0, 3.0, 0.0, -2.0), Manoeuvre::PullUp),
            (motion(2.5, 90.0, 0.2, 0.0, -2.0), Manoeuvre::PushOver),
            (motion(0.0, 60.0, 1.6, -0.2, 0.0), Manoeuvre::LevelTurn),
            (motion(4.0, 60.0, 1.6, 0.2, 0.0), Manoeuvre::ClimbingTurn),
            (motion(-9.0, 60.0, 1.6, 0.2, 0.0), Manoeuvre::DescendingTurn),
            (motion(1.0, 60.0, 1.0, 0.0, 2.2), Manoeuvre::Acceleration),
            (motion(-1.0, 60.0, 1.0, 0.0, -2.2), Manoeuvre::Deceleration),
            (motion(0.1, 0.4, 1.0, 0.0, 0.0), Manoeuvre::AtRest),
        ] {
            assert_eq!(Manoeuvre::of(&motion), expected, "{motion}");
        }
    }

    #[test]
    fn says_what_is_known_only() {
        let only_climb = Motion { climb_rate_mps: Some(-20.0), ..Motion::default() };
        assert_eq!(Manoeuvre::of(&only_climb), Manoeuvre::Dive);
        assert_eq!(only_climb.to_string(), "climb -20 m/s");
        assert_eq!(Manoeuvre::of(&Motion::default()), Manoeuvre::Unknown);
        let only_speed = Motion { speed_mps: Some(50.0), ..Motion::default() };
        assert_eq!(Manoeuvre::of(&only_speed), Manoeuvre::Unknown);
        assert_eq!(Motion { climb_rate_mps: Some(-0.2), ..Motion::default() }.to_string(), "climb +0 m/s");
        assert_eq!(
            motion(-38.0, 62.0, 1.04, 0.1, -1.5).to_string(),
            "climb -38 m/s, 62 m/s, 1.0 g, turning right 6 deg/s"
        );
    }

    /// One signal of four is enough for a classification; without any, it is unknown.
    #[test]
    fn any_signal_says_something() {
        let none = Motion::default();
        assert_eq!(Manoeuvre::of(&none), Manoeuvre::Unknown);
        for motion in [
            Motion { climb_rate_mps: Some(0.0), ..none },
            Motion { load_factor: Some(1.0), ..none },
            Motion { turn_rate_radps: Some(0.0), ..none },
            Motion { acceleration_mps2: Some(0.0), ..none },
        ] {
            assert_ne!(Manoeuvre::of(&motion), Manoeuvre::Unknown, "{motion:?}");
        }
    }
}
