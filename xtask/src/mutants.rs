//! `cargo xtask mutants`: what share of deliberate errors the tests of a crate catch.

use std::fs;
use std::path::Path;

use anyhow::{Context, bail};
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;

use crate::child;
use crate::workspace;

/// The version that was tried.
const VERSION: &str = "27.1.0";
/// Mutants that end with this many seconds of tests unfinished count as caught.
const TIMEOUT_S: &str = "120";

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
        names.truncate(sample);
    }
    eprintln!("{} of {total} mutants of {package}", names.len());
    let mut mutants = workspace::program(&program);
    mutants.args(["mutants", "--package", package, "--test-package", package, "--no-shuffle", "--jobs", "1"]);
    mutants.args(["--timeout", TIMEOUT_S, "--output"]).arg(&folder);
    for name in names {
        mutants.args(["--re", &exactly(name)]);
    }
    let status = mutants.status().with_context(|| format!("`{}`", program.display()))?;
    let outcomes = folder.join("mutants.out");
    let count = |file: &str| fs::read_to_string(outcomes.join(file)).map_or(0, |text| text.lines().count());
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

/// cargo-mutants, built into the target folder once.
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

/// A regular expression for one name and nothing else.
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
