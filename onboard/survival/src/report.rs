//! The report of a restart.

use serde::{Deserialize, Serialize};

use crate::crash::{Cause, CrashRecord};
use crate::slots::Refusal;
use crate::start::Start;
use crate::tick_mark::TickMark;

/// A restart.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct RestartReport {
    /// How the flight computer started.
    pub start: Start,
    /// What ended the last run.
    pub cause: Cause,
    /// Record of the crash, if there is one.
    pub crash: Option<CrashRecord>,
    /// The last tick before the restart.
    pub mark: Option<TickMark>,
    /// Time of the snapshot from which the mission continues, microseconds.
    pub snapshot_us: Option<u64>,
    /// Why a copy of the snapshot was refused.
    pub refused: [Option<Refusal>; 2],
    /// Time at which the mission's clock continues, microseconds.
    pub resumed_us: u64,
    /// Restarts since power-on.
    pub restarts: u32,
    /// Length of the standby before the mission continued, because of repeated crashes, microseconds.
    pub pause_us: u64,
}
