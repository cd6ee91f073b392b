//! Spread and trend of an autocorrelated series, in constant memory.

/// Number of blocks kept.
const BLOCKS: usize = 32;
/// Number of blocks left when each pair is merged.
const HALF: usize = BLOCKS / 2;
/// Initial length of a block, microseconds.
const FIRST_BLOCK_US: u64 = 1_000_000;
/// Fewest blocks that a trend is computed from: two for its parameters, and three to judge them by.
const FEWEST_FOR_TREND: usize = 5;

/// Number, mean and sum of squared deviations of some samples.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Block {
    count: u32,
    mean: f32,
    squares: f32,
}

impl Block {
    const EMPTY: Self = Self { count: 0, mean: 0.0, squares: 0.0 };

    /// Welford's update.
    #[inline]
    fn add(&mut self, sample: f32) {
        self.count = self.count.saturating_add(1);
        let before = sample - self.mean;
        self.mean += before / self.count as f32;
        self.squares += before * (sample - self.mean);
    }

    /// Both merged (Chan, Golub, LeVeque 1979).
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

/// Statistics of the means of some blocks against the blocks' numbers: means, sums of squared deviations and
/// of products of deviations.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Line {
    count: u32,
    /// Numbers of the first and of the last block.
    first: f32,
    last: f32,
    number: f32,
    mean: f32,
    numbers_squared: f32,
    product: f32,
    means_squared: f32,
}

impl Line {
    const EMPTY: Self = Self {
        count: 0,
        first: 0.0,
        last: 0.0,
        number: 0.0,
        mean: 0.0,
        numbers_squared: 0.0,
        product: 0.0,
        means_squared: 0.0,
    };

    /// With one more block, unless that is empty (Welford's update, in two dimensions).
    #[inline]
    fn with(self, number: usize, block: Block) -> Self {
        if block.count == 0 {
            return self;
        }
        let last = number as f32;
        let count = self.count.saturating_add(1);
        let share = 1.0 / count as f32;
        let [along, apart] = [last - self.number, block.mean - self.mean];
        let [number, mean] = [self.number + along * share, self.mean + apart * share];
        Self {
            count,
            first: if self.count == 0 { last } else { self.first },
            last,
            number,
            mean,
            numbers_squared: self.numbers_squared + along * (last - number),
            product: self.product + along * (block.mean - mean),
            means_squared: self.means_squared + apart * (block.mean - mean),
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
    /// Variance of the mean by batch means: computed from the scatter of the blocks, so it accounts for
    /// autocorrelation within a block. Zero if there are fewer than two blocks.
    pub mean_variance: f32,
    /// Variance of the block means: the slow part of the spread.
    pub block_variance: f32,
}

/// A straight line through the block means.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trend {
    /// Change from the first block to the last.
    pub drift: f32,
    /// Variance of the drift, from the scatter of the blocks about the line.
    pub drift_variance: f32,
}

/// Block means of a series: at most 32 blocks, which double in length when they run out.
#[derive(Clone, Debug, PartialEq)]
pub struct BlockStatistics {
    /// The blocks before the one being filled. While pairs are still to be merged, all but the first `merged`
    /// blocks keep half the length, two in the place of one.
    blocks: [Block; BLOCKS],
    /// Number of pairs merged since the blocks doubled; [`HALF`] means all. No block closes before that.
    merged: usize,
    start_us: Option<u64>,
    block_us: u64,
    /// The block being filled, its number, and where it ends.
    filling: Block,
    open: usize,
    open_ends_us: u64,
    /// Totals of the blocks before that one: all their samples, and the means of the merged ones. Kept so
    /// that the tick that latches need not go through all blocks of all series.
    closed: Block,
    closed_means: Line,
}

impl BlockStatistics {
    /// Without samples.
    ///
    /// Use it as the constant it is, so that it is written in place: these blocks are most of what a mission
    /// keeps, and copies of them on the way were most of the stack.
    pub const EMPTY: Self = Self {
        blocks: [Block::EMPTY; BLOCKS],
        merged: HALF,
        start_us: None,
        block_us: FIRST_BLOCK_US,
        filling: Block::EMPTY,
        open: 0,
        open_ends_us: 0,
        closed: Block::EMPTY,
        closed_means: Line::EMPTY,
    };

    /// Lengthens the first blocks by `place` hundredths (0 to 9). Series that begin in the same tick with
    /// different places then run out of blocks, which is expensive, in different ticks. Call it before the
    /// first sample.
    pub const fn stagger(&mut self, place: u8) {
        self.block_us = FIRST_BLOCK_US + FIRST_BLOCK_US / 100 * place as u64;
    }

    /// Adds a finite sample; times increase.
    #[inline]
    pub fn add(&mut self, time_us: u64, sample: f32) {
        if time_us >= self.open_ends_us {
            self.open_block(time_us);
        }
        self.filling.add(sample);
    }

