//! Which fields of each topic are used, and where in a flight they go.

use flight_data::Channel;

/// Where a number goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Target {
    /// A known column.
    Channel(Channel),
    /// A signal.
    Signal(&'static str),
    /// No column of its own: it is combined with other fields.
    Part,
}

/// A number of a topic.
#[derive(Clone, Copy, Debug)]
pub struct FieldRule {
    /// The paths that it has had, newest first, each with the factor to the flight's unit.
    pub paths: &'static [(&'static str, f64)],
    /// Where it goes.
    pub target: Target,
}

/// A topic.
#[derive(Clone, Copy, Debug)]
pub struct Rule {
    /// Its name.
    pub topic: &'static str,
    /// Its numbers.
    pub fields: &'static [FieldRule],
}

const fn channel(path: &'static [(&'static str, f64)], channel: Channel) -> FieldRule {
    FieldRule { paths: path, target: Target::Channel(channel) }
}

const fn signal(path: &'static [(&'static str, f64)], name: &'static str) -> FieldRule {
    FieldRule { paths: path, target: Target::Signal(name) }
}

const fn part(path: &'static [(&'static str, f64)]) -> FieldRule {
    FieldRule { paths: path, target: Target::Part }
}

/// The receiver's fix, in the order of the indices in [`super::gps`]. Two topics have it.
const FIX: &[FieldRule] = &[
    part(&[("fix_type", 1.0)]),
    part(&[("time_utc_usec", 1.0), ("time_gps_usec", 1.0)]),
    part(&[("altitude_msl_m", 1.0), ("alt", 1e-3)]),
    part(&[("vel_n_m_s", 1.0)]),
    part(&[("vel_e_m_s", 1.0)]),
    part(&[("vel_d_m_s", 1.0)]),
    part(&[("epv", 1.0), ("epv_m", 1.0)]),
    part(&[("satellites_used", 1.0), ("satellites_visible", 1.0)]),
    part(&[("latitude_deg", 1.0), ("lat", 1e-7)]),
    part(&[("longitude_deg", 1.0), ("lon", 1e-7)]),
    part(&[("s_variance_m_s", 1.0)]),
    part(&[("vel_ned_valid", 1.0)]),
];

/// Topics with a receiver's fix, the preferred one first.
pub const FIXES: [&str; 2] = ["vehicle_gps_position", "sensor_gps"];

