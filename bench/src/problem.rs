//! The paper's calibration problem, on which every filter is measured.

/// Initial state: altitude, biases of the mother ship's IMU, the UAV's IMU and the barometer, m.
pub const STATE: [f32; 4] = [2100.0, 0.0, 0.0, 0.0];
/// Sigmas of the initial state, m.
pub const PRIOR_SIGMAS: [f32; 4] = [50.0, 100.0, 150.0, 300.0];
/// Diagonal of the initial covariance, m^2.
pub const COVARIANCE: [f32; 4] = squares(PRIOR_SIGMAS);
/// Sigmas of the measurements, m.
pub const NOISE_SIGMAS: [f32; 4] = [25.0, 50.0, 70.0, 150.0];
/// Diagonal of the measurement covariance, m^2.
pub const NOISE: [f32; 4] = squares(NOISE_SIGMAS);
/// The state that each measurement observes.
pub const OBSERVATION: [[f32; 4]; 4] =
    [[1.0, 0.0, 0.0, 0.0], [1.0, 1.0, 0.0, 0.0], [1.0, 0.0, 1.0, 0.0], [1.0, 0.0, 0.0, 1.0]];

const fn squares([a, b, c, d]: [f32; 4]) -> [f32; 4] {
    [a * a, b * b, c * c, d * d]
}

/// A filter on that problem. `A = I` and `Q = 0`, so no filter has to propagate its state. This favours the
/// filters that would have multiplied by the identity.
pub trait Filter {
    /// Processes the time, microseconds, and the four measurements of one tick, metres.
    fn tick(&mut self, time_us: u64, measurements: &[f32; 4]);
    /// The state in the order of [`STATE`], metres.
    fn state(&self) -> [f32; 4];
    /// The diagonal of its covariance, m^2.
    fn variances(&self) -> [f32; 4];
}

/// Measurements of a trimmed flight at 2050 m with the paper's biases and white noise of the paper's sigmas;
/// the same ones in every run.
pub struct Measurements(u32);

impl Measurements {
    /// The sequence, from its start.
    pub const fn new() -> Self {
        Self(20_130_415)
    }

    /// A uniform number of zero mean and unit variance (Numerical Recipes' 32-bit generator).
    fn white(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let uniform = (self.0 >> 8) as f32 / 16_777_216.0;
        (uniform - 0.5) * 3.464_101_6
    }

    /// The next tick's measurements.
    pub fn next_tick(&mut self) -> [f32; 4] {
        [
            2050.0 + NOISE_SIGMAS[0] * self.white(),
            2050.0 + 12.0 + NOISE_SIGMAS[1] * self.white(),
            2050.0 - 72.8909 + NOISE_SIGMAS[2] * self.white(),
            2050.0 - 121.8691 + NOISE_SIGMAS[3] * self.white(),
        ]
    }
}
