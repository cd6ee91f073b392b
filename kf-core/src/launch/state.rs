//! The decision's results: the launch's state, the wire's condition, and counters.

use crate::input::LaunchDoubt;

/// What confirmed a launch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Confirmation {
    /// Open wire; the force departed from its captive mean, and its character has changed.
    Force,
    /// Open wire; the messages fell silent, and the force's character or the climb rate has changed.
    Silence,
    /// The wire was broken or could not be read: departure or change of force, and silence.
    ForceAndSilence,
    /// The wire is stuck closed: near free fall and silence.
    StuckWire,
    /// Near free fall by force and climb rate; without fixes, for long.
    FreeFall,
    /// Wire and messages alone, or the vehicle's motion alone, with nothing that could contradict them.
    Unconfirmed,
}

impl Confirmation {
    /// The name used in telemetry and reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Force => "force",
            Self::Silence => "silence",
            Self::ForceAndSilence => "force_and_silence",
            Self::StuckWire => "stuck_wire",
            Self::FreeFall => "free_fall",
            Self::Unconfirmed => "unconfirmed",
        }
    }
}

/// A launch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Launch {
    /// When the suspicion began: the first edge, or the first sign in the force or the messages;
    /// microseconds.
    pub first_edge_us: u64,
    /// When it was confirmed, microseconds.
    pub confirmed_us: u64,
    /// What confirmed it.
    pub by: Confirmation,
}

/// The verdict after a tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LaunchState {
    /// Under the pylon: calibration data may be taken.
    Captive,
    /// Perhaps launched: no calibration data is taken, and the calibration held.
    Suspected {
        /// Since when, microseconds.
        since_us: u64,
    },
    /// Launched.
    Launched(Launch),
}

impl LaunchState {
    /// For [`crate::input::TickInput::launch`].
    #[must_use]
    pub const fn is_launched(self) -> bool {
        matches!(self, Self::Launched(_))
    }

    /// For [`crate::input::TickInput::launch_doubt`].
    #[must_use]
    pub const fn doubt(self) -> LaunchDoubt {
        match self {
            Self::Captive => LaunchDoubt::None,
            Self::Suspected { .. } => LaunchDoubt::Suspected,
            Self::Launched(launch) => match launch.by {
                Confirmation::Unconfirmed => LaunchDoubt::Unconfirmed,
                _ => LaunchDoubt::None,
            },
        }
    }
}

/// The wire's condition.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WireCondition {
    /// It reads closed.
    Closed,
    /// It reads open, and nothing contradicts it.
    Open,
    /// It reads open, and was found to be no launch: messages came all the same, or nothing else changed.
    Broken,
    /// It has not been read for longer than the time limit.
    Unreadable,
}

impl WireCondition {
    /// The name used in telemetry and reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Closed => "closed",
            Self::Open => "open",
            Self::Broken => "broken",
            Self::Unreadable => "unreadable",
        }
    }
}

/// Counters of the decision. All saturate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LaunchCounts {
    /// Openings shorter than the debounce time.
    pub bounces: u32,
    /// Openings that were longer, but closed again before a decision.
    pub reclosures: u32,
    /// Times that the wire was found broken.
    pub broken_wires: u32,
    /// Times that the wire opened and the messages were silent, or none, and the vehicle moved and shook as
    /// before.
    pub torn_cables: u32,
    /// Times that a broken wire was found whole again.
    pub mended_wires: u32,
    /// Ticks at which the wire could not be read.
    pub unreadable: u32,
    /// Suspicions by force or silence that were withdrawn.
    pub false_alarms: u32,
    /// Invalid specific forces: not finite, beyond any unit's range, or exactly zero on all axes (a dead
    /// unit; one that falls has noise).
    pub forces_refused: u32,
    /// Silences under the pylon after which messages came again.
    pub link_losses: u32,
    /// Messages dated in the future or before the last one.
    pub messages_refused: u32,
    /// Ticks whose time was not after the last one's: each is taken for the next tick.
    pub out_of_order: u32,
    /// Messages that came after the launch was confirmed.
    pub messages_after_launch: u32,
    /// Times that the wire closed after the launch was confirmed.
    pub closures_after_launch: u32,
}
