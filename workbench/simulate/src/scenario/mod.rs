//! A scenario: the TOML file that states what is flown, with which sensors and which errors.
//!
//! Every key has the unit in its name. A missing key has the default given here; an unknown key is an error.

mod check;
mod effect;
mod plan;
mod problem;
mod read;
mod sensors;
mod vehicle;

use serde::Deserialize;

pub use effect::{Effect, EffectId, InjectionPhase};
pub use plan::{Manoeuvre, Segment};
pub use problem::{Expected, ScenarioProblem};
pub use read::ScenarioError;
pub use sensors::{
    AirData, AltitudeSensor, AttitudeSensor, Barometer, BarometerTemperature, CarrierFlow, ColdStart, Gps,
    Inertial, Interval, Noise, Sampling, Sensors,
};
pub use vehicle::{Airframe, Vehicle};

/// Everything that is simulated.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scenario {
    /// Name of the flight.
    pub name: String,
    /// Description of the flight for its `source` line; it must not reveal the injected effects.
    #[serde(default = "default_source")]
    pub source: String,
    /// Seed of every random number.
    #[serde(default = "default_seed")]
    pub seed: u64,
    /// Rows a second; no sensor may be faster.
    #[serde(default = "default_rate_hz")]
    pub rate_hz: f64,
    /// Latitude, degrees; only the Eotvos effect needs it.
    #[serde(default = "default_latitude_deg")]
    pub latitude_deg: f64,
    /// The UAV.
    #[serde(default)]
    pub vehicle: Vehicle,
    /// The mother ship.
    #[serde(default)]
    pub carrier: Airframe,
    /// The atmosphere of the day.
    #[serde(default)]
    pub atmosphere: Atmosphere,
    /// The steady wind.
    #[serde(default)]
    pub wind: Wind,
    /// The gusts.
    #[serde(default)]
    pub turbulence: Turbulence,
    /// Flight under the mother ship's pylon; launch is at its end.
    pub captive: Captive,
    /// What the UAV flies after launch; without a segment it is never launched.
    #[serde(default)]
    pub free_flight: Vec<Segment>,
    /// The sensors.
    #[serde(default)]
    pub sensors: Sensors,
    /// The injected effects.
    #[serde(default)]
    pub effect: Vec<Effect>,
}

fn default_source() -> String {
    "simulated".to_owned()
}

const fn default_seed() -> u64 {
    1
}

const fn default_rate_hz() -> f64 {
    200.0
}

const fn default_latitude_deg() -> f64 {
    45.0
}

impl Scenario {
    /// Length of the flight, s.
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        self.captive.duration_s + self.free_flight.iter().map(|segment| segment.duration_s).sum::<f64>()
    }

    /// Time of launch, s; `None` when the UAV stays under the pylon.
    #[must_use]
    pub fn launch_s(&self) -> Option<f64> {
        (!self.free_flight.is_empty()).then_some(self.captive.duration_s)
    }
}

/// The atmosphere of the day: the standard one (ICAO Doc 7488) unless stated otherwise.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Atmosphere {
    /// Excess over the standard temperature at every pressure level, degrees Celsius.
    pub temperature_offset_c: f64,
    /// Pressure at mean sea level, Pa.
    pub sea_level_pressure_pa: f64,
}

impl Default for Atmosphere {
    fn default() -> Self {
        Self { temperature_offset_c: 0.0, sea_level_pressure_pa: 101_325.0 }
    }
}

/// The steady wind (the direction the air moves to) and its change with altitude.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Wind {
    /// Northward, at the captive altitude, m/s.
    pub north_mps: f64,
    /// Eastward, at the captive altitude, m/s.
    pub east_mps: f64,
    /// Change of the northward wind with altitude, 1/s.
    pub shear_north_per_s: f64,
    /// Change of the eastward wind with altitude, 1/s.
    pub shear_east_per_s: f64,
}

/// Gusts: first-order Gauss-Markov in each axis, frozen in the air mass (Dryden's longitudinal form,
/// MIL-HDBK-1797, in all three axes).
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Turbulence {
    /// Spread of the north and of the east gust (1 sigma), m/s.
    pub horizontal_sigma_mps: f64,
    /// Spread of the vertical gust (1 sigma), m/s.
    pub vertical_sigma_mps: f64,
    /// Scale length, m; the correlation time is this over the airspeed.
    pub length_m: f64,
}

impl Default for Turbulence {
    fn default() -> Self {
        Self { horizontal_sigma_mps: 0.0, vertical_sigma_mps: 0.0, length_m: 300.0 }
    }
}

/// Captive flight: the mother ship holds altitude, airspeed and heading, and swings in its phugoid.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Captive {
    /// Duration, s; launch is at its end.
    pub duration_s: f64,
    /// Altitude, m.
    pub altitude_m: f64,
    /// True airspeed, m/s.
    pub airspeed_mps: f64,
    /// Heading, degrees.
    #[serde(default)]
    pub heading_deg: f64,
    /// Amplitude of the phugoid's altitude, m.
    #[serde(default)]
    pub phugoid_amplitude_m: f64,
    /// Period of the phugoid, s.
    #[serde(default = "default_phugoid_period_s")]
    pub phugoid_period_s: f64,
    /// First part, in which the disturbed flow is stronger (each sensor's `settling_factor`), s.
    #[serde(default)]
    pub settling_s: f64,
    /// Throttle of the UAV's own engine under the pylon, 0 to 1.
    #[serde(default)]
    pub uav_throttle: f64,
}

const fn default_phugoid_period_s() -> f64 {
    40.0
}
