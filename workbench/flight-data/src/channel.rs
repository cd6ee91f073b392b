//! The known channels of a flight file.

macro_rules! channels {
    ($($(#[$doc:meta])* $variant:ident = $name:literal,)*) => {
        /// A known column of a flight file; its name gives the unit.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
        pub enum Channel {
            $($(#[$doc])* $variant,)*
        }

        impl Channel {
            /// Every channel, in the order in which files are written.
            pub const ALL: &'static [Self] = &[$(Self::$variant,)*];

            /// The column's name in a file.
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $name,)*
                }
            }
        }
    };
}

channels! {
    /// The umbilical discrete: 1 once the UAV has left the mother ship.
    Launch = "launch",
    /// What supports `launch`, as decided by a flight computer: 0 nothing, 1 not launched but suspected, 2
    /// launched by the wire alone (optional; held from one cell to the next, as `launch`).
    LaunchDoubt = "launch_doubt",
    /// `gps_alt_m`, m.
    GpsAltM = "gps_alt_m",
    /// `gps_vn_mps`, m/s.
    GpsVnMps = "gps_vn_mps",
    /// `gps_ve_mps`, m/s.
    GpsVeMps = "gps_ve_mps",
    /// `gps_vd_mps`, m/s.
    GpsVdMps = "gps_vd_mps",
    /// `gps_vacc_m`, m.
    GpsVaccM = "gps_vacc_m",
    /// Satellites used in the fix.
    GpsSats = "gps_sats",
    /// Time of the fix by the receiver's clock, s (optional; distinguishes a held fix from a new one).
    GpsTimeS = "gps_time_s",
    /// `baro_pa`, Pa.
    BaroPa = "baro_pa",
    /// `baro_alt_m`, m.
    BaroAltM = "baro_alt_m",
    /// `baro_temp_c`, degrees Celsius.
    BaroTempC = "baro_temp_c",
    /// `imu_master_alt_m`, m.
    ImuMasterAltM = "imu_master_alt_m",
    /// `imu_slave_alt_m`, m.
    ImuSlaveAltM = "imu_slave_alt_m",
    /// `accel_x_mps2`, m/s^2.
    AccelXMps2 = "accel_x_mps2",
    /// `accel_y_mps2`, m/s^2.
    AccelYMps2 = "accel_y_mps2",
    /// `accel_z_mps2`, m/s^2.
    AccelZMps2 = "accel_z_mps2",
    /// `gyro_x_radps`, rad/s.
    GyroXRadps = "gyro_x_radps",
    /// `gyro_y_radps`, rad/s.
    GyroYRadps = "gyro_y_radps",
    /// `gyro_z_radps`, rad/s.
    GyroZRadps = "gyro_z_radps",
    /// `roll_rad`, rad.
    RollRad = "roll_rad",
    /// `pitch_rad`, rad.
    PitchRad = "pitch_rad",
    /// `yaw_rad`, rad.
    YawRad = "yaw_rad",
    /// `tas_mps`, m/s.
    TasMps = "tas_mps",
    /// `aoa_rad`, rad.
    AoaRad = "aoa_rad",
    /// `sideslip_rad`, rad.
    SideslipRad = "sideslip_rad",
    /// `throttle`, 0 to 1.
    Throttle = "throttle",
    /// `oat_c`, degrees Celsius.
    OatC = "oat_c",
}

impl Channel {
    /// The channel with that column name, or `None`.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|channel| channel.name() == name)
    }
}
