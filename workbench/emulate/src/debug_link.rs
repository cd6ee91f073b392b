//! A board on its debug link: OpenOCD writes the image and serves the image's semihosting calls.
//!
//! This relies on OpenOCD's manual and source (0.12); it has not been tried on a board yet:
//! - A call of the host is the instruction `bkpt 0xab`. It halts the core; OpenOCD serves the call and
//!   resumes the core.
//! - Files are in the directory that OpenOCD runs in. The image's standard output goes to OpenOCD's standard
//!   output; OpenOCD's own messages go to its standard error.
//! - The call that ends a flight (`SYS_EXIT_EXTENDED`, since OpenOCD 0.11) ends OpenOCD with the image's exit
//!   status.
//! - By default OpenOCD looks for a call ten times a second. `wait_halt` looks all the time, and returns only
//!   when the core stops for another reason.

use std::fs::{self, File};
use std::io::{self, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use flight_record::{ExitStatus, OUTPUT_FILE};

use super::emulator::Emulation;
use super::error::FlyError;
use super::image::Image;
use super::run::name;

/// OpenOCD's own configuration file of the microcontroller.
const MICROCONTROLLER: &str = "target/stm32f4x.cfg";
/// The image, in the flight's folder: a name without characters that are special in a shell or in Tcl.
const IMAGE_FILE: &str = "flight.elf";
/// What the image logged, in the same folder.
const STDOUT_FILE: &str = "image.log";
/// What OpenOCD wrote to its standard error.
const STDERR_FILE: &str = "openocd.log";
/// End of the RAM that is retained over a reset (`memory.x`).
const RAM_END: u64 = 0x2002_0000;
/// Oldest OpenOCD that passes on an exit status: 0.11.
const OLDEST: u32 = 11;
/// Message when the core stops for any reason but a call of the host.
const HALTED: &str = "pylon: the core has stopped, and not for a call of the host";
/// How often the flight's progress is polled.
const LOOK: Duration = Duration::from_millis(50);

/// A probe on a board's debug link.
#[derive(Clone, Debug)]
pub struct DebugLink {
    /// OpenOCD's program: its name or its path.
    pub openocd: PathBuf,
    /// Configuration files of the probe, such as `interface/stlink.cfg`, in this order: OpenOCD's own or the
    /// user's.
    pub probe: Vec<PathBuf>,
    /// Longest silence: no new output of OpenOCD and no new results.
    pub silence: Duration,
    /// The flight's progress.
    pub progress: Arc<TicksFlown>,
}

impl Default for DebugLink {
    /// An ST-LINK, the installed OpenOCD, and two minutes.
    fn default() -> Self {
        Self {
            openocd: PathBuf::from("openocd"),
            probe: vec![PathBuf::from("interface/stlink.cfg")],
            silence: Duration::from_secs(120),
            progress: Arc::default(),
        }
    }
}

/// Progress of a flight on a board, for another thread to read.
#[derive(Debug, Default)]
pub struct TicksFlown {
    done: AtomicU64,
    of: AtomicU64,
}

impl TicksFlown {
    /// Ticks whose results have arrived, and ticks in all; zero in all before the flight is ready.
    #[must_use]
    pub fn so_far(&self) -> (u64, u64) {
        (self.done.load(Ordering::Relaxed), self.of.load(Ordering::Relaxed))
    }
}

impl DebugLink {
    /// Checks that a suitable OpenOCD is installed, before an image is built for it.
    ///
    /// # Errors
    /// [`FlyError::NoDebugger`], [`FlyError::OldDebugger`], [`FlyError::Io`].
    pub(super) fn check(&self) -> Result<(), FlyError> {
        let output = Command::new(&self.openocd)
            .arg("--version")
            .stdin(Stdio::null())
            .output()
            .map_err(|error| self.not_started(error))?;
        let said = [output.stdout, output.stderr].concat();
        match version(&String::from_utf8_lossy(&said)) {
            Some(minor) if minor < OLDEST => Err(FlyError::OldDebugger { minor }),
            // One that does not report its version is given a chance.
            Some(_) | None => Ok(()),
        }
    }

    /// Writes an image to the board and lets it fly the record of `ticks` ticks in `directory`, until it ends
    /// the flight itself.
    ///
    /// # Errors
    /// [`FlyError::NoDebugger`], [`FlyError::NoProbe`], [`FlyError::NoBoard`], [`FlyError::NotWritten`],
    /// [`FlyError::DebugLink`], [`FlyError::Silent`], [`FlyError::Image`], [`FlyError::NoRetained`],
    /// [`FlyError::Io`].
    pub(super) fn fly(&self, image: &Path, directory: &Path, ticks: u32) -> Result<Emulation, FlyError> {
        let retained = Image::read(image)?
            .retained_start
            .ok_or_else(|| FlyError::NoRetained { path: image.display().to_string() })?;
        let here = |file: &str| directory.join(file);
        fs::copy(image, here(IMAGE_FILE)).map_err(FlyError::io(image.display().to_string()))?;
        let create = |file: &str| File::create(here(file)).map_err(FlyError::io(file));
        let openocd = Command::new(&self.openocd)
            .args(arguments(&self.probe, retained))
            .current_dir(directory)
            .stdin(Stdio::null())
            .stdout(create(STDOUT_FILE)?)
            .stderr(create(STDERR_FILE)?)
            .spawn()
            .map_err(|error| self.not_started(error))?;
        self.progress.of.store(ticks.into(), Ordering::Relaxed);
        let code = self.watch(Running(openocd), directory)?;
        let stderr = said(&here(STDERR_FILE))?;
        if code.and_then(ExitStatus::from_code).is_none() {
            return Err(failure(&stderr));
        }
        let stdout = fs::read(here(STDOUT_FILE)).map_err(FlyError::io(STDOUT_FILE))?;
        // OpenOCD's output is of interest only if it failed.
        Ok(Emulation { code, stdout, stderr: String::new() })
    }

    /// Waits for the end, as long as there is any output, and counts the ticks.
    fn watch(&self, mut openocd: Running, directory: &Path) -> Result<Option<i32>, FlyError> {
        let output = directory.join(name(OUTPUT_FILE)?);
        let (mut heard, mut heard_at) = (0, Instant::now());
        let mut frames = Frames::default();
        loop {
            if let Some(status) = openocd.0.try_wait().map_err(FlyError::io("waiting for openocd"))? {
                return Ok(status.code());
            }
            // A file that does not exist yet counts as empty.
            frames.count(&output).map_err(FlyError::io(output.display().to_string()))?;
            // The first frame is the header.
            self.progress.done.store(frames.seen.saturating_sub(1), Ordering::Relaxed);
            let length = |file: &str| fs::metadata(directory.join(file)).map_or(0, |data| data.len());
            let now = frames.read + length(STDOUT_FILE) + length(STDERR_FILE);
            if now != heard {
                (heard, heard_at) = (now, Instant::now());
            } else if heard_at.elapsed() > self.silence {
                let said = said(&directory.join(STDERR_FILE))?;
                return Err(FlyError::Silent {
                    seconds: self.silence.as_secs(),
                    said: telling_line(&said).to_owned(),
                });
            }
            thread::sleep(LOOK);
        }
    }

    fn not_started(&self, error: io::Error) -> FlyError {
        match error.kind() {
            io::ErrorKind::NotFound => FlyError::NoDebugger,
            _ => FlyError::Io { what: self.openocd.display().to_string(), source: error },
        }
    }
}

/// OpenOCD's arguments.
fn arguments(probe: &[PathBuf], retained: u64) -> Vec<PathBuf> {
    let mut arguments = Vec::new();
    let mut option = |name: &str, value: PathBuf| arguments.extend([PathBuf::from(name), value]);
    for file in probe {
        // A user's file is relative to the user's directory, not the flight's; all others are OpenOCD's.
        option("-f", fs::canonicalize(file).unwrap_or_else(|_| file.clone()));
    }
    option("-f", MICROCONTROLLER.into());
    let words = RAM_END.saturating_sub(retained) / 4;
    for command in [
        // No other program shall interfere, and ports in use shall not matter.
        "gdb_port disabled",
        "tcl_port disabled",
        "telnet_port disabled",
        "init",
        &format!("program {IMAGE_FILE} verify"),
        // `program` leaves the PLL on.
        "reset halt",
        // Otherwise a flight that was cut off would continue.
        &format!("mww {retained:#x} 0 {words}"),
        // The image handles its faults. Where a probe's firmware does the debugging, the command does not
        // exist.
        "catch {cortex_m vector_catch none}",
        "arm semihosting enable",
        "resume",
        "wait_halt 2147483647",
        &format!("echo {{{HALTED}}}"),
        "shutdown error",
    ] {
        option("-c", command.into());
    }
    arguments
}

/// A program that is killed when its handle is dropped.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        // Most often it has already ended, and there is nothing to stop.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Counts the frames of a growing file.
#[derive(Default)]
struct Frames {
    read: u64,
    seen: u64,
}

impl Frames {
    fn count(&mut self, path: &Path) -> io::Result<()> {
        let mut file = match File::open(path) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(()),
            other => other?,
        };
        file.seek(SeekFrom::Start(self.read))?;
        let mut new = Vec::new();
        self.read += file.read_to_end(&mut new)? as u64;
        // A frame ends with the only zero byte in it.
        self.seen += new.iter().filter(|byte| **byte == 0).count() as u64;
        Ok(())
    }
}

