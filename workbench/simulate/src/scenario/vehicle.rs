//! The aircraft.

use serde::Deserialize;

/// The UAV: its name and its airframe.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Vehicle {
    /// Name, for the flight's header.
    pub name: String,
    /// The airframe.
    pub airframe: Airframe,
    /// Vibration of each body axis at full throttle, proportional to throttle (1 sigma), m/s^2.
    pub vibration_mps2: f64,
}

impl Default for Vehicle {
    fn default() -> Self {
        Self { name: "simulated UAV".to_owned(), airframe: Airframe::default(), vibration_mps2: 0.0 }
    }
}

/// A point mass with linear aerodynamics, a parabolic polar and an autopilot that commands body rates.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Airframe {
    /// Mass, kg.
    pub mass_kg: f64,
    /// Wing area, m^2.
    pub wing_area_m2: f64,
    /// Lift curve slope, 1/rad.
    pub lift_slope_per_rad: f64,
    /// Angle of attack of zero lift, degrees.
    pub zero_lift_angle_deg: f64,
    /// Largest angle of attack that the autopilot commands, degrees.
    pub maximum_angle_deg: f64,
    /// Drag coefficient at zero lift.
    pub zero_lift_drag: f64,
    /// Induced drag over lift coefficient squared.
    pub induced_drag: f64,
    /// Side force slope (positive), 1/rad.
    pub side_force_slope_per_rad: f64,
    /// Thrust at full throttle, N; 0 for a glider.
    pub maximum_thrust_n: f64,
    /// Time constant of the flight-path error, s.
    pub path_time_constant_s: f64,
    /// Time constant of the bank error, s.
    pub bank_time_constant_s: f64,
    /// Time constant with which body rates follow their commands, s.
    pub rate_time_constant_s: f64,
    /// Time constant with which thrust follows the throttle lever, s.
    pub engine_time_constant_s: f64,
    /// Lowest load factor that the autopilot commands.
    pub minimum_load_factor: f64,
    /// Highest load factor that the autopilot commands.
    pub maximum_load_factor: f64,
}

/// A small fixed-wing UAV: 15 kg/m^2, trimmed at about two degrees at 28 m/s near the ground.
impl Default for Airframe {
    fn default() -> Self {
        Self {
            mass_kg: 12.0,
            wing_area_m2: 0.8,
            lift_slope_per_rad: 5.0,
            zero_lift_angle_deg: -2.0,
            maximum_angle_deg: 12.0,
            zero_lift_drag: 0.03,
            induced_drag: 0.05,
            side_force_slope_per_rad: 0.6,
            maximum_thrust_n: 60.0,
            path_time_constant_s: 0.8,
            bank_time_constant_s: 0.5,
            rate_time_constant_s: 0.1,
            engine_time_constant_s: 0.4,
            minimum_load_factor: 0.0,
            maximum_load_factor: 4.0,
        }
    }
}
