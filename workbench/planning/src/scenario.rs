//! A plan as a scenario's text, which `pylon simulate` accepts and which is simulated here.

use std::fmt::Write as _;

use crate::circumstances::{Circumstances, ROWS_HZ};
use crate::manoeuvres::segments;
use crate::plan::FlightPlan;

/// The simulated airframe's own trim near the ground (`simulate::scenario::Airframe`): m/s, and its wing
/// area, m^2.
const TRIM_MPS: f64 = 28.0;
const WING_M2: f64 = 0.8;

/// The scenario's text.
pub fn text(plan: &FlightPlan, around: &Circumstances) -> String {
    let FlightPlan { speed_mps, altitude_m, calibration_s, .. } = plan;
    let mut text = format!(
        "# Planned by Pylon. `pylon simulate` flies it; it has not been flown yet.\n\
         name = \"next-flight\"\n\
         source = \"a planned flight, simulated\"\n\
         rate_hz = {ROWS_HZ:?}\n\
         \n\
         # In level flight it vibrates as the aircraft of these flights.\n\
         [vehicle]\n\
         vibration_mps2 = {vibration:?}\n\
         \n\
         # The wing carries the aircraft at this speed and altitude as the default one does at {TRIM_MPS:?} m/s near the ground.\n\
         [vehicle.airframe]\n\
         wing_area_m2 = {wing:?}\n\
         \n\
         # The same for the aircraft that carries it.\n\
         [carrier]\n\
         wing_area_m2 = {wing:?}\n\
         \n\
         # Straight and level, for the calibration.\n\
         [captive]\n\
         duration_s = {calibration_s:?}\n\
         altitude_m = {altitude_m:?}\n\
         airspeed_mps = {speed_mps:?}\n\
         \n\
         # The sampling rates of the flights that the plan is based on.\n\
         [sensors.gps.sampling]\n\
         rate_hz = {gps:?}\n\
         \n\
         [sensors.baro.sampling]\n\
         rate_hz = {baro:?}\n\
         \n\
         [sensors.imu_slave.sampling]\n\
         rate_hz = {imu:?}\n",
        wing = WING_M2 * (TRIM_MPS / speed_mps) * (TRIM_MPS / speed_mps) / density_ratio(*altitude_m),
        vibration = around.vibration_mps2,
        gps = around.gps_hz,
        baro = around.baro_hz,
        imu = around.imu_hz,
    );
    for segment in segments(plan) {
        let _ = write!(
            text,
            "\n[[free_flight]]\nmanoeuvre = \"{}\"\nduration_s = {:?}\n",
            segment.manoeuvre, segment.duration_s
        );
        for (key, value) in segment.keys {
            let _ = writeln!(text, "{key} = {value:?}");
        }
    }
    text
}

/// Density relative to that at mean sea level: the standard troposphere (ICAO Doc 7488).
fn density_ratio(altitude_m: f64) -> f64 {
    const LAPSE_PER_M: f64 = 0.0065 / 288.15;
    const EXPONENT: f64 = 4.255_88;
    libm::pow(1.0 - LAPSE_PER_M * altitude_m.min(11_000.0), EXPONENT)
}
