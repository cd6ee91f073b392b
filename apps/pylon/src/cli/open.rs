//! `pylon open`.

use std::path::PathBuf;

use clap::Args;
use pylon::import;
use pylon::overview::{Overview, text};

use super::failure::Failure;
use super::times::TimesArguments;
use super::{load, terminal};

const EXAMPLES: &str = "\
Examples:
  pylon open log_12_2024-05-01.ulg
      what is in a log: take-off, landing, sensors, which part is analysed, and what to do next
  pylon open 00000042.BIN --json | jq '[.take_off_s, .landing_s]'
      for other programs";

/// Show what a log contains: take-off, landing, sensors, and which part is used
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// The log: any that `pylon import` reads, or a flight CSV
    #[arg(value_name = "LOG")]
    log: PathBuf,
    #[command(flatten)]
    times: TimesArguments,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let (flight, notes) = load::flight(&arguments.log)?;
    let format = import::format_name(&arguments.log)?;
    let file = arguments.log.display().to_string();
    let overview = Overview::new(&file, format, &flight, &notes, arguments.times.given());
    if arguments.json { terminal::put_json(&overview) } else { terminal::put(&text(&overview)) }
}
