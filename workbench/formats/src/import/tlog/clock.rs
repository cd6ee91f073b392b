//! The sender's clock.

use super::value::{Stamp, Timed};

/// Times in microseconds beyond this are since 1970 (it is in the year 2001), not since the sender started.
pub const EPOCH_US: u64 = 1_000_000_000_000_000;
/// A clock that goes back by more has restarted: one sender's messages may arrive slightly out of time order.
const RESTART_US: u64 = 5_000_000;
/// A message's time farther than this from its reception is not by this clock.
const FAR_US: u64 = 60_000_000;

/// Time of a value, by the sender's clock.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Time {
    /// Known to the microsecond.
    Microseconds(u64),
    /// Known to the millisecond.
    Milliseconds(u64),
}

/// Microseconds since the start, if the message gives them.
pub const fn boot_us(stamp: Stamp) -> Option<u64> {
    match stamp {
        Stamp::Microseconds(time_us) if time_us < EPOCH_US => Some(time_us),
        Stamp::Milliseconds(time_ms) => Some(time_ms as u64 * 1_000),
        Stamp::Microseconds(_) | Stamp::None => None,
    }
}

/// The longest stretch of values between two starts of the sender, and the number of restarts.
pub fn longest_run(values: Vec<Timed>) -> (Vec<Timed>, usize) {
    let mut latest_us = 0;
    let mut starts = vec![0];
    for (index, timed) in values.iter().enumerate() {
        // A time by a receiver's or another clock does not show a start.
        let Stamp::Milliseconds(_) = timed.stamp else { continue };
        let Some(time_us) = boot_us(timed.stamp) else { continue };
        if time_us + RESTART_US < latest_us {
            starts.push(index);
            latest_us = 0;
        }
        latest_us = latest_us.max(time_us);
    }
    let restarts = starts.len() - 1;
    let ends = starts.iter().skip(1).copied().chain([values.len()]);
    let longest = starts.iter().copied().zip(ends).max_by_key(|(start, end)| end - start);
    let run = longest.and_then(|(start, end)| values.get(start..end)).map(<[Timed]>::to_vec);
    (run.unwrap_or_default(), restarts)
}

/// Conversion from the receiver's clock to the sender's.
pub struct Clock {
    /// How far the receiver's clock is ahead, with the least delay seen, ignoring one in a hundred: a
    /// receiver's time that is wrong by less than a second is not detected, and must not shift all others.
    ahead_us: Option<u64>,
}

impl Clock {
    /// From the values that have a time of both clocks.
    pub fn of(values: &[Timed]) -> Self {
        let ahead =
            |timed: &Timed| Some((timed.recorded_us, timed.recorded_us.checked_sub(boot_us(timed.stamp)?)?));
        // A frame with several values counts once.
        let mut frames: Vec<(u64, u64)> = values.iter().filter_map(ahead).collect();
        frames.dedup();
        let mut found: Vec<u64> = frames.into_iter().map(|(_, ahead_us)| ahead_us).collect();
        let place = (found.len() / 100).max(usize::from(found.len() > 2));
        let ahead_us = (place < found.len()).then(|| *found.select_nth_unstable(place).1);
        Self { ahead_us }
    }

    /// Time of a value. Without a time of the sender, the receiver's time is used.
    pub fn time(&self, timed: &Timed) -> Time {
        let received_us = timed.recorded_us.saturating_sub(self.ahead_us.unwrap_or(0));
        let is_near = |time_us: &u64| time_us.abs_diff(received_us) <= FAR_US;
        match (timed.stamp, boot_us(timed.stamp).filter(is_near)) {
            (Stamp::Milliseconds(_), Some(time_us)) => Time::Milliseconds(time_us / 1_000),
            (_, Some(time_us)) => Time::Microseconds(time_us),
            (_, None) => Time::Microseconds(received_us),
        }
    }
}
