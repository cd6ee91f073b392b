//! The force's character: whether its mean on any axis, or how rough it is, has changed since the suspicion
//! of a launch began.
//!
//! A vehicle that leaves loses the mother ship's lift, drag and vibration, and starts an engine. Even if its
//! wings carry it, so that there is no step, the force has another character from then on. A tear of the
//! cable changes none of it.
//!
//! Blocks of a quarter of a second are compared with those of captive flight. The block in progress and the
//! one before are left out when a suspicion begins: the hooks open up to a quarter of a second before the
//! wire does.

/// Length of a block, microseconds.
const BLOCK_US: u64 = 250_000;
/// Fewer samples make no block: of 50 at 200 Hz a loaded bus may lose some; a receiver's rate is not enough.
const LEAST_SAMPLES: u16 = 10;
/// Captive blocks in the mean and the variance: 10 s, some tens of gusts.
const MEMORY_BLOCKS: u16 = 40;
/// Captive blocks needed for a comparison: 5 s.
const LEAST_BLOCKS: u16 = 20;
/// Standard deviations, squared, by which a block differs. Two in a row must: in Gaussian noise of 40
/// remembered blocks, where the deviation itself is known to 11 %, one of the four figures does so by chance
/// in some 1e-7 of the blocks, and a gust that fills two blocks in some 1e-5.
const SIGMAS_SQUARED: f32 = 36.0;
/// Least standard deviation of a mean, m/s^2: flexing of the mounting. In still air a step of 0.06 g shows.
const FLOOR_MPS2: f32 = 0.1;
/// The same of the roughness, as a share of the smaller of the two: a change by a factor of 2.5 shows.
const FLOOR_ROUGHNESS: f32 = 0.25;
/// Blocks in a row that differ.
const IN_A_ROW: u8 = 2;
/// Differing captive blocks in a row that are a new regime of flight. Fewer are a flipped bit or a bump:
/// they must not widen the spread that changes are compared with for ten seconds.
const NEW_REGIME: u8 = 3;
/// The last block of a living unit ended no longer ago than this, microseconds: a block and a lost one.
const LIVING_US: u64 = 600_000;

/// Three means and the roughness (mean square of the step from sample to sample, all axes).
pub(super) type Figures = [f32; 4];

#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Character {
    began_us: u64,
    samples: u16,
    last: Option<[f32; 3]>,
    sums: Figures,
    /// A captive block that the next one confirms.
    pending: Option<Figures>,
    blocks: u16,
    mean: Figures,
    variance: Figures,
    was_captive: bool,
    differing: u8,
    /// Captive blocks in a row that differ from those before.
    odd: u8,
    /// When the last block of a living unit ended.
    living_us: Option<u64>,
    /// The unit has been silent or wrong since the suspicion began: it may have missed a passing change.
    was_blind: bool,
}

impl Character {
    /// A valid sample.
    pub(super) fn take(&mut self, now_us: u64, force_mps2: [f32; 3], is_captive: bool) {
        if is_captive != self.was_captive {
            self.was_captive = is_captive;
            self.differing = 0;
            self.pending = None;
            self.was_blind = !is_captive && !self.lives(now_us);
            self.begin(now_us);
        }
        if let Some(last) = self.last.replace(force_mps2) {
            let [means @ .., roughness] = &mut self.sums;
            for ((force_mps2, last_mps2), sum) in force_mps2.into_iter().zip(last).zip(means) {
                let step_mps2 = force_mps2 - last_mps2;
                *sum += force_mps2;
                *roughness += step_mps2 * step_mps2;
            }
            self.samples = self.samples.saturating_add(1);
        }
        if now_us.saturating_sub(self.began_us) >= BLOCK_US {
            self.end_block(now_us, is_captive);
            self.begin(now_us);
        }
    }

    /// What captive flight is like: means and variances.
    pub(super) const fn captive(&self) -> (Figures, Figures) {
        (self.mean, self.variance)
    }

