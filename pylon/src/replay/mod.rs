//! A flight through the estimator: the same ticks, in the same order, as the flight computer gets.
//!
//! Where the captive flight ends is decided here: by the flight's `launch` column, or, for flights that
//! have none, by a window given by the user or found in the flight ([`quiet`]). With a window, rows before
//! it are skipped, launch is said at its end, and nothing is ignored as settling.

mod error;
mod inputs;
mod mission;
pub mod quiet;
mod window;

use std::fmt;

use kf_core::input::TickInput;
use kf_core::latch::LatchRecord;
use kf_core::mission::Counters;
use kf_core::navigation::NavigationCounts;
use kf_core::output::TickOutput;
use kf_core::strapdown;
use model::Model;

use crate::flight::{Channel, Flight};

pub use error::ReplayError;
pub use inputs::{InputCounters, TickInputs};
pub use mission::{AnyMission, mission};
pub use quiet::QuietStretch;
pub use window::{CalibrationWindow, WindowError};

/// What decided when the captive flight ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CalibrationSource {
    /// The flight's `launch` column.
    LaunchColumn,
    /// A window that the user gave.
    Given(CalibrationWindow),
    /// The flight's first quiet stretch.
    Quiet(QuietStretch),
    /// Nothing: the whole flight is free flight, from its first row on.
    Uncalibrated(CalibrationWindow),
}

impl CalibrationSource {
    /// The window, if there is one.
    #[must_use]
    pub const fn window(&self) -> Option<CalibrationWindow> {
        match self {
            Self::LaunchColumn => None,
            Self::Given(window) | Self::Uncalibrated(window) => Some(*window),
            Self::Quiet(stretch) => Some(stretch.window),
        }
    }
}

impl fmt::Display for CalibrationSource {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::LaunchColumn => write!(formatter, "captive flight until the launch column says 1"),
            Self::Given(window) => write!(formatter, "calibrated on {window}, as given"),
            Self::Quiet(stretch) => write!(formatter, "calibrated on {stretch}"),
            Self::Uncalibrated(_) => {
                write!(
                    formatter,
                    "no launch column and no quiet stretch: not calibrated, all of it taken as one"
                )
            }
        }
    }
}

/// A flight, a model and where the one calibrates on the other, ready to run.
#[derive(Clone, Debug)]
pub struct Replay<'a> {
    flight: &'a Flight,
    model: Model,
    source: CalibrationSource,
}

/// What a replay left behind.
#[derive(Clone, Debug, PartialEq)]
pub struct ReplaySummary {
    /// Rows before the calibration window, which the estimator never saw.
    pub skipped_rows: usize,
    /// What could not be made into a tick's input.
    pub inputs: InputCounters,
    /// What the estimator counted: ignored ticks, samples that are not finite, held fixes, and so on.
    pub counters: Counters,
    /// What was counted where the strapdown channel made the UAV's inertial altitude; `None` where it did not.
    pub inertial_altitude: Option<(NavigationCounts, strapdown::Counts)>,
    /// The latched calibration, if there was a launch.
    pub latch: Option<LatchRecord>,
}

impl ReplaySummary {
    /// Ticks ignored because their time was not after the last one's.
    #[must_use]
    pub const fn ignored_rows(&self) -> u32 {
        self.counters.out_of_order
    }

    /// Samples that were not finite, or a pressure that is none.
    #[must_use]
    pub fn not_finite_samples(&self) -> u32 {
        let sensors = self.counters.sensors.iter().map(|sensor| sensor.not_finite);
        sensors.fold(
            self.counters.gps.not_finite.saturating_add(self.counters.signals_not_finite),
            u32::saturating_add,
        )
    }

    /// Fixes that were the last one, held.
    #[must_use]
    pub const fn held_fixes(&self) -> u32 {
        self.counters.gps.held
    }
}

impl<'a> Replay<'a> {
    /// Decides where the flight calibrates: on `window` if given, else up to launch by the `launch`
    /// column, else on the first quiet stretch.
    ///
    /// # Errors
    /// A flight without reference or second altitude, a window outside the flight, or no launch
    /// column and no quiet stretch.
    pub fn new(
        flight: &'a Flight,
        model: &Model,
        window: Option<CalibrationWindow>,
    ) -> Result<Self, ReplayError> {
        flight.require_altitudes()?;
        let has_launch =
            flight.channel(Channel::Launch).is_some_and(|launch| launch.samples().next().is_some());
        let source = match window {
            Some(window) => {
                window.check(flight)?;
                CalibrationSource::Given(window)
            }
            None if has_launch => CalibrationSource::LaunchColumn,
            None => CalibrationSource::Quiet(quiet::find(flight, &model.quality)?),
        };
        let mut model = model.clone();
        if source.window().is_some() {
            model.settling_s = 0.0;
        }
        model.latitude_deg = latitude_deg(flight)?.unwrap_or(model.latitude_deg);
        Ok(Self { flight, model, source })
    }

