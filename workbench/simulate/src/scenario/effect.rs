//! The injected effects: causes that add `coefficient * regressor` metres to a sensor's reading.

use serde::{Deserialize, Serialize};

macro_rules! effects {
    ($($(#[$doc:meta])* $variant:ident = $name:literal, $unit:literal;)*) => {
        /// An effect that can be injected: those of DESIGN.md's catalogue, and one that is not in it.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
        pub enum EffectId {
            $($(#[$doc])* #[serde(rename = $name)] $variant,)*
        }

        impl EffectId {
            /// Every effect that can be injected.
            pub const ALL: &'static [Self] = &[$(Self::$variant,)*];

            /// The name in a scenario.
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self { $(Self::$variant => $name,)* }
            }

            /// The unit of the coefficient.
            #[must_use]
            pub const fn unit(self) -> &'static str {
                match self { $(Self::$variant => $unit,)* }
            }
        }
    };
}

effects! {
    /// `V^2 / (2 g)`: the static port reads a part of the dynamic pressure.
    BaroDynamicPressure = "baro.dynamic_pressure", "1";
    /// `V_latch^2 / (2 g)` after launch, 0 before: the mother ship's pressure field, gone at release.
    BaroCarrierField = "baro.carrier_field", "1";
    /// `aoa V^2 / (2 g)`.
    BaroAngleOfAttack = "baro.angle_of_attack", "1/rad";
    /// `sideslip^2 V^2 / (2 g)`.
    BaroSideslip = "baro.sideslip", "1/rad^2";
    /// `-hdot`: the tubing's lag.
    BaroLag = "baro.lag", "s";
    /// `h - h0`.
    BaroScale = "baro.scale", "1";
    /// `T - T0` of the sensor.
    BaroTemperature = "baro.temperature", "m/K";
    /// `1 - exp(-t / tau)`; needs `time_constant_s`.
    BaroWarmUp = "baro.warm_up", "m";
    /// `t`: weather.
    BaroDrift = "baro.drift", "m/s";
    /// `n_z - 1`.
    BaroAcceleration = "baro.acceleration", "m";
    /// `throttle^2`.
    BaroPropwash = "baro.propwash", "m";
    /// Not in the catalogue: the sensor's elastic hysteresis, a play operator of half width `width_m` on the
    /// altitude, divided by that width (-1 to 1, with the sign opposite to the last large motion).
    BaroHysteresis = "baro.hysteresis", "m";
    /// `t`.
    ImuVelocityError = "imu.velocity_error", "m/s";
    /// `t^2 / 2`.
    ImuAccelBias = "imu.accel_bias", "m/s^2";
    /// Double integral of (upward specific force - g).
    ImuAccelScale = "imu.accel_scale", "1";
    /// Double integral of the horizontal acceleration along the heading.
    ImuTilt = "imu.tilt", "rad";
    /// Double integral of the horizontal acceleration along the heading times t.
    ImuGyroBias = "imu.gyro_bias", "rad/s";
    /// Double integral of the vibration's variance, summed over the body axes.
    ImuVibration = "imu.vibration", "s^2/m";
    /// Double integral of `3.086e-6 (h - h0)`.
    ImuGravityGradient = "imu.gravity_gradient", "1";
    /// Double integral of `2 Omega v_E cos(lat) + v^2 / R`, v horizontal.
    ImuEotvos = "imu.eotvos", "1";
    /// `-hdot` on the reference.
    GpsLatency = "gps.latency", "s";
    /// `exp(-t / tau)` on the reference; needs `time_constant_s`.
    GpsConvergence = "gps.convergence", "m";
    /// `sin(pitch)` on the reference.
    GpsLeverArm = "gps.lever_arm", "m";
}

/// The phase in which an effect acts.
///
/// Its clock `t` and its integrals start with the phase: at launch for `free`, at the first row for `captive`
/// and `both`. `h0` and `T0` are always the values at the first row. The flight computer takes those with
/// which its calibration begins, some seconds later, after its settling time. `V_latch` is the airspeed at
/// launch (or at the first row of a flight without one).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum InjectionPhase {
    /// Under the pylon only.
    Captive,
    /// After launch only.
    Free,
    /// Always.
    #[default]
    Both,
}

/// One injected effect.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Effect {
    /// Which effect.
    pub id: EffectId,
    /// Its coefficient, in [`EffectId::unit`].
    pub coefficient: f64,
    /// When it acts.
    #[serde(default)]
    pub phase: InjectionPhase,
    /// Time constant of `baro.warm_up` and `gps.convergence`, s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub time_constant_s: Option<f64>,
    /// Half width of `baro.hysteresis`, m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub width_m: Option<f64>,
}
