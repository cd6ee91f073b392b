//! Runs a flight through the estimator: the same ticks, in the same order, as the flight computer gets.
//!
//! This crate decides where the captive flight ends: by the flight's `launch` column or, without one, by a
//! window that the user gives or that is found in the flight ([`quiet`]). With a window, rows before it are
//! skipped, launch is set at its end, and nothing is ignored as settling. For a flight without a `launch`
//! column, what follows its landing is also left out, and of several flights in one log all but one
//! ([`Extent`]).

pub mod airborne;
pub mod barometer;
mod effect_columns;
mod error;
mod extent;
mod given;
mod inputs;
mod mission;
mod pairs;
mod pass;
pub mod quiet;
mod reading;
pub mod scatter;
pub mod steps;
mod usage;
mod wild;
mod window;

use std::fmt;
use std::sync::Arc;

use kf_core::input::TickInput;
use kf_core::latch::LatchRecord;
use kf_core::mission::Counters;
use kf_core::navigation::NavigationCounts;
use kf_core::output::TickOutput;
use kf_core::strapdown;
use model::Model;

use flight_data::{AltitudeDatum, Channel, Column, Flight};

pub use effect_columns::{column_notes, missing_columns};
pub use error::ReplayError;
pub use extent::{Extent, Unused};
pub use given::{AirborneError, GivenAirborne, GivenTimes};
pub use inputs::{InputCounters, TickInputs};
pub use mission::{AnyMission, mission};
pub use pass::{Flown, Observer, passes_begun};
pub use quiet::{Calmest, Place, QuietStretch};
pub use reading::reading_m;
pub use usage::{Usage, clock};
pub use wild::WildCells;
pub use window::{CalibrationWindow, WindowError};

/// What decided when the captive flight ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CalibrationSource {
    /// The flight's `launch` column.
    LaunchColumn,
    /// A window that the user gave.
    Given(CalibrationWindow),
    /// The ground before the take-off, or the flight's first quiet stretch.
    Quiet(QuietStretch),
    /// The calmest part of a flight that has no quiet stretch.
    Calmest(Calmest),
    /// None: the whole flight is free flight, from its first row on.
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
            Self::Calmest(calmest) => Some(calmest.window),
        }
    }
}

impl fmt::Display for CalibrationSource {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::LaunchColumn => write!(formatter, "captive flight until the launch column is 1"),
            Self::Given(window) => {
                write!(formatter, "calibrated on {window} of the flight's own clock, as given")
            }
            Self::Quiet(stretch) => write!(formatter, "calibrated on {stretch}"),
            Self::Calmest(Calmest {
                window: CalibrationWindow { start_s, end_s }, altitude_range_m, ..
            }) => write!(
                formatter,
                "calibrated on the calmest stretch, as none is quiet, {start_s:.1}..{end_s:.1} s (altitude varies by \
                 {altitude_range_m:.0} m); --calibrate START..END chooses another"
            ),
            Self::Uncalibrated(_) => {
                write!(
                    formatter,
                    "not calibrated: the biases are estimated with everything else, on all of the flight"
                )
            }
        }
    }
}

/// A flight, a model and where the flight is calibrated, ready to run.
#[derive(Clone, Debug)]
pub struct Replay<'a> {
    flight: &'a Flight,
    model: Model,
    source: CalibrationSource,
    extent: Extent,
    has_barometer: bool,
    /// Columns that replace the flight's own, because of wild cells.
    tamed: Vec<(Channel, Arc<Column>)>,
    wild: Vec<WildCells>,
}

/// Counts of a flight's rows in a pass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InputSummary {
    /// Rows before the calibration window, which the estimator never saw.
    pub skipped_rows: usize,
    /// Rows after the landing, which the estimator never saw either.
    pub rows_after: usize,
    /// What could not be made into a tick's input.
    pub counters: InputCounters,
    /// Counts of the strapdown channel that made the UAV's inertial altitude; `None` where it did not.
    pub inertial_altitude: Option<(NavigationCounts, strapdown::Counts)>,
}

/// Result of a replay.
#[derive(Clone, Debug, PartialEq)]
pub struct ReplaySummary {
    /// Counts of the flight's rows.
    pub inputs: InputSummary,
    /// What the estimator counted: ignored ticks, samples that are not finite, held fixes, and so on.
    pub counters: Counters,
    /// The latched calibration, if there was a launch.
    pub latch: Option<LatchRecord>,
}

