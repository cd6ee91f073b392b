//! The ticks' clock without its leaps.
//!
//! After a leap between the opening of the wire and a message within the cable's slack, that message would
//! seem too late for a launch, and otherwise there would seem to be a long silence. A clock that runs back
//! would hide a departure until it has caught up. Therefore every leap counts as one tick.

use super::LaunchInput;

/// Time between two ticks, which come every 5 ms, from which the clock has leapt: after an outage there is a
/// new detector.
const LEAP_US: u64 = 100_000;
/// The time that is taken to have passed then.
const TICK_US: u64 = 5_000;

#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Clock {
    /// The last tick's time by the clock.
    last_us: Option<u64>,
    /// Sum of all leaps. It wraps, because the clock may have run back by more than it has leapt forward.
    leapt_us: u64,
    /// The last message's time, by the clock and without leaps.
    message_us: Option<(u64, u64)>,
}

impl Clock {
    /// A tick's input by a clock without leaps, and the clock's leap since the previous tick, microseconds:
    /// negative if it has run back or stood still.
    #[inline]
    pub(super) fn without_leaps(&mut self, input: &LaunchInput) -> (LaunchInput, i64) {
        let elapsed_us = self.last_us.map_or(TICK_US, |last_us| input.time_us.wrapping_sub(last_us));
        self.last_us = Some(input.time_us);
        // One comparison for all: a time that ran back has wrapped, and so has 0 less 1.
        let has_leapt = elapsed_us.wrapping_sub(1) >= LEAP_US;
        let leap_us = if has_leapt { elapsed_us.wrapping_sub(TICK_US) } else { 0 };
        self.leapt_us = self.leapt_us.wrapping_add(leap_us);
        let time_us = input.time_us.wrapping_sub(self.leapt_us);
        let last_message_us = input.last_message_us.map(|message_us| {
            self.message(
                message_us,
                time_us.saturating_add_signed(message_us.wrapping_sub(input.time_us).cast_signed()),
            )
        });
        (LaunchInput { time_us, last_message_us, ..*input }, leap_us.cast_signed())
    }

    /// A message's time without leaps, from its time by the clock and the estimate at this tick.
    #[inline]
    fn message(&mut self, message_us: u64, without_us: u64) -> u64 {
        let without_us = match self.message_us {
            Some((last_us, without_us)) if last_us == message_us => return without_us,
            // A message from before a leap that is seen after it is still later than the previous one.
            Some((last_us, least_us)) if last_us < message_us => without_us.max(least_us.saturating_add(1)),
            _ => without_us,
        };
        self.message_us = Some((message_us, without_us));
        without_us
    }

    /// A time without leaps as a time of the clock now.
    #[inline]
    pub(super) const fn told_us(&self, without_us: u64) -> u64 {
        without_us.wrapping_add(self.leapt_us)
    }
}
