//! Time and memory on this machine: of the estimator alone, and of a comparison relative to reading its file,
//! measured in turn in one run.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::Context;
use comfy_table::Cell;
use serde::{Deserialize, Serialize};

use super::figure::Figure;
use super::long_flight;
use super::measure::{self, Cost};
use crate::child;
use crate::table::{plain, right};
use crate::workspace;

/// Times that every command is run. Other load on the machine only makes it slower, so the shortest time
/// counts.
const ROUNDS: usize = 5;
/// Lengths of the flights, hours.
const HOURS: [u32; 2] = [1, 2];

/// Speed of a replay in memory, ticks a second.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct Replay {
    /// The model's name.
    pub model: String,
    /// Ticks of the flight.
    pub ticks: f64,
    /// The mission's ticks alone.
    pub core_ticks_per_s: f64,
    /// The same, including making their inputs from the flight.
    pub replay_ticks_per_s: f64,
}

/// Cost of one flight.
#[derive(Clone, Debug, Serialize)]
pub struct Flight {
    /// Its length, hours.
    pub hours: u32,
    /// Size of its file, bytes.
    pub file_bytes: u64,
    /// Splitting its rows into cells with the csv crate, without converting any to numbers.
    pub csv: Cost,
    /// Parsing it: the same, plus converting every cell to a number with the standard library.
    pub parse: Cost,
    /// `pylon compare`.
    pub compare: Cost,
    /// `pylon diagnose`, over the whole catalogue.
    pub diagnose: Cost,
}

/// Results of the host's benchmarks.
#[derive(Clone, Debug, Serialize)]
pub struct HostBench {
    /// Replays of the one-hour flight.
    pub replays: Vec<Replay>,
    /// The flights by length.
    pub flights: Vec<Flight>,
    /// The target figures.
    pub figures: Vec<Figure>,
}

/// Builds, makes the flights and measures.
pub fn run(echo: bool) -> anyhow::Result<HostBench> {
    child::run(&mut workspace::build_workbench(), echo)?;
    let bench = super::program(echo)?;
    let folder = workspace::target_folder().join("bench");
    fs::create_dir_all(&folder)?;
    let mut flights = Vec::new();
    for hours in HOURS {
        eprintln!("simulating and measuring a flight of {hours} h");
        let file = simulate(&folder, hours, echo)?;
        flights.push(measure_flight(&bench, &file, hours)?);
    }
    let said =
        child::run(workspace::program(&bench).arg("replay").arg(flight_file(&folder, HOURS[0])), echo)?;
    let replays = said
        .stdout
        .lines()
        .map(serde_json::from_str)
        .collect::<Result<Vec<Replay>, _>>()
        .context("the replay's benchmark printed unexpected output")?;
    let figures = figures(&replays, &flights);
    Ok(HostBench { replays, flights, figures })
}

fn flight_file(folder: &Path, hours: u32) -> PathBuf {
    folder.join(format!("{hours}-h.csv"))
}

fn simulate(folder: &Path, hours: u32, echo: bool) -> anyhow::Result<PathBuf> {
    let scenario = folder.join(format!("{hours}-h.toml"));
    let flight = flight_file(folder, hours);
    fs::write(&scenario, long_flight::scenario(hours))?;
    let mut simulate = workspace::program(workspace::workbench());
    child::run(simulate.arg("simulate").arg(&scenario).arg("-o").arg(&flight), echo)?;
    Ok(flight)
}

/// Runs the commands on a file in turn, so that a disturbance affects all of them.
fn measure_flight(bench: &Path, file: &Path, hours: u32) -> anyhow::Result<Flight> {
    let command = |program: &Path, arguments: &[&str]| {
        let mut command = Command::new(program);
        command.args(arguments).arg(file);
        command
    };
    let commands = [
        command(bench, &["csv"]),
        command(bench, &["parse"]),
        command(&workspace::workbench(), &["compare", "--json"]),
        command(&workspace::workbench(), &["diagnose", "--json"]),
    ];
    let [csv, parse, compare, diagnose] = measure::shortest(ROUNDS, commands)?;
    Ok(Flight { hours, file_bytes: fs::metadata(file)?.len(), csv, parse, compare, diagnose })
}

