//! The useful values of each message.

use mavlink::dialects::common::{GpsFixType, HighresImuUpdatedFlags, MavAutopilot, MavMessage, MavType};
use telemetry::named;

use super::frame::Packet;

const G_MPS2: f32 = 9.806_65;

/// Time that a message gives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stamp {
    /// Microseconds since the sender started, or since 1970.
    Microseconds(u64),
    /// Milliseconds since the sender started.
    Milliseconds(u32),
    /// The message gives no time.
    None,
}

/// One useful value and its time.
#[derive(Clone, Copy, Debug)]
pub struct Timed {
    /// Time of reception, microseconds since 1970.
    pub recorded_us: u64,
    /// Time that its message gives.
    pub stamp: Stamp,
    /// The value.
    pub value: Value,
}

/// A fix of the receiver.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fix {
    pub altitude_m: f64,
    pub ground_mps: Option<(f64, f64)>,
    pub satellites: Option<u8>,
    pub vertical_accuracy_m: Option<f64>,
    pub position_deg: Option<(f64, f64)>,
    /// The message's own time, which a held fix repeats.
    pub fix_time_us: u64,
}

/// A position from the autopilot's own estimate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Global {
    pub altitude_m: f64,
    pub north_mps: f64,
    pub east_mps: f64,
    pub down_mps: f64,
    pub position_deg: (f64, f64),
}

/// A useful value, in the flight's units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value {
    Inertial {
        accel_mps2: [f32; 3],
        gyro_radps: [f32; 3],
    },
    ScaledInertial {
        accel_mps2: [f32; 3],
        gyro_radps: [f32; 3],
    },
    PressurePa(f64),
    ScaledPressurePa(f64),
    PressureAltitudeM(f32),
    BarometerC(f32),
    ScaledBarometerC(f32),
    Fix(Fix),
    /// A fix of the second receiver.
    OtherFix(Fix),
    NoFix,
    Global(Global),
    AttitudeRad([f32; 3]),
    CalibratedAirspeedMps(f32),
    ThrottlePercent(u16),
    /// From a Pylon: the number of its phase.
    Phase(u32),
    /// From a Pylon: a value under one of its names.
    Named(Sampled, f32),
    /// From a Pylon: an estimated value.
    Estimate,
}

/// Values that a Pylon samples and sends by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sampled {
    Launch,
    MasterAltitude,
    SlaveAltitude,
    VelocityDown,
    Airspeed,
    AngleOfAttack,
    Sideslip,
    Throttle,
    OutsideAir,
}

impl Sampled {
    fn of(name: &str) -> Option<Self> {
        let names = [
            (named::LAUNCH, Self::Launch),
            (named::ALTITUDE_MASTER, Self::MasterAltitude),
            (named::ALTITUDE_SLAVE, Self::SlaveAltitude),
            (named::VELOCITY_DOWN, Self::VelocityDown),
            (named::TRUE_AIRSPEED, Self::Airspeed),
            (named::ANGLE_OF_ATTACK, Self::AngleOfAttack),
            (named::SIDESLIP, Self::Sideslip),
            (named::THROTTLE, Self::Throttle),
            (named::OUTSIDE_AIR, Self::OutsideAir),
        ];
        names.iter().find_map(|(known, sampled)| (known.text() == name).then_some(*sampled))
    }
}

