//! Builds the firmware.

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::SystemTime;

use model::{Model, codegen};

use super::error::FlyError;
use super::made_of;
use super::old_images::prune;
use super::registry_paths;

/// The flight computer's target.
pub const TARGET: &str = "thumbv7em-none-eabihf";

/// A board of the firmware.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Board {
    /// The emulated one.
    Qemu,
    /// The microcontroller of the flight computer, fed through its debug link.
    Hil,
    /// The flight computer.
    F405,
}

impl Board {
    const fn feature(self) -> &'static str {
        match self {
            Self::Qemu => "board-qemu",
            Self::Hil => "board-hil",
            Self::F405 => "board-f405",
        }
    }
}

/// An image that can be built.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Program {
    /// The flight computer's.
    Flight(Board),
    /// The benchmark against published filters.
    Bench,
    /// The check of the copies of aligned memory.
    CopyCheck,
    /// The mission's tick and nothing else.
    CoreOnly,
    /// The chain of a tick: the drivers and the mission.
    ChainOnly,
}

impl Program {
    const fn binary(self) -> &'static str {
        match self {
            Self::Flight(_) => "flight",
            Self::Bench => "bench",
            Self::CopyCheck => "copy_check",
            Self::CoreOnly => "core_only",
            Self::ChainOnly => "chain_only",
        }
    }

    const fn package(self) -> &'static str {
        match self {
            Self::Bench => "bench",
            Self::Flight(_) | Self::CopyCheck | Self::CoreOnly | Self::ChainOnly => "firmware",
        }
    }

    fn features(self, model: &Model) -> String {
        let board = match self {
            Self::Flight(board) => board.feature(),
            Self::Bench | Self::CopyCheck => "board-qemu",
            Self::CoreOnly | Self::ChainOnly => "",
        };
        let has_formulas = matches!(self, Self::Flight(_)) && !model.definitions().is_empty();
        if has_formulas { format!("{board},formulas") } else { board.to_owned() }
    }

    /// Cargo settings that override the profile. The benchmark compares filters, each as fast as the compiler
    /// makes it; the flight's image has to fit.
    const fn settings(self) -> &'static [&'static str] {
        match self {
            Self::Bench => &[
                "--config=profile.firmware.opt-level=3",
                "--config=profile.firmware.package.kf-core.opt-level=3",
            ],
            Self::Flight(_) | Self::CopyCheck | Self::CoreOnly | Self::ChainOnly => &[],
        }
    }
}

/// An error or load planted in an image, to prove that it is found or withstood.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlantedError {
    /// Every barometer reading is one unit in the last place off.
    Ulp,
    /// A panic in the second tick.
    Panic,
    /// A fault of the core in the second tick.
    Fault,
    /// A processor that seldom has time for anything except the ticks: not an error, and the flight must lose
    /// nothing.
    Starve,
    /// Faults that the emulated board reads from a file ([`flight_record::Strike`]).
    Strike,
    /// A telemetry line with a tenth of the byte rate: frames are dropped, and the flight must lose nothing.
    SlowLine,
    /// A telemetry line that is never idle: where no frame waits, an empty one is sent.
    FullLine,
    /// A telemetry line on which nothing is sent.
    SilentLine,
}

impl PlantedError {
    const fn name(self) -> &'static str {
        match self {
            Self::Ulp => "ulp",
            Self::Panic => "panic",
            Self::Fault => "fault",
            Self::Starve => "starve",
            Self::Strike => "strike",
            Self::SlowLine => "slow_line",
            Self::FullLine => "full_line",
            Self::SilentLine => "silent_line",
        }
    }
}

