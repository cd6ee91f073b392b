//! Checks whether a flight's velocities agree with the positions whose derivatives they are.
//!
//! Some autopilots wrote the climb rate with the wrong sign. Over windows of some seconds, the change of a
//! position is compared with the integral of its velocity. A velocity whose integral runs against the
//! position is reported; its sign is reversed only if the user names it.

use kf_core::atmosphere::pressure_altitude_m;

use flight_data::{Channel, Column, Flight, Note};

/// Length of a window, seconds: long enough that a receiver's noise of a metre is small compared with the
/// path of a climb at some m/s, and short enough to exclude its wander over minutes.
const WINDOW_S: f64 = 5.0;
/// Largest distance between a window's samples, seconds.
const GAP_S: f64 = 2.5;
/// Sigmas by which a correlation must exceed chance, by Fisher's transformation: the probability of 5 is 3 in
/// 10 million.
const SIGMAS: f64 = 5.0;
/// Length of a degree of latitude, metres.
pub(super) const DEGREE_M: f64 = 111_195.0;

/// A velocity that runs against its position.
#[derive(Clone, Debug, PartialEq)]
pub struct Contradiction {
    /// The velocity's column.
    pub velocity: String,
    /// The position's column.
    pub position: String,
    /// Correlation of the position's change with the velocity's integral, which is negative.
    pub correlation: f64,
    /// Number of windows in the correlation.
    pub windows: usize,
}

/// A velocity and its position: columns, and the position's change for one metre of the velocity's integral.
struct Pair {
    velocity: &'static str,
    positions: &'static [&'static str],
    sense: f64,
}

const PAIRS: [Pair; 9] = [
    Pair { velocity: "gps_vd_mps", positions: &["gps_alt_m", "baro_alt_m", "baro_pa"], sense: -1.0 },
    Pair { velocity: "gps_vn_mps", positions: &["latitude_deg"], sense: 1.0 },
    Pair { velocity: "gps_ve_mps", positions: &["longitude_deg"], sense: 1.0 },
    Pair { velocity: "autopilot_vd_mps", positions: &["autopilot_down_m"], sense: 1.0 },
    Pair { velocity: "autopilot_climb_mps", positions: &["autopilot_altitude_m", "gps_alt_m"], sense: 1.0 },
    Pair { velocity: "autopilot_vn_mps", positions: &["latitude_deg"], sense: 1.0 },
    Pair { velocity: "autopilot_ve_mps", positions: &["longitude_deg"], sense: 1.0 },
    Pair { velocity: "vario_mps", positions: &["gps_alt_m"], sense: 1.0 },
    Pair { velocity: "vario_total_energy_mps", positions: &["gps_alt_m"], sense: 1.0 },
];

fn column<'a>(flight: &'a Flight, name: &str) -> Option<&'a Column> {
    Channel::from_name(name)
        .and_then(|channel| flight.channel(channel))
        .or_else(|| flight.extra.iter().find_map(|(found, column)| (found == name).then_some(column)))
}

/// A column's samples in time order; positions in metres, up to a constant.
fn samples(flight: &Flight, name: &str) -> Vec<(f64, f64)> {
    let Some(column) = column(flight, name) else { return Vec::new() };
    let latitude_deg = self::column(flight, "latitude_deg").and_then(|latitudes| latitudes.samples().next());
    let to_metres = |value: f32| match name {
        "baro_pa" => pressure_altitude_m(value).map(f64::from),
        "latitude_deg" => Some(f64::from(value) * DEGREE_M),
        "longitude_deg" => latitude_deg
            .map(|(_, latitude)| f64::from(value) * DEGREE_M * f64::from(latitude).to_radians().cos()),
        _ => Some(f64::from(value)),
    };
    let timed = column.samples().filter_map(|(row, value)| {
        Some((*flight.time_s.get(row)?, to_metres(value).filter(|metres| metres.is_finite())?))
    });
    let mut timed: Vec<(f64, f64)> = timed.collect();
    timed.sort_by(|one, other| one.0.total_cmp(&other.0));
    timed
}

