//! "Fly in QEMU": runs `pylon fly` as a separate process, so that its failures affect nothing else.

use std::env;
use std::io::{self, Write as _};
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::Mutex;

use model::{Model, ModelError};
use pylon::replay::{CalibrationWindow, GivenAirborne, GivenTimes};
use thiserror::Error;

/// Flies one flight at a time, because a flight occupies the whole machine.
#[derive(Debug, Default)]
pub struct Flying {
    now: Mutex<()>,
}

/// Why there is no result.
#[derive(Debug, Error)]
pub enum NotFlown {
    /// Another flight is in progress.
    #[error("another flight is in progress")]
    Busy,
    /// The model cannot be used.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// `pylon fly` could not be started.
    #[error(transparent)]
    Start(#[from] io::Error),
    /// `pylon fly` failed, with its own message.
    #[error("{0}")]
    Failed(String),
}

impl Flying {
    /// Flies a log with a model's text and the user's times; returns the output of `pylon fly --json`.
    pub fn fly(&self, log: &Path, model: &str, times: GivenTimes) -> Result<String, NotFlown> {
        let _flying = self.now.try_lock().map_err(|_| NotFlown::Busy)?;
        Model::parse(model)?;
        let mut file = tempfile::Builder::new().suffix(".toml").tempfile()?;
        file.write_all(model.as_bytes())?;
        let mut fly = Command::new(env::current_exe()?);
        fly.arg("fly").arg("--json").arg("--model").arg(file.path()).stdin(Stdio::null());
        let end = |time_s: Option<f64>| time_s.map_or_else(String::new, |time_s| time_s.to_string());
        if let Some(CalibrationWindow { start_s, end_s }) = times.calibration {
            fly.arg("--calibrate").arg(format!("{start_s}..{end_s}"));
        }
        if let Some(GivenAirborne { take_off_s, landing_s }) = times.airborne {
            fly.arg("--airborne").arg(format!("{}..{}", end(take_off_s), end(landing_s)));
        }
        fly.arg("--").arg(log);
        let output = fly.output()?;
        // Status 1: bits differ, which is a result.
        match output.status.code() {
            Some(0 | 1) => Ok(String::from_utf8_lossy(&output.stdout).into_owned()),
            _ => {
                let said = String::from_utf8_lossy(&output.stderr);
                let last = said
                    .lines()
                    .rev()
                    .find(|line| !line.trim().is_empty())
                    .unwrap_or("it ended without a message");
                Err(NotFlown::Failed(last.strip_prefix("error: ").unwrap_or(last).to_owned()))
            }
        }
    }
}