    /// Does part of the merging left since the blocks doubled, if any. Not calling it costs nothing but time:
    /// the rest is then done at once when the next block closes.
    #[inline]
    pub fn tidy(&mut self) {
        if self.merged < HALF {
            self.merge_pair();
        }
    }

    /// Moves on to the block that contains `time_us`; blocks double in length when they run out.
    #[inline(never)]
    fn open_block(&mut self, time_us: u64) {
        let start_us = *self.start_us.get_or_insert(time_us);
        if self.open_ends_us == 0 {
            self.open_ends_us = start_us.saturating_add(self.block_us);
        }
        // This terminates: each step moves the end on by a block, and sixteen double the block. 2^64 us are
        // 49 doublings of a second.
        while time_us >= self.open_ends_us && self.open_ends_us < u64::MAX {
            self.close();
            if self.open == BLOCKS {
                self.open = HALF;
                self.merged = 0;
                self.closed_means = Line::EMPTY;
                self.block_us = self.block_us.saturating_mul(2);
            }
            self.open_ends_us = self.open_ends_us.saturating_add(self.block_us);
        }
    }

    /// Closes the block being filled.
    fn close(&mut self) {
        while self.merged < HALF {
            self.merge_pair();
        }
        let block = core::mem::take(&mut self.filling);
        self.closed = self.closed.merged(block);
        self.closed_means = self.closed_means.with(self.open, block);
        if let Some(place) = self.blocks.get_mut(self.open) {
            *place = block;
        }
        self.open += 1;
    }

    /// Merges the next two blocks into one.
    #[inline(never)]
    fn merge_pair(&mut self) {
        let block = self.block(self.merged);
        if let Some(place) = self.blocks.get_mut(self.merged) {
            *place = block;
        }
        self.closed_means = self.closed_means.with(self.merged, block);
        self.merged += 1;
    }

    /// The block of that number, whether or not it has been merged.
    #[inline]
    fn block(&self, number: usize) -> Block {
        let kept = |place: usize| self.blocks.get(place).copied().unwrap_or_default();
        if number == self.open {
            self.filling
        } else if (self.merged..HALF).contains(&number) {
            kept(2 * number).merged(kept(2 * number + 1))
        } else {
            kept(number)
        }
    }

    #[inline(never)]
    fn closed_means(&self) -> Line {
        (self.merged..HALF).fold(self.closed_means, |line, number| line.with(number, self.block(number)))
    }

    /// Mean of all samples; `None` without any.
    #[must_use]
    pub fn mean(&self) -> Option<f32> {
        let all = self.closed.merged(self.filling);
        (all.count > 0).then_some(all.mean)
    }

    /// The means of all blocks.
    fn means(&self) -> Line {
        self.closed_means().with(self.open, self.filling)
    }

    /// Mean and spread; `None` without two samples.
    #[must_use]
    #[inline(never)]
    pub fn summary(&self) -> Option<Summary> {
        let all = self.closed.merged(self.filling);
        if all.count < 2 {
            return None;
        }
        let means = self.means();
        let (block_variance, mean_variance) = if means.count < 2 {
            (0.0, 0.0)
        } else {
            let variance = means.means_squared / (means.count - 1) as f32;
            (variance, variance / means.count as f32)
        };
        let variance = all.squares / (all.count - 1) as f32;
        Some(Summary { count: all.count, mean: all.mean, variance, mean_variance, block_variance })
    }

    /// Least-squares line through the means of the blocks; `None` with fewer than five of them.
    #[must_use]
    #[inline]
    pub fn trend(&self) -> Option<Trend> {
        self.trend_from(0, self.means())
    }

    /// The same of the later half of the blocks.
    #[must_use]
    #[inline]
    pub fn later_trend(&self) -> Option<Trend> {
        let from = usize::midpoint(self.open, 1);
        let line = (from..=self.open).fold(Line::EMPTY, |line, number| line.with(number, self.block(number)));
        self.trend_from(from, line)
    }

