//! How often the flight computer has restarted lately: a crash that comes back at once must not keep it
//! busy with restarts for good.

use crate::check::{opened, sealed};

/// So many restarts...
pub const LOOP_RESTARTS: usize = 4;
/// ... within this time of the mission are a loop, microseconds.
pub const LOOP_US: u64 = 10_000_000;

const WORDS: usize = 1 + 2 * LOOP_RESTARTS;
pub(crate) const SEALED_WORDS: usize = WORDS + 1;

/// The restarts since power-on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct History {
    /// How many there were.
    pub restarts: u32,
    /// When the last ones were, by the mission's clock, microseconds; the newest last.
    times_us: [u64; LOOP_RESTARTS],
}

impl History {
    /// Notes one more.
    #[must_use]
    pub fn with_restart(self, time_us: u64) -> Self {
        let [_, older @ ..] = self.times_us;
        let mut times = older.into_iter().chain([time_us]);
        Self {
            restarts: self.restarts.saturating_add(1),
            times_us: core::array::from_fn(|_| times.next().unwrap_or(0)),
        }
    }

    /// Whether the last [`LOOP_RESTARTS`] restarts lie within [`LOOP_US`].
    #[must_use]
    pub fn is_loop(&self) -> bool {
        let [first, .., last] = self.times_us;
        self.restarts as usize >= LOOP_RESTARTS && last.saturating_sub(first) <= LOOP_US
    }

    pub(crate) fn to_words(self) -> [u32; SEALED_WORDS] {
        let mut words = [self.restarts; WORDS];
        let times = self.times_us.iter().flat_map(|time_us| [*time_us as u32, (time_us >> 32) as u32]);
        for (word, half) in words.iter_mut().skip(1).zip(times) {
            *word = half;
        }
        sealed(words)
    }

    pub(crate) fn from_words(words: &[u32; SEALED_WORDS]) -> Option<Self> {
        let [restarts, times @ ..] = opened::<WORDS, SEALED_WORDS>(words)?;
        let mut pairs = times.chunks_exact(2).map(|pair| match pair {
            [low, high] => u64::from(*low) | u64::from(*high) << 32,
            _ => 0,
        });
        Some(Self { restarts, times_us: core::array::from_fn(|_| pairs.next().unwrap_or(0)) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_fourth_restart_within_ten_seconds_is_a_loop() {
        let at = |times: &[u64]| times.iter().fold(History::default(), |history, t| history.with_restart(*t));
        assert!(!at(&[1_000, 2_000, 3_000]).is_loop());
        assert!(at(&[1_000, 2_000, 3_000, 4_000]).is_loop());
        assert!(at(&[0, 0, 0, LOOP_US]).is_loop());
        assert!(!at(&[0, 1, 2, LOOP_US + 1]).is_loop());
        assert!(at(&[0, 90_000_000, 91_000_000, 92_000_000, 93_000_000]).is_loop());
        assert!(!at(&[0, 1, 2, 90_000_000, 91_000_000, 92_000_000]).is_loop());
    }

    #[test]
    fn comes_back_as_it_went() {
        let history = History::default().with_restart(1 << 40).with_restart(u64::MAX);
        let words = history.to_words();
        assert_eq!(History::from_words(&words), Some(history));
        let mut changed = words;
        changed[3] ^= 1;
        assert_eq!(History::from_words(&changed), None);
        assert_eq!(History::from_words(&[0; SEALED_WORDS]), None);
    }
}
