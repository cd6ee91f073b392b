//! The messages: contents and units of each field.
//!
//! Source of fields and units: MAVLink's `common.xml` (mavlink.io/en/messages/common.html). Times are the
//! mission's, microseconds or milliseconds since the flight computer started.

mod altitude;
mod attitude;
mod gps_raw_int;
mod heartbeat;
mod highres_imu;
mod named_value_float;
mod status_text;
mod sys_status;

pub use altitude::altitude;
pub use attitude::attitude;
pub use gps_raw_int::gps_raw_int;
pub use heartbeat::heartbeat;
pub use highres_imu::highres_imu;
pub use named_value_float::named_value_float;
pub use status_text::status_text;
pub use sys_status::{SensorBits, SysStatus, sys_status};

/// Converts a time in microseconds to MAVLink's 32-bit milliseconds, which wrap after 49.7 days.
#[must_use]
pub const fn boot_ms(time_us: u64) -> u32 {
    (time_us / 1_000) as u32
}
