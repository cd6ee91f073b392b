//! Keeps a mission's state while it flies, so that a restart can continue from it.

use core::mem::MaybeUninit;

use kf_core::launch::{CAPTIVE_FORCE_WORDS, CaptiveForce, WireCondition};
use kf_core::navigation::KeptInertial;
use kf_core::snapshot::{MissionMark, MissionSnapshot, RaisedFlags, SnapshotError, Stage};
use survival::{Flight, MarkWriter, PAYLOAD_BYTES, SlotOrder, TickMark, WordMemory};

use crate::computer::Step;
use crate::estimation::Retainable;
use crate::onboard::Onboard;

/// Time between snapshots, microseconds of the mission. One is also kept whenever the mark has changed: a
/// launch is suspected or decided, or a flag has been raised.
const EVERY_US: u64 = 100_000;

/// Keeps the mark of a tick at its end. `count` is the board's free-running timer, `wire` the launch
/// detector's view of the wire.
#[inline]
pub fn keep_mark(
    writer: &mut MarkWriter,
    memory: &mut impl WordMemory,
    mission: &impl Retainable,
    step: &Step,
    count: u32,
    wire: Option<WireCondition>,
) {
    let wire_is_broken = wire == Some(WireCondition::Broken);
    if !step.output.out_of_order {
        writer.keep(memory, &tick_mark(step.input.time_us, count, &mission.mark(), wire_is_broken));
    }
}

/// Converts a mission's mark to its kept form.
#[inline]
const fn tick_mark(time_us: u64, count: u32, mark: &MissionMark, wire_is_broken: bool) -> TickMark {
    TickMark {
        time_us,
        count,
        flags: mark.flags.bits(),
        failed_checks: mark.failed_checks,
        suspicions: mark.suspicions,
        flight: match mark.stage {
            Stage::Captive if wire_is_broken => Flight::CaptiveUnwired,
            Stage::Captive => Flight::Captive,
            Stage::Suspected => Flight::Suspected,
            Stage::Launched => Flight::Free,
        },
    }
}

/// Converts a kept mark to the mission's.
#[must_use]
pub const fn mission_mark(mark: &TickMark) -> MissionMark {
    MissionMark {
        stage: match mark.flight {
            Flight::Captive | Flight::CaptiveUnwired => Stage::Captive,
            Flight::Suspected => Stage::Suspected,
            Flight::Free => Stage::Launched,
        },
        flags: RaisedFlags::from_bits(mark.flags),
        failed_checks: mark.failed_checks,
        suspicions: mark.suspicions,
    }
}

/// Contents of one snapshot: the mission, the inertial altitude that it flies with, and the mark of the same
/// tick.
#[derive(Clone, Debug)]
pub struct Snapshot {
    mark: MissionMark,
    inertial: Option<KeptInertial>,
    mission: MissionSnapshot,
}

impl Snapshot {
    /// Writes the inertial altitude, then the mission, and returns their number of bytes. If both do not fit
    /// (a mission of eight effects with windows of a minute takes all the room), only the mission is kept.
    #[inline(never)]
    fn to_bytes(&self, buffer: &mut [u8; PAYLOAD_BYTES]) -> Result<usize, SnapshotError> {
        let written = self.write(self.inertial.as_ref(), buffer);
        if self.inertial.is_some() && written.is_err() { self.write(None, buffer) } else { written }
    }

    fn write(
        &self,
        inertial: Option<&KeptInertial>,
        buffer: &mut [u8; PAYLOAD_BYTES],
    ) -> Result<usize, SnapshotError> {
        let inertial = postcard::to_slice(&inertial, buffer).map_err(|_| SnapshotError::BufferTooShort)?;
        let length = inertial.len();
        let rest = buffer.get_mut(length..).ok_or(SnapshotError::BufferTooShort)?;
        Ok(length + self.mission.to_bytes(rest)?)
    }
}

/// Splits the inertial altitude off a snapshot's bytes; the mission's follow.
#[inline(never)]
pub(crate) fn split_snapshot(bytes: &[u8]) -> Result<(Option<KeptInertial>, &[u8]), SnapshotError> {
    postcard::take_from_bytes(bytes).map_err(|_| SnapshotError::Format)
}

