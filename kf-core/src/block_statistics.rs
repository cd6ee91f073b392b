//! Spread and trend of an autocorrelated series, in constant memory.

/// How many blocks are kept.
const BLOCKS: usize = 32;
/// Length of a block at first, microseconds.
const FIRST_BLOCK_US: u64 = 1_000_000;
/// Fewest blocks that a trend is computed from: two parameters, and three to judge them by.
const FEWEST_FOR_TREND: usize = 5;

/// Number, mean and sum of squared deviations of some samples.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Block {
    count: u32,
    mean: f32,
    squares: f32,
}

impl Block {
    /// Welford's update.
    #[inline]
    fn add(&mut self, sample: f32) {
        self.count = self.count.saturating_add(1);
        let before = sample - self.mean;
        self.mean += before / self.count as f32;
        self.squares += before * (sample - self.mean);
    }

    /// Both together (Chan, Golub, LeVeque 1979).
    fn merged(self, other: Self) -> Self {
        if self.count == 0 {
            return other;
        }
        if other.count == 0 {
            return self;
        }
        let count = self.count.saturating_add(other.count);
        let share = other.count as f32 / count as f32;
        let apart = other.mean - self.mean;
        Self {
            count,
            mean: self.mean + apart * share,
            squares: self.squares + other.squares + apart * apart * share * self.count as f32,
        }
    }
}

/// Mean and spread of all samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Summary {
    /// Number of samples.
    pub count: u32,
    /// Their mean.
    pub mean: f32,
    /// Their variance.
    pub variance: f32,
    /// Variance of the mean by batch means: the blocks' scatter, so that autocorrelation within a
    /// block is accounted for. Zero if there are fewer than two blocks.
    pub mean_variance: f32,
    /// Variance of the block means: the slow part of the spread.
    pub block_variance: f32,
}

/// A straight line through the block means.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trend {
    /// Change from the first block to the last.
    pub drift: f32,
    /// Its variance, from the scatter of the blocks about the line.
    pub drift_variance: f32,
}

/// Block means of a series: at most 32 blocks, which double in length when they run out.
#[derive(Clone, Debug, PartialEq)]
pub struct BlockStatistics {
    blocks: [Block; BLOCKS],
    start_us: Option<u64>,
    block_us: u64,
    /// Number of the block that is being filled, and where it ends.
    open: usize,
    open_ends_us: u64,
}

impl Default for BlockStatistics {
    fn default() -> Self {
        Self::EMPTY
    }
}

impl BlockStatistics {
    /// Of nothing yet. A constant, so that it is written where it stays: these blocks are most of what a
    /// mission keeps, and copies of them on the way were most of the stack.
    pub const EMPTY: Self = Self {
        blocks: [Block { count: 0, mean: 0.0, squares: 0.0 }; BLOCKS],
        start_us: None,
        block_us: FIRST_BLOCK_US,
        open: 0,
        open_ends_us: 0,
    };

    /// Adds a finite sample; times increase.
    #[inline]
    pub fn add(&mut self, time_us: u64, sample: f32) {
        if time_us >= self.open_ends_us {
            self.open_block(time_us);
        }
        if let Some(block) = self.blocks.get_mut(self.open) {
            block.add(sample);
        }
    }

    /// Finds the block of `time_us`, halving the resolution until there is one.
    #[inline(never)]
    fn open_block(&mut self, time_us: u64) {
        let start_us = *self.start_us.get_or_insert(time_us);
        let age_us = time_us.saturating_sub(start_us);
        // `block_us` doubles from 1 s and ends the loop before it can overflow: 32 blocks of 2^58 us
        // hold every u64.
        while age_us / self.block_us.max(1) >= BLOCKS as u64 {
            for k in 0..BLOCKS {
                let pair = |offset| self.blocks.get(2 * k + offset).copied().unwrap_or_default();
                let merged = pair(0).merged(pair(1));
                if let Some(block) = self.blocks.get_mut(k) {
                    *block = merged;
                }
            }
            self.block_us = self.block_us.saturating_mul(2);
        }
        self.open = usize::try_from(age_us / self.block_us.max(1)).unwrap_or(0);
        let ends = (self.open as u64 + 1).saturating_mul(self.block_us);
        self.open_ends_us = start_us.saturating_add(ends);
    }

    /// Mean and spread; `None` without two samples.
    #[must_use]
    pub fn summary(&self) -> Option<Summary> {
        let all = self.blocks.iter().fold(Block::default(), |sum, block| sum.merged(*block));
        if all.count < 2 {
            return None;
        }
        let mut means = Block::default();
        for block in self.blocks.iter().filter(|block| block.count > 0) {
            means.add(block.mean);
        }
        let (block_variance, mean_variance) = if means.count < 2 {
            (0.0, 0.0)
        } else {
            let variance = means.squares / (means.count - 1) as f32;
            (variance, variance / means.count as f32)
        };
        let variance = all.squares / (all.count - 1) as f32;
        Some(Summary { count: all.count, mean: all.mean, variance, mean_variance, block_variance })
    }

