//! Guesses which columns are pressures and altitudes.

use kf_core::atmosphere::pressure_altitude_m;

use super::board::Board;
use super::names::Role;
use super::relate::{Line, held};
use super::units::{meant, name_agrees};
use crate::import::mapping::middle;
use crate::import::mapping::quantity::Quantity;

/// Pressures at which aircraft fly, Pa: from 13 km altitude to the Dead Sea.
const PRESSURE_PA: std::ops::RangeInclusive<f64> = 16_000.0..=108_000.0;
/// Largest effect of the weather on the standard atmosphere's altitude, metres: 70 hPa at the ground.
const WEATHER_M: f64 = 600.0;
/// An altitude within this of a line through the pressure's altitude is computed from the pressure, metres (1
/// sigma): rounded to the metre.
const MADE_OF_M: f64 = 0.4;
/// Samples of two sensors within this count as simultaneous, seconds.
const HOLD_S: f64 = 1.5;

/// Finds the barometer and every altitude.
pub fn find(board: &mut Board<'_>) {
    for column in board.named(Role::Pressure) {
        pressure(board, column);
    }
    if board.guess("baro_pa").is_none() {
        unnamed_pressure(board);
    }
    for (role, destination) in [
        (Role::GpsAltitude, "gps_alt_m"),
        (Role::BaroAltitude, "baro_alt_m"),
        (Role::SlaveAltitude, "imu_slave_alt_m"),
        (Role::MasterAltitude, "imu_master_alt_m"),
        (Role::Altitude, ""),
    ] {
        for column in board.named(role) {
            altitude(board, column, destination);
        }
    }
    if board.guess("gps_alt_m").is_none() {
        let unnamed = board.free().into_iter().filter(|column| board.role(*column).is_none());
        for column in unnamed.collect::<Vec<_>>() {
            if follows_pressure(board, column).is_some() {
                altitude(board, column, "");
            }
        }
    }
}

/// Pressure altitudes of a column, if its unit were `factor` pascals.
fn pressure_altitudes(board: &Board<'_>, column: usize, factor: f64) -> Vec<(f64, f64)> {
    let in_metres = |(time_s, value): (f64, f64)| {
        Some((time_s, f64::from(pressure_altitude_m((value * factor) as f32)?)))
    };
    board.samples(column).into_iter().filter_map(in_metres).collect()
}

fn pressure(board: &mut Board<'_>, column: usize) {
    let name = board.quoted(column);
    let hint = board.hint(column);
    let Some(usual) = middle(board.numbers(column)) else { return };
    let fits = |factor: f64| PRESSURE_PA.contains(&(usual * factor));
    let mut units: Vec<_> = Quantity::Pressure.units().filter(|unit| fits(unit.factor)).collect();
    let named = hint.unit_of(Quantity::Pressure);
    if let Some(unit) = units.iter().find(|unit| Some(unit.name) == named) {
        units = vec![unit];
    }
    // Where the magnitude allows several units, use the one whose altitude agrees with the other columns.
    let near: Vec<_> =
        units.iter().copied().filter(|unit| lies_at_an_altitude(board, column, unit.factor)).collect();
    let is_told_apart = units.len() > 1 && near.len() == 1;
    let chosen = if is_told_apart { near.first() } else { units.first() };
    let Some(unit) = chosen.copied() else {
        let what =
            format!("its name says pressure, but about {usual:.4} is not an aircraft's pressure in any unit");
        board.set_aside(column, what);
        return;
    };
    if board.guess("baro_pa").is_some() {
        board.set_aside(column, "is a second pressure; one barometer is used");
        return;
    }
    let candidates: Vec<&str> = units.iter().map(|unit| unit.name).collect();
    let is_sure = (candidates.len() == 1 || is_told_apart) && named.is_none_or(|named| named == unit.name);
    let mut evidence =
        format!("{name}: its usual value {usual:.2} is an aircraft's pressure in {}", unit.name);
    if is_told_apart {
        evidence += ", the only unit that agrees with another column's altitude";
    } else if candidates.len() > 1 {
        evidence += &format!("; {} are equally likely", candidates.join(" and "));
    }
    if let Some(named) = named.filter(|named| *named != unit.name) {
        evidence += &format!("; its name says {named}");
    }
    if let Some((other, line)) = followed_altitude(board, column, unit.factor) {
        evidence += &format!(
            "; altitude {} follows it by the standard atmosphere (correlation {:.4})",
            board.quoted(other),
            line.correlation
        );
    }
    board.add_plain("baro_pa", column, Some(unit.name), is_sure, evidence);
}

