//! SYS_STATUS (1).

use mavlink::dialects::common::{MavSysStatusSensor, MavSysStatusSensorExtended, SYS_STATUS_DATA};

use crate::status::ComputerStatus;

/// Sensors as MAVLink's bits: `3D_GYRO` and `3D_ACCEL` are the inertial unit, `ABSOLUTE_PRESSURE` the
/// barometer, `GPS` the reference, `AHRS` the UAV's inertial altitude (`imu_slave`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorBits {
    /// Sensors that have delivered at least once.
    pub present: MavSysStatusSensor,
    /// Sensors that deliver, and are neither stuck nor untrustworthy.
    pub healthy: MavSysStatusSensor,
}

/// Contents of the message.
#[derive(Clone, Copy, Debug)]
pub struct SysStatus {
    /// The sensors.
    pub sensors: SensorBits,
    /// Share of frames dropped since the last message, of all frames to be sent, percent/100.
    pub drop_rate: u16,
    /// Frames dropped so far.
    pub dropped: u32,
    /// Readings and fixes that the estimator refused so far.
    pub refused: u32,
    /// Ticks that were out of order so far.
    pub out_of_order: u32,
    /// Status known only to the flight computer's own code.
    pub computer: ComputerStatus,
}

/// | field | is |
/// |---|---|
/// | `onboard_control_sensors_*` | [`SensorBits`]; every sensor that is present is enabled |
/// | `load` | longest tick, per mille of its period; `UINT16_MAX` if not measured |
/// | `drop_rate_comm` | frames dropped since the last SYS_STATUS, percent/100 |
/// | `errors_comm` | frames dropped so far |
/// | `errors_count1` | failed polls of sensors |
/// | `errors_count2` | readings and fixes that the estimator refused |
/// | `errors_count3` | ticks out of order |
/// | `errors_count4` | results that found no room in the flight record |
/// | `voltage_battery`, `current_battery`, `battery_remaining` | unknown (`UINT16_MAX`, -1, -1) |
///
/// Counts saturate at 65535.
#[must_use]
pub fn sys_status(status: &SysStatus) -> SYS_STATUS_DATA {
    let none = MavSysStatusSensorExtended::empty();
    let computer = &status.computer;
    SYS_STATUS_DATA {
        onboard_control_sensors_present: status.sensors.present,
        onboard_control_sensors_enabled: status.sensors.present,
        onboard_control_sensors_health: status.sensors.healthy,
        load: computer.load_permille.unwrap_or(u16::MAX),
        voltage_battery: u16::MAX,
        current_battery: -1,
        drop_rate_comm: status.drop_rate,
        errors_comm: at_most(status.dropped),
        errors_count1: at_most(computer.sensor_faults),
        errors_count2: at_most(status.refused),
        errors_count3: at_most(status.out_of_order),
        errors_count4: at_most(computer.lost_results),
        battery_remaining: -1,
        onboard_control_sensors_present_extended: none,
        onboard_control_sensors_enabled_extended: none,
        onboard_control_sensors_health_extended: none,
    }
}

fn at_most(count: u32) -> u16 {
    u16::try_from(count).unwrap_or(u16::MAX)
}
