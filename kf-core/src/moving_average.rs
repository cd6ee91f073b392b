//! The moving average of eq. 17.

use core::fmt::{self, Formatter};

use serde::de::{Error as _, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};

/// Number of bins into which the window is divided.
const PARTS: u64 = 32;
/// Number of closed bins; one more is being filled.
const CLOSED: usize = 31;

/// Sum of the samples in one bin of the window, or in several.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Bin {
    sum: f32,
    /// A whole number; f32 counts exactly to 2^24, 16 million samples a window.
    #[serde(with = "whole_number")]
    count: f32,
}

/// A count that is held as f32 but stored in one to four bytes instead of always four.
mod whole_number {
    use serde::{Deserialize, Deserializer, Serializer};

    #[expect(clippy::trivially_copy_pass_by_ref, reason = "serde's form")]
    pub fn serialize<S: Serializer>(count: &f32, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_u32(*count as u32)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f32, D::Error> {
        u32::deserialize(deserializer).map(|count| count as f32)
    }
}

/// The closed bins. A loop, because serde's own implementation for an array repeats the code for each
/// element.
fn bins<'de, D: Deserializer<'de>>(deserializer: D) -> Result<[Bin; CLOSED], D::Error> {
    struct Bins;

    impl<'de> Visitor<'de> for Bins {
        type Value = [Bin; CLOSED];

        fn expecting(&self, formatter: &mut Formatter<'_>) -> fmt::Result {
            write!(formatter, "{CLOSED} bins")
        }

        fn visit_seq<A: SeqAccess<'de>>(self, mut sequence: A) -> Result<Self::Value, A::Error> {
            let mut bins = [Bin::EMPTY; CLOSED];
            for (place, bin) in bins.iter_mut().enumerate() {
                *bin = sequence.next_element()?.ok_or_else(|| A::Error::invalid_length(place, &self))?;
            }
            Ok(bins)
        }
    }

    deserializer.deserialize_tuple(CLOSED, Bins)
}

impl Bin {
    const EMPTY: Self = Self { sum: 0.0, count: 0.0 };

    fn add(&mut self, other: Self) {
        self.sum += other.sum;
        self.count += other.count;
    }

    fn take_off(&mut self, other: Self) {
        self.sum -= other.sum;
        self.count -= other.count;
    }
}

/// Mean of the samples of the last `window`, at any sample rate, at constant cost and memory.
///
/// The window is kept as 32 bins. The oldest one is dropped as a whole, so the mean covers between 31/32 of
/// the window and all of it. Each time the ring has gone round, the running total of the closed bins is
/// replaced by a sum that was started one turn earlier: f32 rounding errors last for two windows at most,
/// however long it runs.
#[derive(Clone, Debug, PartialEq)]
pub struct MovingAverage {
    bins: KeptAverage,
    bin_us: u64,
}

/// State of a moving average that cannot be recovered from its window.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct KeptAverage {
    open: Bin,
    /// Total of the closed bins.
    closed: Bin,
    open_ends_us: u64,
    /// Total of the bins closed since the ring last went round.
    fresh: Bin,
    #[serde(deserialize_with = "bins")]
    ring: [Bin; CLOSED],
    /// Where the next bin to close goes; below `CLOSED`.
    next: u8,
}

impl KeptAverage {
    const EMPTY: Self = Self {
        open: Bin::EMPTY,
        closed: Bin::EMPTY,
        open_ends_us: 0,
        fresh: Bin::EMPTY,
        ring: [Bin::EMPTY; CLOSED],
        next: 0,
    };
}

impl MovingAverage {
    /// A moving average over `window_us` microseconds (at least 32).
    #[must_use]
    pub fn new(window_us: u64) -> Self {
        Self { bins: KeptAverage::EMPTY, bin_us: (window_us / PARTS).max(1) }
    }

    /// Clears every sample, in place.
    pub fn restart(&mut self) {
        let bins = &mut self.bins;
        bins.open = Bin::EMPTY;
        bins.closed = Bin::EMPTY;
        bins.open_ends_us = 0;
        bins.fresh = Bin::EMPTY;
        bins.ring.fill(Bin::EMPTY);
        bins.next = 0;
    }

    pub(crate) fn kept(&self) -> KeptAverage {
        self.bins
    }

    pub(crate) fn restore(&mut self, kept: &KeptAverage) {
        self.bins = *kept;
    }

    /// Adds a sample (finite, times increasing) and returns the mean of the window.
    #[inline(always)]
    pub fn add(&mut self, time_us: u64, sample: f32) -> f32 {
        if self.is_due(time_us) {
            self.close_bins(time_us);
        }
        self.add_to_open(sample)
    }

    /// Whether the open bin must be closed before a sample of this time is added.
    #[inline(always)]
    pub(crate) const fn is_due(&self, time_us: u64) -> bool {
        time_us >= self.bins.open_ends_us
    }

    /// [`Self::add`] if no bin is due.
    #[inline(always)]
    pub(crate) fn add_to_open(&mut self, sample: f32) -> f32 {
        self.bins.open.sum += sample;
        self.bins.open.count += 1.0;
        self.mean()
    }

    /// Samples in the open bin.
    pub(crate) const fn open_count(&self) -> u32 {
        self.bins.open.count as u32
    }

