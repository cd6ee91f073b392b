//! Commands, their arguments, and how errors are reported.
//!
//! Standard output carries the result, standard error the progress and one line for an error. Exit status 0:
//! it ran; 1: `fly` found bits that differ; 2: bad usage or bad input.

mod add;
mod compare;
mod diagnose;
mod discover;
mod effects;
mod export;
mod failure;
mod fly;
mod import;
mod ladder;
mod load;
mod model_lock;
mod one_flight;
mod open;
mod overwriting;
#[cfg(test)]
mod passes;
mod places;
mod plan;
mod progress;
mod report;
mod simulate;
mod studio;
mod study;
mod terminal;
mod times;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

use self::failure::Failure;

/// Calibrates a UAV's altitude sensors in captive flight, monitors them in free flight, and reports where the
/// model fails.
#[derive(Debug, Parser)]
#[command(name = "pylon", version, propagate_version = true, max_term_width = 100)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Simulate(simulate::Arguments),
    Open(open::Arguments),
    Import(import::Arguments),
    Export(export::Arguments),
    Compare(compare::Arguments),
    Diagnose(diagnose::Arguments),
    Discover(discover::Arguments),
    Plan(plan::Arguments),
    Effects(effects::Arguments),
    Add(add::Arguments),
    Ladder(ladder::Arguments),
    Fly(fly::Arguments),
    Report(report::Arguments),
    Studio(studio::Arguments),
}

/// Whether there was no argument at all: a user who types only the name wants to know what the program does.
fn is_bare(error: &clap::Error) -> bool {
    error.kind() == clap::error::ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand
}

/// Runs the command line.
pub fn main() -> ExitCode {
    let outcome = match Arguments::try_parse() {
        Ok(arguments) => match arguments.command {
            Command::Simulate(arguments) => simulate::run(&arguments),
            Command::Open(arguments) => open::run(&arguments),
            Command::Import(arguments) => import::run(&arguments),
            Command::Export(arguments) => export::run(&arguments),
            Command::Compare(arguments) => compare::run(&arguments),
            Command::Diagnose(arguments) => diagnose::run(&arguments),
            Command::Discover(arguments) => discover::run(&arguments),
            Command::Plan(arguments) => plan::run(&arguments),
            Command::Effects(arguments) => effects::run(&arguments),
            Command::Add(arguments) => add::run(&arguments),
            Command::Ladder(arguments) => ladder::run(&arguments),
            Command::Fly(arguments) => fly::run(&arguments),
            Command::Report(arguments) => report::run(&arguments),
            Command::Studio(arguments) => studio::run(&arguments),
        },
        Err(error) if error.use_stderr() && !is_bare(&error) => Err(Failure::usage(&error)),
        Err(help) => terminal::write(&help.render().ansi().to_string(), &help.render().to_string()),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.report(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory as _;

    #[test]
    fn arguments_are_consistent() {
        Arguments::command().debug_assert();
    }

    #[test]
    fn every_command_shows_an_example() {
        for command in Arguments::command().get_subcommands() {
            let help = command.clone().render_long_help().to_string();
            let example = format!("pylon {}", command.get_name());
            assert!(help.contains("Examples:") && help.contains(&example), "{help}");
        }
    }
}
