//! Every kind of bad input on the command line: a clear one-line refusal, or a named degraded state.
#![allow(clippy::unwrap_used, clippy::panic, clippy::expect_used)]

mod common;

use std::fs;
use std::path::Path;

use common::Recipe;
use common::program::{compared, files, refusal, run, stdout};
use serde_json::{Value, json};
use tempfile::TempDir;

/// A generated flight of 60 s captive and 10 s free, with modified cells.
fn flight_with(change: impl Fn(&mut Vec<Vec<String>>)) -> TempDir {
    made(&Recipe { captive_s: 60.0, free_s: 10.0, ..Recipe::default() }, change)
}

fn made(recipe: &Recipe, change: impl Fn(&mut Vec<Vec<String>>)) -> TempDir {
    let directory = tempfile::tempdir().unwrap();
    let file = recipe.write(directory.path());
    let text = fs::read_to_string(&file).unwrap();
    let (head, rows): (Vec<&str>, Vec<&str>) = text.lines().partition(|line| line.starts_with('#'));
    let mut rows: Vec<Vec<String>> =
        rows.iter().map(|row| row.split(',').map(str::to_owned).collect()).collect();
    change(&mut rows);
    let mut changed = head.join("\n") + "\n";
    for row in rows {
        changed += &(row.join(",") + "\n");
    }
    fs::write(file, changed).unwrap();
    directory
}

/// Index of a column.
fn column(rows: &[Vec<String>], name: &str) -> usize {
    rows[0].iter().position(|column| column == name).unwrap()
}

/// Rows (with the names in row 0) from one time to another.
fn between(from_s: f64, to_s: f64) -> std::ops::Range<usize> {
    1 + (from_s * common::ROWS_PER_S) as usize..1 + (to_s * common::ROWS_PER_S) as usize
}

fn failed(comparison: &Value, check: &str) -> bool {
    comparison["calibration"]["failed_checks"].as_array().unwrap().contains(&json!(check))
}

fn warned(comparison: &Value, text: &str) -> bool {
    comparison["warnings"].as_array().unwrap().iter().any(|line| line.as_str().unwrap().contains(text))
}

fn comparison(directory: &TempDir) -> Value {
    compared(directory.path(), "made.csv")
}

#[test]
fn the_unchanged_flight_is_good_and_has_no_warning() {
    let comparison = comparison(&flight_with(|_| {}));
    assert_eq!(
        comparison["calibration"],
        json!({
            "quality": "good",
            "failed_checks": [],
            "duration_s": 50.0,
            "source": "captive flight until the launch column is 1",
        })
    );
    assert_eq!(comparison["warnings"], json!([]));
}

#[test]
fn nan_and_infinite_cells_are_refused_counted_and_said() {
    for bad in ["nan", "inf", "-inf"] {
        let comparison = comparison(&flight_with(|rows| {
            let baro = column(rows, "baro_alt_m");
            for row in between(30.0, 30.2) {
                rows[row][baro] = bad.to_owned();
            }
            let gps = column(rows, "gps_alt_m");
            rows[between(40.0, 41.0).start][gps] = bad.to_owned();
        }));
        assert_eq!(comparison["sensors"]["baro"]["readings"]["not_finite"], 10);
        assert_eq!(comparison["reference"]["fixes"]["not_finite"], 1);
        assert!(failed(&comparison, "inputs_valid"));
        assert!(
            warned(&comparison, "10 baro readings refused") && warned(&comparison, "1 gps reading refused")
        );
        let bias = comparison["sensors"]["baro"]["bias_m"].as_f64().unwrap();
        assert!((bias - 20.0).abs() < 1.0, "{bias}");
    }
}

#[test]
fn repeated_and_backward_times_are_ignored_and_counted() {
    let comparison = comparison(&flight_with(|rows| {
        let repeated = rows[501].clone();
        rows.insert(501, repeated);
        for row in &mut rows[1_000..1_005] {
            "3.5".clone_into(&mut row[0]);
        }
    }));
    assert!(warned(&comparison, "6 rows were ignored"), "{}", comparison["warnings"]);
    assert!(failed(&comparison, "inputs_valid"));
    assert_eq!(comparison["launch_s"], 60.0);
}