/// The integral of a velocity and the change of a position over each window in which both have samples.
/// Samples are expected in time order. Where they are not, or where times are too great to resolve seconds,
/// the rest is ignored.
pub(super) fn windows(velocity: &[(f64, f64)], position: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let mut found = Vec::new();
    let Some((mut start_s, _)) = velocity.first().copied() else { return found };
    let end_s = velocity.last().map_or(start_s, |last| last.0);
    let mut looked_at = 0;
    while start_s + WINDOW_S <= end_s {
        let until_s = start_s + WINDOW_S;
        let first = velocity.partition_point(|sample| sample.0 < start_s);
        let last = velocity.partition_point(|sample| sample.0 <= until_s);
        // Each window has a sample more than those before it: the next sample is not farther away than a gap,
        // or the window begins there.
        if last <= looked_at {
            break;
        }
        looked_at = last;
        let inside = velocity.get(first..last).unwrap_or_default();
        let ends = inside.first().zip(inside.last());
        if let Some(((from_s, _), (to_s, _))) = ends
            && to_s - from_s > WINDOW_S / 2.0
            && inside.windows(2).all(|pair| matches!(pair, [one, other] if other.0 - one.0 <= GAP_S))
            && let (Some(from), Some(to)) = (at(position, *from_s), at(position, *to_s))
        {
            let area = |pair: &[(f64, f64)]| match pair {
                [one, other] => (other.0 - one.0) * (one.1 + other.1) / 2.0,
                _ => 0.0,
            };
            found.push((inside.windows(2).map(area).sum(), to - from));
        }
        // The next one begins at the next sample.
        start_s = match velocity.get(last) {
            Some(next) if next.0 > until_s + GAP_S => next.0,
            _ => until_s,
        };
    }
    found
}

/// A position at a time, interpolated between the samples around it.
fn at(position: &[(f64, f64)], time_s: f64) -> Option<f64> {
    let next = position.partition_point(|sample| sample.0 < time_s);
    let after = position.get(next);
    let before = next.checked_sub(1).and_then(|before| position.get(before));
    match (before, after) {
        (_, Some((own_s, value))) if *own_s == time_s => Some(*value),
        (Some((from_s, from)), Some((to_s, to))) if to_s - from_s <= GAP_S => {
            Some(from + (to - from) * (time_s - from_s) / (to_s - from_s))
        }
        _ => None,
    }
}

/// Correlation of the two in each pair; 0 if one of them does not change.
pub(super) fn correlation(windows: &[(f64, f64)]) -> f64 {
    let n = windows.len() as f64;
    let mean = |pick: fn(&(f64, f64)) -> f64| windows.iter().map(pick).sum::<f64>() / n;
    let (mean_x, mean_y) = (mean(|window| window.0), mean(|window| window.1));
    let (mut xx, mut yy, mut xy) = (0.0, 0.0, 0.0);
    for (x, y) in windows {
        xx += (x - mean_x).powi(2);
        yy += (y - mean_y).powi(2);
        xy += (x - mean_x) * (y - mean_y);
    }
    if xx > 0.0 && yy > 0.0 { xy / (xx * yy).sqrt() } else { 0.0 }
}

/// The velocities that run against their positions.
#[must_use]
pub fn contradictions(flight: &Flight) -> Vec<Contradiction> {
    let mut found = Vec::new();
    for pair in &PAIRS {
        let velocity = samples(flight, pair.velocity);
        if velocity.is_empty() {
            continue;
        }
        let Some(name) = pair.positions.iter().find(|name| column(flight, name).is_some()) else { continue };
        let mut windows = windows(&velocity, &samples(flight, name));
        windows.iter_mut().for_each(|(integral, _)| *integral *= pair.sense);
        let (correlation, count) = (correlation(&windows), windows.len());
        // After that transformation, the correlation of n unrelated pairs has a sigma of one over the root of
        // n - 3.
        let sigmas =
            correlation.clamp(-0.999_999, 0.999_999).atanh() * (count.saturating_sub(3) as f64).sqrt();
        if sigmas < -SIGMAS {
            found.push(Contradiction {
                velocity: pair.velocity.to_owned(),
                position: (*name).to_owned(),
                correlation,
                windows: count,
            });
        }
    }
    found
}

/// Notes on a flight's velocities.
pub fn notes(flight: &Flight) -> Vec<Note> {
    contradictions(flight)
        .into_iter()
        .map(|Contradiction { velocity, position, correlation, windows }| {
            Note::new(format!(
                "{velocity} runs against {position}: over {windows} windows of {WINDOW_S:.0} s its integral and the change of \
                 {position} correlate by {correlation:+.2}, as if its sign were reversed; it is used unchanged, and \
                 'pylon import LOG --turn {velocity} -o FLIGHT' reverses it"
            ))
        })
        .collect()
}

