//! Accesses the real board through its debug probe: `probe-rs` writes the image and reads the log.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use anyhow::{Context, bail};

use crate::child::{self, Failure};
use crate::setup::{self, Need};
use crate::workspace::{self, TARGET};

/// The chip's name in `probe-rs`.
const CHIP: &str = "STM32F405RGTx";

/// The barometer on the board.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Barometer {
    /// MS5611
    Ms5611,
    /// BMP390, on the same pins
    Bmp390,
}

/// Advice if `probe-rs` is missing.
const MISSING: &str = "\
probe-rs is missing: it writes the image through a debug probe (ST-LINK, J-Link, CMSIS-DAP). Install it with one of
  cargo install probe-rs-tools --locked
  curl -LsSf https://github.com/probe-rs/probe-rs/releases/latest/download/probe-rs-tools-installer.sh | sh
On Linux its probes need udev rules: https://probe.rs/docs/getting-started/probe-setup/";

/// Advice if no probe is found.
const NO_PROBE: &str = "\
probe-rs finds no debug probe. Is it plugged in, by a cable that carries data? On Linux: may this user open it (udev rules,
https://probe.rs/docs/getting-started/probe-setup/)? `probe-rs list` shows what there is; docs/bring-up.md has the wiring.";

/// Advice if nothing has been flashed yet.
const NOT_FLASHED: &str = "\
nothing has been written to a board from this checkout; run `cargo xtask flash` first: the log can only be read with the very
image that runs";

/// Builds the flight computer's image for the real board with a model, writes it and starts it.
///
/// # Errors
/// `probe-rs` or a probe is missing; the model cannot be read; the image cannot be built or written.
pub fn flash(model: &str, barometer: Barometer, probe: Option<&str>, echo: bool) -> anyhow::Result<()> {
    check_probe(echo)?;
    setup::provide(Need::Target, echo)?;
    eprintln!("building the image with model {model}");
    child::run(&mut image(model, barometer), echo).context("the image does not build")?;
    let built = built_image();
    eprintln!("writing {}", workspace::shown(&built));
    child::run(&mut download(&built, probe), echo).context("the image could not be written")?;
    fs::copy(&built, flashed_image()).with_context(|| workspace::shown(&built))?;
    child::run(&mut reset(probe), echo).context("the board could not be started")?;
    println!("written and started; `cargo xtask log` reads its log");
    Ok(())
}

/// Shows the log of the running board, until interrupted.
///
/// # Errors
/// `probe-rs` or a probe is missing; nothing has been flashed; the probe lost the board.
pub fn log(probe: Option<&str>, echo: bool) -> anyhow::Result<()> {
    let image = flashed_image();
    if !image.is_file() {
        bail!(NOT_FLASHED);
    }
    check_probe(echo)?;
    let mut attach = attach(&image, probe);
    let shown = child::shown(&attach);
    eprintln!("$ {shown}");
    // The user reads it as it arrives, and interrupts it.
    let status = attach.stdin(Stdio::inherit()).status().with_context(|| shown.clone())?;
    if !status.success() {
        bail!("`{shown}` ended with {status}");
    }
    Ok(())
}

/// Checks that `probe-rs` and a probe are there; the error gives advice.
fn check_probe(echo: bool) -> anyhow::Result<()> {
    let probes = match child::run(&mut probe_rs("list", None), echo) {
        Ok(said) => said.all,
        Err(Failure::NotStarted { error, .. }) if error.kind() == io::ErrorKind::NotFound => bail!(MISSING),
        Err(failure) => return Err(failure.into()),
    };
    if has_no_probe(&probes) {
        bail!(NO_PROBE);
    }
    Ok(())
}

/// Whether this is the output of `probe-rs list` without a probe.
fn has_no_probe(said: &str) -> bool {
    said.contains("No debug probes were found")
}