#[test]
fn a_sensor_that_sticks_is_said_so() {
    let comparison = comparison(&flight_with(|rows| {
        let baro = column(rows, "baro_alt_m");
        for row in between(35.0, 70.0) {
            rows[row][baro] = "2020.25".to_owned();
        }
    }));
    let stuck = comparison["sensors"]["baro"]["readings"]["stuck"].as_u64().unwrap();
    // All but the two seconds that detection takes.
    assert!((1_600..1_750).contains(&stuck), "{stuck}");
    assert!(failed(&comparison, "sensors_alive") && warned(&comparison, "bit-identical readings"));
    assert!(warned(&comparison, "baro was not monitored"), "{}", comparison["warnings"]);
}

#[test]
fn a_gps_that_freezes_is_no_reference() {
    let freeze = |from_s: f64, to_s: f64| {
        comparison(&flight_with(|rows| {
            let columns: Vec<usize> = ["gps_alt_m", "gps_vn_mps", "gps_ve_mps", "gps_vd_mps"]
                .into_iter()
                .map(|name| column(rows, name))
                .collect();
            let range = between(from_s, to_s);
            let held = rows[range.start].clone();
            for row in range.step_by(common::ROWS_PER_FIX) {
                for &column in &columns {
                    rows[row][column].clone_from(&held[column]);
                }
            }
        }))
    };
    let captive = freeze(30.0, 45.0);
    assert_eq!(captive["reference"]["fixes"]["held"], 74);
    assert!(failed(&captive, "reference_fresh") && warned(&captive, "74 gps readings ignored"));
    let free = freeze(61.0, 70.0);
    assert!(warned(&free, "not monitored"), "{}", free["warnings"]);
    assert_eq!(free["sensors"]["baro"]["trust"], "unmonitored");
    assert!(free["sensors"]["baro"]["unmonitored_s"].as_f64().unwrap() > 3.0);
}

#[test]
fn missing_columns_are_named() {
    let without = |names: &[&str]| {
        let directory = flight_with(|rows| {
            for name in names {
                let gone = column(rows, name);
                rows.iter_mut().for_each(|row| {
                    row.remove(gone);
                });
            }
        });
        refusal(directory.path(), &["compare", "made.csv"])
    };
    assert!(without(&["gps_alt_m"]).contains("made.csv: row 5: no column gps_alt_m; expected it"));
    let none = without(&["baro_alt_m", "imu_master_alt_m", "imu_slave_alt_m"]);
    assert!(
        none.contains(
            "made.csv: no altitude besides gps_alt_m: no barometer, and so nothing to calibrate; expected"
        ),
        "{none}"
    );
    assert!(without(&["time_s"]).contains("no column time_s"));
}

#[test]
fn a_row_cut_in_its_middle_is_refused_with_its_place() {
    let directory = flight_with(|rows| rows[777].truncate(4));
    let line = refusal(directory.path(), &["compare", "made.csv"]);
    assert!(line.contains("made.csv: row 782: 4 cells, expected 10; the row is cut after column"), "{line}");
    // A file with a missing end: its last row is incomplete.
    let file = directory.path().join("made.csv");
    let directory_of_whole = flight_with(|_| {});
    let whole = fs::read_to_string(directory_of_whole.path().join("made.csv")).unwrap();
    fs::write(&file, &whole[..whole.trim_end().rfind(',').unwrap() - 2]).unwrap();
    let line = refusal(directory.path(), &["compare", "made.csv"]);
    assert!(line.contains("the row is cut after column"), "{line}");
    let directory = flight_with(|rows| rows[300][2] = "20x1".to_owned());
    let line = refusal(directory.path(), &["compare", "made.csv"]);
    assert!(line.contains("row 305, column gps_alt_m: '20x1', expected a number"), "{line}");
}

