//! Effect of a monitor's rule on healthy sensors in the first window after launch, before the window is full.

use super::ResidualModel;
use super::draw_set::DrawSet;
use super::monitor_rule::samples_of;

/// Number of drawn launches, and the largest number of readings in each.
pub(super) const FIRST_DRAWS: u64 = 512;
const FIRST_SAMPLES: u64 = 1_000;
/// Healthy launches of a residual, drawn once for all the rules that are examined.
#[derive(Clone, Debug)]
pub struct HealthyLaunches<'a> {
    model: &'a ResidualModel,
    draws: DrawSet,
    /// Window lengths in samples, ascending.
    windows: Vec<u64>,
    /// For each window and launch, the result of [`first_window_barriers`].
    barriers: Vec<Vec<f64>>,
}

impl<'a> HealthyLaunches<'a> {
    /// Draws launches for windows of these lengths, seconds.
    #[must_use]
    pub fn draw(model: &'a ResidualModel, windows_s: &[f64]) -> Self {
        Self::draw_set(model, windows_s, DrawSet::default())
    }

    /// As [`Self::draw`], with this set of random numbers.
    pub(super) fn draw_set(model: &'a ResidualModel, windows_s: &[f64], draws: DrawSet) -> Self {
        let mut windows: Vec<u64> = windows_s.iter().map(|window_s| samples_of(model, *window_s)).collect();
        windows.sort_unstable();
        windows.dedup();
        let barriers = first_window_barriers(model, &windows, draws);
        Self { model, draws, windows, barriers }
    }

    /// The residual.
    pub(super) const fn model(&self) -> &'a ResidualModel {
        self.model
    }

    /// The random numbers, which are also used to assess rules of this residual.
    pub(super) const fn draws(&self) -> DrawSet {
        self.draws
    }

    /// The thresholds of that window, one a launch.
    pub(super) fn barriers(&self, window: u64) -> Vec<f64> {
        match self.windows.binary_search(&window) {
            Ok(index) => self.barriers.get(index).cloned().unwrap_or_default(),
            Err(_) => first_window_barriers(self.model, &[window], self.draws).concat(),
        }
    }

    /// Share of healthy launches in which the sensor becomes untrustworthy before the window is full.
    pub(super) fn alarms(&self, threshold_m: f64, window: u64) -> f64 {
        let barriers = self.barriers(window);
        let alarms = barriers.iter().filter(|barrier| **barrier > threshold_m).count();
        alarms as f64 / FIRST_DRAWS as f64
    }
}

/// For each window (in ascending order), and each of [`FIRST_DRAWS`] healthy launches, the threshold below
/// which the sensor would be called untrustworthy before the window is full.
///
/// From the first reading on, that takes a reading beyond the threshold, followed by an average beyond it, in
/// which the part of the window without readings counts as no error (`kf_core::monitor`). The barrier is
/// therefore the largest of min(largest reading before, sum so far over the whole window). Only the first
/// [`FIRST_SAMPLES`] readings are drawn: averages over more are part of the steady rate.
fn first_window_barriers(model: &ResidualModel, windows: &[u64], draws: DrawSet) -> Vec<Vec<f64>> {
    let mut barriers: Vec<Vec<f64>> = vec![Vec::new(); windows.len()];
    let longest = windows.last().copied().unwrap_or(0).min(FIRST_SAMPLES);
    for launch in 0..FIRST_DRAWS {
        let (mut sum, mut largest) = (0.0, 0.0_f64);
        barriers.iter_mut().for_each(|slot| slot.push(0.0));
        for (index, error) in model.simulate(1, draws.seed(launch)).take(longest as usize).enumerate() {
            sum += error;
            let filling = windows.iter().zip(&mut barriers).filter(|(window, _)| index < **window as usize);
            for (window, slot) in filling {
                if let Some(barrier) = slot.last_mut() {
                    *barrier = barrier.max(largest.min(f64::abs(sum) / *window as f64));
                }
            }
            largest = largest.max(error.abs());
        }
    }
    barriers
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Component;

    #[test]
    fn launches_drawn_together_are_those_drawn_alone() {
        let model = ResidualModel {
            sample_interval_s: 0.02,
            white_variance_m2: 4.0,
            components: vec![Component { time_s: 1.0, variance_m2: 1.0 }],
            longest_lag_s: 20.0,
        };
        let together = HealthyLaunches::draw(&model, &[0.1, 2.0, 0.5]);
        for window in [5, 25, 100] {
            assert!(together.windows.contains(&window));
            assert_eq!(together.barriers(window), HealthyLaunches::draw(&model, &[]).barriers(window));
        }
    }
}
