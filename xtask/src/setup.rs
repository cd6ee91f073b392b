//! Finds what the jobs need from the machine, installs it, or reports how to install it.

use std::env;
use std::fs;
use std::io::{self, IsTerminal};
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, bail};

use crate::child;
use crate::wasm;
use crate::workspace::{self, TARGET};

/// The emulated board.
const MACHINE: &str = "netduinoplus2";
/// Debian's and Ubuntu's package of its emulator.
const QEMU: &str = "qemu-system-arm";
/// The package manager that fetches uPlot; its package has the same name.
const NPM: &str = "npm";
/// The browser that displays reports; its package has the same name.
const CHROMIUM: &str = "chromium";

/// The telemetry's client, in a venv of that name under Cargo's folder.
const PYMAVLINK: &str = "pymavlink";
/// Its requirements, with its version.
const PYMAVLINK_REQUIREMENTS: &str = "host-tests/telemetry/requirements.txt";
/// Debian's package that it needs.
const PYTHON: &str = "python3-venv";

/// Something that is not part of the checkout.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Need {
    /// The formatter.
    Rustfmt,
    /// The linter.
    Clippy,
    /// The standard library for the flight computer's target.
    Target,
    /// The standard library for a browser.
    Wasm,
    /// The emulator.
    Qemu,
    /// What fetches uPlot, without which the workbench does not build.
    Npm,
    /// The browser in which tests open reports.
    Chromium,
    /// The client with which tests read the telemetry.
    Pymavlink,
}

/// Result of providing a need.
pub enum Provided {
    /// It was already there.
    Found(String),
    /// It was missing and has been installed.
    Installed(String),
}

impl Need {
    /// Everything that any job needs.
    pub const ALL: [Self; 8] = [
        Self::Rustfmt,
        Self::Clippy,
        Self::Target,
        Self::Wasm,
        Self::Qemu,
        Self::Npm,
        Self::Chromium,
        Self::Pymavlink,
    ];

    /// Its name for users.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Rustfmt => "rustfmt",
            Self::Clippy => "clippy",
            Self::Target => TARGET,
            Self::Wasm => wasm::TARGET,
            Self::Qemu => QEMU,
            Self::Npm => NPM,
            Self::Chromium => CHROMIUM,
            Self::Pymavlink => PYMAVLINK,
        }
    }

    /// Its version or place, if it is there.
    fn find(self) -> Option<String> {
        match self {
            Self::Rustfmt => first_line(&mut workspace::cargo(["fmt", "--version"])),
            Self::Clippy => first_line(&mut workspace::cargo(["clippy", "--version"])),
            Self::Target => target_library(TARGET),
            Self::Wasm => target_library(wasm::TARGET),
            Self::Qemu => {
                let machines = child::run(workspace::program(QEMU).args(["-machine", "help"]), false).ok()?;
                machines.stdout.lines().find(|line| line.split(' ').next() == Some(MACHINE))?;
                first_line(workspace::program(QEMU).arg("--version"))
            }
            // A user who has uPlot's package does not need npm.
            Self::Npm => match env::var("PYLON_UPLOT") {
                Ok(folder) => Some(format!("uPlot in {folder}")),
                Err(_) => first_line(workspace::program(NPM).arg("--version")),
            },
            Self::Chromium => first_line(workspace::program(CHROMIUM).arg("--version")),
            Self::Pymavlink => {
                let wanted = fs::read_to_string(workspace::root().join(PYMAVLINK_REQUIREMENTS)).ok()?;
                let lines = wanted.lines().filter(|line| !line.is_empty() && !line.starts_with('#'));
                let wanted = lines.collect::<Vec<_>>().join(" ");
                let names: Vec<&str> =
                    wanted.split(' ').filter_map(|line| Some(line.split_once("==")?.0)).collect();
                let versions = format!(
                    "import importlib.metadata as m; print(*(n + '==' + m.version(n) for n in {names:?}))"
                );
                let found = first_line(workspace::program(pymavlink_python()).args(["-c", &versions]))?;
                (found == wanted).then_some(found)
            }
        }
    }

    /// The command that installs it.
    fn installation(self) -> anyhow::Result<Vec<Command>> {
        let rustup = |kind: &str, name: &str| {
            let mut command = workspace::program("rustup");
            command.args([kind, "add", name]);
            vec![command]
        };
        match self {
            Self::Rustfmt => Ok(rustup("component", "rustfmt")),
            Self::Clippy => Ok(rustup("component", "clippy")),
            Self::Target => Ok(rustup("target", TARGET)),
            Self::Wasm => Ok(rustup("target", wasm::TARGET)),
            Self::Qemu => install(QEMU, &format!("it must support `{QEMU} -machine {MACHINE}`")),
            Self::Npm => install(NPM, "part of Node.js"),
            Self::Chromium => install(CHROMIUM, "its command must be `chromium`"),
            Self::Pymavlink => {
                let has_venv =
                    first_line(workspace::program("python3").args(["-c", "import ensurepip; print(1)"]));
                let mut commands = match has_venv {
                    Some(_) => Vec::new(),
                    None => install(PYTHON, "Python 3.9 or newer with its venv module")?,
                };
                let mut venv = workspace::program("python3");
                venv.args(["-m", "venv", "--clear"]).arg(workspace::target_folder().join(PYMAVLINK));
                let mut pip = workspace::program(pymavlink_python());
                pip.args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check"]);
                pip.args(["--requirement", PYMAVLINK_REQUIREMENTS]);
                commands.extend([venv, pip]);
                Ok(commands)
            }
        }
    }
}