#[test]
fn files_that_are_no_flight_are_refused() {
    let directory = tempfile::tempdir().unwrap();
    let refused = |name: &str, content: &[u8]| {
        fs::write(directory.path().join(name), content).unwrap();
        refusal(directory.path(), &["compare", name])
    };
    assert!(refused("empty.csv", b"").contains("empty.csv: the file is empty; expected a flight"));
    assert!(refused("text.csv", b"time_s,gps_alt_m\n0,1\n").contains("no '# pylon-flight: 1' line"));
    assert!(refused("noise.bin", &[0xff, 0, 0x9c, 10, 0x80]).contains("noise.bin: "));
    assert!(
        refused("units.csv", b"# pylon-flight: 1\ntime_s,gps_alt_m,baro_hpa\n0,1,2\n")
            .contains("row 2, column baro_hpa: looks like baro_pa, but its unit is not that column's")
    );
    let feet = refused("feet.csv", b"# pylon-flight: 1\ntime_s,gps_alt_ft,baro_pa\n0,1,2\n");
    assert!(feet.contains("gps_alt_ft") && feet.contains("gps_alt_m"), "{feet}");
    assert!(
        refused("version.csv", b"# pylon-flight: 2\n").contains("version '2'; this program reads version 1")
    );
    assert!(refusal(directory.path(), &["compare", "absent.csv"]).contains("absent.csv: cannot be read"));
    assert!(refusal(directory.path(), &["compare", "."]).contains("cannot be read"));
}

#[test]
fn a_launch_before_the_calibration_ended_latches_degraded() {
    let launched_at =
        |captive_s: f64| comparison(&made(&Recipe { captive_s, free_s: 20.0, ..Recipe::default() }, |_| {}));
    let unsettled = launched_at(5.0);
    assert_eq!(unsettled["calibration"]["quality"], "degraded");
    assert!(failed(&unsettled, "settled"));
    let short = launched_at(15.0);
    assert!(!failed(&short, "settled") && failed(&short, "long_enough"));
    assert_eq!(short["launch_s"], 15.0);
}

#[test]
fn of_two_launches_the_first_counts() {
    let comparison = comparison(&flight_with(|rows| {
        let launch = column(rows, "launch");
        for row in between(63.0, 65.0) {
            rows[row][launch] = "0".to_owned();
        }
    }));
    assert_eq!(comparison["launch_s"], 60.0);
    assert!(warned(&comparison, "2 changes of the launch discrete after launch were ignored"));
}

#[test]
fn without_a_launch_nothing_is_latched_and_that_is_said() {
    let comparison = comparison(&made(&Recipe { free_s: 0.0, ..Recipe::default() }, |_| {}));
    assert_eq!(comparison["launch_s"], Value::Null);
    assert_eq!(comparison["calibration"]["quality"], Value::Null);
    assert_eq!(comparison["sensors"]["baro"]["free_flight_rms_m"], Value::Null);
    assert_eq!(comparison["remedies"], json!([]));
    assert!(warned(&comparison, "no launch: the whole flight is captive"));
}

#[test]
fn a_flight_shorter_than_settling_has_no_bias_and_that_is_said() {
    let directory = made(&Recipe { captive_s: 4.0, free_s: 0.0, ..Recipe::default() }, |_| {});
    let comparison = comparison(&directory);
    assert_eq!(comparison["sensors"]["baro"]["bias_m"], Value::Null);
    assert_eq!(comparison["calibration"]["quality"], Value::Null);
    assert!(warned(&comparison, "shorter than the settling time"), "{}", comparison["warnings"]);
    let text = stdout(directory.path(), &["compare", "made.csv"]);
    assert!(!text.contains("NaN"), "{text}");
}

#[test]
fn a_flight_of_one_row_is_compared_without_a_number() {
    let directory = tempfile::tempdir().unwrap();
    let text = "# pylon-flight: 1\ntime_s,launch,gps_alt_m,baro_pa\n0,0,100,100000\n";
    fs::write(directory.path().join("made.csv"), text).unwrap();
    assert_eq!(comparison(&directory)["sensors"]["baro"]["bias_m"], Value::Null);
}

