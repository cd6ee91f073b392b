//! Wall time and peak memory of a child process.

use std::process::{Command, Stdio};
use std::time::Instant;
use std::{env, io};

use anyhow::{Context, bail};
use nix::sys::resource::{UsageWho, getrusage};
use nix::sys::time::TimeValLike as _;
use serde::{Deserialize, Serialize};

use crate::{child, workspace};

/// Cost of a child process.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Cost {
    /// Wall time from start to end, seconds.
    pub seconds: f64,
    /// Processor time of all its threads, seconds.
    pub cpu_seconds: f64,
    /// Peak resident memory, bytes.
    pub peak_bytes: u64,
}

/// Runs a command in its own process, so that the peak is this child's alone.
pub fn cost(command: &Command) -> anyhow::Result<Cost> {
    let mut measurer = workspace::program(env::current_exe()?);
    measurer.args(["measure", "--"]).arg(command.get_program()).args(command.get_args());
    let said = child::run(&mut measurer, false)?;
    serde_json::from_str(&said.stdout).context("`cargo xtask measure` printed unexpected output")
}

/// Runs commands in turn, so that a disturbance affects all of them; returns the shortest times and the
/// highest peak of each.
pub fn shortest<const N: usize>(rounds: usize, commands: [Command; N]) -> anyhow::Result<[Cost; N]> {
    let mut best = [Cost { seconds: f64::INFINITY, cpu_seconds: f64::INFINITY, peak_bytes: 0 }; N];
    for _ in 0..rounds {
        for (best, command) in best.iter_mut().zip(&commands) {
            let Cost { seconds, cpu_seconds, peak_bytes } = cost(command)?;
            *best = Cost {
                seconds: best.seconds.min(seconds),
                cpu_seconds: best.cpu_seconds.min(cpu_seconds),
                peak_bytes: best.peak_bytes.max(peak_bytes),
            };
        }
    }
    Ok(best)
}

/// Runs a command, discards its output and prints its cost.
pub fn print(command: &[String]) -> anyhow::Result<()> {
    let Some((program, arguments)) = command.split_first() else { bail!("no command to measure") };
    let start = Instant::now();
    let status = Command::new(program)
        .args(arguments)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .status()
        .with_context(|| format!("`{program}` could not be started"))?;
    let seconds = start.elapsed().as_secs_f64();
    if !status.success() {
        bail!("`{}` ended with {status}", command.join(" "));
    }
    let usage = getrusage(UsageWho::RUSAGE_CHILDREN).map_err(io::Error::from)?;
    let peak = usage.max_rss();
    let busy = usage.user_time() + usage.system_time();
    let cpu_seconds = busy.num_microseconds() as f64 * 1e-6;
    // Linux counts in KiB, macOS in bytes.
    let unit = if cfg!(target_os = "macos") { 1 } else { 1024 };
    let cost = Cost { seconds, cpu_seconds, peak_bytes: u64::try_from(peak)? * unit };
    println!("{}", serde_json::to_string(&cost)?);
    Ok(())
}
