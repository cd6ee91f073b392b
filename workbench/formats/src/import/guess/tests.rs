use super::*;
use crate::import::mapping::Mapping;
use flight_data::{Channel, Flight};
use simulate::{Scenario, simulate};

fn quickstart() -> Flight {
    let text = include_str!("../../../../../flights/quickstart.toml");
    simulate(&Scenario::from_toml(text, "quickstart.toml").unwrap(), 7).unwrap().0
}

/// A signal's new name, its unit there, and the value of Pylon's unit in that unit.
type Renamed<'a> = (&'a str, &'a str, f64, f64);

/// The flight as another program's table: names, factors and offsets by channel; other channels dropped.
fn table(flight: &Flight, time: (&str, f64), columns: &[Renamed<'_>], separator: char) -> String {
    let names: Vec<String> =
        [time.0.to_owned()].into_iter().chain(columns.iter().map(|column| column.1.to_owned())).collect();
    let mut text = format!("Logger of somebody, v1.2\n{}\n", names.join(&separator.to_string()));
    for (row, time_s) in flight.time_s.iter().enumerate() {
        text += &format!("{}", time_s * time.1);
        for (channel, _, factor, offset) in columns {
            let cell = Channel::from_name(channel).and_then(|channel| flight.channel(channel)?.get(row));
            text.push(separator);
            if let Some(value) = cell {
                text += &format!("{}", f64::from(value) * factor + offset);
            }
        }
        text.push('\n');
    }
    text
}

fn draft(text: &str) -> Draft {
    guess(&LoggedTable::read(text.as_bytes(), mapping::Layout::find(text.as_bytes()).unwrap()))
}

/// Reads a table with its own draft.
fn by_draft(text: &str) -> (Draft, Flight) {
    let draft = draft(text);
    let written = draft.text("log.csv", "mapping.toml");
    let (flight, _) =
        mapping::import(text.as_bytes(), &Mapping::parse(&written).unwrap(), "mapping.toml").unwrap();
    (draft, flight)
}

/// Every sample of these channels equals the flight's, except for rounding.
fn assert_same(found: &Flight, flight: &Flight, names: &[&str]) {
    for name in names {
        let channel = Channel::from_name(name).unwrap();
        let (own, other) = (flight.channel(channel).unwrap(), found.channel(channel));
        let other = other.unwrap_or_else(|| panic!("{name} is not in what was read"));
        let (own, other): (Vec<_>, Vec<_>) = (own.samples().collect(), other.samples().collect());
        assert_eq!(own.len(), other.len(), "{name}");
        for ((row, value), (at, read)) in own.iter().zip(&other) {
            assert_eq!(row, at, "{name}");
            assert!((value - read).abs() <= 2e-6 * value.abs().max(1.0), "{name}: {value} {read}");
        }
    }
}

#[test]
fn another_programs_names_and_units_are_found_back_by_name_and_physics() {
    let flight = quickstart();
    let columns = [
        ("gps_alt_m", "GPS Altitude [ft]", 1.0 / 0.3048, 0.0),
        ("gps_vn_mps", "velN (kt)", 3_600.0 / 1_852.0, 0.0),
        ("gps_ve_mps", "velE (kt)", 3_600.0 / 1_852.0, 0.0),
        ("gps_vd_mps", "GPS climb rate", -1.0, 0.0),
        ("baro_pa", "Pressure", 0.01, 0.0),
        ("baro_temp_c", "baroTemp [K]", 1.0, 273.15),
        ("accel_x_mps2", "AccX", 1.0 / 9.806_65, 0.0),
        ("accel_y_mps2", "AccY", 1.0 / 9.806_65, 0.0),
        ("accel_z_mps2", "AccZ", 1.0 / 9.806_65, 0.0),
        ("gyro_x_radps", "GyroX", 57.295_779_5, 0.0),
        ("gyro_y_radps", "GyroY", 57.295_779_5, 0.0),
        ("gyro_z_radps", "GyroZ", 57.295_779_5, 0.0),
        ("roll_rad", "Roll", 57.295_779_5, 0.0),
        ("pitch_rad", "Pitch", 57.295_779_5, 0.0),
        ("yaw_rad", "Heading", 57.295_779_5, 0.0),
        ("tas_mps", "TAS km/h", 3.6, 0.0),
        ("throttle", "Throttle", 100.0, 0.0),
        ("launch", "released", 1.0, 0.0),
        ("gps_sats", "numSV", 1.0, 0.0),
    ];
    let names: Vec<&str> = columns.iter().map(|column| column.0).collect();
    let text = table(&flight, ("time (ms)", 1_000.0), &columns, ';');
    let (draft, found) = by_draft(&text);
    assert!(draft.guesses().iter().all(|guess| guess.is_sure), "{}", draft.explanation());
    assert_same(&found, &flight, &names);
    assert_eq!(found.time_s.len(), flight.time_s.len());
    let explanation = draft.explanation();
    for words in [
        "GPS Altitude [ft]' follows the barometer by the standard atmosphere, 3.3",
        "'GPS climb rate': over 5 s its integral runs against the descent that the altitude shows",
        "is an aircraft's pressure in hPa",
        "one g in g",
        "the attitude turns by 0.017",
    ] {
        assert!(explanation.contains(words), "{words}: {explanation}");
    }
}

#[test]
fn without_a_name_nothing_is_placed_wrongly_and_what_physics_tells_is() {
    let flight = quickstart();
    let columns = [
        ("gps_alt_m", "c1", 1.0, 0.0),
        ("gps_vn_mps", "c2", 1.0, 0.0),
        ("gps_vd_mps", "c3", 1.0, 0.0),
        ("baro_pa", "c4", 0.01, 0.0),
        ("imu_slave_alt_m", "c5", 3.280_84, 0.0),
        ("accel_z_mps2", "c6", 1.0, 0.0),
        ("throttle", "c7", 1.0, 0.0),
        ("tas_mps", "c8", 1.0, 0.0),
    ];
    let draft = draft(&table(&flight, ("c0", 1e6), &columns, ','));
    let text = draft.explanation();
    assert!(draft.time().is_some_and(|time| time.unit == Some("us") && time.is_sure), "{text}");
    for guess in draft.guesses().iter().filter(|guess| guess.is_sure) {
        let of = columns[guess.column - 1].0;
        assert_eq!(guess.destination, of, "{text}");
    }
    assert!(draft.guesses().iter().any(|guess| guess.destination == "baro_pa" && guess.is_sure), "{text}");
    // The values do not show whose altitude it is.
    let altitude = draft.guesses().iter().find(|guess| guess.destination == "gps_alt_m").unwrap();
    assert!(!altitude.is_sure && altitude.evidence.contains("its sensor is unknown"), "{text}");
    assert!(text.contains("still needed: gps_alt_m"), "{text}");
}

#[test]
fn a_unit_in_a_name_that_the_values_contradict_is_doubtful() {
    let flight = quickstart();
    let columns = [
        ("gps_alt_m", "gps_alt_ft", 1.0, 0.0),
        ("baro_pa", "press_hPa", 1.0, 0.0),
        ("roll_rad", "roll_rad", 57.3, 0.0),
        ("gps_vd_mps", "gps_vd_kt", 1.0, 0.0),
    ];
    let draft = draft(&table(&flight, ("time_s", 1.0), &columns, ','));
    for (name, words) in [
        ("gps_alt_m", ": m, but its name says ft"),
        ("baro_pa", "an aircraft's pressure in Pa; its name says hPa; altitude 'gps_alt_ft' follows it"),
        ("roll_rad", "its name says rad, but values reach"),
        ("gps_vd_mps", ": m/s, but its name says kt"),
    ] {
        let guess = draft.guesses().iter().find(|guess| guess.destination == name).unwrap();
        assert!(!guess.is_sure && guess.evidence.contains(words), "{guess:?}");
    }
    let text = draft.text("log.csv", "m.toml");
    assert!(text.contains("# baro_pa = { column = \"press_hPa\", unit = \"Pa\" }"), "{text}");
}

#[test]
fn every_draft_reads_as_a_mapping_whatever_the_names_are() {
    for names in
        ["time_s,\"a\"\"b\",a = 3", "t,#x,\\n", "time_s,time_s,time_s", "t,gps_alt_ft,baro_hpa", "t,é,漢"]
    {
        let rows: String = (0..100).map(|k| format!("{},{},{}\n", k as f64 / 10.0, k % 7, 90 - k)).collect();
        let draft = draft(&format!("{names}\n{rows}"));
        let text = draft.text("log.csv", "m.toml");
        Mapping::parse(&text).unwrap_or_else(|error| panic!("{names}: {error}\n{text}"));
        // The mapping also parses with all commented-out lines included.
        let all: String = text
            .lines()
            .map(|line| match line.strip_prefix("# ") {
                Some(rest) if rest.contains(" = { column = ") => format!("{rest}\n"),
                _ => format!("{line}\n"),
            })
            .collect();
        Mapping::parse(&all).unwrap_or_else(|error| panic!("{names}: {error}\n{all}"));
    }
}

#[test]
fn held_fixes_are_seen_and_taken_once() {
    let flight = quickstart();
    let text = table(
        &flight,
        ("time_s", 1.0),
        &[
            ("gps_alt_m", "gps_alt_m", 1.0, 0.0),
            ("gps_vn_mps", "gps_vn_mps", 1.0, 0.0),
            ("baro_pa", "baro_pa", 1.0, 0.0),
        ],
        ',',
    );
    // Each cell holds until the next, as in the files of many loggers.
    let mut held = String::new();
    let mut latest: Vec<String> = Vec::new();
    for line in text.lines() {
        let cells: Vec<String> = line.split(',').map(str::to_owned).collect();
        latest.resize(cells.len(), String::new());
        for (latest, cell) in latest.iter_mut().zip(cells) {
            if !cell.is_empty() {
                *latest = cell;
            }
        }
        held += &format!("{}\n", latest.join(","));
    }
    let held = held.replacen("Logger of somebody, v1.2,,\n", "", 1);
    let (draft, found) = by_draft(&held);
    let guess = draft.guesses().iter().find(|guess| guess.destination == "gps_alt_m").unwrap();
    assert!(guess.held && guess.is_sure, "{}", draft.explanation());
    let count = |flight: &Flight| flight.channel(Channel::GpsAltM).unwrap().samples().count();
    assert_eq!(count(&found), count(&flight));
    let mut written = Vec::new();
    flight_data::to_writer(&mut written, &found).unwrap();
    flight_data::parse(&written).unwrap();
}
