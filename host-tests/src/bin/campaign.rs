//! A campaign of faults on the whole chain: `cargo xtask campaign`.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::Context as _;
use clap::Parser;
use host_tests::campaign::fly;
use host_tests::campaign::judge::{Verdict, Violation, judge, shown_m};
use host_tests::campaign::known::Known;
use host_tests::campaign::matrix::Matrix;
use host_tests::campaign::mutants::{Outcome, without};
use host_tests::campaign::run::{Case, Flown, config};
use host_tests::campaign::watch::REFERENCE;
use indicatif::{ProgressBar, ProgressStyle};
use kf_core::guard::Guard;
use kf_core::sensor::Sensor;

/// The page that `--write` writes the tables into.
const PAGE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/fault-campaign.md");
/// The tables lie between these lines of the page.
const BEGIN: &str = "<!-- tables: written by `cargo xtask campaign --write` -->";
const END: &str = "<!-- end of the tables -->";
/// Number of guards whose removal must be noticed.
const MUTANTS: usize = 10;

/// Fly random flights with random faults, and compare each with the same flight without them.
#[derive(Debug, Parser)]
#[command(name = "campaign", bin_name = "cargo xtask campaign")]
struct Arguments {
    /// Number of runs.
    #[arg(default_value_t = 1_000)]
    runs: u64,
    /// Seed of the campaign.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Fly only this run, and print what was drawn and the result.
    #[arg(long)]
    run: Option<u64>,
    /// Also write what was observed of both its flights, tick by tick, as CSV.
    #[arg(long, value_name = "FILE", requires = "run")]
    trace: Option<PathBuf>,
    /// Remove each guard in turn, and fail unless the campaign reports it.
    #[arg(long)]
    mutants: bool,
    /// Write the tables into docs/fault-campaign.md.
    #[arg(long)]
    write: bool,
    /// Fail for violations that this list does not name, and for listed ones that no longer happen, instead
    /// of for any violation.
    #[arg(long, value_name = "FILE")]
    known: Option<PathBuf>,
    /// Rewrite the list from this campaign.
    #[arg(long, requires = "known")]
    accept: bool,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    // A panic is a finding, and is reported with the others.
    std::panic::set_hook(Box::new(|_| ()));
    let outcome = match arguments.run {
        Some(index) => detail(arguments.seed, index, arguments.trace.as_deref()),
        None => campaign(&arguments),
    };
    match outcome {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::from(2)
        }
    }
}

fn bar(length: u64, message: String) -> anyhow::Result<ProgressBar> {
    let style = ProgressStyle::with_template("{msg} {wide_bar} {pos} of {len}, {eta} left")?;
    Ok(ProgressBar::new(length).with_message(message).with_style(style))
}

fn campaign(arguments: &Arguments) -> anyhow::Result<bool> {
    let progress = bar(arguments.runs, "runs".to_owned())?;
    let cases: Vec<Case> =
        (0..arguments.runs).map(|index| Case::draw(arguments.seed, index, false)).collect();
    let verdicts = fly(arguments.seed, &cases, &|| progress.inc(1))?;
    progress.finish_and_clear();
    let mut matrix = Matrix::default();
    let mut violations = Vec::new();
    for (case, verdict) in cases.iter().zip(&verdicts) {
        matrix.take(case, verdict);
        violations.extend(lines(arguments.seed, case, verdict));
    }
    violations.sort();
    violations.iter().for_each(|line| println!("{line}"));
    let tables = format!("{}\n{}", matrix.table(), matrix.summary());
    println!("{tables}");
    if arguments.write {
        write(arguments, &tables, &violations)?;
    }
    let caught = if arguments.mutants { Some(mutants(arguments.seed, &cases, &verdicts)?) } else { None };
    let Some(file) = &arguments.known else {
        return Ok(matrix.violated() == 0 && caught.is_none_or(|caught| caught.len() >= MUTANTS));
    };
    let found = Known::found(arguments.seed, &cases, &verdicts, caught.as_deref());
    if arguments.accept {
        found.save(file)?;
    }
    let changes = found.changes_from(&Known::load(file)?);
    for change in &changes {
        println!("differs from {}: {change}", file.display());
    }
    println!(
        "{} of {} runs break an invariant, all known; the campaign reports the removal of {} of {} guards",
        matrix.violated(),
        cases.len(),
        caught.map_or(0, |caught| caught.len()),
        Guard::ALL.len()
    );
    Ok(changes.is_empty())
}

/// One line per violation.
fn lines(seed: u64, case: &Case, verdict: &Verdict) -> Vec<String> {
    let names: Vec<_> =
        case.faults.iter().map(|fault| format!("{} ({})", fault.name, fault.phase.name())).collect();
    let line = |violation: &Violation| {
        format!(
            "{}: {}: {}: `cargo xtask campaign --run {} --seed {seed}`",
            violation.invariant.name(),
            names.join(" and "),
            violation.what,
            case.index
        )
    };
    verdict.violations.iter().map(line).collect()
}

