//! `pylon discover`.

use std::io::Write as _;
use std::path::{Path, PathBuf};

use clap::Args;
use pylon::contained::contained;
use pylon::discover::{Discovery, discover, id, text, with_definition};
use pylon::output_file::prepare;
use pylon::plots::draw_laws;
use pylon::replay::GivenAirborne;

use super::failure::Failure;
use super::model_lock::lock_model;
use super::overwriting::{Role, refuse_overwriting};
use super::progress::Counter;
use super::study::StudyArguments;
use super::{load, terminal};

const EXAMPLES: &str = "\
Examples:
  pylon discover flight.csv
      laws over the recorded signals that explain what the default model and the catalogue leave unexplained, if any
  pylon discover monday.csv tuesday.csv --hold-out friday.csv --model ours.toml
      learn from two flights; a law that the third contradicts is not proposed
  pylon discover flight.csv --write ours.toml 1
      the first law becomes an [[effect_definition]] of ours.toml; continue with `pylon add`
  pylon discover flight.csv --plots pictures
      the measured error against the law, and the remainder against each of its signals, as SVG
  pylon discover flight.csv --json | jq .laws[0].regressor
      for other programs";

/// Search the recorded signals for a law where no catalogue effect explains the misfit
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    #[command(flatten)]
    study: StudyArguments,
    /// Make law N, as this command numbers it, an effect definition of this model file
    #[arg(long, num_args = 2, value_names = ["MODEL.toml", "N"])]
    write: Option<Vec<String>>,
    /// Id of the definition that `--write` makes [default: what it acts on and its signals]
    #[arg(long, value_name = "ID", requires = "write")]
    id: Option<String>,
    /// Draw every law into DIR (SVG): measured against law, and the remainder against each of its signals
    #[arg(long, value_name = "DIR")]
    plots: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let wanted = arguments.write.as_deref().map(target).transpose()?;
    let study = &arguments.study;
    let model = load::model(&study.model)?;
    let places = study.find()?;
    if let Some((file, _)) = wanted {
        let flights: Vec<_> = places.files().map(|flight| Role::new(flight, "a flight")).collect();
        refuse_overwriting(&flights, &[Role::new(file, "the model")])?;
        readable(file)?;
    }
    let flights = places.read(&model, study)?;
    let [learned, held] = flights.replays(&model)?;
    let mut counter = Counter::new("searching for laws", "fits");
    let found = contained(|| discover(&learned, &held, &mut || counter.step()));
    drop(counter);
    let mut discovery = found.map_err(|why| {
        Failure::input(format!(
            "the flights could not be searched because of a bug in pylon; please report it: {why}"
        ))
    })?;
    discovery.model.clone_from(&study.model);
    discovery.warnings.splice(0..0, flights.warnings());
    flights.write_left_out();
    if let Some(directory) = &arguments.plots {
        for file in draw_laws(directory, &discovery)? {
            // The paths of the figures are not part of the result.
            let _ = writeln!(std::io::stderr(), "drew {}", file.display());
        }
    }
    let written = wanted.map(|(file, number)| write(file, number, arguments, &discovery)).transpose()?;
    if arguments.json {
        terminal::put_json(&discovery)
    } else if let Some(written) = written {
        terminal::put(&written)
    } else {
        terminal::put(&text(&discovery, &command(study)))
    }
}

/// The file and the number after `--write`.
fn target(values: &[String]) -> Result<(&Path, usize), Failure> {
    match values {
        [file, number] => match number.parse() {
            Ok(number) if number > 0 => Ok((Path::new(file), number)),
            _ => Err(Failure::input(format!(
                "--write {file} {number}: expected the number of a law, such as 1, after the model"
            ))),
        },
        _ => Err(Failure::input("--write: expected a model file and the number of a law".to_owned())),
    }
}

fn readable(file: &Path) -> Result<String, Failure> {
    std::fs::read_to_string(file).map_err(|error| {
        let hint = if error.kind() == std::io::ErrorKind::NotFound {
            format!(" (an empty file is a model: touch {})", file.display())
        } else {
            String::new()
        };
        Failure::input(format!("{}: cannot be read: {error}{hint}", file.display()))
    })
}

/// Writes a law into a model file as an effect definition; returns a message that reports it.
fn write(
    file: &Path,
    number: usize,
    arguments: &Arguments,
    discovery: &Discovery,
) -> Result<String, Failure> {
    let law = discovery.laws.get(number - 1).ok_or_else(|| {
        let there = match discovery.laws.len() {
            0 => "no law is proposed".to_owned(),
            1 => "the only law is number 1".to_owned(),
            n => format!("the laws are 1 to {n}"),
        };
        Failure::input(format!("there is no law {number}: {there}; nothing was written"))
    })?;
    let id = arguments.id.clone().unwrap_or_else(|| id(law, &discovery.signals));
    let _lock = lock_model(file)?;
    let changed = with_definition(&readable(file)?, &id, law)
        .map_err(|error| Failure::input(format!("{}: {error}", file.display())))?;
    prepare(file, |out| out.write_all(changed.as_bytes()))?.publish()?;
    let flight = discovery.flights.first().map_or("FLIGHT", String::as_str);
    let model = file.display();
    Ok(format!(
        "{model} now defines {id}: {} += c * {}\n\nTo learn its coefficient and see the error fall:\n  pylon add {id} --model {model} --from {flight}\n",
        law.on, law.regressor
    ))
}

/// The command that was run, ready to paste.
fn command(arguments: &StudyArguments) -> String {
    let mut command = "pylon discover".to_owned();
    for flight in &arguments.flights {
        command += &format!(" {}", flight.display());
    }
    for flight in &arguments.hold_out {
        command += &format!(" --hold-out {}", flight.display());
    }
    if arguments.model != "default" {
        command += &format!(" --model {}", arguments.model);
    }
    if let Some(window) = arguments.times.calibrate {
        command += &format!(" --calibrate {}..{}", window.start_s, window.end_s);
    }
    if let Some(GivenAirborne { take_off_s, landing_s }) = arguments.times.airborne {
        let end = |time_s: Option<f64>| time_s.map_or_else(String::new, |time_s| time_s.to_string());
        command += &format!(" --airborne {}..{}", end(take_off_s), end(landing_s));
    }
    command
}
