//! Meaning of the names of a flight's columns.

use std::collections::BTreeMap;

use super::channel::Channel;
use super::error::CsvProblem;
use super::note::Note;

/// Name of the time axis.
pub const TIME: &str = "time_s";

/// Unit suffixes as people and logs write them. A column whose name is a known column's up to such a suffix
/// holds that quantity in another unit.
const UNITS: &[&str] = &[
    "m",
    "meter",
    "meters",
    "metre",
    "metres",
    "km",
    "cm",
    "mm",
    "ft",
    "feet",
    "kft",
    "fl",
    "nm",
    "mps",
    "ms",
    "m_s",
    "kt",
    "kts",
    "knot",
    "knots",
    "kmh",
    "kph",
    "km_h",
    "mph",
    "fps",
    "fpm",
    "mps2",
    "m_s2",
    "mss",
    "g",
    "mg",
    "ft_s2",
    "pa",
    "hpa",
    "kpa",
    "mbar",
    "mb",
    "bar",
    "inhg",
    "mmhg",
    "psi",
    "atm",
    "deg",
    "degs",
    "degree",
    "degrees",
    "rad",
    "rads",
    "radian",
    "radians",
    "mrad",
    "dps",
    "degps",
    "deg_s",
    "rad_s",
    "radps",
    "rpm",
    "c",
    "f",
    "k",
    "degc",
    "degf",
    "celsius",
    "fahrenheit",
    "kelvin",
    "s",
    "sec",
    "seconds",
    "msec",
    "us",
    "usec",
    "ns",
    "min",
    "h",
    "pct",
    "percent",
];

/// Content of a column.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Meaning {
    /// The time axis.
    Time,
    /// A known channel.
    Known(Channel),
    /// A signal of another name.
    Extra(String),
}

/// Meaning of every column of the row of names at line `row`, with notes on names that may be typing errors.
///
/// # Errors
/// The first name that is empty, repeated, or a known quantity in another unit; then the first required
/// column that is missing.
pub fn resolve(names: &[String], row: u64) -> Result<(Vec<Meaning>, Vec<Note>), CsvProblem> {
    let mut places = BTreeMap::new();
    for (name, number) in names.iter().zip(1..) {
        if name.is_empty() {
            return Err(CsvProblem::Unnamed { row, index: number });
        }
        if let Some(first) = places.insert(name.as_str(), number) {
            return Err(CsvProblem::Duplicate { row, name: name.clone(), first, second: number });
        }
    }
    let present = |known: &str| places.contains_key(known);
    let mut meanings = Vec::with_capacity(names.len());
    let mut notes = Vec::new();
    for name in names {
        meanings.push(match (name.as_str(), Channel::from_name(name)) {
            (TIME, _) => Meaning::Time,
            (_, Some(channel)) => Meaning::Known(channel),
            (_, None) => {
                // Beside the known column, the same quantity in another unit does no harm.
                let lower = name.to_ascii_lowercase();
                if let Some(known) = known_names().find(|known| lower == **known && !present(known)) {
                    return Err(CsvProblem::LetterCase { row, name: name.clone(), known });
                }
                if let Some(known) = same_quantity(&lower).filter(|known| !present(known)) {
                    return Err(CsvProblem::Unit { row, name: name.clone(), known });
                }
                if let Some(known) = nearly_known(name).filter(|known| !present(known)) {
                    notes.push(Note::new(format!(
                        "row {row}, column {name}: kept as a signal of that name; if it is meant as {known}, rename it"
                    )));
                }
                Meaning::Extra(name.clone())
            }
        });
    }
    if !present(TIME) {
        return Err(missing(TIME, names, row));
    }
    require_altitudes(|channel| present(channel.name())).map_err(|problem| match problem {
        CsvProblem::Missing { name, .. } => missing(name, names, row),
        other => other,
    })?;
    Ok((meanings, notes))
}

/// Checks that there is a reference and another altitude; `present` reports which channels exist.
pub fn require_altitudes(present: impl Fn(Channel) -> bool) -> Result<(), CsvProblem> {
    use Channel::{
        AccelXMps2, AccelYMps2, AccelZMps2, BaroAltM, BaroPa, GpsAltM, GyroXRadps, GyroYRadps, GyroZRadps,
        ImuMasterAltM, ImuSlaveAltM,
    };
    if !present(GpsAltM) {
        return Err(CsvProblem::Missing { row: 1, name: GpsAltM.name(), similar: None });
    }
    let altitude = [BaroPa, BaroAltM, ImuSlaveAltM, ImuMasterAltM].into_iter().any(&present);
    let inertial = [AccelXMps2, AccelYMps2, AccelZMps2, GyroXRadps, GyroYRadps, GyroZRadps];
    if altitude || inertial.into_iter().all(&present) { Ok(()) } else { Err(CsvProblem::NoSecondAltitude) }
}

fn missing(required: &'static str, names: &[String], row: u64) -> CsvProblem {
    let similar = names.iter().find(|name| is_slip(name, required)).cloned();
    CsvProblem::Missing { row, name: required, similar }
}

fn known_names() -> impl Iterator<Item = &'static str> {
    std::iter::once(TIME).chain(Channel::ALL.iter().map(|channel| channel.name()))
}

/// The known column that a name stands for in another case or unit, so that it cannot be used in a flight's
/// file.
pub fn unit_slip(name: &str) -> Option<&'static str> {
    let lower = name.to_ascii_lowercase();
    let is_known = known_names().any(|known| known == name);
    (!is_known)
        .then(|| known_names().find(|known| lower == **known).or_else(|| same_quantity(&lower)))
        .flatten()
}

