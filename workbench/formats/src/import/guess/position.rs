//! Guesses which columns are the receiver's position and velocity.

use super::board::{Board, Guess};
use super::names::Role;
use super::relate::{Line, quantile};
use super::units::{meant, name_agrees};
use crate::import::mapping::quantity::Quantity;
use crate::import::mapping::{changes, middle};
use crate::import::signs::{DEGREE_M, windows};

/// A flight stays within this, degrees.
const FAR_DEG: f64 = 10.0;

/// Finds latitude and longitude.
pub fn find_position(board: &mut Board<'_>) {
    for (role, destination, most) in
        [(Role::Latitude, "latitude_deg", 90.0), (Role::Longitude, "longitude_deg", 180.0)]
    {
        for column in board.named(role) {
            named(board, column, destination, most);
        }
    }
    if board.guess("latitude_deg").is_none() && board.guess("longitude_deg").is_none() {
        unnamed(board);
    }
}

fn named(board: &mut Board<'_>, column: usize, destination: &str, most: f64) {
    let name = board.quoted(column);
    let hint = board.hint(column);
    let numbers = board.numbers(column);
    let largest = numbers.iter().fold(0.0, |largest: f64, value| largest.max(value.abs()));
    let is_whole = numbers.iter().all(|value| value.fract() == 0.0);
    let (unit, is_sure, what) = match largest {
        largest if largest <= most && !is_whole => {
            let is_radians = hint.unit_of(Quantity::Position) == Some("rad");
            if is_radians { ("rad", true, "radians by its name") } else { ("deg", true, "degrees") }
        }
        largest if is_whole && largest > 10.0 * most && largest <= most * 1e7 => {
            ("degE7", true, "whole numbers up to the ten-millionth of a degree")
        }
        largest if largest > most && largest < most * 100.0 + 100.0 => {
            board.set_aside(
                column,
                "degrees and minutes in one number (NMEA), which no factor converts to degrees",
            );
            return;
        }
        _ => ("deg", false, "not a position in any known unit"),
    };
    let (low, high) = range(&numbers);
    board.add_plain(
        destination,
        column,
        Some(unit),
        is_sure,
        format!("{name}: its name, and values from {low} to {high}: {what}"),
    );
}

fn range(numbers: &[f64]) -> (f64, f64) {
    numbers
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(*value), high.max(*value)))
}

/// Two adjacent columns that stay near one place, have many digits and change in the same rows.
fn unnamed(board: &mut Board<'_>) {
    let is_place = |column: usize, most: f64| {
        let numbers = board.numbers(column);
        let (low, high) = range(&numbers);
        let center = middle(numbers.iter().copied()).unwrap_or(0.0).abs();
        let has_digits =
            numbers.iter().filter(|value| (**value * 1e4).fract().abs() > 1e-6).count() * 2 > numbers.len();
        board.role(column).is_none()
            && has_digits
            && (high - low) > 1e-5
            && (high - low) < FAR_DEG
            && center > 5.0 * (high - low)
            && high.abs().max(low.abs()) <= most
    };
    let free = board.free();
    let pair = free.windows(2).find_map(|pair| match pair {
        [one, other] if other - one == 1 && is_place(*one, 90.0) && is_place(*other, 180.0) => {
            Some((*one, *other))
        }
        _ => None,
    });
    let Some((latitude, longitude)) = pair else { return };
    for (column, destination, what) in
        [(latitude, "latitude_deg", "latitude"), (longitude, "longitude_deg", "longitude")]
    {
        let (low, high) = range(&board.numbers(column));
        let evidence = format!(
            "{}: from {low} to {high} beside another such column: {what}, if latitude comes first",
            board.quoted(column)
        );
        board.add_plain(destination, column, Some("deg"), false, evidence);
    }
}

impl Board<'_> {
    /// The rows in which the receiver's position changes.
    fn fix_rows(&self) -> Option<Vec<bool>> {
        let mut rows: Option<Vec<bool>> = None;
        for destination in ["latitude_deg", "longitude_deg", "gps_vn_mps", "gps_ve_mps"] {
            let Some(guess) = self.guess(destination) else { continue };
            let rows = rows.get_or_insert_with(|| vec![false; self.table.lines.len()]);
            for (slot, is_new) in rows.iter_mut().zip(changes(self.table.values(guess.column))) {
                *slot |= is_new;
            }
        }
        rows
    }

    /// Whether a column changes only in rows in which the receiver's position does; `None` if that proves
    /// nothing, such as when the position changes in every row.
    pub fn moves_with_fix(&self, column: usize) -> Option<bool> {
        let fixes = self.fix_rows()?;
        let count = fixes.iter().filter(|is_fix| **is_fix).count();
        if count < 5 || count * 5 > fixes.len() * 4 {
            return None;
        }
        let own: Vec<bool> = changes(self.table.values(column)).collect();
        let all = own.iter().filter(|is_new| **is_new).count();
        let with = own.iter().zip(&fixes).filter(|(is_new, is_fix)| **is_new && **is_fix).count();
        Some(with * 10 >= all * 9)
    }
}

