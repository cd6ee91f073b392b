//! Counts results from the output of tests.

use std::fmt;

/// A kind of test.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Tests within the code.
    Unit,
    /// Tests in a crate's folder `tests`.
    Integration,
    /// Such tests that use the emulator.
    Emulated,
    /// Such tests of the firmware's budgets.
    Budgets,
    /// Tests of the studio's page.
    Browser,
    /// Examples in the documentation.
    Documentation,
}

impl Kind {
    const ALL: [(Self, &str); 6] = [
        (Self::Unit, "unit"),
        (Self::Integration, "integration"),
        (Self::Emulated, "in QEMU"),
        (Self::Budgets, "budgets"),
        (Self::Browser, "in a browser"),
        (Self::Documentation, "documentation"),
    ];

    /// The starting order: tests that wait long for other programs, on few processors, come first.
    pub const fn rank(self) -> u8 {
        match self {
            Self::Budgets => 0,
            Self::Emulated => 1,
            Self::Browser => 2,
            Self::Integration => 3,
            Self::Documentation => 4,
            Self::Unit => 5,
        }
    }
}

/// Results of tests.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct TestReport {
    /// Tests that passed, by kind.
    passed: [usize; Kind::ALL.len()],
    /// Tests that failed.
    pub failed: usize,
    /// Tests that are marked as ignored.
    ignored: usize,
    /// What tests reported as left out (`skipped: ...`), each once.
    pub skipped: Vec<String>,
}

impl TestReport {
    /// Reads the output of a program of this kind, both streams in order: of a Rust test program with
    /// `--show-output`, or of Node.
    pub fn hear(&mut self, kind: Kind, output: &str) {
        for line in output.lines() {
            if let Some(counts) = line.strip_prefix("test result: ") {
                self.add(kind, counts);
            } else if let Some(count) = node_count(line, "pass") {
                self.passed[kind as usize] += count;
            } else if let Some(count) = node_count(line, "fail") {
                self.failed += count;
            } else if let Some(name) = line.trim_start().strip_prefix("skipped: ")
                && !self.skipped.iter().any(|known| known == name)
            {
                self.skipped.push(name.to_owned());
            }
        }
    }

    /// Tests that passed.
    pub fn passed(&self) -> usize {
        self.passed.iter().sum()
    }

    /// Adds `ok. 3 passed; 0 failed; 1 ignored; 0 measured; ...`.
    fn add(&mut self, kind: Kind, counts: &str) {
        let counts = counts.split_once(". ").map_or(counts, |(_, counts)| counts);
        for part in counts.split("; ") {
            let Some((number, what)) = part.split_once(' ') else { continue };
            let Ok(number) = number.parse::<usize>() else { continue };
            match what {
                "passed" => self.passed[kind as usize] += number,
                "failed" => self.failed += number,
                "ignored" => self.ignored += number,
                _ => {}
            }
        }
    }
}

/// The number in `# pass 35` or `ℹ pass 35`, the summary of Node's test runner.
fn node_count(line: &str, what: &str) -> Option<usize> {
    let rest = line.strip_prefix("# ").or_else(|| line.strip_prefix("ℹ "))?;
    rest.strip_prefix(what)?.trim().parse().ok()
}

impl fmt::Display for TestReport {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{} tests:", self.passed())?;
        for (kind, name) in Kind::ALL {
            let comma = if kind == Kind::Unit { "" } else { "," };
            write!(formatter, "{comma} {} {name}", self.passed[kind as usize])?;
        }
        if self.ignored > 0 {
            write!(formatter, "; {} ignored", self.ignored)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_by_kind_and_lists_what_was_left_out_once() {
        let unit = "running 2 tests
test a ... ok
test b ... ok

successes:

---- a stdout ----
skipped: real IGC logs (../shared is missing)

test result: ok. 2 passed; 0 failed; 0 ignored; 0 measured; 0 filtered out; finished in 0.01s
";
        let oracle = "\
---- c stdout ----
skipped: real IGC logs (../shared is missing)
test result: FAILED. 30 passed; 1 failed; 4 ignored; 0 measured; 0 filtered out; finished in 0.02s
";
        let examples = "\
   Doc-tests kf_core
test result: ok. 1 passed; 0 failed; 0 ignored; 0 measured; 0 filtered out; finished in 0.02s
   Doc-tests model
test result: ok. 2 passed; 0 failed; 0 ignored; 0 measured; 0 filtered out; finished in 0.02s
";
        let budgets =
            "test result: ok. 3 passed; 0 failed; 0 ignored; 0 measured; 0 filtered out; finished in 9.01s";
        let mut report = TestReport::default();
        for (kind, output) in [
            (Kind::Unit, unit),
            (Kind::Integration, oracle),
            (Kind::Budgets, budgets),
            (Kind::Documentation, examples),
            (Kind::Browser, "✔ opens (3 ms)\nℹ tests 36\nℹ pass 34\nℹ fail 2\n"),
            (Kind::Browser, "# tests 1\n# pass 1\n# fail 0\n"),
        ] {
            report.hear(kind, output);
        }
        assert_eq!(
            report.to_string(),
            "73 tests: 2 unit, 30 integration, 0 in QEMU, 3 budgets, 35 in a browser, 3 documentation; 4 ignored"
        );
        assert_eq!(report.failed, 3);
        assert_eq!(report.skipped, ["real IGC logs (../shared is missing)"]);
    }

    #[test]
    fn silence_is_no_test() {
        let mut report = TestReport::default();
        report.hear(Kind::Unit, "error: could not compile `kf-core`");
        assert_eq!(report, TestReport::default());
    }
}
