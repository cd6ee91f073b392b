//! State of a channel in free flight that is kept over a restart of the flight computer.

use serde::{Deserialize, Serialize};

use super::sum::Sum;
use super::tie::Tie;
use super::vector::{Down, Vector};
use super::{Last, Phase, VerticalChannel};

/// A channel in free flight, or held for a suspected launch: everything that its next sample needs. Body
/// axes, SI units.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct KeptChannel {
    time_us: u64,
    force: Vector,
    rate: Vector,
    acceleration_mps2: f32,
    down: Vector,
    gyro_bias: Vector,
    accel_bias: Vector,
    altitude: Sum,
    climb_rate: Sum,
    tie: Tie,
    tie_time_us: u64,
    bridged_m2ps2: f32,
    is_mending: bool,
}

impl KeptChannel {
    /// Whether every number is finite; a damaged copy passes its checksum once in four billion times.
    fn is_finite(&self) -> bool {
        let vectors = [self.force, self.rate, self.down, self.gyro_bias, self.accel_bias];
        let sums = [self.altitude.value(), self.climb_rate.value()];
        vectors.iter().flatten().chain(&sums).all(|number| number.is_finite())
            && self.acceleration_mps2.is_finite()
            && self.bridged_m2ps2.is_finite()
            && self.tie.altitude_m2().is_finite()
            && self.tie.climb_m2ps2().is_finite()
    }
}

impl VerticalChannel {
    /// State to be stored: `None` in captive flight, where a restart begins again, and if there is no
    /// altitude.
    #[must_use]
    pub fn kept(&self) -> Option<KeptChannel> {
        let Phase::Free { accel_bias, aligned: true } = self.phase else { return None };
        let (last, down) = (self.last?, self.down?);
        Some(KeptChannel {
            time_us: last.time_us,
            force: last.force,
            rate: last.rate,
            acceleration_mps2: last.acceleration_mps2,
            down: down.get(),
            gyro_bias: self.gyro_bias_radps(),
            accel_bias,
            altitude: self.altitude,
            climb_rate: self.climb_rate,
            tie: self.tie,
            tie_time_us: self.tie_time_us,
            bridged_m2ps2: self.bridged_m2ps2,
            is_mending: self.is_mending,
        })
    }

    /// Continues from a stored channel, before the first sample. `unknown_s`: how much longer than the clock
    /// shows the gap until the next sample may be, seconds. False, and nothing changes, if a number is not
    /// finite.
    #[must_use]
    pub fn resume(&mut self, kept: &KeptChannel, unknown_s: f32) -> bool {
        if !kept.is_finite() {
            return false;
        }
        self.phase = Phase::Free { accel_bias: kept.accel_bias, aligned: true };
        self.down = Some(Down::from_unit(kept.down));
        self.levelling.gyro_bias = kept.gyro_bias.map(Sum::new);
        self.last = Some(Last {
            time_us: kept.time_us,
            force: kept.force,
            rate: kept.rate,
            acceleration_mps2: kept.acceleration_mps2,
        });
        self.altitude = kept.altitude;
        self.climb_rate = kept.climb_rate;
        self.tie = kept.tie;
        self.tie_time_us = kept.tie_time_us;
        self.bridged_m2ps2 = kept.bridged_m2ps2;
        self.is_mending = kept.is_mending;
        // If the next sample leaves no gap, nothing else requests a climb rate before an altitude ends the
        // mending.
        self.climb_fix_us = kept.is_mending.then_some(kept.tie_time_us);
        self.is_resumed = true;
        self.unknown_s = unknown_s;
        true
    }
}
