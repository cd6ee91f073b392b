//! "Fly in QEMU": `pylon fly`, as a program of its own, so that what happens to it happens to nothing else.

use std::env;
use std::io::Write as _;
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::Mutex;

use model::Model;

/// One flight at a time: it takes the machine.
#[derive(Debug, Default)]
pub struct Flying {
    now: Mutex<()>,
}

/// Why there is no result.
#[derive(Debug, PartialEq, Eq)]
pub enum NotFlown {
    /// Another flight is flying.
    Busy,
    /// `pylon fly`'s own line, or why it could not be started.
    Failed(String),
}

impl Flying {
    /// Flies a log with a model's text; what `pylon fly --json` prints.
    pub fn fly(&self, log: &Path, model: &str) -> Result<String, NotFlown> {
        let _flying = self.now.try_lock().map_err(|_| NotFlown::Busy)?;
        Model::parse(model).map_err(|error| NotFlown::Failed(error.to_string()))?;
        let failed = |error: std::io::Error| NotFlown::Failed(error.to_string());
        let mut file = tempfile::Builder::new().suffix(".toml").tempfile().map_err(failed)?;
        file.write_all(model.as_bytes()).map_err(failed)?;
        let mut fly = Command::new(env::current_exe().map_err(failed)?);
        fly.arg("fly").arg("--json").arg("--model").arg(file.path()).arg("--").arg(log).stdin(Stdio::null());
        let output = fly.output().map_err(failed)?;
        // 1: bits differ, which is a result.
        match output.status.code() {
            Some(0 | 1) => Ok(String::from_utf8_lossy(&output.stdout).into_owned()),
            _ => {
                let said = String::from_utf8_lossy(&output.stderr);
                let last = said
                    .lines()
                    .rev()
                    .find(|line| !line.trim().is_empty())
                    .unwrap_or("it ended without a word");
                Err(NotFlown::Failed(last.strip_prefix("error: ").unwrap_or(last).to_owned()))
            }
        }
    }
}
