//! A sensor's altitude beside the receiver's, fix by fix, in which the aircraft's motion is the same.

use kf_core::atmosphere::pressure_altitude_m;
use statistics::RobustSpread;

use flight_data::{Channel, Column, Flight};

/// The columns of the sensors' altitudes, a barometer's pressure before the altitude made of it.
pub(crate) const SENSORS: [Channel; 4] =
    [Channel::BaroPa, Channel::BaroAltM, Channel::ImuSlaveAltM, Channel::ImuMasterAltM];

/// The receiver's and a sensor's altitude at the time of a fix.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pair {
    /// Seconds of the flight's own clock.
    pub(crate) time_s: f64,
    pub(crate) receiver_m: f64,
    pub(crate) sensor_m: f64,
}

impl Pair {
    pub(crate) fn apart_m(&self) -> f64 {
        self.sensor_m - self.receiver_m
    }
}

/// The two altitudes at every fix that has a reading of the sensor at most half a usual interval before, in
/// the order of time. None of an altitude that is not used, because the barometer's pressure is recorded too.
pub(crate) fn pairs(flight: &Flight, sensor: Channel) -> Vec<Pair> {
    let has_pressure =
        || flight.channel(Channel::BaroPa).is_some_and(|pressure| pressure.samples().next().is_some());
    let (Some(receiver), Some(column)) = (flight.channel(Channel::GpsAltM), flight.channel(sensor)) else {
        return Vec::new();
    };
    if sensor == Channel::BaroAltM && has_pressure() {
        return Vec::new();
    }
    let metres =
        |value: f32| if sensor == Channel::BaroPa { pressure_altitude_m(value) } else { Some(value) };
    let at = |column: &Column, metres: &dyn Fn(f32) -> Option<f32>| -> Vec<(f64, f64)> {
        let timed = column
            .samples()
            .filter_map(|(row, value)| Some((*flight.time_s.get(row)?, f64::from(metres(value)?))));
        timed.filter(|(_, metres)| metres.is_finite()).collect()
    };
    let (fixes, readings) = (at(receiver, &Some), at(column, &metres));
    let half_s = 0.5 * usual(fixes.windows(2).map(|two| two[1].0 - two[0].0)).unwrap_or(0.0);
    let mut next = 0;
    let mut pairs: Vec<Pair> = Vec::with_capacity(fixes.len());
    for (time_s, receiver_m) in fixes {
        while readings.get(next).is_some_and(|(reading_s, _)| *reading_s <= time_s) {
            next += 1;
        }
        let Some((reading_s, sensor_m)) = next.checked_sub(1).and_then(|last| readings.get(last)) else {
            continue;
        };
        let is_later = pairs.last().is_none_or(|last| time_s > last.time_s);
        if is_later && time_s - reading_s <= half_s {
            pairs.push(Pair { time_s, receiver_m, sensor_m: *sensor_m });
        }
    }
    pairs
}

/// How much an altitude changes between the second and the third of four fixes, beyond what it does on either
/// side, metres.
pub(crate) fn bend_m(around: &[Pair], altitude_m: fn(&Pair) -> f64) -> f64 {
    let climbs: Vec<f64> = around.windows(2).map(|two| altitude_m(&two[1]) - altitude_m(&two[0])).collect();
    match climbs.as_slice() {
        [before, across, after] => across - 0.5 * (before + after),
        _ => 0.0,
    }
}

/// The upper median; `None` of nothing.
pub(crate) fn usual(values: impl Iterator<Item = f64>) -> Option<f64> {
    let mut spread = RobustSpread::default();
    values.for_each(|value| spread.push(value));
    spread.median()
}

/// The robust standard deviation; zero of nothing.
pub(crate) fn spread(values: impl Iterator<Item = f64>) -> f64 {
    let mut spread = RobustSpread::default();
    values.for_each(|value| spread.push(value));
    spread.sigma().unwrap_or(0.0)
}