#[test]
fn calibration_windows_must_fit() {
    let directory = flight_with(|_| {});
    let refused = |window: &str| refusal(directory.path(), &["compare", "made.csv", "--calibrate", window]);
    assert!(refused("20").contains("expected START..END in seconds"));
    assert!(refused("30..20").contains("expected START below END"));
    assert!(
        refused("100..200")
            .contains("made.csv: calibration window 100..200 s does not lie within the flight")
    );
    let window = stdout(directory.path(), &["compare", "made.csv", "--json", "--calibrate", "5..50"]);
    let comparison: Value = serde_json::from_str(&window).unwrap();
    assert_eq!(comparison["launch_s"], 50.0);
    assert!(warned(&comparison, "250 rows before the calibration window were not used"));
}

#[test]
fn take_off_and_landing_must_fit() {
    let directory = flight_with(|_| {});
    let refused =
        |airborne: &str| refusal(directory.path(), &["diagnose", "made.csv", "--airborne", airborne]);
    assert!(refused("20").contains("expected FROM..TO in seconds"));
    assert!(refused("30..20").contains("expected FROM below TO"));
    assert!(refused("10..60").contains("made.csv: time in the air 10..60 s: this flight's launch column"));
}

#[test]
fn models_and_scenarios_that_make_no_sense_are_refused() {
    let directory = flight_with(|_| {});
    let path = directory.path();
    fs::write(path.join("typo.toml"), "[monitor]\nmultiplyer = 3\n").unwrap();
    fs::write(path.join("wrong.toml"), "[sensor.baro]\nsigma_m = -1\n").unwrap();
    let model = |name: &str| refusal(path, &["compare", "made.csv", "--model", name]);
    assert!(model("typo.toml").contains("typo.toml") && model("typo.toml").contains("multiplyer"));
    assert!(model("wrong.toml").contains("wrong.toml") && model("wrong.toml").contains("sigma_m"));
    assert!(model("absent.toml").contains("absent.toml"));
    fs::write(path.join("scenario.toml"), "name = 3\n").unwrap();
    let line = refusal(path, &["simulate", "scenario.toml", "-o", "out.csv"]);
    assert!(line.contains("scenario.toml"), "{line}");
    assert!(!files(path).iter().any(|name| name.starts_with("out")));
}

#[test]
fn effects_that_can_not_be_or_say_nothing_are_told() {
    let directory = flight_with(|_| {});
    let path = directory.path();
    let model = |text: &str| fs::write(path.join("m.toml"), text).unwrap();
    let arguments = ["compare", "made.csv", "--json", "--model", "m.toml"];
    model("[[effect]]\nid = \"baro.dynamic_presure\"\ncoefficient = 1\n");
    let line = refusal(path, &arguments);
    assert!(line.contains("m.toml") && line.contains("nearest: baro.dynamic_pressure"), "{line}");
    model("[[revision]]\nnumber = 3\n[[revision]]\nnumber = 3\n");
    assert!(refusal(path, &arguments).contains("revision 3 in row 4 clashes with the one in row 2"));
    // Values that are possible but do not occur in nature, and a column that the flight lacks.
    model(
        "[[effect]]\nid = \"baro.lag\"\ncoefficient = 7\n[[effect]]\nid = \"baro.propwash\"\ncoefficient = 1\n",
    );
    let output = run(path, &arguments);
    assert!(output.status.success());
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert!(stderr.contains(
        "warning: m.toml: coefficient of effect baro.lag is 7 s, outside of its physical range 0 to 5 s"
    ));
    let comparison: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(warned(
        &comparison,
        "effect baro.propwash of the model was not applied: the flight lacks throttle"
    ));
    assert!(!warned(&comparison, "effect baro.lag"));
}

