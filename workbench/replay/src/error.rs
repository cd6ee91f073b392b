//! Why a flight cannot be replayed.

use kf_core::estimator::ConfigError;
use model::ModelError;
use thiserror::Error;

use super::barometer::Fault;
use super::given::AirborneError;
use super::quiet::Calmest;
use super::window::WindowError;
use flight_data::{AltitudeDatum, CsvProblem};

/// Why a flight cannot be replayed; displayed as one line, without the flight's name.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ReplayError {
    /// The flight lacks what every comparison needs.
    #[error(transparent)]
    Flight(#[from] CsvProblem),
    /// The barometer's column was not measured by a working barometer, and there is no other altitude.
    #[error("{}; there is no other altitude to compare with the receiver's", .0.sentence())]
    NoBarometer(Fault),
    /// An altitude has another datum than the reference.
    #[error(
        "{column} is measured {} and gps_alt_m {}, which differ by the geoid's height above the ellipsoid (up to 107 m): \
         'pylon import FLIGHT --to-msl {}=GEOID_HEIGHT -o CORRECTED' converts it, with the metres by which the geoid is above the \
         ellipsoid there",
        own.words(), reference.words(), if *own == AltitudeDatum::Ellipsoid { column } else { "gps_alt_m" }
    )]
    MixedDatums {
        /// The altitude's column.
        column: &'static str,
        /// Its datum.
        own: AltitudeDatum,
        /// The reference's datum.
        reference: AltitudeDatum,
    },
    /// The calibration window does not fit the flight.
    #[error(transparent)]
    Window(#[from] WindowError),
    /// The given take-off and landing do not fit the flight.
    #[error(transparent)]
    Airborne(#[from] AirborneError),
    /// The header's latitude is invalid.
    #[error("latitude_deg in the header is '{0}', expected degrees from -90 to 90")]
    Latitude(String),
    /// The flight does not record its launch and has no quiet stretch.
    #[error("no launch column and no quiet stretch of {wanted_s:.0} s to calibrate on{}; give one by --calibrate START..END (seconds)", hint(.calmest.as_ref()))]
    NoQuietStretch {
        /// Required length, seconds.
        wanted_s: f64,
        /// The stretch that comes nearest to it.
        calmest: Option<Calmest>,
    },
    /// The flight does not record its launch and is shorter than any calibration.
    #[error(
        "too short to be used: {found_s:.0} s of flight, expected at least {wanted_s:.0} s, to calibrate the sensors' \
         biases"
    )]
    TooShort {
        /// Its length, seconds.
        found_s: f64,
        /// Required length, seconds.
        wanted_s: f64,
    },
    /// The model is not valid.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// The estimator refuses the model's numbers.
    #[error("the estimator refuses the model: {0}")]
    Config(&'static str),
}

fn hint(found: Option<&Calmest>) -> String {
    found.map_or_else(String::new, |Calmest { window, altitude_range_m, speed_range_mps }| {
        format!(
            " (the calmest is {window}, where altitude varies by {altitude_range_m:.1} m and speed by \
             {speed_range_mps:.1} m/s)"
        )
    })
}

impl From<ConfigError> for ReplayError {
    fn from(error: ConfigError) -> Self {
        Self::Config(match error {
            ConfigError::Shape => "its states do not fit the filter's shape",
            ConfigError::ClimbRateNeedsDenseFilter => "a climb rate needs a filter without head states",
            ConfigError::OutOfRange => "a number is out of the range that f32 arithmetic can hold",
        })
    }
}
