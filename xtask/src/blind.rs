//! `cargo xtask blind`, `real-trials` and `baselines`: how often a diagnosis is right, compared with the
//! methods in use today.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, bail};

use crate::child;
use crate::cli::Baselines;
use crate::setup::{self, Need};
use crate::workspace;

/// A script of other methods, its requirements, and its folder under Cargo's.
struct Others {
    script: &'static str,
    requirements: &'static str,
    folder: &'static str,
}
/// Least squares, the LASSO and a state-space model, compared with the diagnosis.
const BESIDE_DIAGNOSIS: Others = Others {
    script: "host-tests/baselines/compare.py",
    requirements: "host-tests/baselines/requirements.txt",
    folder: "baselines",
};
/// Symbolic and sparse regression, compared with the search for laws.
const BESIDE_LAWS: Others = Others {
    script: "host-tests/baselines/laws.py",
    requirements: "host-tests/baselines/laws-requirements.txt",
    folder: "baselines-laws",
};
/// The page with the tables.
const PAGE: &str = "docs/blind-trials.md";
/// The lines of that page between which the tables are.
const BASELINES: Marks = Marks {
    begin: "<!-- tables: written by `cargo xtask baselines --write` -->",
    end: "<!-- end of the tables -->",
};
/// The same for the second family of flights.
const KINEMATIC_BASELINES: Marks = Marks {
    begin: "<!-- kinematic tables: written by `cargo xtask baselines --family kinematic --write` -->",
    end: "<!-- end of the kinematic tables -->",
};
/// The table of the development half of the real logs.
const DEVELOPMENT: Marks = Marks {
    begin: "<!-- development: written by `cargo xtask real-trials --write` -->",
    end: "<!-- end of development -->",
};
/// The table of the unseen half.
const UNSEEN: Marks = Marks {
    begin: "<!-- unseen: written by `cargo xtask real-trials --half unseen --write` -->",
    end: "<!-- end of unseen -->",
};

/// The page with the table of the trials for laws.
const LAWS_PAGE: &str = "docs/blind-laws.md";
/// That table.
const LAWS: Marks =
    Marks { begin: "<!-- laws: written by `cargo xtask laws --write` -->", end: "<!-- end of laws -->" };

/// The lines that enclose a table.
struct Marks {
    begin: &'static str,
    end: &'static str,
}

/// Flies blind trials; their lines and tables are printed to standard output as they are made.
pub fn run(trials: u64, seed: u64, family: &str, flies_advice: bool, verbose: bool) -> anyhow::Result<()> {
    let mut program = built("blind", verbose)?;
    program.args([&trials.to_string(), "--seed", &seed.to_string(), "--family", family]);
    if flies_advice {
        program.arg("--fly-advice");
    }
    if verbose {
        program.arg("--verbose");
    }
    // The program draws its own progress bar, so it needs the terminal.
    let status = program.status().with_context(|| format!("`{}`", child::shown(&program)))?;
    if !status.success() {
        bail!("`{}` ended with {status}", child::shown(&program));
    }
    Ok(())
}

/// Flies the trials, runs the other methods on the diagnosis's inputs, and prints both tables.
pub fn baselines(arguments: &Baselines, echo: bool) -> anyhow::Result<()> {
    let Baselines { trials, seed, family, .. } = arguments;
    // The script runs in the checkout's folder, which need not be the user's.
    let earlier = arguments.earlier.as_ref().map(|program| {
        program.canonicalize().with_context(|| format!("{} cannot be found", program.display()))
    });
    let earlier = earlier.transpose()?;
    let python = environment(&BESIDE_DIAGNOSIS, echo)?;
    let folder = emptied("blind-trials")?;
    let mut program = built("blind", echo)?;
    program.args([&trials.to_string(), "--seed", &seed.to_string(), "--family", family]);
    program.args(["--quiet", "--dump"]).arg(&folder);
    eprintln!("flying {trials} blind trials");
    let ours = child::run(&mut program, echo)?.stdout;
    eprintln!("fitting their residuals with other methods: takes some seconds each");
    let mut script = script(&BESIDE_DIAGNOSIS, python, &folder);
    if let Some(earlier) = earlier {
        script.arg("--earlier").arg(earlier);
    }
    let theirs = child::run(&mut script, echo)?.stdout;
    let text = tables(arguments, &ours, &theirs);
    print!("{text}");
    if arguments.write {
        let marks = if family == "kinematic" { &KINEMATIC_BASELINES } else { &BASELINES };
        write_page(marks, &text)?;
    }
    Ok(())
}

