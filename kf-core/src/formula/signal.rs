//! Signals that a formula may read.

use crate::effect::Uses;

/// Largest number of extra columns (columns that the estimator has no name for) that a model's formulas may
/// read. None on a target without an operating system: only the desk has such columns.
pub const MAX_COLUMNS: usize = if cfg!(target_os = "none") { 0 } else { 8 };

macro_rules! signals {
    ($($(#[$doc:meta])* $variant:ident = $name:literal, $unit:literal;)*) => {
        /// A signal, by its place in a [`super::Frame`].
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        #[repr(u8)]
        pub enum Signal {
            $($(#[$doc])* $variant,)*
        }

        impl Signal {
            /// Every signal, in the order of their places.
            pub const ALL: &'static [Self] = &[$(Self::$variant),*];

            /// Its name in a formula.
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self { $(Self::$variant => $name,)* }
            }

            /// Its unit in a formula. Columns `_c` are converted to kelvin, absolute.
            #[must_use]
            pub const fn unit(self) -> &'static str {
                match self { $(Self::$variant => $unit,)* }
            }
        }
    };
}

signals! {
    /// Seconds since launch; 0 before.
    Time = "t", "s";
    /// Seconds since the first tick: power-on.
    TimeOn = "t_on", "s";
    /// 0 before launch, 1 after.
    Launch = "launch", "1";
    /// Cosine of the latitude of the model's `[site]`.
    CosineLatitude = "cos_latitude", "1";
    /// True airspeed; until one is measured, the speed over ground, climb included.
    Airspeed = "airspeed_mps", "m/s";
    /// Horizontal speed over ground.
    GroundSpeed = "ground_speed_mps", "m/s";
    /// Climb rate: the receiver's own if it gives one, else from its altitudes.
    ClimbRate = "climb_rate_mps", "m/s";
    /// The reference's altitude: the last fix carried forward by the climb rate.
    Altitude = "altitude_m", "m";
    /// Load factor, low-passed with a time constant of 0.05 s.
    LoadFactor = "load_factor", "1";
    /// Upward acceleration in the level frame, without gravity.
    UpwardAcceleration = "upward_accel_mps2", "m/s^2";
    /// Forward acceleration in the level frame; after launch without the constant error that captive flight
    /// showed.
    ForwardAcceleration = "forward_accel_mps2", "m/s^2";
    /// Half the squared difference of two successive samples of the specific force, summed over the axes: the
    /// vibration's variance.
    AccelerationVariance = "accel_variance", "m^2/s^4";
    /// Column `tas_mps`.
    TrueAirspeed = "tas_mps", "m/s";
    /// Column `aoa_rad`.
    AngleOfAttack = "aoa_rad", "rad";
    /// Column `sideslip_rad`.
    Sideslip = "sideslip_rad", "rad";
    /// Column `throttle`.
    Throttle = "throttle", "1";
    /// Column `oat_c`, in kelvin.
    OutsideAirTemperature = "oat_c", "K";
    /// Column `baro_temp_c`, in kelvin.
    BaroTemperature = "baro_temp_c", "K";
    /// Column `roll_rad`.
    Roll = "roll_rad", "rad";
    /// Column `pitch_rad`.
    Pitch = "pitch_rad", "rad";
    /// Column `yaw_rad`.
    Yaw = "yaw_rad", "rad";
    /// Column `accel_x_mps2`.
    AccelX = "accel_x_mps2", "m/s^2";
    /// Column `accel_y_mps2`.
    AccelY = "accel_y_mps2", "m/s^2";
    /// Column `accel_z_mps2`.
    AccelZ = "accel_z_mps2", "m/s^2";
    /// Column `gyro_x_radps`.
    GyroX = "gyro_x_radps", "rad/s";
    /// Column `gyro_y_radps`.
    GyroY = "gyro_y_radps", "rad/s";
    /// Column `gyro_z_radps`.
    GyroZ = "gyro_z_radps", "rad/s";
    /// Column `gps_alt_m`: the last accepted fix.
    GpsAltitude = "gps_alt_m", "m";
    /// Column `gps_vn_mps`.
    GpsNorth = "gps_vn_mps", "m/s";
    /// Column `gps_ve_mps`.
    GpsEast = "gps_ve_mps", "m/s";
    /// Column `gps_vd_mps`.
    GpsDown = "gps_vd_mps", "m/s";
    /// Column `gps_vacc_m`.
    GpsAccuracy = "gps_vacc_m", "m";
    /// Column `gps_sats`.
    GpsSatellites = "gps_sats", "1";
    /// Column `baro_pa`.
    BaroPressure = "baro_pa", "Pa";
    /// Column `baro_alt_m`.
    BaroAltitude = "baro_alt_m", "m";
    /// Column `imu_master_alt_m`.
    ImuMaster = "imu_master_alt_m", "m";
    /// Column `imu_slave_alt_m`.
    ImuSlave = "imu_slave_alt_m", "m";
}

/// Places of a frame: the signals, then the extra columns.
pub const SIGNALS: usize = Signal::ALL.len() + MAX_COLUMNS;

/// Number of places in a [`super::Frame`]; 0 where no model has a formula. A power of two, so that a mask
/// keeps an index in range, which is cheaper than a comparison.
pub(super) const PLACES: usize = if cfg!(feature = "formulas") { SIGNALS.next_power_of_two() } else { 0 };

impl Signal {
    /// Its place in a frame.
    #[must_use]
    pub const fn place(self) -> u8 {
        self as u8
    }

    /// Its bit in a set of signals.
    #[must_use]
    pub const fn bit(self) -> u64 {
        1 << self.place()
    }

    /// The signal with this name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|signal| signal.name() == name)
    }

    /// Place of an extra column by its number; there are [`MAX_COLUMNS`].
    #[must_use]
    pub const fn column_place(column: u8) -> u8 {
        Self::ALL.len() as u8 + column
    }

    /// Columns of a flight from which the signal is made when nothing substitutes for them.
    #[must_use]
    pub const fn needs(self) -> &'static [&'static str] {
        const ATTITUDE: &[&str] = &["roll_rad", "pitch_rad", "yaw_rad"];
        const INERTIAL: &[&str] =
            &["accel_x_mps2", "accel_y_mps2", "accel_z_mps2", "gyro_x_radps", "gyro_y_radps", "gyro_z_radps"];
        match self {
            Self::Time | Self::TimeOn | Self::Launch | Self::CosineLatitude => &[],
            Self::Airspeed | Self::TrueAirspeed => &["tas_mps"],
            Self::GroundSpeed => &["gps_vn_mps", "gps_ve_mps"],
            Self::ClimbRate | Self::Altitude | Self::GpsAltitude => &["gps_alt_m"],
            Self::LoadFactor
            | Self::AccelerationVariance
            | Self::AccelX
            | Self::AccelY
            | Self::AccelZ
            | Self::GyroX
            | Self::GyroY
            | Self::GyroZ => INERTIAL,
            Self::UpwardAcceleration | Self::ForwardAcceleration => super::frame::INERTIAL_AND_ATTITUDE,
            Self::Roll | Self::Pitch | Self::Yaw => ATTITUDE,
            Self::AngleOfAttack => &["aoa_rad"],
            Self::Sideslip => &["sideslip_rad"],
            Self::Throttle => &["throttle"],
            Self::OutsideAirTemperature => &["oat_c"],
            Self::BaroTemperature => &["baro_temp_c"],
            Self::GpsNorth => &["gps_vn_mps"],
            Self::GpsEast => &["gps_ve_mps"],
            Self::GpsDown => &["gps_vd_mps"],
            Self::GpsAccuracy => &["gps_vacc_m"],
            Self::GpsSatellites => &["gps_sats"],
            Self::BaroPressure => &["baro_pa"],
            Self::BaroAltitude => &["baro_alt_m"],
            Self::ImuMaster => &["imu_master_alt_m"],
            Self::ImuSlave => &["imu_slave_alt_m"],
        }
    }
}

/// What the signal tracker must follow for a set of signals.
pub(crate) const fn uses(signals: u64) -> Uses {
    let mut uses = Uses::NOTHING;
    if signals & (Signal::ClimbRate.bit() | Signal::Altitude.bit()) != 0 {
        uses = uses.and(Uses::HEIGHT);
    }
    if signals & Signal::LoadFactor.bit() != 0 {
        uses = uses.and(Uses::LOAD_FACTOR);
    }
    if signals & Signal::UpwardAcceleration.bit() != 0 {
        uses = uses.and(Uses::ATTITUDE).and(Uses::VERTICAL);
    }
    if signals & Signal::ForwardAcceleration.bit() != 0 {
        uses = uses.and(Uses::ATTITUDE).and(Uses::FORWARD);
    }
    uses
}
