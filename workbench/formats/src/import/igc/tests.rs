use std::fmt::Write as _;

use executor::Inline;
use proptest::prelude::*;

use super::*;
use crate::import;
use crate::import::airspeed::true_airspeed_factor;
use flight_data::{AltitudeDatum, Channel, parse, to_writer};

fn import(log: &str) -> (Flight, Vec<String>) {
    let (flight, notes) = Igc.import(log.as_bytes()).unwrap();
    (flight, notes.iter().map(|note| note.text().to_owned()).collect())
}

fn cells(flight: &Flight, channel: Channel) -> Vec<Option<f32>> {
    let column = flight.channel(channel).unwrap();
    (0..column.len()).map(|row| column.get(row)).collect()
}

fn signal(flight: &Flight, name: &str) -> Vec<Option<f32>> {
    let column = &flight.extra.iter().find(|(found, _)| found == name).unwrap().1;
    (0..column.len()).map(|row| column.get(row)).collect()
}

fn has_note(notes: &[String], part: &str) -> bool {
    notes.iter().any(|note| note.contains(part))
}

/// A fix a second, each 100 m further north; altitudes as given (pressure, GNSS, validity).
fn log(head: &str, fixes: &[(i32, i32, char)]) -> String {
    let mut text = head.to_owned();
    for (index, (pressure, gnss, validity)) in fixes.iter().enumerate() {
        let thousandths = index * 54;
        let _ = writeln!(text, "B1000{index:02}45{thousandths:05}N00700000E{validity}{pressure:05}{gnss:05}");
    }
    text
}

#[test]
fn altitudes_datum_and_header() {
    let head =
        "AXYZ123\nHFDTE010203\nHFPLTPILOT:Somebody\nHFGTYGLIDERTYPE:LS 6\nHFALG:GEO\nHFALPALTPRESSURE:MSL\n";
    let (flight, notes) = import(&log(head, &[(500, 560, 'A'), (501, 0, 'V'), (-2, 562, 'A')]));
    assert_eq!(flight.time_s, [0.0, 1.0, 2.0]);
    assert_eq!(cells(&flight, Channel::GpsAltM), [Some(560.0), None, Some(562.0)]);
    assert_eq!(cells(&flight, Channel::GpsTimeS), [Some(0.0), None, Some(2.0)]);
    assert_eq!(cells(&flight, Channel::BaroAltM), [Some(500.0), Some(501.0), Some(-2.0)]);
    assert_eq!(flight.header.altitude_datum, AltitudeDatum::Msl);
    assert_eq!(flight.header.vehicle, "LS 6");
    assert_eq!(flight.header.other[1], ("start_utc".to_owned(), "2003-02-01T10:00:00Z".to_owned()));
    assert!(has_note(&notes, "not 3D (validity V) and give no GPS sample: 1"));
    assert!(has_note(&notes, "ALP header says 'MSL', not ISA"));
    assert!(!has_note(&notes, "ALG"));
    // The pilot's name is private and not imported.
    assert!(!format!("{:?}", flight.header).contains("Somebody"));
}

#[test]
fn without_a_datum_header_the_ellipsoid_is_assumed_and_said() {
    let (flight, notes) = import(&log("", &[(500, 560, 'A'); 3]));
    assert_eq!(flight.header.altitude_datum, AltitudeDatum::Ellipsoid);
    assert!(has_note(&notes, "ALG header is missing: GPS altitude is taken as above the ellipsoid"));
    assert!(has_note(&import(&log("HFALGALTGPS:NKN\n", &[(500, 560, 'A')])).1, "ALG header says 'NKN'"));
}

#[test]
fn logs_without_a_barometer_have_no_baro_column() {
    for (pressure, reason) in [(0, "every pressure altitude is zero"), (560, "is the GPS altitude, copied")] {
        let (flight, notes) = import(&log("", &[(pressure, 560, 'A'); 3]));
        assert!(flight.channel(Channel::BaroAltM).is_none());
        assert!(has_note(&notes, reason), "{notes:?}");
        assert!(flight.require_altitudes().is_err());
    }
    let (flight, notes) = import(&log("", &[(500, 560, 'A'), (0, 561, 'A'), (502, 562, 'A')]));
    assert_eq!(cells(&flight, Channel::BaroAltM), [Some(500.0), None, Some(502.0)]);
    assert!(has_note(&notes, "zero amid others, left out as missing values: 1"));
}

