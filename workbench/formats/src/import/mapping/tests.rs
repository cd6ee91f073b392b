use super::super::{Fault, import};
use super::*;

/// Twenty rows a second; a position that moves north by 10 m/s and changes five times a second.
fn log() -> String {
    let mut text = "Time,P,Alt,Lat,Lon,State\n".to_owned();
    for row in 0..200_i32 {
        let fix = row / 4 * 4;
        let north_deg = f64::from(fix) * 0.5 / 111_195.0;
        text += &format!(
            "{},{},{},{},{},up\n",
            row * 50,
            950.0 + f64::from(row) / 100.0,
            1_000.0 + f64::from(fix),
            47.0 + north_deg,
            8.5
        );
    }
    text
}

const MAPPING: &str = "pylon-mapping = 1\n[flight]\nvehicle = \"kite\"\n[time]\ncolumn = \"Time\"\nunit = \"ms\"\n[signals]\n\
    baro_pa = { column = \"P\", unit = \"hPa\" }\ngps_alt_m = { column = \"Alt\", unit = \"ft\", held = true }\n\
    latitude_deg = { column = \"Lat\", held = true }\nlongitude_deg = { column = 5, held = true }\n";

fn read(log: &str, mapping: &str) -> Result<(Flight, Vec<String>), String> {
    let mapping = Mapping::parse(mapping).map_err(|error| error.to_string())?;
    match import(log.as_bytes(), &mapping, "m.toml") {
        Ok((flight, notes)) => Ok((flight, notes.iter().map(|note| note.text().to_owned()).collect())),
        Err(Fault::Log(what)) => Err(format!("log: {what}")),
        Err(Fault::Mapping(what)) => Err(format!("mapping: {what}")),
    }
}

fn samples(flight: &Flight, channel: Channel) -> Vec<f32> {
    flight.channel(channel).unwrap().samples().map(|(_, value)| value).collect()
}

#[test]
fn columns_become_signals_in_pylons_units_and_held_fixes_are_one() {
    let (flight, notes) = read(&log(), MAPPING).unwrap();
    assert_eq!((flight.rows(), flight.time_s[1], flight.header.vehicle.as_str()), (200, 0.05, "kite"));
    assert_eq!(samples(&flight, Channel::BaroPa)[..2], [95_000.0, 95_001.0]);
    let altitudes = samples(&flight, Channel::GpsAltM);
    assert_eq!((altitudes.len(), altitudes[0]), (50, 304.8));
    let north = samples(&flight, Channel::GpsVnMps);
    assert!(north.len() == 50 && north.iter().all(|mps| (mps - 10.0).abs() < 0.1), "{north:?}");
    assert!(notes.iter().any(|note| note.contains("left out: State")), "{notes:?}");
}

#[test]
fn a_signal_may_have_a_datum_of_its_own() {
    let with = |datum: &str| {
        let own = format!("imu_master_alt_m = {{ column = \"Alt\", unit = \"ft\", datum = \"{datum}\" }}\n");
        read(&log(), &(MAPPING.to_owned() + &own)).map(|(flight, _)| flight.header)
    };
    let header = with("ellipsoid").unwrap();
    assert_eq!(header.datum_of("imu_master_alt_m").name(), "ellipsoid");
    assert_eq!(header.datum_of("gps_alt_m").name(), "msl");
    assert!(with("geoid").unwrap_err().contains("imu_master_alt_m: datum is 'geoid', expected \"msl\""));
    let of_none = MAPPING.replace("unit = \"hPa\"", "unit = \"hPa\", datum = \"msl\"");
    assert!(read(&log(), &of_none).unwrap_err().contains("baro_pa: datum is 'msl'"));
}

#[test]
fn damage_costs_its_line_and_is_said_with_its_place() {
    let mut lines: Vec<String> = log().lines().map(str::to_owned).collect();
    lines[50] = "2450,".to_owned();
    lines[100] = lines[100].replacen("4950,", "6000000000,", 1);
    lines[120] = lines[120].replacen("5950,", "x,", 1);
    let (flight, notes) = read(&lines.join("\n"), MAPPING).unwrap();
    assert_eq!(flight.rows(), 197);
    assert!(*flight.time_s.last().unwrap() < 10.0);
    let said = |words: &str| assert!(notes.iter().any(|note| note.contains(words)), "{words}: {notes:?}");
    said("the first is line 51");
    said(
        "time contradicts those around them, left out: 1 (0.51 %); the first is at line 101, with a time of 6000000.000 s",
    );
    said("rows without a time, or with one decades away, left out: 1 (0.50 %), the first is line 121");
}

