//! Known violations of a campaign, so that the test command fails for any other: a list that may only shrink.

use std::collections::BTreeMap;
use std::path::Path;

use anyhow::Context as _;
use kf_core::guard::Guard;
use serde::{Deserialize, Serialize};

use super::judge::Verdict;
use super::run::Case;

/// The list, as stored in a TOML file.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Known {
    /// Seed of the campaign.
    seed: u64,
    /// Number of runs.
    runs: usize,
    /// Guards whose removal nothing reports; empty if that was not tried.
    unnoticed_guards: Vec<String>,
    /// Violated invariants by the number of the run.
    violations: BTreeMap<String, Vec<String>>,
}

impl Known {
    /// The result of a campaign; `caught` are the guards whose removal was noticed.
    #[must_use]
    pub fn found(seed: u64, cases: &[Case], verdicts: &[Verdict], caught: Option<&[Guard]>) -> Self {
        let mut violations: BTreeMap<String, Vec<String>> = BTreeMap::new();
        for (case, verdict) in cases.iter().zip(verdicts) {
            let mut names: Vec<_> =
                verdict.violations.iter().map(|violation| violation.invariant.name().to_owned()).collect();
            names.sort();
            names.dedup();
            if !names.is_empty() {
                violations.insert(format!("{:04}", case.index), names);
            }
        }
        let unnoticed = |caught: &[Guard]| {
            Guard::ALL
                .iter()
                .filter(|guard| !caught.contains(guard))
                .map(|guard| format!("{guard:?}"))
                .collect()
        };
        Self {
            seed,
            runs: cases.len(),
            unnoticed_guards: caught.map(unnoticed).unwrap_or_default(),
            violations,
        }
    }

    /// Reads the list.
    ///
    /// # Errors
    /// The file cannot be read, or is not such a list.
    pub fn load(file: &Path) -> anyhow::Result<Self> {
        let text = std::fs::read_to_string(file).with_context(|| file.display().to_string())?;
        toml::from_str(&text).with_context(|| file.display().to_string())
    }

    /// Writes the list.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn save(&self, file: &Path) -> anyhow::Result<()> {
        let text = format!(
            "# Invariants that the fault campaign of the test command is known to break (docs/fault-campaign.md explains the classes). The test fails\n\
             # for anything else, and for a line of this list that is no longer true. Written by\n\
             # cargo xtask campaign --mutants --known --accept.\n{}",
            toml::to_string(self)?
        );
        std::fs::write(file, text).with_context(|| file.display().to_string())
    }

    /// Differences of this from a list, one line each.
    #[must_use]
    pub fn changes_from(&self, list: &Self) -> Vec<String> {
        let mut changes = Vec::new();
        if (self.seed, self.runs) != (list.seed, list.runs) {
            changes.push(format!("the list is of {} runs of seed {}", list.runs, list.seed));
        }
        for guard in &self.unnoticed_guards {
            if !list.unnoticed_guards.contains(guard) {
                changes.push(format!("nothing reports the removal of {guard}"));
            }
        }
        for (run, names) in &self.violations {
            for name in names.iter().filter(|name| !list.names(run).contains(name)) {
                changes.push(format!("run {run}: {name}"));
            }
        }
        for (run, names) in &list.violations {
            for name in names.iter().filter(|name| !self.names(run).contains(name)) {
                changes.push(format!("run {run}: {name} no longer happens: remove it from the list"));
            }
        }
        changes
    }

    fn names(&self, run: &str) -> &[String] {
        self.violations.get(run).map_or(&[], Vec::as_slice)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn list(runs: &[(&str, &[&str])], guards: &[&str]) -> Known {
        let owned = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect::<Vec<_>>();
        Known {
            seed: 1,
            runs: 10,
            unnoticed_guards: owned(guards),
            violations: runs.iter().map(|(run, names)| ((*run).to_owned(), owned(names))).collect(),
        }
    }

    #[test]
    fn what_is_new_and_what_is_gone_are_both_said() {
        let known = list(&[("0003", &["latch changed"]), ("0007", &["false launch"])], &["UbxOnly"]);
        assert!(known.changes_from(&known).is_empty());
        let now = list(&[("0003", &["latch changed", "panic"])], &["UbxOnly", "InnovationGate"]);
        assert_eq!(
            now.changes_from(&known),
            [
                "nothing reports the removal of InnovationGate",
                "run 0003: panic",
                "run 0007: false launch no longer happens: remove it from the list",
            ]
        );
        let text = toml::to_string(&known).unwrap();
        assert_eq!(toml::from_str::<Known>(&text).unwrap(), known);
    }
}