/// Failed runs leave the directory, and the file that was to be replaced, unchanged.
#[test]
fn no_refused_command_leaves_anything_behind() {
    let directory = flight_with(|rows| rows[777].truncate(4));
    let path: &Path = directory.path();
    fs::write(path.join("old.csv"), "old").unwrap();
    fs::write(path.join("broken.igc"), "AXXX\nHFDTE010199\nB12").unwrap();
    let before = files(path);
    for arguments in [
        &["compare", "made.csv", "--plots", "pictures"][..],
        &["export", "made.csv", "--format", "csv", "-o", "old.csv"],
        &["export", "made.csv", "--format", "mcap", "-o", "new.mcap"],
        &["export", "made.csv", "--format", "csv", "-o", "no/such/new.csv"],
        &["import", "broken.igc", "-o", "new.csv"],
        &["import", "made.csv", "-o", "new.csv"],
        &["simulate", "absent.toml", "-o", "new.csv"],
        &["fly", "made.csv"],
        &["compare"],
        &["compare", "absent.csv", "--plots", "pictures"],
        &["compare", "made.csv", "--calibrate", "9..3", "--plots", "pictures"],
    ] {
        refusal(path, arguments);
        assert_eq!(files(path), before, "{arguments:?}");
        assert_eq!(fs::read_to_string(path.join("old.csv")).unwrap(), "old", "{arguments:?}");
    }
}

#[test]
fn an_open_quote_a_leaping_clock_utf_16_and_a_folder_that_is_not_are_said_as_such() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path();
    let flight = |rows: &str| format!("# pylon-flight: 1\n{rows}");
    fs::write(path.join("quote.csv"), flight("time_s,gps_alt_m,\"baro_alt_m\n0,1,2\n1,2,3\n")).unwrap();
    let said = refusal(path, &["compare", "quote.csv"]);
    assert!(said.starts_with("error: quote.csv: row 2: quote never closed"), "{said}");

    let utf_16: Vec<u8> = flight("time_s\n").encode_utf16().flat_map(u16::to_le_bytes).collect();
    fs::write(path.join("wide.csv"), [&[0xff, 0xfe][..], &utf_16].concat()).unwrap();
    for command in [&["compare", "wide.csv"][..], &["open", "wide.csv"]] {
        let said = refusal(path, command);
        assert!(said.contains("wide.csv: text in UTF-16, expected UTF-8"), "{said}");
    }

    let rows: String = (0..600)
        .map(|row| {
            let time_s = if row < 400 { row } else { 6_000_000 + row };
            format!("{time_s},{},{}\n", 100 + row % 7, 101 + row % 5)
        })
        .collect();
    fs::write(path.join("leap.csv"), flight(&format!("time_s,gps_alt_m,baro_alt_m\n{rows}"))).unwrap();
    let output = run(path, &["open", "leap.csv"]);
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(
        text.contains(
            "row 401 leaps to 6000400 s; rows more than a day away from the flight, left out: 200 of 600"
        ),
        "{text}"
    );
    assert!(text.contains("in 400 rows, from 0 s to 399 s"), "{text}");

    let said = refusal(path, &["export", "leap.csv", "--format", "parquet", "-o", "none/x.parquet"]);
    assert!(said.ends_with("none/x.parquet: cannot be written: folder none does not exist\n"), "{said}");
}

/// A copy of the receiver's altitude looks like a perfect barometer.
#[test]
fn a_barometer_that_is_a_copy_of_the_receiver_is_said_before_everything_else() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path();
    // An IGC file whose recorder put the receiver's altitude, 47 m lower, into the pressure field.
    let fixes: String = (0..1_200)
        .map(|second| {
            let up = (second % 700).min(700 - second % 700);
            let (minute, second) = (second / 60, second % 60);
            format!("B10{minute:02}{second:02}4647{:03}N00812000EA{:05}{:05}\n", up, 900 + up - 47, 900 + up)
        })
        .collect();
    fs::write(path.join("copy.igc"), format!("AXXXABC\nHFDTE010124\n{fixes}")).unwrap();
    let words = "no barometer: its column is a copy of the receiver's altitude, -47 m";
    let text = stdout(path, &["open", "copy.igc"]);
    assert!(text.lines().nth(1).unwrap().contains(words), "{text}");
    assert!(!text.contains("used  ") && !text.contains("pylon diagnose"), "{text}");
    for command in
        [&["compare", "copy.igc"][..], &["diagnose", "copy.igc"], &["report", "copy.igc", "-o", "page.html"]]
    {
        let said = refusal(path, command);
        assert!(said.starts_with(&format!("error: copy.igc: {words}")), "{said}");
    }
    assert_eq!(files(path), ["copy.igc"]);
}

