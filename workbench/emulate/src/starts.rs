//! How evenly the ticks began.

/// Start times of ticks, compared with the even grid of their timer.
#[derive(Clone, Debug, Default)]
pub struct Starts {
    begun: Vec<u32>,
}

impl Starts {
    /// Adds the start of the next tick: instructions, wrapping.
    pub fn take(&mut self, begun: u32) {
        self.begun.push(begun);
    }

    /// Period of the timer's interrupts, instructions: the median interval between two ticks. The emulated
    /// timer's period is not exactly the 5 ms that it is set to.
    #[must_use]
    pub fn period(&self) -> u32 {
        let mut intervals = self.intervals();
        let middle = intervals.len() / 2;
        match intervals.get(middle) {
            Some(_) => *intervals.select_nth_unstable(middle).1,
            None => 0,
        }
    }

    /// Largest difference between how late two ticks began on the grid, instructions. There may be interrupts
    /// without a tick between them.
    #[must_use]
    pub fn jitter(&self) -> u64 {
        let period = i64::from(self.period().max(1));
        let (mut late, mut earliest, mut latest) = (0_i64, 0, 0);
        for interval in self.intervals() {
            late += (i64::from(interval) + period / 2).rem_euclid(period) - period / 2;
            earliest = earliest.min(late);
            latest = latest.max(late);
        }
        latest.abs_diff(earliest)
    }

    fn intervals(&self) -> Vec<u32> {
        self.begun
            .iter()
            .zip(self.begun.iter().skip(1))
            .map(|(last, next)| next.wrapping_sub(*last))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD: i64 = 4_999_999;

    /// Ticks at these places of the grid, each this late.
    fn starts(ticks: impl IntoIterator<Item = (i64, i64)>) -> Starts {
        let mut starts = Starts::default();
        for (place, late) in ticks {
            // The counter wraps within the first ten.
            starts.take((4_280_000_000 + place * PERIOD + late) as u32);
        }
        starts
    }

    #[test]
    fn the_jitter_is_from_the_promptest_tick_to_the_latest() {
        assert_eq!((starts([]).period(), starts([]).jitter()), (0, 0));
        assert_eq!(starts([(0, 3)]).jitter(), 0);
        let even = starts((0..20).map(|k| (k, 7)));
        assert_eq!((even.period(), even.jitter()), (4_999_999, 0));
        assert_eq!(starts((0..20).map(|k| (k, [5, 0, 5, 11, 5][k as usize % 5]))).jitter(), 11);
        // One tick in a thousand is late, then every tick from one on.
        assert_eq!(starts((0..1_000).map(|k| (k, if k == 400 { 90 } else { 0 }))).jitter(), 90);
        assert_eq!(starts((0..1_000).map(|k| (k, if k >= 400 { 90 } else { 0 }))).jitter(), 90);
    }

    #[test]
    fn interrupts_without_a_tick_are_left_out() {
        let places = [0, 1, 2, 3, 4, 7, 8, 300, 301];
        assert_eq!(starts(places.map(|place| (place, if place == 7 { 3 } else { 0 }))).jitter(), 3);
    }
}