#[test]
fn gps_altitudes_of_zero_amid_others_are_no_fix() {
    let (flight, notes) = import(&log("", &[(500, 560, 'A'), (501, 0, 'A'), (502, 562, 'A')]));
    assert_eq!(cells(&flight, Channel::GpsAltM), [Some(560.0), None, Some(562.0)]);
    assert_eq!(cells(&flight, Channel::GpsTimeS)[1], None);
    assert_eq!(cells(&flight, Channel::GpsVnMps)[1], None);
    assert!(has_note(&notes, "GPS altitudes of zero amid others, left out as missing values: 1"));
}

#[test]
fn velocities_come_from_valid_positions() {
    // 54 thousandths of a minute of latitude at 45 degrees are 100.02 m.
    let (flight, notes) =
        import(&log("", &[(500, 560, 'A'), (500, 0, 'V'), (500, 561, 'A'), (500, 562, 'A')]));
    for velocity in [0, 2, 3].map(|row| cells(&flight, Channel::GpsVnMps)[row].unwrap()) {
        assert!((velocity - 100.02).abs() < 0.02, "{velocity}");
    }
    assert_eq!(cells(&flight, Channel::GpsVnMps)[1], None);
    assert_eq!(cells(&flight, Channel::GpsVeMps)[3], Some(0.0));
    assert!(flight.channel(Channel::GpsVdMps).is_none());
    assert!(has_note(&notes, "derived from positions"));
    assert_eq!(signal(&flight, "latitude_deg")[0], Some(45.0));
    // 45 degrees and 0.108 minutes: a digit that f32 cannot represent.
    let (_, latitudes) = flight.extra.iter().find(|(name, _)| name == "latitude_deg").unwrap();
    assert!(latitudes.samples_f64().any(|(_, degrees)| (degrees - 45.001_8).abs() < 1e-12));
}

#[test]
fn a_log_of_which_nothing_is_left_is_an_error() {
    let message = |text: &str| import::import(text.as_bytes()).unwrap_err().to_string();
    assert_eq!(
        message(&log("", &[(500, 0, 'V'), (500, 560, 'V')])),
        "IGC log without a usable fix (2 fixes without altitude, 0 unreadable lines), expected at least one"
    );
    assert!(message("HFDTE010203\nB100\nB1000\n").contains("(0 fixes without altitude, 2 unreadable lines)"));
    let unknown = message("a,b,c\n1,2,3\n");
    assert!(unknown.starts_with("not a log of a known format, expected one of: "), "{unknown}");
    for importer in import::IMPORTERS {
        assert!(unknown.contains(importer.name()), "{unknown}");
    }
    assert!(message("").starts_with("an empty file"));
}

#[test]
fn repeated_and_lost_records_are_noted() {
    let mut text = log("I013638FXA\n", &[(500, 560, 'A'); 3]);
    text += "B1000024500162N00700000EA0050000560\nB10000\nK1x\n?\nB0959594500162N00700000EA0050000560\n";
    let notes = import(&text).1;
    assert!(has_note(
        &notes,
        "repeat the time of the one before: 1, that are earlier than one before them: 0"
    ));
    assert!(has_note(&notes, "could not be read and were left out: 3, the first is line 6"));
    assert!(has_note(&notes, "blank or not numbers: 4"));
    assert!(has_note(&notes, "before the first fix's, left out: 1"));
}

/// One wrong digit moves a record by hours; the records after it keep their place. Hours that really passed
/// are reported.
#[test]
fn a_wrong_hour_costs_its_record_and_hours_without_any_are_said() {
    let text = log("HFALG:ELL\n", &[(500, 560, 'A'); 50]);
    for wrong in ["B150020", "B230020", "B050020"] {
        let (flight, notes) = import(&text.replace("B100020", wrong));
        assert_eq!((flight.rows(), flight.time_s[48]), (49, 49.0), "{wrong}");
        let time = format!("{}:00:20 after 10:00:19", &wrong[1..3]);
        let words = "records whose time contradicts those around them, left out: 1 (2.0 %); the first is line 22, with ";
        assert!(has_note(&notes, &format!("{words}{time}")), "{notes:?}");
    }
    let later = text.replace("B1000", "B1500").replace("HFALG:ELL\n", "");
    let (flight, notes) = import::import((text + &later).as_bytes()).unwrap();
    assert_eq!(flight.rows(), 100);
    let words = "nothing was recorded for 17951 s (99 % of the log), from 49 s to 18000 s";
    assert!(notes.iter().any(|note| note.text() == words), "{notes:?}");
}