/// Logs whose format is recognised, but which contain nothing to compare with.
#[test]
fn logs_of_computers_without_a_receivers_altitude_are_named() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path();
    let mut cats = b"3.0.1\0".to_vec();
    for k in 0..100_u32 {
        cats.extend(
            [(k * 10).to_le_bytes(), 0x20_u32.to_le_bytes(), 95_000_u32.to_le_bytes(), [0; 4]].concat(),
        );
    }
    fs::write(path.join("flight.cfl"), cats).unwrap();
    let names = "Year,Month,Day,Time,Flight_Time_(s),Temperature_(F),Baro_Press_(atm)";
    let rows: String = (0..50).map(|k| format!("2024,5,1,10:00:00,{k},70,0.95\n")).collect();
    fs::write(path.join("raven.csv"), format!("{names}\n{rows}")).unwrap();
    for (file, what) in [("flight.cfl", "CATS flight computer"), ("raven.csv", "Featherweight Blue Raven")] {
        for command in [&["open", file][..], &["import", file, "-o", "flight.csv"]] {
            let said = refusal(path, command);
            assert!(said.contains(what) && said.contains("nothing to compare its barometer with"), "{said}");
        }
    }
    assert_eq!(files(path), ["flight.cfl", "raven.csv"]);
}

/// A MATLAB file of either version is refused with advice on what to do instead.
#[test]
fn a_matlab_file_is_named_for_what_it_is() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path();
    for version in ["5.0", "7.3"] {
        let header = format!("{:<124}", format!("MATLAB {version} MAT-file, Platform: GLNXA64"));
        fs::write(path.join("log.mat"), [header.as_bytes(), b"\x00\x01IM", &[0xe3; 300]].concat()).unwrap();
        for command in
            [&["open", "log.mat"][..], &["import", "log.mat", "-o", "flight.csv"], &["compare", "log.mat"]]
        {
            let said = refusal(path, command);
            assert!(said.contains("log.mat: a MATLAB file (.mat)") && said.contains("writetable"), "{said}");
        }
    }
    assert_eq!(files(path), ["log.mat"]);
}

/// Never `baro.scale = -1`, which fits a barometer that does not move.
#[test]
fn a_barometer_that_is_stuck_is_said_and_nothing_is_diagnosed_by_it() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path();
    let rows: String = (0..3_000)
        .map(|row| {
            let up = f64::from(row % 600).min(f64::from(600 - row % 600));
            format!(
                "{},{:.1},500.0,{:.1}\n",
                f64::from(row) * 0.5,
                500.0 + up,
                3.0 + 500.0 + up + f64::from(row % 7) / 5.0
            )
        })
        .collect();
    let head = "# pylon-flight: 1\ntime_s,gps_alt_m,baro_alt_m";
    let without: String = rows.lines().map(|row| row.rsplit_once(',').unwrap().0.to_owned() + "\n").collect();
    fs::write(path.join("stuck.csv"), format!("{head}\n{without}")).unwrap();
    for command in ["compare", "diagnose"] {
        let said = refusal(path, &[command, "stuck.csv"]);
        assert!(
            said.contains("stuck.csv: the barometer is stuck: it repeats one value for the whole flight"),
            "{said}"
        );
    }
    // Another altitude sensor is diagnosed without the barometer.
    fs::write(path.join("other.csv"), format!("{head},imu_slave_alt_m\n{rows}")).unwrap();
    let text = stdout(path, &["diagnose", "other.csv"]);
    assert!(text.contains("imu_slave") && !text.contains("baro.scale"), "{text}");
}
