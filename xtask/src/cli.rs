//! The command line.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};

use crate::board::Barometer;
use crate::{campaign, hil};

/// All jobs of this checkout.
#[derive(Debug, Parser)]
#[command(
    name = "cargo xtask",
    bin_name = "cargo xtask",
    disable_help_subcommand = true,
    after_help = "\
Examples:
  cargo xtask demo           see Pylon work: a flight is calibrated, latched, flagged and drawn
  cargo xtask test           install what is missing and run every test
  cargo xtask test budgets   only the steps and programs of tests whose name contains `budgets`, and their set-up
  cargo xtask site           the studio as one file, which any browser opens from the disk
  cargo xtask bench          speed and size, compared with other filters
  cargo xtask blind 400      how often the diagnosis is right, on 400 simulated flights
  cargo xtask laws           how often `pylon discover` is right, on flights with a hidden law
  cargo xtask real-trials    the same on real logs and tracks
  cargo xtask campaign       a thousand flights with faults of chips, wires and supply, compared with the same flights without
  cargo xtask flash          write the flight computer's image to a board (docs/bring-up.md)
  cargo xtask hil q.csv      fly a flight through a board on its debug probe, and compare every tick with the host
  cargo xtask endurance      ten hours captive, and fifty random flights, in QEMU, bit for bit

Missing tools are installed with rustup and apt-get; each is announced first."
)]
pub struct Cli {
    /// What to do; if omitted, print this help.
    #[command(subcommand)]
    pub job: Option<Job>,

    /// Show the output of the commands that are run.
    #[arg(long, short, global = true)]
    pub verbose: bool,
}

