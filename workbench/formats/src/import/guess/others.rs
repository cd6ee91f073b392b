//! Guesses the columns that are independent of others: temperatures, airspeed, satellites, throttle, launch.

use super::board::{Board, Guess};
use super::names::Role;
use super::position::ground_speed;
use super::relate::{Line, quantile};
use crate::import::mapping::middle;
use crate::import::mapping::quantity::Quantity;

/// Bounds of the ratio of airspeed to speed over ground over a whole flight, with wind and climb.
const RATIO: std::ops::RangeInclusive<f64> = 0.65..=1.5;

/// Finds these columns.
pub fn find(board: &mut Board<'_>) {
    for (role, destination, is_place_sure) in [
        (Role::BaroTemperature, "baro_temp_c", true),
        (Role::OutsideTemperature, "oat_c", true),
        (Role::Temperature, "baro_temp_c", false),
    ] {
        for column in board.named(role) {
            temperature(board, column, destination, is_place_sure);
        }
    }
    for column in board.named(Role::TrueAirspeed) {
        airspeed(board, column, true);
    }
    for column in board.named(Role::Airspeed) {
        airspeed(board, column, false);
    }
    for column in board.named(Role::Satellites) {
        let numbers = board.numbers(column);
        let is_count = numbers.iter().all(|value| value.fract() == 0.0 && (0.0..=80.0).contains(value));
        let what = format!("{}: its name, and whole numbers up to 80: {is_count}", board.quoted(column));
        let what = what.replace(": true", "").replace("80: false", "80 were expected");
        board.add_plain("gps_sats", column, None, is_count, what);
    }
    for column in board.named(Role::VerticalAccuracy) {
        let named = board.hint(column).unit_of(Quantity::Length);
        let usual = middle(board.numbers(column)).unwrap_or(0.0);
        let unit = named.unwrap_or(if usual > 200.0 { "mm" } else { "m" });
        let what = format!("{}: its name; about {usual:.1}", board.quoted(column));
        board.add_plain(
            "gps_vacc_m",
            column,
            Some(unit),
            named.is_some() || (0.2..50.0).contains(&usual),
            what,
        );
    }
    for column in board.named(Role::ReceiverTime) {
        receiver_time(board, column);
    }
    for column in board.named(Role::Throttle) {
        throttle(board, column);
    }
    for column in board.named(Role::Launch) {
        let is_switch = board.numbers(column).iter().all(|value| matches!(value, 0.0 | 1.0));
        let what = format!(
            "{}: its name{}",
            board.quoted(column),
            if is_switch { ", and only 0 and 1" } else { "; but not only 0 and 1" }
        );
        board.add_plain("launch", column, None, is_switch, what);
    }
    for (role, destination) in [(Role::AngleOfAttack, "aoa_rad"), (Role::Sideslip, "sideslip_rad")] {
        for column in board.named(role) {
            let named = board.hint(column).unit_of(Quantity::Angle);
            let largest =
                board.numbers(column).iter().fold(0.0, |largest: f64, value| largest.max(value.abs()));
            let is_degrees = largest > 3.2;
            let unit = named.unwrap_or(if is_degrees { "deg" } else { "rad" });
            let is_sure = named.map_or(is_degrees, |named| named != "rad" || !is_degrees);
            let what = format!("{}: its name; values reach {largest:.2}", board.quoted(column));
            board.add_plain(destination, column, Some(unit), is_sure, what);
        }
    }
    for column in board.named(Role::GroundSpeed) {
        board.set_aside(column, "is a speed over ground; Pylon uses north and east velocity");
    }
}

