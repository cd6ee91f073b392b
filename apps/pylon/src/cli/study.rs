//! The inputs of a study: flights to learn from, flights to evaluate on, and the model to test against them.

use std::path::PathBuf;

use clap::Args;
use model::Model;
use pylon::diagnose::NamedReplay;
use pylon::flight::Flight;
use pylon::replay::{GivenTimes, Replay};

use super::failure::Failure;
use super::load::{self, Batch};
use super::places::Places;
use super::times::TimesArguments;

/// The common arguments of `diagnose` and `discover`.
#[derive(Debug, Args)]
pub struct StudyArguments {
    /// Flights to learn from: flight CSVs, logs that `pylon import` reads, or folders of them
    #[arg(value_name = "FLIGHT", required = true)]
    pub flights: Vec<PathBuf>,
    /// The model: a TOML file, `default` or `paper`
    #[arg(long, value_name = "MODEL", default_value = "default")]
    pub model: String,
    /// Evaluate on this flight instead of on held-out manoeuvres (may be repeated)
    #[arg(long, value_name = "FLIGHT")]
    pub hold_out: Vec<PathBuf>,
    #[command(flatten)]
    pub times: TimesArguments,
    /// Fail if one flight cannot be used, instead of skipping and naming it
    #[arg(long)]
    pub strict: bool,
}

impl StudyArguments {
    /// Resolves the arguments to files; refuses a flight that is given twice.
    pub fn find(&self) -> Result<StudyPlaces, Failure> {
        let places =
            StudyPlaces { learned: Places::find(&self.flights)?, held: Places::find(&self.hold_out)? };
        load::refuse_repeats(&places.learned.files, &places.held.files)?;
        Ok(places)
    }
}

/// The files of a study.
pub struct StudyPlaces {
    learned: Places,
    held: Places,
}

impl StudyPlaces {
    /// Every flight's file.
    pub fn files(&self) -> impl Iterator<Item = &PathBuf> {
        self.learned.files.iter().chain(&self.held.files)
    }

    /// Reads the flights that can be used with this model.
    pub fn read(self, model: &Model, arguments: &StudyArguments) -> Result<StudyFlights, Failure> {
        let is_usable =
            |flight: &Flight| Replay::calibrated_or_not(flight, model, arguments.times.given()).map(|_| ());
        Ok(StudyFlights {
            learned: Batch::read(&self.learned.files, arguments.strict, is_usable)?,
            held: Batch::read(&self.held.files, arguments.strict, is_usable)?,
            given: arguments.times.given(),
            places: self,
        })
    }
}

/// The flights of a study, as read.
pub struct StudyFlights {
    places: StudyPlaces,
    learned: Batch,
    held: Batch,
    given: GivenTimes,
}

impl StudyFlights {
    /// The flights to learn from, and those to evaluate on.
    pub fn replays(&self, model: &Model) -> Result<[Vec<NamedReplay<'_>>; 2], Failure> {
        Ok([self.replays_of(&self.learned, model)?, self.replays_of(&self.held, model)?])
    }

    /// The flights to learn from.
    pub fn learned(&self) -> impl Iterator<Item = &Flight> {
        self.learned.flights.iter().map(|(flight, _)| flight)
    }

    fn replays_of<'a>(&self, batch: &'a Batch, model: &Model) -> Result<Vec<NamedReplay<'a>>, Failure> {
        load::replays_to_diagnose(&batch.files, &batch.flights, model, self.given)
    }

    /// Notes on the logs, each with its file.
    pub fn warnings(&self) -> Vec<String> {
        let of = |batch: &Batch| -> Vec<String> {
            let pairs = batch.files.iter().zip(&batch.flights);
            pairs
                .flat_map(|(file, (_, notes))| notes.iter().map(|note| format!("{}: {note}", file.display())))
                .collect()
        };
        [of(&self.learned), of(&self.held)].concat()
    }

    /// Prints to standard error what was left out of folders, and which flights were skipped.
    pub fn write_left_out(&self) {
        self.places.learned.write_notes();
        self.places.held.write_notes();
        self.learned.write_skipped();
        self.held.write_skipped();
    }
}
