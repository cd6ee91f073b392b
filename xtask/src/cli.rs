//! The command line.

use clap::{Parser, Subcommand};

use crate::board::Barometer;
use crate::{campaign, hil};

/// Every job that has to do with this checkout.
#[derive(Debug, Parser)]
#[command(
    name = "cargo xtask",
    bin_name = "cargo xtask",
    disable_help_subcommand = true,
    after_help = "\
Examples:
  cargo xtask demo           see Pylon at work: a flight is calibrated, latched, flagged and drawn
  cargo xtask test           set up what is missing and run every test of every kind
  cargo xtask test budgets   only the steps whose name contains `budgets`, with what they need
  cargo xtask bench          how fast, how small, beside whom
  cargo xtask blind 400      how often a diagnosis is right, on 400 simulated flights
  cargo xtask laws           the same of laws that nobody wrote down (`pylon discover`)
  cargo xtask real-trials    the same on real logs and tracks
  cargo xtask campaign       a thousand flights with faults of chips, wires and supply, against the same without
  cargo xtask flash          write the flight computer's image to a board (docs/bring-up.md)
  cargo xtask hil q.csv      fly a flight through a board on its debug probe, and compare every tick with the host
  cargo xtask endurance      ten hours captive, and fifty random flights, in QEMU, bit for bit

Missing tools are installed by rustup and apt-get, and what is installed is said first."
)]
pub struct Cli {
    /// What to do; without it, this help.
    #[command(subcommand)]
    pub job: Option<Job>,

    /// Show what the commands that run say.
    #[arg(long, short, global = true)]
    pub verbose: bool,
}

/// A job.
#[derive(Debug, Subcommand)]
pub enum Job {
    /// Install what is missing: rustfmt, clippy, the flight computer's target, wasm32, QEMU, npm, Chromium.
    Setup,
    /// Fly the paper's flight, as reconstructed, on the host and in QEMU, and tell what happened.
    Demo,
    /// Run every test of every kind; ends with `N passed, N failed, N skipped`.
    Test {
        /// Only the steps whose name contains one of these words.
        words: Vec<String>,
        /// Only list the steps.
        #[arg(long)]
        list: bool,
    },
    /// Measure: instructions a tick beside other filters, ticks a second, time and memory of a comparison.
    Bench {
        /// Print JSON instead of tables.
        #[arg(long)]
        json: bool,
        /// Only this part: `target` (instructions, in QEMU), `host` (time and memory) or `import` (real logs, beside their formats'
        /// reference readers).
        part: Option<BenchPart>,
    },
    /// Fly simulated flights with hidden effects, diagnose them blind, and count how often that is right.
    Blind {
        /// How many trials.
        #[arg(default_value_t = 200)]
        trials: u64,
        /// The first trial's seed; each further one's is one more.
        #[arg(long, default_value_t = 1)]
        seed: u64,
    },
    /// Fly simulated flights with a hidden law of the recorded signals, search for it blind, and count how often that is right.
    Laws {
        /// How many trials.
        #[arg(default_value_t = 120)]
        trials: u64,
        /// The first trial's seed; each further one's is one more.
        #[arg(long, default_value_t = 1)]
        seed: u64,
        /// Write the table into docs/blind-laws.md as well.
        #[arg(long)]
        write: bool,
    },
    /// Diagnose the real logs in ../shared/flights/real, flights made of their tracks, and both with one effect added,
    /// and count how often that is right.
    RealTrials {
        /// Which half of the logs: `development`, or `unseen`, which is for the final figures only.
        #[arg(long, default_value = "development", value_parser = ["development", "unseen"])]
        half: String,
        /// Write the table into docs/blind-trials.md as well.
        #[arg(long)]
        write: bool,
    },
    /// Give the blind trials' residuals to least squares and the LASSO as well, and compare.
    Baselines {
        /// How many trials.
        #[arg(default_value_t = 200)]
        trials: u64,
        /// The first trial's seed; each further one's is one more.
        #[arg(long, default_value_t = 1)]
        seed: u64,
        /// Write the tables into docs/blind-trials.md as well.
        #[arg(long)]
        write: bool,
    },
    /// Fly random faults through the whole chain, and hold every flight against the same one without them.
    #[command(after_help = "\
Examples:
  cargo xtask campaign                          a thousand runs: a table of fault by phase with the worst consequence
  cargo xtask campaign 10000 --seed 77          more of them, of another seed
  cargo xtask campaign --run 42 --seed 77       one of them: what was drawn, what came of it
  cargo xtask campaign --mutants                take out each guard in turn: the campaign must report it
  cargo xtask campaign --qemu 50                fly fifty short runs in QEMU instead, every tick bit for bit the host's

Exit status: 0 every invariant was kept; 1 one was broken; 2 bad usage.")]
    Campaign(campaign::Arguments),
    /// Compare rules for the monitor on the same residuals, and write docs/monitor-rules.md and its picture.
    MonitorCurves {
        /// Seed of the made residuals.
        #[arg(long, default_value_t = 1)]
        seed: u64,
    },
    /// Build the flight computer's image with a model, write it to a board by its debug probe, and start it.
    #[command(after_help = "\
Examples:
  cargo xtask flash                             the default model
  cargo xtask flash --model ours.toml           a model of one's own, as `pylon add` has improved it
  cargo xtask flash --probe 0483:3748           where more than one probe is plugged in (`probe-rs list`)

It needs probe-rs and a debug probe, and says how to get them. docs/bring-up.md has the wiring and the first checks.")]
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
    /// Read the log of the board that was flashed last, until interrupted.
    #[command(after_help = "\
Examples:
  cargo xtask log                               what the flight computer says, from the attachment on
  cargo xtask log --probe 0483:3748             where more than one probe is plugged in (`probe-rs list`)

It neither stops nor resets the board, which drops what finds no room in the log.")]
    Log {
        /// The probe: VID:PID or VID:PID:SERIAL.
        #[arg(long)]
        probe: Option<String>,
    },
    /// Fly a flight through a board by its debug probe (hardware in the loop), and compare every tick with the host.
    #[command(after_help = "\
Examples:
  cargo xtask hil q.csv                         through an STM32F405 on an ST-LINK, with the default model
  cargo xtask hil q.csv --model ours.toml       with a model of one's own
  cargo xtask hil q.csv --probe-config interface/cmsis-dap.cfg
                                                on a CMSIS-DAP probe
  cargo xtask hil q.csv -- --fault \"baro stuck-low 60..65\" --json
                                                with further options of `pylon fly`

It needs openocd 0.11 or newer and a debug probe, and says how to get them. It writes the board's flash. Nothing but the probe has to
be wired: the sensors are models, on the board as on the host. docs/bring-up.md has what is seen, and what is not tried.

Exit status: 0 every bit is the same; 1 bits differ; 2 bad usage or bad input, or no probe or board.")]
    Hil(hil::Arguments),
    /// Fly ten hours of captive flight, and fifty random flights, through the emulated flight computer, bit for bit.
    Endurance {
        /// Hours of captive flight.
        #[arg(long, default_value_t = 10.0)]
        hours: f64,
        /// Random flights.
        #[arg(long, default_value_t = 50)]
        flights: u64,
        /// The first random flight's seed; each further one's is one more.
        #[arg(long, default_value_t = 1)]
        seed: u64,
    },
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
    /// Time and memory of importing real logs, beside pyulog, pymavlink and aerofiles.
    Import,
}
