//! Forces of the air and the engine.
//!
//! Lift is linear in the angle of attack, drag a parabola in lift, side force linear in sideslip
//! (Stevens and Lewis, "Aircraft Control and Simulation", section 2.3). Lift is normal to the flow in the
//! plane of symmetry, drag along the flow, side force along body y, thrust along body x.

use super::super::atmosphere::GRAVITY;
use super::super::rotation::{Vector, norm, scale};
use super::super::scenario::Airframe;

/// The airflow relative to the aircraft.
#[derive(Clone, Copy, Debug)]
pub(super) struct Flow {
    /// Unit vector of the aircraft's velocity through the air, body axes.
    direction: Vector,
    pub(super) airspeed: f64,
    pub(super) angle_of_attack: f64,
    pub(super) sideslip: f64,
    /// Dynamic pressure, Pa.
    pub(super) dynamic_pressure: f64,
}

impl Flow {
    pub(super) fn new(body_velocity: Vector, density: f64) -> Self {
        let airspeed = norm(body_velocity);
        let direction = scale(body_velocity, 1.0 / airspeed);
        let [u, v, w] = direction;
        Self {
            direction,
            airspeed,
            angle_of_attack: libm::atan2(w, u),
            sideslip: libm::asin(v.clamp(-1.0, 1.0)),
            dynamic_pressure: 0.5 * density * airspeed * airspeed,
        }
    }

    /// Dynamic pressure times wing area over mass, m/s^2: a force coefficient's acceleration.
    pub(super) fn acceleration_scale(&self, airframe: &Airframe) -> f64 {
        self.dynamic_pressure * airframe.wing_area_m2 / airframe.mass_kg
    }

    pub(super) fn drag_coefficient(&self, airframe: &Airframe) -> f64 {
        let lift = lift_coefficient(airframe, self.angle_of_attack);
        airframe.zero_lift_drag + airframe.induced_drag * lift * lift
    }

    /// What thrust adds to the load factor normal to the flow.
    pub(super) fn thrust_load_factor(&self, airframe: &Airframe, throttle: f64) -> f64 {
        throttle * airframe.maximum_thrust_n / airframe.mass_kg * libm::sin(self.angle_of_attack) / GRAVITY
    }

    /// Specific force, body axes, m/s^2.
    pub(super) fn specific_force(&self, airframe: &Airframe, throttle: f64) -> Vector {
        let scale = self.acceleration_scale(airframe);
        let lift = scale * lift_coefficient(airframe, self.angle_of_attack);
        let drag = scale * self.drag_coefficient(airframe);
        let side = -scale * airframe.side_force_slope_per_rad * self.sideslip;
        let thrust = throttle * airframe.maximum_thrust_n / airframe.mass_kg;
        let (sine, cosine) = libm::sincos(self.angle_of_attack);
        let [u, v, w] = self.direction;
        [lift * sine - drag * u + thrust, side - drag * v, -lift * cosine - drag * w]
    }
}

fn lift_coefficient(airframe: &Airframe, angle_of_attack: f64) -> f64 {
    airframe.lift_slope_per_rad * (angle_of_attack - airframe.zero_lift_angle_deg.to_radians())
}

/// Angle of attack whose lift gives a load factor, rad.
pub(super) fn angle_for(airframe: &Airframe, acceleration_scale: f64, lift_load_factor: f64) -> f64 {
    airframe.zero_lift_angle_deg.to_radians()
        + lift_load_factor * GRAVITY / (acceleration_scale * airframe.lift_slope_per_rad)
}

/// Steady flight along a straight path.
pub(super) struct Trim {
    pub(super) angle_of_attack_rad: f64,
    pub(super) throttle: f64,
}

pub(super) fn trim(airframe: &Airframe, density: f64, airspeed: f64, path_rad: f64) -> Trim {
    let at = |angle: f64| {
        let (sine, cosine) = libm::sincos(angle);
        Flow::new([airspeed * cosine, 0.0, airspeed * sine], density)
    };
    let (sine, cosine) = libm::sincos(path_rad);
    let mut trim = Trim { angle_of_attack_rad: 0.0, throttle: 0.0 };
    // Thrust lifts a little and lift costs thrust: each iteration contracts the error by about a hundred.
    for _ in 0..8 {
        let flow = at(trim.angle_of_attack_rad);
        let lift = cosine - flow.thrust_load_factor(airframe, trim.throttle);
        let angle_of_attack_rad = angle_for(airframe, flow.acceleration_scale(airframe), lift);
        let flow = at(angle_of_attack_rad);
        let drag = flow.acceleration_scale(airframe) * flow.drag_coefficient(airframe);
        let along = (drag + GRAVITY * sine) / libm::cos(angle_of_attack_rad);
        trim = Trim { angle_of_attack_rad, throttle: throttle_for(airframe, along) };
    }
    trim
}

/// Throttle that gives an acceleration along the path (m/s^2), within the engine's limits.
pub(super) fn throttle_for(airframe: &Airframe, acceleration: f64) -> f64 {
    if airframe.maximum_thrust_n > 0.0 {
        (acceleration * airframe.mass_kg / airframe.maximum_thrust_n).clamp(0.0, 1.0)
    } else {
        0.0
    }
}
