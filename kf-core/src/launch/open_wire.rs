//! The verdict while the wire reads open and has not been found broken: the table's rows that begin with
//! "open".

use super::{Confirmation, LaunchDetector, Verdict, count};
use crate::guard::Guard;
use crate::time::microseconds;

/// Longest time that the wire may stay open, with a unit that would not have felt a release and an unchanged
/// climb rate, before that is decided, seconds. A vehicle is steered within a minute of its release, and the
/// carrier's crew sees most faults that last a minute. If the unit is still dead, it is a launch: if the cable
/// has torn, two faults make a false launch; if the vehicle was released, one fault hides it for this long.
const UNSHOWN_S: f32 = 60.0;
/// For this long a small change of the climb rate shows a release, seconds. It is twice the limit: a vehicle
/// that sinks has lost that much by then, and a carrier's swings last longer.
const SOON_S: f32 = 6.0;

/// The table's column "messages".
#[derive(Clone, Copy, PartialEq, Eq)]
enum Messages {
    /// One came later after the edge than the cable's slack allows: the umbilical is still there.
    CameLater,
    /// They were alive at the edge, and are not silent yet.
    Alive,
    /// They were alive at the edge, and are silent now.
    FellSilent,
    /// There were none at the edge.
    Absent,
}

/// The table's column "force and climb rate".
#[derive(Clone, Copy, PartialEq, Eq)]
enum Motion {
    /// The force has another character, or the climb rate has fallen.
    Changed,
    /// The force departed about the edge, and has no other character.
    Departed,
    /// The inertial unit delivers, and would have shown a release.
    Unchanged,
    /// The inertial unit is dead, or reads a fall that did not begin with the opening and that the climb rate
    /// does not show.
    NotKnown,
}

impl LaunchDetector {
    #[inline(never)]
    pub(super) fn judge_open(
        &mut self,
        now_us: u64,
        edge_us: u64,
        is_settled: bool,
        is_early: bool,
    ) -> Verdict {
        if !is_settled {
            self.has_departed = self.has_departed && self.wire.has_reopened();
            return Verdict::Suspected;
        }
        let departs_about = self
            .force
            .departed_us()
            .is_some_and(|departed_us| departed_us.abs_diff(edge_us) <= microseconds(self.config.window_s));
        // A release is felt within the window. A force that became too low before or after it is not the
        // release's, if the climb rate would show the fall.
        let is_other_fall = self.force.is_below() && !departs_about && self.climb.is_known(edge_us, now_us);
        if is_other_fall {
            self.character.disregard_changes();
        }
        if self.unmoved_us != Some(edge_us) {
            self.has_departed |= departs_about;
            let has_shown = Self::has_lasted(edge_us, now_us, self.config.window_s);
            if is_other_fall {
                self.character.call_blind();
            }
            let is_unmoved = has_shown && !self.has_departed && self.character.is_known(now_us);
            self.unmoved_us = is_unmoved.then_some(edge_us);
        }
        let is_over = Self::has_lasted(edge_us, now_us, self.config.undecided_s);
        let messages = self.messages_since(edge_us, now_us);
        if messages == Messages::FellSilent && !Guard::ListenUntilDecided.stands() {
            return Verdict::Launched(Confirmation::Silence);
        }
        match messages {
            Messages::CameLater => {
                self.wire.call_broken();
                count(&mut self.counts.broken_wires);
                return Verdict::Captive;
            }
            Messages::Alive if !is_over => return Verdict::Suspected,
            Messages::Alive | Messages::FellSilent | Messages::Absent => {}
        }
        let motion = self.motion_since(edge_us, now_us, is_other_fall);
        // Without a captive character only a departure can show a release, and it comes within the window.
        let is_decidable = is_over
            || (motion == Motion::Unchanged
                && !self.character.is_comparable()
                && Self::has_lasted(edge_us, now_us, self.config.window_s));
        let is_free = match motion {
            Motion::Changed => {
                return Verdict::Launched(match messages {
                    _ if self.has_departed => Confirmation::Force,
                    Messages::Absent => Confirmation::Unconfirmed,
                    _ => Confirmation::Silence,
                });
            }
            _ if !is_decidable => return Verdict::Suspected,
            Motion::NotKnown if !is_early && self.climbs_as_before(edge_us, now_us) => {
                if !Self::has_lasted(edge_us, now_us, UNSHOWN_S) {
                    return Verdict::Suspected;
                }
                is_other_fall || !self.character.lives(now_us)
            }
            Motion::Departed | Motion::NotKnown => !is_early,
            Motion::Unchanged => false,
        };
        if is_free {
            return Verdict::Launched(Confirmation::Unconfirmed);
        }
        self.wire.call_broken();
        count(&mut self.counts.torn_cables);
        self.refuted_silence_us = self.link.last_us();
        Verdict::Captive
    }

    fn messages_since(&self, edge_us: u64, now_us: u64) -> Messages {
        if self.is_attached_after(edge_us) {
            Messages::CameLater
        } else if !self.link.is_alive_at(edge_us, &self.config) {
            Messages::Absent
        } else if self.link.is_silent(now_us, &self.config) {
            Messages::FellSilent
        } else {
            Messages::Alive
        }
    }

    fn motion_since(&self, edge_us: u64, now_us: u64, is_other_fall: bool) -> Motion {
        if self.climb.has_fallen(edge_us) || self.character.has_changed() {
            Motion::Changed
        } else if self.has_departed {
            Motion::Departed
        } else if self.character.is_living(now_us) && !is_other_fall {
            Motion::Unchanged
        } else {
            Motion::NotKnown
        }
    }

    /// Whether the climb rate is what it was under the pylon. It is the only witness where the unit is dead, or
    /// was when it would have felt a release.
    fn climbs_as_before(&self, edge_us: u64, now_us: u64) -> bool {
        let is_soon = !Self::has_lasted(edge_us, now_us, SOON_S);
        self.character.is_comparable()
            && self.climb.is_known(edge_us, now_us)
            && !self.climb.is_another(is_soon)
    }
}
