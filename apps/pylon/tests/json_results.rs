//! Every command that prints JSON: the output validates against the published schema, and the type reads it
//! back unchanged.
#![allow(clippy::unwrap_used, clippy::panic, clippy::expect_used)]

mod common;

use std::fs;
use std::path::{Path, PathBuf};

use common::Recipe;
use common::json::checked;
use common::program::stdout;
use pylon::results::{
    Addition, Comparison, DiagnoseResult, Discovery, EffectsResult, ExportResult, ImportResult, Ladder,
    Overview, PlanResult, ReportResult, SimulateResult, schemas,
};

const WRITE: &str = "PYLON_WRITE_SCHEMAS";

fn published(command: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/schemas").join(format!("{command}.json"))
}

#[test]
fn the_published_schemas_are_those_of_the_types() {
    for (command, schema) in schemas() {
        let text = serde_json::to_string_pretty(&schema).unwrap() + "\n";
        let file = published(command);
        if std::env::var_os(WRITE).is_some() {
            fs::write(&file, &text).unwrap();
        }
        let found = fs::read_to_string(&file).unwrap_or_default();
        assert!(found == text, "docs/schemas/{command}.json is stale; `cargo xtask schemas` writes it");
    }
}

#[test]
fn every_command_with_json_has_a_schema() {
    let directory = tempfile::tempdir().unwrap();
    let help = stdout(directory.path(), &["--help"]);
    let commands = help.lines().skip_while(|line| !line.starts_with("Commands:")).skip(1);
    let with_json: Vec<String> = commands
        .take_while(|line| !line.is_empty())
        .filter_map(|line| line.strip_prefix("  ")?.split(' ').next().filter(|name| !name.is_empty()))
        .filter(|name| *name != "help" && stdout(directory.path(), &[name, "--help"]).contains("--json"))
        .map(str::to_owned)
        .collect();
    let mut with_schema: Vec<&str> = schemas().into_iter().map(|(command, _)| command).collect();
    with_schema.sort_unstable();
    let mut sorted = with_json.clone();
    sorted.sort_unstable();
    assert_eq!(sorted, with_schema);
}

/// All commands but `fly`, which needs QEMU; its own tests check its JSON.
#[test]
fn what_a_command_prints_is_what_its_schema_says() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    Recipe { captive_s: 40.0, free_s: 60.0, ..Recipe::default() }.write(here);
    fs::copy(here.join("made.csv"), here.join("other.csv")).unwrap();
    fs::write(here.join("ours.toml"), "").unwrap();

    let opened: Overview = checked("open", here, &["made.csv"]);
    assert_eq!((opened.version, opened.launch_s), (Overview::VERSION, Some(40.0)));
    let compared: Comparison = checked("compare", here, &["made.csv"]);
    assert_eq!(compared.launch_s, Some(40.0));
    let one: DiagnoseResult = checked("diagnose", here, &["made.csv"]);
    assert!(one.together.is_some() && one.one_by_one.is_none());
    let several: DiagnoseResult = checked("diagnose", here, &["made.csv", "other.csv"]);
    assert_eq!(several.one_by_one.unwrap().by_flight.len(), 2);
    let planned: PlanResult = checked("plan", here, &["made.csv"]);
    assert!(planned.duration_s > planned.plan.calibration_s);
    let searched: Discovery = checked("discover", here, &["made.csv"]);
    assert!(searched.laws.len() <= 5);
    let arguments = ["baro.drift", "--model", "ours.toml", "--from", "made.csv", "--force"];
    let added: Addition = checked("add", here, &arguments);
    assert_eq!(added.effect, "baro.drift");
    let ladder: Ladder = checked("ladder", here, &["--model", "ours.toml", "made.csv"]);
    assert_eq!(ladder.revisions.len(), 2);
    let with_effect: Comparison = checked("compare", here, &["made.csv", "--model", "ours.toml"]);
    assert_eq!(with_effect.effects[0].effect, "baro.drift");

    let effects: EffectsResult = checked("effects", here, &[]);
    assert!(effects.effects.len() > 20);
    let barometer: EffectsResult = checked("effects", here, &["baro"]);
    assert!(barometer.effects.iter().all(|effect| effect.on == "baro"));

    for format in ["csv", "plain-csv", "parquet", "mcap"] {
        let exported: ExportResult =
            checked("export", here, &["made.csv", "--format", format, "-o", &format!("out.{format}")]);
        assert_eq!((&*exported.format, exported.rows), (format, opened.rows));
    }
    let imported: ImportResult = checked("import", here, &["out.mcap", "-o", "back.csv"]);
    assert!(imported.rows > 0 && imported.columns.iter().any(|column| column == "baro_alt_m"));
    let reported: ReportResult = checked("report", here, &["made.csv", "-o", "page.html"]);
    assert_eq!(reported.size_bytes as u64, fs::metadata(here.join("page.html")).unwrap().len());

    let scenario = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../flights/quickstart.toml");
    let scenario = scenario.to_str().unwrap();
    let simulated: SimulateResult = checked("simulate", here, &[scenario, "--seed", "7", "-o", "q.csv"]);
    assert_eq!((simulated.seed, simulated.truth.as_str()), (7, "q.truth.toml"));
}