/// Keeps snapshots of a mission, below the tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SnapshotKeeper {
    order: SlotOrder,
    model: u64,
    last: Option<(u64, MissionMark)>,
    lost: u32,
    /// Whether the memory has what the force was like under the pylon, as far as is known.
    has_force: Option<bool>,
}

impl SnapshotKeeper {
    /// A keeper that has not kept any snapshot since the start.
    #[must_use]
    pub const fn new(order: SlotOrder, model: u64) -> Self {
        Self { order, model, last: None, lost: 0, has_force: None }
    }

    /// Makes the snapshot in `place`, if one is due. Under the pylon none is kept. A snapshot is large, so it
    /// is not moved.
    #[inline(never)]
    pub fn make_due<'a>(
        &self,
        mission: &impl Retainable,
        onboard: Option<&Onboard>,
        place: &'a mut MaybeUninit<Snapshot>,
    ) -> Option<&'a Snapshot> {
        let mark = mission.mark();
        if mark.stage == Stage::Captive {
            return None;
        }
        let is_due = self.last.is_none_or(|(last_us, last)| {
            mark != last || mission.last_us().saturating_sub(last_us) >= EVERY_US
        });
        if !is_due {
            return None;
        }
        let mission = mission.snapshot()?;
        Some(place.write(Snapshot { mark, inertial: onboard.and_then(Onboard::kept), mission }))
    }

    /// [`kf_core::launch::LaunchDetector::captive_force`], if the memory has none yet, or words that are none
    /// if it must not have one any more; to be kept with [`survival::keep_captive_force`].
    #[inline(never)]
    pub fn captive_force_due(&mut self, onboard: Option<&Onboard>) -> Option<[u32; CAPTIVE_FORCE_WORDS]> {
        let force = onboard?.launch().captive_force();
        let is_due = self.has_force.replace(force.is_some()) != Some(force.is_some());
        is_due.then(|| force.map_or([u32::MAX; CAPTIVE_FORCE_WORDS], CaptiveForce::to_words))
    }

    /// Keeps a snapshot; `buffer` is ordinary memory.
    #[inline(never)]
    pub fn keep(
        &mut self,
        memory: &mut impl WordMemory,
        snapshot: &Snapshot,
        buffer: &mut [u8; PAYLOAD_BYTES],
    ) {
        self.last = Some((snapshot.mission.time_us(), snapshot.mark));
        let bytes = snapshot.to_bytes(buffer).ok().and_then(|length| buffer.get(..length));
        if bytes.is_none_or(|bytes| self.order.keep(memory, self.model, bytes).is_err()) {
            self.lost = self.lost.saturating_add(1);
        }
    }

    /// Number of snapshots that could not be kept.
    #[must_use]
    pub const fn lost(&self) -> u32 {
        self.lost
    }
}

#[cfg(test)]
mod tests {
    extern crate std;

    use std::vec::Vec;

    use kf_core::input::{ImuSample, TickInput};
    use kf_core::launch::LaunchConfig;
    use kf_core::strapdown;

    use super::*;

    /// The memory of an earlier flight, or of a suspicion that is over, must not say that the force has not
    /// departed: the next opening may be the release.
    #[test]
    fn the_force_under_the_pylon_is_kept_while_a_torn_cable_is_suspected_and_no_longer() {
        let mut onboard = Onboard::new(LaunchConfig::DEFAULT, strapdown::Config::MEMS).unwrap();
        let mut keeper = SnapshotKeeper::new(SlotOrder::EMPTY, 1);
        let none = [u32::MAX; CAPTIVE_FORCE_WORDS];
        assert_eq!(CaptiveForce::from_words(none), None);
        let mut kept = Vec::new();
        for tick in 0..4_400 {
            let is_open = (4_000..4_200).contains(&tick);
            let noise_mps2 = if tick % 2 == 0 { 0.05 } else { -0.05 };
            let mut input = TickInput {
                time_us: 1_000_000 + tick * 5_000,
                imu: Some(ImuSample { accel_mps2: [0.0, 0.0, noise_mps2 - 9.8], gyro_radps: [0.0; 3] }),
                ..TickInput::default()
            };
            onboard.complete(&mut input, Some(is_open));
            kept.extend(keeper.captive_force_due(Some(&onboard)).map(|words| (tick, words == none)));
        }
        // The window is a quarter of a second: 50 ticks.
        assert_eq!(kept, [(0, true), (4_050, false), (4_200, true)]);
    }
}