impl ReplaySummary {
    /// Ticks ignored because their time was not after the last one's.
    #[must_use]
    pub const fn ignored_rows(&self) -> u32 {
        self.counters.out_of_order
    }

    /// Samples that were not finite, or an invalid pressure.
    #[must_use]
    pub fn not_finite_samples(&self) -> u32 {
        let sensors = self.counters.sensors.iter().map(|sensor| sensor.not_finite);
        sensors.fold(
            self.counters.gps.not_finite.saturating_add(self.counters.signals_not_finite),
            u32::saturating_add,
        )
    }

    /// Fixes that were held, repeating the last one.
    #[must_use]
    pub const fn held_fixes(&self) -> u32 {
        self.counters.gps.held
    }
}

impl<'a> Replay<'a> {
    /// Decides where the flight is calibrated: in a given window, else up to launch by the `launch` column,
    /// else on the ground before the take-off, in the first quiet stretch of the flight or, without one, in
    /// the calmest.
    ///
    /// # Errors
    /// A flight without reference or second altitude, or with a stuck barometer or a copy of the receiver's
    /// altitude in its place, altitudes of several datums, a window outside the flight or after its landing,
    /// an invalid take-off and landing, or no launch column and nothing to calibrate on.
    pub fn new(flight: &'a Flight, model: &Model, given: impl Into<GivenTimes>) -> Result<Self, ReplayError> {
        let given = given.into();
        let has_barometer = has_barometer(flight)?;
        let has_launch = has_launch(flight);
        let window = given.calibration;
        if let Some(window) = window {
            window.check(flight)?;
        }
        let extent = extent(flight, given)?;
        let source = match window {
            Some(window) => CalibrationSource::Given(window),
            None if has_launch => CalibrationSource::LaunchColumn,
            None => quiet_or_calmest(flight, model, &extent)?,
        };
        let model = as_flown(model, flight, &source)?;
        Ok(Self { flight, model, source, extent, has_barometer, tamed: Vec::new(), wild: Vec::new() })
    }

    /// The same part of the flight with another model. `None` for a model that may be calibrated elsewhere,
    /// because its limits on calibration quality differ, or that reads other columns.
    #[must_use]
    pub fn by_model(&self, model: &Model) -> Option<Self> {
        if model.quality != self.model.quality || model.columns() != self.model.columns() {
            return None;
        }
        Some(Self { model: as_flown(model, self.flight, &self.source).ok()?, ..self.clone() })
    }

    /// Whether another replay gives a mission the same ticks, to the bit, apart from an inertial altitude
    /// that the flight computer makes.
    #[must_use]
    pub fn has_ticks_of(&self, other: &Self) -> bool {
        let is_tame = self.tamed.is_empty() && other.tamed.is_empty();
        is_tame
            && std::ptr::eq(self.flight, other.flight)
            && self.source.window() == other.source.window()
            && self.end_row() == other.end_row()
            && self.has_barometer == other.has_barometer
            && self.model.columns() == other.model.columns()
    }

    /// A flight without captive flight: launch is at its first row. For uses that need no calibration, such
    /// as a diagnosis.
    ///
    /// # Errors
    /// A flight without reference or second altitude, an invalid latitude in the header, or an invalid
    /// take-off and landing.
    pub fn uncalibrated(
        flight: &'a Flight,
        model: &Model,
        airborne: Option<GivenAirborne>,
    ) -> Result<Self, ReplayError> {
        let has_barometer = has_barometer(flight)?;
        let extent = extent(flight, GivenTimes { calibration: None, airborne })?;
        let first_s = extent.used_s.0;
        let window = CalibrationWindow { start_s: first_s, end_s: first_s };
        let source = CalibrationSource::Uncalibrated(window);
        let model = as_flown(model, flight, &source)?;
        Ok(Self { flight, model, source, extent, has_barometer, tamed: Vec::new(), wild: Vec::new() })
    }

    /// As [`Self::new`], but a flight without a quiet stretch to calibrate on is used uncalibrated, by
    /// [`Self::uncalibrated`].
    ///
    /// # Errors
    /// As those of both, except for a flight without a quiet stretch.
    pub fn calibrated_or_not(
        flight: &'a Flight,
        model: &Model,
        given: impl Into<GivenTimes>,
    ) -> Result<Self, ReplayError> {
        let given = given.into();
        match Self::new(flight, model, given) {
            Err(ReplayError::NoQuietStretch { .. } | ReplayError::TooShort { .. })
            | Ok(Self { source: CalibrationSource::Calmest(_), .. }) => {
                Self::uncalibrated(flight, model, given.airborne)
            }
            other => other,
        }
    }

