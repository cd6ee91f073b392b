//! What can go wrong in a run: where, when and what.

use chip_models::flown::{ChipFault, Fault, Quantity};

use super::flight::TICKS_PER_S;

/// Ticks of a second.
pub(super) const SECOND: usize = TICKS_PER_S as usize;
/// A fault that lasts no longer is a transient, ticks.
pub const TRANSIENT_TICKS: usize = SECOND;

/// Where a fault begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Phase {
    /// The first ten seconds.
    Settling,
    /// Captive flight.
    Calibrating,
    /// The last five seconds before the hooks open.
    BeforeLaunch,
    /// From 0.1 s before to half a second after the hooks open.
    Release,
    /// Up to 8 s after.
    EarlyFree,
    /// From 15 s after on.
    LateFree,
}

impl Phase {
    /// Every phase, in order.
    pub const ALL: [Self; 6] = [
        Self::Settling,
        Self::Calibrating,
        Self::BeforeLaunch,
        Self::Release,
        Self::EarlyFree,
        Self::LateFree,
    ];

    /// For tables.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Settling => "settling",
            Self::Calibrating => "calibrating",
            Self::BeforeLaunch => "before launch",
            Self::Release => "release",
            Self::EarlyFree => "early free",
            Self::LateFree => "late free",
        }
    }
}

/// Where a fault is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Place {
    /// The barometer.
    Baro,
    /// The inertial unit.
    Imu,
    /// The receiver: the reference.
    Gps,
    /// The mother ship's messages.
    Master,
    /// The umbilical's wire.
    Wire,
    /// The supply.
    Supply,
    /// The flight computer's clock.
    Clock,
    /// The flight computer's program.
    Program,
}

/// At what point of a tick the supply goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Boundary {
    /// Before the mark of this tick: after the poll, or after the mission's tick.
    BeforeMark,
    /// While the mark is written: so many of its words are there.
    InMark(u32),
    /// Before the snapshot.
    BeforeSnapshot,
    /// While the snapshot is written: so many of its words are there.
    InSnapshot(u32),
    /// At the tick's end.
    AtEnd,
}

/// Which tick a dip is in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DipTick {
    /// This one.
    At(usize),
    /// So many after that of the wire's first edge.
    Edge(usize),
    /// So many after the one that latches in the clean flight.
    Latch(usize),
}

impl Boundary {
    /// Whether nobody has heard of the tick that the supply goes in: messages and records are made by tasks
    /// below the tick, which run when it has ended.
    #[must_use]
    pub const fn is_before_telling(self) -> bool {
        matches!(self, Self::BeforeMark | Self::InMark(_))
    }
}

/// A dip of the supply, or a crash of the program.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dip {
    /// When.
    pub tick: DipTick,
    /// For how many ticks.
    pub ticks: usize,
    /// At what point of the tick.
    pub boundary: Boundary,
    /// Whether the chips lose their power as well.
    pub with_chips: bool,
    /// Whether it is the program that has crashed.
    pub is_crash: bool,
}

/// One fault.
#[derive(Clone, Debug, PartialEq)]
pub struct Drawn {
    /// Its name in the matrix.
    pub name: &'static str,
    /// Where it is.
    pub place: Place,
    /// In what phase it begins.
    pub phase: Phase,
    /// First tick of it.
    pub from: usize,
    /// First tick without it.
    pub to: usize,
    /// What it does, chip by chip.
    pub events: Vec<(usize, ChipFault)>,
    /// Dips of the supply.
    pub dips: Vec<Dip>,
    /// Step of the clock, microseconds.
    pub step_us: i64,
}

impl Drawn {
    /// Whether it is over within a second.
    #[must_use]
    pub const fn is_transient(&self) -> bool {
        self.to - self.from <= TRANSIENT_TICKS
    }

    /// Whether all that it does is to add something to an altitude or a pressure, the same while it lasts.
    #[must_use]
    pub fn is_altitude_offset(&self) -> bool {
        let is_one = |fault: &Fault| {
            matches!(fault, Fault::Lies { .. } | Fault::Offset { quantity: Quantity::Pressure, .. })
        };
        let begins = self.events.first().is_some_and(|(_, event)| is_one(&event.fault));
        begins && self.events.iter().all(|(_, event)| is_one(&event.fault) || event.fault == Fault::None)
    }
}
