//! ATTITUDE (30).

use mavlink::dialects::common::ATTITUDE_DATA;

/// Roll, pitch, yaw (rad) of the vehicle's attitude equipment, and the body rates (rad/s) of the inertial
/// sample of the same tick; NaN without one.
#[must_use]
pub fn attitude(time_ms: u32, attitude_rad: [f32; 3], rates_radps: Option<[f32; 3]>) -> ATTITUDE_DATA {
    let [roll, pitch, yaw] = attitude_rad;
    let [rollspeed, pitchspeed, yawspeed] = rates_radps.unwrap_or([f32::NAN; 3]);
    ATTITUDE_DATA { time_boot_ms: time_ms, roll, pitch, yaw, rollspeed, pitchspeed, yawspeed }
}
