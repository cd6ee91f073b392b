//! The climb rate after a first-order low pass.
//!
//! A lag is hardly ever a pure delay: a tube with a volume at its end, or a receiver that filters, is a low
//! pass, `y + tau y' = x`. Then `y = x - tau LP(x')`, exactly, with the same low pass LP: the coefficient is
//! still the lag in seconds, and the regressor is the smoothed climb rate. A pure delay d is `x - d` times
//! the mean climb rate of the last d seconds, which a low pass of about d/2 approximates. Without this, a
//! lag's misfit at sharp turns of the path is attributed to whatever effect happens to look like it.

/// Time constants of the low passes that lags are tried with, seconds. 0: as in the catalogue.
pub const SMOOTHINGS_S: [f32; 5] = [0.0, 0.5, 1.0, 2.0, 4.0];

/// The climb rate through each of the low passes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SmoothedClimb {
    last: Option<(u64, f64)>,
    smoothed_mps: [f64; SMOOTHINGS_S.len()],
}

impl SmoothedClimb {
    /// Adds the climb rate (m/s) at a time (microseconds) later than the last; in between it is assumed to be
    /// linear.
    pub fn take(&mut self, time_us: u64, climb_mps: f64) {
        let Some((last_us, before_mps)) = self.last else {
            self.last = Some((time_us, climb_mps));
            self.smoothed_mps = [climb_mps; SMOOTHINGS_S.len()];
            return;
        };
        let elapsed_s = time_us.saturating_sub(last_us) as f64 * 1e-6;
        if elapsed_s <= 0.0 {
            return;
        }
        let slope = (climb_mps - before_mps) / elapsed_s;
        for (smoothed, time_s) in self.smoothed_mps.iter_mut().zip(SMOOTHINGS_S.map(f64::from)) {
            // After a low pass a ramp is late by the time constant; the earlier error decays.
            let keep = if time_s > 0.0 { libm::exp(-elapsed_s / time_s) } else { 0.0 };
            *smoothed = climb_mps - slope * time_s + keep * (*smoothed - before_mps + slope * time_s);
        }
        self.last = Some((time_us, climb_mps));
    }

    /// The climb rate through the low pass of this time constant, m/s; `None` for one that is not tried, or
    /// before the first sample.
    pub fn mps(&self, smoothing_s: f32) -> Option<f64> {
        self.last?;
        let at = SMOOTHINGS_S.iter().position(|time_s| *time_s == smoothing_s)?;
        self.smoothed_mps.get(at).copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// With this low pass, the altitude itself is in closed form the steady response to its ramp and sine.
    #[test]
    fn a_smoothed_climb_rate_makes_a_low_passed_altitude() {
        let rate = 0.7_f64;
        for smoothing_s in SMOOTHINGS_S {
            let tau = f64::from(smoothing_s);
            let mut climb = SmoothedClimb::default();
            for k in 0..6000_u32 {
                let t = f64::from(k) * 0.01;
                climb.take((t * 1e6).round() as u64, 3.0 + rate * (rate * t).cos());
                // y = LP(3 t + sin(rate t)) once the start is forgotten.
                let gain = 1.0 / (1.0 + (rate * tau).powi(2));
                let low_passed = 3.0 * (t - tau) + gain * ((rate * t).sin() - rate * tau * (rate * t).cos());
                let made = 3.0 * t + (rate * t).sin() - tau * climb.mps(smoothing_s).unwrap();
                if t > 50.0 {
                    assert!((made - low_passed).abs() < 1e-4, "{smoothing_s} s at {t}: {made} {low_passed}");
                }
            }
        }
    }
}
