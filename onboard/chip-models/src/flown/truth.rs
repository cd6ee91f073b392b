//! Converts a flight's values to the surroundings of the chips.

use kf_core::atmosphere::static_pressure_pa;
use kf_core::input::{BaroReading, GpsFix, ImuSample};

use crate::source::{Air, Motion};
use crate::ublox::Solution;

/// Temperature of a chip for which the flight has none, degrees Celsius: the one for which the datasheets
/// give their figures.
pub const ASSUMED_TEMPERATURE_C: f32 = 25.0;
/// Satellites of a fix without a count. A receiver's message cannot express "not known".
pub const ASSUMED_SATELLITES: u8 = 12;

/// Full scale of the MS5611 (datasheet: 10 to 1200 mbar, -40 to 85 degrees).
const PRESSURE_PA: core::ops::RangeInclusive<f32> = 1_000.0..=120_000.0;
const TEMPERATURE_C: core::ops::RangeInclusive<f32> = -40.0..=85.0;
/// Full scale of the ICM-42688-P as the board configures it: 16 g, 2000 degrees a second.
const FULL_SCALE_MPS2: f32 = 16.0 * kf_core::atmosphere::STANDARD_GRAVITY_MPS2;
const FULL_SCALE_RADPS: f32 = 2_000.0 * (core::f32::consts::PI / 180.0);
/// Range of the receiver's millimetres in 32 bits, metres and m/s.
const FULL_SCALE_M: f32 = 2_147_483.0;

/// Counts of a flight's values that could not go through the chips unchanged. All saturate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TruthCounts {
    /// Values that are NaN or infinite: no chip can be subject to them, and it keeps the last valid ones.
    pub not_finite: u32,
    /// Pressures and temperatures beyond the barometer's range. The chip saturates, and its driver reports
    /// that.
    pub baro_beyond_range: u32,
    /// Specific forces and rates beyond the inertial unit's range. The chip saturates, and its driver reports
    /// that.
    pub imu_beyond_range: u32,
    /// Altitudes and velocities beyond the range of the receiver's message.
    pub gps_beyond_range: u32,
    /// Barometer readings without a temperature before them: [`ASSUMED_TEMPERATURE_C`] was used.
    pub assumed_temperatures: u32,
    /// Fixes without a satellite count: [`ASSUMED_SATELLITES`] was used.
    pub assumed_satellites: u32,
    /// Fixes with only some of the three velocities: their velocity was treated as not known.
    pub partial_velocities: u32,
    /// Fixes that repeat the last one: a receiver sends a solution once.
    pub held_fixes: u32,
    /// Altitudes of the mother ship after launch, when the umbilical is open.
    pub after_launch: u32,
    /// Ticks whose time is earlier than the last one's, or later than any flight's: no time passes for the
    /// chips.
    pub impossible_times: u32,
    /// Faults that the chip cannot have.
    pub impossible_faults: u32,
}

pub(super) fn count(counter: &mut u32) {
    *counter = counter.saturating_add(1);
}

/// The air at the barometer after this reading; `None` if no air can have these values.
pub(super) fn air(reading: BaroReading, temperature_c: Option<f32>, counts: &mut TruthCounts) -> Option<Air> {
    let pressure_pa = match reading {
        BaroReading::PressurePa(pressure_pa) => pressure_pa,
        BaroReading::AltitudeM(altitude_m) => static_pressure_pa(altitude_m).unwrap_or(f32::NAN),
    };
    if !pressure_pa.is_finite() {
        count(&mut counts.not_finite);
        return None;
    }
    let temperature_c = temperature_c.unwrap_or_else(|| {
        count(&mut counts.assumed_temperatures);
        ASSUMED_TEMPERATURE_C
    });
    if !PRESSURE_PA.contains(&pressure_pa) || !TEMPERATURE_C.contains(&temperature_c) {
        count(&mut counts.baro_beyond_range);
    }
    Some(Air { pressure_pa, temperature_c })
}

/// The motion of the inertial unit with this sample; the chip's axes are the body's.
pub(super) fn motion(sample: &ImuSample, counts: &mut TruthCounts) -> Option<Motion> {
    let ImuSample { accel_mps2, gyro_radps } = *sample;
    if !accel_mps2.iter().chain(&gyro_radps).all(|value| value.is_finite()) {
        count(&mut counts.not_finite);
        return None;
    }
    let beyond = |values: &[f32; 3], full_scale: f32| values.iter().any(|value| value.abs() > full_scale);
    if beyond(&accel_mps2, FULL_SCALE_MPS2) || beyond(&gyro_radps, FULL_SCALE_RADPS) {
        count(&mut counts.imu_beyond_range);
    }
    Some(Motion { accel_mps2, gyro_radps, temperature_c: ASSUMED_TEMPERATURE_C })
}

/// The receiver's solution for this fix.
pub(super) fn solution(fix: &GpsFix, counts: &mut TruthCounts) -> Option<Solution> {
    let velocities = [fix.velocity_north_mps, fix.velocity_east_mps, fix.velocity_down_mps];
    let is_finite = |value: &f32| value.is_finite();
    let known = velocities.iter().flatten().copied();
    if !known.chain([fix.altitude_m]).chain(fix.vertical_accuracy_m).all(|value| is_finite(&value)) {
        count(&mut counts.not_finite);
        return None;
    }
    let velocity_ned_mps = match velocities {
        [Some(north), Some(east), Some(down)] => Some([north, east, down]),
        [None, None, None] => None,
        _ => {
            count(&mut counts.partial_velocities);
            None
        }
    };
    let satellites = fix.satellites.unwrap_or_else(|| {
        count(&mut counts.assumed_satellites);
        ASSUMED_SATELLITES
    });
    let velocity = velocity_ned_mps.unwrap_or_default();
    if velocity.iter().chain([&fix.altitude_m]).any(|value| value.abs() > FULL_SCALE_M) {
        count(&mut counts.gps_beyond_range);
    }
    Some(Solution {
        // The flight has one altitude, above its own datum; the driver is configured to use the second.
        ellipsoid_m: fix.altitude_m,
        mean_sea_level_m: fix.altitude_m,
        velocity_ned_mps: velocity,
        vertical_accuracy_m: fix.vertical_accuracy_m.unwrap_or(f32::INFINITY),
        // A flight has no accuracy of its velocities. A tenth of a metre a second is the order that
        // receivers' datasheets give.
        speed_accuracy_mps: if velocity_ned_mps.is_some() { 0.1 } else { f32::INFINITY },
        satellites,
        fix_type: 3,
    })
}