/// A simulated glider: it circles at 28 m/s true airspeed in a wind of 8 m/s from the west and climbs from
/// 500 m to 1700 m of pressure altitude in 10 minutes. `extension` writes the additional numbers from
/// true airspeed (m/s), ground speed (m/s), climb rate (m/s) and pressure altitude (m).
fn glider(additions: &str, extension: impl Fn(f64, f64, f64, f64) -> String) -> String {
    let mut text = format!("HFDTE010203\nHFALG:ELL\n{additions}\n");
    let (mut north_m, mut east_m, mut altitude_m) = (0.0_f64, 0.0_f64, 500.0_f64);
    for second in 0..600_i32 {
        let time = f64::from(second);
        let (speed, heading) = (28.0 + 3.0 * (0.05 * time).sin(), 0.25 * time);
        let (vn, ve) = (speed * heading.cos(), speed * heading.sin() + 8.0);
        let climb = 2.0 + 1.5 * (0.1 * time).sin();
        let thousandths =
            |metres: f64, metre_a_degree: f64| (metres / metre_a_degree * 60_000.0).round() as i64;
        let latitude = thousandths(north_m, 111_132.0) + 2_700_000;
        let longitude = thousandths(east_m, 78_847.0) + 420_000;
        let _ = writeln!(
            text,
            "B10{:02}{:02}{:02}{:05}N{:03}{:05}EA{:05.0}{:05.0}{}",
            second / 60,
            second % 60,
            latitude / 60_000,
            latitude % 60_000,
            longitude / 60_000,
            longitude % 60_000,
            altitude_m,
            altitude_m + 55.0,
            extension(speed, vn.hypot(ve), climb, altitude_m)
        );
        (north_m, east_m, altitude_m) = (north_m + vn, east_m + ve, altitude_m + climb);
    }
    text
}

fn largest_error(found: &[Option<f32>], expected: impl Fn(f64) -> f64) -> f64 {
    let error =
        |(second, cell): (usize, &Option<f32>)| (f64::from(cell.unwrap()) - expected(second as f64)).abs();
    found.iter().enumerate().map(error).fold(0.0, f64::max)
}

#[test]
fn airspeeds_of_every_maker_come_out_the_same() {
    let true_mps = |second: f64| 28.0 + 3.0 * (0.05 * second).sin();
    for (unit, scale) in
        [("km/h", 3.6), ("tenths of km/h", 36.0), ("hundredths of km/h", 360.0), ("kt", 1.943_844)]
    {
        let text = glider("I013640TAS", |speed, _, _, _| format!("{:05.0}", speed * scale));
        let (flight, notes) = import(&text);
        assert!(has_note(&notes, &format!("tas_mps: TAS is taken as {unit}: ")), "{notes:?}");
        // Rounding of half a unit.
        assert!(largest_error(&cells(&flight, Channel::TasMps), true_mps) <= 0.51 / scale);
    }
}

#[test]
fn indicated_airspeed_becomes_true_airspeed_by_density() {
    let text = glider("I023638IAS3941OAT", |speed, _, _, altitude| {
        let temperature = 25.0 - 0.007 * altitude;
        format!("{:03.0}{temperature:03.0}", 3.6 * speed / true_airspeed_factor(altitude, temperature))
    });
    let (flight, notes) = import(&text);
    assert!(has_note(
        &notes,
        "tas_mps: computed from IAS, taken as km/h, by pressure altitude and the logged temperature"
    ));
    assert!(has_note(&notes, "oat_c: OAT is taken as degrees C: "));
    // Rounding of half a km/h, half a degree of temperature and half a metre of altitude.
    let error = largest_error(&cells(&flight, Channel::TasMps), |second| 28.0 + 3.0 * (0.05 * second).sin());
    assert!(error < 0.14 * 1.1 + 0.05, "{error}");
    assert!(signal(&flight, "indicated_airspeed_mps")[0].unwrap() < 28.0);
}

#[test]
fn other_additional_numbers_become_signals() {
    let text = glider("I073638VXA3940SIU4145GSP4649VAT5052HDT5355ENL5657ABC", |_, ground, climb, _| {
        format!("00709{:05.0}{:04.0}27001242", ground * 360.0, climb * 10.0)
    });
    let (flight, notes) = import(&text);
    assert_eq!(cells(&flight, Channel::GpsVaccM)[3], Some(7.0));
    assert_eq!(cells(&flight, Channel::GpsSats)[3], Some(9.0));
    assert_eq!(signal(&flight, "heading_true_deg")[0], Some(270.0));
    assert_eq!(signal(&flight, "engine_noise")[0], Some(12.0));
    assert_eq!(signal(&flight, "igc_abc")[0], Some(42.0));
    assert!(has_note(&notes, "ground_speed_mps: GSP is taken as hundredths of km/h"), "{notes:?}");
    assert!(has_note(&notes, "vario_total_energy_mps: VAT is taken as tenths of m/s"), "{notes:?}");
    let climb = signal(&flight, "vario_total_energy_mps")[0].unwrap();
    assert!((climb - 2.0).abs() < 1e-6);
}

