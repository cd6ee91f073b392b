//! Which fields of each message are used, and where they go in a flight.

use super::units::Quantity;
use flight_data::Channel;

/// Destination of a field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Target {
    /// A known column, from the instance that is used.
    Channel(Channel),
    /// A signal.
    Signal(&'static str),
    /// Calibrated airspeed, from which the true airspeed is computed.
    CalibratedAirspeed,
    /// Throttle, whose unit depends on the vehicle.
    Throttle,
}

/// A field.
#[derive(Clone, Copy, Debug)]
pub struct FieldRule {
    /// All its names, newest first.
    pub names: &'static [&'static str],
    /// Its quantity.
    pub quantity: Quantity,
    /// Factor to the flight's unit, where the log gives no unit.
    pub factor: f64,
    /// Its destination.
    pub target: Target,
    /// What follows `FAMILY_INSTANCE_` in the signal's name of an instance that is not used.
    pub other: Option<&'static str>,
}

/// The fields of one kind of message.
#[derive(Clone, Copy, Debug)]
pub struct Rule {
    /// Its name for the user; names of other instances' signals begin with it.
    pub family: &'static str,
    /// Names of the messages, each with its instance where no field gives one.
    pub messages: &'static [(&'static str, u8)],
    /// The fields.
    pub fields: &'static [FieldRule],
}

const DEGREE: f64 = std::f64::consts::PI / 180.0;

const fn channel(names: &'static [&'static str], quantity: Quantity, channel: Channel) -> FieldRule {
    FieldRule { names, quantity, factor: 1.0, target: Target::Channel(channel), other: None }
}

const fn signal(names: &'static [&'static str], quantity: Quantity, name: &'static str) -> FieldRule {
    FieldRule { names, quantity, factor: 1.0, target: Target::Signal(name), other: None }
}

const fn with_other(mut rule: FieldRule, other: &'static str) -> FieldRule {
    rule.other = Some(other);
    rule
}

const fn in_unit(mut rule: FieldRule, factor: f64) -> FieldRule {
    rule.factor = factor;
    rule
}

/// The receiver's fix, its fields in the order of the places in [`super::gps`].
pub const GPS: Rule = Rule {
    family: "gps",
    messages: &[("GPS", 0), ("GPS2", 1)],
    fields: &[
        signal(&["Status"], Quantity::Plain, "status"),
        signal(&["GWk", "Week"], Quantity::Plain, "week"),
        signal(&["GMS", "TimeMS", "Time"], Quantity::Plain, "week_ms"),
        signal(&["NSats"], Quantity::Plain, "satellites"),
        signal(&["HDop"], Quantity::Plain, "hdop"),
        signal(&["Lat"], Quantity::Degrees, "latitude_deg"),
        signal(&["Lng"], Quantity::Degrees, "longitude_deg"),
        signal(&["Alt"], Quantity::Length, "altitude_m"),
        signal(&["Spd"], Quantity::Speed, "speed_mps"),
        in_unit(signal(&["GCrs"], Quantity::Angle, "course_rad"), DEGREE),
        signal(&["VZ"], Quantity::Speed, "down_mps"),
    ],
};

/// The fix's accuracy.
pub const ACCURACY: Rule = Rule {
    family: "gps accuracy",
    messages: &[("GPA", 0), ("GPA2", 1)],
    fields: &[
        signal(&["VAcc"], Quantity::Length, "vertical_accuracy_m"),
        signal(&["HAcc"], Quantity::Length, "gps_horizontal_accuracy_m"),
        signal(&["SAcc"], Quantity::Speed, "gps_speed_accuracy_mps"),
    ],
};

/// Index of the accuracy among the rules.
pub const ACCURACY_PLACE: usize = 0;

