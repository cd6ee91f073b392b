//! The board, chosen by a feature: everything that differs between the flight computer and the two boards
//! that fly a flight record. All have the same names here.

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

/// A board that runs.
pub struct Board {
    /// The tick.
    pub timer: TickTimer,
    /// Says when and whether there is a tick to run.
    pub source: Source,
    /// Brings input for the source.
    pub feeder: Feeder,
    /// The sensors.
    pub sensors: Sensors,
    /// Whether they are a recording's, which knows when the vehicle left and the altitude of its inertial
    /// unit.
    pub is_recording: bool,
    /// Where results go.
    pub sink: Sink,
    /// Where the telemetry goes.
    pub line: Line,
    /// The watchdog.
    pub watchdog: Watchdog,
}

/// What a timer tick is for.
pub enum Next {
    /// Run the mission; the sensors have what is new at this time, microseconds.
    Tick(u64),
    /// Input is late: wait.
    Underrun,
    /// Results have no room: wait.
    Stall,
    /// There is no more input.
    End,
}
