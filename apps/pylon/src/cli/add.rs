//! `pylon add`.

use std::fs;
use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use kf_core::effect::{Clock, EffectId};
use model::Model;
use pylon::diagnose::WantedEffect;
use pylon::flight::Flight;
use pylon::learn::{Addition, Request, add, addition_text};
use pylon::output_file::prepare;
use pylon::replay::{Replay, ReplayError, missing_columns};
use thiserror::Error;
use time::{Date, OffsetDateTime};

use super::failure::Failure;
use super::model_lock::{ModelLock, lock_model};
use super::overwriting::{Role, refuse_overwriting};
use super::places::Places;
use super::progress::Counter;
use super::times::TimesArguments;
use super::{load, terminal};

const EXAMPLES: &str = "\
Examples:
  touch ours.toml
  pylon add baro.dynamic_pressure --model ours.toml --from monday.csv --hold-out friday.csv
      learn the coefficient from one flight, evaluate it on another, write it into the model
  pylon add baro.lag --model ours.toml --from monday.csv tuesday.csv --estimate
      the coefficient becomes a state of the filter, with the learned value as its prior
  pylon add baro.lag --model ours.toml --from logs/
      from every log of a folder; those that cannot be used are skipped and named
  pylon add baro.warm_up --model default --from monday.csv --time-constant 120 --since start -o ours.toml
      start from a preset and write another file
  pylon add baro.lag --model ours.toml --from monday.csv --json | jq '[.rms_before_m, .rms_after_m]'
      for other programs";

/// Learn an effect's coefficient and write it into a model
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// The effect's id, as `pylon diagnose` names it: from the catalogue, or from the model's own
    /// [[effect_definition]]s. A lag or latency that acts as a low pass is written as one, defined in the model
    #[arg(value_name = "EFFECT")]
    effect: String,
    /// The model file to change (an empty file is a model); with -o also `default` or `paper`
    #[arg(long, value_name = "MODEL")]
    model: String,
    /// Flights to learn from: flight CSVs, logs that `pylon import` reads, or folders of them
    #[arg(long, value_name = "FLIGHT", required = true, num_args = 1..)]
    from: Vec<PathBuf>,
    /// Evaluate on these flights instead of on held-out manoeuvres
    #[arg(long, value_name = "FLIGHT", num_args = 1..)]
    hold_out: Vec<PathBuf>,
    /// Make the coefficient a state of the filter rather than a constant
    #[arg(long)]
    estimate: bool,
    /// Time constant of the effect, seconds [default: the best of a grid]
    #[arg(long, value_name = "SECONDS", value_parser = time_constant)]
    time_constant: Option<f32>,
    /// Start of the clock for an effect with a time constant [default: whichever fits best]
    #[arg(long, value_name = "WHEN")]
    since: Option<Since>,
    /// Write the effect despite the concerns raised
    #[arg(long)]
    force: bool,
    /// Write this file instead of the model's own
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    #[command(flatten)]
    times: TimesArguments,
    /// Fail if a flight to learn from cannot be used, instead of skipping and naming it
    #[arg(long)]
    strict: bool,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Start of a clock.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum Since {
    /// From launch
    Launch,
    /// From the first tick
    Start,
}

fn time_constant(text: &str) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(value) if value.is_finite() && value > 0.0 => Ok(value),
        _ => Err("expected seconds above 0".to_owned()),
    }
}