/// All others. Names of the autopilot's estimates begin with `autopilot_`.
pub const RULES: [Rule; 14] = [
    ACCURACY,
    Rule {
        family: "baro",
        messages: &[("BARO", 0), ("BAR2", 1), ("BAR3", 2)],
        fields: &[
            with_other(channel(&["Press"], Quantity::Pressure, Channel::BaroPa), "pa"),
            with_other(channel(&["Temp"], Quantity::Temperature, Channel::BaroTempC), "temp_c"),
        ],
    },
    Rule {
        family: "imu",
        messages: &[("IMU", 0), ("IMU2", 1), ("IMU3", 2)],
        fields: &[
            channel(&["AccX"], Quantity::Acceleration, Channel::AccelXMps2),
            channel(&["AccY"], Quantity::Acceleration, Channel::AccelYMps2),
            channel(&["AccZ"], Quantity::Acceleration, Channel::AccelZMps2),
            channel(&["GyrX"], Quantity::AngularRate, Channel::GyroXRadps),
            channel(&["GyrY"], Quantity::AngularRate, Channel::GyroYRadps),
            channel(&["GyrZ"], Quantity::AngularRate, Channel::GyroZRadps),
            signal(&["T"], Quantity::Temperature, "imu_temp_c"),
        ],
    },
    Rule {
        family: "attitude",
        messages: &[("ATT", 0)],
        fields: &[
            in_unit(channel(&["Roll"], Quantity::Angle, Channel::RollRad), DEGREE),
            in_unit(channel(&["Pitch"], Quantity::Angle, Channel::PitchRad), DEGREE),
            in_unit(channel(&["Yaw"], Quantity::Angle, Channel::YawRad), DEGREE),
        ],
    },
    Rule {
        family: "airspeed",
        messages: &[("ARSP", 0), ("ASP2", 1), ("ARS2", 1)],
        fields: &[
            with_other(
                FieldRule {
                    names: &["Airspeed"],
                    quantity: Quantity::Speed,
                    factor: 1.0,
                    target: Target::CalibratedAirspeed,
                    other: None,
                },
                "calibrated_mps",
            ),
            with_other(signal(&["DiffPress"], Quantity::Pressure, "airspeed_pressure_pa"), "pressure_pa"),
            signal(&["Temp"], Quantity::Temperature, "airspeed_sensor_temp_c"),
        ],
    },
    Rule {
        family: "control",
        messages: &[("CTUN", 0)],
        fields: &[
            throttle(&["ThO", "ThrOut"]),
            signal(&["BAlt", "BarAlt"], Quantity::Length, BARO_ABOVE_GROUND),
            signal(&["DAlt", "WPAlt"], Quantity::Length, "autopilot_desired_altitude_m"),
            signal(&["Alt"], Quantity::Length, "autopilot_altitude_m"),
            in_unit(signal(&["CRt", "CRate"], Quantity::Speed, "autopilot_climb_mps"), 0.01),
        ],
    },
    Rule { family: "throttle", messages: &[("THR", 0)], fields: &[throttle(&["ThrOut"])] },
    Rule {
        family: "outputs",
        messages: &[("RCOU", 0), ("RCOUT", 0)],
        fields: &[
            signal(&["C1", "Ch1", "Chan1"], Quantity::Plain, "output_1_us"),
            signal(&["C2", "Ch2", "Chan2"], Quantity::Plain, "output_2_us"),
            signal(&["C3", "Ch3", "Chan3"], Quantity::Plain, "output_3_us"),
            signal(&["C4", "Ch4", "Chan4"], Quantity::Plain, "output_4_us"),
            signal(&["C5", "Ch5", "Chan5"], Quantity::Plain, "output_5_us"),
            signal(&["C6", "Ch6", "Chan6"], Quantity::Plain, "output_6_us"),
            signal(&["C7", "Ch7", "Chan7"], Quantity::Plain, "output_7_us"),
            signal(&["C8", "Ch8", "Chan8"], Quantity::Plain, "output_8_us"),
            signal(&["C9"], Quantity::Plain, "output_9_us"),
            signal(&["C10"], Quantity::Plain, "output_10_us"),
            signal(&["C11"], Quantity::Plain, "output_11_us"),
            signal(&["C12"], Quantity::Plain, "output_12_us"),
            signal(&["C13"], Quantity::Plain, "output_13_us"),
            signal(&["C14"], Quantity::Plain, "output_14_us"),
        ],
    },
    Rule {
        family: "air angles",
        messages: &[("AOA", 0)],
        fields: &[
            in_unit(signal(&["AOA"], Quantity::Angle, "autopilot_aoa_rad"), DEGREE),
            in_unit(signal(&["SSA"], Quantity::Angle, "autopilot_sideslip_rad"), DEGREE),
        ],
    },
    Rule {
        family: "vibration",
        messages: &[("VIBE", 0)],
        fields: &[
            signal(&["VibeX"], Quantity::Acceleration, "vibration_x_mps2"),
            signal(&["VibeY"], Quantity::Acceleration, "vibration_y_mps2"),
            signal(&["VibeZ"], Quantity::Acceleration, "vibration_z_mps2"),
        ],
    },
    // One core of one filter is used: EKF3's, else EKF2's, else the first filter's.
    Rule {
        family: "EKF velocities",
        messages: &[("XKF1", 0), ("NKF1", EKF2), ("EKF1", EKF1)],
        fields: &[
            signal(&["VN"], Quantity::Speed, "autopilot_vn_mps"),
            signal(&["VE"], Quantity::Speed, "autopilot_ve_mps"),
            signal(&["VD"], Quantity::Speed, "autopilot_vd_mps"),
            signal(&["PD"], Quantity::Length, "autopilot_down_m"),
            in_unit(signal(&["GX"], Quantity::AngularRate, "autopilot_gyro_bias_x_radps"), DEGREE),
            in_unit(signal(&["GY"], Quantity::AngularRate, "autopilot_gyro_bias_y_radps"), DEGREE),
            in_unit(signal(&["GZ"], Quantity::AngularRate, "autopilot_gyro_bias_z_radps"), DEGREE),
        ],
    },
    Rule {
        family: "EKF biases",
        messages: &[("XKF2", 0), ("NKF2", EKF2)],
        fields: &[
            signal(&["VWN"], Quantity::Speed, "autopilot_wind_n_mps"),
            signal(&["VWE"], Quantity::Speed, "autopilot_wind_e_mps"),
            signal(&["AX"], Quantity::Acceleration, "autopilot_accel_bias_x_mps2"),
            signal(&["AY"], Quantity::Acceleration, "autopilot_accel_bias_y_mps2"),
            // The second filter estimates only the bias of the third axis.
            signal(&["AZ", "AZbias"], Quantity::Acceleration, "autopilot_accel_bias_z_mps2"),
        ],
    },
    Rule {
        family: "EKF innovations",
        messages: &[("XKF3", 0), ("NKF3", EKF2), ("EKF3", EKF1)],
        fields: &[
            signal(&["IVN"], Quantity::Speed, "autopilot_innovation_vn_mps"),
            signal(&["IVE"], Quantity::Speed, "autopilot_innovation_ve_mps"),
            signal(&["IVD"], Quantity::Speed, "autopilot_innovation_vd_mps"),
            signal(&["IPD"], Quantity::Length, "autopilot_innovation_altitude_m"),
        ],
    },
    Rule {
        family: "EKF innovation ratios",
        messages: &[("XKF4", 0), ("NKF4", EKF2), ("EKF4", EKF1)],
        fields: &[
            signal(&["SV"], Quantity::Plain, "autopilot_innovation_ratio_velocity"),
            signal(&["SP"], Quantity::Plain, "autopilot_innovation_ratio_position"),
            signal(&["SH"], Quantity::Plain, "autopilot_innovation_ratio_altitude"),
        ],
    },
];

/// First instance number of the second and of the first filter, after the third one's cores.
const EKF2: u8 = 8;
const EKF1: u8 = 16;
/// The barometric altitude above the ground at arming, where the log has nothing better.
pub const BARO_ABOVE_GROUND: &str = "autopilot_baro_above_ground_m";

const fn throttle(names: &'static [&'static str]) -> FieldRule {
    FieldRule { names, quantity: Quantity::Plain, factor: 1.0, target: Target::Throttle, other: None }
}
