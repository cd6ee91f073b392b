//! Arguments of the commands that fly one flight.

use std::path::PathBuf;

use clap::Args;

use super::times::TimesArguments;

/// A flight, the model to fly over it, and the output format.
#[derive(Debug, Args)]
pub struct OneFlight {
    /// The flight: a flight's CSV, or a log that `pylon import` reads
    #[arg(value_name = "FLIGHT")]
    pub flight: PathBuf,
    /// The model: a TOML file, `default` or `paper`
    #[arg(long, value_name = "MODEL", default_value = "default")]
    pub model: String,
    #[command(flatten)]
    pub times: TimesArguments,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}