/// Every topic that is used. Names of the autopilot's own estimates begin with `autopilot_`.
pub const RULES: &[Rule] = &[
    Rule { topic: "vehicle_gps_position", fields: FIX },
    Rule { topic: "sensor_gps", fields: FIX },
    Rule {
        topic: "vehicle_air_data",
        fields: &[
            part(&[("baro_pressure_pa", 1.0)]),
            part(&[("baro_temp_celcius", 1.0), ("temperature", 1.0)]),
            part(&[("baro_alt_meter", 1.0)]),
            signal(&[("ambient_temperature", 1.0)], "ambient_temp_c"),
        ],
    },
    Rule {
        topic: "sensor_baro",
        fields: &[part(&[("pressure", 1.0)]), part(&[("temperature", 1.0)]), part(&[("altitude", 1.0)])],
    },
    Rule {
        topic: "sensor_combined",
        fields: &[
            channel(&[("accelerometer_m_s2[0]", 1.0)], Channel::AccelXMps2),
            channel(&[("accelerometer_m_s2[1]", 1.0)], Channel::AccelYMps2),
            channel(&[("accelerometer_m_s2[2]", 1.0)], Channel::AccelZMps2),
            channel(&[("gyro_rad[0]", 1.0), ("gyro_rad_s[0]", 1.0)], Channel::GyroXRadps),
            channel(&[("gyro_rad[1]", 1.0), ("gyro_rad_s[1]", 1.0)], Channel::GyroYRadps),
            channel(&[("gyro_rad[2]", 1.0), ("gyro_rad_s[2]", 1.0)], Channel::GyroZRadps),
            // From before vehicle_air_data existed.
            part(&[("baro_alt_meter", 1.0), ("baro_alt_meter[0]", 1.0)]),
            part(&[("baro_temp_celcius", 1.0), ("baro_temp_celcius[0]", 1.0)]),
        ],
    },
    Rule {
        topic: "vehicle_attitude",
        fields: &[
            part(&[("q[0]", 1.0)]),
            part(&[("q[1]", 1.0)]),
            part(&[("q[2]", 1.0)]),
            part(&[("q[3]", 1.0)]),
        ],
    },
    Rule {
        topic: "airspeed_validated",
        fields: &[
            part(&[("true_airspeed_m_s", 1.0)]),
            signal(
                &[("calibrated_airspeed_m_s", 1.0), ("equivalent_airspeed_m_s", 1.0)],
                "calibrated_airspeed_mps",
            ),
        ],
    },
    Rule {
        topic: "airspeed",
        fields: &[
            part(&[("true_airspeed_m_s", 1.0), ("true_airspeed_unfiltered_m_s", 1.0)]),
            signal(&[("indicated_airspeed_m_s", 1.0)], "indicated_airspeed_mps"),
        ],
    },
    Rule {
        topic: "differential_pressure",
        fields: &[signal(
            &[("differential_pressure_pa", 1.0), ("differential_pressure_raw_pa", 1.0)],
            "airspeed_pressure_pa",
        )],
    },
    Rule { topic: "actuator_controls_0", fields: &[part(&[("control[3]", 1.0)])] },
    Rule {
        topic: "vehicle_thrust_setpoint",
        fields: &[part(&[("xyz[0]", 1.0)]), part(&[("xyz[1]", 1.0)]), part(&[("xyz[2]", 1.0)])],
    },
    Rule {
        topic: "vehicle_local_position",
        fields: &[
            signal(&[("vx", 1.0)], "autopilot_vn_mps"),
            signal(&[("vy", 1.0)], "autopilot_ve_mps"),
            signal(&[("vz", 1.0)], "autopilot_vd_mps"),
            signal(&[("z", 1.0)], "autopilot_down_m"),
        ],
    },
    Rule {
        topic: "estimator_innovations",
        fields: &[
            signal(&[("gps_vvel", 1.0)], "autopilot_innovation_vd_mps"),
            signal(&[("gps_vpos", 1.0)], "autopilot_innovation_gps_altitude_m"),
            signal(&[("baro_vpos", 1.0)], "autopilot_innovation_altitude_m"),
        ],
    },
    Rule {
        topic: "ekf2_innovations",
        fields: &[
            signal(&[("vel_pos_innov[2]", 1.0)], "autopilot_innovation_vd_mps"),
            signal(&[("vel_pos_innov[5]", 1.0)], "autopilot_innovation_altitude_m"),
        ],
    },
    Rule {
        topic: "estimator_sensor_bias",
        fields: &[
            signal(&[("gyro_bias[0]", 1.0)], "autopilot_gyro_bias_x_radps"),
            signal(&[("gyro_bias[1]", 1.0)], "autopilot_gyro_bias_y_radps"),
            signal(&[("gyro_bias[2]", 1.0)], "autopilot_gyro_bias_z_radps"),
            signal(&[("accel_bias[0]", 1.0)], "autopilot_accel_bias_x_mps2"),
            signal(&[("accel_bias[1]", 1.0)], "autopilot_accel_bias_y_mps2"),
            signal(&[("accel_bias[2]", 1.0)], "autopilot_accel_bias_z_mps2"),
        ],
    },
    // The same under its name from before estimator_sensor_bias existed.
    Rule {
        topic: "sensor_bias",
        fields: &[
            signal(&[("gyro_bias[0]", 1.0), ("gyro_x_bias", 1.0)], "autopilot_gyro_bias_x_radps"),
            signal(&[("gyro_bias[1]", 1.0), ("gyro_y_bias", 1.0)], "autopilot_gyro_bias_y_radps"),
            signal(&[("gyro_bias[2]", 1.0), ("gyro_z_bias", 1.0)], "autopilot_gyro_bias_z_radps"),
            signal(&[("accel_bias[0]", 1.0), ("accel_x_bias", 1.0)], "autopilot_accel_bias_x_mps2"),
            signal(&[("accel_bias[1]", 1.0), ("accel_y_bias", 1.0)], "autopilot_accel_bias_y_mps2"),
            signal(&[("accel_bias[2]", 1.0), ("accel_z_bias", 1.0)], "autopilot_accel_bias_z_mps2"),
        ],
    },
    Rule { topic: "estimator_baro_bias", fields: &[signal(&[("bias", 1.0)], "autopilot_baro_bias_m")] },
    Rule {
        topic: "wind",
        fields: &[
            signal(&[("windspeed_north", 1.0)], "autopilot_wind_n_mps"),
            signal(&[("windspeed_east", 1.0)], "autopilot_wind_e_mps"),
        ],
    },
    Rule {
        topic: "wind_estimate",
        fields: &[
            signal(&[("windspeed_north", 1.0)], "autopilot_wind_n_mps"),
            signal(&[("windspeed_east", 1.0)], "autopilot_wind_e_mps"),
        ],
    },
];