/// The known column with the same quantity as `name` (in lower case), which has another unit or none.
fn same_quantity(name: &str) -> Option<&'static str> {
    known_names().filter(|known| *known != Channel::GpsSats.name()).find(|known| {
        let Some((stem, _unit)) = known.rsplit_once('_') else { return false };
        match name.strip_prefix(stem) {
            Some("") => true,
            Some(rest) => rest.strip_prefix('_').is_some_and(|unit| UNITS.contains(&unit)),
            None => false,
        }
    })
}

/// The known column that `name` may be a typing error of.
fn nearly_known(name: &str) -> Option<&'static str> {
    known_names().find(|known| is_slip(name, known))
}

/// One letter added, left out, changed or swapped with its neighbour. Short names, and names that only differ
/// by a digit or an axis letter, are too similar for this.
fn is_slip(name: &str, known: &str) -> bool {
    // Lengths first: a table may have a million names.
    let is_near = name.chars().take(known.len() + 2).count().abs_diff(known.len()) <= 1;
    known.len() >= 6
        && is_near
        && strsim::osa_distance(&name.to_ascii_lowercase(), known) == 1
        && !name.chars().any(|letter| letter.is_ascii_digit() && !known.contains(letter))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn resolve_names(names: &str) -> Result<(Vec<Meaning>, Vec<Note>), CsvProblem> {
        let names: Vec<_> = names.split(',').map(str::to_owned).collect();
        resolve(&names, 3)
    }

    #[test]
    fn many_names_are_bounded_work() {
        let names: Vec<String> = (0..200_000).map(|k| format!("gps_signal_{k}")).collect();
        let known = ["time_s", "gps_alt_m", "baro_alt_m"].map(str::to_owned);
        let (meanings, _) = resolve(&[&known[..], &names].concat(), 2).unwrap();
        assert_eq!(meanings.len(), 200_003);
        let twice = [&known[..], &names, &["gps_signal_7".to_owned()]].concat();
        let error = resolve(&twice, 2).unwrap_err();
        assert!(matches!(error, CsvProblem::Duplicate { first: 11, second: 200_004, .. }), "{error}");
    }

    fn message(names: &str) -> String {
        resolve_names(names).unwrap_err().to_string()
    }

    #[test]
    fn every_known_name_means_itself() {
        let names: Vec<_> = known_names().map(str::to_owned).collect();
        let (meanings, notes) = resolve(&names, 1).unwrap();
        assert_eq!(meanings[0], Meaning::Time);
        for (meaning, channel) in meanings[1..].iter().zip(Channel::ALL) {
            assert_eq!(*meaning, Meaning::Known(*channel));
        }
        assert_eq!(notes, []);
    }

    #[test]
    fn a_known_quantity_in_another_unit_names_the_column_it_resembles() {
        for (name, known) in [
            ("gps_alt_ft", "gps_alt_m"),
            ("gps_alt", "gps_alt_m"),
            ("GPS_Alt_ft", "gps_alt_m"),
            ("baro_hpa", "baro_pa"),
            ("baro_alt_feet", "baro_alt_m"),
            ("tas_kt", "tas_mps"),
            ("roll_deg", "roll_rad"),
            ("gyro_x_dps", "gyro_x_radps"),
            ("accel_z_g", "accel_z_mps2"),
            ("oat_k", "oat_c"),
            ("time_ms", "time_s"),
        ] {
            let text = message(&format!("time_x,{name}"));
            assert!(
                text.starts_with(&format!("row 3, column {name}: looks like {known}, but its unit")),
                "{text}"
            );
        }
    }

    #[test]
    fn names_are_in_lower_case() {
        let text = message("time_s,GPS_Alt_m");
        assert_eq!(text, "row 3, column GPS_Alt_m: expected the name in lower case, gps_alt_m");
        assert!(message("time_s,Launch").ends_with("lower case, launch"));
    }

    #[test]
    fn another_unit_beside_the_known_column_is_a_signal() {
        let (meanings, _) = resolve_names("time_s,gps_alt_m,baro_pa,baro_hpa").unwrap();
        assert_eq!(meanings[3], Meaning::Extra("baro_hpa".into()));
    }

    #[test]
    fn other_names_are_signals_and_slips_are_noted() {
        let (meanings, notes) = resolve_names("time_s,gps_alt_m,baro_pa,flap,baro_status,thottle").unwrap();
        assert_eq!(meanings[3], Meaning::Extra("flap".into()));
        assert_eq!(meanings[4], Meaning::Extra("baro_status".into()));
        assert_eq!(notes.len(), 1);
        assert!(notes[0].text().contains("if it is meant as throttle"), "{}", notes[0]);
    }

    #[test]
    fn names_what_is_missing() {
        assert_eq!(
            message("time_s,baro_pa"),
            "row 3: no column gps_alt_m; expected it, since every flight needs one"
        );
        assert!(message("tim_s,gps_alt_m,baro_pa").contains("no column time_s; expected it"));
        assert!(message("time_s,gpsalt_m,baro_pa").ends_with("(is it 'gpsalt_m'?)"));
        assert!(message("time_s,gps_alt_m").starts_with("no altitude besides gps_alt_m"));
        assert!(message("time_s,gps_alt_m,accel_x_mps2").starts_with("no altitude besides gps_alt_m"));
        resolve_names(
            "time_s,gps_alt_m,accel_x_mps2,accel_y_mps2,accel_z_mps2,gyro_x_radps,gyro_y_radps,gyro_z_radps",
        )
        .unwrap();
    }

    #[test]
    fn refuses_unnamed_and_duplicate_columns() {
        assert!(message("time_s,gps_alt_m,,baro_pa").starts_with("row 3: column 3 has no name"));
        assert!(message("time_s,flap,baro_pa,flap").contains("twice (columns 2 and 4)"));
    }
}
