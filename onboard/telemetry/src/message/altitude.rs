//! ALTITUDE (141).

use mavlink::dialects::common::ALTITUDE_DATA;

/// Terrain altitude below -1000 m, which means "unknown" in the message.
const UNKNOWN_TERRAIN_M: f32 = -10_000.0;
/// A negative clearance, which means "no measurement".
const NO_CLEARANCE_M: f32 = -1.0;

/// Altitudes, metres.
///
/// | field | is |
/// |---|---|
/// | `altitude_monotonic` | the barometer as it reads (ISA pressure altitude), not corrected by anything; NaN before the first reading |
/// | `altitude_amsl` | the reference: the filter's in captive flight, the last fix's after launch; NaN without one |
/// | `altitude_local`, `altitude_relative` | NaN: there is no home |
/// | `altitude_terrain`, `bottom_clearance` | unknown (-10000 and -1, as the message defines) |
#[must_use]
pub fn altitude(time_us: u64, baro_m: Option<f32>, reference_m: Option<f32>) -> ALTITUDE_DATA {
    ALTITUDE_DATA {
        time_usec: time_us,
        altitude_monotonic: baro_m.unwrap_or(f32::NAN),
        altitude_amsl: reference_m.unwrap_or(f32::NAN),
        altitude_local: f32::NAN,
        altitude_relative: f32::NAN,
        altitude_terrain: UNKNOWN_TERRAIN_M,
        bottom_clearance: NO_CLEARANCE_M,
    }
}
