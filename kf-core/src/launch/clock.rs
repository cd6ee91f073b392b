//! The ticks' clock without its leaps.
//!
//! A leap between the opening of the wire and a message that came within the cable's slack would make of that
//! message one that came too late for a launch, and of everything else a long silence. A clock that runs back
//! would hide a departure until it has caught up. A tick is a tick, whatever its clock: both are counted as
//! one.

use super::LaunchInput;

/// A tick comes every 5 ms. One that is later than this by the clock is a clock that has leapt: after an
/// outage there is another detector.
const LEAP_US: u64 = 100_000;
/// What has passed then.
const TICK_US: u64 = 5_000;

#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Clock {
    /// The last tick, as the clock had it.
    last_us: Option<u64>,
    /// What it has leapt by in all: wraps, as it may have run back by more than it has leapt on.
    leapt_us: u64,
    /// The last message's time, as the clock had it and without leaps.
    message_us: Option<(u64, u64)>,
}

impl Clock {
    /// A tick's input by a clock that has not leapt, and by how much it has leapt on since the tick before,
    /// microseconds: negative where it has run back, or stood still.
    #[inline]
    pub(super) fn without_leaps(&mut self, input: &LaunchInput) -> (LaunchInput, i64) {
        let elapsed_us = self.last_us.map_or(TICK_US, |last_us| input.time_us.wrapping_sub(last_us));
        self.last_us = Some(input.time_us);
        // One comparison for both: what runs back has wrapped, and so has nothing less one.
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

    /// A message's time without leaps, of what its time and this tick's make of that.
    #[inline]
    fn message(&mut self, message_us: u64, without_us: u64) -> u64 {
        let without_us = match self.message_us {
            Some((last_us, without_us)) if last_us == message_us => return without_us,
            // One from before a leap that is seen after it is still a later one.
            Some((last_us, least_us)) if last_us < message_us => without_us.max(least_us.saturating_add(1)),
            _ => without_us,
        };
        self.message_us = Some((message_us, without_us));
        without_us
    }

    /// A time without leaps, as the clock would have it now.
    #[inline]
    pub(super) const fn told_us(&self, without_us: u64) -> u64 {
        without_us.wrapping_add(self.leapt_us)
    }
}