    /// Mean of the open bin's samples; NaN if it is empty.
    pub(crate) const fn open_mean(&self) -> f32 {
        self.bins.open.sum / self.bins.open.count
    }

    /// When the open bin ends; 0 before the first.
    pub(crate) const fn open_ends_us(&self) -> u64 {
        self.bins.open_ends_us
    }

    /// Length of a bin, microseconds.
    pub(crate) fn bin_us(&self) -> u32 {
        u32::try_from(self.bin_us).unwrap_or(u32::MAX)
    }

    /// Mean of the window's samples; NaN if it is empty.
    #[inline(always)]
    pub(crate) fn mean(&self) -> f32 {
        let KeptAverage { open, closed, .. } = &self.bins;
        (closed.sum + open.sum) / (closed.count + open.count)
    }

    /// Advances to the bin that contains `time_us`: the next one, except after a gap.
    #[inline(never)]
    pub(crate) fn close_bins(&mut self, time_us: u64) {
        self.close_bin();
        if time_us >= self.bins.open_ends_us {
            self.catch_up(time_us);
        }
    }

    #[cold]
    fn catch_up(&mut self, time_us: u64) {
        let late_us = time_us.saturating_sub(self.bins.open_ends_us);
        if late_us >= self.bin_us.saturating_mul(PARTS - 1) {
            // The first sample, or the first after a gap longer than the window: every bin is empty by now,
            // and the rounding error of the total is cleared with them.
            self.restart();
            self.bins.open_ends_us = time_us.wrapping_add(self.bin_us);
            return;
        }
        // At most 31 times, whatever the clock reads: the bins' ends wrap with the clock.
        for _ in 1..PARTS {
            if time_us < self.bins.open_ends_us {
                return;
            }
            self.close_bin();
        }
    }

    #[inline(always)]
    fn close_bin(&mut self) {
        let bins = &mut self.bins;
        if let Some(oldest) = bins.ring.get_mut(usize::from(bins.next)) {
            bins.closed.add(bins.open);
            bins.closed.take_off(*oldest);
            *oldest = bins.open;
        }
        bins.fresh.add(bins.open);
        bins.next = bins.next.wrapping_add(1);
        if usize::from(bins.next) >= CLOSED {
            bins.next = 0;
            bins.closed = bins.fresh;
            bins.fresh = Bin::EMPTY;
        }
        bins.open = Bin::EMPTY;
        // 64 bits of microseconds wrap after half a million years.
        bins.open_ends_us = bins.open_ends_us.wrapping_add(self.bin_us);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn lags_a_ramp_by_half_the_window() {
        let window_us = 3_000_000;
        let mut average = MovingAverage::new(window_us);
        let mut last = 0.0;
        for k in 0..4_000_u64 {
            last = average.add(k * 5_000, k as f32 * 0.005);
        }
        let lag = 3_999.0 * 0.005 - last;
        // 31/32 to all of the window, with one sample at either end.
        assert!(lag > 1.5 * 31.0 / 32.0 - 0.005 && lag < 1.5 + 0.005, "{lag}");
    }

    #[test]
    fn does_not_drift_in_ten_hours() {
        let mut average = MovingAverage::new(2_000_000);
        let mut last = 0.0;
        for k in 0..7_200_000_u64 {
            // Large values first: a running sum would keep their rounding.
            let x = if k < 7_190_000 { 1.0e4 + (k % 7) as f32 * 0.1 } else { 0.25 };
            last = average.add(k * 5_000, x);
        }
        assert_eq!(last, 0.25);
    }

    /// The ends of bins wrap at the end of 64 bits of microseconds: the result is then useless, but there is
    /// one.
    #[test]
    fn a_clock_at_its_end_is_survived() {
        let mut average = MovingAverage::new(3_200_000);
        for before_end_us in [5_000_000, 3_000_000, 2_900_000, 90_000, 50_000, 10, 5, 1, 0] {
            assert_eq!(average.add(u64::MAX - before_end_us, 7.0), 7.0);
        }
    }

    proptest! {
        #[test]
        fn agrees_with_the_exact_mean_of_a_window_between_31_and_32_parts(
            // Gaps up to the length of the whole window, and beyond, among many samples.
            steps in prop::collection::vec(
                (prop_oneof![9 => 1_u64..400_000, 1 => 2_800_000_u64..3_600_000], -100.0_f32..100.0),
                1..300,
            ),
        ) {
            let window_us = 3_200_000;
            let mut average = MovingAverage::new(window_us);
            let mut samples: Vec<(u64, f32)> = Vec::new();
            let mut now = 17;
            for (dt, x) in steps {
                now += dt;
                samples.push((now, x));
                let got = f64::from(average.add(now, x));
                // It is the mean of the newest samples, cut at an age between the two limits.
                let possible = (0..samples.len()).any(|first| {
                    let age = |k: usize| now - samples[k].0;
                    let fits = age(first) <= window_us
                        && (first == 0 || age(first - 1) >= window_us / 32 * 31);
                    let newest = samples[first..].iter().map(|(_, x)| f64::from(*x));
                    fits && (newest.sum::<f64>() / (samples.len() - first) as f64 - got).abs() < 1e-3
                });
                prop_assert!(possible, "{got} at {now}");
            }
        }
    }
}
