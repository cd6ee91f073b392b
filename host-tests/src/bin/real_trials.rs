//! Trials on real tracks: `cargo xtask real-trials`.

use clap::{Parser, ValueEnum};
use host_tests::real_trials::{Case, Half, Log, Outcome, logs, of_log, reliability, table};
use indicatif::{ProgressBar, ProgressStyle};
use rayon::prelude::*;

/// Diagnose real logs, flights generated from their tracks, and both with one effect added, and count how
/// often the diagnosis is right.
#[derive(Debug, Parser)]
#[command(name = "real_trials")]
struct Arguments {
    /// Half of the logs to use.
    #[arg(long, value_enum, default_value_t = HalfName::Development)]
    half: HalfName,
    /// Only logs whose name contains this text.
    #[arg(long, value_name = "TEXT")]
    log: Option<String>,
    /// Also print every diagnosis.
    #[arg(long, short)]
    verbose: bool,
    /// Print only the tables, without a line for every trial.
    #[arg(long, short)]
    quiet: bool,
}

/// The halves, by their names on the command line.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum HalfName {
    Development,
    Unseen,
}

fn main() -> anyhow::Result<()> {
    let arguments = Arguments::parse();
    let half = match arguments.half {
        HalfName::Development => Half::Development,
        HalfName::Unseen => Half::Unseen,
    };
    let Some((mut logs, unread)) = logs(half)? else {
        println!("skipped: ../shared/flights/real is not there");
        return Ok(());
    };
    if let Some(part) = &arguments.log {
        logs.retain(|log| log.name.contains(part));
    }
    let bar = ProgressBar::no_length()
        .with_message("trials on real tracks")
        .with_style(ProgressStyle::with_template("{msg} {spinner} {pos}")?);
    let done = || bar.inc(1);
    let said = |log: &Log| {
        let outcomes = of_log(log, &done);
        let mut lines = String::new();
        for outcome in outcomes.iter().filter(|_| !arguments.quiet) {
            lines.push_str(&line(outcome));
            lines.push('\n');
            if let (true, Ok(diagnosis)) = (arguments.verbose, &outcome.said) {
                lines.push_str(&pylon::diagnose::text(diagnosis, false));
            }
        }
        print!("{lines}");
        outcomes
    };
    let outcomes: Vec<Vec<Outcome>> = logs.par_iter().map(said).collect();
    bar.finish_and_clear();
    let outcomes: Vec<Outcome> = outcomes.into_iter().flatten().collect();
    for reason in &unread {
        println!("not read: {reason}");
    }
    let silent = outcomes.iter().filter(|outcome| outcome.said.is_err()).count();
    let longest_s = outcomes.iter().map(|outcome| outcome.took_s).fold(0.0, f64::max);
    println!(
        "{} logs ({} not read), {} flights diagnosed, {silent} refused; the longest took {longest_s:.1} s\n\n{}\n{}",
        logs.len(),
        unread.len(),
        outcomes.len() - silent,
        table(&outcomes),
        reliability(&outcomes)
    );
    Ok(())
}

fn line(outcome: &Outcome) -> String {
    let case = match outcome.case {
        Case::Plain => "plain".to_owned(),
        Case::Half(half) => format!("half {}", half + 1),
        Case::Null => "null".to_owned(),
        Case::Made(injection) => format!("made {} {:+.4}", injection.effect(), injection.coefficient()),
        Case::Added(injection) => format!("added {} {:+.4}", injection.effect(), injection.coefficient()),
    };
    let said = match &outcome.said {
        Err(reason) => format!("refused: {reason}"),
        Ok(diagnosis) => {
            let identified: Vec<String> = outcome
                .identified()
                .iter()
                .map(|effect| {
                    outcome.fitted(effect).map_or_else(
                        || (*effect).to_owned(),
                        |(coefficient, sigma)| format!("{effect} {coefficient:+.4}+-{sigma:.4}"),
                    )
                })
                .collect();
            let sets: Vec<String> =
                outcome.sets().iter().map(|set| format!("{{{}}}", set.join(" "))).collect();
            format!("{} {} {}", diagnosis.verdict.name(), identified.join(", "), sets.join(" "))
        }
    };
    format!("{:<46} {:>5.1} m {:>5.1} s {case:<36} => {said}", outcome.log, outcome.noise_m, outcome.took_s)
}
