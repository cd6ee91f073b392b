//! Horizontal velocity from positions.

use std::iter;

/// A position, degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Position {
    /// Latitude, north positive.
    pub latitude_deg: f64,
    /// Longitude, east positive.
    pub longitude_deg: f64,
}

/// WGS-84 equatorial radius, metres.
const EQUATORIAL_RADIUS_M: f64 = 6_378_137.0;
/// WGS-84 first eccentricity squared.
const ECCENTRICITY_SQUARED: f64 = 6.694_379_990_14e-3;
/// Longest time between two positions that give a velocity, seconds.
const LONGEST_GAP_S: f64 = 15.0;
/// Fastest plausible velocity, m/s: faster is a jump of the position.
const FASTEST_MPS: f64 = 400.0;

/// A position with its time, seconds.
pub type TimedPosition = (f64, Position);

/// North and east displacement between two near positions, metres.
///
/// Radii of curvature at the mean latitude: B. Hofmann-Wellenhof et al., "Navigation", 2003, sec. 2.2.
fn displacement_m(from: Position, to: Position) -> (f64, f64) {
    let latitude = (0.5 * (from.latitude_deg + to.latitude_deg)).to_radians();
    let flattening = 1.0 - ECCENTRICITY_SQUARED * latitude.sin().powi(2);
    let normal_m = EQUATORIAL_RADIUS_M / flattening.sqrt();
    let meridian_m = normal_m * (1.0 - ECCENTRICITY_SQUARED) / flattening;
    let north_m = (to.latitude_deg - from.latitude_deg).to_radians() * meridian_m;
    // Across the antimeridian, take the short way.
    let turn_deg = (to.longitude_deg - from.longitude_deg + 540.0).rem_euclid(360.0) - 180.0;
    (north_m, turn_deg.to_radians() * normal_m * latitude.cos())
}

fn velocity_mps(from: TimedPosition, to: TimedPosition) -> Option<(f32, f32)> {
    let seconds = to.0 - from.0;
    if seconds <= 0.0 || seconds > 2.0 * LONGEST_GAP_S {
        return None;
    }
    let (north_m, east_m) = displacement_m(from.1, to.1);
    let speed_mps = north_m.hypot(east_m) / seconds;
    (speed_mps <= FASTEST_MPS).then_some(((north_m / seconds) as f32, (east_m / seconds) as f32))
}

/// North and east velocity at each position, m/s: central differences, one-sided at the ends and beside gaps.
/// `None` where neither neighbour is near enough in time, or a position has jumped. Of positions whose time
/// does not increase, only the first has a velocity.
pub fn velocities(
    positions: impl Iterator<Item = TimedPosition> + Clone,
) -> impl Iterator<Item = Option<(f32, f32)>> {
    let mut rest = positions;
    let mut before: Option<TimedPosition> = None;
    iter::from_fn(move || {
        let here = rest.next()?;
        if before.is_some_and(|before| here.0 <= before.0) {
            return Some(None);
        }
        let after = rest.clone().find(|after| after.0 > here.0);
        let velocity = velocity_between(before, here, after);
        before = Some(here);
        Some(velocity)
    })
}

fn velocity_between(
    before: Option<TimedPosition>,
    here: TimedPosition,
    after: Option<TimedPosition>,
) -> Option<(f32, f32)> {
    let near = |other: &TimedPosition| (other.0 - here.0).abs() <= LONGEST_GAP_S;
    match (before.filter(near), after.filter(near)) {
        (None, None) => None,
        (before, after) => velocity_mps(before.unwrap_or(here), after.unwrap_or(here)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn velocities(positions: &[TimedPosition]) -> Vec<Option<(f32, f32)>> {
        super::velocities(positions.iter().copied()).collect()
    }

    fn at(time_s: f64, latitude_deg: f64, longitude_deg: f64) -> TimedPosition {
        (time_s, Position { latitude_deg, longitude_deg })
    }

    #[test]
    fn a_degree_of_latitude_and_longitude_have_their_known_lengths() {
        // Meridian and parallel at 45 degrees: 111 132 m and 78 847 m a degree (WGS-84).
        let (north, _) = displacement_m(at(0.0, 44.999, 7.0).1, at(0.0, 45.001, 7.0).1);
        let (_, east) = displacement_m(at(0.0, 45.0, 7.0).1, at(0.0, 45.0, 7.002).1);
        assert!((north / 0.002 - 111_132.0).abs() < 1.0, "{north}");
        assert!((east / 0.002 - 78_847.0).abs() < 1.0, "{east}");
    }

    #[test]
    fn differences_are_central_and_one_sided_at_the_ends() {
        // 0, 1, 4 millidegrees north in seconds 0, 1, 2.
        let found = velocities(&[at(0.0, 0.0, 0.0), at(1.0, 0.001, 0.0), at(2.0, 0.004, 0.0)]);
        let north: Vec<f64> = found.iter().map(|velocity| f64::from(velocity.unwrap().0) / 110.574).collect();
        for (found, expected) in north.iter().zip([1.0, 2.0, 3.0]) {
            assert!((found - expected).abs() < 1e-3, "{north:?}");
        }
    }

    #[test]
    fn crosses_the_antimeridian() {
        let found = velocities(&[at(0.0, 0.0, 179.9995), at(1.0, 0.0, -179.9995)]);
        assert!((found[0].unwrap().1 - 111.3).abs() < 0.1, "{found:?}");
    }

    #[test]
    fn gaps_jumps_and_repeats_have_no_velocity() {
        assert_eq!(velocities(&[]), []);
        assert_eq!(velocities(&[at(0.0, 0.0, 0.0)]), [None]);
        assert_eq!(velocities(&[at(0.0, 0.0, 0.0), at(16.0, 0.001, 0.0)]), [None, None]);
        assert_eq!(velocities(&[at(0.0, 0.0, 0.0), at(1.0, 1.0, 0.0)]), [None, None]);
        let repeated = velocities(&[at(0.0, 0.0, 0.0), at(0.0, 0.5, 0.0), at(1.0, 0.001, 0.0)]);
        assert!(repeated[0].is_some() && repeated[1].is_none() && repeated[2].is_some());
    }
}
