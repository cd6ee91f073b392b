//! The faults of a run: where, when and what.

use chip_models::flown::{ChipFault, Fault, Quantity};

use super::flight::TICKS_PER_S;

/// Ticks per second.
pub(super) const SECOND: usize = TICKS_PER_S as usize;
/// Longest duration of a transient, ticks.
pub const TRANSIENT_TICKS: usize = SECOND;

/// Phase in which a fault begins.
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

    /// Name for tables.
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

/// Place of a fault.
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

/// Point of a tick at which the supply fails.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Boundary {
    /// Before the mark of this tick: after the poll, or after the mission's tick.
    BeforeMark,
    /// While the mark is written: after this many of its words.
    InMark(u32),
    /// Before the snapshot.
    BeforeSnapshot,
    /// While the snapshot is written: after this many of its words.
    InSnapshot(u32),
    /// At the tick's end.
    AtEnd,
}

/// Tick that a dip is in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DipTick {
    /// This one.
    At(usize),
    /// This many ticks after the wire's first edge.
    Edge(usize),
    /// This many ticks after the one that latches in the clean flight.
    Latch(usize),
}

impl Boundary {
    /// Whether nothing has reported the tick in which the supply fails: messages and records are made by
    /// tasks below the tick, which run after it.
    #[must_use]
    pub const fn is_before_reporting(self) -> bool {
        matches!(self, Self::BeforeMark | Self::InMark(_))
    }
}

/// A dip of the supply, or a crash of the program.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dip {
    /// Its tick.
    pub tick: DipTick,
    /// Its length in ticks.
    pub ticks: usize,
    /// Its point of the tick.
    pub boundary: Boundary,
    /// Whether the chips lose their power as well.
    pub with_chips: bool,
    /// Whether it is a crash of the program.
    pub is_crash: bool,
}

/// One fault.
#[derive(Clone, Debug, PartialEq)]
pub struct Drawn {
    /// Its name in the matrix.
    pub name: &'static str,
    /// Its place.
    pub place: Place,
    /// The phase in which it begins.
    pub phase: Phase,
    /// Its first tick.
    pub from: usize,
    /// The first tick after it.
    pub to: usize,
    /// Its effects, chip by chip.
    pub events: Vec<(usize, ChipFault)>,
    /// Dips of the supply.
    pub dips: Vec<Dip>,
    /// Step of the clock, microseconds.
    pub step_us: i64,
}

impl Drawn {
    /// Whether it ends within a second.
    #[must_use]
    pub const fn is_transient(&self) -> bool {
        self.to - self.from <= TRANSIENT_TICKS
    }

    /// Whether its only effect is a constant offset of an altitude or a pressure.
    #[must_use]
    pub fn is_altitude_offset(&self) -> bool {
        let is_one = |fault: &Fault| {
            matches!(fault, Fault::Lies { .. } | Fault::Offset { quantity: Quantity::Pressure, .. })
        };
        let begins = self.events.first().is_some_and(|(_, event)| is_one(&event.fault));
        begins && self.events.iter().all(|(_, event)| is_one(&event.fault) || event.fault == Fault::None)
    }
}
