//! `cargo xtask`: one command for every job in this checkout. `cargo xtask` alone lists them.

#[cfg(test)]
mod architecture;
mod bench;
mod blind;
mod board;
mod campaign;
mod child;
mod cli;
mod demo;
mod endurance;
mod hil;
mod improvement;
mod monitor_curves;
mod mutants;
mod packages;
#[path = "../../workbench/emulate/src/registry_paths.rs"]
mod registry_paths;
mod schemas;
mod setup;
mod site;
mod stages;
mod steps;
mod story;
mod table;
mod test_job;
mod test_programs;
mod test_report;
mod wasm;
#[cfg(test)]
mod wiring;
mod workspace;

use std::process::ExitCode;

use anyhow::bail;
use clap::{CommandFactory, Parser};

use cli::{Cli, Job};
use setup::{Need, Provided};

fn main() -> ExitCode {
    let Cli { job, verbose } = Cli::parse();
    let Some(job) = job else {
        return match Cli::command().print_help() {
            Ok(()) => ExitCode::SUCCESS,
            Err(_) => ExitCode::FAILURE,
        };
    };
    // A flight that could not be flown must be distinguishable from one whose bits differ.
    let failed = if matches!(job, Job::Hil(_)) { ExitCode::from(hil::NOT_FLOWN) } else { ExitCode::FAILURE };
    match run(job, verbose) {
        Ok(code) => code,
        Err(error) => {
            if let Some(child::Failure::Ended { output, .. }) = error.downcast_ref() {
                eprintln!("{}", output.all.trim_end());
            }
            eprintln!("error: {error:#}");
            failed
        }
    }
}

/// Runs the job and returns its exit status.
fn run(job: Job, verbose: bool) -> anyhow::Result<ExitCode> {
    match job {
        Job::Setup => set_up(verbose)?,
        Job::Demo => demo::run(verbose)?,
        Job::Test { words, list } => {
            let passed = test_job::run(&words, list, verbose)?;
            return Ok(if passed { ExitCode::SUCCESS } else { ExitCode::FAILURE });
        }
        Job::Site => {
            for need in [Need::Npm, Need::Wasm] {
                setup::provide(need, verbose)?;
            }
            println!("{}", site::build(verbose)?);
        }
        Job::Hil(arguments) => return hil::run(&arguments, verbose),
        Job::Bench { json, part } => bench::run(part, json, verbose)?,
        Job::Blind { trials, seed, family, fly_advice } => {
            blind::run(trials, seed, &family, fly_advice, verbose)?;
        }
        Job::Laws { trials, seed, beside, write } => blind::laws(trials, seed, beside, write, verbose)?,
        Job::RealTrials { half, write } => blind::real(&half, write, verbose)?,
        Job::MonitorCurves { seed } => monitor_curves::run(seed, verbose)?,
        Job::Baselines(arguments) => blind::baselines(&arguments, verbose)?,
        Job::Campaign(arguments) => {
            let is_kept = campaign::run(&arguments, verbose)?;
            return Ok(if is_kept { ExitCode::SUCCESS } else { ExitCode::FAILURE });
        }
        Job::Mutants { package, sample, seed } => mutants::run(&package, sample, seed, verbose)?,
        Job::Schemas => schemas::run(verbose)?,
        Job::Flash { model, barometer, probe } => board::flash(&model, barometer, probe.as_deref(), verbose)?,
        Job::Log { probe } => board::log(probe.as_deref(), verbose)?,
        Job::Endurance { hours, flights, seed } => endurance::run(hours, flights, seed, verbose)?,
        Job::Measure { command } => bench::measure::print(&command)?,
    }
    Ok(ExitCode::SUCCESS)
}

/// Installs everything that is missing before reporting any failure.
fn set_up(verbose: bool) -> anyhow::Result<()> {
    let mut missing = 0;
    for need in Need::ALL {
        match setup::provide(need, verbose) {
            Ok(Provided::Found(what)) => println!("{}: found, {what}", need.name()),
            Ok(Provided::Installed(what)) => println!("{}: installed, {what}", need.name()),
            Err(error) => {
                eprintln!("error: {error:#}");
                missing += 1;
            }
        }
    }
    if missing > 0 {
        bail!("{missing} of {} tools are missing", Need::ALL.len());
    }
    Ok(())
}
