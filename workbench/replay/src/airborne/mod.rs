//! When a vehicle was in the air: take-offs and landings, from what the flight itself recorded.
//!
//! Heights, their changes and the speed over ground are examined in blocks of a second or more (`blocks.rs`).
//! A block shows flight when the vehicle moves fast while its height changes, or when its height changes
//! faster than ground allows. It shows standing when it is slow and its height does not change. A landing is
//! where flight ends in a stretch of standing, a take-off where flight begins after one. Standing in the air
//! (a hover) is distinguished from standing on the ground by the ground's height: where the vehicle has been
//! lower at the same place, there is air below it.
//!
//! Limits: a car that drives up and down hills after the landing looks like one more, low flight. It does no
//! harm, because the longest flight is used. A log that begins less than [`EDGE_S`] before the take-off is
//! reported as beginning in the air.

mod blocks;
mod boost;
mod drop;
mod grouping;
#[cfg(test)]
mod tests;

use flight_data::Flight;

pub use blocks::Heights;
pub use boost::{Boost, boost};
pub use drop::{Drop, drop};
pub use grouping::EDGE_S;

/// One time in the air, by the flight's own clock.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AirborneInterval {
    /// When it took off, seconds; `None`: it was already in the air when the log began, or (in a log with a
    /// long gap) after the gap.
    pub take_off_s: Option<f64>,
    /// When it landed, seconds; `None`: it was still in the air when the log ended.
    pub landing_s: Option<f64>,
    /// First recorded moment in the air, seconds.
    pub from_s: f64,
    /// Last recorded moment in the air, seconds.
    pub to_s: f64,
    /// Since when it stood on the ground before the take-off, seconds: since the landing before it, or the
    /// log's beginning. `None` without a take-off.
    pub ground_from_s: Option<f64>,
}

impl AirborneInterval {
    /// How long it was in the air, seconds.
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        self.to_s - self.from_s
    }
}

/// All times in the air of a log.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AirborneIntervals {
    /// In order of time; none for a log that never leaves the ground, or never moves enough to detect it.
    pub airborne: Vec<AirborneInterval>,
    /// Source of the heights; `None` without any.
    pub heights: Option<Heights>,
    /// Whether the log has a speed.
    pub has_speed: bool,
}

impl AirborneIntervals {
    /// The longest of them, and its index.
    #[must_use]
    pub fn longest(&self) -> Option<(usize, AirborneInterval)> {
        let all = self.airborne.iter().copied().enumerate();
        // Of two equally long ones, the first.
        all.rev().max_by(|one, other| one.1.duration_s().total_cmp(&other.1.duration_s()))
    }

    /// The one that a moment belongs to: in the air, or on the ground before it. `None` after the last
    /// landing.
    #[must_use]
    pub fn around(&self, time_s: f64) -> Option<(usize, AirborneInterval)> {
        let landed_later = |interval: &AirborneInterval| {
            interval.landing_s.map_or(interval.to_s >= time_s, |landing_s| landing_s > time_s)
        };
        self.airborne.iter().copied().enumerate().find(|(_, interval)| landed_later(interval))
    }
}

/// Finds the times in the air. Only time and one altitude are needed; a speed over ground makes it more
/// reliable.
#[must_use]
pub fn find(flight: &Flight) -> AirborneIntervals {
    let Some(blocks) = blocks::Blocks::new(flight) else { return AirborneIntervals::default() };
    AirborneIntervals {
        airborne: grouping::airborne(&blocks),
        heights: Some(blocks.heights),
        has_speed: blocks.has_speed(),
    }
}
