//! When a vehicle was in the air: take-offs and landings, from what the flight itself recorded.
//!
//! Heights, their changes and the speed over ground are looked at in blocks of a second or more
//! (`blocks.rs`). A block shows flight when the vehicle moves fast while its height changes, or when its
//! height changes faster than ground allows; it shows standing when it is slow and its height does not
//! change. A landing is where flight ends in a stretch of standing, a take-off where it begins after one.
//! Standing in the air (a hover) is told from standing on the ground by the ground: where the vehicle has
//! been lower at the same place, there is air below it.
//!
//! What this cannot tell: a car that drives up and down hills after the landing looks like one more, low
//! flight; the flight that is used is the longest, so that it does no harm. A log that begins less than
//! [`EDGE_S`] before the take-off is said to begin in the air.

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
    /// When it took off, seconds; `None`: it was in the air already when the log began, or (in a log with a
    /// long gap) went on.
    pub take_off_s: Option<f64>,
    /// When it landed, seconds; `None`: it was still in the air when the log ended.
    pub landing_s: Option<f64>,
    /// First moment in the air that the log has, seconds.
    pub from_s: f64,
    /// Last one, seconds.
    pub to_s: f64,
    /// From when on it stood on the ground before the take-off, seconds: the landing before it, or the log's
    /// beginning. `None` without a take-off.
    pub ground_from_s: Option<f64>,
}

impl AirborneInterval {
    /// How long it was in the air, seconds.
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        self.to_s - self.from_s
    }
}

/// All of a log's times in the air.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Outings {
    /// In order of time; none for a log that never leaves the ground, or never moves enough to tell.
    pub airborne: Vec<AirborneInterval>,
    /// What the heights are those of; `None` without any.
    pub heights: Option<Heights>,
    /// Whether there was a speed to go by.
    pub has_speed: bool,
}

impl Outings {
    /// The longest of them, and its place.
    #[must_use]
    pub fn longest(&self) -> Option<(usize, AirborneInterval)> {
        let all = self.airborne.iter().copied().enumerate();
        // Of two that are equally long, the first.
        all.rev().max_by(|one, other| one.1.duration_s().total_cmp(&other.1.duration_s()))
    }

    /// The one that a moment belongs to: on the ground before it, or in the air. `None` after the last
    /// landing.
    #[must_use]
    pub fn around(&self, time_s: f64) -> Option<(usize, AirborneInterval)> {
        let landed_later = |interval: &AirborneInterval| {
            interval.landing_s.map_or(interval.to_s >= time_s, |landing_s| landing_s > time_s)
        };
        self.airborne.iter().copied().enumerate().find(|(_, interval)| landed_later(interval))
    }
}

/// Finds the times in the air. Nothing is needed but time and one altitude; a speed over ground tells more.
#[must_use]
pub fn find(flight: &Flight) -> Outings {
    let Some(blocks) = blocks::Blocks::new(flight) else { return Outings::default() };
    Outings {
        airborne: grouping::airborne(&blocks),
        heights: Some(blocks.heights),
        has_speed: blocks.has_speed(),
    }
}
