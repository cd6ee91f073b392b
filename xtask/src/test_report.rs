//! What `cargo test` says, counted.

use std::fmt;
use std::time::Duration;

/// A kind of test.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// Beside the code.
    Unit,
    /// In a crate's folder `tests`.
    Integration,
    /// There, and with the emulator.
    Emulated,
    /// There, and about the firmware's budgets.
    Budgets,
    /// In the documentation.
    Documentation,
}

impl Kind {
    const ALL: [(Self, &str); 5] = [
        (Self::Unit, "unit"),
        (Self::Integration, "integration"),
        (Self::Emulated, "in QEMU"),
        (Self::Budgets, "budgets"),
        (Self::Documentation, "documentation"),
    ];

    /// The kind that a line of cargo's announces.
    fn announced(line: &str) -> Option<Self> {
        let line = line.trim_start();
        if line.starts_with("Doc-tests ") {
            return Some(Self::Documentation);
        }
        let file = line.strip_prefix("Running ")?;
        Some(match file {
            _ if file.starts_with("tests/qemu") => Self::Emulated,
            _ if file.starts_with("tests/budgets") => Self::Budgets,
            _ if file.starts_with("tests/") => Self::Integration,
            _ => Self::Unit,
        })
    }
}

/// How tests fared.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct TestReport {
    /// Tests that passed, by kind.
    passed: [usize; Kind::ALL.len()],
    /// Tests that failed.
    pub failed: usize,
    /// Tests that are marked as ignored.
    ignored: usize,
    /// What tests said they left out (`skipped: ...`), each once.
    pub skipped: Vec<String>,
}

impl TestReport {
    /// Reads the output of `cargo test -- --show-output`, both streams in order.
    pub fn read(output: &str) -> Self {
        let mut report = Self::default();
        let mut kind = Kind::Unit;
        for line in output.lines() {
            if let Some(announced) = Kind::announced(line) {
                kind = announced;
            } else if let Some(counts) = line.strip_prefix("test result: ") {
                report.add(kind, counts);
            } else if let Some(name) = line.trim_start().strip_prefix("skipped: ")
                && !report.skipped.iter().any(|known| known == name)
            {
                report.skipped.push(name.to_owned());
            }
        }
        report
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

/// What `cargo test` says, as it comes: a line for every program of tests that has ended, so that one sees where the time goes, and
/// how far it came if it is cut off.
#[derive(Debug, Default)]
pub struct TestProgress {
    running: Option<String>,
    /// What each program of tests took, by its own word.
    pub took: Vec<(String, Duration)>,
}

impl TestProgress {
    /// Takes a line; says how a program fared where this line ends it.
    pub fn hear(&mut self, line: &str) -> Option<String> {
        let line = line.trim();
        if Kind::announced(line).is_some() {
            // `Running tests/suite.rs (target/debug/deps/suite-0123)`: the crate's own programs are all called alike.
            let name = match line.rsplit_once('/') {
                Some((_, program)) if program.ends_with(')') => {
                    program.rsplit_once('-').map_or(program, |(name, _)| name)
                }
                _ => line,
            };
            self.running = Some(name.to_owned());
            return None;
        }
        let (_, counts) = line.strip_prefix("test result: ")?.split_once(". ")?;
        let told = ["passed", "failed", "finished"];
        let parts = counts.split("; ").filter(|part| told.iter().any(|word| part.contains(word)));
        let name = self.running.take()?;
        if let Some(took) = counts.rsplit_once("finished in ").and_then(|(_, took)| duration(took)) {
            self.took.push((name.clone(), took));
        }
        Some(format!("{name}: {}", parts.collect::<Vec<_>>().join(", ")))
    }
}

/// `9.01s` as a duration.
fn duration(text: &str) -> Option<Duration> {
    Duration::try_from_secs_f64(text.strip_suffix('s')?.parse().ok()?).ok()
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
        let output = "\
   Compiling kf-core v0.1.0
     Running unittests src/lib.rs (target/debug/deps/kf_core-0123)

running 2 tests
test a ... ok
test b ... ok

successes:

---- a stdout ----
skipped: real IGC logs (../shared is missing)

test result: ok. 2 passed; 0 failed; 0 ignored; 0 measured; 0 filtered out; finished in 0.01s

     Running tests/qemu_flight.rs (target/debug/deps/qemu_flight-0123)
test result: ok. 5 passed; 0 failed; 0 ignored; 0 measured; 0 filtered out; finished in 9.01s
     Running tests/budgets.rs (target/debug/deps/budgets-0123)
test result: ok. 3 passed; 0 failed; 0 ignored; 0 measured; 0 filtered out; finished in 9.01s
     Running tests/oracle.rs (target/debug/deps/oracle-0123)
---- c stdout ----
skipped: real IGC logs (../shared is missing)
test result: FAILED. 30 passed; 1 failed; 4 ignored; 0 measured; 0 filtered out; finished in 0.02s
   Doc-tests kf_core
test result: ok. 1 passed; 0 failed; 0 ignored; 0 measured; 0 filtered out; finished in 0.02s
";
        let report = TestReport::read(output);
        assert_eq!(
            report.to_string(),
            "41 tests: 2 unit, 30 integration, 5 in QEMU, 3 budgets, 1 documentation; 4 ignored"
        );
        assert_eq!(report.failed, 1);
        assert_eq!(report.skipped, ["real IGC logs (../shared is missing)"]);
    }

    #[test]
    fn tells_of_each_program_as_it_ends() {
        let output = "\
   Compiling kf-core v0.1.0
     Running unittests src/lib.rs (target/debug/deps/kf_core-0123)

running 2 tests
test a ... ok
test result: ok. 2 passed; 0 failed; 0 ignored; 0 measured; 0 filtered out; finished in 0.01s
     Running tests/qemu_flight.rs (target/debug/deps/qemu_flight-0123)
test result: FAILED. 4 passed; 1 failed; 0 ignored; 0 measured; 0 filtered out; finished in 9.01s
   Doc-tests kf_core
test result: ok. 1 passed; 0 failed; 0 ignored; 0 measured; 0 filtered out; finished in 0.02s
";
        let mut progress = TestProgress::default();
        let told: Vec<_> = output.lines().filter_map(|line| progress.hear(line)).collect();
        let expected = [
            "kf_core: 2 passed, 0 failed, finished in 0.01s",
            "qemu_flight: 4 passed, 1 failed, finished in 9.01s",
            "Doc-tests kf_core: 1 passed, 0 failed, finished in 0.02s",
        ];
        assert_eq!(told, expected);
        let took: Vec<_> =
            progress.took.iter().map(|(name, took)| (name.as_str(), took.as_millis())).collect();
        assert_eq!(took, [("kf_core", 10), ("qemu_flight", 9010), ("Doc-tests kf_core", 20)]);
    }

    #[test]
    fn silence_is_no_test() {
        assert_eq!(TestReport::read("error: could not compile `kf-core`"), TestReport::default());
    }
}
