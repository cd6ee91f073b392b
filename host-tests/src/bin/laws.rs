//! Blind trials for laws: `cargo xtask laws`.

use std::path::PathBuf;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

use clap::Parser;
use host_tests::laws::{Trial, draw, dump, run, table};

/// Fly simulated flights with a hidden law, search for it blind, and count how often the search is right.
#[derive(Debug, Parser)]
#[command(name = "laws")]
struct Arguments {
    /// Number of trials.
    #[arg(default_value_t = 120, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    trials: u64,
    /// Seed of the first trial; each further trial adds one.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Write the search's inputs and the truth to this folder, without searching: for other methods to try.
    #[arg(long, value_name = "FOLDER")]
    dump: Option<PathBuf>,
    /// Print only the table, without a line for every trial.
    #[arg(long, short)]
    quiet: bool,
}

fn main() -> anyhow::Result<()> {
    let arguments = Arguments::parse();
    if let Some(folder) = &arguments.dump {
        std::fs::create_dir_all(folder)?;
        for seed in arguments.seed..arguments.seed.saturating_add(arguments.trials) {
            // A plan that the aircraft can't fly is not a trial.
            if let Err(error) = dump(&draw(seed), folder) {
                println!("{seed:>5} not flown: {error}");
            }
        }
        return Ok(());
    }
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
                    let trial = run(draw(seed));
                    if let (Ok(trial), false) = (&trial, arguments.quiet) {
                        println!("{}", line(trial));
                    }
                    if let Ok(mut results) = results.lock() {
                        results.push((seed, trial));
                    }
                }
            });
        }
    });
    let mut results = results.into_inner()?;
    results.sort_by_key(|(seed, _)| *seed);
    let mut trials = Vec::new();
    let mut unflown = 0;
    for (seed, result) in results {
        match result {
            Ok(trial) => trials.push(trial),
            Err(error) => {
                unflown += 1;
                if !arguments.quiet {
                    println!("{seed:>5} not flown: {error}");
                }
            }
        }
    }
    println!(
        "{} trials flown (seeds {} to {}), {unflown} plans that the aircraft can't fly\n\n{}",
        trials.len(),
        arguments.seed,
        end - 1,
        table(&trials)
    );
    Ok(())
}

fn line(trial: &Trial) -> String {
    let hidden = trial
        .case
        .hidden
        .map_or_else(|| "null".to_owned(), |(hidden, size)| format!("{hidden:?} x{size:.1}"));
    let laws: Vec<String> = trial
        .discovery
        .laws
        .iter()
        .zip(&trial.correlations)
        .map(|(law, r)| format!("{} {} [p {:.2}, r {r:.3}]", law.on, law.regressor, law.probability))
        .collect();
    let said = match (laws.as_slice(), &trial.discovery.rejected) {
        ([], Some(rejected)) => {
            format!("none ({:?} {} {:?})", rejected.why, rejected.regressor, rejected.effect)
        }
        ([], None) => "none".to_owned(),
        (laws, _) => laws.join(" | "),
    };
    let [among, first] = trial.hits();
    let mark = match (trial.case.hidden.is_some(), among, first) {
        (true, _, true) => "first",
        (true, true, false) => "among",
        (true, ..) => "missed",
        (false, ..) if trial.discovery.laws.is_empty() => "",
        (false, ..) => "WRONG",
    };
    let worse = if trial.is_worse() { " WORSE" } else { "" };
    format!(
        "{:>5} {mark:<6}{worse} {hidden} => [{}] {said}",
        trial.case.seed,
        trial.discovery.catalogue.join(" ")
    )
}
