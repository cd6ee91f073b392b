//! True airspeed from the calibrated one that autopilots log.

use kf_core::atmosphere::pressure_altitude_m;

use super::igc::units::{standard_temperature_c, true_airspeed_factor};
use flight_data::{Channel, Column, Flight};

/// Puts `tas_mps` in, made of calibrated airspeeds (rows and m/s, in row order) by the standard atmosphere's density at the
/// pressure altitude, which is held from the last row that has one; at the reference's altitude without barometer. Says
/// whether there was any.
pub fn put_true_airspeed(flight: &mut Flight, calibrated: impl IntoIterator<Item = (usize, f64)>) -> bool {
    let altitudes = held_pressure_altitudes(flight);
    let mut column = Column::empty(flight.rows());
    let mut any = false;
    for (row, mps) in calibrated {
        let Some(altitude_m) = altitudes.get(row).copied().flatten() else { continue };
        let factor = true_airspeed_factor(altitude_m, standard_temperature_c(altitude_m));
        any |= column.set(row, Some((mps * factor) as f32));
    }
    if any {
        flight.set_channel(Channel::TasMps, column);
    }
    any
}

fn held_pressure_altitudes(flight: &Flight) -> Vec<Option<f64>> {
    let pressure = flight.channel(Channel::BaroPa);
    let altitude = flight.channel(Channel::BaroAltM);
    let reference = flight.channel(Channel::GpsAltM);
    let at = |row: usize| match (pressure, altitude) {
        (Some(pressure), _) => pressure.get(row).and_then(pressure_altitude_m),
        (None, Some(altitude)) => altitude.get(row),
        (None, None) => reference.and_then(|reference| reference.get(row)),
    };
    let mut held = None;
    (0..flight.rows())
        .map(|row| {
            held = at(row).map(f64::from).filter(|altitude_m| altitude_m.is_finite()).or(held);
            held
        })
        .collect()
}
