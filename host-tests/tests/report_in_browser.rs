//! The page of `pylon report` in a browser: it draws, zooms and responds to the mouse and the keyboard, light
//! and dark, and its scripts report no errors. Pictures of it are left in `target/report-in-browser/` for
//! inspection.
#![allow(clippy::unwrap_used, clippy::panic)]

mod browser;

use std::fs;
use std::path::{Path, PathBuf};

use browser::{Mouse, Sheet};
use model::Model;
use pylon::compare::{Options, compare};
use pylon::diagnose::{NamedReplay, diagnose};
use pylon::learn::{NamedFlight, ladder};
use pylon::replay::Replay;
use pylon::report::{FlightReport, Report, TRACE_SLOTS};
use pylon::simulate::{Scenario, simulate};
use serde_json::{Value, json};
use tempfile::TempDir;

const SCENARIO: &str = include_str!("../../flights/quickstart.toml");
/// The diagram that is operated, and another one of its group.
const FIGURE: &str = "document.querySelector('[data-chart=\"flight-1-fig4-baro\"]')";
const SIBLING: &str = "document.querySelector('[data-chart=\"flight-1-fig4-imu_slave\"]')";

/// Two revisions; the first learned too little of the effect that the scenario hides.
const IMPROVED: &str = r#"
[[effect]]
id = "baro.dynamic_pressure"
coefficient = 0.06
[[revision]]
number = 1
effect = "baro.dynamic_pressure"
coefficient = 0.02
[[revision]]
number = 2
effect = "baro.dynamic_pressure"
coefficient = 0.06
replaced_coefficient = 0.02
"#;
/// A legend's text for the moving average, once there is a value.
const AVERAGE: &str = "/moving average-?[0-9]/";
const LADDER: &str = "document.querySelector('[data-chart=\"ladder-1\"]')";

/// The report of a simulated flight, in a folder of its own.
fn report() -> (TempDir, PathBuf) {
    let scenario = Scenario::from_toml(SCENARIO, "quickstart.toml").unwrap();
    let (flight, _) = simulate(&scenario, scenario.seed).unwrap();
    let model = Model::default();
    let replay = Replay::new(&flight, &model, None).unwrap();
    let options = Options { trace_slots: Some(TRACE_SLOTS), ..Options::default() };
    let (mut comparison, traces) = compare(&replay, &options, &mut |_| ()).unwrap();
    comparison.flight.file = "quickstart.csv".into();
    let flights = [FlightReport::new(0, &replay, comparison, &traces.unwrap())];
    let named = NamedReplay::new("quickstart.csv".into(), replay);
    let diagnosis = diagnose(&[named], &[], &mut || ());
    // The model as `pylon add` would have made it: with the effect that the scenario hides.
    let improved = Model::parse(IMPROVED).unwrap();
    let mut ladder = ladder(&improved, &[NamedFlight::new("quickstart.csv", &flight)], &mut |_| ()).unwrap();
    ladder.model = "improved.toml".into();
    let report = Report {
        flights: &flights,
        model: &improved,
        model_name: "improved.toml",
        diagnosis: &diagnosis,
        ladder: &ladder,
        batch: None,
    };
    let html = report.html();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("report.html");
    fs::write(&file, html).unwrap();
    (folder, file)
}

/// Scrolls a diagram into the window and waits until it is drawn.
fn show(sheet: &Sheet, place: &str) {
    sheet.run(&format!("{place}.scrollIntoView({{ block: 'center', behavior: 'instant' }})"));
    sheet.wait(&format!("{place}.plot && {place}.plot.status === 1"));
}

/// The point in the window at a share of a diagram's width.
fn point(sheet: &Sheet, place: &str, share: f64) -> (f64, f64) {
    let rect = sheet.value(&format!("{place}.plot.over.getBoundingClientRect()"));
    let side = |name: &str| rect[name].as_f64().unwrap();
    (side("left") + share * side("width"), side("top") + 0.5 * side("height"))
}

fn span(sheet: &Sheet, place: &str) -> (f64, f64) {
    (sheet.number(&format!("{place}.plot.scales.x.min")), sheet.number(&format!("{place}.plot.scales.x.max")))
}

