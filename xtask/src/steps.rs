//! A job as a series of steps: each is run, timed and reported, and a failed one does not stop the rest.

use std::io::{self, Write};
use std::time::{Duration, Instant};

use comfy_table::Cell;

use crate::child::Failure;
use crate::table::{plain, right};

/// Smallest share of the time that has its own row among the slowest, so that there are at most a hundred.
const SMALLEST_SHARE: f64 = 0.01;

/// Result of a step that succeeded.
#[derive(Clone, Debug, Default)]
pub struct Done {
    /// A short description with its counts.
    pub what: String,
    /// What it left out, and why.
    pub skipped: Vec<String>,
    /// The times of its parts, if it has any.
    pub parts: Parts,
}

/// The parts of a step, which may have run in parallel.
#[derive(Clone, Debug, Default)]
pub struct Parts {
    /// Time of each part.
    pub each: Vec<(String, Duration)>,
    /// Time of all of them together: less than their sum if they ran in parallel.
    pub together: Duration,
}

impl Parts {
    /// A part's share of [`Self::together`], in proportion to its own time.
    fn charge(&self, took: Duration) -> Duration {
        let sum: Duration = self.each.iter().map(|(_, took)| *took).sum();
        if sum.is_zero() {
            Duration::ZERO
        } else {
            self.together.mul_f64(took.as_secs_f64() / sum.as_secs_f64())
        }
    }
}

impl Done {
    /// A step that left nothing out.
    pub fn all(what: impl Into<String>) -> Self {
        Self { what: what.into(), ..Self::default() }
    }
}

/// How a step ended.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Outcome {
    Passed(String),
    Failed(String),
    Skipped(String),
}

/// A finished step.
struct Row {
    name: String,
    outcome: Outcome,
    took: Duration,
    parts: Parts,
}

/// The steps of a job so far.
pub struct Steps {
    planned: usize,
    begun: usize,
    rows: Vec<Row>,
}

impl Steps {
    /// No step yet of this many.
    pub const fn new(planned: usize) -> Self {
        Self { planned, begun: 0, rows: Vec::new() }
    }

    /// Runs a step, and returns whether it passed. A failed child's output goes to standard error.
    pub fn run(&mut self, name: &str, step: impl FnOnce() -> anyhow::Result<Done>) -> bool {
        self.begun += 1;
        eprint!("[{:>2}/{}] {name} ... ", self.begun, self.planned);
        // A progress line that cannot be shown is no reason to stop.
        let _ = io::stderr().flush();
        let start = Instant::now();
        let outcome = step();
        let took = start.elapsed();
        let mut add = |outcome, parts| self.rows.push(Row { name: name.to_owned(), outcome, took, parts });
        match outcome {
            Ok(Done { what, skipped, parts }) => {
                eprintln!("passed, {}", seconds(took));
                add(Outcome::Passed(what), parts);
                for what in skipped {
                    // Not in the words with which a test reports a skip: this is run in a test as well.
                    eprintln!("           left out: {what}");
                    self.rows.push(Row {
                        name: name.to_owned(),
                        outcome: Outcome::Skipped(what),
                        took: Duration::ZERO,
                        parts: Parts::default(),
                    });
                }
                true
            }
            Err(error) => {
                if let Some(Failure::Ended { output, .. }) = error.downcast_ref::<Failure>() {
                    eprintln!("\n{}", output.all.trim_end());
                }
                eprintln!("FAILED, {}: {error:#}", seconds(took));
                add(Outcome::Failed(format!("{error:#}")), Parts::default());
                false
            }
        }
    }

    /// Numbers of passed, failed and skipped steps.
    pub fn counts(&self) -> [usize; 3] {
        let count = |kind: fn(&Outcome) -> bool| self.rows.iter().filter(|row| kind(&row.outcome)).count();
        [
            count(|outcome| matches!(outcome, Outcome::Passed(_))),
            count(|outcome| matches!(outcome, Outcome::Failed(_))),
            count(|outcome| matches!(outcome, Outcome::Skipped(_))),
        ]
    }

    /// Every step, one row each.
    pub fn table(&self) -> String {
        let mut table = plain([Cell::new("step"), Cell::new("outcome"), right("took"), Cell::new("what")]);
        for Row { name, outcome, took, .. } in &self.rows {
            let (word, took, what) = match outcome {
                Outcome::Passed(what) => ("passed", seconds(*took), what),
                Outcome::Failed(what) => ("FAILED", seconds(*took), what),
                Outcome::Skipped(what) => ("skipped", String::new(), what),
            };
            table.add_row([Cell::new(name), Cell::new(word), right(took), Cell::new(what)]);
        }
        table.trim_fmt()
    }

