//! A job as a row of steps: each is run, timed and told of, and one that fails does not stop the rest.

use std::io::{self, Write};
use std::time::{Duration, Instant};

use comfy_table::Cell;

use crate::child::Failure;
use crate::table::{plain, right};

/// What a step that ended well has to say.
#[derive(Clone, Debug, Default)]
pub struct Done {
    /// In a few words, with its counts.
    pub what: String,
    /// What it had to leave out, and why.
    pub skipped: Vec<String>,
}

impl Done {
    /// All of it done.
    pub fn all(what: impl Into<String>) -> Self {
        Self { what: what.into(), skipped: Vec::new() }
    }
}

/// How a step ended.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Outcome {
    Passed(String),
    Failed(String),
    Skipped(String),
}

/// A step that ended.
struct Row {
    name: String,
    outcome: Outcome,
    took: Duration,
}

/// The steps of a job so far.
pub struct Steps {
    planned: usize,
    begun: usize,
    rows: Vec<Row>,
}

impl Steps {
    /// None yet, of so many.
    pub const fn new(planned: usize) -> Self {
        Self { planned, begun: 0, rows: Vec::new() }
    }

    /// Runs a step, and says whether it passed. What a failed child said goes to standard error.
    pub fn run(&mut self, name: &str, step: impl FnOnce() -> anyhow::Result<Done>) -> bool {
        self.begun += 1;
        eprint!("[{:>2}/{}] {name} ... ", self.begun, self.planned);
        // Progress that nobody can be shown is no reason to stop.
        let _ = io::stderr().flush();
        let start = Instant::now();
        let outcome = step();
        let took = start.elapsed();
        let mut add = |outcome| self.rows.push(Row { name: name.to_owned(), outcome, took });
        match outcome {
            Ok(Done { what, skipped }) => {
                eprintln!("passed, {}", seconds(took));
                add(Outcome::Passed(what));
                for what in skipped {
                    // Not in the words in which a test says that it skips: this is run in a test as well.
                    eprintln!("           left out: {what}");
                    add(Outcome::Skipped(what));
                }
                true
            }
            Err(error) => {
                if let Some(Failure::Ended { said, .. }) = error.downcast_ref::<Failure>() {
                    eprintln!("\n{}", said.all.trim_end());
                }
                eprintln!("FAILED, {}: {error:#}", seconds(took));
                add(Outcome::Failed(format!("{error:#}")));
                false
            }
        }
    }

    /// How many passed, failed and were skipped.
    pub fn counts(&self) -> [usize; 3] {
        let count = |kind: fn(&Outcome) -> bool| self.rows.iter().filter(|row| kind(&row.outcome)).count();
        [
            count(|outcome| matches!(outcome, Outcome::Passed(_))),
            count(|outcome| matches!(outcome, Outcome::Failed(_))),
            count(|outcome| matches!(outcome, Outcome::Skipped(_))),
        ]
    }

    /// Every step, one a row.
    pub fn table(&self) -> String {
        let mut table = plain([Cell::new("step"), Cell::new("outcome"), right("took"), Cell::new("what")]);
        for Row { name, outcome, took } in &self.rows {
            let (word, took, what) = match outcome {
                Outcome::Passed(what) => ("passed", seconds(*took), what),
                Outcome::Failed(what) => ("FAILED", seconds(*took), what),
                Outcome::Skipped(what) => ("skipped", String::new(), what),
            };
            table.add_row([Cell::new(name), Cell::new(word), right(took), Cell::new(what)]);
        }
        table.trim_fmt()
    }

    /// The line that sums up: `N passed, N failed, N skipped`.
    pub fn verdict(&self) -> String {
        let [passed, failed, skipped] = self.counts();
        format!("{passed} passed, {failed} failed, {skipped} skipped")
    }
}

fn seconds(took: Duration) -> String {
    format!("{:.1} s", took.as_secs_f64())
}

#[cfg(test)]
mod tests {
    use std::process::Command;

    use super::*;
    use crate::child;

    #[test]
    fn counts_every_kind_and_goes_on_after_a_failure() {
        let mut steps = Steps::new(3);
        assert!(steps.run("first", || Ok(Done::all("7 tests"))));
        assert!(!steps.run("second", || {
            child::run(Command::new("sh").args(["-c", "exit 1"]), false)?;
            Ok(Done::default())
        }));
        assert!(steps.run("third", || Ok(Done { what: "2 tests".into(), skipped: vec!["no logs".into()] })));
        assert_eq!(steps.verdict(), "2 passed, 1 failed, 1 skipped");
        let table = steps.table();
        assert!(table.contains("FAILED"), "{table}");
        assert!(table.contains("`sh -c 'exit 1'` ended with exit status: 1"), "{table}");
        assert_eq!(table.lines().count(), 5, "{table}");
    }
}
