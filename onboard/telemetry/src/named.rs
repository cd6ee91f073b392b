//! The plain values: their names, of at most ten letters, and units.
//!
//! Samples, with the time of the sample, at the rates of [`crate::Rates`]:
//!
//! | name | value | unit |
//! |---|---|---|
//! | `alt_master` | the mother ship's inertial altitude | m |
//! | `alt_slave` | the UAV's inertial altitude | m |
//! | `gps_vd` | velocity down of a fix, for which GPS_RAW_INT has no field | m/s |
//! | `tas`, `aoa`, `sideslip` | true airspeed, angle of attack, sideslip | m/s, rad, rad |
//! | `throttle` | throttle, 0 to 1 | 1 |
//! | `oat` | outside air temperature | degrees Celsius |
//! | `launch` | 0, or 1 once the launch is decided; at once when it changes | 1 |
//! | `wire` | the umbilical's wire: 0 closed, 1 open, 2 broken (open, and no launch), 3 unreadable | 1 |
//!
//! Of each sensor (`_master`, `_slave`, `_baro`):
//!
//! | name | value | unit |
//! |---|---|---|
//! | `e_` | error of eq. 16: reading minus bias, effects and reference | m |
//! | `ma_` | its moving average, free flight only | m |
//! | `tr_` | trust: 0 calibrating, 1 trusted, 2 doubtful, 3 untrustworthy, 4 unmonitored | 1 |
//! | `b_`, `sb_` | bias, and its sigma by the filter | m |
//! | `sr_` | spread of the calibrated residual (1 sigma), after the latch | m |
//! | `bd_` | the monitor's alarm limit, after the latch | m |
//!
//! Other values:
//!
//! | name | value | unit |
//! |---|---|---|
//! | `c_0` to `c_7`, `sc_0` to `sc_7` | estimated coefficients and their sigmas, in the model's order; a text says which effect each is | the effect's |
//! | `s_ref` | sigma of the reference altitude in captive flight | m |
//! | `i_gps` | innovation of the last fix that was used | m |
//! | `checks` | failed checks of the latched calibration, one bit each in the order of `kf_core::quality::Check` | 1 |
//! | `ticks` | ticks of the mission | 1 |
//! | `d_hb`, `d_sys`, `d_gps`, `d_att`, `d_imu`, `d_alt`, `d_nvf`, `d_text` | frames dropped so far, by message | 1 |
//!
//! Counts are whole numbers up to 2^24 and are rounded beyond.

use mavlink::types::CharArray;

use kf_core::launch::WireCondition;
use kf_core::output::Trust;
use kf_core::sensor::{SENSORS, Sensor};

use crate::link::MessageKind;

/// A name as in the message: shorter names are padded with zeros.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Name([u8; Name::LEN]);

impl Name {
    const LEN: usize = 10;

    /// The name with that text; more than ten letters do not compile in a constant.
    const fn new(text: &str) -> Self {
        let text = text.as_bytes();
        assert!(text.len() <= Self::LEN && !text.is_empty());
        let mut name = [0; Self::LEN];
        let mut k = 0;
        while k < text.len() {
            name[k] = text[k];
            k += 1;
        }
        Self(name)
    }

    /// The name as the message's field.
    #[must_use]
    pub const fn field(self) -> CharArray<10> {
        CharArray::new(self.0)
    }

    /// The name as text.
    #[must_use]
    pub fn text(&self) -> &str {
        let len = self.0.iter().position(|byte| *byte == 0).unwrap_or(Self::LEN);
        self.0.get(..len).and_then(|text| core::str::from_utf8(text).ok()).unwrap_or_default()
    }
}

