//! The page of `pylon report`: its content, and that it needs nothing else. A test in a browser checks that
//! it draws correctly (host-tests/tests/report_in_browser.rs).
#![allow(clippy::unwrap_used, clippy::panic, clippy::expect_used)]

mod common;

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use common::program::{compared, files, stdout};
use common::{MODEL, Recipe, dive_mps};
use pylon::flight;
use serde_json::Value;
use tempfile::TempDir;

/// A flight whose barometer lags by 1.5 s in a dive.
fn late_baro() -> Recipe {
    Recipe { baro_error: |_, climb_mps| -1.5 * climb_mps, climb_mps: dive_mps, ..Recipe::default() }
}

fn written(recipe: &Recipe) -> TempDir {
    let directory = tempfile::tempdir().unwrap();
    recipe.write(directory.path());
    fs::write(directory.path().join("model.toml"), MODEL).unwrap();
    directory
}

fn page(directory: &Path, arguments: &[&str]) -> String {
    let all = [&["report"], arguments, &["-o", "report.html"]].concat();
    let said = stdout(directory, &all);
    assert!(said.starts_with("report.html: "), "{said}");
    fs::read_to_string(directory.join("report.html")).unwrap()
}

/// The diagrams' data, by the name of their place on the page.
fn charts(page: &str) -> Value {
    let start = "<script id=\"chart-data\" type=\"application/json\">";
    let (_, rest) = page.split_once(start).unwrap();
    serde_json::from_str(rest.split_once("</script>").unwrap().0).unwrap()
}

fn numbers(values: &Value) -> Vec<f64> {
    values.as_array().unwrap().iter().filter_map(Value::as_f64).collect()
}

#[test]
fn every_diagram_has_a_place_and_every_place_a_diagram() {
    let directory = written(&late_baro());
    let page = page(directory.path(), &["made.csv", "--model", "model.toml"]);
    let charts = charts(&page);
    let drawn: BTreeSet<&str> = charts.as_object().unwrap().keys().map(String::as_str).collect();
    let places: BTreeSet<&str> =
        page.split("data-chart=\"").skip(1).map(|rest| rest.split('"').next().unwrap()).collect();
    assert_eq!(drawn, places);
    for id in [
        "flight-1-fig2-altitude",
        "flight-1-fig2-baro",
        "flight-1-fig3-gps",
        "flight-1-fig3-imu_slave",
        "flight-1-fig4-baro",
        "flight-1-altitude-baro",
        "flight-1-difference-imu_master",
        "flight-1-signal-baro-0",
    ] {
        assert!(drawn.contains(id), "{id} of {drawn:?}");
    }
    assert!(!drawn.contains("flight-1-fig4-imu_master"), "it does not fly free");
    for (id, chart) in charts.as_object().unwrap() {
        let places = numbers(&chart["x"]);
        assert!(places.is_sorted() && places.len() > 1, "{id}");
        let columns = chart["lines"].as_array().unwrap().iter().map(|line| &line["y"]);
        let bands = chart["bands"].as_array().unwrap().iter().flat_map(|band| [&band["from"], &band["to"]]);
        for column in columns.chain(bands) {
            assert_eq!(column.as_array().unwrap().len(), places.len(), "{id}");
            assert!(!numbers(column).is_empty(), "{id}: a curve without a point");
        }
    }
}

