//! Instructions of a tick on the flight computer, ours and other filters', counted by QEMU in one run.

use anyhow::Context;
use comfy_table::Cell;
use serde::{Deserialize, Serialize};

use super::figure::Figure;
use crate::child;
use crate::table::{plain, right};
use crate::workspace;

/// The filter that the others are compared with: the paper's four states and four sensors.
const FILTER: &str = "kf-core filter";

/// Role of a measured filter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
enum Role {
    /// kf-core.
    Ours,
    /// Published.
    Peer,
    /// Hand-written for comparison; not published.
    Reference,
}

/// A filter.
#[derive(Clone, Debug, Deserialize, Serialize)]
struct Row {
    name: String,
    role: Role,
    /// Instructions of a tick.
    mean: f64,
    /// Instructions of the cheapest tick.
    least: u32,
    /// Instructions of the most expensive tick.
    most: u32,
}

/// A budget of the firmware.
#[derive(Debug, Deserialize)]
struct Check {
    what: String,
    measured: String,
    budget: String,
    kept: bool,
}

/// Output of the benchmark's program.
#[derive(Debug, Deserialize)]
struct Counts {
    rows: Vec<Row>,
    checks: Vec<Check>,
}

/// Results of the count.
#[derive(Debug, Serialize)]
pub struct TargetBench {
    rows: Vec<Row>,
    /// The target figures.
    pub figures: Vec<Figure>,
}

/// Builds the image, runs it in QEMU and reads the counts.
pub fn run(echo: bool) -> anyhow::Result<TargetBench> {
    let program = super::program(echo)?;
    let said = child::run(workspace::program(program).arg("target"), echo)?;
    read(&said.stdout)
}

fn read(output: &str) -> anyhow::Result<TargetBench> {
    let Counts { rows, checks } =
        serde_json::from_str(output).context("the benchmark's program printed unexpected output")?;
    let figures = checks
        .into_iter()
        .map(|Check { what, measured, budget, kept }| Figure {
            name: what,
            measured,
            wanted: budget,
            met: kept,
        })
        .collect();
    Ok(TargetBench { rows, figures })
}

impl TargetBench {
    /// The filters, with their cost in multiples of ours.
    pub fn table(&self) -> String {
        let filter = self.rows.iter().find(|row| row.name == FILTER).map_or(f64::NAN, |row| row.mean);
        let header = [Cell::new("filter"), right("instructions"), right("worst"), right("ratio to ours")];
        let mut table = plain(header);
        for row in &self.rows {
            let ratio = row.mean / filter;
            let ratio = if row.role == Role::Ours { String::new() } else { format!("{ratio:.2}") };
            let remark = if row.role == Role::Reference { " (hand-written; not published)" } else { "" };
            table.add_row([
                Cell::new(format!("{}{remark}", row.name)),
                right(format!("{:.0}", row.mean)),
                right(row.most.to_string()),
                right(ratio),
            ]);
        }
        format!(
            "Instructions of a tick on the Cortex-M4F: the paper's 4-state, 4-sensor problem, one image, one run in QEMU.\n{}",
            table.trim_fmt()
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const OUTPUT: &str = r#"{"rows": [
        {"name": "nalgebra sequential", "role": "peer", "mean": 819.0, "least": 819, "most": 819, "agrees": true},
        {"name": "nalgebra rank-one", "role": "reference", "mean": 314.0, "least": 314, "most": 314, "agrees": true},
        {"name": "kf-core filter", "role": "ours", "mean": 166.0, "least": 166, "most": 166, "agrees": true}],
        "checks": [{"what": "filter", "measured": "166", "budget": "<= 100", "kept": false}]}"#;

    #[test]
    fn ratios_are_to_ours() {
        let bench = read(OUTPUT).unwrap();
        assert!(!bench.figures[0].met);
        let table = bench.table();
        let last_word = |name: &str| {
            let line = table.lines().find(|line| line.starts_with(name)).unwrap();
            line.split_whitespace().last().unwrap().to_owned()
        };
        assert_eq!(last_word("nalgebra sequential"), "4.93");
        assert_eq!(last_word("nalgebra rank-one"), "1.89");
        assert_eq!(last_word("kf-core filter"), "166");
    }

    #[test]
    fn anything_else_is_an_error() {
        assert!(read("panicked").is_err());
    }
}
