//! `pylon compare`.

use std::io::Write as _;
use std::path::PathBuf;

use clap::Args;
use pylon::compare::{Comparison, FIGURE_SLOTS, Options, RuleRequirements, Traces, compare, text};
use pylon::plots;
use pylon::replay::Replay;

use super::failure::Failure;
use super::one_flight::OneFlight;
use super::progress::Progress;
use super::{load, terminal};

const EXAMPLES: &str = "\
Examples:
  pylon compare flight.csv
      how well the default model agrees with the flight, sensor by sensor
  pylon compare flight.csv --model paper --plots pictures
      the paper's model, with its Figures 2 to 4 drawn for this flight
  pylon compare logger.csv --calibrate 60..180
      a flight without a launch column: calibrate on 60 s to 180 s
  pylon compare flight.csv --json | jq .sensors.baro
      for other programs";

/// Fly a model over a flight and show where it holds and where it fails
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    #[command(flatten)]
    what: OneFlight,
    /// Draw the paper's Figures 2, 3 and 4 for this flight into DIR (SVG)
    #[arg(long, value_name = "DIR")]
    plots: Option<PathBuf>,
    /// False-alarm rate of the recommended monitor rule, per hour
    #[arg(long, value_name = "PER_HOUR", default_value_t = RuleRequirements::default().false_alarms_per_hour, value_parser = positive)]
    false_alarms: f64,
    /// Step that a rule should detect, metres [default: 5 sigmas of the captive residual]
    #[arg(long, value_name = "METRES", value_parser = positive)]
    step: Option<f64>,
    /// Ramp that a rule should detect, m/s [default: 1 sigma of the captive residual in 10 s]
    #[arg(long, value_name = "M_PER_S", value_parser = positive)]
    ramp: Option<f64>,
}

fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && value > 0.0 => Ok(value),
        _ => Err("expected a positive number".to_owned()),
    }
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let model = load::model(&arguments.what.model)?;
    let (flight, notes) = load::flight(&arguments.what.flight)?;
    let in_flight = |error: &dyn std::fmt::Display| {
        Failure::input(format!("{}: {error}", arguments.what.flight.display()))
    };
    let replay =
        Replay::new(&flight, &model, arguments.what.times.given()).map_err(|error| in_flight(&error))?;
    let options = Options {
        trace_slots: arguments.plots.is_some().then_some(FIGURE_SLOTS),
        requirements: RuleRequirements {
            false_alarms_per_hour: arguments.false_alarms,
            step_m: arguments.step,
            ramp_mps: arguments.ramp,
        },
    };
    let mut progress = Progress::new("flying", flight.rows() as u64);
    let (mut comparison, traces) =
        compare(&replay, &options, &mut |rows| progress.show(rows)).map_err(|error| in_flight(&error))?;
    drop(progress);
    comparison.flight.file = arguments.what.flight.display().to_string();
    comparison.model.clone_from(&arguments.what.model);
    comparison.warnings.splice(0..0, notes.iter().map(ToString::to_string));
    let drawn = draw(arguments, &comparison, traces.as_deref())?;
    print(arguments, &comparison)?;
    // The paths of the figures are not part of the result.
    for file in drawn {
        let _ = writeln!(std::io::stderr(), "drew {}", file.display());
    }
    Ok(())
}

fn draw(
    arguments: &Arguments,
    comparison: &Comparison,
    traces: Option<&Traces>,
) -> Result<Vec<PathBuf>, Failure> {
    match (&arguments.plots, traces) {
        (Some(directory), Some(traces)) => Ok(plots::draw(directory, comparison, traces)?),
        _ => Ok(Vec::new()),
    }
}

fn print(arguments: &Arguments, comparison: &Comparison) -> Result<(), Failure> {
    if arguments.what.json {
        terminal::put_json(comparison)
    } else {
        terminal::put_coloured(&text(comparison, terminal::has_colour()))
    }
}
