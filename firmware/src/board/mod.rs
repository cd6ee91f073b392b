//! The board, chosen by a feature: everything that differs between the flight computer and the two boards
//! that fly a flight record. The names are the same for all boards.

#[cfg(any(
    all(feature = "board-f405", feature = "board-qemu"),
    all(feature = "board-f405", feature = "board-hil"),
    all(feature = "board-qemu", feature = "board-hil"),
))]
compile_error!("choose one board: feature board-qemu, board-hil or board-f405, not two");
#[cfg(not(any(feature = "board-f405", feature = "board-qemu", feature = "board-hil")))]
compile_error!("choose a board: feature board-qemu, board-hil or board-f405");

#[cfg(feature = "board-f405")]
mod f405;
#[cfg(all(feature = "recorded", not(feature = "board-f405")))]
mod recorded;

#[cfg(feature = "board-f405")]
pub use f405::{
    CostClock, Feeder, Line, NAME, Sensors, Sink, Source, Storage, Watchdog, clock_is_internal, exit,
    prepare, reset_facts, retained, stand_by, start,
};
#[cfg(all(feature = "recorded", not(feature = "board-f405")))]
pub use recorded::{
    CostClock, Feeder, Line, NAME, Sensors, Sink, Source, Storage, Watchdog, clock_is_internal, exit,
    prepare, reset_facts, retained, stand_by, start,
};

use crate::tick_timer::TickTimer;

/// A started board.
pub struct Board {
    /// The tick.
    pub timer: TickTimer,
    /// Decides whether there is a tick to run, and at what time.
    pub source: Source,
    /// Supplies input for the source.
    pub feeder: Feeder,
    /// The sensors.
    pub sensors: Sensors,
    /// Whether they are those of a recording, which already contains the launch and the inertial unit's
    /// altitude.
    pub is_recording: bool,
    /// Output for results.
    pub sink: Sink,
    /// Output for telemetry.
    pub line: Line,
    /// The watchdog.
    pub watchdog: Watchdog,
}

/// The purpose of a timer tick.
pub enum Next {
    /// Run the mission; the sensors have new samples up to this time, microseconds.
    Tick(u64),
    /// Wait: input is late.
    Underrun,
    /// Wait: there is no room for results.
    Stall,
    /// There is no more input.
    End,
}
