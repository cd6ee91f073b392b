//! The verdict while the wire shows no opening, because it reads closed, is broken or cannot be read: the
//! table's other rows.

use super::{Confirmation, LaunchDetector, Verdict, WireCondition, count};
use crate::guard::Guard;

/// A sign of launch while the wire shows none.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Sign {
    Force { since_us: u64, has_lasted: bool },
    Silence { since_us: u64 },
}

impl LaunchDetector {
    /// `says_nothing`: the wire is broken or cannot be read; otherwise it reads closed.
    #[inline(never)]
    pub(super) fn judge_without(&mut self, now_us: u64, says_nothing: bool) -> Verdict {
        if let Some(sign) = self.sign {
            self.sign = self.followed(sign, now_us, says_nothing);
            if self.sign.is_none() {
                count(&mut self.counts.false_alarms);
            }
        }
        if self.sign.is_none() {
            self.sign = self.new_sign(now_us, says_nothing);
        }
        let by = match self.sign {
            None => return Verdict::Captive,
            Some(Sign::Silence { since_us }) => self.shown_by_silence(since_us, now_us),
            Some(Sign::Force { since_us, has_lasted }) => {
                if self.link.is_alive_at(since_us, &self.config) {
                    let by =
                        if says_nothing { Confirmation::ForceAndSilence } else { Confirmation::StuckWire };
                    (has_lasted && self.link.is_silent(now_us, &self.config)).then_some(by)
                } else {
                    self.shown_by_force(since_us, now_us, says_nothing)
                }
            }
        };
        by.map_or(Verdict::Suspected, Verdict::Launched)
    }

    /// A broken wire, and messages that have ended.
    fn shown_by_silence(&self, since_us: u64, now_us: u64) -> Option<Confirmation> {
        if self.has_changed(since_us) {
            return Some(Confirmation::ForceAndSilence);
        }
        Self::has_lasted(since_us, now_us, self.config.undecided_s).then_some(Confirmation::Unconfirmed)
    }

    /// The force alone, without messages: only together with the climb rate.
    fn shown_by_force(&self, since_us: u64, now_us: u64, says_nothing: bool) -> Option<Confirmation> {
        let is_fall = self.force.falling_since_us().is_some_and(|falling_us| falling_us <= now_us);
        let lasts = |limit_s| is_fall && Self::has_lasted(since_us, now_us, limit_s);
        if self.climb.has_fallen(since_us) {
            if lasts(self.config.fall_s) {
                return Some(Confirmation::FreeFall);
            }
            if says_nothing {
                return Some(Confirmation::Unconfirmed);
            }
        }
        let stands_alone = says_nothing && !self.climb.is_known(since_us, now_us);
        (lasts(self.config.long_fall_s) && (stands_alone || !Guard::ClosedWireHolds.stands()))
            .then_some(Confirmation::FreeFall)
    }

    fn new_sign(&self, now_us: u64, says_nothing: bool) -> Option<Sign> {
        let departed = self.force.departed_us().filter(|departed_us| *departed_us == now_us);
        if let Some(since_us) = departed.filter(|_| says_nothing) {
            return Some(Sign::Force { since_us, has_lasted: true });
        }
        let fall = self
            .force
            .falling_since_us()
            .filter(|since_us| !self.is_attached_after(*since_us) && self.refuted_fall_us != Some(*since_us));
        if let Some(since_us) = fall {
            return Some(Sign::Force { since_us, has_lasted: false });
        }
        let is_cut = self.wire.condition() == WireCondition::Broken
            && self.link.is_silent(now_us, &self.config)
            && self.refuted_silence_us != self.link.last_us();
        is_cut.then_some(Sign::Silence { since_us: now_us })
    }

    /// The sign as it stands now; `None`: it is withdrawn.
    fn followed(&mut self, sign: Sign, now_us: u64, says_nothing: bool) -> Option<Sign> {
        match sign {
            Sign::Silence { since_us } => {
                let is_refuted = Self::has_lasted(since_us, now_us, self.config.undecided_s)
                    && !self.has_changed(since_us)
                    && self.character.is_known(now_us);
                if is_refuted {
                    self.refuted_silence_us = self.link.last_us();
                }
                (!is_refuted && self.link.is_silent(now_us, &self.config)).then_some(sign)
            }
            Sign::Force { since_us, has_lasted } => {
                if self.is_attached_after(since_us) {
                    return None;
                }
                let falling_us = self.force.falling_since_us();
                let goes_on = falling_us == Some(since_us);
                if !self.link.is_alive_at(since_us, &self.config) {
                    // A unit that still reads a fall after this time, while the climb rate shows none, is
                    // dead.
                    if Self::has_lasted(since_us, now_us, self.config.undecided_s) {
                        self.refuted_fall_us = falling_us;
                        return None;
                    }
                    return (goes_on || (says_nothing && has_lasted)).then_some(sign);
                }
                let has_lasted = has_lasted
                    || (goes_on && Self::has_lasted(since_us, now_us, self.config.fall_s))
                    || (says_nothing && self.force.departed_us() == Some(since_us));
                (has_lasted || goes_on).then_some(Sign::Force { since_us, has_lasted })
            }
        }
    }
}
