//! `cargo xtask bench`: Pylon's target figures.

mod figure;
mod host;
mod import;
mod long_flight;
pub mod measure;
mod target;

use std::path::PathBuf;

use anyhow::Context;
use comfy_table::Cell;
use serde::{Deserialize, Serialize};

use crate::child;
use crate::cli::BenchPart;
use crate::setup::{self, Need};
use crate::table::{plain, right};
use crate::workspace;

use figure::Figure;

/// All results.
#[derive(Serialize)]
struct Report {
    target: Option<target::TargetBench>,
    host: Option<host::HostBench>,
    import: Option<import::ImportBench>,
}

/// Measures and prints.
pub fn run(part: Option<BenchPart>, json: bool, echo: bool) -> anyhow::Result<()> {
    let wants = |one| part.is_none_or(|part| part == one);
    let target = if wants(BenchPart::Target) { Some(instructions(echo)?) } else { None };
    let host = if wants(BenchPart::Host) {
        setup::provide(Need::Npm, echo)?;
        eprintln!("building the workbench");
        Some(host::run(echo)?)
    } else {
        None
    };
    let import = if wants(BenchPart::Import) {
        for need in [Need::Npm, Need::Pymavlink] {
            setup::provide(need, echo)?;
        }
        Some(import::run(echo)?)
    } else {
        None
    };
    let report = Report { target, host, import };
    if json {
        println!("{}", serde_json::to_string_pretty(&report)?);
        return Ok(());
    }
    let mut figures = Vec::new();
    if let Some(target) = &report.target {
        println!("{}\n", target.table());
        figures.extend_from_slice(&target.figures);
    }
    if let Some(host) = &report.host {
        println!("{}\n", host.table());
        figures.extend_from_slice(&host.figures);
    }
    if let Some(import) = &report.import {
        println!("{}\n", import.table());
        figures.extend_from_slice(&import.figures);
    }
    println!("{}", figures_table(&figures));
    Ok(())
}

/// Counts instructions in QEMU, after setting up what that needs.
fn instructions(echo: bool) -> anyhow::Result<target::TargetBench> {
    for need in [Need::Target, Need::Qemu, Need::Npm] {
        setup::provide(need, echo)?;
    }
    eprintln!("building the benchmark's image and counting its instructions");
    target::run(echo)
}

/// The benchmark's name.
const BENCHMARK: &str = "figures";

/// Builds the program that measures one thing per process; returns its path.
fn program(echo: bool) -> anyhow::Result<PathBuf> {
    let arguments =
        ["bench", "--package", "host-tests", "--bench", BENCHMARK, "--no-run", "--message-format", "json"];
    let said = child::run(&mut workspace::cargo(arguments), echo)?;
    executable(&said.stdout).context("cargo reported no benchmark that it built")
}

/// The benchmark's path among cargo's messages; a package's programs are built beside it.
fn executable(messages: &str) -> Option<PathBuf> {
    #[derive(Deserialize)]
    struct Message {
        target: Target,
        executable: Option<PathBuf>,
    }
    #[derive(Deserialize)]
    struct Target {
        name: String,
    }
    let messages = messages.lines().filter_map(|line| serde_json::from_str::<Message>(line).ok());
    messages.filter(|message| message.target.name == BENCHMARK).find_map(|message| message.executable)
}

fn figures_table(figures: &[Figure]) -> String {
    let mut table = plain([Cell::new("figure"), right("measured"), Cell::new("wanted"), Cell::new("")]);
    for figure in figures {
        table.add_row([
            Cell::new(&figure.name),
            right(&figure.measured),
            Cell::new(&figure.wanted),
            Cell::new(if figure.met { "met" } else { "MISSED" }),
        ]);
    }
    table.trim_fmt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_benchmark_is_found_among_the_programs_of_its_package() {
        let messages = r#"{"reason":"compiler-artifact","target":{"name":"figures"},"executable":"/target/figures-1"}
{"reason":"compiler-artifact","target":{"name":"endurance"},"executable":"/target/endurance"}
{"reason":"compiler-artifact","target":{"name":"host_tests"},"executable":null}
{"reason":"build-finished","success":true}"#;
        assert_eq!(executable(messages), Some(PathBuf::from("/target/figures-1")));
        assert_eq!(executable(r#"{"reason":"build-finished","success":false}"#), None);
    }
}
