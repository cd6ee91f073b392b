//! Loads the flights and models that the user named.

use std::collections::BTreeSet;
use std::error::Error;
use std::fmt::Display;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use model::Model;
use pylon::contained::contained;
use pylon::diagnose::NamedReplay;
use pylon::flight::{Flight, Note};
use pylon::import;
use pylon::learn::NamedFlight;
use pylon::replay::{GivenTimes, Replay, ReplayError, Usage};
use view::text::printable;

use super::failure::Failure;
use super::progress::while_busy;

/// Reads a flight from its CSV or from any log that can be imported, with notes on it.
pub fn flight(file: &Path) -> Result<(Flight, Vec<Note>), Failure> {
    Ok(while_busy("reading", || import::open(file))?)
}

/// Refuses a flight that is given twice: learned from twice it would count double, and once learned from it
/// is not held out.
pub fn refuse_repeats(learned: &[PathBuf], held: &[PathBuf]) -> Result<(), Failure> {
    let same = |file: &PathBuf| file.canonicalize().unwrap_or_else(|_| file.clone());
    let mut seen = BTreeSet::new();
    for file in learned {
        if !seen.insert(same(file)) {
            return Err(Failure::input(format!(
                "{}: given twice; expected different flights",
                file.display()
            )));
        }
    }
    for file in held {
        if !seen.insert(same(file)) {
            let message = "is already used for learning or held out; hold out a different flight";
            return Err(Failure::input(format!("{}: {message}", file.display())));
        }
    }
    Ok(())
}

/// A flight as read, and notes on it.
pub type Read = (Flight, Vec<Note>);

/// The usable ones of several flights.
pub struct Batch {
    /// Files of the flights.
    pub files: Vec<PathBuf>,
    /// The flights, in the files' order.
    pub flights: Vec<Read>,
    /// Why each of the others was skipped.
    skipped: Vec<Failure>,
}

impl Batch {
    /// Reads flights from files. One that cannot be read, or that `is_usable` refuses, is skipped, unless it
    /// is the only one or all must be usable (`strict`).
    pub fn read<E: Error>(
        files: &[PathBuf],
        strict: bool,
        is_usable: impl Fn(&Flight) -> Result<(), E>,
    ) -> Result<Self, Failure> {
        let mut batch = Self { files: Vec::new(), flights: Vec::new(), skipped: Vec::new() };
        for file in files {
            let usable = contained(|| {
                flight(file).and_then(|read| match is_usable(&read.0) {
                    Ok(()) => Ok(read),
                    Err(error) => Err(Failure::input(format!("{}: {error}", file.display()))),
                })
            });
            let usable = usable.unwrap_or_else(|why| {
                Err(Failure::input(format!(
                    "{}: not read because of a bug in pylon; please report it: {why}",
                    file.display()
                )))
            });
            match usable {
                Ok(read) => {
                    batch.files.push(file.clone());
                    batch.flights.push(read);
                }
                Err(failure) if strict || files.len() == 1 => return Err(failure),
                Err(failure) => batch.skipped.push(failure),
            }
        }
        if batch.files.is_empty() && !batch.skipped.is_empty() {
            return Err(batch.skipped.swap_remove(0));
        }
        Ok(batch)
    }

    /// Prints to standard error which flights were skipped, and why.
    pub fn write_skipped(&self) {
        if self.skipped.is_empty() {
            return;
        }
        let all = self.files.len() + self.skipped.len();
        let mut text = format!("skipped {} of {all} flights (--strict fails instead):\n", self.skipped.len());
        for why in &self.skipped {
            text += &format!("  {}\n", why.message());
        }
        // If standard error is closed, there is nowhere to report this.
        let _ = write!(std::io::stderr(), "{text}");
    }
}

/// Replays of these flights with a model, each under its file's name.
pub fn replays<'a>(
    files: &[PathBuf],
    flights: &'a [Read],
    model: &Model,
    given: GivenTimes,
) -> Result<Vec<NamedReplay<'a>>, Failure> {
    replays_by(files, flights, |flight| Replay::new(flight, model, given))
}

/// As [`replays`], for a diagnosis, which estimates the biases along with everything else.
pub fn replays_to_diagnose<'a>(
    files: &[PathBuf],
    flights: &'a [Read],
    model: &Model,
    given: GivenTimes,
) -> Result<Vec<NamedReplay<'a>>, Failure> {
    replays_by(files, flights, |flight| Replay::to_diagnose(flight, model, given))
}

fn replays_by<'a>(
    files: &[PathBuf],
    flights: &'a [Read],
    replay: impl Fn(&'a Flight) -> Result<Replay<'a>, ReplayError>,
) -> Result<Vec<NamedReplay<'a>>, Failure> {
    let named = files.iter().zip(flights).map(|(file, (flight, _))| {
        let replay =
            replay(flight).map_err(|error| Failure::input(format!("{}: {error}", file.display())))?;
        Ok(NamedReplay::new(file.display().to_string(), replay))
    });
    named.collect()
}

/// Prints to standard error which part of each flight is not used, and why.
pub fn write_unused<'a>(named: impl IntoIterator<Item = &'a NamedReplay<'a>>) {
    for NamedReplay { file, replay, .. } in named {
        write_unused_of(file, replay);
    }
}

/// As [`write_unused`], for one flight.
pub fn write_unused_of(file: &impl Display, replay: &Replay<'_>) {
    for line in Usage::of(replay).lines() {
        // If standard error is closed, there is nowhere to report this.
        let _ = writeln!(std::io::stderr(), "note: {file}: {line}");
    }
}

/// These flights, each under its file's name.
pub fn named<'a>(files: &[PathBuf], flights: &'a [Read], given: GivenTimes) -> Vec<NamedFlight<'a>> {
    let named = |(file, (flight, _)): (&PathBuf, &'a Read)| NamedFlight {
        file: file.display().to_string(),
        flight,
        given,
    };
    files.iter().zip(flights).map(named).collect()
}

/// Loads a model by preset name or file; prints a warning to standard error for each unlikely value in it.
pub fn model(name: &str) -> Result<Model, Failure> {
    let model = Model::load(name)?;
    for warning in model.warnings() {
        // If standard error is closed, there is nowhere to report this.
        let _ = writeln!(std::io::stderr(), "warning: {name}: {warning}");
    }
    Ok(model)
}

/// Prints notes on an input to standard error.
pub fn write_notes(notes: &[Note]) {
    for note in notes {
        // If standard error is closed, there is nowhere to report this.
        let _ = writeln!(std::io::stderr(), "note: {}", printable(&note.to_string()));
    }
}