#[test]
fn slow_logs_dates_and_times_of_day_are_read() {
    let rows = |time: fn(i32) -> String| {
        let rows = (0..20).map(|k| format!("{},{},{}\n", time(k), 100_000 - k, 100 + k)).collect::<String>();
        format!("when,p,h\n{rows}")
    };
    let mapping = |time: &str| {
        format!(
            "pylon-mapping = 1\n[time]\n{time}\n[signals]\nbaro_pa = {{ column = \"p\" }}\ngps_alt_m = {{ column = \"h\" }}\n"
        )
    };
    // One row a minute, past midnight.
    let clock = rows(|k| format!("{:02}:{:02}:00", (23 * 60 + 50 + k) / 60 % 24, (50 + k) % 60));
    let (flight, _) = read(&clock, &mapping("column = \"when\"")).unwrap();
    assert_eq!((flight.rows(), flight.time_s[19]), (20, 19.0 * 60.0));
    let date = rows(|k| format!("2024-05-01T12:00:{k:02}.5Z"));
    let (flight, _) = read(&date, &mapping("column = \"when\"")).unwrap();
    assert_eq!(flight.time_s[19], 19.0);
    assert!(flight.header.other.contains(&("start_utc".to_owned(), "2024-05-01T12:00:00Z".to_owned())));
    let (flight, _) = read(&date, &mapping("rate_hz = 4")).unwrap();
    assert_eq!(flight.time_s[19], 19.0 / 4.0);
    assert!(
        read(&date, &mapping("column = \"when\"\nunit = \"s\"")).unwrap_err().contains("expected no unit")
    );
}

#[test]
fn what_contradicts_is_refused_or_said_in_one_line() {
    let with = |from: &str, to: &str| MAPPING.replace(from, to);
    for (mapping, words) in [
        (with("\"P\"", "\"Q\""), "mapping: [signals] baro_pa: no column 'Q' in the table (is it 'P'?)"),
        (
            with("column = 5", "column = 9"),
            "mapping: [signals] longitude_deg: column 9 of 6, expected 1 to 6",
        ),
        (with("gps_alt_m", "height").replace(", unit = \"ft\"", ""), "mapping: [signals] has no gps_alt_m"),
        (
            with("baro_pa", "flap").replace(", unit = \"hPa\"", ""),
            "mapping: [signals]: no altitude besides gps_alt_m",
        ),
        (with("\nunit = \"ms\"", ""), "mapping: [time] has no unit for column 'Time'"),
        (with("\"Alt\"", "\"State\""), "log: no value of gps_alt_m"),
    ] {
        let error = read(&log(), &mapping).unwrap_err();
        assert!(error.contains(words), "{words}: {error}");
    }
    let (_, notes) = read(&log(), &with("unit = \"hPa\"", "unit = \"bar\"")).unwrap();
    assert!(notes.iter().any(|note| note.contains("is the unit of column 'P' right?")), "{notes:?}");
    let twice = log().replacen("State", "P", 1);
    let error = read(&twice, MAPPING).unwrap_err();
    assert!(
        error.contains("several columns are named 'P', expected the place of one of them, as column = 2"),
        "{error}"
    );
    assert!(read("\0\0\0\0", MAPPING).unwrap_err().contains("it is not text"));
    assert!(read("", MAPPING).unwrap_err().contains("an empty file"));
    // Zero latitude and longitude is what a receiver without a fix reports.
    let nowhere = log().replacen(",47,8.5,", ",0,0,", 4);
    let (flight, notes) = read(&nowhere, MAPPING).unwrap();
    assert!(notes.iter().any(|note| note.contains("latitude 0 and longitude 0")), "{notes:?}");
    assert_eq!(samples(&flight, Channel::GpsAltM).len(), 49);
}
