//! Blind trials: `cargo xtask blind`.

use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

use anyhow::bail;
use host_tests::blind::{Trial, draw, run, table};

fn main() -> anyhow::Result<()> {
    let verbose = std::env::args().any(|argument| argument == "--verbose");
    let numbers: Result<Vec<u64>, _> = std::env::args()
        .skip(1)
        .filter(|argument| argument != "--verbose")
        .map(|argument| argument.parse())
        .collect();
    let (count, first) = match numbers.as_deref() {
        Ok([]) => (200, 1),
        Ok([count]) => (*count, 1),
        Ok([count, first]) => (*count, *first),
        _ => bail!("usage: blind [TRIALS] [FIRST_SEED]"),
    };
    let next = AtomicU64::new(first);
    let trials: Mutex<Vec<Trial>> = Mutex::new(Vec::new());
    let unflown = AtomicU64::new(0);
    std::thread::scope(|scope| {
        for _ in 0..std::thread::available_parallelism().map_or(1, usize::from) {
            scope.spawn(|| {
                loop {
                    let seed = next.fetch_add(1, Ordering::Relaxed);
                    if seed >= first + count {
                        break;
                    }
                    match run(draw(seed)) {
                        Ok(trial) => {
                            println!("{}", line(&trial));
                            if verbose {
                                println!(
                                    "{}\n{}",
                                    trial.case.scenario,
                                    pylon::diagnose::text(&trial.diagnosis, false)
                                );
                            }
                            if let Ok(mut trials) = trials.lock() {
                                trials.push(trial);
                            }
                        }
                        Err(error) => {
                            unflown.fetch_add(1, Ordering::Relaxed);
                            println!("{seed:>5} not flown: {error}");
                        }
                    }
                }
            });
        }
    });
    let trials = trials.into_inner()?;
    println!(
        "\n{} trials flown, {} plans that the aircraft can't fly\n{}",
        trials.len(),
        unflown.into_inner(),
        table(&trials)
    );
    Ok(())
}

fn line(trial: &Trial) -> String {
    let truth: Vec<String> = trial.truth.iter().map(|(id, size)| format!("{id} x{size:.1}")).collect();
    let kind = match &trial.case.kind {
        host_tests::blind::Kind::Effects(_) => truth.join(" + "),
        other => format!("{other:?}"),
    };
    let said: Vec<String> = trial
        .diagnosis
        .sensors
        .iter()
        .map(|(name, sensor)| {
            let sets: Vec<String> =
                sensor.indistinguishable.iter().map(|set| format!("{{{}}}", set.join(" "))).collect();
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
        trial.deviations.iter().map(|deviation| format!("{deviation:+.1}")).collect();
    let deviations =
        if deviations.is_empty() { String::new() } else { format!(" ({} sigma)", deviations.join(" ")) };
    format!(
        "{:>5} {mark:<6} {:?} {kind}{} => {}{deviations}",
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