/// Reverses the sign of a column; returns whether the flight has it.
pub fn turn(flight: &mut Flight, name: &str) -> bool {
    let turned = column(flight, name).map(|column| {
        let mut turned = Column::with_capacity(column.len());
        (0..column.len()).for_each(|row| turned.push(column.get(row).map(|value| -value)));
        turned
    });
    let Some(turned) = turned else { return false };
    match Channel::from_name(name) {
        Some(channel) => flight.set_channel(channel, turned),
        None => {
            if let Some((_, slot)) = flight.extra.iter_mut().find(|(found, _)| found == name) {
                *slot = turned;
            }
        }
    }
    match flight.header.other.iter_mut().find(|(key, _)| key == "turned") {
        Some((_, names)) => *names += &format!(", {name}"),
        None => flight.header.other.push(("turned".to_owned(), name.to_owned())),
    }
    true
}

/// Velocities for which [`turn`] is intended.
pub fn names() -> impl Iterator<Item = &'static str> {
    PAIRS.iter().map(|pair| pair.velocity)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A flight that climbs and sinks by a sine of 60 s, with noise in its altitude; its vd is the right one
    /// times `sign`.
    fn flight(seconds: usize, amplitude_mps: f64, sign: f64) -> Flight {
        let mut flight = Flight::default();
        let (mut altitude, mut down, mut latitude) =
            (Column::default(), Column::default(), Column::default());
        let mut north = Column::default();
        let mut seed = 1_u32;
        for k in 0..seconds * 5 {
            let time_s = k as f64 / 5.0;
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let noise_m = f64::from(seed >> 8) / f64::from(1 << 24) - 0.5;
            let phase = std::f64::consts::TAU * time_s / 60.0;
            flight.time_s.push(time_s);
            altitude.push(Some(
                (100.0 - amplitude_mps * 60.0 / std::f64::consts::TAU * phase.cos() + noise_m) as f32,
            ));
            down.push(Some((-sign * amplitude_mps * phase.sin()) as f32));
            latitude.push(Some((47.0 + 10.0 * time_s / DEGREE_M) as f32));
            north.push(Some((10.0 + phase.sin()) as f32));
        }
        flight.set_channel(Channel::GpsAltM, altitude);
        flight.set_channel(Channel::GpsVdMps, down);
        flight.set_channel(Channel::GpsVnMps, north);
        flight.extra.push(("latitude_deg".to_owned(), latitude));
        flight
    }

    /// A damaged clock may give any time; searching all windows of five seconds up to that time would take
    /// years.
    #[test]
    fn times_that_are_none_end_the_windows() {
        let position = [(0.0, 0.0), (1e17, 1.0)];
        assert_eq!(windows(&[(1e17, 1.0); 3], &position), []);
        assert_eq!(windows(&[(0.0, 1.0), (1e15, 1.0), (1.0, 1.0), (1e15, 1.0)], &position), []);
        let seconds: Vec<(f64, f64)> = (0..60).map(|second| (f64::from(second), 1.0)).collect();
        assert_eq!(windows(&seconds, &seconds).len(), 11);
    }

    #[test]
    fn a_turned_climb_rate_is_found_turned_and_then_agrees() {
        assert_eq!(contradictions(&flight(300, 2.0, 1.0)), []);
        let mut turned = flight(300, 2.0, -1.0);
        let found = contradictions(&turned);
        assert_eq!((found.len(), found[0].velocity.as_str(), found[0].windows), (1, "gps_vd_mps", 59));
        assert!(found[0].correlation < -0.95, "{found:?}");
        assert!(notes(&turned)[0].text().contains("--turn gps_vd_mps"));
        assert!(turn(&mut turned, "gps_vd_mps"));
        assert_eq!(contradictions(&turned), []);
        assert_eq!(turned.header.other, [("turned".to_owned(), "gps_vd_mps".to_owned())]);
        assert_eq!(
            turned.channel(Channel::GpsVdMps).unwrap().get(40),
            flight(300, 2.0, 1.0).channel(Channel::GpsVdMps).unwrap().get(40)
        );
        assert!(!turn(&mut turned, "gps_ve_mps"));
    }

    #[test]
    fn nothing_is_said_of_what_shows_nothing() {
        // Level flight, and a flight too short to exclude chance.
        assert_eq!(contradictions(&flight(300, 0.0, -1.0)), []);
        assert_eq!(contradictions(&flight(20, 2.0, -1.0)), []);
        assert_eq!(contradictions(&Flight::default()), []);
    }
}
