//! What a command that flies one flight is told.

use std::path::PathBuf;

use clap::Args;
use pylon::replay::CalibrationWindow;

/// A flight, the model to fly over it, and how to print what came out.
#[derive(Debug, Args)]
pub struct OneFlight {
    /// The flight: a flight's CSV, or a log that `pylon import` reads
    #[arg(value_name = "FLIGHT")]
    pub flight: PathBuf,
    /// The model: a TOML file, `default` or `paper`
    #[arg(long, value_name = "MODEL", default_value = "default")]
    pub model: String,
    /// Calibrate on this part of the flight (seconds of the flight's own clock, as `pylon open` shows it: an imported log's begins with its first record) and say launch at its end
    #[arg(long, value_name = "START..END")]
    pub calibrate: Option<CalibrationWindow>,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}
