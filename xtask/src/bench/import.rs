//! Time and memory of importing a log, compared with the format's reference reader on the same file in one
//! run.

use std::fs;
use std::path::Path;

use comfy_table::Cell;
use serde::Serialize;

use super::figure::Figure;
use super::measure::{self, Cost};
use crate::child;
use crate::setup;
use crate::table::{plain, right};
use crate::workspace;

/// Times that every command is run. Other load on the machine only makes it slower, so the shortest time
/// counts.
const ROUNDS: usize = 5;
/// Where the real logs are, beside the checkout.
const LOGS: &str = "../shared/flights/real";
/// A log so short that its import shows the program's own memory: its code read from the disk, and its
/// threads.
const SHORT: &str = "igc/goigc_short1.igc";
/// Smallest log whose memory is compared with its size: below it, most memory is the program's own.
const MEASURABLE_BYTES: u64 = 1_000_000;
/// The longest real log of each kind, and the reader that users of its format have.
const FILES: [(&str, &str); 5] = [
    ("ulog/frrs_ekf_failure.ulg", "pyulog"),
    ("dataflash/pymav_test.BIN", "pymavlink"),
    ("tlog/dronekit_flight_replay.tlog", "pymavlink"),
    ("igc_many/goigc2_2023-10-28-xna-150420-01.igc", "aerofiles"),
    ("igc/igclib_flight_with_middle_landing.igc", "aerofiles"),
];
/// Reads the whole file with that reader; without a file, only loads the reader.
const READ: &str = r#"
import sys
reader, file = sys.argv[1], sys.argv[2:]
if reader == "pyulog":
    from pyulog import ULog
    for path in file:
        ULog(path)
elif reader == "pymavlink":
    from pymavlink import mavutil
    for path in file:
        log = mavutil.mavlink_connection(path)
        while log.recv_match() is not None:
            pass
else:
    import aerofiles
    for path in file:
        with open(path, encoding="utf-8", errors="replace") as opened:
            aerofiles.igc.Reader(skip_duplicates=True).read(opened)
"#;

/// Cost of one log.
#[derive(Clone, Debug, Serialize)]
pub struct Log {
    /// Path below the folder of real logs.
    pub file: &'static str,
    /// The reference reader.
    pub reader: &'static str,
    /// The file's size, bytes.
    pub file_bytes: u64,
    /// `pylon import`, including writing the flight.
    pub pylon: Cost,
    /// Starting Python and loading the reader.
    pub reader_started: Cost,
    /// The same, plus reading the file.
    pub reader_read: Cost,
}

/// Results of the import benchmarks.
#[derive(Clone, Debug, Serialize)]
pub struct ImportBench {
    /// `pylon --version`: cost of the program without any work.
    pub idle: Cost,
    /// `pylon import` of a log of 43 kB: the program's own cost of an import.
    pub short: Cost,
    /// The logs.
    pub logs: Vec<Log>,
    /// Logs that are not on this machine.
    pub skipped: Vec<&'static str>,
    /// The target figures.
    pub figures: Vec<Figure>,
}

/// Builds and measures.
pub fn run(echo: bool) -> anyhow::Result<ImportBench> {
    child::run(&mut workspace::build_workbench(), echo)?;
    let folder = workspace::target_folder().join("bench");
    fs::create_dir_all(&folder)?;
    let logs = workspace::root().join(LOGS);
    let short = logs.join(SHORT);
    anyhow::ensure!(short.exists(), "no {}: without real logs there is nothing to measure", short.display());
    let (there, skipped): (Vec<_>, Vec<_>) =
        FILES.into_iter().partition(|(file, _)| logs.join(file).exists());
    let mut version = workspace::program(workspace::workbench());
    version.arg("--version");
    let mut import = workspace::program(workspace::workbench());
    import.arg("import").arg(short).arg("-o").arg(folder.join("imported.csv"));
    let [idle, short] = measure::shortest(ROUNDS, [version, import])?;
    let mut measured = Vec::new();
    for (file, reader) in there {
        eprintln!("importing {file}");
        measured.push(measure_log(&logs.join(file), file, reader, &folder)?);
    }
    let figures = figures(&measured, short);
    Ok(ImportBench {
        idle,
        short,
        logs: measured,
        skipped: skipped.into_iter().map(|(file, _)| file).collect(),
        figures,
    })
}