/// Adds the useful values of a message.
pub fn take(packet: &Packet, values: &mut Vec<Timed>) {
    let mut add = |stamp, value| values.push(Timed { recorded_us: packet.recorded_us, stamp, value });
    match &packet.message {
        MavMessage::HIGHRES_IMU(imu) if imu.id == 0 => {
            use HighresImuUpdatedFlags as Updated;
            let stamp = Stamp::Microseconds(imu.time_usec);
            let updated = |flag| imu.fields_updated.contains(flag);
            let accel_mps2 = [imu.xacc, imu.yacc, imu.zacc];
            let gyro_radps = [imu.xgyro, imu.ygyro, imu.zgyro];
            if imu.fields_updated.bits() & 0x3f == 0x3f {
                add(stamp, Value::Inertial { accel_mps2, gyro_radps });
            }
            if updated(Updated::HIGHRES_IMU_UPDATED_ABS_PRESSURE) {
                add(stamp, Value::PressurePa(f64::from(imu.abs_pressure) * 100.0));
            } else if updated(Updated::HIGHRES_IMU_UPDATED_PRESSURE_ALT) {
                add(stamp, Value::PressureAltitudeM(imu.pressure_alt));
            }
            if updated(Updated::HIGHRES_IMU_UPDATED_TEMPERATURE) {
                add(stamp, Value::BarometerC(imu.temperature));
            }
        }
        MavMessage::SCALED_IMU(imu) => {
            let thousandths = |axes: [i16; 3], unit: f32| axes.map(|axis| f32::from(axis) * unit / 1_000.0);
            let accel_mps2 = thousandths([imu.xacc, imu.yacc, imu.zacc], G_MPS2);
            let gyro_radps = thousandths([imu.xgyro, imu.ygyro, imu.zgyro], 1.0);
            add(Stamp::Milliseconds(imu.time_boot_ms), Value::ScaledInertial { accel_mps2, gyro_radps });
        }
        MavMessage::SCALED_PRESSURE(pressure) => {
            let stamp = Stamp::Milliseconds(pressure.time_boot_ms);
            add(stamp, Value::ScaledPressurePa(f64::from(pressure.press_abs) * 100.0));
            add(stamp, Value::ScaledBarometerC(f32::from(pressure.temperature) / 100.0));
        }
        MavMessage::GPS_RAW_INT(fix) => {
            let raw = RawFix {
                fix_type: fix.fix_type as u8,
                time_us: fix.time_usec,
                altitude_mm: fix.alt,
                latitude_e7: fix.lat,
                longitude_e7: fix.lon,
                speed_cmps: fix.vel,
                course_cdeg: fix.cog,
                satellites: fix.satellites_visible,
                vertical_accuracy_mm: fix.v_acc,
            };
            add(Stamp::Microseconds(fix.time_usec), raw.fix().map_or(Value::NoFix, Value::Fix));
        }
        MavMessage::GPS2_RAW(fix) => {
            let raw = RawFix {
                fix_type: fix.fix_type as u8,
                time_us: fix.time_usec,
                altitude_mm: fix.alt,
                latitude_e7: fix.lat,
                longitude_e7: fix.lon,
                speed_cmps: fix.vel,
                course_cdeg: fix.cog,
                satellites: fix.satellites_visible,
                vertical_accuracy_mm: fix.v_acc,
            };
            if let Some(fix) = raw.fix() {
                add(Stamp::Microseconds(fix.fix_time_us), Value::OtherFix(fix));
            }
        }
        MavMessage::GLOBAL_POSITION_INT(position) => {
            let hundredths = |value: i16| f64::from(value) / 100.0;
            let global = Global {
                altitude_m: f64::from(position.alt) / 1_000.0,
                north_mps: hundredths(position.vx),
                east_mps: hundredths(position.vy),
                down_mps: hundredths(position.vz),
                position_deg: (degrees(position.lat), degrees(position.lon)),
            };
            add(Stamp::Milliseconds(position.time_boot_ms), Value::Global(global));
        }
        MavMessage::ATTITUDE(attitude) => {
            let angles_rad = [attitude.roll, attitude.pitch, attitude.yaw];
            add(Stamp::Milliseconds(attitude.time_boot_ms), Value::AttitudeRad(angles_rad));
        }
        MavMessage::VFR_HUD(hud) => {
            add(Stamp::None, Value::CalibratedAirspeedMps(hud.airspeed));
            add(Stamp::None, Value::ThrottlePercent(hud.throttle));
        }
        MavMessage::HEARTBEAT(heartbeat)
            if packet.sender.1 == telemetry::COMPONENT_ID
                && heartbeat.mavtype == MavType::MAV_TYPE_ONBOARD_CONTROLLER
                && heartbeat.autopilot == MavAutopilot::MAV_AUTOPILOT_INVALID =>
        {
            add(Stamp::None, Value::Phase(heartbeat.custom_mode));
        }
        MavMessage::NAMED_VALUE_FLOAT(value) if packet.sender.1 == telemetry::COMPONENT_ID => {
            let sampled = value.name.to_str().ok().and_then(Sampled::of);
            let found = sampled.map_or(Value::Estimate, |sampled| Value::Named(sampled, value.value));
            add(Stamp::Milliseconds(value.time_boot_ms), found);
        }
        _ => {}
    }
}

/// The common data of both receivers' messages.
struct RawFix {
    fix_type: u8,
    time_us: u64,
    altitude_mm: i32,
    latitude_e7: i32,
    longitude_e7: i32,
    speed_cmps: u16,
    course_cdeg: u16,
    satellites: u8,
    vertical_accuracy_mm: u32,
}

impl RawFix {
    /// The fix, if it has an altitude.
    fn fix(&self) -> Option<Fix> {
        if self.fix_type < GpsFixType::GPS_FIX_TYPE_3D_FIX as u8 {
            return None;
        }
        let is_known = self.speed_cmps != u16::MAX && self.course_cdeg != u16::MAX;
        let ground_mps = is_known.then(|| {
            let (speed_mps, course) =
                (f64::from(self.speed_cmps) / 100.0, (f64::from(self.course_cdeg) / 100.0).to_radians());
            (speed_mps * course.cos(), speed_mps * course.sin())
        });
        let (latitude_e7, longitude_e7) = (self.latitude_e7, self.longitude_e7);
        let has_position =
            latitude_e7 != i32::MAX && longitude_e7 != i32::MAX && (latitude_e7, longitude_e7) != (0, 0);
        Some(Fix {
            altitude_m: f64::from(self.altitude_mm) / 1_000.0,
            ground_mps,
            satellites: (self.satellites != u8::MAX).then_some(self.satellites),
            vertical_accuracy_m: (self.vertical_accuracy_mm != 0)
                .then(|| f64::from(self.vertical_accuracy_mm) / 1_000.0),
            position_deg: has_position.then(|| (degrees(latitude_e7), degrees(longitude_e7))),
            fix_time_us: self.time_us,
        })
    }
}

fn degrees(e7: i32) -> f64 {
    f64::from(e7) / 1e7
}