/// The build of the image with a model: a file, or a preset's name; the firmware's build has further presets.
fn image(model: &str, barometer: Barometer) -> Command {
    let board = match barometer {
        Barometer::Ms5611 => "board-f405",
        Barometer::Bmp390 => "board-f405,baro-bmp390",
    };
    // If the word is only in a comment, the image is larger than necessary; without the feature the build
    // refuses a formula.
    let has_formulas = fs::read_to_string(model).is_ok_and(|text| text.contains("effect_definition"));
    let features = if has_formulas { format!("{board},formulas") } else { board.to_owned() };
    let mut build = workspace::firmware_build("flight", &features);
    // The build runs in the firmware's folder, so the path must be absolute.
    let model = fs::canonicalize(model).unwrap_or_else(|_| PathBuf::from(model));
    build.env("PYLON_MODEL", model).env("DEFMT_LOG", "info");
    // Neither a deliberate error nor another model may be flashed.
    build.env_remove("PYLON_MUTATE").env_remove("PYLON_MODEL_SOURCE");
    build
}

fn built_image() -> PathBuf {
    workspace::root().join("target/flight-computer").join(TARGET).join("firmware/flight")
}

/// The image that was last written to a board.
fn flashed_image() -> PathBuf {
    workspace::root().join("target/flight-computer/flashed.elf")
}

fn download(image: &Path, probe: Option<&str>) -> Command {
    let mut command = probe_rs("download", probe);
    command.args(["--chip", CHIP, "--non-interactive", "--verify"]).arg(image);
    command
}

fn reset(probe: Option<&str>) -> Command {
    let mut command = probe_rs("reset", probe);
    command.args(["--chip", CHIP, "--non-interactive"]);
    command
}

fn attach(image: &Path, probe: Option<&str>) -> Command {
    let mut command = probe_rs("attach", probe);
    // By default `probe-rs` halts the core on a fault or reset; the flight computer must restart by itself.
    command.args(["--chip", CHIP, "--no-catch-hardfault", "--no-catch-reset"]).arg(image);
    command
}

fn probe_rs(job: &str, probe: Option<&str>) -> Command {
    let mut command = workspace::program("probe-rs");
    command.arg(job);
    if let Some(probe) = probe {
        command.args(["--probe", probe]);
    }
    command
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_lines_are_those_of_probe_rs() {
        let image = Path::new("a b.elf");
        assert_eq!(
            child::shown(&download(image, None)),
            "probe-rs download --chip STM32F405RGTx --non-interactive --verify 'a b.elf'"
        );
        assert_eq!(
            child::shown(&attach(image, Some("0483:3748"))),
            "probe-rs attach --probe 0483:3748 --chip STM32F405RGTx --no-catch-hardfault --no-catch-reset 'a b.elf'"
        );
        assert_eq!(
            child::shown(&reset(Some("0483:3748"))),
            "probe-rs reset --probe 0483:3748 --chip STM32F405RGTx --non-interactive"
        );
    }

    #[test]
    fn the_image_has_the_model_and_no_planted_error() {
        let build = image("paper", Barometer::Ms5611);
        let value = |name: &str| build.get_envs().find(|(key, _)| *key == name).map(|(_, value)| value);
        assert_eq!(value("PYLON_MODEL"), Some(Some("paper".as_ref())));
        assert_eq!(value("PYLON_MUTATE"), Some(None));
        assert_eq!(value("PYLON_MODEL_SOURCE"), Some(None));
        let shown = child::shown(&build);
        assert!(shown.contains("--features board-f405 --profile firmware --target thumbv7em"), "{shown}");
    }

    #[test]
    fn a_model_file_is_given_by_a_path_that_holds_in_every_folder() {
        let here = file!();
        let file = workspace::root().join(here);
        let build = image(&file.display().to_string(), Barometer::Bmp390);
        let model = build.get_envs().find(|(key, _)| *key == "PYLON_MODEL").unwrap().1.unwrap();
        assert!(Path::new(model).is_absolute() && Path::new(model).ends_with(here), "{model:?}");
    }

    #[test]
    fn no_probe_is_told_from_one() {
        assert!(has_no_probe("No debug probes were found.\n"));
        assert!(!has_no_probe(
            "The following debug probes were found:\n[0]: STLink V2 -- 0483:3748:2B4907 (ST-LINK)\n"
        ));
    }
}