/// Finds the velocities over ground by the position, whose derivatives they are.
pub fn find_horizontal(board: &mut Board<'_>) {
    let latitude_deg =
        middle(board.converted("latitude_deg").into_iter().map(|sample| sample.1)).unwrap_or(0.0);
    let scaled = |samples: Vec<(f64, f64)>, by: f64| {
        samples.into_iter().map(|(time_s, value)| (time_s, value * by)).collect::<Vec<_>>()
    };
    let north = scaled(board.converted("latitude_deg"), DEGREE_M);
    let east = scaled(board.converted("longitude_deg"), DEGREE_M * latitude_deg.to_radians().cos());
    find_velocity(board, &[Role::North], "gps_vn_mps", &north, "latitude");
    find_velocity(board, &[Role::East], "gps_ve_mps", &east, "longitude");
    confirm_unnamed_position(board);
}

/// Finds the receiver's vertical velocity by the altitude, whose derivative it is: the receiver's altitude,
/// or any other if it has none.
pub fn find_vertical(board: &mut Board<'_>) {
    let is_known = |name: &str| board.guess(name).is_some_and(|guess| guess.is_sure);
    if is_known("gps_vn_mps")
        && board.guess("gps_alt_m").is_none()
        && board.named(Role::GpsAltitude).is_empty()
    {
        unnamed_altitude(board);
    }
    let names = ["gps_alt_m", "baro_alt_m", "imu_slave_alt_m"].into_iter();
    let altitude = names.map(|name| board.converted(name)).find(|samples| !samples.is_empty());
    let down: Vec<(f64, f64)> =
        altitude.unwrap_or_default().into_iter().map(|(time_s, m)| (time_s, -m)).collect();
    find_velocity(board, &[Role::Down, Role::Climb], "gps_vd_mps", &down, "altitude");
}

/// If velocities over ground are known: the column whose change is another column's integral is the
/// receiver's altitude.
fn unnamed_altitude(board: &mut Board<'_>) {
    let unnamed: Vec<usize> = board
        .free()
        .into_iter()
        .filter(|column| board.role(*column).is_none() && board.moves_with_fix(*column) != Some(false))
        .filter(|column| !board.is_constant(*column))
        .collect();
    let line = |altitude: usize, velocity: usize| {
        let line = Line::through(&windows(&board.samples(velocity), &board.samples(altitude)));
        line.filter(|line| line.is_sound() && line.correlation.abs() > 0.9)
    };
    let pairs = unnamed.iter().flat_map(|altitude| unnamed.iter().map(|velocity| (*altitude, *velocity)));
    let found = pairs
        .filter(|(altitude, velocity)| altitude != velocity)
        .filter_map(|(altitude, velocity)| Some((altitude, velocity, line(altitude, velocity)?)))
        .max_by(|one, other| one.2.correlation.abs().total_cmp(&other.2.correlation.abs()));
    let Some((altitude, velocity, line)) = found else { return };
    let Some(length) = meant(Quantity::Length, 1.0 / line.slope, &board.hint(altitude)) else { return };
    let evidence = format!(
        "{}: over 5 s it changes by {:.3} per unit of the integral of {} (correlation {:+.2}), as an altitude in {} does with its \
         climb rate in m/s, the unit of the velocities over ground",
        board.quoted(altitude),
        line.slope.abs(),
        board.quoted(velocity),
        line.correlation,
        length.unit
    );
    let is_in_mps = board.guess("gps_vn_mps").is_some_and(|guess| guess.unit == Some("m/s"));
    board.add_plain("gps_alt_m", altitude, Some(length.unit), length.is_sure && is_in_mps, evidence);
}

fn find_velocity(
    board: &mut Board<'_>,
    roles: &[Role],
    destination: &str,
    position: &[(f64, f64)],
    of: &str,
) {
    for role in roles {
        for column in board.named(*role) {
            velocity(board, column, destination, position, of, true);
        }
    }
    if board.guess(destination).is_none() {
        let unnamed = board.free().into_iter().filter(|column| board.role(*column).is_none());
        for column in unnamed.collect::<Vec<_>>() {
            velocity(board, column, destination, position, of, false);
        }
    }
}