/// Why an effect cannot be learned from a flight.
#[derive(Debug, Error)]
enum NotUsable {
    /// The effect's regressor needs columns that the flight does not have.
    #[error("{effect} can't be learned, the flight has no {lacking}")]
    Lacks {
        /// The effect.
        effect: &'static str,
        /// The columns, with commas between them.
        lacking: String,
    },
    /// The flight cannot be replayed.
    #[error(transparent)]
    Replay(#[from] ReplayError),
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let [given, held_files] = [Places::find(&arguments.from)?, Places::find(&arguments.hold_out)?];
    let flights = given.files.iter().chain(&held_files.files);
    let flights: Vec<_> = flights.map(|flight| Role::new(flight, "a flight")).collect();
    let is_preset = Model::preset(&arguments.model).is_some();
    // No other program may change the model between this read and the write.
    let _lock = if is_preset { None } else { locked(&arguments.model)? };
    let (text, output, before) = model(arguments)?;
    let effect = effect(arguments, &before)?;
    refuse_overwriting(&flights, &[Role::new(&output, "the model")])?;
    let date = today()?;
    load::refuse_repeats(&given.files, &held_files.files)?;
    let times = arguments.times.given();
    let is_usable = |flight: &Flight| {
        let lacking = missing_columns(flight, effect);
        if !lacking.is_empty() {
            return Err(NotUsable::Lacks { effect: effect.name(), lacking: lacking.join(", ") });
        }
        Ok(Replay::calibrated_or_not(flight, &before, times).map(|_| ())?)
    };
    let [batch, held_out] =
        [&given.files, &held_files.files].map(|files| load::Batch::read(files, arguments.strict, is_usable));
    let (batch, held_out) = (batch?, held_out?);
    given.write_notes();
    held_files.write_notes();
    batch.write_skipped();
    held_out.write_skipped();
    for load::Batch { files, flights, .. } in [&batch, &held_out] {
        load::write_unused(&load::replays_to_diagnose(files, flights, &before, times)?);
    }
    let request = Request {
        text: &text,
        wanted: WantedEffect {
            effect,
            time_constant_s: arguments.time_constant,
            since: arguments.since.map(|since| match since {
                Since::Launch => Clock::Launch,
                Since::Start => Clock::Start,
            }),
        },
        estimate: arguments.estimate,
        date,
        learning: load::named(&batch.files, &batch.flights, times),
        held_out: load::named(&held_out.files, &held_out.flights, times),
    };
    let mut counter = Counter::new("learning", "fits and flights");
    let addition = add(&request, &mut || counter.step());
    drop(counter);
    let addition = addition?;
    if !addition.concerns.is_empty() && !arguments.force {
        return Err(refused(&addition));
    }
    // The result is printed before the model gets its name: if printing fails, nothing was changed.
    let written = prepare(&output, |out| out.write_all(addition.text.as_bytes()))?;
    if arguments.json {
        terminal::put_json(&addition)?;
    } else {
        terminal::put(&addition_text(&addition, &output.display().to_string()))?;
    }
    if is_preset {
        written.publish_new()?;
    } else {
        written.publish()?;
    }
    Ok(())
}

/// Locks the model; `None` if there is no such file, which is reported elsewhere.
fn locked(model: &str) -> Result<Option<ModelLock>, Failure> {
    let path = Path::new(model);
    if path.is_file() { lock_model(path).map(Some) } else { Ok(None) }
}

/// The effect, checked to support the options given for it.
fn effect(arguments: &Arguments, model: &Model) -> Result<EffectId, Failure> {
    let name = &arguments.effect;
    let effect = model.effect_named(name).ok_or_else(|| {
        let nearest = model.nearest_effects(name);
        let place =
            if model.definitions().is_empty() { "the catalogue" } else { "the catalogue or the model" };
        Failure::input(format!("no effect '{name}' in {place}; nearest: {nearest}"))
    })?;
    let wants_time = arguments.time_constant.is_some() || arguments.since.is_some();
    if wants_time && !effect.has_time_constant() {
        let message = "has no time constant: leave --time-constant and --since out";
        return Err(Failure::input(format!("{name} {message}")));
    }
    Ok(effect)
}

/// The model's text, the file to write, and the parsed model.
fn model(arguments: &Arguments) -> Result<(String, PathBuf, Model), Failure> {
    let name = &arguments.model;
    if let Some(preset) = Model::preset(name) {
        let output = arguments.output.clone().ok_or_else(|| {
            Failure::input(format!(
                "{name} is a preset and can't be changed; write to another file with -o ours.toml"
            ))
        })?;
        if output.exists() {
            let message =
                "already exists and would be overwritten; pass it as --model, or choose another name for -o";
            return Err(Failure::input(format!("{}: {message}", output.display())));
        }
        let text = if name == "paper" { include_str!("../../../../flights/models/paper.toml") } else { "" };
        return Ok((text.to_owned(), output, preset));
    }
    let text = fs::read_to_string(name).map_err(|error| {
        let hint = if error.kind() == std::io::ErrorKind::NotFound {
            format!(" (an empty file is a model: touch {name}, or --model default -o {name})")
        } else {
            String::new()
        };
        Failure::input(format!("{name}: cannot be read: {error}{hint}"))
    })?;
    // Read from the file again, so that errors name it.
    let before = load::model(name)?;
    Ok((text, arguments.output.clone().unwrap_or_else(|| PathBuf::from(name)), before))
}

/// Today in UTC; `SOURCE_DATE_EPOCH` takes precedence
/// (<https://reproducible-builds.org/specs/source-date-epoch/>).
fn today() -> Result<Date, Failure> {
    let Some(epoch) = std::env::var_os("SOURCE_DATE_EPOCH") else {
        return Ok(OffsetDateTime::now_utc().date());
    };
    let seconds = epoch.to_str().and_then(|text| text.parse::<i64>().ok());
    let time = seconds.and_then(|seconds| OffsetDateTime::from_unix_timestamp(seconds).ok());
    time.map(OffsetDateTime::date).ok_or_else(|| {
        let epoch = epoch.display();
        Failure::input(format!("SOURCE_DATE_EPOCH is '{epoch}', expected seconds since 1970-01-01"))
    })
}

fn refused(addition: &Addition) -> Failure {
    Failure::input(format!(
        "{} was not added: {}; nothing was written (--force writes it anyway)",
        addition.effect,
        addition.concerns.join("; ")
    ))
}