/// Tries a half of the real logs and prints the table; `write` also writes it into the page.
pub fn real(half: &str, write: bool, echo: bool) -> anyhow::Result<()> {
    let mut program = built("real_trials", echo)?;
    program.args(["--quiet", "--half", half]);
    eprintln!("diagnosing real logs and flights made from their tracks: takes some minutes");
    let said = child::run(&mut program, echo)?.stdout;
    println!("{}", said.trim());
    if write {
        let marks = if half == "unseen" { &UNSEEN } else { &DEVELOPMENT };
        let text =
            format!("`cargo xtask real-trials --half {half} --write`\n\n```text\n{}\n```", said.trim());
        write_page(marks, &text)?;
    }
    Ok(())
}

/// Searches flights for hidden laws, runs other methods on `beside` of them, and prints both tables; `write`
/// also writes them into their page.
pub fn laws(trials: u64, seed: u64, beside: u64, write: bool, echo: bool) -> anyhow::Result<()> {
    let mut program = built("laws", echo)?;
    program.args([&trials.to_string(), "--seed", &seed.to_string(), "--quiet"]);
    eprintln!("flying {trials} blind trials for laws");
    let ours = child::run(&mut program, echo)?.stdout;
    let mut said = ours.trim().to_owned();
    println!("{said}");
    let beside = beside.min(trials);
    if beside > 0 {
        let python = environment(&BESIDE_LAWS, echo)?;
        let folder = emptied("blind-laws")?;
        let mut program = built("laws", echo)?;
        program.args([&beside.to_string(), "--seed", &seed.to_string(), "--dump"]).arg(&folder);
        child::run(&mut program, echo)?;
        eprintln!("fitting {beside} of them with symbolic and sparse regression: about half a minute each");
        let theirs = child::run(&mut script(&BESIDE_LAWS, python, &folder), echo)?.stdout;
        println!("\n{}", theirs.trim());
        said = format!("{said}\n\n{}", theirs.trim());
    }
    if write {
        let text = format!(
            "`cargo xtask laws {trials} --seed {seed} --beside {beside} --write`\n\n```text\n{said}\n```"
        );
        write_to(LAWS_PAGE, &LAWS, &text)?;
    }
    Ok(())
}

/// Writes a table into the page.
fn write_page(marks: &Marks, text: &str) -> anyhow::Result<()> {
    write_to(PAGE, marks, text)
}

/// Writes a table into a page.
fn write_to(path: &str, marks: &Marks, text: &str) -> anyhow::Result<()> {
    let page = workspace::root().join(path);
    let old = fs::read_to_string(&page).with_context(|| format!("{path} cannot be read"))?;
    fs::write(&page, replaced(path, &old, marks, text)?)
        .with_context(|| format!("{path} cannot be written"))?;
    eprintln!("wrote {path}");
    Ok(())
}

/// Builds a program of the trials; returns the command.
fn built(program: &str, echo: bool) -> anyhow::Result<Command> {
    setup::provide(Need::Npm, echo)?;
    eprintln!("building the trials");
    child::run(
        &mut workspace::cargo(["build", "--release", "--package", "host-tests", "--bin", program]),
        echo,
    )?;
    let file = workspace::workbench().with_file_name(format!("{program}{}", std::env::consts::EXE_SUFFIX));
    Ok(workspace::program(file))
}

