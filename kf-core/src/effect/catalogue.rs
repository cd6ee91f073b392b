//! The catalogue of effects. A new effect is one row (beside its formula in the file of its family) and one
//! line in the list at this file's end.

use serde::{Deserialize, Serialize};

use super::definition::{Defined, Parts, definition_of};
use super::tracker::SignalTracker;
use super::{Regressor, barometer, inertial_altitude, reference};
use crate::sensor::Sensor;

/// What an effect acts on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum EffectSubject {
    /// The reference's altitude; it shows in every sensor's residual at once, with the opposite sign.
    Gps,
    /// One sensor's altitude.
    Sensor(Sensor),
}

impl EffectSubject {
    /// The name used in files and reports: `gps`, or the sensor's.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Gps => "gps",
            Self::Sensor(sensor) => sensor.name(),
        }
    }
}

/// Signals that a row's formula reads, so that the tracker can skip those that no effect of a model reads.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Uses(pub u16);

impl Uses {
    pub(crate) const NOTHING: Self = Self(0);
    pub(crate) const ANGLE_OF_ATTACK: Self = Self(1);
    pub(crate) const SIDESLIP: Self = Self(1 << 1);
    pub(crate) const THROTTLE: Self = Self(1 << 2);
    pub(crate) const BARO_TEMPERATURE: Self = Self(1 << 3);
    pub(crate) const LOAD_FACTOR: Self = Self(1 << 4);
    pub(crate) const ATTITUDE: Self = Self(1 << 5);
    pub(crate) const VERTICAL: Self = Self(1 << 6);
    pub(crate) const FORWARD: Self = Self(1 << 7);
    pub(crate) const VIBRATION: Self = Self(1 << 8);
    pub(crate) const GRAVITY: Self = Self(1 << 9);
    pub(crate) const EOTVOS: Self = Self(1 << 10);
    /// Height or climb rate.
    pub(crate) const HEIGHT: Self = Self(1 << 11);
    /// Everything that is integrated from launch on, except the vibration.
    pub(crate) const INTEGRATED: Self =
        Self::VERTICAL.and(Self::FORWARD).and(Self::GRAVITY).and(Self::EOTVOS);
    pub(crate) const EVERYTHING: Self = Self(u16::MAX);

    pub(crate) const fn and(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    pub(crate) const fn any_of(self, other: Self) -> bool {
        self.0 & other.0 != 0
    }
}

/// One row of the catalogue.
pub(super) struct Row {
    pub name: &'static str,
    pub unit: &'static str,
    pub subject: EffectSubject,
    /// Columns of a flight that the regressor needs.
    pub needs: &'static [&'static str],
    pub uses: Uses,
    pub plausible: [f32; 2],
    pub typical_regressor_m: f32,
    pub has_time_constant: bool,
    /// Present regressor, metres per unit of coefficient; `None` while a signal has not been seen.
    pub value: fn(&SignalTracker, &Regressor) -> Option<f32>,
}

macro_rules! catalogue {
    ($($(#[$doc:meta])* $variant:ident = $row:path;)*) => {
        /// An effect: one of the catalogue, or a model's own.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
        #[non_exhaustive]
        pub enum EffectId {
            $($(#[$doc])* $variant,)*
            /// An effect by formula, defined by a model.
            Defined(Defined),
        }

        impl EffectId {
            /// Every effect of the catalogue.
            pub const ALL: [Self; [$(Self::$variant),*].len()] = [$(Self::$variant),*];

            pub(super) const fn row(self) -> &'static Row {
                match self {
                    $(Self::$variant => &$row,)*
                    Self::Defined(defined) => &definition_of(defined).row,
                }
            }
        }
    };
}

impl EffectId {
    /// The id used in model files and on the command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        self.row().name
    }

    /// Unit of the coefficient.
    #[must_use]
    pub const fn unit(self) -> &'static str {
        self.row().unit
    }

    /// What the effect acts on.
    #[must_use]
    pub const fn subject(self) -> EffectSubject {
        self.row().subject
    }

    /// Whether the effect acts on that sensor.
    #[must_use]
    pub const fn acts_on(self, sensor: Sensor) -> bool {
        match self.subject() {
            EffectSubject::Gps => false,
            EffectSubject::Sensor(own) => own.index() == sensor.index(),
        }
    }

    /// Columns of a flight that the regressor needs. Airspeed and forward acceleration have stand-ins
    /// ([`SignalTracker::airspeed_source`], [`SignalTracker::acceleration_source`]); whether a flight has
    /// enough is decided by [`SignalTracker::regressor_m`].
    #[must_use]
    pub const fn needs(self) -> &'static [&'static str] {
        self.row().needs
    }

    /// Range of the coefficient in nature, in [`Self::unit`]; the source is given with each effect.
    #[must_use]
    pub const fn plausible(self) -> [f32; 2] {
        self.row().plausible
    }

    /// A power of two near the regressor's size in flight (metres): the coefficient's state is kept in units
    /// of its inverse, so that all states of the filter are of the same order.
    #[must_use]
    pub const fn typical_regressor_m(self) -> f32 {
        self.row().typical_regressor_m
    }

    /// Whether the effect uses [`Regressor::time_constant_s`] and [`Regressor::since`].
    #[must_use]
    pub const fn has_time_constant(self) -> bool {
        self.row().has_time_constant
    }

    /// Parts of an effect by formula; `None` for one of the catalogue.
    #[must_use]
    pub const fn formula(self) -> Option<&'static Parts> {
        match self {
            Self::Defined(defined) => Some(definition_of(defined).parts()),
            _ => None,
        }
    }

    /// The catalogue's effect with that id, or `None`.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|effect| effect.name() == name)
    }
}