#[test]
fn the_diagrams_show_what_the_comparison_says() {
    let directory = written(&late_baro());
    fs::copy(directory.path().join("model.toml"), directory.path().join("m.toml")).unwrap();
    let page = page(directory.path(), &["made.csv", "--model", "m.toml"]);
    let compare = stdout(directory.path(), &["compare", "made.csv", "--model", "m.toml", "--json"]);
    let comparison: Value = serde_json::from_str(&compare).unwrap();
    let charts = charts(&page);
    let (baro, figure) = (&comparison["sensors"]["baro"], &charts["flight-1-fig4-baro"]);
    let doubtful_s = baro["doubtful_after_s"].as_f64().unwrap();
    assert!((figure["moments"][0]["x"].as_f64().unwrap() - doubtful_s).abs() < 1e-3);
    assert!((figure["levels"][0]["y"].as_f64().unwrap() - baro["bound_m"].as_f64().unwrap()).abs() < 1e-3);
    let average = numbers(&figure["lines"][0]["y"]);
    let end_m = baro["moving_average_end_m"].as_f64().unwrap();
    assert!((average.last().unwrap() - end_m).abs() < 0.1, "{:?} {end_m}", average.last());

    // 45 m of error in the dive, with noise of 0.6 m.
    let difference = &charts["flight-1-difference-baro"];
    let highest = numbers(&difference["bands"][0]["to"]).into_iter().fold(f64::NEG_INFINITY, f64::max);
    assert!((45.0..50.0).contains(&highest), "{highest}");
    let shade = &difference["shades"][0];
    let (from, to) = (shade["from"].as_f64().unwrap(), shade["to"].as_f64().unwrap());
    assert!(from >= 9.0 && to <= 26.0 && to > from, "{shade}");

    // The error is measured minus modelled.
    let altitude = &charts["flight-1-altitude-baro"];
    let line = |index: usize| numbers(&altitude["lines"][index]["y"]);
    let largest = line(0).iter().zip(line(1)).map(|(a, b)| a - b).fold(f64::NEG_INFINITY, f64::max);
    assert!((largest - highest).abs() < 1.0, "{largest} {highest}");

    // The climb rate explains more of the error than the airspeed, which is constant.
    let first = charts["flight-1-signal-baro-0"]["x_name"].as_str().unwrap();
    assert_eq!(first, "climb rate, m/s");
    assert!(page.contains("to tell: airspeed, airspeed squared / 2 g"), "airspeed is constant");
    assert!(page.contains("It became doubtful 10."), "the summary in words");
    assert!(page.contains("untrustworthy"));
}

/// A page may be shared: it contains the files' names, but nothing of their folders.
#[test]
fn a_page_has_no_path_of_its_author() {
    let directory = written(&late_baro());
    let at = |name: &str| directory.path().join(name).display().to_string();
    let revision = format!(
        "\n[[revision]]\nnumber = 1\ndate = 2026-11-20\neffect = \"baro.lag\"\nlearned_from = \"{}, {}\"\n",
        at("made.csv"),
        at("other.csv")
    );
    fs::write(at("model.toml"), format!("{MODEL}{revision}")).unwrap();
    // A reading that is left out, and said with its file.
    let text = fs::read_to_string(at("made.csv")).unwrap();
    fs::write(at("second.csv"), text + "0.5,,,,,,,,,\n").unwrap();
    let [made, second, model] = [at("made.csv"), at("second.csv"), at("model.toml")];
    let page = page(directory.path(), &[&made, "--hold-out", &second, "--model", &model]);
    let folder = directory.path().file_name().unwrap().to_str().unwrap();
    let around = page.find(folder).map(|at| &page[at.saturating_sub(200)..(at + 100).min(page.len())]);
    assert_eq!(around, None);
    for name in ["made.csv", "second.csv", "model.toml", "made.csv, other.csv"] {
        assert!(page.contains(name), "{name}");
    }
}

#[test]
fn a_page_asks_for_nothing_from_a_network() {
    let directory = written(&Recipe { free_s: 20.0, ..Recipe::default() });
    let page = page(directory.path(), &["made.csv"]);
    for forbidden in ["src=\"", "@import", "url(", "fetch(", "XMLHttpRequest", "<iframe", "<img"] {
        assert!(!page.contains(forbidden), "{forbidden}");
    }
    assert!(!page.contains("href=\"http"));
    assert!(page.contains("default-src 'none'"));
    assert!(page.contains("MIT License") && page.contains("Leon Sorokin"), "uPlot's licence goes with it");
}

