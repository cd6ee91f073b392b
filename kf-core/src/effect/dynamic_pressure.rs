//! `baro.dynamic_pressure`: the head of the dynamic pressure.

use crate::atmosphere::STANDARD_GRAVITY_MPS2;

/// `V^2 / (2 g)` in metres: the altitude error of a port that reads the whole dynamic pressure.
///
/// From `dp = rho V^2 / 2` and the hydrostatic `dh = dp / (rho g)`; the density cancels.
#[must_use]
pub fn dynamic_pressure_head_m(airspeed_squared_m2ps2: f32) -> f32 {
    airspeed_squared_m2ps2 * (0.5 / STANDARD_GRAVITY_MPS2)
}
