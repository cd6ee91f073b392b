//! Counts the flight computer's restarts, and detects whether it crashes again as soon as it runs.

/// Number of crashes in a row that cause no pause.
pub const CRASHES_AT_ONCE: u32 = 3;
/// Length of a run that ends a row of crashes, microseconds: four crashes within ten seconds are a row.
pub const STEADY_US: u64 = 3_333_333;
/// The first pause, microseconds: longer than the watchdog's 0.25 s and than the transients of up to a second
/// that may cause a crash. Each further pause is twice as long.
pub const FIRST_PAUSE_US: u64 = 1_000_000;
/// The longest pause, microseconds: a flight computer that crashes at once is tried again more than three
/// times a minute.
pub const LONGEST_PAUSE_US: u64 = 16_000_000;

pub(crate) const WORDS: usize = 4;
pub(crate) const SEALED_WORDS: usize = WORDS + 1;

/// The restarts since power-on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct History {
    /// Number of restarts.
    pub restarts: u32,
    /// Number of the last restarts that were crashes, each after a run shorter than [`STEADY_US`].
    pub crashes: u32,
    /// Time at which the mission's clock continued at the last restart, microseconds.
    pub resumed_us: u64,
}

impl History {
    /// Counts one more restart, after a run that ended at `ended_us` of the mission's clock; the next run
    /// begins at `resumed_us`. Only a restart with `is_crash` counts towards a pause.
    #[must_use]
    pub const fn with_restart(self, is_crash: bool, ended_us: u64, resumed_us: u64) -> Self {
        let ran_us = ended_us.saturating_sub(self.resumed_us);
        let crashes = match is_crash {
            false => self.crashes,
            true if ran_us >= STEADY_US => 1,
            true => self.crashes.saturating_add(1),
        };
        Self { restarts: self.restarts.saturating_add(1), crashes, resumed_us }
    }

    /// Length of the standby before the mission continues, microseconds, after a crash that is the last of
    /// [`Self::crashes`].
    #[must_use]
    pub const fn pause_us(&self) -> u64 {
        match self.crashes.checked_sub(CRASHES_AT_ONCE + 1) {
            None => 0,
            Some(doublings @ 0..4) => FIRST_PAUSE_US << doublings,
            Some(_) => LONGEST_PAUSE_US,
        }
    }

    pub(crate) const fn to_words(self) -> [u32; WORDS] {
        [self.restarts, self.crashes, self.resumed_us as u32, (self.resumed_us >> 32) as u32]
    }

    pub(crate) const fn from_words([restarts, crashes, low, high]: [u32; WORDS]) -> Self {
        Self { restarts, crashes, resumed_us: low as u64 | (high as u64) << 32 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Crashes after runs of these lengths.
    fn after(runs_us: &[u64]) -> History {
        runs_us.iter().fold(History::default(), |history, ran_us| {
            let ended_us = history.resumed_us + ran_us;
            history.with_restart(true, ended_us, ended_us + 100_000)
        })
    }

    #[test]
    fn the_fourth_crash_in_a_row_pauses_and_each_next_one_twice_as_long() {
        let pauses =
            |runs| (1..=runs).map(|k| after(&vec![1_000; k]).pause_us() / 1_000_000).collect::<Vec<_>>();
        assert_eq!(pauses(10), [0, 0, 0, 1, 2, 4, 8, 16, 16, 16]);
        assert_eq!(History { crashes: u32::MAX, ..after(&[1]) }.pause_us(), LONGEST_PAUSE_US);
    }

    #[test]
    fn a_steady_run_ends_the_row() {
        assert_eq!(
            after(&[9_000_000, STEADY_US - 1, STEADY_US - 1, STEADY_US - 1]).pause_us(),
            FIRST_PAUSE_US
        );
        assert_eq!(after(&[1, 1, 1, STEADY_US]).crashes, 1);
        assert_eq!(after(&[1, 1, 1, 1, 1, STEADY_US, 1]).pause_us(), 0);
    }

    #[test]
    fn what_is_no_crash_counts_as_a_restart_only() {
        let dips = (1..=20).fold(History::default(), |history, k| history.with_restart(false, k, k));
        assert_eq!((dips.restarts, dips.crashes, dips.pause_us()), (20, 0, 0));
        let between =
            after(&[1, 1, 1]).with_restart(false, 400_000, 400_000).with_restart(true, 400_001, 400_002);
        assert_eq!((between.restarts, between.crashes), (5, 4));
    }

    #[test]
    fn comes_back_as_it_went() {
        let history = History { restarts: 7, crashes: 3, resumed_us: (1 << 40) + 5 };
        assert_eq!(History::from_words(history.to_words()), history);
    }
}
