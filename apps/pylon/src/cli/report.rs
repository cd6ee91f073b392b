//! `pylon report`.

use std::path::{Path, PathBuf};
use std::sync::Mutex;

use clap::Args;
use pylon::batch::{self, Batch};
use pylon::compare::Options;
use pylon::contained::{Panicked, contained};
use pylon::diagnose::{NamedReplay, diagnose};
use pylon::flight::Note;
use pylon::learn::NamedFlight;
use pylon::output_file::write_atomically;
use pylon::replay::Replay;
use pylon::report::{FlightReport, Report, TRACE_SLOTS, file_name, keep_most_telling};
use pylon::results::{ReportResult, VERSION};
use pylon::survey::Survey;

use super::failure::Failure;
use super::overwriting::{Role, refuse_overwriting};
use super::places::Places;
use super::progress::{Counter, Progress};
use super::times::TimesArguments;
use super::{load, terminal};

const EXAMPLES: &str = "\
Examples:
  pylon report flight.csv -o report.html
      how well the default model agrees with the flight, as a page
  pylon report first.csv second.csv --model my-uav.toml -o report.html
      several flights, and how the model got where it is
  pylon report first.csv --hold-out second.csv -o report.html
      what the model lacks, evaluated on a flight it was not learned from
  pylon report logger.igc --calibrate 60..180 -o report.html
      a log without a launch column";

/// Write a page about flights: zoomable charts, where the model fails and what it may be missing
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// The flights: flight CSVs, logs that `pylon import` reads, or folders of them
    #[arg(value_name = "FLIGHT", required = true)]
    flights: Vec<PathBuf>,
    /// The model: a TOML file, `default` or `paper`
    #[arg(long, value_name = "MODEL", default_value = "default")]
    model: String,
    #[command(flatten)]
    times: TimesArguments,
    /// Evaluate missing effects on this flight instead of on held-out manoeuvres (may be repeated)
    #[arg(long, value_name = "FLIGHT")]
    hold_out: Vec<PathBuf>,
    /// Fail if one flight cannot be used, instead of skipping and naming it
    #[arg(long)]
    strict: bool,
    /// The page to write: one self-contained HTML file
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Print JSON: the page's file and size
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let [given, held_files] = [Places::find(&arguments.flights)?, Places::find(&arguments.hold_out)?];
    let flights = given.files.iter().chain(&held_files.files);
    let model = Role::new(Path::new(&arguments.model), "the model");
    let inputs: Vec<_> = flights.map(|flight| Role::new(flight, "a flight")).chain([model]).collect();
    refuse_overwriting(&inputs, &[Role::new(&arguments.output, "the page")])?;
    let model = load::model(&arguments.model)?;
    let times = arguments.times.given();
    load::refuse_repeats(&given.files, &held_files.files)?;
    let batch = load::Batch::read(&given.files, arguments.strict, |flight| {
        Replay::new(flight, &model, times).map(|_| ())
    })?;
    let held = load::Batch::read(&held_files.files, arguments.strict, |flight| {
        Replay::calibrated_or_not(flight, &model, times).map(|_| ())
    })?;
    let learned_from = by_name(load::replays(&batch.files, &batch.flights, &model, times)?);
    // A diagnosis needs no quiet period to calibrate in.
    let to_diagnose = by_name(load::replays_to_diagnose(&batch.files, &batch.flights, &model, times)?);
    let to_judge = by_name(load::replays_to_diagnose(&held.files, &held.flights, &model, times)?);
    let [learned_flights, held_flights] = [&batch, &held].map(|batch| {
        let mut named = load::named(&batch.files, &batch.flights, times);
        named.iter_mut().for_each(|named| named.file = file_name(&named.file));
        named
    });
    let model_name = file_name(&arguments.model);
    let mut survey = Survey::new(&model);
    let mut flights = Vec::with_capacity(batch.files.len());
    let mut without = Vec::new();
    let each = learned_from.iter().zip(&learned_flights).zip(&to_diagnose).zip(&batch.flights);
    for (index, (((named, unread), diagnosed), (_, notes))) in each.enumerate() {
        let asked = Asked { index, named, flight: unread, diagnosed, notes, model: &model_name };
        match contained(|| flight(&asked, &mut survey)) {
            Ok(found) => flights.push(found?),
            Err(why) if learned_from.len() > 1 && !arguments.strict => {
                without.push(defect(&named.file, &why))
            }
            Err(why) => return Err(Failure::input(defect(&named.file, &why))),
        }
    }
    for (flight, judging) in held_flights.iter().zip(&to_judge) {
        survey.hold_out(flight, &model, judging);
    }
    let mut counter = Counter::new("diagnosing", "fits");
    let mut diagnosis = diagnose(&to_diagnose, &to_judge, &mut || counter.step());
    drop(counter);
    diagnosis.model.clone_from(&model_name);
    diagnosis.warnings.append(&mut without);
    let one_by_one = (to_diagnose.len() > 1).then(|| {
        let counter = Mutex::new(Counter::new("diagnosing one by one", "flights"));
        batch::batch(&to_diagnose, Some(&diagnosis), &|| {
            if let Ok(mut counter) = counter.lock() {
                counter.step();
            }
        })
    });
    keep_most_telling(&mut flights, &one_by_one.iter().flat_map(Batch::odd_files).collect::<Vec<_>>());
    let all = [learned_flights, held_flights].concat();
    let mut progress =
        Progress::new("flying every revision", (model.revisions.len() as u64 + 1) * all.len() as u64);
    let mut ladder = survey
        .ladder(&model, &all, &mut |done| progress.show(done))
        .map_err(|error| Failure::input(error.to_string()))?;
    drop(progress);
    ladder.model.clone_from(&model_name);
    let report = Report {
        flights: &flights,
        model: &model,
        model_name: &model_name,
        diagnosis: &diagnosis,
        ladder: &ladder,
        batch: one_by_one.as_ref(),
    };
    let html = report.html();
    write_atomically(&arguments.output, |out| out.write_all(html.as_bytes()))?;
    given.write_notes();
    held_files.write_notes();
    batch.write_skipped();
    held.write_skipped();
    if arguments.json {
        return terminal::put_json(&ReportResult {
            version: VERSION,
            file: arguments.output.display().to_string(),
            flights: flights.len(),
            size_bytes: html.len(),
        });
    }
    let (count, size) = (flights.len(), html.len() as f64 / 1e6);
    let flights = if count == 1 { "1 flight".to_owned() } else { format!("{count} flights") };
    terminal::put(&format!("{}: {flights}, {size:.1} MB\n", arguments.output.display()))
}