fn velocity(
    board: &mut Board<'_>,
    column: usize,
    destination: &str,
    position: &[(f64, f64)],
    of: &str,
    is_named: bool,
) {
    if board.is_constant(column) {
        return;
    }
    let name = board.quoted(column);
    let hint = board.hint(column);
    let line = Line::through(&windows(&board.samples(column), position)).filter(Line::is_sound);
    let by_slope = line.and_then(|line| Some((line, meant(Quantity::Speed, line.slope, &hint)?)));
    let is_climb = destination == "gps_vd_mps";
    let says_up = hint.role == Some(Role::Climb);
    let (unit, is_unit_sure, is_turned, mut evidence) = match by_slope {
        Some((line, speed)) => {
            let is_turned = line.slope < 0.0;
            let sign = if is_turned { "against" } else { "with" };
            let mut evidence = format!(
                "{name}: over 5 s its integral runs {sign} {}, by {:.3} per unit (correlation {:+.2}): {}{}",
                if is_climb { "the descent that the altitude shows" } else { of },
                line.slope.abs(),
                line.correlation,
                speed.unit,
                name_agrees(&speed, &hint)
            );
            if is_climb && is_named && is_turned != says_up {
                evidence += "; its name implies the opposite sign";
            }
            (speed.unit, speed.is_sure, is_turned, evidence)
        }
        None if is_named => {
            let named = hint.unit_of(Quantity::Speed);
            let unit = named.unwrap_or("m/s");
            let what = if named.is_some() { "its name says" } else { "its unit is unknown, perhaps" };
            let why = if position.is_empty() {
                format!("no {of} to check that against")
            } else {
                format!("the flight shows too little of it to check that against {of}")
            };
            let evidence = format!("{name}: {what} {unit} ({why})");
            (unit, named.is_some(), is_climb && says_up, evidence)
        }
        None => return,
    };
    // A climb rate may be the barometer's, which is not a reference.
    let is_receivers = !is_climb
        || hint.is_gps()
        || hint.role == Some(Role::Down)
        || board.moves_with_fix(column) == Some(true);
    // A line found among many columns without names must fit well.
    let is_found = is_named
        || (by_slope.is_some_and(|(line, _)| line.correlation.abs() > 0.95)
            && board.guess("latitude_deg").is_some());
    if !is_found {
        return;
    }
    if !is_receivers {
        evidence += "; it may be the receiver's or the barometer's";
    }
    board.add(Guess {
        destination: destination.to_owned(),
        column,
        unit: Some(unit),
        scale: is_turned.then_some(-1.0),
        offset: None,
        held: false,
        is_sure: is_unit_sure && is_receivers,
        evidence,
    });
}

/// Confirms a position that was guessed only by its values, if velocities agree with it.
fn confirm_unnamed_position(board: &mut Board<'_>) {
    let is_found = |name: &str| board.guess(name).is_some_and(|guess| guess.is_sure);
    if !(is_found("gps_vn_mps") && is_found("gps_ve_mps")) {
        return;
    }
    for guess in &mut board.guesses {
        if matches!(guess.destination.as_str(), "latitude_deg" | "longitude_deg") && !guess.is_sure {
            guess.is_sure = true;
            guess.evidence += "; confirmed: two other columns are its velocity";
        }
    }
}

/// Speed over ground between the fixes, m/s; `None` without positions.
pub fn ground_speed(board: &Board<'_>) -> Option<f64> {
    let (north, east) = (board.converted("gps_vn_mps"), board.converted("gps_ve_mps"));
    let pairs = super::relate::held(&north, &east, 1.5);
    if !pairs.is_empty() {
        return quantile(pairs.into_iter().map(|(north, east)| north.hypot(east)), 0.5);
    }
    let (latitudes, longitudes) = (board.converted("latitude_deg"), board.converted("longitude_deg"));
    let cosine = latitudes.first()?.1.to_radians().cos();
    let places: Vec<(f64, f64, f64)> = {
        let mut next = 0;
        let mut found = Vec::new();
        for (time_s, longitude) in &longitudes {
            while latitudes.get(next + 1).is_some_and(|later| later.0 <= *time_s) {
                next += 1;
            }
            if let Some((_, latitude)) = latitudes.get(next) {
                found.push((*time_s, latitude * DEGREE_M, longitude * DEGREE_M * cosine));
            }
        }
        found
    };
    let stride = (places.len() / 200).max(1);
    let speeds = places.iter().zip(places.iter().skip(stride)).filter(|(one, other)| other.0 > one.0);
    quantile(speeds.map(|(one, other)| (other.1 - one.1).hypot(other.2 - one.2) / (other.0 - one.0)), 0.5)
}