/// Builds an image and returns its path; one that was built from the same sources is used again. Images are
/// kept apart by program, board, model and planted error, so that several can be built and run at the same
/// time.
///
/// # Errors
/// [`FlyError::NoSource`], [`FlyError::NoCargo`], [`FlyError::NoTarget`], [`FlyError::Build`] with the
/// compiler's first error, [`FlyError::Model`], [`FlyError::Io`].
pub fn build(program: Program, model: &Model, planted: Option<PlantedError>) -> Result<PathBuf, FlyError> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    if !root.join("firmware/Cargo.toml").is_file() {
        return Err(FlyError::NoSource { path: root.join("firmware").display().to_string() });
    }
    let compiler = check_target(&root)?;
    model.check_signals(match program {
        Program::Flight(Board::F405) => model::Board::F405,
        _ => model::Board::Recorded,
    })?;
    let fingerprint = model.fingerprint()?;
    let generated = codegen(model)?;
    let target_directory = root.join("target/flight-computer");
    let images = target_directory.join("images");
    fs::create_dir_all(&images).map_err(FlyError::io(images.display().to_string()))?;

    let board = program.features(model);
    let planted_name = planted.map_or("", PlantedError::name);
    let image = images.join(format!("{}-{board}-{fingerprint:016x}-{planted_name}.elf", program.binary()));
    let flags = registry_paths::compiler_flags();
    let named_flags = flags.to_string_lossy();
    let made_by = [&*compiler, &generated, program.package(), &*named_flags];
    let settings = [&made_by[..], program.settings()].concat();
    let key = made_of::key(&root, &settings).map_err(FlyError::io(root.display().to_string()))?;
    if made_of::is_current(&image, &key) {
        return Ok(image);
    }

    // From the build to the copy of its result, builds of other models must wait.
    let lock_file = target_directory.join("image.lock");
    let lock = File::create(&lock_file).map_err(FlyError::io(lock_file.display().to_string()))?;
    lock.lock().map_err(FlyError::io(lock_file.display().to_string()))?;

    // The previous holder of the lock may have built it.
    if made_of::is_current(&image, &key) {
        return Ok(image);
    }
    let source = images.join(format!("model-{fingerprint:016x}.rs"));
    write_if_changed(&source, &generated)?;
    let mut cargo = Command::new("cargo");
    cargo
        .current_dir(&root)
        .args(["build", "--quiet", "--package", program.package(), "--bin", program.binary()])
        .args(["--profile", "firmware", "--target", TARGET, "--features", &board])
        .args(program.settings())
        .arg("--target-dir")
        .arg(&target_directory)
        .env("PYLON_MODEL_SOURCE", &source)
        .env("DEFMT_LOG", "info")
        .env_remove("PYLON_TELEMETRY_BAUD")
        .env_remove("PYLON_MUTATE");
    // A host's flags (for a coverage run, for example) are not the target's.
    for variable in ["RUSTFLAGS", "CARGO_TARGET_DIR", "CARGO_BUILD_TARGET"] {
        cargo.env_remove(variable);
    }
    cargo.env("CARGO_ENCODED_RUSTFLAGS", flags);
    if let Some(planted) = planted {
        cargo.env("PYLON_MUTATE", planted.name());
    }
    let output = cargo.output().map_err(|error| match error.kind() {
        io::ErrorKind::NotFound => FlyError::NoCargo,
        _ => FlyError::Io { what: "cargo build of the firmware".to_owned(), source: error },
    })?;
    if !output.status.success() {
        let messages = String::from_utf8_lossy(&output.stderr);
        let first_error = messages.lines().find(|line| line.trim_start().starts_with("error"));
        let first_error = first_error.unwrap_or("cargo printed nothing").trim().to_owned();
        return Err(FlyError::Build { first_error });
    }

    let built = target_directory.join(TARGET).join("firmware").join(program.binary());
    made_of::forget(&image).map_err(FlyError::io(image.display().to_string()))?;
    // Renamed into place: another process may be running the image that was there.
    let copy = image.with_extension("new");
    fs::copy(&built, &copy).map_err(FlyError::io(built.display().to_string()))?;
    fs::rename(&copy, &image).map_err(FlyError::io(image.display().to_string()))?;
    made_of::keep(&image, &key).map_err(FlyError::io(image.display().to_string()))?;
    prune(&images, SystemTime::now()).map_err(FlyError::io(images.display().to_string()))?;
    Ok(image)
}

/// Which compiler will be used; it must have the target's library.
fn check_target(root: &Path) -> Result<String, FlyError> {
    let directory = rustc(root, &["--print", "target-libdir", "--target", TARGET])?;
    if !Path::new(directory.trim()).is_dir() {
        return Err(FlyError::NoTarget { target: TARGET });
    }
    rustc(root, &["--version", "--verbose"])
}

/// The compiler's answer; empty where it fails.
fn rustc(root: &Path, arguments: &[&str]) -> Result<String, FlyError> {
    let output =
        Command::new("rustc").current_dir(root).args(arguments).output().map_err(|error| {
            match error.kind() {
                io::ErrorKind::NotFound => FlyError::NoCargo,
                _ => FlyError::Io { what: "rustc".to_owned(), source: error },
            }
        })?;
    let said = if output.status.success() { output.stdout } else { Vec::new() };
    Ok(String::from_utf8_lossy(&said).into_owned())
}

/// Leaves the file's time unchanged where nothing changes, so that cargo need not build again.
fn write_if_changed(file: &Path, text: &str) -> Result<(), FlyError> {
    if fs::read_to_string(file).is_ok_and(|old| old == text) {
        return Ok(());
    }
    fs::write(file, text).map_err(FlyError::io(file.display().to_string()))
}