/// The guards whose removal the campaign notices.
fn mutants(seed: u64, cases: &[Case], verdicts: &[Verdict]) -> anyhow::Result<Vec<Guard>> {
    let mut noticed = Vec::new();
    println!("| removed guard | runs | of these report it | first |\n|---|---|---|---|");
    for guard in Guard::ALL {
        let progress = bar(0, format!("without {guard:?}"))?;
        let Outcome { runs, reports, .. } = without(guard, seed, cases, verdicts, &|| progress.inc(1))?;
        progress.finish_and_clear();
        if !reports.is_empty() {
            noticed.push(guard);
        }
        let first = reports.first().map_or_else(
            || "-".to_owned(),
            |(index, invariant)| format!("run {index}: {}", invariant.name()),
        );
        println!("| {guard:?} | {runs} | {} | {first} |", reports.len());
    }
    println!("\nThe campaign reports the removal of {} of {} guards", noticed.len(), Guard::ALL.len());
    Ok(noticed)
}

fn write(arguments: &Arguments, tables: &str, violations: &[String]) -> anyhow::Result<()> {
    let page = std::fs::read_to_string(Path::new(PAGE)).with_context(|| PAGE)?;
    let (before, rest) = page.split_once(BEGIN).with_context(|| format!("{PAGE} has no line `{BEGIN}`"))?;
    let (_, after) = rest.split_once(END).with_context(|| format!("{PAGE} has no line `{END}`"))?;
    let violations = match violations {
        [] => "No invariant was broken.".to_owned(),
        violations => violations.iter().map(|line| format!("- {line}")).collect::<Vec<_>>().join("\n"),
    };
    let command = format!("`cargo xtask campaign {} --seed {}`", arguments.runs, arguments.seed);
    let text = format!("{before}{BEGIN}\n\n{command}\n\n{tables}\n{violations}\n\n{END}{after}");
    std::fs::write(Path::new(PAGE), text).with_context(|| PAGE)
}

/// A line for each tick and sensor of both flights.
fn trace(file: &Path, flown: &Flown) -> anyhow::Result<()> {
    use std::fmt::Write as _;
    let mut text = "flight,tick,sensor,trust,fresh,fix,error_m,average_m,true_error_m\n".to_owned();
    let number = |value: Option<f32>| value.map_or_else(String::new, |value| value.to_string());
    for (name, flight) in [("clean", &flown.clean), ("faulty", &flown.faulty)] {
        for (tick, seen) in flight.ticks.iter().enumerate() {
            let Some(seen) = seen else { continue };
            for sensor in Sensor::ALL {
                let i = sensor.index();
                let is_fresh = |bit: usize| u8::from(seen.fresh & 1 << bit != 0);
                writeln!(
                    text,
                    "{name},{tick},{},{:?},{},{},{},{},{}",
                    sensor.name(),
                    seen.trust[i],
                    is_fresh(i),
                    is_fresh(REFERENCE),
                    number(seen.error_m[i]),
                    number(seen.average_m[i]),
                    seen.true_error_m[i]
                )?;
            }
        }
    }
    std::fs::write(file, text).with_context(|| file.display().to_string())
}

fn detail(seed: u64, index: u64, trace_file: Option<&Path>) -> anyhow::Result<bool> {
    let case = Case::draw(seed, index, false);
    println!("{case:#?}");
    let flown = case.fly(seed, &config()?)?;
    let verdict = judge(&case, &flown);
    if let Some(file) = trace_file {
        trace(file, &flown)?;
    }
    for (name, flight) in [("clean", &flown.clean), ("faulty", &flown.faulty)] {
        println!(
            "{name}: edge {:?}, launched {:?}, flagged {:?}, operations {}, step {:?}",
            flight.first_edge, flight.launched, flight.flagged, flight.most_operations, flight.step_m
        );
        println!("{name}: restarts {:#?}", flight.restarts);
        let latch = flight.latch.as_ref().map(|latch| (latch.time_us, latch.failed_checks, latch.sensors));
        println!("{name}: latch {latch:#?}");
    }
    for (sensor, flagged) in Sensor::ALL.into_iter().zip(flown.faulty.flagged) {
        if let Some(flagged) = flagged {
            let shown_m = shown_m(&flown.clean, &flagged);
            println!("faulty: {} flagged; the clean flight's receiver shows {shown_m:.2} m", sensor.name());
        }
    }
    println!("{verdict:#?}");
    Ok(verdict.violations.is_empty())
}