/// The Python interpreter that has the telemetry's client.
pub fn pymavlink_python() -> PathBuf {
    workspace::target_folder().join(PYMAVLINK).join("bin/python")
}

/// Finds a need; if it is missing, installs it and reports that on standard error.
pub fn provide(need: Need, echo: bool) -> anyhow::Result<Provided> {
    let name = need.name();
    if let Some(found) = need.find() {
        return Ok(Provided::Found(found));
    }
    let commands = need.installation().with_context(|| format!("{name} is missing"))?;
    let by_hand = commands.iter().map(child::shown).collect::<Vec<_>>().join(" && ");
    eprintln!("{name} is missing; installing it: {by_hand}");
    for mut command in commands {
        let outcome = child::run(&mut command, echo);
        // An outdated package list may still be good enough.
        if !child::shown(&command).ends_with("update") {
            outcome.with_context(|| {
                format!("{name} is missing and could not be installed; by hand: {by_hand}")
            })?;
        }
    }
    match need.find() {
        Some(found) => Ok(Provided::Installed(found)),
        None => bail!("{name} was installed and is still not found; by hand: {by_hand}"),
    }
}

/// Commands that install a package of Debian and Ubuntu. Elsewhere the user must install it; `hint` states
/// what is needed.
fn install(package: &str, hint: &str) -> anyhow::Result<Vec<Command>> {
    if !on_path("apt-get") {
        bail!("this machine has no apt-get; install {package} by hand: {hint}");
    }
    Ok(vec![
        apt(package, &["update"])?,
        apt(package, &["install", "--yes", "--no-install-recommends", package])?,
    ])
}

/// apt-get with these arguments, as root, in order to install a package.
fn apt(package: &str, arguments: &[&str]) -> anyhow::Result<Command> {
    let mut command = if nix::unistd::geteuid().is_root() {
        workspace::program("env")
    } else if on_path("sudo") {
        let mut sudo = workspace::program("sudo");
        // Without a terminal, no password can be typed.
        if !io::stdin().is_terminal() {
            sudo.arg("--non-interactive");
        }
        sudo.arg("env");
        sudo
    } else {
        bail!("only root may install packages; as root: apt-get install {package}");
    };
    command.arg("DEBIAN_FRONTEND=noninteractive").arg("apt-get");
    command.args(["-o", "Acquire::Retries=3", "-o", "DPkg::Lock::Timeout=300"]).args(arguments);
    Ok(command)
}

/// The first line of a program's output, if it succeeds.
fn first_line(command: &mut Command) -> Option<String> {
    let said = child::run(command, false).ok()?;
    said.stdout.lines().next().map(str::to_owned)
}

/// The folder of a target's standard library, if `core` is in it.
fn target_library(target: &str) -> Option<String> {
    let folder =
        first_line(workspace::program("rustc").args(["--print", "target-libdir", "--target", target]))?;
    let has_core = fs::read_dir(&folder)
        .ok()?
        .flatten()
        .any(|entry| entry.file_name().to_string_lossy().starts_with("libcore-"));
    has_core.then_some(folder)
}

fn on_path(name: &str) -> bool {
    env::var_os("PATH")
        .is_some_and(|path| env::split_paths(&path).any(|folder| is_program(&folder.join(name))))
}

fn is_program(path: &Path) -> bool {
    fs::metadata(path).is_ok_and(|file| file.is_file())
}
