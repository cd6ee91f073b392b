//! `pylon report`.

use std::path::PathBuf;

use clap::Args;
use pylon::compare::{Options, compare};
use pylon::output_file::write_atomically;
use pylon::replay::{CalibrationWindow, Replay};
use pylon::report::{FlightReport, Report};

use super::failure::Failure;
use super::progress::Progress;
use super::{load, terminal};

const EXAMPLES: &str = "\
Examples:
  pylon report flight.csv -o report.html
      how well the default model agrees with the flight, as a page to look at
  pylon report first.csv second.csv --model my-uav.toml -o report.html
      several flights, and how the model got where it is
  pylon report logger.igc --calibrate 60..180 -o report.html
      a log that does not say when the UAV was launched";

/// Write a page about flights: figures to zoom into, where the model fails and what may be missing
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// The flights: flights' CSV, or logs that `pylon import` reads
    #[arg(value_name = "FLIGHT", required = true)]
    flights: Vec<PathBuf>,
    /// The model: a TOML file, `default` or `paper`
    #[arg(long, value_name = "MODEL", default_value = "default")]
    model: String,
    /// Calibrate on this part of every flight (seconds by its own time) and say launch at its end
    #[arg(long, value_name = "START..END")]
    calibrate: Option<CalibrationWindow>,
    /// The page to write: one HTML file, with everything in it
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let model = load::model(&arguments.model)?;
    let mut flights = Vec::with_capacity(arguments.flights.len());
    for (index, file) in arguments.flights.iter().enumerate() {
        let (flight, notes) = load::flight(file)?;
        let in_flight =
            |error: &dyn std::fmt::Display| Failure::input(format!("{}: {error}", file.display()));
        let replay = Replay::new(&flight, &model, arguments.calibrate).map_err(|error| in_flight(&error))?;
        let mut progress = Progress::new("flying", flight.rows() as u64);
        let (mut comparison, _) = compare(&replay, &Options::default(), &mut |rows| progress.show(rows))
            .map_err(|error| in_flight(&error))?;
        comparison.flight.file = file.display().to_string();
        comparison.model.clone_from(&arguments.model);
        comparison.warnings.splice(0..0, notes.iter().map(ToString::to_string));
        flights.push(FlightReport::new(index, &replay, comparison).map_err(|error| in_flight(&error))?);
    }
    let html = Report { flights: &flights, model: &model, model_name: &arguments.model }.html();
    write_atomically(&arguments.output, |out| out.write_all(html.as_bytes()))?;
    let (count, size) = (flights.len(), html.len() as f64 / 1e6);
    let flights = if count == 1 { "1 flight".to_owned() } else { format!("{count} flights") };
    terminal::put(&format!("{}: {flights}, {size:.1} MB\n", arguments.output.display()))
}
