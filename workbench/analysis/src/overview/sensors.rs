//! Which sensors a log has, and whether they measured.

use flight_data::{Channel, Column, Flight, is_altitude};
use replay::barometer::{self, Fault};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::name::Name;

/// Whether a sensor measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
#[serde(rename_all = "snake_case")]
pub enum SensorState {
    /// It has values that change.
    Present,
    /// It repeats one value all the time.
    Stuck,
    /// Its column contains the receiver's altitude, with or without a constant added.
    Copied,
    /// The log has no such sensor.
    Absent,
}

/// A sensor of a log.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct SensorView {
    /// Its name.
    pub sensor: Name,
    /// Whether it measured.
    pub state: SensorState,
    /// Number of samples.
    pub samples: u64,
    /// Median rate, samples per second.
    pub rate_hz: Option<f64>,
    /// Its columns.
    pub columns: Vec<Name>,
    /// Datum of its altitudes, `msl`, `ellipsoid` or `pressure`; null for a sensor that is not an altitude.
    pub datum: Option<Name>,
}

/// A sensor and its columns, the decisive one first.
const SENSORS: &[(&str, &[Channel])] = &[
    ("receiver's altitude", &[Channel::GpsAltM, Channel::GpsVaccM, Channel::GpsSats]),
    ("receiver's velocity", &[Channel::GpsVnMps, Channel::GpsVeMps, Channel::GpsVdMps]),
    ("barometer", &[Channel::BaroPa, Channel::BaroAltM, Channel::BaroTempC]),
    ("accelerometer", &[Channel::AccelZMps2, Channel::AccelXMps2, Channel::AccelYMps2]),
    ("gyro", &[Channel::GyroXRadps, Channel::GyroYRadps, Channel::GyroZRadps]),
    ("attitude", &[Channel::RollRad, Channel::PitchRad, Channel::YawRad]),
    ("airspeed", &[Channel::TasMps]),
    ("air's temperature", &[Channel::OatC]),
    ("inertial altitude", &[Channel::ImuSlaveAltM]),
    ("mother ship's altitude", &[Channel::ImuMasterAltM]),
    ("throttle", &[Channel::Throttle]),
];

/// Every sensor; those that most logs lack are left out where they are absent.
pub(super) fn views(flight: &Flight) -> Vec<SensorView> {
    let view = |(place, (sensor, channels)): (usize, &(&'static str, &[Channel]))| {
        let columns: Vec<(Channel, &Column)> = channels
            .iter()
            .filter_map(|channel| Some((*channel, flight.channel(*channel)?)))
            .filter(|(_, column)| column.samples().next().is_some())
            .collect();
        let telling = columns.first().map(|(_, column)| *column);
        let state = telling.map_or(SensorState::Absent, |column| state(flight, sensor, column));
        // The receiver and the barometer are always listed, the others are not.
        (place < 3 || state != SensorState::Absent).then(|| SensorView {
            sensor: (*sensor).into(),
            state,
            samples: telling.map_or(0, |column| column.samples().count() as u64),
            rate_hz: telling.and_then(|column| rate_hz(flight, column)),
            columns: columns.iter().map(|(channel, _)| channel.name().into()).collect(),
            datum: columns
                .iter()
                .map(|(channel, _)| channel.name())
                .find(|name| is_altitude(name))
                .map(|name| flight.header.datum_of(name).name().into()),
        })
    };
    SENSORS.iter().enumerate().filter_map(view).collect()
}

fn state(flight: &Flight, sensor: &str, column: &Column) -> SensorState {
    if sensor == "barometer" {
        return match barometer::check(flight) {
            None => SensorState::Present,
            Some(Fault::Stuck) => SensorState::Stuck,
            Some(Fault::Copied { .. }) => SensorState::Copied,
        };
    }
    // A vehicle that stood still the whole time has equal values too, but fewer of them.
    let mut values = column.samples().map(|(_, value)| value.to_bits());
    let first = values.next();
    let count = column.samples().count();
    let is_equal = count >= 100 && values.all(|value| Some(value) == first);
    // A throttle or a temperature may well be constant.
    let may_rest = matches!(sensor, "throttle" | "air's temperature");
    if is_equal && !may_rest { SensorState::Stuck } else { SensorState::Present }
}

fn rate_hz(flight: &Flight, column: &Column) -> Option<f64> {
    let times: Vec<f64> = column.samples().filter_map(|(row, _)| flight.time_s.get(row).copied()).collect();
    let mut steps: Vec<f64> = times
        .iter()
        .zip(times.iter().skip(1))
        .map(|(one, next)| next - one)
        .filter(|step| *step > 0.0)
        .collect();
    let middle = steps.len().checked_sub(1)? / 2;
    Some(1.0 / *steps.select_nth_unstable_by(middle, f64::total_cmp).1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_most_logs_lack_is_listed_only_where_it_is_there() {
        let mut flight = Flight::default();
        let (mut altitude, mut empty) = (Column::default(), Column::default());
        for row in 0..300 {
            flight.time_s.push(f64::from(row) * 0.5);
            altitude.push(Some(row as f32));
            empty.push(None);
        }
        flight.set_channel(Channel::GpsAltM, altitude);
        flight.set_channel(Channel::GyroXRadps, empty.clone());
        flight.set_channel(Channel::BaroPa, empty);
        let views = views(&flight);
        let named: Vec<_> = views.iter().map(|view| (&*view.sensor, view.state)).collect();
        assert_eq!(
            named,
            [
                ("receiver's altitude", SensorState::Present),
                ("receiver's velocity", SensorState::Absent),
                ("barometer", SensorState::Absent)
            ]
        );
        assert_eq!((views[0].rate_hz, views[0].samples), (Some(2.0), 300));
    }
}