/// Altitudes by name.
fn altitudes(board: &Board<'_>) -> Vec<usize> {
    let is_altitude = |role: Role| {
        matches!(
            role,
            Role::GpsAltitude
                | Role::BaroAltitude
                | Role::Altitude
                | Role::SlaveAltitude
                | Role::MasterAltitude
        )
    };
    let all = board.free().into_iter();
    all.filter(|column| board.role(*column).is_some_and(is_altitude) && !board.is_constant(*column)).collect()
}

/// Whether another column, in a unit of length, is close to the altitude of that pressure.
fn lies_at_an_altitude(board: &Board<'_>, column: usize, factor: f64) -> bool {
    let Some(height_m) = middle(pressure_altitudes(board, column, factor).into_iter().map(|sample| sample.1))
    else {
        return false;
    };
    altitudes(board).into_iter().any(|other| {
        let named = board.hint(other).unit_of(Quantity::Length);
        let units = Quantity::Length
            .units()
            .filter(|unit| named.map_or(unit.name == "m", |named| named == unit.name));
        let usual = middle(board.numbers(other)).unwrap_or(f64::NAN);
        units.into_iter().any(|unit| (usual * unit.factor - height_m).abs() < WEATHER_M)
    })
}

/// The line through altitudes over pressure altitude.
fn line(heights: &[(f64, f64)], altitudes: &[(f64, f64)]) -> Option<Line> {
    Line::through(&held(heights, altitudes, HOLD_S)).filter(Line::is_sound)
}

/// An altitude that follows a pressure, and the line through them.
fn followed_altitude(board: &Board<'_>, column: usize, factor: f64) -> Option<(usize, Line)> {
    let heights = pressure_altitudes(board, column, factor);
    let follows =
        |other: usize| Some((other, line(&heights, &board.fresh(other)).filter(|line| line.slope > 0.0)?));
    let found = altitudes(board).into_iter().filter_map(follows);
    found.max_by(|one, other| one.1.correlation.total_cmp(&other.1.correlation))
}

/// A column whose name is not a pressure's but which behaves as one: of the right magnitude, and an altitude
/// follows it.
fn unnamed_pressure(board: &mut Board<'_>) {
    for column in board.free() {
        let usual = middle(board.numbers(column)).unwrap_or(f64::NAN);
        if board.role(column).is_some() || board.is_constant(column) {
            continue;
        }
        for unit in Quantity::Pressure.units().filter(|unit| matches!(unit.name, "Pa" | "hPa" | "kPa")) {
            if !PRESSURE_PA.contains(&(usual * unit.factor)) {
                continue;
            }
            let heights = pressure_altitudes(board, column, unit.factor);
            let others = board.free().into_iter().filter(|other| *other != column);
            let follower = others
                .filter(|other| !board.is_constant(*other))
                .filter_map(|other| {
                    let line = line(&heights, &board.fresh(other)).filter(|line| line.correlation > 0.98)?;
                    let length = meant(Quantity::Length, 1.0 / line.slope, &board.hint(other))?;
                    // Apart from the weather, the line goes through the origin.
                    (line.slope > 0.0 && (line.offset * length.factor).abs() < WEATHER_M)
                        .then_some((other, line))
                })
                .max_by(|one, other| one.1.correlation.total_cmp(&other.1.correlation));
            if let Some((other, line)) = follower {
                let evidence = format!(
                    "{}: its usual value {usual:.2} is a pressure in {}, and {} follows it as an altitude by the standard \
                     atmosphere (correlation {:.4})",
                    board.quoted(column),
                    unit.name,
                    board.quoted(other),
                    line.correlation
                );
                board.add_plain("baro_pa", column, Some(unit.name), true, evidence);
                return;
            }
        }
    }
}

/// Altitudes of the barometer that was found; empty without one.
fn barometer_heights(board: &Board<'_>) -> Vec<(f64, f64)> {
    let samples = board.converted("baro_pa").into_iter();
    samples.filter_map(|(time_s, pa)| Some((time_s, f64::from(pressure_altitude_m(pa as f32)?)))).collect()
}