    /// As [`Self::calibrated_or_not`], for a diagnosis, which estimates the biases along with everything
    /// else. All of a flight is used, from before its take-off to its landing, except what lies before a
    /// given window or before the last minutes on the ground. Cells that no aircraft can produce are left out
    /// ([`Self::wild`]).
    ///
    /// # Errors
    /// As [`Self::calibrated_or_not`].
    pub fn to_diagnose(
        flight: &'a Flight,
        model: &Model,
        given: impl Into<GivenTimes>,
    ) -> Result<Self, ReplayError> {
        let given = given.into();
        let mut replay = Self::calibrated_or_not(flight, model, given)?;
        // Calibration in the air would lose what was flown before it.
        if let CalibrationSource::Quiet(stretch) = replay.source
            && stretch.place == Place::Flight
            && replay.extent.interval().is_some()
        {
            replay = Self::uncalibrated(flight, model, given.airborne)?;
        }
        (replay.tamed, replay.wild) = wild::tamed(flight);
        Ok(replay)
    }

    /// The cells of single columns that a diagnosis leaves out, because no aircraft can produce them. None
    /// where the flight is replayed as the flight computer would see it.
    #[must_use]
    pub fn wild(&self) -> &[WildCells] {
        &self.wild
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

    /// The model as flown: without settling time where a window was given or found, and at the flight's own
    /// latitude if its header has one.
    #[must_use]
    pub const fn model(&self) -> &Model {
        &self.model
    }

    /// Which part of the log is analysed.
    #[must_use]
    pub const fn extent(&self) -> &Extent {
        &self.extent
    }

    /// The parts of the log that are not analysed, and why.
    #[must_use]
    pub fn unused(&self) -> Vec<Unused> {
        self.extent.unused(self.source.window().map_or(f64::NEG_INFINITY, |window| window.start_s))
    }

    /// Times of the rows that are analysed and of those skipped before the calibration window: all except
    /// those after the landing.
    #[must_use]
    pub fn times_s(&self) -> &'a [f64] {
        self.flight.time_s.get(..self.end_row()).unwrap_or_default()
    }

    /// The first row that is no longer analysed.
    fn end_row(&self) -> usize {
        let rows = self.flight.rows();
        if self.extent.used_s.1 >= self.extent.log_s.1 {
            return rows;
        }
        self.flight.time_s.iter().position(|time_s| *time_s > self.extent.used_s.1).unwrap_or(rows)
    }

    /// What decided when the captive flight ends.
    #[must_use]
    pub const fn source(&self) -> &CalibrationSource {
        &self.source
    }

    /// The ticks that the mission gets: [`Self::inputs`], and, if the flight has accelerometer and gyro at
    /// 50 Hz or more but no `imu_slave_alt_m`, the altitude that the flight computer makes from them.
    #[must_use]
    pub fn mission_inputs(&self) -> TickInputs<'a> {
        self.inputs().with_inertial_altitude()
    }

    /// Whether the flight computer makes the UAV's inertial altitude: [`Self::mission_inputs`] then has it
    /// and [`Self::inputs`] does not.
    #[must_use]
    pub fn makes_inertial_altitude(&self) -> bool {
        self.mission_inputs().inertial_altitude().is_some()
    }

    /// The ticks with the sensors' own values only, one a row from the calibration window on.
    #[must_use]
    pub fn inputs(&self) -> TickInputs<'a> {
        let (window, end) = (self.source.window(), self.end_row());
        TickInputs::new(self.flight, &self.tamed, window, end, self.has_barometer, self.model.columns())
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
            inputs: self.summary_of(&inputs),
            counters: *mission.counters(),
            latch: mission.latch().cloned(),
        })
    }

    /// Counts of the rows that these ticks were made from.
    fn summary_of(&self, inputs: &TickInputs<'_>) -> InputSummary {
        InputSummary {
            skipped_rows: inputs.skipped_rows(),
            rows_after: self.flight.rows() - self.end_row(),
            counters: *inputs.counters(),
            inertial_altitude: inputs
                .inertial_altitude()
                .map(|made| (*made.counts(), made.channel().counts())),
        }
    }
}