    /// Trend of the blocks from `from` on, whose means are `line`.
    // Not compiled here, for size, but with the mission, for speed; the same holds for what it calls.
    #[inline]
    fn trend_from(&self, from: usize, line: Line) -> Option<Trend> {
        if (line.count as usize) < FEWEST_FOR_TREND {
            return None;
        }
        let slope = line.product / line.numbers_squared;
        // Computed from the residuals themselves: the squares less what the line explains would cancel.
        let mut squares = 0.0;
        let mut along = from as f32 - line.number;
        for block in (from..=self.open).map(|number| self.block(number)) {
            if block.count > 0 {
                let residual = block.mean - line.mean - slope * along;
                squares += residual * residual;
            }
            along += 1.0;
        }
        let scatter = squares / (line.count as f32 - 2.0);
        let span = line.last - line.first;
        Some(Trend { drift: slope * span, drift_variance: span * span * scatter / line.numbers_squared })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn filled(samples: impl Iterator<Item = f32>, period_us: u64) -> BlockStatistics {
        let mut statistics = BlockStatistics::EMPTY;
        for (k, x) in samples.enumerate() {
            statistics.add(1_000 + k as u64 * period_us, x);
        }
        statistics
    }

    #[test]
    fn too_little_says_so() {
        assert_eq!(filled([].into_iter(), 1).summary(), None);
        assert_eq!(filled([1.0].into_iter(), 1).summary(), None);
        assert_eq!(filled((0..4).map(|k| k as f32), 1_000_000).trend(), None);
    }

    #[test]
    fn a_ramp_drifts_by_its_height_and_noise_does_not() {
        // 100 s at 20 Hz: 4 s blocks, 25 of them; the line spans their centres, 96 s.
        let trend = filled((0..2_000).map(|k| k as f32 * 0.01), 50_000).trend().unwrap();
        assert!((trend.drift - 19.2).abs() < 1e-3, "{trend:?}");
        assert!(trend.drift_variance < 1e-6);
        let alternating = filled((0..2_000).map(|k| if k % 2 == 0 { 1.0 } else { -1.0 }), 50_000);
        let trend = alternating.trend().unwrap();
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

        /// Compares with the samples sorted into blocks again, however much merging is left since the blocks
        /// doubled.
        #[test]
        fn a_block_has_the_samples_of_its_time(
            samples in prop::collection::vec(-1e3_f32..1e3, 1..500),
            period_us in 1_000_u64..10_000_000,
            tidied in 0_usize..3,
        ) {
            let mut statistics = BlockStatistics::EMPTY;
            let mut untidied = BlockStatistics::EMPTY;
            for (k, sample) in samples.iter().enumerate() {
                statistics.add(k as u64 * period_us, *sample);
                untidied.add(k as u64 * period_us, *sample);
                (0..tidied).for_each(|_| statistics.tidy());
            }
            prop_assert_eq!(statistics.summary(), untidied.summary());
            prop_assert_eq!(statistics.trend(), untidied.trend());
            prop_assert_eq!(statistics.later_trend(), untidied.later_trend());
            let mut blocks = vec![(0_u32, 0.0_f64); BLOCKS];
            for (k, sample) in samples.iter().enumerate() {
                let block = &mut blocks[(k as u64 * period_us / statistics.block_us) as usize];
                *block = (block.0 + 1, block.1 + f64::from(*sample));
            }
            for (number, (count, sum)) in blocks.into_iter().enumerate().take(statistics.open + 1) {
                let block = statistics.block(number);
                prop_assert_eq!(block.count, count, "{} of {}", number, statistics.open);
                prop_assert!(count == 0 || (f64::from(block.mean) - sum / f64::from(count)).abs() < 1e-2);
            }
        }

        /// Compares the totals of the closed blocks with all blocks in f64: a block forgotten or counted
        /// twice when they double in length would show.
        #[test]
        fn what_is_kept_is_what_the_blocks_say(
            samples in prop::collection::vec(-1e3_f32..1e3, 1..500),
            period_us in 1_000_u64..10_000_000,
        ) {
            let statistics = filled(samples.into_iter(), period_us);
            for (from, trend) in [(0, statistics.trend()), (statistics.open.div_ceil(2), statistics.later_trend())] {
                let points: Vec<(f64, f64)> = (from..=statistics.open)
                    .filter(|number| statistics.block(*number).count > 0)
                    .map(|number| (number as f64, f64::from(statistics.block(number).mean)))
                    .collect();
                let n = points.len() as f64;
                let mean = points.iter().map(|(_, y)| y).sum::<f64>() / n;
                let number = points.iter().map(|(x, _)| x).sum::<f64>() / n;
                let xx = points.iter().map(|(x, _)| (x - number).powi(2)).sum::<f64>();
                let slope = points.iter().map(|(x, y)| (x - number) * (y - mean)).sum::<f64>() / xx;
                let yy = points.iter().map(|(_, y)| (y - mean).powi(2)).sum::<f64>();
                if let (0, Some(summary)) = (from, statistics.summary().filter(|_| n > 1.0)) {
                    let variance = yy / (n - 1.0);
                    prop_assert!((f64::from(summary.block_variance) - variance).abs() <= 1e-4 * variance + 1e-6);
                }
                prop_assert_eq!(trend.is_some(), points.len() >= FEWEST_FOR_TREND);
                let Some(trend) = trend else { continue };
                let span = points[points.len() - 1].0 - points[0].0;
                let squares = points.iter().map(|(x, y)| (y - mean - slope * (x - number)).powi(2)).sum::<f64>();
                let variance = span * span * squares / (n - 2.0) / xx;
                // With a scatter `s`, f32 keeps the slope to about 1e-6 s.
                let scale = span * (yy / xx).sqrt();
                prop_assert!((f64::from(trend.drift) - slope * span).abs() <= 1e-4 * scale + 1e-6, "{trend:?}");
                prop_assert!((f64::from(trend.drift_variance) - variance).abs() <= 1e-3 * variance + 1e-6 * scale * scale);
            }
        }
    }
}
