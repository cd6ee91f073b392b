//! Times at which a sensor's trust changed.

use kf_core::output::Trust;

/// The monitor's flags of one sensor and their times.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Flags {
    /// First tick at which the sensor was doubtful or worse, microseconds.
    pub(super) doubtful_us: Option<u64>,
    /// First tick at which it was untrustworthy.
    pub(super) untrustworthy_us: Option<u64>,
    /// Time for which it was not monitored, microseconds.
    pub(super) unmonitored_us: u64,
    /// Trust after the last tick.
    pub(super) last: Option<Trust>,
    last_us: Option<u64>,
}

impl Flags {
    /// Takes the trust after one tick of free flight.
    #[inline]
    pub(super) fn take(&mut self, time_us: u64, trust: Trust) {
        match trust {
            Trust::Doubtful => {
                self.doubtful_us.get_or_insert(time_us);
            }
            Trust::Untrustworthy => {
                self.doubtful_us.get_or_insert(time_us);
                self.untrustworthy_us.get_or_insert(time_us);
            }
            Trust::Unmonitored => {
                self.unmonitored_us += time_us.saturating_sub(self.last_us.unwrap_or(time_us));
            }
            Trust::Calibrating | Trust::Trusted => {}
        }
        self.last = Some(trust);
        self.last_us = Some(time_us);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn notes_the_first_time_of_each_flag_and_the_time_without_a_reference() {
        let mut flags = Flags::default();
        use Trust::{Doubtful, Trusted, Unmonitored, Untrustworthy};
        for (time_us, trust) in [
            (10, Trusted),
            (20, Unmonitored),
            (35, Unmonitored),
            (40, Trusted),
            (50, Doubtful),
            (60, Doubtful),
            (70, Untrustworthy),
            (80, Untrustworthy),
        ] {
            flags.take(time_us, trust);
        }
        assert_eq!((flags.doubtful_us, flags.untrustworthy_us), (Some(50), Some(70)));
        assert_eq!(flags.unmonitored_us, 25);
        assert_eq!(flags.last, Some(Untrustworthy));
    }
}