    /// Continues after a restart with the captive flight from before it.
    pub(super) const fn resume(&mut self, mean: Figures, variance: Figures) {
        self.mean = mean;
        self.variance = variance;
        self.blocks = LEAST_BLOCKS;
    }

    /// At a start: a unit that has lived before counts as living until a block and a lost one have passed.
    pub(super) const fn assume_living(&mut self, now_us: u64) {
        self.living_us = Some(now_us);
    }

    fn begin(&mut self, now_us: u64) {
        self.began_us = now_us;
        self.samples = 0;
        self.sums = [0.0; 4];
    }

    #[inline(never)]
    fn end_block(&mut self, now_us: u64, is_captive: bool) {
        // Samples that never change are a unit that has stopped: its own noise is above its resolution.
        if self.samples < LEAST_SAMPLES || self.sums[3] <= 0.0 {
            self.differing = 0;
            return;
        }
        let share = 1.0 / f32::from(self.samples);
        let figures = self.sums.map(|sum| sum * share);
        self.was_blind |= !is_captive && !self.lives(now_us);
        self.living_us = Some(now_us);
        if !is_captive {
            let differs = self.blocks >= LEAST_BLOCKS && self.differs(&figures);
            self.differing = if differs { self.differing.saturating_add(1) } else { 0 };
            return;
        }
        let Some(figures) = self.pending.replace(figures) else { return };
        if self.blocks >= LEAST_BLOCKS && self.differs(&figures) {
            self.odd = self.odd.saturating_add(1);
            if self.odd < NEW_REGIME {
                return;
            }
        } else {
            self.odd = 0;
        }
        self.blocks = (self.blocks + 1).min(MEMORY_BLOCKS);
        let gain = 1.0 / f32::from(self.blocks);
        for ((figure, mean), variance) in figures.into_iter().zip(&mut self.mean).zip(&mut self.variance) {
            let apart = figure - *mean;
            *mean += gain * apart;
            *variance += gain * ((1.0 - gain) * apart * apart - *variance);
        }
    }

    fn differs(&self, figures: &Figures) -> bool {
        let mut differs = false;
        for (k, ((figure, mean), variance)) in figures.iter().zip(&self.mean).zip(&self.variance).enumerate()
        {
            let floor = if k < 3 { FLOOR_MPS2 } else { FLOOR_ROUGHNESS * figure.min(*mean) };
            let apart = figure - mean;
            differs |= apart * apart > SIGMAS_SQUARED * (variance + floor * floor);
        }
        differs
    }

    /// Disregards the blocks so far: they show a fault of the unit.
    pub(super) const fn disregard_changes(&mut self) {
        self.differing = 0;
    }

    /// A fault of the unit may have hidden a passing change in this suspicion.
    pub(super) const fn call_blind(&mut self) {
        self.was_blind = true;
    }

    /// Whether it has changed since the suspicion began.
    pub(super) const fn has_changed(&self) -> bool {
        self.differing >= IN_A_ROW
    }

    /// Whether enough captive flight is known for a comparison.
    pub(super) const fn is_comparable(&self) -> bool {
        self.blocks >= LEAST_BLOCKS
    }

    /// Whether a change would have been seen: captive flight is known, and [`Self::is_living`].
    pub(super) fn is_known(&self, now_us: u64) -> bool {
        self.is_comparable() && self.is_living(now_us)
    }

    /// Whether the unit delivers, and has done so since a block before the suspicion began. That is the
    /// longest time that the cable's slack takes, so it would have felt the hooks open.
    pub(super) fn is_living(&self, now_us: u64) -> bool {
        !self.was_blind && self.lives(now_us)
    }

    /// Whether the unit delivers now.
    pub(super) fn lives(&self, now_us: u64) -> bool {
        self.living_us.is_some_and(|living_us| now_us.saturating_sub(living_us) <= LIVING_US)
    }
}
