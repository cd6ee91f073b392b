//! The table of consequences by fault and phase.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use super::fault::Phase;
use super::judge::{Consequence, Invariant, Verdict};
use super::run::Case;

/// A cell: number of runs, and the worst of them.
#[derive(Clone, Copy, Debug)]
struct Cell {
    runs: usize,
    worst: Consequence,
    violations: usize,
}

/// The results of a campaign.
#[derive(Debug, Default)]
pub struct Matrix {
    cells: BTreeMap<(&'static str, Phase), Cell>,
    pairs: BTreeMap<Phase, Cell>,
    broken: BTreeMap<Invariant, usize>,
    runs: usize,
    violated: usize,
}

impl Matrix {
    /// Adds a run.
    pub fn take(&mut self, case: &Case, verdict: &Verdict) {
        self.runs += 1;
        self.violated += usize::from(!verdict.violations.is_empty());
        let mut counted: Vec<Invariant> =
            verdict.violations.iter().map(|violation| violation.invariant).collect();
        counted.dedup();
        for invariant in counted {
            *self.broken.entry(invariant).or_default() += 1;
        }
        let new = Cell { runs: 0, worst: Consequence::None, violations: 0 };
        let Some(first) = case.faults.first() else { return };
        let cell = match case.faults.len() {
            1 => self.cells.entry((first.name, first.phase)).or_insert(new),
            _ => self.pairs.entry(first.phase).or_insert(new),
        };
        cell.runs += 1;
        cell.violations += usize::from(!verdict.violations.is_empty());
        if verdict.worst > cell.worst {
            cell.worst = verdict.worst;
        }
    }

    /// Number of runs with a violation.
    #[must_use]
    pub const fn violated(&self) -> usize {
        self.violated
    }

    /// The matrix as a Markdown table.
    #[must_use]
    pub fn table(&self) -> String {
        let mut text = String::from("| fault |");
        for phase in Phase::ALL {
            // Writing to a string cannot fail.
            let _ = write!(text, " {} |", phase.name());
        }
        let _ = writeln!(text, "\n|---|{}", "---|".repeat(Phase::ALL.len()));
        let mut names: Vec<_> = self.cells.keys().map(|(name, _)| *name).collect();
        names.dedup();
        for name in names {
            let _ = write!(text, "| {name} |");
            for phase in Phase::ALL {
                let _ = write!(text, " {} |", said(self.cells.get(&(name, phase))));
            }
            let _ = writeln!(text);
        }
        let _ = write!(text, "| two faults (phase of the first) |");
        for phase in Phase::ALL {
            let _ = write!(text, " {} |", said(self.pairs.get(&phase)));
        }
        let _ = writeln!(text);
        text
    }

    /// How often each invariant was broken.
    #[must_use]
    pub fn summary(&self) -> String {
        let mut text = format!(
            "{} runs, {} of them with a violation ({:.2} %)\n\n| invariant | runs that broke it |\n|---|---|\n",
            self.runs,
            self.violated,
            100.0 * self.violated as f64 / self.runs.max(1) as f64
        );
        for invariant in Invariant::ALL {
            let count = self.broken.get(&invariant).copied().unwrap_or(0);
            let _ = writeln!(text, "| {} | {count} |", invariant.name());
        }
        text
    }
}

fn said(cell: Option<&Cell>) -> String {
    match cell {
        None => "-".to_owned(),
        Some(Cell { runs, worst, violations: 0 }) => format!("{worst} ({runs})"),
        Some(Cell { runs, worst, violations }) => format!("{worst} ({violations} of {runs})"),
    }
}
