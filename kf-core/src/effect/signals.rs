//! The latest signals, and the regressors made of them.

use super::{EffectId, dynamic_pressure_head_m};
use crate::input::{GpsFix, Signals};

/// Latest values of what the regressors are made of. Non-finite values are not taken.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SignalHolder {
    true_airspeed_mps: Option<f32>,
    ground_speed_squared_m2ps2: Option<f32>,
    /// How many signal values were refused because they were not finite.
    refused: u32,
}

impl SignalHolder {
    /// Takes this tick's signals.
    pub fn take(&mut self, signals: &Signals) {
        match signals.true_airspeed_mps {
            Some(speed) if speed.is_finite() => self.true_airspeed_mps = Some(speed),
            Some(_) => self.refused = self.refused.saturating_add(1),
            None => {}
        }
    }

    /// Takes an accepted fix: its speed stands in for the airspeed of a flight that measures none.
    pub fn take_fix(&mut self, fix: &GpsFix) {
        if let (Some(north), Some(east)) = (fix.velocity_north_mps, fix.velocity_east_mps) {
            let down = fix.velocity_down_mps.unwrap_or(0.0);
            self.ground_speed_squared_m2ps2 = Some(north * north + east * east + down * down);
        }
    }

    /// Square of the true airspeed, (m/s)^2, or of the speed over ground where no airspeed has ever
    /// been measured.
    #[must_use]
    pub fn airspeed_squared_m2ps2(&self) -> Option<f32> {
        self.true_airspeed_mps.map(|speed| speed * speed).or(self.ground_speed_squared_m2ps2)
    }

    /// How many signal values were refused because they were not finite.
    #[must_use]
    pub const fn refused(&self) -> u32 {
        self.refused
    }

    /// The regressor of an effect now, metres per unit of its coefficient; `None` while a signal
    /// that it needs has not been seen.
    #[must_use]
    pub fn regressor_m(&self, effect: EffectId) -> Option<f32> {
        match effect {
            EffectId::BaroDynamicPressure => self.airspeed_squared_m2ps2().map(dynamic_pressure_head_m),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ground_speed_stands_in_until_an_airspeed_is_measured() {
        let mut holder = SignalHolder::default();
        assert_eq!(holder.regressor_m(EffectId::BaroDynamicPressure), None);
        holder.take_fix(&GpsFix {
            velocity_north_mps: Some(3.0),
            velocity_east_mps: Some(4.0),
            velocity_down_mps: Some(12.0),
            ..GpsFix::default()
        });
        assert_eq!(holder.airspeed_squared_m2ps2(), Some(169.0));
        holder.take(&Signals { true_airspeed_mps: Some(100.0), ..Signals::default() });
        // 100 m/s: 10^4 / (2 * 9.80665) = 509.86 m.
        let head = holder.regressor_m(EffectId::BaroDynamicPressure).unwrap();
        assert!((head - 509.858).abs() < 1e-3, "{head}");
        holder.take(&Signals { true_airspeed_mps: Some(f32::NAN), ..Signals::default() });
        assert_eq!((holder.airspeed_squared_m2ps2(), holder.refused()), (Some(10_000.0), 1));
    }
}