fn read_out(sheet: &Sheet, place: &str) -> String {
    let text = sheet.value(&format!("{place}.querySelector('.u-legend').textContent"));
    text.as_str().unwrap().to_owned()
}

/// Number of pixels inside a diagram that are not background, and number of colours.
fn drawn(sheet: &Sheet, place: &str) -> (u64, u64) {
    let counted = sheet.value(&format!(
        "(() => {{
            const {{ ctx, bbox }} = {place}.plot;
            const {{ data }} = ctx.getImageData(bbox.left, bbox.top, bbox.width, bbox.height);
            const colours = new Set();
            let inked = 0;
            for (let at = 0; at < data.length; at += 4) {{
                if (data[at + 3] > 0) {{
                    inked += 1;
                    colours.add((data[at] << 16) | (data[at + 1] << 8) | data[at + 2]);
                }}
            }}
            return [inked, colours.size];
        }})()"
    ));
    (counted[0].as_u64().unwrap(), counted[1].as_u64().unwrap())
}

fn keep_picture(sheet: &Sheet, name: &str) {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("../report-in-browser");
    fs::create_dir_all(&folder).unwrap();
    fs::write(folder.join(name), sheet.picture()).unwrap();
}

#[test]
fn every_diagram_is_drawn_and_nothing_complains() {
    let (_folder, file) = report();
    let sheet = Sheet::open(&file, 1366, 768);
    assert!(
        sheet.value("pylonCharts.drawn.size").as_u64().unwrap() < 10,
        "only what is in view is drawn at first"
    );
    sheet.run("document.querySelectorAll('details').forEach((details) => { details.open = true; })");
    let places = sheet.number("document.querySelectorAll('[data-chart]').length") as usize;
    assert!(places > 30, "{places}");
    for index in 0..places {
        let place = format!("document.querySelectorAll('[data-chart]')[{index}]");
        show(&sheet, &place);
        let (inked, colours) = drawn(&sheet, &place);
        // The grid alone is one colour.
        assert!(inked > 1_500 && colours > 3, "diagram {index}: {inked} pixels in {colours} colours");
    }
    assert_eq!(sheet.number("pylonCharts.drawn.size") as usize, places);
    // Lengths are to scale: the error without and with the effect that the scenario hides.
    let row = "document.querySelector('.candidates .chosen')";
    assert!(
        sheet.value(&format!("{row}.textContent")).as_str().unwrap().starts_with("baro.dynamic_pressure")
    );
    let length = |kind: &str| {
        sheet.number(&format!("{row}.querySelector('.bar.{kind} .length').getBoundingClientRect().width"))
    };
    let error = |kind: &str| {
        sheet.number(&format!(
            "parseFloat({row}.querySelector('.bar.{kind} .value').textContent.match(/[\\d.]+/)[0])"
        ))
    };
    let (lengths, errors) = (length("after") / length("before"), error("after") / error("before"));
    assert!((lengths - errors).abs() < 0.02 && errors < 0.6, "{lengths} {errors}");
    for width in [1_024, 1_366, 1_920] {
        sheet.resize(width, 768);
        sheet.wait(&format!("innerWidth === {width}"));
        sheet.wait("document.documentElement.scrollWidth <= innerWidth");
        sheet.wait(&format!("{FIGURE}.plot.width === {FIGURE}.clientWidth"));
    }
    assert_eq!(*sheet.complaints.lock().unwrap(), Vec::<String>::new());
    // The page's scripts would have reported what its security policy forbids; here, the page does not even
    // try.
    assert_eq!(sheet.value("performance.getEntriesByType('resource').map((entry) => entry.name)"), json!([]));
}