/// An emptied folder of that name under Cargo's.
fn emptied(name: &str) -> anyhow::Result<PathBuf> {
    let folder = workspace::target_folder().join(name);
    if folder.exists() {
        fs::remove_dir_all(&folder).with_context(|| format!("{} cannot be emptied", folder.display()))?;
    }
    Ok(folder)
}

/// The command that runs other methods on the files of a folder.
fn script(others: &Others, python: PathBuf, folder: &Path) -> Command {
    let mut script = workspace::program(python);
    // One thread a process: there is one process a core.
    script.arg(others.script).arg(folder).env("OMP_NUM_THREADS", "1").env("OPENBLAS_NUM_THREADS", "1");
    script
}

/// Python with a script's requirements, in its own folder under Cargo's; made once for each list of
/// requirements.
fn environment(others: &Others, echo: bool) -> anyhow::Result<PathBuf> {
    let requirements = others.requirements;
    let folder = workspace::target_folder().join(others.folder);
    let python = folder.join("bin/python");
    let wanted = fs::read_to_string(workspace::root().join(requirements))?;
    let installed = folder.join("installed.txt");
    if fs::read_to_string(&installed).is_ok_and(|text| text == wanted) {
        return Ok(python);
    }
    eprintln!("installing {requirements} into {}", workspace::shown(&folder));
    let mut venv = workspace::program("python3");
    child::run(venv.args(["-m", "venv", "--clear"]).arg(&folder), echo)
        .context("Python 3.11 or newer with its venv module is needed (Debian: python3-venv)")?;
    let mut pip = workspace::program(&python);
    pip.args([
        "-m",
        "pip",
        "install",
        "--quiet",
        "--disable-pip-version-check",
        "--requirement",
        requirements,
    ]);
    child::run(&mut pip, echo)?;
    fs::write(&installed, wanted)?;
    Ok(python)
}

/// Both tables, with the command that makes them.
fn tables(arguments: &Baselines, ours: &str, theirs: &str) -> String {
    let Baselines { trials, seed, family, earlier, .. } = arguments;
    let earlier =
        earlier.as_ref().map_or_else(String::new, |program| format!(" --earlier {}", program.display()));
    format!(
        "`cargo xtask baselines {trials} --seed {seed} --family {family}{earlier} --write`\n\n\
         ```text\n{}\n```\n\n{}\n",
        ours.trim(),
        theirs.trim()
    )
}

/// The page with the table between two lines replaced.
fn replaced(path: &str, page: &str, marks: &Marks, text: &str) -> anyhow::Result<String> {
    let Marks { begin, end } = marks;
    let (before, rest) = page.split_once(begin).with_context(|| format!("{path} has no line `{begin}`"))?;
    let (_, after) = rest.split_once(end).with_context(|| format!("{path} has no line `{end}`"))?;
    Ok(format!("{before}{begin}\n\n{}\n\n{end}{after}", text.trim()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_pages_tables_are_replaced_and_nothing_else() {
        let page = fs::read_to_string(workspace::root().join(PAGE)).unwrap();
        let arguments = Baselines {
            trials: 7,
            seed: 3,
            family: "kinematic".to_owned(),
            earlier: Some("../pylon".into()),
            write: true,
        };
        let text = tables(&arguments, "ours", "theirs");
        for marks in [&BASELINES, &KINEMATIC_BASELINES, &DEVELOPMENT, &UNSEEN] {
            let once = replaced(PAGE, &page, marks, &text).unwrap();
            let command = "`cargo xtask baselines 7 --seed 3 --family kinematic --earlier ../pylon --write`";
            assert!(once.contains(command), "{once}");
            assert_eq!(once.split(marks.begin).next(), page.split(marks.begin).next());
            assert_eq!(once.split(marks.end).last(), page.split(marks.end).last());
            assert_eq!(replaced(PAGE, &once, marks, &text).unwrap(), once);
        }
        assert!(replaced(PAGE, "# Nothing", &BASELINES, "").unwrap_err().to_string().contains("has no line"));
    }
}