/// The line of a column against the barometer's altitude.
fn follows_pressure(board: &Board<'_>, column: usize) -> Option<Line> {
    let heights = barometer_heights(board);
    line(&heights, &board.fresh(column)).filter(|line| line.slope > 0.0 && line.correlation > 0.95)
}

fn altitude(board: &mut Board<'_>, column: usize, destination: &str) {
    let name = board.quoted(column);
    let hint = board.hint(column);
    if board.is_constant(column) {
        board.set_aside(column, "has the same value in every row");
        return;
    }
    let usual = middle(board.numbers(column)).unwrap_or(0.0);
    let heights = barometer_heights(board);
    let follows = follows_pressure(board, column);
    let named = hint.unit_of(Quantity::Length);
    let by_slope = follows.and_then(|line| Some((line, meant(Quantity::Length, 1.0 / line.slope, &hint)?)));
    let (unit, is_unit_sure, why) = match (&by_slope, named) {
        (Some((line, length)), _) => (
            length.unit,
            length.is_sure,
            format!(
                "{name} follows the barometer by the standard atmosphere, {:.3} of it per metre (correlation {:.4}): {}{}",
                line.slope,
                line.correlation,
                length.unit,
                name_agrees(length, &hint)
            ),
        ),
        (None, Some(named)) => {
            let rest = if heights.is_empty() {
                "no barometer to compare it with"
            } else {
                "too little climb to check it against the barometer"
            };
            (named, true, format!("{name}: its name says {named} ({rest})"))
        }
        (None, None) => match by_level(usual, &heights) {
            Some(unit) => {
                (unit, true, format!("{name}: about {usual:.0}, the barometer's altitude only in {unit}"))
            }
            None => ("m", false, format!("{name}: about {usual:.0}; it may be metres or feet")),
        },
    };
    let is_made_of_pressure = by_slope.is_some_and(|(line, length)| {
        let pairs = held(&heights, &board.fresh(column), HOLD_S);
        let squares = pairs
            .iter()
            .map(|(height, own)| ((own - line.offset - line.slope * height) * length.factor).powi(2));
        (squares.sum::<f64>() / pairs.len().max(1) as f64).sqrt() < MADE_OF_M
    });
    if is_made_of_pressure && destination != "gps_alt_m" {
        let what = format!(
            "is computed from the pressure in {}: not a second sensor",
            board.guess("baro_pa").map_or_else(String::new, |guess| board.quoted(guess.column))
        );
        board.set_aside(column, what);
        return;
    }
    let moves_with_fix = board.moves_with_fix(column);
    let (destination, is_place_sure, place) = match destination {
        "gps_alt_m" if is_made_of_pressure => {
            (destination, false, "but it has no error of its own: copied from the barometer?".to_owned())
        }
        "gps_alt_m" => (destination, true, "the receiver's, by its name".to_owned()),
        "baro_alt_m" if board.guess("baro_pa").is_some() => {
            board.set_aside(column, "is a barometer's altitude, and the barometer's pressure is used");
            return;
        }
        "" if moves_with_fix == Some(true) => {
            ("gps_alt_m", true, "it changes when the position does: the receiver's".to_owned())
        }
        "" if heights.is_empty() && board.guess("gps_alt_m").is_some() => {
            ("baro_alt_m", false, "its sensor is unknown: another column is the receiver's".to_owned())
        }
        "" => ("gps_alt_m", false, "its sensor is unknown; not computed from the pressure".to_owned()),
        other => (other, true, "its name gives the sensor".to_owned()),
    };
    if destination == "gps_alt_m" {
        let is_ellipsoid = hint.has(&["ellipsoid", "wgs84", "hae"]);
        if board.guess("gps_alt_m").is_some_and(|guess| guess.is_sure) {
            board.set_aside(column, "is another altitude of the receiver; one is used");
            return;
        }
        board.is_above_ellipsoid = is_ellipsoid;
    }
    board.add_plain(
        destination,
        column,
        Some(unit),
        is_unit_sure && is_place_sure,
        format!("{why}; {place}"),
    );
}

/// Metres or feet, whichever agrees with the barometer's altitude.
fn by_level(usual: f64, heights: &[(f64, f64)]) -> Option<&'static str> {
    let level_m = middle(heights.iter().map(|sample| sample.1))?;
    let fits = |factor: f64| (usual * factor - level_m).abs() < WEATHER_M;
    match (fits(1.0), fits(0.304_8)) {
        (true, false) => Some("m"),
        (false, true) => Some("ft"),
        _ => None,
    }
}
