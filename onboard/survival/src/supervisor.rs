//! Supervises whether every activity is alive.

use core::sync::atomic::{AtomicU32, Ordering};

/// A supervised activity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Supervised {
    /// The mission's tick.
    Tick = 0,
    /// The task that supplies input.
    Feed = 1,
    /// The task that writes results.
    Report = 2,
    /// The stack: its end is untouched.
    Stack = 3,
    /// The task that sends the telemetry.
    Transmit = 4,
    /// The task that makes the telemetry.
    Telemetry = 5,
}

impl Supervised {
    /// All supervised activities.
    pub const ALL: [Self; 6] =
        [Self::Tick, Self::Feed, Self::Report, Self::Stack, Self::Transmit, Self::Telemetry];

    /// The name used in logs.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Tick => "tick",
            Self::Feed => "feed",
            Self::Report => "report",
            Self::Stack => "stack",
            Self::Transmit => "transmit",
            Self::Telemetry => "tell",
        }
    }

    const fn bit(self) -> u32 {
        1 << self as u8
    }
}

const ALL: u32 = 0b11_1111;

/// Activities without a sign of life since the last feed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Late(u8);

impl Late {
    /// From a byte of [`Self::bits`].
    #[must_use]
    pub const fn from_bits(bits: u8) -> Self {
        Self(bits)
    }

    /// The bits as a byte.
    #[must_use]
    pub const fn bits(self) -> u8 {
        self.0
    }

    /// Whether an activity is among them.
    #[must_use]
    pub const fn contains(self, supervised: Supervised) -> bool {
        self.0 as u32 & supervised.bit() != 0
    }
}

/// Collects signs of life. The watchdog may be fed only when every activity has given one since the last
/// feed, so that a running task cannot hide a stopped one.
#[derive(Debug, Default)]
pub struct Supervisor {
    seen: AtomicU32,
}

impl Supervisor {
    /// A supervisor without any signs of life yet.
    #[must_use]
    pub const fn new() -> Self {
        Self { seen: AtomicU32::new(0) }
    }

    /// Records a sign of life. May be called from any priority.
    #[inline]
    pub fn is_alive(&self, supervised: Supervised) {
        self.seen.fetch_or(supervised.bit(), Ordering::Relaxed);
    }

    /// Whether the watchdog may be fed. If so, every activity has to give a sign again before the next feed.
    #[inline]
    pub fn may_feed(&self) -> bool {
        let is_whole = self.seen.load(Ordering::Relaxed) & ALL == ALL;
        if is_whole {
            // A sign between the load and the store is lost, but comes again.
            self.seen.store(0, Ordering::Relaxed);
        }
        is_whole
    }

    /// Activities without a sign of life since the last feed.
    #[must_use]
    pub fn late(&self) -> Late {
        Late((!self.seen.load(Ordering::Relaxed) & ALL) as u8)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn is_fed_only_when_all_have_been_seen_since() {
        for missing in Supervised::ALL {
            let supervisor = Supervisor::new();
            for _ in 0..3 {
                Supervised::ALL.into_iter().for_each(|one| supervisor.is_alive(one));
                assert!(supervisor.may_feed());
                assert!(!supervisor.may_feed(), "not twice for the same signs");
            }
            for _ in 0..100 {
                for one in Supervised::ALL.into_iter().filter(|one| *one != missing) {
                    supervisor.is_alive(one);
                }
                assert!(!supervisor.may_feed(), "{missing:?}");
            }
            let late = Late::from_bits(supervisor.late().bits());
            assert!(Supervised::ALL.into_iter().all(|one| late.contains(one) == (one == missing)));
            supervisor.is_alive(missing);
            assert!(supervisor.may_feed());
        }
    }
}
