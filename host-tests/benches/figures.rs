//! Measurements of `cargo xtask bench`, one per process; results as JSON.
//!
//! `csv FLIGHT` iterates the flight's CSV with the csv crate and does nothing else; `parse FLIGHT` also
//! converts its cells to numbers; `replay FLIGHT` flies it through kf-core, from memory, and prints the ticks
//! a second; `target` counts instructions in QEMU.

use std::error::Error;
use std::hint::black_box;
use std::path::Path;
use std::time::Instant;
use std::{env, fs};

use host_tests::bench::{self, Row};
use host_tests::budget::{Budgets, Check};
use kf_core::input::TickInput;
use model::Model;
use pylon::flight;
use pylon::replay::{Replay, mission};
use serde::Serialize;

/// Rounds of a replay. The fastest counts, because other load on the machine only slows it.
const ROUNDS: usize = 7;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<_> = env::args().skip(1).filter(|argument| argument != "--bench").collect();
    match arguments.iter().map(String::as_str).collect::<Vec<_>>().as_slice() {
        ["csv", file] => iterate(Path::new(file)),
        ["parse", file] => parse(Path::new(file)),
        ["replay", file] => replay(Path::new(file)),
        ["target"] => target(),
        // `cargo bench` alone.
        [] => {
            println!("this is a part of `cargo xtask bench`");
            Ok(())
        }
        _ => Err("expected: csv FLIGHT, parse FLIGHT, replay FLIGHT or target".into()),
    }
}

fn reader(file: &Path) -> Result<csv::Reader<fs::File>, Box<dyn Error>> {
    Ok(csv::ReaderBuilder::new().comment(Some(b'#')).from_path(file)?)
}

/// The csv crate's cheapest way through a file: one record, reused for every row.
fn iterate(file: &Path) -> Result<(), Box<dyn Error>> {
    let mut reader = reader(file)?;
    let mut record = csv::ByteRecord::new();
    let (mut rows, mut bytes) = (0_u64, 0_u64);
    while reader.read_byte_record(&mut record)? {
        rows += 1;
        bytes += record.iter().map(|cell| cell.len() as u64).sum::<u64>();
    }
    println!("{rows} rows, {bytes} bytes in cells");
    Ok(())
}

/// The same, with every cell converted to a number by the standard library.
fn parse(file: &Path) -> Result<(), Box<dyn Error>> {
    let mut reader = reader(file)?;
    let mut record = csv::ByteRecord::new();
    let (mut rows, mut sum) = (0_u64, 0.0_f64);
    while reader.read_byte_record(&mut record)? {
        rows += 1;
        for cell in record.iter().filter(|cell| !cell.is_empty()) {
            sum += str::from_utf8(cell)?.parse::<f64>()?;
        }
    }
    println!("{rows} rows, sum {sum}");
    Ok(())
}

/// Ticks a second.
#[derive(Serialize)]
struct Rates {
    model: &'static str,
    ticks: f64,
    core_ticks_per_s: f64,
    replay_ticks_per_s: f64,
}

/// The mission alone, with its inputs in memory; then including the conversion of the flight to inputs.
fn replay(file: &Path) -> Result<(), Box<dyn Error>> {
    let (flight, _) = flight::read(file)?;
    for (name, model) in [("default", Model::default()), ("paper", Model::paper())] {
        let replay = Replay::new(&flight, &model, None)?;
        let inputs: Vec<TickInput> = replay.inputs().collect();
        let core = best(|| {
            let mut mission = mission(replay.model())?;
            for input in &inputs {
                black_box(mission.tick(black_box(input)));
            }
            Ok(())
        })?;
        let whole = best(|| {
            replay.run(&mut |_, output| {
                black_box(output);
            })?;
            Ok(())
        })?;
        let ticks = inputs.len() as f64;
        let rates =
            Rates { model: name, ticks, core_ticks_per_s: ticks / core, replay_ticks_per_s: ticks / whole };
        println!("{}", serde_json::to_string(&rates)?);
    }
    Ok(())
}

/// Instructions of a tick on the flight computer, and whether the budgets are met.
fn target() -> Result<(), Box<dyn Error>> {
    #[derive(Serialize)]
    struct Counts {
        rows: Vec<Row>,
        checks: Vec<Check>,
    }
    let rows = bench::run()?;
    let checks = Budgets::read()?.check_bench(&rows)?.to_vec();
    println!("{}", serde_json::to_string(&Counts { rows, checks })?);
    Ok(())
}

/// The shortest of several rounds, seconds.
fn best(mut round: impl FnMut() -> Result<(), Box<dyn Error>>) -> Result<f64, Box<dyn Error>> {
    let mut best = f64::INFINITY;
    for _ in 0..ROUNDS {
        let start = Instant::now();
        round()?;
        best = best.min(start.elapsed().as_secs_f64());
    }
    Ok(best)
}
