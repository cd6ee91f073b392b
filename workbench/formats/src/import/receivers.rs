//! Several receivers in one log: one is the reference, the others are kept as signals.
//!
//! The altitudes of two receivers are not averaged: their errors are largely the same, and one that jumps
//! would disturb the other. So one is used unchanged, and the others are kept under names of their own, with
//! their distance from it.

use flight_data::{Channel, Column, Flight, Note};
use kf_core::atmosphere::pressure_altitude_m;

use super::fixes::{Fix, Fixes};
use super::table::{Destination, Filling, Samples};

/// Largest distance between fixes of the reference for a comparison: in longer gaps its altitude is not
/// known.
const APART_US: u64 = 2_000_000;
/// Fewest fixes at common times for a comparison.
const LEAST_COMMON: usize = 5;

/// A receiver that is not the reference.
#[derive(Clone, Debug)]
pub struct Other {
    /// Its name in the log.
    pub name: String,
    /// Its number for the user, from 1.
    pub number: usize,
    /// Its fixes.
    pub fixes: Fixes,
}

impl Other {
    /// Its signals.
    pub fn fillings(&self) -> Vec<Filling<'static>> {
        let signal = |what: &str, value: &dyn Fn(&Fix) -> f64| Filling {
            destination: Destination::signal(format!("gps_{}_{what}", self.number)),
            samples: Samples::Own(
                self.fixes.fixes.iter().map(|fix| (fix.stamp, value(fix) as f32)).collect(),
            ),
        };
        vec![
            signal("alt_m", &|fix| fix.altitude_m),
            signal("vn_mps", &|fix| fix.velocity_mps[0]),
            signal("ve_mps", &|fix| fix.velocity_mps[1]),
            signal("vd_mps", &|fix| fix.velocity_mps[2]),
            signal("vacc_m", &|fix| fix.vertical_accuracy_m),
            signal("sats", &|fix| fix.satellites),
        ]
    }

    /// The note on it, compared with the receiver that is used.
    pub fn sentence(&self, used: (&str, &Fixes), times_us: &[Option<u64>]) -> String {
        let altitudes = |fixes: &Fixes| -> Vec<(u64, f64)> {
            let timed =
                |fix: &Fix| Some((times_us.get(fix.stamp as usize).copied().flatten()?, fix.altitude_m));
            fixes.fixes.iter().filter_map(timed).collect()
        };
        let (name, fixes) = used;
        sentence((name, &mut altitudes(fixes)), (&self.name, self.number, &altitudes(&self.fixes)))
    }
}

/// The note on a receiver, compared with the one that is used: names, and fixes as times in microseconds and
/// altitudes in metres.
pub fn sentence(used: (&str, &mut [(u64, f64)]), other: (&str, usize, &[(u64, f64)])) -> String {
    let (used_name, used) = used;
    let (name, number, altitudes) = other;
    used.sort_by_key(|(time_us, _)| *time_us);
    let apart = apart(used, altitudes);
    format!(
        "several receivers: {used_name}, with {} 3D fixes, is the reference; {name}, with {}, is kept as gps_{number}_alt_m and \
         other signals gps_{number}_*: {apart}",
        used.len(),
        altitudes.len()
    )
}

/// How far one altitude is from the one that is used, whose fixes are in the order of time.
fn apart(used: &[(u64, f64)], altitudes: &[(u64, f64)]) -> String {
    let mut apart_m: Vec<f64> =
        altitudes.iter().filter_map(|(time_us, other_m)| Some(other_m - at(used, *time_us)?)).collect();
    apart_m.sort_by(f64::total_cmp);
    let share = |percent: usize| apart_m.get((apart_m.len().saturating_sub(1)) * percent / 100).copied();
    match [2, 50, 98].map(share) {
        [Some(least), Some(middle), Some(most)] if apart_m.len() >= LEAST_COMMON => format!(
            "its altitude differs from the other's by {middle:+.1} m in the median, and by {least:+.1} to {most:+.1} m in 96 of 100 fixes"
        ),
        _ => "it has too few fixes in common with the other to compare their altitudes".to_owned(),
    }
}

