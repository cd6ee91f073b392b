//! Sorts values into rows by their times.

use std::collections::BTreeMap;

use super::clock::Time;

/// The rows of a flight, by microseconds of the sender's clock.
#[derive(Default)]
pub struct Rows {
    /// Time and row; rows are numbered once all times are known.
    times: BTreeMap<u64, usize>,
}

impl Rows {
    /// A row for each time. A time known only to the millisecond joins the first row of that millisecond: a
    /// flight computer's messages of one tick become one row again.
    pub fn new(times: &[Time]) -> Self {
        let mut rows = Self::default();
        for time in times {
            if let Time::Microseconds(time_us) = time {
                rows.times.insert(*time_us, 0);
            }
        }
        for time in times {
            if let Time::Milliseconds(time_ms) = time
                && rows.within(*time_ms).is_none()
            {
                rows.times.insert(time_ms * 1_000, 0);
            }
        }
        for (row, slot) in rows.times.values_mut().enumerate() {
            *slot = row;
        }
        rows
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.times.len()
    }

    /// The row of a time that was given to [`Self::new`].
    pub fn row(&self, time: Time) -> Option<usize> {
        match time {
            Time::Microseconds(time_us) => self.times.get(&time_us).copied(),
            Time::Milliseconds(time_ms) => self.within(time_ms),
        }
    }

    /// Time of every row since the first, seconds.
    pub fn seconds(&self) -> Vec<f64> {
        let first_us = self.times.keys().next().copied().unwrap_or(0);
        self.times.keys().map(|time_us| (time_us - first_us) as f64 / 1e6).collect()
    }

    fn within(&self, time_ms: u64) -> Option<usize> {
        self.times.range(time_ms * 1_000..(time_ms + 1) * 1_000).next().map(|(_, row)| *row)
    }
}
