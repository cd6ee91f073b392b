//! Real IGC logs, if present; see SOURCES.md beside them. Each test reports a missing log.
#![allow(clippy::unwrap_used, clippy::panic)]

use std::path::{Path, PathBuf};

use model::Model;
use pylon::flight::{Channel, Flight, to_writer};
use pylon::import::import_file;
use pylon::replay::{CalibrationSource, CalibrationWindow, Replay, ReplaySummary};

/// The log, and its notes as one text.
fn import(name: &str) -> Option<(Flight, String)> {
    let path: PathBuf =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/flights/real/igc").join(name);
    if !path.exists() {
        println!("skipped: {name}");
        return None;
    }
    let (flight, notes) = import_file(&path).unwrap();
    let mut written = Vec::new();
    to_writer(&mut written, &flight).unwrap();
    if flight.require_altitudes().is_ok() {
        let (read, _) = pylon::flight::parse(&written).unwrap();
        let mut again = Vec::new();
        to_writer(&mut again, &read).unwrap();
        assert!(again == written, "{name} does not read back as it was written");
    }
    let notes: Vec<_> = notes.iter().map(|note| note.text().to_owned()).collect();
    Some((flight, notes.join("\n")))
}

fn samples(flight: &Flight, channel: Channel) -> Vec<f32> {
    flight.channel(channel).map_or_else(Vec::new, |column| column.samples().map(|(_, value)| value).collect())
}

fn median(mut values: Vec<f32>) -> f32 {
    values.sort_by(f32::total_cmp);
    values[values.len() / 2]
}

fn replay(flight: &Flight, window: Option<CalibrationWindow>) -> (CalibrationSource, ReplaySummary) {
    let replay = Replay::new(flight, &Model::default(), window).unwrap();
    (*replay.source(), replay.run(&mut |_, _| {}).unwrap())
}

/// Every row reached the estimator, and every reading was accepted.
fn all_was_taken(flight: &Flight, summary: &ReplaySummary) {
    let ticks = usize::try_from(summary.counters.ticks + summary.counters.out_of_order).unwrap();
    assert_eq!(ticks + summary.inputs.skipped_rows + summary.inputs.rows_after, flight.rows());
    assert_eq!((summary.held_fixes(), summary.not_finite_samples()), (0, 0));
    assert_eq!(summary.inputs.counters, pylon::replay::InputCounters::default());
}

#[test]
fn new_zealand_units_are_told_from_the_data() {
    let Some((flight, notes)) = import("igclib_new_zealand.igc") else { return };
    assert_eq!(flight.rows(), 5367);
    assert!(notes.contains("TAS is taken as hundredths of km/h"), "{notes}");
    assert!(notes.contains("GSP is taken as hundredths of km/h"), "{notes}");
    assert!(notes.contains("OAT is taken as tenths of degrees C"), "{notes}");
    assert!(notes.contains("VAT is taken as hundredths of m/s"), "{notes}");
    assert_eq!(samples(&flight, Channel::TasMps).len(), 5367);
    // The log's own numbers: TAS 617 to 23846, median 11989, hundredths of km/h; OAT 7 to 19 degrees.
    assert!((median(samples(&flight, Channel::TasMps)) - 119.89 / 3.6).abs() < 1e-4);
    let temperatures = samples(&flight, Channel::OatC);
    assert!(temperatures.iter().all(|value| (7.0..=19.0).contains(value)));
    // It starts on the runway half a minute before the take-off, and never flies level: the calmest stretch
    // is used, and reported.
    let (source, _) = replay(&flight, None);
    assert!(matches!(source, CalibrationSource::Calmest(_)), "{source}");
    assert!(source.to_string().contains("none is quiet"), "{source}");
    assert!(source.to_string().contains("--calibrate START..END"), "{source}");
    let (_, summary) = replay(&flight, Some("600..900".parse().unwrap()));
    all_was_taken(&flight, &summary);
}

/// The log crosses midnight UTC.
#[test]
fn new_zealand_time_increases_over_midnight() {
    let Some((flight, _)) = import("igclib_new_zealand.igc") else { return };
    assert!(flight.time_s.windows(2).all(|pair| pair[0] < pair[1]));
    assert!(flight.header.other.contains(&("start_utc".into(), "2009-11-06T23:48:08Z".into())));
}

