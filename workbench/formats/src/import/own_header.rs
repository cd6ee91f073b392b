//! A flight's header and columns as Pylon writes them into other programs' formats; in a damaged file they
//! may be invalid.

use flight_data::{AltitudeDatum, Channel, Column, Flight, Header, Note, unit_slip};

/// The header with these keys, in their order. In a damaged file they may contain line ends, which a flight's
/// header cannot.
pub fn own_header(keys: impl IntoIterator<Item = (String, String)>) -> Header {
    let clean = |text: String| text.replace(['\n', '\r'], " ");
    let mut header = Header::default();
    for (key, value) in keys {
        let value = clean(value);
        match key.trim() {
            "vehicle" => header.vehicle = value,
            "source" => header.source = value,
            "altitude_datum" if value == AltitudeDatum::Ellipsoid.name() => {
                header.altitude_datum = AltitudeDatum::Ellipsoid;
            }
            "altitude_datum" | "pylon-flight" | "" => {}
            _ => header.other.push((clean(key).replace(':', " "), value)),
        }
    }
    header
}

/// Adds a column under its name. In a damaged file the name may be one that a flight's CSV cannot have, or
/// that exists already: then the column is left out and a note returned.
pub fn put_column(flight: &mut Flight, name: &str, column: Column) -> Option<Note> {
    let has =
        |name: &str| name == "time_s" || flight.channels.iter().any(|(channel, _)| channel.name() == name);
    let is_taken = has(name) || flight.extra.iter().any(|(other, _)| other == name);
    // Beside the known column, one in another unit is a signal; the known columns come first.
    let is_slip = unit_slip(name).is_some_and(|known| !has(known));
    let is_name = !name.is_empty() && name.trim() == name && !name.contains(char::is_control);
    if !is_name || is_taken || is_slip {
        let what = if is_taken { "occurs twice" } else { "has a name that no column of a flight has" };
        let shown: String = name.chars().take(40).filter(|letter| !letter.is_control()).collect();
        return Some(Note::new(format!("damaged: column '{shown}' {what}, left out")));
    }
    match Channel::from_name(name) {
        Some(channel) => flight.set_channel(channel, column),
        None => flight.extra.push((name.to_owned(), column)),
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_that_could_not_be_written_is_left_out_and_said() {
        let mut flight = Flight { time_s: vec![0.0], ..Flight::default() };
        let column = || {
            let mut column = Column::default();
            column.push(Some(1.0));
            column
        };
        for name in ["gps_alt_m", "flap", "gps_alt_ft"] {
            assert_eq!(put_column(&mut flight, name, column()), None);
        }
        for name in [
            " aro_alt_m",
            "gps_al   ",
            "",
            "a\nb",
            "a\0b",
            "gps_alt_m",
            "flap",
            "time_s",
            "baro_alt_ft",
            "Baro_alt_m",
        ] {
            let note = put_column(&mut flight, name, column());
            assert!(note.is_some_and(|note| note.text().ends_with("left out")), "{name:?}");
        }
        flight_data::to_writer(Vec::new(), &flight).unwrap();
        assert_eq!((flight.channels.len(), flight.extra.len()), (1, 2));
    }
}
