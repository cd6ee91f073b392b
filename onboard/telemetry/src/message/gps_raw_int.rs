//! GPS_RAW_INT (24).

use kf_core::input::GpsFix;
use mavlink::dialects::common::{GPS_RAW_INT_DATA, GpsFixType};

const DEGREES: f32 = 180.0 / core::f32::consts::PI;

/// A fix of the reference.
///
/// | field | is |
/// |---|---|
/// | `fix_type` | 3D: a receiver's driver passes on no other fix |
/// | `lat`, `lon` | `INT32_MAX`, which means no position: the estimator receives none |
/// | `alt` | altitude above the flight's datum, mm |
/// | `vel`, `cog` | speed over ground, cm/s, and its direction, degrees/100; `UINT16_MAX` unless north and east are known |
/// | `satellites_visible` | satellites used in the fix; `UINT8_MAX` if not known |
/// | `v_acc` | the receiver's own vertical accuracy (1 sigma), mm; 0 if not known |
/// | `eph`, `epv` | `UINT16_MAX`: not known |
/// | the other extensions | 0: not known |
///
/// The velocity down is not in this message; see [`crate::named`].
#[must_use]
pub fn gps_raw_int(time_us: u64, fix: &GpsFix) -> GPS_RAW_INT_DATA {
    let (vel, cog) = match (fix.velocity_north_mps, fix.velocity_east_mps) {
        (Some(north), Some(east)) if north.is_finite() && east.is_finite() => over_ground(north, east),
        _ => (u16::MAX, u16::MAX),
    };
    GPS_RAW_INT_DATA {
        time_usec: time_us,
        lat: i32::MAX,
        lon: i32::MAX,
        alt: libm::roundf(fix.altitude_m * 1_000.0) as i32,
        eph: u16::MAX,
        epv: u16::MAX,
        vel,
        cog,
        fix_type: GpsFixType::GPS_FIX_TYPE_3D_FIX,
        satellites_visible: fix.satellites.unwrap_or(u8::MAX),
        alt_ellipsoid: 0,
        h_acc: 0,
        v_acc: fix.vertical_accuracy_m.map_or(0, |metres| libm::roundf(metres * 1_000.0) as u32),
        vel_acc: 0,
        hdg_acc: 0,
        yaw: 0,
    }
}

/// Speed in cm/s, below the value for "unknown" (655 m/s and more are unknown), and course in degrees/100
/// below 36000.
fn over_ground(north_mps: f32, east_mps: f32) -> (u16, u16) {
    // `libm::hypotf` computes in double precision, which the target does not have.
    let speed_cmps = libm::roundf(libm::sqrtf(north_mps * north_mps + east_mps * east_mps) * 100.0);
    if speed_cmps >= f32::from(u16::MAX) {
        return (u16::MAX, u16::MAX);
    }
    let course_deg = libm::atan2f(east_mps, north_mps) * DEGREES;
    let course_deg = if course_deg < 0.0 { course_deg + 360.0 } else { course_deg };
    let course = libm::roundf(course_deg * 100.0) as u16;
    (speed_cmps as u16, if course >= 36_000 { 0 } else { course })
}
