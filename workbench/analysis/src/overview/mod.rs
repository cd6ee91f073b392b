//! What is in a log, in the words of its pilot: `pylon open`.

mod next;
mod sensors;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use flight_data::{Channel, Column, Flight, Note};
use model::Model;
use replay::airborne::{self, AirborneInterval, EDGE_S};
use replay::barometer;
use replay::{GivenTimes, Replay, Usage, clock, has_launch};

pub use next::quoted;
pub use sensors::{SensorState, SensorView};

/// The format name of a flight's CSV.
pub const FLIGHT_FORMAT: &str = "Pylon's own CSV";

/// What is in a log: the keys of `pylon open --json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Overview {
    /// Version of the keys' meaning. It increases where a key changes its meaning or is removed.
    pub version: u32,
    /// The file.
    pub file: String,
    /// What kind of log it is.
    pub format: String,
    /// The vehicle, as given in the log.
    pub vehicle: String,
    /// Number of rows.
    pub rows: u64,
    /// First time of the flight's own clock, seconds. `--calibrate` counts from zero of that clock, not from
    /// this time.
    pub first_s: f64,
    /// Time from the first row to the last, seconds.
    pub duration_s: f64,
    /// When it was launched or dropped, from its own `launch` column, seconds.
    pub launch_s: Option<f64>,
    /// When it was dropped from a carrier, found by how it falls, seconds; null where it was not, or has a
    /// `launch` column.
    pub drop_s: Option<f64>,
    /// Which part of it is analysed.
    #[serde(flatten, deserialize_with = "crate::json::whole")]
    pub usage: Usage,
    /// The share of it that a diagnosis uses, which needs no calibration; null where it cannot be analysed.
    pub diagnosed_share: Option<f64>,
    /// Every time in the air.
    pub airborne: Vec<AirborneTime>,
    /// Time on the ground before the take-off of the flight that is analysed, seconds.
    pub ground_before_s: Option<f64>,
    /// Time after its landing, seconds.
    pub after_landing_s: Option<f64>,
    /// Where it is calibrated, in words; null where nothing can be.
    pub calibration: Option<String>,
    /// Start and end of the calibration, seconds; null for a flight with a launch, or where nothing can be
    /// calibrated.
    pub calibration_window_s: Option<[f64; 2]>,
    /// Why it cannot be analysed, if it cannot.
    pub refused: Option<String>,
    /// What is wrong with the barometer for the whole log, if anything.
    pub barometer_fault: Option<String>,
    /// The sensors.
    pub sensors: Vec<SensorView>,
    /// Anything remarkable about the log.
    pub notes: Vec<String>,
    /// Commands to continue with.
    pub next: Vec<String>,
}

/// One time in the air, seconds of the flight's own clock; null where the log does not show it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct AirborneTime {
    /// When it took off.
    pub take_off_s: Option<f64>,
    /// When it landed.
    pub landing_s: Option<f64>,
    /// How long it was in the air.
    pub duration_s: f64,
}

impl From<&AirborneInterval> for AirborneTime {
    fn from(interval: &AirborneInterval) -> Self {
        Self {
            take_off_s: interval.take_off_s,
            landing_s: interval.landing_s,
            duration_s: interval.duration_s(),
        }
    }
}

impl Overview {
    /// The version that this program writes.
    pub const VERSION: u32 = 1;

    /// The overview of a flight that was read; `format` is the file's format.
    #[must_use]
    pub fn new(
        file: &str,
        format: &str,
        flight: &Flight,
        notes: &[Note],
        given: impl Into<GivenTimes>,
    ) -> Self {
        let given = given.into();
        let first_s = flight.time_s.first().copied().unwrap_or(0.0);
        let last_s = flight.time_s.iter().copied().fold(first_s, f64::max);
        let replay = Replay::new(flight, &Model::default(), given);
        let mut airborne = match (&replay, given.airborne) {
            (Ok(replay), Some(_)) => replay.extent().airborne.clone(),
            _ => airborne::find(flight).airborne,
        };
        // The blocks in which take-offs are found are too long for a log that begins with a launch.
        let boost = airborne::boost(flight).filter(|_| !has_launch(flight) && given.airborne.is_none());
        if let Some(boost) = boost {
            let interval =
                airborne.iter_mut().find(|interval| (boost.from_s - interval.from_s).abs() <= EDGE_S);
            if let Some(interval) = interval.filter(|interval| interval.take_off_s.is_none()) {
                interval.take_off_s = Some(boost.from_s);
            }
        }
        let launched = boost.map(|boost| {
            format!(
                "launched by a rocket motor at {}: from standing the height rises by {:.0} m within 2 s",
                clock(boost.from_s),
                boost.rise_m
            )
        });
        let drop = airborne::drop(flight).filter(|_| !has_launch(flight));
        let dropped = drop.map(|drop| {
            format!(
                "dropped from a carrier at {}: out of steady flight it falls by {:.0} m within 2 s",
                clock(drop.from_s),
                drop.fall_m
            )
        });
        let (usage, calibration, window_s, refused, chosen) = match &replay {
            Ok(replay) => (
                Usage::of(replay),
                Some(replay.source().to_string()),
                replay.source().window().map(|window| [window.start_s, window.end_s]),
                None,
                replay.extent().interval(),
            ),
            Err(error) => (Usage::default(), None, None, Some(error.to_string()), None),
        };
        Self {
            version: Self::VERSION,
            file: file.to_owned(),
            format: format.to_owned(),
            vehicle: flight.header.vehicle.clone(),
            rows: flight.rows() as u64,
            first_s,
            duration_s: last_s - first_s,
            launch_s: launch_s(flight),
            drop_s: drop.map(|drop| drop.from_s),
            diagnosed_share: Replay::to_diagnose(flight, &Model::default(), given)
                .ok()
                .filter(|_| refused.is_none())
                .map(|replay| Usage::of(&replay).used_share),
            // A flight that records its launch is not searched for take-offs.
            airborne: if has_launch(flight) {
                Vec::new()
            } else {
                airborne.iter().map(AirborneTime::from).collect()
            },
            ground_before_s: chosen.and_then(|interval| Some(interval.take_off_s? - interval.ground_from_s?)),
            after_landing_s: chosen.and_then(|interval| Some(last_s - interval.landing_s?)),
            calibration,
            calibration_window_s: window_s,
            next: next::next(file, refused.is_none(), format == FLIGHT_FORMAT),
            refused,
            barometer_fault: barometer::check(flight).map(barometer::Fault::sentence),
            sensors: sensors::views(flight),
            notes: launched.into_iter().chain(dropped).chain(notes.iter().map(ToString::to_string)).collect(),
            usage,
        }
    }
}

fn launch_s(flight: &Flight) -> Option<f64> {
    let launch: &Column = flight.channel(Channel::Launch)?;
    let (row, _) = launch.samples().find(|(_, value)| *value != 0.0)?;
    flight.time_s.get(row).copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The launch is the first row whose cell marks it; a column of zeros marks none, and neither does a
    /// missing column.
    #[test]
    fn a_launch_is_the_first_that_is_said() {
        let of = |cells: &str| {
            let rows: String =
                cells.chars().enumerate().map(|(row, cell)| format!("{}.5,{cell},1,2\n", row)).collect();
            let csv = format!("# pylon-flight: 1\ntime_s,launch,gps_alt_m,baro_alt_m\n{rows}");
            launch_s(&flight_data::parse(csv.as_bytes()).unwrap().0)
        };
        assert_eq!((of("0011"), of("0000"), of("1000")), (Some(2.5), None, Some(0.5)));
        assert_eq!(launch_s(&Flight::default()), None);
    }
}