/// A job.
#[derive(Debug, Subcommand)]
pub enum Job {
    /// Install what is missing: rustfmt, clippy, the flight computer's target, wasm32, QEMU, npm, Chromium.
    Setup,
    /// Fly the reconstructed flight of the paper on the host and in QEMU, and report the result.
    Demo,
    /// Run every test; ends with `N passed, N failed, N skipped`.
    Test {
        /// Only the steps and test programs whose names contain one of these words.
        words: Vec<String>,
        /// Only list the steps and the test programs.
        #[arg(long)]
        list: bool,
    },
    /// Build the studio (the engine as WebAssembly, and its page) as one file: target/studio/studio.html.
    Site,
    /// Measure instructions per tick (also of other filters), ticks per second, and the time and memory of a
    /// comparison.
    Bench {
        /// Print JSON instead of tables.
        #[arg(long)]
        json: bool,
        /// Only this part: `target` (instructions, in QEMU), `host` (time and memory) or `import` (real logs,
        /// also with their formats' reference readers).
        part: Option<BenchPart>,
    },
    /// Diagnose simulated flights with hidden effects, and count how often the diagnosis is right.
    Blind {
        /// Number of trials.
        #[arg(default_value_t = 200)]
        trials: u64,
        /// Seed of the first trial; each further trial adds one.
        #[arg(long, default_value_t = 1)]
        seed: u64,
        /// The generator: `dynamic` (`pylon simulate`), or `kinematic`, which shares nothing with it.
        #[arg(long, default_value = "dynamic", value_parser = ["dynamic", "kinematic"])]
        family: String,
        /// Also fly the plan that is advised for each set, and diagnose both flights together.
        #[arg(long)]
        fly_advice: bool,
    },
    /// Search simulated flights for a hidden law of their recorded signals, blind, and count how often the
    /// search is right.
    Laws {
        /// Number of trials.
        #[arg(default_value_t = 120)]
        trials: u64,
        /// Seed of the first trial; each further trial adds one.
        #[arg(long, default_value_t = 1)]
        seed: u64,
        /// Number of trials on which symbolic regression (gplearn) and sparse regression (PySINDy) are also
        /// run; they take half a minute each.
        #[arg(long, default_value_t = 24)]
        beside: u64,
        /// Also write the table into docs/blind-laws.md.
        #[arg(long)]
        write: bool,
    },
    /// Diagnose the real logs in ../shared/flights/real, flights simulated along their tracks, and both with
    /// one effect added, and count how often the diagnosis is right.
    RealTrials {
        /// Half of the logs to use: `development`, or `unseen`, which is for final figures only.
        #[arg(long, default_value = "development", value_parser = ["development", "unseen"])]
        half: String,
        /// Also write the table into docs/blind-trials.md.
        #[arg(long)]
        write: bool,
    },
    /// Compare the diagnosis with least squares, the LASSO and a state-space model on the blind trials'
    /// residuals.
    Baselines(Baselines),
    /// Fly random faults through the whole chain, and compare every flight with the same one without them.
    #[command(after_help = "\
Examples:
  cargo xtask campaign                          a thousand runs: a table of fault by phase with the worst consequence
  cargo xtask campaign 10000 --seed 77          more runs, from another seed
  cargo xtask campaign --run 42 --seed 77       one run: what was drawn and what resulted
  cargo xtask campaign --mutants                disable each guard in turn: the campaign must report it
  cargo xtask campaign --qemu 50                fly fifty short runs in QEMU instead, every tick compared with the host bit for bit

Exit status: 0 every invariant was kept; 1 one was broken; 2 bad usage.")]
    Campaign(campaign::Arguments),
    /// Compare rules for the monitor on the same residuals, and write docs/monitor-rules.md and its picture.
    MonitorCurves {
        /// Seed of the simulated residuals.
        #[arg(long, default_value_t = 1)]
        seed: u64,
    },
    /// Build the flight computer's image with a model, write it to a board through its debug probe, and start
    /// it.
    #[command(after_help = "\
Examples:
  cargo xtask flash                             the default model
  cargo xtask flash --model ours.toml           your own model, as improved by `pylon add`
  cargo xtask flash --probe 0483:3748           if several probes are connected (`probe-rs list`)

It needs probe-rs and a debug probe; if one is missing it says how to get it. docs/bring-up.md has the wiring and the first checks.")]
    Flash {
        /// A model file, or a preset's name.
        #[arg(long, default_value = "default")]
        model: String,
        /// The barometer on the board.
        #[arg(long, value_enum, default_value = "ms5611")]
        barometer: Barometer,
        /// The probe: VID:PID or VID:PID:SERIAL.
        #[arg(long)]
        probe: Option<String>,
    },
    /// Read the log of the last flashed board, until interrupted.
    #[command(after_help = "\
Examples:
  cargo xtask log                               the flight computer's log, from now on
  cargo xtask log --probe 0483:3748             if several probes are connected (`probe-rs list`)

It neither stops nor resets the board, which drops entries that do not fit into its log buffer.")]
    Log {
        /// The probe: VID:PID or VID:PID:SERIAL.
        #[arg(long)]
        probe: Option<String>,
    },
    /// Fly a flight through a board and its debug probe (hardware in the loop), and compare every tick with
    /// the host.
    #[command(after_help = "\
Examples:
  cargo xtask hil q.csv                         through an STM32F405 on an ST-LINK, with the default model
  cargo xtask hil q.csv --model ours.toml       with your own model
  cargo xtask hil q.csv --probe-config interface/cmsis-dap.cfg
                                                on a CMSIS-DAP probe
  cargo xtask hil q.csv -- --fault \"baro stuck-low 60..65\" --json
                                                with further options of `pylon fly`

It needs openocd 0.11 or newer and a debug probe; if one is missing it says how to get it. It writes the board's flash. Only the probe has
to be connected: the sensors are models, on the board as on the host. docs/bring-up.md says what to expect and what is untested.

Exit status: 0 every bit is the same; 1 bits differ; 2 bad usage or bad input, or no probe or board.")]
    Hil(hil::Arguments),
    /// Fly ten hours of captive flight, and fifty random flights, through the emulated flight computer, bit
    /// for bit.
    Endurance {
        /// Hours of captive flight.
        #[arg(long, default_value_t = 10.0)]
        hours: f64,
        /// Number of random flights.
        #[arg(long, default_value_t = 50)]
        flights: u64,
        /// Seed of the first random flight; each further flight adds one.
        #[arg(long, default_value_t = 1)]
        seed: u64,
    },
    /// Measure which errors a crate's tests catch: change its code at random places, one at a time, and run
    /// its tests
    #[command(after_help = "\
Examples:
  cargo xtask mutants statistics               25 mutants of workbench/statistics
  cargo xtask mutants replay --sample 200      a larger sample
  cargo xtask mutants kf-core --sample 0       every mutant: hours

It uses cargo-mutants, which it installs into target/tools when it is missing. It is not part of `cargo xtask test`. The survivors
are listed in target/mutants/mutants.out/missed.txt; docs/mutants.md has what was measured.")]
    Mutants {
        /// The crate.
        package: String,
        /// Number of mutants, drawn at random; 0 for all.
        #[arg(long, default_value_t = 25)]
        sample: usize,
        /// Seed of the draw.
        #[arg(long, default_value_t = 1)]
        seed: u64,
    },
    /// Write the JSON schemas of the commands' output into docs/schemas. A test fails if these are out of
    /// date.
    Schemas,
    /// Run a command and print its wall time and its peak memory as JSON (for `bench`).
    #[command(hide = true)]
    Measure {
        /// The command and its arguments.
        #[arg(required = true, trailing_var_arg = true, allow_hyphen_values = true)]
        command: Vec<String>,
    },
}

/// A part of the benchmarks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum BenchPart {
    /// Instructions, counted by QEMU.
    Target,
    /// Time and memory on this machine.
    Host,
    /// Time and memory of importing real logs, compared with pyulog, pymavlink and aerofiles.
    Import,
}

/// Arguments of `cargo xtask baselines`.
#[derive(Debug, Args)]
pub struct Baselines {
    /// Number of trials.
    #[arg(default_value_t = 200)]
    pub trials: u64,
    /// Seed of the first trial; each further trial adds one.
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// The generator: `dynamic` (`pylon simulate`), or `kinematic`, which shares nothing with it.
    #[arg(long, default_value = "dynamic", value_parser = ["dynamic", "kinematic"])]
    pub family: String,
    /// The program `pylon` of an earlier commit; it diagnoses the same flights.
    #[arg(long, value_name = "PYLON")]
    pub earlier: Option<PathBuf>,
    /// Also write the tables into docs/blind-trials.md.
    #[arg(long)]
    pub write: bool,
}
