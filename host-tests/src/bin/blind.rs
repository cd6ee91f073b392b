//! Blind trials: `cargo xtask blind`.

use std::fs::{self, File};
use std::io::{BufWriter, Write as _};
use std::path::PathBuf;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

use anyhow::Context as _;
use clap::Parser;
use host_tests::blind::{
    Case, Family, Kind, Plan, Trial, advised, draw, fly, improvement, intervals, reliability, run, table,
};
use host_tests::confusion::confusion;
use indicatif::{ProgressBar, ProgressStyle};
use model::Model;
use pylon::replay::Replay;
use serde::Serialize;

/// Fly simulated flights with hidden effects, diagnose them blind, and count how often the diagnosis is
/// right.
#[derive(Debug, Parser)]
#[command(name = "blind")]
struct Arguments {
    /// Number of trials.
    #[arg(default_value_t = 200, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    trials: u64,
    /// Seed of the first trial; each further trial adds one.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// The generator: `pylon simulate`, or one that shares nothing with it.
    #[arg(long, value_enum, default_value_t)]
    family: Family,
    /// Also print every trial's scenario and diagnosis.
    #[arg(long, short)]
    verbose: bool,
    /// Print only the tables, without a line for every trial.
    #[arg(long, short)]
    quiet: bool,
    /// Also fly the plan that is advised for each set, and diagnose both flights together.
    #[arg(long)]
    fly_advice: bool,
    /// Write the flights, the diagnosis's inputs and the truth to this folder, for other methods to try.
    #[arg(long, value_name = "FOLDER")]
    dump: Option<PathBuf>,
}

/// A trial in the form that other methods need.
#[derive(Serialize)]
struct Dumped<'a> {
    seed: u64,
    /// The effects that acted.
    truth: Vec<&'a str>,
    /// The strongest of them, if it counts: more than twice the noise, on a flight that excites.
    strongest: Option<&'a str>,
    /// Whether no sensor had an error.
    is_null: bool,
    /// Effects that Pylon identifies.
    identified: Vec<&'a str>,
    /// Whether Pylon identifies the strongest effect, or a set that contains it.
    is_held: bool,
}

fn main() -> anyhow::Result<()> {
    let arguments = Arguments::parse();
    if let Some(folder) = &arguments.dump {
        fs::create_dir_all(folder).with_context(|| format!("{} cannot be made", folder.display()))?;
    }
    let bar = ProgressBar::new(arguments.trials)
        .with_message("blind trials")
        .with_style(ProgressStyle::with_template("{msg} {wide_bar} {pos} of {len}, {eta} left")?);
    let end = arguments.seed.saturating_add(arguments.trials);
    let next = AtomicU64::new(arguments.seed);
    let results: Mutex<Vec<(u64, anyhow::Result<Trial>)>> = Mutex::new(Vec::new());
    std::thread::scope(|scope| {
        for _ in 0..std::thread::available_parallelism().map_or(1, usize::from) {
            scope.spawn(|| {
                loop {
                    let seed = next.fetch_add(1, Ordering::Relaxed);
                    if seed >= end {
                        break;
                    }
                    let trial = one(draw(arguments.family, seed), &arguments);
                    bar.inc(1);
                    if let Ok(mut results) = results.lock() {
                        results.push((seed, trial));
                    }
                }
            });
        }
    });
    bar.finish_and_clear();
    let mut results = results.into_inner()?;
    results.sort_by_key(|(seed, _)| *seed);
    let mut trials = Vec::new();
    let mut unflown = 0;
    for (seed, result) in results {
        match result {
            Ok(trial) => {
                if !arguments.quiet {
                    println!("{}", line(&trial));
                }
                if arguments.verbose {
                    println!("{}\n{}", trial.case.scenario, pylon::diagnose::text(&trial.diagnosis, false));
                }
                trials.push(trial);
            }
            Err(error) => {
                unflown += 1;
                if !arguments.quiet {
                    println!("{seed:>5} not flown: {error}");
                }
            }
        }
    }
    if let Some(folder) = &arguments.dump {
        let dumped: Vec<Dumped<'_>> = trials.iter().map(dumped).collect();
        fs::write(folder.join("trials.json"), serde_json::to_string_pretty(&dumped)?)?;
    }
    let improvements: Vec<_> = trials.iter().filter_map(|trial| trial.improvement.clone()).collect();
    println!(
        "{} trials flown (seeds {} to {}), {unflown} plans that the aircraft can't fly\n\n{}\n{}\n{}\n{}\n{}",
        trials.len(),
        arguments.seed,
        end - 1,
        table(&trials),
        reliability(&trials),
        intervals(&trials),
        improvement::lines(&improvements),
        confusion(&trials)
    );
    if arguments.fly_advice {
        let advised: Vec<_> = trials.iter().filter_map(|trial| trial.advised.clone()).collect();
        print!("\n{}", advised::lines(&advised));
    }
    Ok(())
}

