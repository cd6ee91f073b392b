//! Causes that are not in the catalogue.

use pylon::simulate::TruthSample;

/// A cause outside the catalogue. All but the last act on the barometer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outside {
    /// The sensor's elastic hysteresis: a play of 30 m on the altitude.
    Hysteresis,
    /// The square of the bank angle: a port in the fuselage's wake.
    Bank,
    /// The sine of the heading: a field of the vehicle's magnetism, or the sun.
    Heading,
    /// A lasting step halfway through: a detached hose.
    Step,
    /// The pitch rate: a hose along the fuselage.
    PitchRate,
    /// The square of the roll rate.
    RollRate,
    /// A sine with a period of a minute, unrelated to any recorded signal.
    Oscillation,
    /// On the inertial altitude: the roll angle, integrated.
    Roll,
}

impl Outside {
    /// All causes.
    pub const ALL: [Self; 8] = [
        Self::Hysteresis,
        Self::Bank,
        Self::Heading,
        Self::Step,
        Self::PitchRate,
        Self::RollRate,
        Self::Oscillation,
        Self::Roll,
    ];

    /// Whether it acts on the inertial altitude.
    #[must_use]
    pub const fn is_inertial(self) -> bool {
        matches!(self, Self::Roll)
    }

    /// Its shape at every row; zero in captive flight.
    #[must_use]
    pub fn shape(self, flight: &[TruthSample]) -> Vec<f64> {
        let launch = flight.iter().position(|sample| !sample.captive).unwrap_or(flight.len());
        let mut shape = vec![0.0; flight.len()];
        let Some(first) = flight.get(launch) else { return shape };
        let middle = launch + (flight.len() - launch) / 2;
        let mut centre = first.altitude_m;
        let mut integral = 0.0;
        for (row, sample) in flight.iter().enumerate().skip(launch) {
            let [roll, _, yaw] = sample.euler_rad;
            shape[row] = match self {
                Self::Hysteresis => {
                    centre = centre.max(sample.altitude_m - 30.0).min(sample.altitude_m + 30.0);
                    (centre - sample.altitude_m) / 30.0
                }
                Self::Bank => roll * roll,
                Self::Heading => yaw.sin() - first.euler_rad[2].sin(),
                Self::Step => f64::from(u8::from(row > middle)),
                Self::PitchRate => sample.rate_radps[1],
                Self::RollRate => sample.rate_radps[0] * sample.rate_radps[0],
                Self::Oscillation => ((sample.time_s - first.time_s) / 60.0 * std::f64::consts::TAU).sin(),
                Self::Roll => {
                    integral += roll * 0.005;
                    integral
                }
            };
        }
        shape
    }
}