#[test]
fn a_unit_that_can_not_be_told_leaves_plain_numbers() {
    let text = glider("I023638TAS3941OAT", |_, _, climb, _| {
        let nothing_to_do_with_speed = if climb > 2.0 { 999 } else { 20 };
        format!("{nothing_to_do_with_speed:03}999")
    });
    let (flight, notes) = import(&text);
    assert!(flight.channel(Channel::TasMps).is_none() && flight.channel(Channel::OatC).is_none());
    assert_eq!(signal(&flight, "igc_oat")[0], Some(999.0));
    assert!(signal(&flight, "igc_tas").contains(&Some(20.0)));
    assert!(has_note(&notes, "no oat_c: the unit of OAT is unknown"), "{notes:?}");
    let level = log("I013638TAS\n", &[(500, 560, 'A'); 60]).replace("EA0050000560", "EA0050000560123");
    let (flight, notes) = import(&level);
    assert_eq!(signal(&flight, "igc_tas")[0], Some(123.0));
    assert!(has_note(&notes, "no tas_mps: the unit of TAS is unknown"), "{notes:?}");
}

#[test]
fn is_recognised_by_content_and_opened_as_a_flight() {
    let text = log("", &[(500, 560, 'A'), (501, 561, 'A')]);
    let opened = |bytes: &[u8]| import::open(bytes, "log.txt", &Inline);
    assert_eq!(opened(text.as_bytes()).unwrap().0.rows(), 2);
    let csv = b"# pylon-flight: 1\ntime_s,gps_alt_m,baro_alt_m\n0,1,2\n";
    assert_eq!(opened(csv).unwrap().0.rows(), 1);
    assert!(import::is_known(csv) && import::is_known(text.as_bytes()) && !import::is_known(b"neither"));
    // A binary file is not reported as a flight without its first line.
    for binary in [&b"\x7fELF\x02\x01\x01\0\0\0"[..], &[0xfe; 5_000]] {
        assert!(
            opened(binary)
                .unwrap_err()
                .to_string()
                .starts_with("not a log of a known format, expected one of: ")
        );
    }
    assert!(opened(b"neither").unwrap_err().to_string().contains("no '# pylon-flight: 1' line"));
}

/// A flight imported from a log can be written, and reads back the same.
fn round_trip(flight: &Flight) {
    let mut written = Vec::new();
    to_writer(&mut written, flight).unwrap();
    if flight.require_altitudes().is_ok() {
        let (read, notes) = parse(&written).unwrap();
        assert_eq!(notes, []);
        let mut again = Vec::new();
        to_writer(&mut again, &read).unwrap();
        assert_eq!(again, written);
    }
}

#[test]
fn an_imported_flight_is_a_flight() {
    round_trip(&import(&glider("I013640TAS", |speed, _, _, _| format!("{:05.0}", speed * 360.0))).0);
}

proptest! {
    #[test]
    fn arbitrary_bytes_never_panic(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        let _ = import::import(&bytes);
        let _ = Igc.import(&bytes);
    }

    /// Lines that are nearly right: digits, letters and lengths that almost match the records.
    #[test]
    fn damaged_logs_never_panic_and_stay_flights(
        lines in prop::collection::vec(
            prop_oneof![
                "B[0-2][0-9][0-5][0-9][0-5][0-9][0-9]{7}[NS][0-9]{8}[EW][AV][-0-9][0-9]{4}[-0-9][0-9]{4}[-0-9 ]{0,20}",
                "[IJ][0-9]{2}([0-9]{4,6}(TAS|IAS|OAT|LAD|LOD|TDS|GSP|VAR|SIU|VXA|[A-Z]{3})){0,4}",
                "K[0-2][0-9][0-5][0-9][0-5][0-9][-0-9]{0,30}",
                "H[FOP](DTE|ALG|ALP|GTY|GPS)[ -~]{0,20}",
                "[ -~]{0,40}",
            ],
            0..40,
        ),
        damage in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..4),
    ) {
        let mut text = lines.join("\n").into_bytes();
        for (index, byte) in damage {
            if !text.is_empty() {
                let place = index.index(text.len());
                text[place] = byte;
            }
        }
        if let Ok((flight, _)) = Igc.import(&text) {
            round_trip(&flight);
        }
    }
}