macro_rules! names {
    ($($(#[$doc:meta])* $constant:ident = $text:literal,)*) => {
        $($(#[$doc])* pub const $constant: Name = const { Name::new($text) };)*
    };
}

names! {
    /// See the table.
    ALTITUDE_MASTER = "alt_master",
    /// See the table.
    ALTITUDE_SLAVE = "alt_slave",
    /// See the table.
    VELOCITY_DOWN = "gps_vd",
    /// See the table.
    TRUE_AIRSPEED = "tas",
    /// See the table.
    ANGLE_OF_ATTACK = "aoa",
    /// See the table.
    SIDESLIP = "sideslip",
    /// See the table.
    THROTTLE = "throttle",
    /// See the table.
    OUTSIDE_AIR = "oat",
    /// See the table.
    LAUNCH = "launch",
    /// See the table.
    REFERENCE_SIGMA = "s_ref",
    /// See the table.
    FIX_INNOVATION = "i_gps",
    /// See the table.
    FAILED_CHECKS = "checks",
    /// See the table.
    TICKS = "ticks",
    /// See the table.
    WIRE = "wire",
}

/// Names of one value, for every sensor in the order of [`Sensor`].
type OfSensors = [Name; SENSORS];

macro_rules! of_sensors {
    ($prefix:literal) => {
        const {
            [
                Name::new(concat!($prefix, "_master")),
                Name::new(concat!($prefix, "_slave")),
                Name::new(concat!($prefix, "_baro")),
            ]
        }
    };
}

/// `e_`.
pub const ERROR: OfSensors = of_sensors!("e");
/// `ma_`.
pub const MOVING_AVERAGE: OfSensors = of_sensors!("ma");
/// `tr_`.
pub const TRUST: OfSensors = of_sensors!("tr");
/// `b_`.
pub const BIAS: OfSensors = of_sensors!("b");
/// `sb_`.
pub const BIAS_SIGMA: OfSensors = of_sensors!("sb");
/// `sr_`.
pub const RESIDUAL_SIGMA: OfSensors = of_sensors!("sr");
/// `bd_`.
pub const BOUND: OfSensors = of_sensors!("bd");

macro_rules! numbered {
    ($prefix:literal) => {
        const {
            [
                Name::new(concat!($prefix, "_0")),
                Name::new(concat!($prefix, "_1")),
                Name::new(concat!($prefix, "_2")),
                Name::new(concat!($prefix, "_3")),
                Name::new(concat!($prefix, "_4")),
                Name::new(concat!($prefix, "_5")),
                Name::new(concat!($prefix, "_6")),
                Name::new(concat!($prefix, "_7")),
            ]
        }
    };
}

/// `c_`.
pub const COEFFICIENT: [Name; kf_core::config::MAX_ESTIMATED_EFFECTS] = numbered!("c");
/// `sc_`.
pub const COEFFICIENT_SIGMA: [Name; kf_core::config::MAX_ESTIMATED_EFFECTS] = numbered!("sc");

/// `d_`, in the order of [`MessageKind`].
pub const DROPPED: [Name; MessageKind::COUNT] = const {
    [
        Name::new("d_hb"),
        Name::new("d_sys"),
        Name::new("d_gps"),
        Name::new("d_att"),
        Name::new("d_imu"),
        Name::new("d_alt"),
        Name::new("d_nvf"),
        Name::new("d_text"),
    ]
};

/// The number for a trust.
#[must_use]
pub const fn trust_number(trust: Trust) -> f32 {
    match trust {
        Trust::Calibrating => 0.0,
        Trust::Trusted => 1.0,
        Trust::Doubtful => 2.0,
        Trust::Untrustworthy => 3.0,
        Trust::Unmonitored => 4.0,
    }
}

/// The number for the condition of the umbilical's wire.
#[must_use]
pub const fn wire_number(wire: WireCondition) -> f32 {
    match wire {
        WireCondition::Closed => 0.0,
        WireCondition::Open => 1.0,
        WireCondition::Broken => 2.0,
        WireCondition::Unreadable => 3.0,
    }
}

/// The name of a sensor's value.
pub(crate) fn of(names: &OfSensors, sensor: Sensor) -> Name {
    let [master, slave, baro] = *names;
    match sensor {
        Sensor::ImuMaster => master,
        Sensor::ImuSlave => slave,
        Sensor::Baro => baro,
    }
}