#[test]
fn the_ladder_shows_every_revision_and_its_flags() {
    let (_folder, file) = report();
    let sheet = Sheet::open(&file, 1366, 768);
    show(&sheet, LADDER);
    let (inked, colours) = drawn(&sheet, LADDER);
    assert!(inked > 1_500 && colours > 3, "{inked} pixels in {colours} colours");
    // Three named places, and the barometer's error decreases from each to the next.
    let names = sheet.value(&format!("{LADDER}.plot.axes[0]._values"));
    assert_eq!(names, json!(["at first", "1: baro.dynamic_pressure", "2: baro.dynamic_pressure"]));
    let label = |at: usize| format!("{LADDER}.plot.series[{at}].label");
    let baro = (1..3).find(|at| sheet.value(&label(*at)) == json!("baro")).unwrap();
    let rms_m = |revision: usize| sheet.number(&format!("{LADDER}.plot.data[{baro}][{}]", revision + 1));
    assert!(rms_m(0) > rms_m(1) && rms_m(1) > rms_m(2), "{} {} {}", rms_m(0), rms_m(1), rms_m(2));
    // The table agrees, with its bars to scale, and a strip is as long as the flight.
    let row = |revision: usize| {
        let rows = "[...document.querySelectorAll('.revisions tbody tr')]";
        format!("{rows}.filter((row) => row.cells[1].textContent === 'baro')[{revision}]")
    };
    let bar = |revision: usize| {
        sheet.number(&format!("{}.querySelector('.length').getBoundingClientRect().width", row(revision)))
    };
    assert!((bar(2) / bar(0) - rms_m(2) / rms_m(0)).abs() < 0.02, "{} {}", bar(2), bar(0));
    for revision in 0..3 {
        let strip = format!("{}.querySelector('.strip')", row(revision));
        let parts = sheet.number(&format!(
            "[...{strip}.children].reduce((sum, part) => sum + part.getBoundingClientRect().width, 0)"
        ));
        let whole = sheet.number(&format!("{strip}.clientWidth"));
        assert!((parts - whole).abs() < 1.5, "{parts} {whole}");
    }
    // Hovering over a revision names it.
    let (first, last) = span(&sheet, LADDER);
    sheet.mouse(Mouse::Move, point(&sheet, LADDER, (2.0 - first) / (last - first)), 0);
    sheet.wait(&format!(
        "{LADDER}.querySelector('.u-legend').textContent.includes('2: baro.dynamic_pressure')"
    ));
    keep_picture(&sheet, "ladder.png");
    sheet.prefer("dark");
    sheet.wait("getComputedStyle(document.body).backgroundColor === 'rgb(20, 24, 29)'");
    keep_picture(&sheet, "ladder-dark.png");
    assert_eq!(*sheet.complaints.lock().unwrap(), Vec::<String>::new());
}

#[test]
fn the_mouse_reads_values_and_zooms_a_group() {
    let (_folder, file) = report();
    let sheet = Sheet::open(&file, 1366, 900);
    show(&sheet, SIBLING);
    show(&sheet, FIGURE);
    let (first, last) = span(&sheet, FIGURE);
    assert!(first >= 0.0 && last > 100.0, "{first} {last}");
    // Where nothing is read off there is no value, and no dash in its place.
    assert!(!read_out(&sheet, FIGURE).contains('–'), "{}", read_out(&sheet, FIGURE));
    assert!(
        !sheet
            .value(&format!("{AVERAGE}.test({FIGURE}.querySelector('.u-legend').textContent)"))
            .as_bool()
            .unwrap()
    );

    // Hovering shows the values there, also in the diagrams of the group, and a line through them.
    sheet.mouse(Mouse::Move, point(&sheet, FIGURE, 0.25), 0);
    sheet.wait(&format!("{AVERAGE}.test({FIGURE}.querySelector('.u-legend').textContent)"));
    sheet.wait(&format!("{AVERAGE}.test({SIBLING}.querySelector('.u-legend').textContent)"));
    let time_s = sheet.number(&format!("{FIGURE}.plot.data[0][{FIGURE}.plot.cursor.idx]"));
    assert!((time_s - (first + 0.25 * (last - first))).abs() < 0.5, "{time_s}");
    assert!(
        sheet.number(&format!("{FIGURE}.querySelector('.u-cursor-x').getBoundingClientRect().height")) > 50.0
    );
    keep_picture(&sheet, "hover.png");

    // Dragging from 40 % to 60 %.
    sheet.mouse(Mouse::Press, point(&sheet, FIGURE, 0.4), 1);
    sheet.mouse(Mouse::Move, point(&sheet, FIGURE, 0.5), 1);
    sheet.mouse(Mouse::Move, point(&sheet, FIGURE, 0.6), 1);
    sheet.mouse(Mouse::Release, point(&sheet, FIGURE, 0.6), 1);
    sheet.wait(&format!("{FIGURE}.classList.contains('zoomed') && {SIBLING}.classList.contains('zoomed')"));
    for place in [FIGURE, SIBLING] {
        let (from, to) = span(&sheet, place);
        let share = |x: f64| (x - first) / (last - first);
        assert!((share(from) - 0.4).abs() < 0.01 && (share(to) - 0.6).abs() < 0.01, "{from} {to}");
    }
    let (inked, colours) = drawn(&sheet, FIGURE);
    assert!(inked > 1_500 && colours > 3, "{inked} {colours}");

    // A double click shows everything again.
    for clicks in [1, 2] {
        sheet.mouse(Mouse::Press, point(&sheet, FIGURE, 0.5), clicks);
        sheet.mouse(Mouse::Release, point(&sheet, FIGURE, 0.5), clicks);
    }
    sheet.wait(&format!("!{FIGURE}.classList.contains('zoomed') && !{SIBLING}.classList.contains('zoomed')"));
    assert_eq!(span(&sheet, FIGURE), (first, last));
    assert_eq!(*sheet.complaints.lock().unwrap(), Vec::<String>::new());
}

