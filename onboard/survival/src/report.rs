//! What a restart says of itself.

use serde::{Deserialize, Serialize};

use crate::crash::{Cause, CrashRecord};
use crate::slots::Refusal;
use crate::start::Start;
use crate::tick_mark::TickMark;

/// A restart.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct RestartReport {
    /// How it started.
    pub start: Start,
    /// What ended the last run.
    pub cause: Cause,
    /// Its record, if it left one.
    pub crash: Option<CrashRecord>,
    /// The last tick before the restart.
    pub mark: Option<TickMark>,
    /// Time of the snapshot that the mission goes on from, microseconds.
    pub snapshot_us: Option<u64>,
    /// Why a copy of the snapshot was not believed.
    pub refused: [Option<Refusal>; 2],
    /// Where the mission's clock goes on, microseconds.
    pub resumed_us: u64,
    /// Restarts since power-on.
    pub restarts: u32,
    /// How long the flight computer has stood by before it went on, because it kept crashing, microseconds.
    pub pause_us: u64,
}
