//! What the launch has made of the calibration: it goes on, is held, or is latched.
//!
//! | state | launch discrete and doubt | next |
//! |---|---|---|
//! | captive | neither a launch nor a suspicion | captive |
//! | captive | suspected | suspected: the calibration is copied and held |
//! | captive | a launch | suspected and launched in the same tick |
//! | suspected | still suspected | suspected: a part of the checks is made |
//! | suspected | neither | captive: the calibration goes on |
//! | suspected | a launch | launched: what is held is the latch |
//! | launched | any | launched |

use crate::calibration::StatisticalChecks;
use crate::latch::LatchRecord;
use crate::snapshot::Stage;

/// Contacts that part bounce for so long at most, microseconds: the wire's debounce.
const BOUNCE_US: u64 = 20_000;

/// See the module.
#[derive(Clone, Debug)]
#[expect(clippy::large_enum_variant, reason = "there is one, in place, and no heap")]
pub(super) enum Latching {
    /// Under the pylon.
    Captive {
        /// The last suspicion of a launch that was none.
        taken_back: Option<TakenBack>,
        /// The reference was lost and came back during it: the next fix has none before it.
        has_reacquired: bool,
    },
    /// From the first edge on, as the watches are begun: a suspected launch is flown as one, in secret, so
    /// that nothing depends on how long it takes to confirm it.
    Latched {
        /// The calibration of the first edge.
        record: LatchRecord,
        /// What has come of it.
        decision: Decision,
    },
}

/// What has come of the first edge of a launch.
#[derive(Clone, Debug)]
pub(super) enum Decision {
    /// Nothing yet: the record is held.
    Suspected {
        /// What the record's failed checks do not have yet.
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

    /// The calibration that is held or latched.
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

    /// As it is kept in a tick's mark.
    #[inline]
    pub(super) const fn stage(&self) -> Stage {
        match self {
            Self::Captive { .. } => Stage::Captive,
            Self::Latched { decision: Decision::Suspected { .. }, .. } => Stage::Suspected,
            Self::Latched { decision: Decision::Launched, .. } => Stage::Launched,
        }
    }

    /// The reference was lost and is back. Only a suspicion remembers it.
    #[inline]
    pub(super) const fn note_reacquired(&mut self) {
        if let Self::Latched { decision: Decision::Suspected { has_reacquired, .. }, .. } = self {
            *has_reacquired = true;
        }
    }

    /// Whether the reference came back in the last suspicion, once.
    #[inline]
    pub(super) const fn take_reacquired(&mut self) -> bool {
        match self {
            Self::Captive { has_reacquired, .. } => core::mem::replace(has_reacquired, false),
            Self::Latched { .. } => false,
        }
    }

    /// The last suspicion, if parting contacts that bounce may continue it; `now_us` is in microseconds.
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

/// A suspicion of a launch that was taken back.
#[derive(Clone, Copy, Debug)]
pub(super) struct TakenBack {
    /// When, microseconds.
    time_us: u64,
    /// It was as short as a bounce. One that lasted was decided: of a wire that is broken nothing is
    /// suspected any more.
    is_bounce: bool,
    /// Of what was held for it.
    pub(super) failed_checks: u16,
}

impl TakenBack {
    /// Taken back now, with what was held for it.
    pub(super) const fn now(now_us: u64, held: &LatchRecord) -> Self {
        Self {
            time_us: now_us,
            is_bounce: now_us.saturating_sub(held.time_us) <= BOUNCE_US,
            failed_checks: held.failed_checks,
        }
    }

    /// Whether the parting contacts may have bounced just now: what was held is still kept, and a restart
    /// that finds the wire open goes on from that.
    const fn may_be_a_bounce(&self, now_us: u64) -> bool {
        self.is_bounce && now_us.saturating_sub(self.time_us) < BOUNCE_US
    }
}
