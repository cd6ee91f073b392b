//! Recursive least squares of a polynomial in time: all samples have equal weight until a window is full;
//! from then on older ones fade (P. Zarchan and H. Musoff, "Fundamentals of Kalman Filtering", 3rd edition,
//! AIAA 2009, sections 3.3 and 3.4; N. Morrison, "Introduction to Sequential Smoothing and Prediction",
//! McGraw-Hill 1969).

/// Number of samples that the next gains represent.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Memory {
    samples: u32,
    elapsed_s: f32,
}

impl Memory {
    /// Counts a sample `step_s` after the last one.
    pub(super) fn count(&mut self, step_s: f32, window_s: f32) {
        if self.samples == 0 || self.elapsed_s < window_s {
            self.elapsed_s += if self.samples == 0 { 0.0 } else { step_s };
            self.samples = self.samples.saturating_add(1);
        }
    }

    /// Time that the samples cover, seconds; at most the window.
    pub(super) const fn elapsed_s(self) -> f32 {
        self.elapsed_s
    }

    pub(super) const fn is_empty(self) -> bool {
        self.samples == 0
    }

    fn n(self) -> f32 {
        self.samples.max(1) as f32
    }

    /// Gain of a mean.
    pub(super) fn mean_gain(self) -> f32 {
        1.0 / self.n()
    }

    /// Gains of a straight line: value, slope (1/s). Per mean step of the window: two samples that are close
    /// together give no information about a slope.
    pub(super) fn line_gains(self, step_s: f32) -> [f32; 2] {
        let n = self.n();
        let step_s = if self.samples > 1 { self.elapsed_s / (n - 1.0) } else { step_s };
        let scale = n * (n + 1.0);
        [2.0 * (2.0 * n - 1.0) / scale, 6.0 / (scale * step_s)]
    }

    /// Gains of a parabola: value, slope (1/s), second derivative (1/s^2).
    pub(super) fn parabola_gains(self, step_s: f32) -> [f32; 3] {
        let n = self.n();
        let scale = n * (n + 1.0) * (n + 2.0);
        [
            3.0 * (3.0 * n * n - 3.0 * n + 2.0) / scale,
            18.0 * (2.0 * n - 1.0) / (scale * step_s),
            60.0 / (scale * step_s * step_s),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Runs the recursion over samples of a parabola; the state is (value, slope, curvature) at the last
    /// sample.
    fn fit(samples: &[f64], step_s: f64) -> [f64; 3] {
        let mut memory = Memory::default();
        let mut state = [0f64; 3];
        for &sample in samples {
            memory.count(step_s as f32, f32::MAX);
            state[0] += step_s * state[1] + 0.5 * step_s * step_s * state[2];
            state[1] += step_s * state[2];
            let residual = sample - state[0];
            for (part, gain) in state.iter_mut().zip(memory.parabola_gains(step_s as f32)) {
                *part += f64::from(gain) * residual;
            }
        }
        state
    }

    #[test]
    fn a_parabola_is_found_exactly() {
        let step_s = 0.1;
        let at = |k: i32| {
            let t = f64::from(k) * step_s;
            3.0 - 2.0 * t + 0.25 * t * t
        };
        let samples: Vec<_> = (0..200).map(at).collect();
        let t = 199.0 * step_s;
        for (found, wanted) in fit(&samples, step_s).into_iter().zip([at(199), -2.0 + 0.5 * t, 0.5]) {
            assert!((found - wanted).abs() < 1e-4 * wanted.abs().max(1.0), "{found} {wanted}");
        }
    }

    /// A parabola through three points or fewer passes through the last of them, whatever they are.
    #[test]
    fn the_first_three_samples_are_met() {
        let samples = [3.0, -1.0, 7.0];
        for count in 1..=samples.len() {
            let [value, ..] = fit(&samples[..count], 0.1);
            assert!((value - samples[count - 1]).abs() < 1e-5, "{count}: {value}");
        }
    }

    /// Otherwise it is the least-squares parabola: the residuals are orthogonal to 1, t and t^2.
    #[test]
    fn the_fit_is_least_squares() {
        let step_s = 0.1;
        let samples: Vec<f64> =
            (0..300).map(|k| (f64::from(k) * 0.7).sin() + (f64::from(k * k % 17) - 8.0) * 0.1).collect();
        let [value, slope, curvature] = fit(&samples, step_s);
        let last = (samples.len() - 1) as f64 * step_s;
        for power in 0..3 {
            let (mut product, mut size) = (0.0, 0.0);
            for (k, sample) in samples.iter().enumerate() {
                let t = k as f64 * step_s - last;
                let residual = sample - (value + slope * t + 0.5 * curvature * t * t);
                product += residual * t.powi(power);
                size += (residual * t.powi(power)).abs();
            }
            // f32 gains: 1e-6 of the sum's size, accumulated.
            assert!(product.abs() < 2e-4 * size, "power {power}: {product} of {size}");
        }
    }

    #[test]
    fn a_full_window_grows_no_more() {
        let mut memory = Memory::default();
        for _ in 0..1_000 {
            memory.count(0.1, 20.0);
        }
        assert!((memory.elapsed_s() - 20.0).abs() < 0.11 && memory.samples.abs_diff(201) <= 1, "{memory:?}");
    }
}