catalogue! {
    /// `V^2 / (2 g)`: the static port reads a part of the dynamic pressure.
    BaroDynamicPressure = barometer::DYNAMIC_PRESSURE;
    /// `V_latch^2 / (2 g)` after launch, 0 before: the mother ship's pressure field, gone at release.
    BaroCarrierField = barometer::CARRIER_FIELD;
    /// `aoa V^2 / (2 g)`: the port's pressure coefficient changes with the angle of attack.
    BaroAngleOfAttack = barometer::ANGLE_OF_ATTACK;
    /// `sideslip^2 V^2 / (2 g)`: the same with sideslip, for ports on both sides.
    BaroSideslip = barometer::SIDESLIP;
    /// `-hdot`: the lag of tubing and sensor.
    BaroLag = barometer::LAG;
    /// `h - h0`: scale factor, or air that is not the standard one.
    BaroScale = barometer::SCALE;
    /// `T - T0`: temperature of the sensor.
    BaroTemperature = barometer::TEMPERATURE;
    /// `1 - exp(-t / tau)`: the sensor warms up.
    BaroWarmUp = barometer::WARM_UP;
    /// `t`: weather.
    BaroDrift = barometer::DRIFT;
    /// `n_z - 1`: the sensor's membrane feels acceleration.
    BaroAcceleration = barometer::ACCELERATION;
    /// `throttle^2`: the propeller's slipstream at the port.
    BaroPropwash = barometer::PROPWASH;
    /// `t`: error of the vertical velocity at release.
    ImuVelocityError = inertial_altitude::VELOCITY_ERROR;
    /// `t^2 / 2`: bias of the vertical accelerometer.
    ImuAccelBias = inertial_altitude::ACCEL_BIAS;
    /// Double integral of (upward specific force - g): scale factor of the vertical accelerometer.
    ImuAccelScale = inertial_altitude::ACCEL_SCALE;
    /// Double integral of the forward horizontal acceleration: a pitch error.
    ImuTilt = inertial_altitude::TILT;
    /// Double integral of the forward horizontal acceleration times `t`: a growing pitch error.
    ImuGyroBias = inertial_altitude::GYRO_BIAS;
    /// Double integral of the specific force's short-term variance: vibration rectification.
    ImuVibration = inertial_altitude::VIBRATION;
    /// Double integral of `3.086e-6 (h - h0)`: gravity falls with height.
    ImuGravityGradient = inertial_altitude::GRAVITY_GRADIENT;
    /// Double integral of `2 Omega v_E cos(lat) + v^2 / R`: motion over a turning, round earth.
    ImuEotvos = inertial_altitude::EOTVOS;
    /// `-hdot` on the reference: a receiver that is late.
    GpsLatency = reference::LATENCY;
    /// `exp(-t / tau)` on the reference: a receiver that settles.
    GpsConvergence = reference::CONVERGENCE;
    /// `sin(pitch)` on the reference: the antenna is ahead of the sensors.
    GpsLeverArm = reference::LEVER_ARM;
}