#[test]
fn no_text_of_a_flight_becomes_markup() {
    let directory = tempfile::tempdir().unwrap();
    let mut made = Recipe { free_s: 20.0, ..Recipe::default() }.make();
    made.header.source = "</script><script>alert(1)</script>".to_owned();
    let mut flap = flight::Column::default();
    (0..made.rows()).for_each(|row| flap.push(Some(row as f32)));
    made.extra.push(("<b>flap</b>".to_owned(), flap));
    flight::write(&directory.path().join("a&b.csv"), &made).unwrap();
    let page = page(directory.path(), &["a&b.csv"]);
    assert!(!page.contains("<script>alert") && !page.contains("<b>flap"));
    assert!(page.contains("&lt;b&gt;flap") && page.contains("a&amp;b.csv"));
    let names: Vec<String> =
        charts(&page).as_object().unwrap().values().map(|chart| chart["x_name"].to_string()).collect();
    assert!(names.iter().any(|name| name.contains("<b>flap</b>")));
}

#[test]
fn flights_without_a_launch_and_short_ones_have_a_page() {
    let directory = written(&Recipe { free_s: 0.0, ..Recipe::default() });
    let captive = page(directory.path(), &["made.csv"]);
    assert!(captive.contains("Nothing was calibrated") && !captive.contains("Figure 4:"));
    assert!(captive.contains("of captive flight; the line"), "errors against signals, of captive flight");

    let short = Recipe { captive_s: 4.0, free_s: 0.0, ..Recipe::default() };
    let short = page(written(&short).path(), &["made.csv"]);
    assert!(!short.contains("NaN") && charts(&short).as_object().unwrap().is_empty());

    let one_row = tempfile::tempdir().unwrap();
    let text = "# pylon-flight: 1\ntime_s,launch,gps_alt_m,baro_pa\n0,0,100,100000\n";
    fs::write(one_row.path().join("made.csv"), text).unwrap();
    page(one_row.path(), &["made.csv"]);
}

#[test]
fn several_flights_share_a_page_and_a_model_shows_its_history() {
    let directory = written(&late_baro());
    fs::copy(directory.path().join("made.csv"), directory.path().join("second.csv")).unwrap();
    let revision = "\n[[revision]]\nnumber = 1\ndate = 2026-11-20\neffect = \"baro.lag\"\nlearned_from = \"made.csv\"\n\
                    rms_before_m = 21.5\nrms_after_m = 0.75\nheld_out_before_m = 20.25\nheld_out_after_m = 0.875\n";
    fs::write(directory.path().join("model.toml"), format!("{MODEL}{revision}")).unwrap();
    let page = page(directory.path(), &["made.csv", "second.csv", "--model", "model.toml"]);
    let charts = charts(&page);
    assert!(charts["flight-1-fig4-baro"]["group"] != charts["flight-2-fig4-baro"]["group"]);
    assert_eq!(charts["flight-1-fig4-baro"]["x"], charts["flight-2-fig4-baro"]["x"]);
    for text in
        ["2 flights: a report", "baro.lag", "before 21.50 m", "after 0.75 m", "before 20.25 m", "width: 3.5%"]
    {
        assert!(page.contains(text), "{text}");
    }
    // The ladder's numbers are those of `pylon ladder`, on the flight that was held out too.
    let third = Recipe { seed: 3, ..late_baro() }.make();
    flight::write(&directory.path().join("third.csv"), &third).unwrap();
    let model = fs::read_to_string(directory.path().join("model.toml")).unwrap();
    let lag = "\n[[effect]]\nid = \"baro.lag\"\ncoefficient = 1.5\n";
    fs::write(directory.path().join("model.toml"), format!("{model}{lag}")).unwrap();
    let flights = ["made.csv", "--model", "model.toml"];
    let page = self::page(directory.path(), &[&flights[..], &["--hold-out", "third.csv"]].concat());
    let said =
        stdout(directory.path(), &["ladder", "made.csv", "third.csv", "--model", "model.toml", "--json"]);
    let ladder: Value = serde_json::from_str(&said).unwrap();
    let charts = self::charts(&page);
    for flight in 0..2 {
        let chart = &charts[format!("ladder-{}", flight + 1)];
        let baro = chart["lines"].as_array().unwrap().iter().find(|line| line["name"] == "baro").unwrap();
        let drawn = numbers(&baro["y"]);
        assert_eq!(drawn.len(), 2);
        for (revision, drawn) in drawn.iter().enumerate() {
            let score = &ladder["revisions"][revision]["flights"][flight]["sensors"]["baro"];
            let rms_m = score["free_flight_rms_m"].as_f64().unwrap();
            assert!((drawn - rms_m).abs() < 1e-3, "{drawn} {rms_m}");
        }
        assert!(drawn[0] > 5.0 * drawn[1], "{drawn:?}");
    }
    assert!(page.contains("never doubtful") && page.contains("untrustworthy after"), "flags in words");
}