fn figures(replays: &[Replay], flights: &[Flight]) -> Vec<Figure> {
    let mut figures = Vec::new();
    for replay in replays {
        let name = format!("kf-core, model {}", replay.model);
        figures.push(Figure::at_least(name, replay.core_ticks_per_s / 1e6, 2.0, " million ticks/s"));
        let name = format!("replay of a flight in memory, model {}", replay.model);
        figures.push(Figure::at_least(name, replay.replay_ticks_per_s / 1e6, 2.0, " million ticks/s"));
    }
    if let Some(flight) = flights.first() {
        let Flight { parse, compare, diagnose, .. } = flight;
        for (name, ratio) in [
            ("compare / parsing every cell with the csv crate, time", compare.seconds / parse.seconds),
            ("the same, time of all cores", compare.cpu_seconds / parse.cpu_seconds),
        ] {
            figures.push(Figure::at_most(name, ratio, 3.0, ""));
        }
        let hours = f64::from(flight.hours);
        figures.push(Figure::at_most(
            "diagnose, time per hour of flight",
            diagnose.seconds / hours,
            5.0,
            " s",
        ));
        // A comparison holds little more than the parsed flight: the measure of a diagnosis's memory.
        let memory = diagnose.peak_bytes as f64 / compare.peak_bytes as f64;
        figures.push(Figure::at_most("diagnose / compare, memory", memory, 4.0, ""));
    }
    if let [short, long] = flights {
        let memory = long.compare.peak_bytes as f64 / short.compare.peak_bytes as f64;
        let file = long.file_bytes as f64 / short.file_bytes as f64;
        figures.push(Figure::at_most("compare: growth of memory / growth of file", memory / file, 1.0, ""));
        let time = long.diagnose.seconds / short.diagnose.seconds;
        figures.push(Figure::at_most("diagnose: growth of time / growth of file", time / file, 1.1, ""));
    }
    figures
}

impl HostBench {
    /// Times and memory by flight.
    pub fn table(&self) -> String {
        let header = [
            Cell::new("flight"),
            Cell::new("what"),
            right("time"),
            right("all cores"),
            right("time / parsing"),
            right("peak memory"),
        ];
        let mut table = plain(header);
        let mebibytes = |bytes: u64| format!("{:.0} MiB", bytes as f64 / f64::from(1 << 20));
        for flight in &self.flights {
            let ways = [
                ("cut into cells by the csv crate", flight.csv),
                ("and every cell parsed", flight.parse),
                ("pylon compare", flight.compare),
                ("pylon diagnose", flight.diagnose),
            ];
            for (what, cost) in ways {
                table.add_row([
                    Cell::new(format!("{} h, {}", flight.hours, mebibytes(flight.file_bytes))),
                    Cell::new(what),
                    right(format!("{:.2} s", cost.seconds)),
                    right(format!("{:.2} s", cost.cpu_seconds)),
                    right(format!("{:.2}", cost.seconds / flight.parse.seconds)),
                    right(mebibytes(cost.peak_bytes)),
                ]);
            }
        }
        format!(
            "Simulated flights, 200 rows a second, on this machine; the shortest of {ROUNDS} rounds, taken in turn.\n{}",
            table.trim_fmt()
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn flight(file_bytes: u64, seconds: f64, peak_bytes: u64) -> Flight {
        let csv = Cost { seconds: 0.8, cpu_seconds: 0.8, peak_bytes: 1 };
        let parse = Cost { seconds: 1.0, cpu_seconds: 1.0, peak_bytes: 1 };
        let compare = Cost { seconds, cpu_seconds: 1.5 * seconds, peak_bytes };
        let diagnose = Cost { seconds: 2.0 * seconds, cpu_seconds: 2.0, peak_bytes: 2 * peak_bytes };
        Flight { hours: 1, file_bytes, csv, parse, compare, diagnose }
    }

    #[test]
    fn figures_are_ratios_of_one_run() {
        let figures = figures(&[], &[flight(100, 2.5, 50), flight(200, 9.0, 110)]);
        let measured: Vec<_> = figures.iter().map(|figure| (figure.measured.as_str(), figure.met)).collect();
        assert_eq!(
            measured,
            [
                ("2.50", true),
                ("3.75", false),
                ("5.00 s", true),
                ("2.00", true),
                ("1.10", false),
                ("1.80", false)
            ]
        );
    }
}