#[test]
fn fixes_without_altitude_keep_their_pressure() {
    let Some((flight, notes)) = import("goigc_optlong.igc") else { return };
    assert_eq!(flight.rows(), 6171);
    assert_eq!(samples(&flight, Channel::GpsAltM).len(), 6141);
    assert_eq!(samples(&flight, Channel::BaroAltM).len(), 6171);
    assert!(notes.contains("give no GPS sample: 30"), "{notes}");
    let (source, summary) = replay(&flight, None);
    // It begins on the ground.
    let CalibrationSource::Quiet(stretch) = source else { panic!("{source}") };
    assert_eq!(stretch.window.start_s, 0.0);
    assert!(stretch.speed_mps.unwrap() < 1.0);
    all_was_taken(&flight, &summary);
}

/// SOURCES.md: a height scale of about -4.3 %, by regression of pressure minus GNSS altitude on height.
#[test]
fn the_height_scale_of_the_long_flight_is_the_known_one() {
    let Some((flight, _)) = import("goigc_optlong.igc") else { return };
    let (gps, baro) = (flight.channel(Channel::GpsAltM).unwrap(), flight.channel(Channel::BaroAltM).unwrap());
    let pairs: Vec<(f64, f64)> = gps
        .samples()
        .filter_map(|(row, gps)| Some((f64::from(gps), f64::from(baro.get(row)?) - f64::from(gps))))
        .collect();
    let count = pairs.len() as f64;
    let mean_height = pairs.iter().map(|(height, _)| height).sum::<f64>() / count;
    let mean_error = pairs.iter().map(|(_, error)| error).sum::<f64>() / count;
    let product: f64 =
        pairs.iter().map(|(height, error)| (height - mean_height) * (error - mean_error)).sum();
    let square: f64 = pairs.iter().map(|(height, _)| (height - mean_height).powi(2)).sum();
    let slope = product / square;
    assert!((-0.055..=-0.035).contains(&slope), "{slope}");
}

#[test]
fn negative_pressure_altitudes_are_read() {
    let Some((flight, _)) = import("aerofiles_skytraxx21-2023-04-15.igc") else { return };
    assert_eq!(flight.rows(), 2008);
    let lowest = samples(&flight, Channel::BaroAltM).into_iter().fold(f32::INFINITY, f32::min);
    assert!((-60.0..=-50.0).contains(&lowest), "{lowest}");
    all_was_taken(&flight, &replay(&flight, None).1);
}

#[test]
fn a_phone_without_barometer_has_nothing_to_calibrate() {
    let Some((flight, notes)) = import("aerofiles_xctrack-2023-04-28.igc") else { return };
    assert_eq!(flight.rows(), 979);
    assert!(notes.contains("no barometer: every pressure altitude is zero"), "{notes}");
    assert!(flight.channel(Channel::BaroAltM).is_none());
    // HFALG:GEO.
    assert_eq!(flight.header.altitude_datum, pylon::flight::AltitudeDatum::Msl);
    let error = Replay::new(&flight, &Model::default(), None).unwrap_err().to_string();
    assert!(error.starts_with("no altitude besides gps_alt_m"), "{error}");
}

#[test]
fn a_repeated_second_is_counted() {
    let Some((flight, notes)) = import("igclib_flight_with_middle_landing.igc") else { return };
    assert_eq!(flight.rows(), 14_819);
    assert!(
        notes.contains("repeat the time of the one before: 1, that are earlier than one before them: 0"),
        "{notes}"
    );
    let (_, summary) = replay(&flight, Some("0..60".parse().unwrap()));
    assert_eq!(summary.ignored_rows(), 1);
    all_was_taken(&flight, &summary);
}

#[test]
fn a_short_log_is_read() {
    let Some((flight, _)) = import("goigc_short1.igc") else { return };
    assert_eq!(flight.rows(), 640);
    // SIU counts satellites: from single digits up to a dozen.
    assert!(samples(&flight, Channel::GpsSats).iter().all(|count| (0.0..=12.0).contains(count)));
    all_was_taken(&flight, &replay(&flight, None).1);
}