#[test]
fn the_keyboard_does_what_the_mouse_does() {
    let (_folder, file) = report();
    let sheet = Sheet::open(&file, 1366, 900);
    show(&sheet, FIGURE);
    let (first, last) = span(&sheet, FIGURE);
    sheet.run(&format!("{FIGURE}.focus()"));
    sheet.key("ArrowRight");
    sheet.wait(&format!("{FIGURE}.plot.cursor.idx != null"));
    let middle = sheet.number(&format!("{FIGURE}.plot.cursor.idx"));
    sheet.key("ArrowLeft");
    sheet.wait(&format!("{FIGURE}.plot.cursor.idx < {middle}"));
    sheet.key("+");
    sheet.wait(&format!("{FIGURE}.classList.contains('zoomed')"));
    let (from, to) = span(&sheet, FIGURE);
    assert!(((to - from) / (last - first) - 0.5).abs() < 0.01, "{from} {to}");
    sheet.key("-");
    sheet.wait(&format!("!{FIGURE}.classList.contains('zoomed')"));
    sheet.key("+");
    sheet.wait(&format!("{FIGURE}.classList.contains('zoomed')"));
    sheet.key("Escape");
    sheet.wait(&format!("!{FIGURE}.classList.contains('zoomed')"));
    // Tab reaches every diagram and every control.
    let reachable =
        sheet.value("[...document.querySelectorAll('[data-chart]')].every((place) => place.tabIndex === 0)");
    assert_eq!(reachable, Value::Bool(true));
    assert_eq!(*sheet.complaints.lock().unwrap(), Vec::<String>::new());
}

#[test]
fn colours_follow_the_system_and_the_button() {
    let (_folder, file) = report();
    let sheet = Sheet::open(&file, 1366, 900);
    let ground = "getComputedStyle(document.body).backgroundColor";
    let ink = format!("{FIGURE}.plot.axes[0].stroke()");
    let (light, dark) = (json!("rgb(255, 255, 255)"), json!("rgb(20, 24, 29)"));
    sheet.prefer("light");
    sheet.wait(&format!("{ground} === {light}"));
    keep_picture(&sheet, "light-summary.png");
    show(&sheet, FIGURE);
    keep_picture(&sheet, "light.png");
    let inks_light = sheet.value(&ink);

    sheet.prefer("dark");
    sheet.wait(&format!("{ground} === {dark}"));
    sheet.wait(&format!("{ink} !== {inks_light}"));
    keep_picture(&sheet, "dark.png");

    // The button overrules the system: auto, light, dark.
    let press = "document.getElementById('theme').click()";
    sheet.run(press);
    sheet.wait(&format!("{ground} === {light}"));
    assert_eq!(sheet.value(&ink), inks_light);
    sheet.run(press);
    sheet.wait(&format!("{ground} === {dark}"));
    assert!(sheet.value("document.getElementById('theme').ariaLabel").as_str().unwrap().contains("dark"));
    sheet.run("scrollTo({ top: 0, behavior: 'instant' })");
    keep_picture(&sheet, "dark-summary.png");
    assert_eq!(*sheet.complaints.lock().unwrap(), Vec::<String>::new());
}