    /// Least-squares line through the means of blocks `from..to` of the filled span, given in 32nds
    /// of it (0..32 is everything); `None` with fewer than five blocks.
    #[must_use]
    pub fn trend(&self, from: usize, to: usize) -> Option<Trend> {
        let filled = self.open + 1;
        let range = (filled * from / BLOCKS)..(filled * to / BLOCKS);
        let points = || {
            let blocks = self.blocks.get(range.clone()).unwrap_or(&[]);
            blocks.iter().enumerate().filter(|(_, b)| b.count > 0).map(|(k, b)| (k as f32, b.mean))
        };
        let count = points().count();
        if count < FEWEST_FOR_TREND {
            return None;
        }
        let n = count as f32;
        let mean_x = points().map(|(x, _)| x).sum::<f32>() / n;
        let mean_y = points().map(|(_, y)| y).sum::<f32>() / n;
        let xx = points().map(|(x, _)| (x - mean_x) * (x - mean_x)).sum::<f32>();
        let xy = points().map(|(x, y)| (x - mean_x) * (y - mean_y)).sum::<f32>();
        let slope = xy / xx;
        let residual = |(x, y): (f32, f32)| {
            let r = y - mean_y - slope * (x - mean_x);
            r * r
        };
        let scatter = points().map(residual).sum::<f32>() / (n - 2.0);
        let span = points().next_back().map_or(0.0, |(x, _)| x) - points().next().map_or(0.0, |(x, _)| x);
        Some(Trend { drift: slope * span, drift_variance: span * span * scatter / xx })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn filled(samples: impl Iterator<Item = f32>, period_us: u64) -> BlockStatistics {
        let mut statistics = BlockStatistics::default();
        for (k, x) in samples.enumerate() {
            statistics.add(1_000 + k as u64 * period_us, x);
        }
        statistics
    }

    #[test]
    fn too_little_says_so() {
        assert_eq!(filled([].into_iter(), 1).summary(), None);
        assert_eq!(filled([1.0].into_iter(), 1).summary(), None);
        assert_eq!(filled((0..4).map(|k| k as f32), 1_000_000).trend(0, 32), None);
    }

    #[test]
    fn a_ramp_drifts_by_its_height_and_noise_does_not() {
        // 100 s at 20 Hz: 4 s blocks, 25 of them; the line spans their centres, 96 s.
        let trend = filled((0..2_000).map(|k| k as f32 * 0.01), 50_000).trend(0, 32).unwrap();
        assert!((trend.drift - 19.2).abs() < 1e-3, "{trend:?}");
        assert!(trend.drift_variance < 1e-6);
        let alternating = filled((0..2_000).map(|k| if k % 2 == 0 { 1.0 } else { -1.0 }), 50_000);
        let trend = alternating.trend(0, 32).unwrap();
        assert!(trend.drift.abs() <= 3.0 * trend.drift_variance.sqrt() + 1e-6, "{trend:?}");
    }

    #[test]
    fn an_hour_at_two_hundred_hertz_keeps_its_digits() {
        let n = 720_000_u32;
        let x = |k: u32| 2_000.0 + f32::from((k % 201) as u16) * 0.01;
        let summary = filled((0..n).map(x), 5_000).summary().unwrap();
        let mean = (0..n).map(|k| f64::from(x(k))).sum::<f64>() / f64::from(n);
        let squares = (0..n).map(|k| (f64::from(x(k)) - mean).powi(2)).sum::<f64>();
        let variance = squares / f64::from(n - 1);
        // f32 keeps 2,000 m to 0.12 mm; a mean must not lose more than a few of those.
        assert!((f64::from(summary.mean) - mean).abs() < 6e-4, "{} {mean}", summary.mean);
        assert!((f64::from(summary.variance) / variance - 1.0).abs() < 1e-3);
    }

    proptest! {
        #[test]
        fn agrees_with_two_pass_arithmetic(
            samples in prop::collection::vec(-1e3_f32..1e3, 2..500),
            period_us in 1_000_u64..10_000_000,
        ) {
            let summary = filled(samples.iter().copied(), period_us).summary().unwrap();
            let n = samples.len() as f64;
            let mean = samples.iter().map(|x| f64::from(*x)).sum::<f64>() / n;
            let squares = samples.iter().map(|x| (f64::from(*x) - mean).powi(2)).sum::<f64>();
            prop_assert_eq!(summary.count as usize, samples.len());
            prop_assert!((f64::from(summary.mean) - mean).abs() < 1e-2);
            prop_assert!((f64::from(summary.variance).sqrt() - (squares / (n - 1.0)).sqrt()).abs() < 1e-1);
        }
    }
}