/// Flies and diagnoses a case, and writes the diagnosis's inputs: the block means (`SEED.csv`) and the whole
/// flight (`SEED.flight.csv`), which another build of `pylon` can diagnose.
fn one(case: Case, arguments: &Arguments) -> anyhow::Result<Trial> {
    if let Some(folder) = &arguments.dump {
        let model = Model::default();
        let flown = fly(&case, 0)?;
        let replay = Replay::new(&flown.flight, &model, None)?;
        let mut out = BufWriter::new(File::create(folder.join(format!("{}.csv", case.seed)))?);
        pylon::diagnose::dump(&replay, &mut out)?;
        out.flush()?;
        let mut out = BufWriter::new(File::create(folder.join(format!("{}.flight.csv", case.seed)))?);
        pylon::flight::to_writer(&mut out, &flown.flight)?;
        out.flush()?;
    }
    run(case, arguments.fly_advice)
}

fn dumped(trial: &Trial) -> Dumped<'_> {
    let counts = matches!(trial.case.kind, Kind::Effects(_)) && trial.case.plan != Plan::Level;
    let strongest = trial.truth.first().filter(|(_, size)| counts && *size > 2.0).map(|(id, _)| *id);
    Dumped {
        seed: trial.case.seed,
        truth: trial.truth.iter().map(|(id, _)| *id).collect(),
        strongest,
        is_null: matches!(trial.case.kind, Kind::Null | Kind::Glitch(_)),
        identified: trial.identified(),
        is_held: strongest.is_some_and(|id| trial.holds(id)),
    }
}

fn line(trial: &Trial) -> String {
    let truth: Vec<String> = trial.truth.iter().map(|(id, size)| format!("{id} x{size:.1}")).collect();
    let kind = match &trial.case.kind {
        Kind::Effects(_) => truth.join(" + "),
        other => format!("{other:?}"),
    };
    let said: Vec<String> = trial
        .diagnosis
        .sensors
        .iter()
        .map(|(name, sensor)| {
            let sets: Vec<String> = sensor
                .sets()
                .map(|set| {
                    let nothing = set.nothing.map_or_else(String::new, |nothing| {
                        format!(", or nothing: {:.0} %", 100.0 * nothing)
                    });
                    format!("{{{}{nothing}}}", set.effects.join(" "))
                })
                .collect();
            let follows =
                sensor.follows.first().map_or_else(String::new, |follows| format!(" ~{}", follows.signal));
            format!(
                "{name}: {} {} {}{follows}",
                sensor.verdict.name(),
                sensor.missing.join(" "),
                sets.join(" ")
            )
        })
        .collect();
    let strongest = trial.truth.first().filter(|(_, size)| *size > 2.0);
    let mark = if trial.is_wrong() {
        "WRONG"
    } else if strongest.is_some_and(|(id, _)| !trial.holds(id)) {
        "missed"
    } else {
        ""
    };
    let deviations: Vec<String> =
        trial.deviations.iter().map(|deviation| format!("{:+.1}", deviation.sigmas())).collect();
    let deviations =
        if deviations.is_empty() { String::new() } else { format!(" ({} sigma)", deviations.join(" ")) };
    let improvement = trial.improvement.as_ref().map_or_else(String::new, |i| {
        let refused: Vec<String> = i.refused.iter().map(|why| format!("; refused {why}")).collect();
        format!(
            " [next flight {:.2} m, added {:.2} m, oracle {:.2} m{}]",
            i.before_m,
            i.after_m,
            i.oracle_m,
            refused.concat()
        )
    });
    let advised = trial.advised.as_ref().map_or_else(String::new, |advised| {
        let of_set = |set: &advised::AdvisedSet| {
            let outcome = set.outcome.map_or("not flown".to_owned(), |outcome| format!("{outcome:?}"));
            format!("{{{}}} {:.0} %: {outcome}", set.effects.join(" "), 100.0 * set.promised)
        };
        let sets: Vec<String> = advised.sets.iter().map(of_set).collect();
        format!(" [flown as advised, {:.0} s: {} => {}]", advised.free_s, sets.join("; "), advised.said)
    });
    format!(
        "{:>5} {mark:<6} {:?} {kind}{} => {}{deviations}{improvement}{advised}",
        trial.case.seed,
        trial.case.plan,
        if trial.case.missing.is_empty() {
            String::new()
        } else {
            format!(" -[{}]", trial.case.missing.join(" "))
        },
        said.join("; ")
    )
}