#[test]
fn a_page_is_as_large_as_a_screen_needs_and_not_as_the_flight() {
    let size = |captive_s: f64, free_s: f64| {
        let directory = written(&Recipe { captive_s, free_s, ..late_baro() });
        let page = page(directory.path(), &["made.csv"]);
        assert_eq!(compared(directory.path(), "made.csv")["launch_s"], captive_s);
        page.len()
    };
    let (long, longer) = (size(200.0, 600.0), size(200.0, 1_800.0));
    assert!((longer as f64) < 1.25 * long as f64, "{long} {longer}");
    assert!(longer < 4_000_000, "{longer}");
}

#[test]
fn a_refused_report_leaves_no_file() {
    let directory = written(&late_baro());
    fs::write(directory.path().join("cut.csv"), "# pylon-flight: 1\ntime_s,gps_alt_m,baro_pa\n0,1\n")
        .unwrap();
    let before = files(directory.path());
    for arguments in [
        &["report", "made.csv", "cut.csv", "--strict", "-o", "report.html"][..],
        &["report", "absent.csv", "-o", "report.html"],
        &["report", "made.csv", "--calibrate", "900..950", "-o", "report.html"],
        &["report", "made.csv", "--model", "absent.toml", "-o", "report.html"],
        &["report", "made.csv", "--hold-out", "made.csv", "-o", "report.html"],
        &["report", "made.csv", "-o", "no/such/report.html"],
        &["report", "made.csv"],
    ] {
        common::program::refusal(directory.path(), arguments);
        assert_eq!(files(directory.path()), before, "{arguments:?}");
    }
}

#[test]
fn the_page_says_what_a_diagnosis_says() {
    let directory = written(&late_baro());
    let second = Recipe { seed: 2, ..late_baro() }.make();
    flight::write(&directory.path().join("second.csv"), &second).unwrap();
    let arguments = ["made.csv", "--hold-out", "second.csv", "--model", "model.toml"];
    let page = page(directory.path(), &arguments);
    let said = stdout(directory.path(), &[&["diagnose"], &arguments[..], &["--json"]].concat());
    let diagnosis: Value = serde_json::from_str(&said).unwrap();
    let baro = &diagnosis["sensors"]["baro"];
    assert!(page.contains(&format!("finding {}", baro["verdict"].as_str().unwrap())));
    let advice = baro["advice"].as_str().unwrap();
    assert!(
        !advice.is_empty() && page.contains(&advice.replace('&', "&amp;").replace('<', "&lt;")),
        "{advice}"
    );
    for candidate in baro["candidates"].as_array().unwrap() {
        let id = candidate["effect"].as_str().unwrap();
        assert!(page.contains(&format!("<th scope=\"row\">{id}")), "{id}");
    }
    let named = [&baro["missing"], &baro["indistinguishable"]].map(ToString::to_string).concat();
    assert!(named.contains("baro.lag"), "1.5 s of lag are found, or a set that holds it: {named}");
    assert!(page.contains("Held-out errors are those on second.csv."));
}