    /// Where the time went, slowest first: for a step with parts, each of them and the remainder. Parts that
    /// ran in parallel have their share of their common time.
    pub fn slowest(&self) -> String {
        let mut rows: Vec<(String, Duration, Duration)> = Vec::new();
        for Row { name, took, parts, .. } in &self.rows {
            let left =
                if parts.each.is_empty() { name.clone() } else { format!("{name}: building, and the rest") };
            let rest = took.saturating_sub(parts.together);
            rows.push((left, rest, rest));
            let charged = |took| parts.charge(took);
            rows.extend(
                parts.each.iter().map(|(part, took)| (format!("{name}: {part}"), *took, charged(*took))),
            );
        }
        rows.sort_by_key(|(_, took, _)| std::cmp::Reverse(*took));
        let total: Duration = rows.iter().map(|(_, _, charged)| *charged).sum();
        let mut table = plain([Cell::new("slowest first"), right("took"), right("share")]);
        let (mut few, mut short, mut short_charged) = (0, Duration::ZERO, Duration::ZERO);
        for (name, took, charged) in rows {
            let share = charged.as_secs_f64() / total.as_secs_f64();
            if share >= SMALLEST_SHARE {
                table.add_row([Cell::new(name), right(seconds(took)), right(percent(share))]);
            } else if !took.is_zero() {
                few += 1;
                short += took;
                short_charged += charged;
            }
        }
        if few > 0 {
            let share = short_charged.as_secs_f64() / total.as_secs_f64();
            let name = format!("{few} of less than {} each", percent(SMALLEST_SHARE));
            table.add_row([Cell::new(name), right(seconds(short)), right(percent(share))]);
        }
        table.add_row([Cell::new("all"), right(seconds(total)), right(percent(1.0))]);
        table.trim_fmt()
    }

    /// The summary line: `N passed, N failed, N skipped`.
    pub fn verdict(&self) -> String {
        let [passed, failed, skipped] = self.counts();
        format!("{passed} passed, {failed} failed, {skipped} skipped")
    }
}

fn percent(share: f64) -> String {
    format!("{:.0} %", 100.0 * share)
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
        assert!(steps.run("third", || Ok(Done {
            what: "2 tests".into(),
            skipped: vec!["no logs".into()],
            ..Done::default()
        })));
        assert_eq!(steps.verdict(), "2 passed, 1 failed, 1 skipped");
        let table = steps.table();
        assert!(table.contains("FAILED"), "{table}");
        assert!(table.contains("`sh -c 'exit 1'` ended with exit status: 1"), "{table}");
        assert_eq!(table.lines().count(), 5, "{table}");
    }

    fn row(name: &str, took: u64, together: u64, parts: &[(&str, u64)]) -> Row {
        let each =
            parts.iter().map(|(name, took)| ((*name).to_owned(), Duration::from_secs(*took))).collect();
        Row {
            name: name.to_owned(),
            outcome: Outcome::Passed(String::new()),
            took: Duration::from_secs(took),
            parts: Parts { each, together: Duration::from_secs(together) },
        }
    }

    /// The table's rows without padding and without the header.
    fn slowest(rows: Vec<Row>) -> Vec<String> {
        let table = Steps { planned: rows.len(), begun: rows.len(), rows }.slowest();
        table.lines().skip(1).map(|line| line.split_whitespace().collect::<Vec<_>>().join(" ")).collect()
    }

    #[test]
    fn the_slowest_part_comes_first_and_nothing_is_left_out() {
        let rows = vec![
            row("clippy", 100, 0, &[]),
            row("tests", 890, 851, &[("oracle", 250), ("budgets", 600), ("quick", 1)]),
            row("formatting", 10, 0, &[]),
        ];
        let expected = [
            "tests: budgets 600.0 s 60 %",
            "tests: oracle 250.0 s 25 %",
            "clippy 100.0 s 10 %",
            "tests: building, and the rest 39.0 s 4 %",
            "formatting 10.0 s 1 %",
            "1 of less than 1 % each 1.0 s 0 %",
            "all 1000.0 s 100 %",
        ];
        assert_eq!(slowest(rows), expected);
    }

    /// Two lanes: 400 s and 200 s of parts took 300 s together, which is all that the step is charged with.
    #[test]
    fn parts_that_ran_side_by_side_share_the_time_that_they_took_together() {
        let rows = vec![row("clippy", 100, 0, &[]), row("tests", 300, 300, &[("long", 400), ("short", 200)])];
        let expected = [
            "tests: long 400.0 s 50 %",
            "tests: short 200.0 s 25 %",
            "clippy 100.0 s 25 %",
            "all 400.0 s 100 %",
        ];
        assert_eq!(slowest(rows), expected);
    }
}