/// The notes on the other receivers of a flight that is opened: how far each is from the reference and, with a
/// barometer, how much each of the two departs from it, which shows the worse one.
pub fn notes(flight: &Flight) -> Vec<Note> {
    let timed = |column: &Column, metres: fn(f32) -> Option<f32>| -> Vec<(u64, f64)> {
        let cells = column.samples().filter_map(|(row, cell)| {
            let time_us = 1e6 * flight.time_s.get(row)?;
            Some((time_us, f64::from(metres(cell)?)))
        });
        // Before the clock's zero nothing is compared.
        let usable = cells.filter(|(time_us, metres)| *time_us >= 0.0 && metres.is_finite());
        let mut altitudes: Vec<(u64, f64)> =
            usable.map(|(time_us, metres)| (time_us as u64, metres)).collect();
        altitudes.sort_by_key(|(time_us, _)| *time_us);
        altitudes
    };
    let Some(used) = flight.channel(Channel::GpsAltM).map(|column| timed(column, Some)) else {
        return Vec::new();
    };
    let pressure = flight.channel(Channel::BaroPa).map(|column| timed(column, pressure_altitude_m));
    let barometer = pressure
        .filter(|altitudes| !altitudes.is_empty())
        .or_else(|| flight.channel(Channel::BaroAltM).map(|column| timed(column, Some)));
    let is_others = |name: &str| {
        let number = name.strip_prefix("gps_").and_then(|rest| rest.strip_suffix("_alt_m"));
        number.is_some_and(|number| !number.is_empty() && number.bytes().all(|byte| byte.is_ascii_digit()))
    };
    let others = flight.extra.iter().filter(|(name, _)| is_others(name));
    let of = |(name, column): &(String, Column)| {
        let other = timed(column, Some);
        let mut text = format!(
            "several receivers: gps_alt_m is the reference; {name} is another: {}",
            apart(&used, &other)
        );
        let by_barometer = barometer
            .as_deref()
            .and_then(|barometer| Some((spread_m(barometer, &used)?, spread_m(barometer, &other)?)));
        if let Some((used_m, other_m)) = by_barometer {
            text += &format!(
                "; about the barometer the reference spreads by {used_m:.1} m and {name} by {other_m:.1} m (1 sigma)"
            );
        }
        Note::new(text)
    };
    others.map(of).collect()
}

/// Half of the range of the middle 68 % of an altitude's distances from the barometer's, metres: the standard
/// deviation of normal values, hardly moved by a few wild ones. `None` of too few fixes.
fn spread_m(barometer: &[(u64, f64)], altitudes: &[(u64, f64)]) -> Option<f64> {
    let apart = altitudes.iter().filter_map(|(time_us, metres)| Some(metres - at(barometer, *time_us)?));
    let mut apart_m: Vec<f64> = apart.collect();
    apart_m.sort_by(f64::total_cmp);
    let last = apart_m.len().checked_sub(1).filter(|_| apart_m.len() >= LEAST_COMMON)?;
    Some(0.5 * (apart_m.get(last * 84 / 100)? - apart_m.get(last * 16 / 100)?))
}

/// The altitude at a time, interpolated between the fixes around it.
fn at(fixes: &[(u64, f64)], time_us: u64) -> Option<f64> {
    let next = fixes.partition_point(|(fix_us, _)| *fix_us < time_us);
    let (after_us, after_m) = *fixes.get(next)?;
    if after_us == time_us {
        return Some(after_m);
    }
    let (before_us, before_m) = *fixes.get(next.checked_sub(1)?)?;
    let between_us = after_us - before_us;
    let share = (time_us - before_us) as f64 / between_us as f64;
    (between_us <= APART_US).then_some(before_m + share * (after_m - before_m))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_second_receiver_is_compared_at_its_own_times() {
        // A climb of 2 m/s; the second receiver is half a second later and 3 m higher, and once 40 m.
        let mut used: Vec<(u64, f64)> = (0..100).map(|k| (k * 1_000_000, 2.0 * k as f64)).collect();
        let other: Vec<(u64, f64)> = (0..100)
            .map(|k| (k * 1_000_000 + 500_000, 2.0 * k as f64 + 1.0 + if k == 50 { 40.0 } else { 3.0 }))
            .collect();
        let said = sentence(("GPS", &mut used), ("GPS2", 2, &other));
        for words in [
            "GPS, with 100 3D fixes, is the reference",
            "GPS2, with 100, is kept as gps_2_alt_m",
            "differs from the other's by +3.0 m",
            "+3.0 to +3.0 m",
        ] {
            assert!(said.contains(words), "{said}");
        }
        // In a gap of the reference there is no comparison.
        let mut gap = [(0, 0.0), (60_000_000, 120.0)];
        assert!(sentence(("GPS", &mut gap), ("GPS2", 2, &other)).contains("too few"));
    }
}
