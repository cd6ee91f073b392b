//! Folders and patterns on the command line, and the files that they mean.

use std::fs;
use std::io;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use glob::MatchOptions;
use pylon::import;

use super::failure::Failure;
use super::progress::while_busy;

/// As a shell matches: a star crosses no folder, and finds no hidden file.
const AS_SHELLS_DO: MatchOptions =
    MatchOptions { case_sensitive: true, require_literal_separator: true, require_literal_leading_dot: true };

/// How many names of files that are no logs are said.
const NAMED: usize = 5;

/// What the user meant.
#[derive(Debug, Default)]
pub struct Places {
    /// Files, in the order in which they were given; those of a folder by name.
    pub files: Vec<PathBuf>,
    /// Folders that have other files beside logs.
    notes: Vec<String>,
}

impl Places {
    /// The files that these arguments mean: a file itself, a folder every log in it at any depth, a pattern
    /// (`logs/*.igc`, where the shell has not expanded it) what it matches. What is no log is left out of a
    /// folder, but not of a pattern.
    ///
    /// # Errors
    /// A folder without a log, a pattern that matches nothing, a folder that cannot be listed.
    pub fn find(given: &[PathBuf]) -> Result<Self, Failure> {
        let mut places = Self::default();
        for path in given {
            if path.is_dir() {
                places.take_folder(path)?;
            } else if path.exists() || !is_pattern(path) {
                // A file that does not exist is named by whoever reads it.
                places.files.push(path.clone());
            } else {
                places.take_pattern(path)?;
            }
        }
        Ok(places)
    }

    fn take_folder(&mut self, folder: &Path) -> Result<(), Failure> {
        let mut found = Vec::new();
        list(folder, &mut found)
            .map_err(|error| Failure::input(format!("{}: cannot be listed: {error}", folder.display())))?;
        found.sort();
        let (logs, others): (Vec<_>, Vec<_>) = while_busy("looking for logs", || {
            // One that cannot be read is named with the reason when it is opened.
            found.into_iter().partition(|file| import::is_known(file).unwrap_or(true))
        });
        if logs.is_empty() {
            return Err(Failure::input(format!(
                "{}: no log among the {} files of this folder, expected flights' CSV or logs that `pylon import` reads",
                folder.display(),
                others.len()
            )));
        }
        if !others.is_empty() {
            let names: Vec<_> = others
                .iter()
                .take(NAMED)
                .map(|file| file.strip_prefix(folder).unwrap_or(file).display().to_string())
                .collect();
            let more = if others.len() > NAMED { ", ..." } else { "" };
            self.notes.push(format!(
                "{}: {} logs; {} other files were left out: {}{more}",
                folder.display(),
                logs.len(),
                others.len(),
                names.join(", ")
            ));
        }
        self.files.extend(logs);
        Ok(())
    }

    fn take_pattern(&mut self, pattern: &Path) -> Result<(), Failure> {
        let in_pattern = |error: &dyn std::fmt::Display| {
            Failure::input(format!("{}: no pattern of files: {error}", pattern.display()))
        };
        let text = pattern.to_str().ok_or_else(|| in_pattern(&"it is no text"))?;
        let found = glob::glob_with(text, AS_SHELLS_DO).map_err(|error| in_pattern(&error))?;
        let before = self.files.len();
        for file in found {
            let file = file.map_err(|error| Failure::input(format!("{}: {error}", pattern.display())))?;
            if !file.is_dir() {
                self.files.push(file);
            }
        }
        if self.files.len() == before {
            return Err(Failure::input(format!("{}: no file matches this pattern", pattern.display())));
        }
        Ok(())
    }

    /// Says on standard error what was left out.
    pub fn write_notes(&self) {
        for note in &self.notes {
            // Nothing is left to be told to when standard error is closed.
            let _ = writeln!(io::stderr(), "note: {note}");
        }
    }
}

/// Whether a name has what shells expand.
fn is_pattern(path: &Path) -> bool {
    path.to_string_lossy().contains(['*', '?', '['])
}

/// Every file at any depth. Hidden ones and linked folders, which may lead in a circle, are none of the
/// user's logs.
fn list(folder: &Path, found: &mut Vec<PathBuf>) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        if entry.file_name().to_string_lossy().starts_with('.') {
            continue;
        }
        let kind = entry.file_type()?;
        if kind.is_dir() {
            list(&entry.path(), found)?;
        } else if entry.path().is_file() {
            found.push(entry.path());
        }
    }
    Ok(())
}
