//! Resolves folders and patterns on the command line to files.

use std::fs;
use std::io;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use glob::MatchOptions;
use pylon::import;

use super::failure::Failure;
use super::progress::while_busy;

/// Matching as in a shell: a star does not cross folders or match hidden files.
const AS_SHELLS_DO: MatchOptions =
    MatchOptions { case_sensitive: true, require_literal_separator: true, require_literal_leading_dot: true };

/// Number of files other than logs that are named in a note.
const NAMED: usize = 5;

/// The files that the user's arguments stand for.
#[derive(Debug, Default)]
pub struct Places {
    /// Files in the order given; those of a folder by name.
    pub files: Vec<PathBuf>,
    /// Notes on folders that contain other files besides logs.
    notes: Vec<String>,
}

impl Places {
    /// The files that these arguments stand for: a file stands for itself, a folder for every log in it at
    /// any depth, a pattern (`logs/*.igc`, if the shell has not expanded it) for what it matches. Files that
    /// are not logs are left out of a folder, but not of a pattern.
    ///
    /// # Errors
    /// A folder without a log, a pattern that matches nothing, a folder that cannot be listed.
    pub fn find(given: &[PathBuf]) -> Result<Self, Failure> {
        let mut places = Self::default();
        for path in given {
            if path.is_dir() {
                places.take_folder(path)?;
            } else if path.exists() || !is_pattern(path) {
                // A missing file is reported by the code that reads it.
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
            // A file that cannot be read is reported with the reason when it is opened.
            found.into_iter().partition(|file| import::is_known(file).unwrap_or(true))
        });
        if logs.is_empty() {
            return Err(Failure::input(format!(
                "{}: no log among the {} files of this folder, expected flight CSVs or logs that `pylon import` reads",
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
            Failure::input(format!("{}: invalid file pattern: {error}", pattern.display()))
        };
        let text = pattern.to_str().ok_or_else(|| in_pattern(&"it is not valid UTF-8"))?;
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

    /// Prints to standard error what was left out.
    pub fn write_notes(&self) {
        for note in &self.notes {
            // If standard error is closed, there is nowhere to report this.
            let _ = writeln!(io::stderr(), "note: {note}");
        }
    }
}

/// Whether a name contains characters that shells expand.
fn is_pattern(path: &Path) -> bool {
    path.to_string_lossy().contains(['*', '?', '['])
}

/// Lists every file at any depth, except hidden files and linked folders: they are not the user's logs, and
/// links may form a cycle.
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
