//! State of the calibration with respect to the launch: it continues, is held, or is latched.
//!
//! | state | launch discrete and doubt | next |
//! |---|---|---|
//! | captive | neither a launch nor a suspicion | captive |
//! | captive | suspected | suspected: the calibration is copied and held |
//! | captive | a launch | suspected and launched in the same tick |
//! | suspected | still suspected | suspected: a part of the checks is evaluated |
//! | suspected | neither | captive: the calibration continues |
//! | suspected | a launch | launched: the held calibration is the latch |
//! | launched | any | launched |

use crate::calibration::StatisticalChecks;
use crate::latch::LatchRecord;
use crate::snapshot::Stage;

/// Longest time that parting contacts bounce, microseconds: the wire's debounce.
const BOUNCE_US: u64 = 20_000;

/// See the module.
#[derive(Clone, Debug)]
#[expect(clippy::large_enum_variant, reason = "there is one, in place, and no heap")]
pub(super) enum Latching {
    /// Captive flight.
    Captive {
        /// The last suspected launch that was withdrawn.
        taken_back: Option<TakenBack>,
        /// The reference was lost and came back during it: the next fix has no predecessor.
        has_reacquired: bool,
    },
    /// From the first edge on, monitoring runs: a suspected launch is treated as a launch internally, so that
    /// nothing depends on how long its confirmation takes.
    Latched {
        /// The calibration at the first edge.
        record: LatchRecord,
        /// Whether the launch is decided.
        decision: Decision,
    },
}

/// Decision about the first edge of a launch.
#[derive(Clone, Debug)]
pub(super) enum Decision {
    /// Undecided: the record is held.
    Suspected {
        /// Checks that are not yet in the record's failed checks.
        unchecked: Option<StatisticalChecks>,
        /// As in [`Latching::Captive`].
        has_reacquired: bool,
    },
    /// The record is the latch.
    Launched,
}

impl Latching {
    /// Before any suspicion.
    pub(super) const START: Self = Self::Captive { taken_back: None, has_reacquired: false };

    /// The held or latched calibration.
    #[inline]
    pub(super) const fn record(&self) -> Option<&LatchRecord> {
        match self {
            Self::Latched { record, .. } => Some(record),
            Self::Captive { .. } => None,
        }
    }

    #[inline]
    pub(super) const fn is_held(&self) -> bool {
        matches!(self, Self::Latched { decision: Decision::Suspected { .. }, .. })
    }

    #[inline]
    pub(super) const fn is_launched(&self) -> bool {
        matches!(self, Self::Latched { decision: Decision::Launched, .. })
    }

    /// The stage as stored in a tick's mark.
    #[inline]
    pub(super) const fn stage(&self) -> Stage {
        match self {
            Self::Captive { .. } => Stage::Captive,
            Self::Latched { decision: Decision::Suspected { .. }, .. } => Stage::Suspected,
            Self::Latched { decision: Decision::Launched, .. } => Stage::Launched,
        }
    }

    /// The reference was lost and is back. Recorded only during a suspicion.
    #[inline]
    pub(super) const fn note_reacquired(&mut self) {
        if let Self::Latched { decision: Decision::Suspected { has_reacquired, .. }, .. } = self {
            *has_reacquired = true;
        }
    }

    /// Whether the reference came back during the last suspicion; true once.
    #[inline]
    pub(super) const fn take_reacquired(&mut self) -> bool {
        match self {
            Self::Captive { has_reacquired, .. } => core::mem::replace(has_reacquired, false),
            Self::Latched { .. } => false,
        }
    }

    /// The last suspicion, if bouncing contacts may continue it; `now_us` is in microseconds.
    #[inline]
    pub(super) fn bounce(&self, now_us: u64) -> Option<&TakenBack> {
        match self {
            Self::Captive { taken_back, .. } => {
                taken_back.as_ref().filter(|taken_back| taken_back.may_be_a_bounce(now_us))
            }
            Self::Latched { .. } => None,
        }
    }
}

/// A suspected launch that was withdrawn.
#[derive(Clone, Copy, Debug)]
pub(super) struct TakenBack {
    /// When, microseconds.
    time_us: u64,
    /// It was as short as a bounce. A longer one was decided: a broken wire raises no more suspicions.
    is_bounce: bool,
    /// Failed checks of the calibration held for it.
    pub(super) failed_checks: u16,
}

impl TakenBack {
    /// Withdrawn now, with the calibration held for it.
    pub(super) const fn now(now_us: u64, held: &LatchRecord) -> Self {
        Self {
            time_us: now_us,
            is_bounce: now_us.saturating_sub(held.time_us) <= BOUNCE_US,
            failed_checks: held.failed_checks,
        }
    }

    /// Whether the parting contacts may just have bounced: the held calibration is still stored, and a
    /// restart that finds the wire open continues from it.
    const fn may_be_a_bounce(&self, now_us: u64) -> bool {
        self.is_bounce && now_us.saturating_sub(self.time_us) < BOUNCE_US
    }
}
