//! Keeps snapshots of the mission in the retained memory.

use kf_core::snapshot::{MissionMark, MissionSnapshot, Stage};
use survival::Slots;

use crate::flown_model::FINGERPRINT;

/// A snapshot is kept this often, microseconds of the mission, and whenever its mark has changed: a launch is suspected or
/// decided, or a flag has been raised.
const EVERY_US: u64 = 100_000;

/// What keeps them.
pub struct Keeper {
    slots: &'static mut Slots,
    last: Option<(u64, MissionMark)>,
    lost: u32,
}

impl Keeper {
    /// None has been kept since the start.
    pub const fn new(slots: &'static mut Slots) -> Self {
        Self { slots, last: None, lost: 0 }
    }

    /// Whether it is time for one. Under the pylon there is none to keep.
    pub fn is_due(&self, time_us: u64, mark: &MissionMark) -> bool {
        if mark.stage == Stage::Captive {
            return false;
        }
        self.last.is_none_or(|(last_us, last)| *mark != last || time_us.saturating_sub(last_us) >= EVERY_US)
    }

    /// Keeps it.
    pub fn keep(&mut self, snapshot: &MissionSnapshot, mark: MissionMark) {
        self.last = Some((snapshot.time_us(), mark));
        if self.slots.keep(FINGERPRINT, |buffer| snapshot.to_bytes(buffer).ok()).is_err() {
            self.lost = self.lost.saturating_add(1);
        }
    }

    /// How many could not be kept.
    pub const fn lost(&self) -> u32 {
        self.lost
    }
}