fn measure_log(path: &Path, file: &'static str, reader: &'static str, folder: &Path) -> anyhow::Result<Log> {
    let mut pylon = workspace::program(workspace::workbench());
    pylon.arg("import").arg(path).arg("-o").arg(folder.join("imported.csv"));
    let python = |file: Option<&Path>| {
        let mut command = workspace::program(setup::pymavlink_python());
        command.args(["-c", READ, reader]).args(file);
        command
    };
    let [pylon, reader_started, reader_read] =
        measure::shortest(ROUNDS, [pylon, python(None), python(Some(path))])?;
    Ok(Log { file, reader, file_bytes: fs::metadata(path)?.len(), pylon, reader_started, reader_read })
}

impl Log {
    /// Ratio of the reference reader's reading time alone to that of the whole import, which includes the
    /// program's start and the writing.
    fn speed(&self) -> f64 {
        (self.reader_read.cpu_seconds - self.reader_started.cpu_seconds) / self.pylon.cpu_seconds
    }

    /// Memory beyond that needed for a short file, in multiples of the file's size.
    fn memory(&self, short: Cost) -> f64 {
        self.pylon.peak_bytes.saturating_sub(short.peak_bytes) as f64 / self.file_bytes as f64
    }
}

fn figures(logs: &[Log], short: Cost) -> Vec<Figure> {
    let mut figures = Vec::new();
    for log in logs {
        let name = format!("{}: {}'s reading / pylon import, time of all cores", log.file, log.reader);
        figures.push(Figure::at_least(name, log.speed(), 3.0, ""));
        if log.file_bytes >= MEASURABLE_BYTES {
            let name = format!("{}: memory beyond a short log's / file", log.file);
            figures.push(Figure::at_most(name, log.memory(short), 3.0, ""));
        }
    }
    figures
}

impl ImportBench {
    /// Times and memory by log.
    pub fn table(&self) -> String {
        let header = [
            Cell::new("log"),
            right("size"),
            Cell::new("beside"),
            right("its reading"),
            right("with its start"),
            right("pylon import"),
            right("memory"),
            right("beyond a short log's / file"),
        ];
        let mut table = plain(header);
        let megabytes = |bytes: u64| format!("{:.1} MB", bytes as f64 / 1e6);
        for log in &self.logs {
            let reading = log.reader_read.cpu_seconds - log.reader_started.cpu_seconds;
            table.add_row([
                Cell::new(log.file),
                right(megabytes(log.file_bytes)),
                Cell::new(log.reader),
                right(format!("{reading:.3} s")),
                right(format!("{:.3} s", log.reader_read.cpu_seconds)),
                right(format!("{:.3} s", log.pylon.cpu_seconds)),
                right(megabytes(log.pylon.peak_bytes)),
                right(format!("{:.1}", log.memory(self.short))),
            ]);
        }
        let skipped: String = self.skipped.iter().map(|file| format!("\nskipped: {file}")).collect();
        format!(
            "Real logs, time of all cores; the shortest of {ROUNDS} rounds, taken in turn. Of memory `pylon --version` \
             takes {}, and the import of {SHORT} {}; a file's share is a figure from {} on.\n{}{skipped}",
            megabytes(self.idle.peak_bytes),
            megabytes(self.short.peak_bytes),
            megabytes(MEASURABLE_BYTES),
            table.trim_fmt()
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_readers_start_is_not_counted_and_the_programs_own_memory_neither() {
        let cost = |cpu_seconds: f64, peak_bytes| Cost { seconds: 9.0, cpu_seconds, peak_bytes };
        let log = |file_bytes| Log {
            file: "a.igc",
            reader: "aerofiles",
            file_bytes,
            pylon: cost(0.5, 5_500_000),
            reader_started: cost(1.0, 0),
            reader_read: cost(2.0, 0),
        };
        let figures = figures(&[log(1_000_000), log(999_999)], cost(0.1, 2_000_000));
        let found: Vec<_> = figures.iter().map(|figure| (figure.measured.as_str(), figure.met)).collect();
        // A file too small for a memory figure has only its time.
        assert_eq!(found, [("2.00", false), ("3.50", false), ("2.00", false)]);
    }
}