/// Renames the flights to their files' names without folders, as the page shows them.
fn by_name(mut named: Vec<NamedReplay<'_>>) -> Vec<NamedReplay<'_>> {
    named.iter_mut().for_each(|named| named.file = file_name(&named.file));
    named
}

fn defect(file: &str, why: &Panicked) -> String {
    format!("{file}: not drawn because of a bug in pylon; please report it: {why}")
}

/// A flight to report on: as read, replayed and diagnosed.
struct Asked<'f, 'a> {
    /// Its position in the page, from 0.
    index: usize,
    named: &'f NamedReplay<'a>,
    flight: &'f NamedFlight<'a>,
    diagnosed: &'f NamedReplay<'a>,
    notes: &'f [Note],
    /// The model's name.
    model: &'f str,
}

fn flight<'a>(asked: &Asked<'_, 'a>, survey: &mut Survey<'a>) -> Result<FlightReport, Failure> {
    let Asked { named: NamedReplay { file, replay, .. }, .. } = asked;
    let in_flight = |error: &dyn std::fmt::Display| Failure::input(format!("{file}: {error}"));
    let mut progress = Progress::new("flying", replay.flight().rows() as u64);
    let options = Options { trace_slots: Some(TRACE_SLOTS), ..Options::default() };
    let (mut comparison, traces) = survey
        .compare(asked.flight, replay, asked.diagnosed, &options, &mut |rows| progress.show(rows))
        .map_err(|error| in_flight(&error))?;
    comparison.flight.file.clone_from(file);
    asked.model.clone_into(&mut comparison.model);
    comparison.warnings.splice(0..0, asked.notes.iter().map(ToString::to_string));
    let traces = traces.ok_or_else(|| in_flight(&"its comparison kept no traces"))?;
    Ok(FlightReport::new(asked.index, replay, comparison, &traces))
}