/// Whether the flight records its own launch.
#[must_use]
pub fn has_launch(flight: &Flight) -> bool {
    flight.channel(Channel::Launch).is_some_and(|launch| launch.samples().next().is_some())
}

/// A model without settling time where a window decides when to calibrate, and at the flight's own latitude.
fn as_flown(model: &Model, flight: &Flight, source: &CalibrationSource) -> Result<Model, ReplayError> {
    let mut model = model.clone();
    if source.window().is_some() {
        model.settling_s = 0.0;
    }
    model.latitude_deg = latitude_deg(flight)?.unwrap_or(model.latitude_deg);
    Ok(model)
}

/// Which part of a log is analysed.
fn extent(flight: &Flight, given: GivenTimes) -> Result<Extent, ReplayError> {
    match given.airborne {
        None if has_launch(flight) => Ok(Extent::all(flight)),
        _ => Extent::of(flight, given),
    }
}

/// Where a flight without a launch column can be calibrated.
fn quiet_or_calmest(
    flight: &Flight,
    model: &Model,
    extent: &Extent,
) -> Result<CalibrationSource, ReplayError> {
    let (from_s, to_s) = extent.used_s;
    let before = |end_s: f64, place| quiet::find_before(flight, &model.quality, (from_s, end_s), place);
    let take_off_s = extent.interval().and_then(|interval| interval.take_off_s);
    let drop_s = airborne::drop(flight).map(|drop| drop.from_s).filter(|at_s| (from_s..to_s).contains(at_s));
    // A vehicle under a carrier is calibrated there, as near to the drop as possible.
    let captive = drop_s.and_then(|drop_s| {
        let aloft_s = take_off_s.filter(|take_off_s| *take_off_s < drop_s).unwrap_or(from_s);
        quiet::find_before(flight, &model.quality, (aloft_s, drop_s), Place::Captive)
    });
    let on_ground = || before(take_off_s?, Place::Ground);
    if let Some(stretch) = captive.or_else(on_ground) {
        return Ok(CalibrationSource::Quiet(stretch));
    }
    match quiet::find(flight, &model.quality, (from_s, drop_s.unwrap_or(to_s))) {
        Err(ReplayError::NoQuietStretch { calmest: Some(calmest), .. }) => {
            Ok(CalibrationSource::Calmest(calmest))
        }
        other => other.map(CalibrationSource::Quiet),
    }
}

/// The header's optional key `latitude_deg`.
fn latitude_deg(flight: &Flight) -> Result<Option<f32>, ReplayError> {
    let Some((_, text)) = flight.header.other.iter().find(|(key, _)| key == "latitude_deg") else {
        return Ok(None);
    };
    match text.trim().parse::<f32>() {
        Ok(latitude_deg) if (-90.0..=90.0).contains(&latitude_deg) => Ok(Some(latitude_deg)),
        _ => Err(ReplayError::Latitude(text.clone())),
    }
}

/// Whether there is a usable barometer, besides a reference and another altitude.
fn has_barometer(flight: &Flight) -> Result<bool, ReplayError> {
    flight.require_altitudes()?;
    require_one_datum(flight)?;
    let fault = barometer::check(flight);
    let inertial = [Channel::ImuSlaveAltM, Channel::ImuMasterAltM, Channel::AccelXMps2];
    match fault {
        Some(fault) if !inertial.into_iter().any(|channel| flight.channel(channel).is_some()) => {
            Err(ReplayError::NoBarometer(fault))
        }
        fault => Ok(fault.is_none()),
    }
}

/// Checks that all compared altitudes have the same datum. A pressure altitude may be compared with any.
fn require_one_datum(flight: &Flight) -> Result<(), ReplayError> {
    let datum = |channel: Channel| flight.header.datum_of(channel.name());
    let reference = datum(Channel::GpsAltM);
    let compared = [Channel::ImuMasterAltM, Channel::ImuSlaveAltM, Channel::BaroAltM];
    let mixed = compared.into_iter().find(|channel| {
        let is_other = !matches!(datum(*channel), AltitudeDatum::Pressure) && datum(*channel) != reference;
        is_other && flight.channel(*channel).is_some()
    });
    mixed.map_or(Ok(()), |channel| {
        Err(ReplayError::MixedDatums { column: channel.name(), own: datum(channel), reference })
    })
}

#[cfg(test)]
mod tests;