    /// A flight without captive flight: launch is at its first row. What needs no calibration, such as a
    /// diagnosis, can work on it.
    ///
    /// # Errors
    /// A flight without reference or second altitude, or a header's latitude that is none.
    pub fn uncalibrated(flight: &'a Flight, model: &Model) -> Result<Self, ReplayError> {
        flight.require_altitudes()?;
        let first_s = flight.time_s.first().copied().unwrap_or(0.0);
        let window = CalibrationWindow { start_s: first_s, end_s: first_s };
        let mut model = model.clone();
        model.latitude_deg = latitude_deg(flight)?.unwrap_or(model.latitude_deg);
        model.settling_s = 0.0;
        Ok(Self { flight, model, source: CalibrationSource::Uncalibrated(window) })
    }

    /// As [`Self::new`], but a flight that has nothing to calibrate on is taken as it is, by
    /// [`Self::uncalibrated`].
    ///
    /// # Errors
    /// As those of both, but for a flight that is nowhere quiet.
    pub fn calibrated_or_not(
        flight: &'a Flight,
        model: &Model,
        window: Option<CalibrationWindow>,
    ) -> Result<Self, ReplayError> {
        match Self::new(flight, model, window) {
            Err(ReplayError::NoQuietStretch { .. }) => Self::uncalibrated(flight, model),
            other => other,
        }
    }

    /// Whether there is anything to calibrate on.
    #[must_use]
    pub const fn is_calibrated(&self) -> bool {
        !matches!(self.source, CalibrationSource::Uncalibrated(_))
    }

    /// The flight.
    #[must_use]
    pub const fn flight(&self) -> &'a Flight {
        self.flight
    }

    /// The model as flown: without settling time where a window was given or found, and at the flight's
    /// own latitude where its header says one.
    #[must_use]
    pub const fn model(&self) -> &Model {
        &self.model
    }

    /// What decided when the captive flight ends.
    #[must_use]
    pub const fn source(&self) -> &CalibrationSource {
        &self.source
    }

    /// The ticks as the mission gets them: [`Self::inputs`], and where the flight has accelerometer and gyro at 50 Hz or more
    /// but no `imu_slave_alt_m`, the altitude that the flight computer makes of them.
    #[must_use]
    pub fn mission_inputs(&self) -> TickInputs<'a> {
        self.inputs().with_inertial_altitude()
    }

    /// The ticks as the sensors' own, one a row from the calibration window on.
    #[must_use]
    pub fn inputs(&self) -> TickInputs<'a> {
        TickInputs::new(self.flight, self.source.window())
    }

    /// Runs the flight through a new mission and shows every tick to `on_tick`; memory does not grow
    /// with the flight.
    ///
    /// # Errors
    /// [`ReplayError::Model`] or [`ReplayError::Config`] for a model that no mission can be made of.
    pub fn run(
        &self,
        on_tick: &mut dyn FnMut(&TickInput, &TickOutput),
    ) -> Result<ReplaySummary, ReplayError> {
        let mut mission = mission(&self.model)?;
        let mut inputs = self.mission_inputs();
        for input in inputs.by_ref() {
            let output = mission.tick(&input);
            on_tick(&input, &output);
        }
        Ok(ReplaySummary {
            skipped_rows: inputs.skipped_rows(),
            inputs: *inputs.counters(),
            counters: *mission.counters(),
            inertial_altitude: inputs
                .inertial_altitude()
                .map(|made| (*made.counts(), made.channel().counts())),
            latch: mission.latch().cloned(),
        })
    }
}

/// The header's free key `latitude_deg`, if there is one.
fn latitude_deg(flight: &Flight) -> Result<Option<f32>, ReplayError> {
    let Some((_, text)) = flight.header.other.iter().find(|(key, _)| key == "latitude_deg") else {
        return Ok(None);
    };
    match text.trim().parse::<f32>() {
        Ok(latitude_deg) if (-90.0..=90.0).contains(&latitude_deg) => Ok(Some(latitude_deg)),
        _ => Err(ReplayError::Latitude(text.clone())),
    }
}

#[cfg(test)]
mod tests;
