//! The mother ship's messages: whether they come regularly, and whether they have stopped.

use super::{LaunchConfig, LaunchCounts, LaunchInput, count};
use crate::time::microseconds;

/// Intervals needed to know the messages' rhythm; until then a silence must last for the time limit.
const LEAST_INTERVALS: u8 = 2;
/// Weight of one interval in their mean: one in eight.
const WEIGHT: u64 = 8;
/// Shortest silence, microseconds: the mother ship's operating system may pause as long.
const SHORTEST_SILENCE_US: u64 = 50_000;

#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Link {
    last_us: Option<u64>,
    interval_us: u64,
    intervals: u8,
}

impl Link {
    /// Whether this tick brought a message.
    pub(super) fn take(
        &mut self,
        input: &LaunchInput,
        config: &LaunchConfig,
        counts: &mut LaunchCounts,
    ) -> bool {
        let Some(message_us) = input.last_message_us else { return false };
        let Some(last_us) = self.last_us.filter(|_| message_us <= input.time_us) else {
            if message_us > input.time_us {
                count(&mut counts.messages_refused);
                return false;
            }
            self.last_us = Some(message_us);
            return true;
        };
        if message_us <= last_us {
            if message_us < last_us {
                count(&mut counts.messages_refused);
            }
            return false;
        }
        let interval_us = message_us - last_us;
        self.last_us = Some(message_us);
        if self.has_rhythm() && interval_us > self.silence_us(config) {
            // A silence is not an interval: the rhythm is learned again.
            count(&mut counts.link_losses);
            self.intervals = 0;
            return true;
        }
        self.interval_us = match self.intervals {
            0 => interval_us,
            // Each share is divided by itself: their sum may exceed 64 bits.
            _ => self.interval_us - self.interval_us / WEIGHT + interval_us / WEIGHT,
        };
        self.intervals = self.intervals.saturating_add(1);
        true
    }

    const fn has_rhythm(&self) -> bool {
        self.intervals >= LEAST_INTERVALS
    }

    fn silence_us(&self, config: &LaunchConfig) -> u64 {
        if !self.has_rhythm() {
            return microseconds(config.undecided_s);
        }
        self.interval_us.saturating_mul(u64::from(config.silent_intervals)).max(SHORTEST_SILENCE_US)
    }

    /// When the last message came.
    pub(super) const fn last_us(&self) -> Option<u64> {
        self.last_us
    }

    /// Whether messages came until that time.
    #[inline(never)]
    pub(super) fn is_alive_at(&self, time_us: u64, config: &LaunchConfig) -> bool {
        let limit_us = self.silence_us(config);
        self.last_us.is_some_and(|last_us| time_us.saturating_sub(last_us) <= limit_us)
    }

    /// Whether messages came, and have stopped.
    pub(super) fn is_silent(&self, now_us: u64, config: &LaunchConfig) -> bool {
        self.last_us.is_some() && !self.is_alive_at(now_us, config)
    }
}