fn said(file: &Path) -> Result<String, FlyError> {
    let bytes = fs::read(file).map_err(FlyError::io(file.display().to_string()))?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

/// The `12` of `Open On-Chip Debugger 0.12.0`; `None` for anything else, such as a version 1.
fn version(said: &str) -> Option<u32> {
    let (_, rest) = said.split_once("Open On-Chip Debugger 0.")?;
    let digits = rest.find(|digit: char| !digit.is_ascii_digit()).unwrap_or(rest.len());
    rest.get(..digits)?.parse().ok()
}

/// OpenOCD's messages without a probe, or when it may not open it.
const NO_PROBE: &[&str] = &[
    "Error: open failed",
    "LIBUSB_ERROR_ACCESS",
    "unable to find a matching CMSIS-DAP device",
    "unable to open CMSIS-DAP device",
    "No J-Link device found",
];
/// Its messages when nothing is connected at the other end of the wires.
const NO_BOARD: &[&str] = &[
    "unable to connect to the target",
    "Error connecting DP",
    "Could not find MEM-AP",
    "xamination failed",
    "Target not examined",
    "Unable to reset target",
];
/// Its messages when writing the flash fails.
const NOT_WRITTEN: &[&str] = &["** Programming Failed **", "** Verify Failed **"];

/// Why OpenOCD ended without the image's exit status.
fn failure(stderr: &str) -> FlyError {
    let said = telling_line(stderr).to_owned();
    let says = |any: &[&str]| any.iter().any(|words| stderr.contains(words));
    if says(NO_PROBE) {
        FlyError::NoProbe { said }
    } else if says(NO_BOARD) {
        FlyError::NoBoard { said }
    } else if says(NOT_WRITTEN) {
        FlyError::NotWritten { said }
    } else {
        FlyError::DebugLink { said }
    }
}

/// The most informative line: the first error, else the last line.
fn telling_line(stderr: &str) -> &str {
    let lines = || stderr.lines().map(str::trim).filter(|line| !line.is_empty());
    let telling = |line: &&str| line.starts_with("Error") || line.contains("Failed **") || *line == HALTED;
    lines().find(telling).or_else(|| lines().next_back()).unwrap_or("it printed nothing")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn versions_are_told_apart() {
        assert_eq!(version("Open On-Chip Debugger 0.12.0\nLicensed under"), Some(12));
        assert_eq!(version("xPack Open On-Chip Debugger 0.12.0+dev-01557"), Some(12));
        assert_eq!(version("Open On-Chip Debugger 0.10.0"), Some(10));
        assert_eq!(version("Open On-Chip Debugger 1.0.0"), None);
        assert_eq!(version(""), None);
    }

    /// Lines as users have quoted them from OpenOCD 0.10 to 0.12.
    #[test]
    fn failures_are_told_apart_by_what_openocd_says() {
        let kind = |said: &str| match failure(said) {
            FlyError::NoProbe { .. } => "probe",
            FlyError::NoBoard { .. } => "board",
            FlyError::NotWritten { .. } => "flash",
            FlyError::DebugLink { .. } => "link",
            other => panic!("{other}"),
        };
        assert_eq!(kind("Info : clock speed 2000 kHz\nError: open failed\n"), "probe");
        assert_eq!(kind("Error: unable to find a matching CMSIS-DAP device\n"), "probe");
        assert_eq!(kind("Error: No J-Link device found\n"), "probe");
        assert_eq!(
            kind("Info : Target voltage: 3.29\nError: init mode failed (unable to connect to the target)\n"),
            "board"
        );
        assert_eq!(kind("Error: Error connecting DP: cannot read IDR\n"), "board");
        assert_eq!(kind("** Programming Started **\n** Programming Failed **\n"), "flash");
        assert_eq!(kind("** Verify Started **\n** Verify Failed **\n"), "flash");
        assert_eq!(kind("embedded:startup.tcl:28: Error: Can't find interface/my.cfg\n"), "link");
        assert_eq!(kind(""), "link");
    }

    #[test]
    fn the_line_that_says_most_is_the_first_error_or_the_last_word() {
        assert_eq!(telling_line("Info : a\nError: b\nError: c\nd\n"), "Error: b");
        assert_eq!(telling_line("Info : a\n** Verify Failed **\nshutdown\n"), "** Verify Failed **");
        assert_eq!(telling_line(&format!("Info : a\n{HALTED}\nshutdown command invoked\n")), HALTED);
        assert_eq!(telling_line("Info : a\nb\n\n"), "b");
        assert_eq!(telling_line(""), "it printed nothing");
    }

    #[test]
    fn a_file_of_the_users_is_found_from_the_flights_folder_and_openocds_own_is_left_to_it() {
        let file = tempfile::NamedTempFile::new().unwrap();
        let arguments = arguments(&["interface/jlink.cfg".into(), file.path().into()], 0x2001_f000);
        let expected = fs::canonicalize(file.path()).unwrap();
        assert_eq!(arguments[..2], [PathBuf::from("-f"), "interface/jlink.cfg".into()]);
        assert_eq!(arguments[2..4], [PathBuf::from("-f"), expected]);
    }

    #[test]
    fn frames_are_counted_as_they_come() {
        let file = tempfile::NamedTempFile::new().unwrap();
        let mut frames = Frames::default();
        for (bytes, seen) in [(&b"ab\0c"[..], 1), (b"ab\0cd\0", 2), (b"ab\0cd\0\0", 3)] {
            fs::write(file.path(), bytes).unwrap();
            frames.count(file.path()).unwrap();
            assert_eq!((frames.read, frames.seen), (bytes.len() as u64, seen));
        }
        frames.count(Path::new("not there")).unwrap();
    }
}