fn temperature(board: &mut Board<'_>, column: usize, destination: &str, is_place_sure: bool) {
    let named = board.hint(column).unit_of(Quantity::Temperature);
    let usual = middle(board.numbers(column)).unwrap_or(0.0);
    let by_size = match usual {
        usual if (200.0..=340.0).contains(&usual) => Some("K"),
        usual if (-60.0..=60.0).contains(&usual) => Some("C"),
        usual if (2_000.0..=6_000.0).contains(&usual) => Some("cC"),
        _ => None,
    };
    let unit = named.or(by_size).unwrap_or("C");
    // Without a unit in the name, 15 to 60 may be Fahrenheit; beyond, only one of the units is plausible in
    // flight.
    let is_unit_sure = named.is_some() || by_size.is_some_and(|unit| unit != "C" || usual < 45.0);
    let doubt = if is_place_sure { "" } else { "; it may not be the barometer's" };
    let what = format!("{}: its name; about {usual:.1}: {unit}{doubt}", board.quoted(column));
    board.add_plain(destination, column, Some(unit), is_unit_sure && is_place_sure, what);
}

fn airspeed(board: &mut Board<'_>, column: usize, is_true: bool) {
    let name = board.quoted(column);
    let hint = board.hint(column);
    let named = hint.unit_of(Quantity::Speed);
    let flown = quantile(board.numbers(column), 0.5).filter(|speed| *speed > 0.0);
    let ratio = ground_speed(board).zip(flown).map(|(ground, air)| ground / air);
    let fits = |factor: f64| ratio.is_some_and(|ratio| RATIO.contains(&(ratio / factor)));
    let by_ground: Vec<&str> =
        Quantity::Speed.units().filter(|unit| fits(unit.factor)).map(|unit| unit.name).collect();
    let (unit, is_unit_sure, why) = match (named, by_ground.as_slice()) {
        (Some(named), []) if ratio.is_some() => {
            (named, false, format!("its name says {named}, but then it contradicts the speed over ground"))
        }
        (Some(named), _) => (named, true, format!("its name says {named}")),
        (None, [only]) => {
            (*only, true, format!("compared with the speed over ground, it can only be in {only}"))
        }
        (None, [first, ..]) => (
            *first,
            false,
            format!("compared with the speed over ground, it may be in {}", by_ground.join(" or ")),
        ),
        (None, []) => ("m/s", false, "its unit is unknown".to_owned()),
    };
    let doubt = if is_true {
        ""
    } else {
        "; indicated or calibrated, but true airspeed is needed: no factor converts one into the other"
    };
    board.add_plain("tas_mps", column, Some(unit), is_true && is_unit_sure, format!("{name}: {why}{doubt}"));
}

fn receiver_time(board: &mut Board<'_>, column: usize) {
    let line = Line::through(&board.samples(column)).filter(Line::is_sound);
    let named = board.hint(column).unit_of(Quantity::Time);
    let unit = line.and_then(|line| {
        super::relate::factor(1.0 / line.slope, Quantity::Time.units().map(|unit| (unit.name, unit.factor)))
    });
    let name = board.quoted(column);
    match (unit, named) {
        (Some(unit), _) => {
            let what = format!("{name}: its name, and it runs with the time base: {unit}");
            board.add_plain("gps_time_s", column, Some(unit), named.is_none_or(|named| named == unit), what);
        }
        (None, _) => board.set_aside(column, "does not run with the time base"),
    }
}

fn throttle(board: &mut Board<'_>, column: usize) {
    let numbers = board.numbers(column);
    let low = quantile(numbers.iter().copied(), 0.0).unwrap_or(0.0);
    let high = quantile(numbers.iter().copied(), 1.0).unwrap_or(0.0);
    let named = board.hint(column).unit_of(Quantity::Share);
    let is_within = |from: f64, to: f64| low >= from && high <= to;
    let (unit, scale, offset, is_sure, what) = if is_within(0.0, 1.0) && named != Some("%") {
        ("1", None, None, true, "from 0 to 1")
    } else if is_within(0.0, 100.0) {
        ("%", None, None, named == Some("%") || high > 30.0, "from 0 to 100: per cent")
    } else if is_within(800.0, 2_200.0) {
        ("1", Some(0.001), Some(-1.0), true, "from 1000 to 2000: a servo's pulse in microseconds")
    } else {
        ("1", None, None, false, "in no known unit")
    };
    let evidence = format!("{}: its name, and values from {low} to {high}, {what}", board.quoted(column));
    board.add(Guess {
        destination: "throttle".to_owned(),
        column,
        unit: Some(unit),
        scale,
        offset,
        held: false,
        is_sure,
        evidence,
    });
}
