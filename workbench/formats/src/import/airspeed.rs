//! True airspeed from the calibrated airspeed that autopilots log.

use kf_core::atmosphere::pressure_altitude_m;

use flight_data::{Channel, Column, Flight};

/// Temperature of the standard atmosphere (ICAO Doc 7488), degrees Celsius.
#[must_use]
pub fn standard_temperature_c(altitude_m: f64) -> f64 {
    15.0 - 0.0065 * altitude_m.min(11_000.0)
}

/// Square root of the standard sea-level density over the density at a pressure altitude (metres) and
/// a temperature (degrees Celsius): the factor from indicated to true airspeed at speeds below 0.3 Mach.
#[must_use]
pub fn true_airspeed_factor(pressure_altitude_m: f64, temperature_c: f64) -> f64 {
    let standard_k = standard_temperature_c(pressure_altitude_m) + 273.15;
    let exponent = 9.806_65 / (287.052_87 * 0.0065);
    let pressure_ratio = if pressure_altitude_m <= 11_000.0 {
        (standard_k / 288.15).powf(exponent)
    } else {
        (216.65_f64 / 288.15).powf(exponent)
            * (-9.806_65 * (pressure_altitude_m - 11_000.0) / (287.052_87 * 216.65)).exp()
    };
    ((temperature_c + 273.15) / 288.15 / pressure_ratio).sqrt()
}

/// Adds `tas_mps`, computed from calibrated airspeeds (rows and m/s, in row order) with the standard
/// atmosphere's density at the pressure altitude, which is held from the last row that has one. Without a
/// barometer it uses the reference's altitude. Returns whether there were any values.
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
