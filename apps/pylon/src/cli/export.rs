//! `pylon export`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use pylon::export::{mcap, parquet, plain_csv};
use pylon::flight;
use pylon::output_file::write_atomically;
use pylon::results::{ExportResult, VERSION};

use super::failure::Failure;
use super::load;
use super::overwriting::{Role, refuse_overwriting};
use super::progress::while_busy;
use super::terminal;

const EXAMPLES: &str = "\
Examples:
  pylon export flight.csv --format mcap -o flight.mcap
      for Foxglove Studio: one topic per device, JSON messages
  pylon export flight.csv --format parquet -o flight.parquet
      for pandas, polars and DuckDB: one row group, with column units in the file's metadata
  pylon export flight.csv --format plain-csv -o plain.csv
      for PlotJuggler and spreadsheets: names in the first line, time_s first, nothing else
  pylon export logger.igc --format csv -o flight.csv
      any log that `import` reads, as a flight CSV";

/// Convert a flight to another program's format
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// The flight: a flight's CSV, or a log that `pylon import` reads
    #[arg(value_name = "FLIGHT")]
    flight: PathBuf,
    /// The format
    #[arg(long, value_enum)]
    format: Format,
    /// The file to write
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Format {
    /// A flight's CSV
    Csv,
    /// MCAP, for Foxglove Studio and ROS tools
    Mcap,
    /// Apache Parquet, for pandas, polars and DuckDB
    Parquet,
    /// CSV without header lines, for PlotJuggler and spreadsheets
    PlainCsv,
}

impl Format {
    /// As `--format` takes it.
    const fn name(self) -> &'static str {
        match self {
            Self::Csv => "csv",
            Self::Mcap => "mcap",
            Self::Parquet => "parquet",
            Self::PlainCsv => "plain-csv",
        }
    }
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    refuse_overwriting(
        &[Role::new(&arguments.flight, "the flight")],
        &[Role::new(&arguments.output, "the export")],
    )?;
    let (flight, notes) = load::flight(&arguments.flight)?;
    let file = arguments.output.display();
    let mut result = ExportResult {
        version: VERSION,
        file: file.to_string(),
        format: arguments.format.name().into(),
        rows: flight.rows() as u64,
        columns: None,
        messages: None,
        topics: None,
        notes: notes.iter().map(ToString::to_string).collect(),
    };
    let line = match arguments.format {
        Format::Csv => {
            while_busy("writing", || flight::write(&arguments.output, &flight))?;
            format!("{file}: {} rows\n", flight.rows())
        }
        Format::PlainCsv => {
            while_busy("writing", || {
                write_atomically(&arguments.output, |out| plain_csv::write(out, &flight))
            })?;
            format!("{file}: {} rows\n", flight.rows())
        }
        Format::Parquet => {
            let mut columns = 0;
            while_busy("writing", || {
                write_atomically(&arguments.output, |out| {
                    columns = parquet::write(out, &flight)?;
                    Ok(())
                })
            })?;
            result.columns = Some(columns);
            format!("{file}: {} rows of {columns} columns\n", flight.rows())
        }
        Format::Mcap => {
            let mut summary = mcap::McapSummary::default();
            while_busy("writing", || {
                write_atomically(&arguments.output, |out| {
                    summary = mcap::write(out, &flight)?;
                    Ok(())
                })
            })?;
            (result.messages, result.topics) = (Some(summary.messages), Some(summary.topics));
            format!("{file}: {} messages on {} topics\n", summary.messages, summary.topics)
        }
    };
    load::write_notes(&notes);
    if arguments.json { terminal::put_json(&result) } else { terminal::put(&line) }
}
