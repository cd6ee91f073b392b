//! `cargo xtask mutants`: which share of deliberate errors the tests of a crate catch.

use std::collections::HashSet;
use std::fs;
use std::path::Path;

use anyhow::{Context, bail};
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;

use crate::child;
use crate::workspace;

/// The version of cargo-mutants that this was tested with.
const VERSION: &str = "27.1.0";
/// Time limit of the tests of one mutant, seconds: unfinished tests count as having caught it.
const TIMEOUT_S: &str = "120";
/// Crates whose tests are partly in another crate: the drivers run against models of their chips, and the
/// meaning of a formula's text in a model is tested where that text is read. A crate's own features are
/// always enabled, so kf-core's formulas are included.
const TESTED_BY: [(&str, &str); 2] = [("drivers", "chip-models"), ("kf-core", "model")];
/// How cargo-mutants names the mutants that its filter of names never excludes.
const UNFILTERED: &str = ": delete field ";

/// Draws mutants of a crate and runs its tests on each.
pub fn run(package: &str, sample: usize, seed: u64, echo: bool) -> anyhow::Result<()> {
    let program = provide(echo)?;
    let folder = workspace::target_folder().join("mutants");
    fs::create_dir_all(&folder)?;
    let mut list = workspace::program(&program);
    list.args(["mutants", "--package", package, "--list"]);
    let all = child::run(&mut list, false)?.all;
    let mut names: Vec<&str> = all.lines().filter(|line| line.contains(": ")).collect();
    if names.is_empty() {
        bail!("`{package}` has no mutants; name one of the workspace's crates");
    }
    let total = names.len();
    if sample > 0 {
        names.shuffle(&mut ChaCha8Rng::seed_from_u64(seed));
    }
    let others = names.split_off(if sample > 0 { sample.min(total) } else { total });
    eprintln!("{} of {total} mutants of {package}", names.len());
    let outcomes = folder.join("mutants.out");
    if outcomes.exists() {
        fs::remove_dir_all(&outcomes)?;
    }
    fs::create_dir_all(&outcomes)?;
    // Mutants listed as caught before are not tried.
    let unasked: String =
        others.iter().filter(|name| name.contains(UNFILTERED)).map(|name| format!("{name}\n")).collect();
    fs::write(outcomes.join("caught.txt"), unasked)?;
    let mut mutants = workspace::program(&program);
    // In random order, so that a run that is ended early has also tried a random sample.
    mutants.args(["mutants", "--package", package, "--iterate", "--shuffle", "--jobs", "1"]);
    mutants.args(["--timeout", TIMEOUT_S, "--output"]).arg(&folder);
    let tests = TESTED_BY.iter().filter(|(of, _)| *of == package).map(|(_, by)| *by);
    for tests in tests.chain([package]) {
        mutants.args(["--test-package", tests]);
    }
    for name in &names {
        mutants.args(["--re", &exactly(name)]);
    }
    let status = mutants.status().with_context(|| format!("`{}`", program.display()))?;
    let drawn: HashSet<&str> = names.into_iter().collect();
    let count = |file: &str| {
        fs::read_to_string(outcomes.join(file))
            .map_or(0, |text| text.lines().filter(|line| drawn.contains(line)).count())
    };
    let (caught, missed) = (count("caught.txt") + count("timeout.txt"), count("missed.txt"));
    // 2: mutants were missed; 3: some timed out.
    if !matches!(status.code(), Some(0 | 2 | 3)) || caught + missed == 0 {
        bail!("cargo-mutants ended with {status}");
    }
    println!(
        "{package}: {caught} of {} viable mutants caught ({:.0} %), {} did not build; missed: {}",
        caught + missed,
        100.0 * caught as f64 / (caught + missed) as f64,
        count("unviable.txt"),
        workspace::shown(&outcomes.join("missed.txt"))
    );
    Ok(())
}

/// cargo-mutants, built once into the target folder.
fn provide(echo: bool) -> anyhow::Result<std::path::PathBuf> {
    let root = workspace::target_folder().join("tools");
    let program = root.join("bin").join(format!("cargo-mutants{}", std::env::consts::EXE_SUFFIX));
    if !Path::new(&program).is_file() {
        eprintln!("installing cargo-mutants {VERSION}");
        let mut install = workspace::cargo(["install", "cargo-mutants", "--locked", "--version", VERSION]);
        child::run(install.arg("--root").arg(&root), echo)?;
    }
    Ok(program)
}

/// A regular expression that matches one name only.
fn exactly(name: &str) -> String {
    let mut expression = String::from("^");
    for letter in name.chars() {
        if r"\.+*?()|[]{}^$#&-~".contains(letter) {
            expression.push('\\');
        }
        expression.push(letter);
    }
    expression + "$"
}

#[cfg(test)]
mod tests {
    use super::exactly;

    #[test]
    fn a_name_becomes_an_expression_for_itself() {
        assert_eq!(
            exactly("src/a.rs:1:2: replace f -> Option<f64> with None"),
            "^src/a\\.rs:1:2: replace f \\-> Option<f64> with None$"
        );
    }
}
