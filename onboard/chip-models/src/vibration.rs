//! A vibration of the airframe as an inertial unit samples it: after the chip's filter, and only at the
//! chip's samples.

use kf_core::trigonometry::sine_and_cosine;

/// A sinusoid on one channel of an inertial unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vibration {
    /// Channel: specific force and then rate, in the order of the axes.
    pub channel: usize,
    /// Frequency, millihertz.
    pub frequency_mhz: u32,
    /// Amplitude before the filter, in the channel's unit (m/s^2, rad/s).
    pub amplitude: f32,
}

/// A low pass described by its amplitude: order and -3 dB frequency of a Butterworth filter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LowPass {
    /// Order.
    pub order: u8,
    /// -3 dB frequency, Hz.
    pub bandwidth_hz: f32,
}

impl LowPass {
    /// Fraction of a sinusoid's amplitude that it passes.
    #[must_use]
    pub fn gain(self, frequency_hz: f32) -> f32 {
        let ratio = frequency_hz / self.bandwidth_hz;
        let power = (0..self.order).fold(1.0, |power, _| power * ratio * ratio);
        1.0 / libm::sqrtf(1.0 + power)
    }
}

impl Vibration {
    /// The filtered vibration at a time, microseconds. The filter's delay only shifts its phase, and is left
    /// out.
    #[must_use]
    pub fn at(self, time_us: u64, filter: LowPass) -> f32 {
        // Billionths of a turn. Whole turns are removed, so that the phase is as exact an hour later.
        let turns = (u128::from(time_us) * u128::from(self.frequency_mhz)) % 1_000_000_000;
        let turn = turns as f32 * 1e-9;
        // Within half a turn of zero, where the sine is most exact.
        let angle = (if turn > 0.5 { turn - 1.0 } else { turn }) * core::f32::consts::TAU;
        let (sine, _) = sine_and_cosine(angle).unwrap_or_default();
        self.amplitude * filter.gain(self.frequency_mhz as f32 * 1e-3) * sine
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const OPEN: LowPass = LowPass { order: 1, bandwidth_hz: 1e9 };

    #[test]
    fn a_filter_has_its_order_and_its_bandwidth() {
        for order in 1..=3u8 {
            let filter = LowPass { order, bandwidth_hz: 25.0 };
            assert!((filter.gain(25.0) - 0.5f32.sqrt()).abs() < 1e-6);
            // Each order falls by 6 dB an octave.
            let octave = filter.gain(800.0) / filter.gain(1_600.0);
            assert!((octave - f32::from(1u16 << order)).abs() < 0.01, "{octave}");
        }
    }

    #[test]
    fn a_vibration_keeps_its_phase_for_hours() {
        let vibration = Vibration { channel: 0, frequency_mhz: 200_250, amplitude: 2.0 };
        // Each second ends a quarter of a turn later.
        for hours in [0u64, 1, 10] {
            let at = |us: u64| vibration.at(hours * 3_600_000_000 + us, OPEN);
            assert!((at(1_000_000) - 2.0).abs() < 1e-5, "{}", at(1_000_000));
            assert!(at(2_000_000).abs() < 1e-5);
            assert!((at(3_000_000) + 2.0).abs() < 1e-5);
        }
    }
}
