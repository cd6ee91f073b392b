//! The autopilot: turns the plan into targets, and targets into body rates and throttle.

use core::f64::consts::{PI, TAU};

use super::super::atmosphere::GRAVITY;
use super::super::rotation::Vector;
use super::super::scenario::{Captive, Manoeuvre, Scenario};
use super::State;
use super::aerodynamics::{self, Flow};
use crate::scenario::Airframe;

/// Time constant of the mother ship's altitude error, s.
const ALTITUDE_TIME_CONSTANT_S: f64 = 5.0;
/// Time constant of its heading error, s.
const HEADING_TIME_CONSTANT_S: f64 = 5.0;
/// Time constant of an airspeed error, while thrust lasts, s.
const AIRSPEED_TIME_CONSTANT_S: f64 = 3.0;
/// Time constant of an angle of attack error, s.
const ANGLE_TIME_CONSTANT_S: f64 = 0.25;
/// Time constant of sideslip, s.
const SIDESLIP_TIME_CONSTANT_S: f64 = 0.5;
/// Fastest roll towards a new bank, rad/s.
const ROLL_RATE_LIMIT: f64 = 1.0;
/// Largest bank that holds the mother ship's heading, rad.
const HEADING_BANK_LIMIT: f64 = 0.3;

/// Target of the path.
#[derive(Clone, Copy, Debug)]
enum Path {
    /// A moving altitude.
    Altitude { altitude: f64, climb_rate: f64, climb_acceleration: f64 },
    /// Angle above the horizon, rad.
    Angle(f64),
}

#[derive(Clone, Copy, Debug)]
enum Lateral {
    Heading(f64),
    Bank(f64),
}

/// Targets of the autopilot.
#[derive(Clone, Copy, Debug)]
pub(super) struct Target {
    path: Path,
    lateral: Lateral,
    airspeed: f64,
    /// Wanted rate of change of the airspeed, m/s^2.
    airspeed_rate: f64,
    load_factor_limits: Option<(f64, f64)>,
}

impl Target {
    /// Climb rate that the path asks for, m/s.
    pub(super) fn climb_rate(&self, airspeed: f64, altitude: f64) -> f64 {
        match self.path {
            Path::Altitude { altitude: wanted, climb_rate, .. } => {
                climb_rate + (wanted - altitude) / ALTITUDE_TIME_CONSTANT_S
            }
            Path::Angle(angle) => airspeed * libm::sin(angle),
        }
    }

    /// Climb acceleration that the path asks for, m/s^2.
    fn climb_acceleration(&self) -> f64 {
        match self.path {
            Path::Altitude { climb_acceleration, .. } => climb_acceleration,
            Path::Angle(_) => 0.0,
        }
    }
}

/// The whole flight's targets.
pub(super) struct Plan {
    captive: Captive,
    launch_s: Option<f64>,
    /// Start of each segment, s, and its target.
    segments: Vec<(f64, Target)>,
}

impl Plan {
    pub(super) fn new(scenario: &Scenario) -> Self {
        let captive = scenario.captive;
        let airframe = &scenario.vehicle.airframe;
        let mut start_s = captive.duration_s;
        let mut angle = 0.0_f64;
        let mut airspeed = captive.airspeed_mps;
        let mut segments = Vec::with_capacity(scenario.free_flight.len());
        for segment in &scenario.free_flight {
            if segment.manoeuvre == Manoeuvre::LevelOff {
                angle = 0.0;
            }
            angle = segment.flight_path_deg.map_or(angle, f64::to_radians);
            airspeed = segment.airspeed_mps.unwrap_or(airspeed);
            let (mut low, mut high) = (airframe.minimum_load_factor, airframe.maximum_load_factor);
            match (segment.manoeuvre, segment.load_factor) {
                (Manoeuvre::Dive, Some(limit)) => low = limit,
                (_, Some(limit)) => high = limit,
                (_, None) => {}
            }
            segments.push((
                start_s,
                Target {
                    path: Path::Angle(angle),
                    lateral: Lateral::Bank(segment.bank_deg.unwrap_or(0.0).to_radians()),
                    airspeed,
                    airspeed_rate: 0.0,
                    load_factor_limits: Some((low, high)),
                },
            ));
            start_s += segment.duration_s;
        }
        Self { captive, launch_s: scenario.launch_s(), segments }
    }

    /// The target at `time_s` of the segment that is flown at `row_s` (the start of the row's step).
    pub(super) fn target(&self, row_s: f64, time_s: f64) -> Target {
        if self.launch_s.is_none_or(|launch_s| row_s < launch_s) {
            return self.trimmed(time_s);
        }
        let segment = self.segments.iter().rev().find(|(start_s, _)| *start_s <= row_s);
        segment.map_or_else(|| self.trimmed(time_s), |(_, target)| *target)
    }

    /// The mother ship's phugoid trades altitude for speed at constant energy: V dV = -g dh
    /// (Lanchester; Etkin, "Dynamics of Flight", section 6.3).
    fn trimmed(&self, time_s: f64) -> Target {
        let captive = &self.captive;
        let frequency = TAU / captive.phugoid_period_s;
        let (sine, cosine) = libm::sincos(frequency * time_s);
        let swing = captive.phugoid_amplitude_m * sine;
        let swing_rate = captive.phugoid_amplitude_m * frequency * cosine;
        Target {
            path: Path::Altitude {
                altitude: captive.altitude_m + swing,
                climb_rate: swing_rate,
                climb_acceleration: -frequency * frequency * swing,
            },
            lateral: Lateral::Heading(captive.heading_deg.to_radians()),
            airspeed: captive.airspeed_mps - GRAVITY * swing / captive.airspeed_mps,
            airspeed_rate: -GRAVITY * swing_rate / captive.airspeed_mps,
            load_factor_limits: None,
        }
    }
}

/// Commands of the autopilot.
pub(super) struct Command {
    /// Body rates, rad/s.
    pub(super) rate: Vector,
    pub(super) throttle: f64,
}

pub(super) fn command(
    airframe: &Airframe,
    state: &State,
    flow: &Flow,
    specific_force: Vector,
    target: &Target,
) -> Command {
    let [roll, pitch, yaw] = state.attitude.euler();
    let (sin_roll, cos_roll) = libm::sincos(roll);
    let (sin_pitch, cos_pitch) = libm::sincos(pitch);
    let airspeed = flow.airspeed;
    let angle_of = |climb_rate: f64| libm::asin((climb_rate / airspeed).clamp(-0.999, 0.999));
    let path = angle_of(-state.velocity[2]);
    let (sin_path, cos_path) = libm::sincos(path);

    // Path: the load factor that turns it, within limits, then the angle of attack that gives it.
    let wanted_path = angle_of(target.climb_rate(airspeed, state.altitude_m()));
    let curvature =
        (wanted_path - path) / airframe.path_time_constant_s + target.climb_acceleration() / airspeed;
    let (low, high) =
        target.load_factor_limits.unwrap_or((airframe.minimum_load_factor, airframe.maximum_load_factor));
    // A knife-edge bank has no lift to turn the path with: at most two g for each g upward.
    let lift_share = cos_roll.max(0.25);
    let wanted_load = ((cos_path + airspeed * curvature / GRAVITY) / lift_share).clamp(low, high);
    let thrust_load = flow.thrust_load_factor(airframe, state.thrust);
    let wanted_lift = wanted_load - thrust_load;
    let wanted_angle = aerodynamics::angle_for(airframe, flow.acceleration_scale(airframe), wanted_lift)
        .min(airframe.maximum_angle_deg.to_radians());
    let load = -specific_force[2] / GRAVITY;
    let pitch_rate = GRAVITY / airspeed * (load - cos_path * cos_roll)
        + (wanted_angle - flow.angle_of_attack) / ANGLE_TIME_CONSTANT_S;

    let wanted_bank = match target.lateral {
        Lateral::Bank(bank) => bank,
        Lateral::Heading(heading) => {
            let error = libm::remainder(heading - yaw, 2.0 * PI);
            libm::atan(airspeed / GRAVITY * error / HEADING_TIME_CONSTANT_S)
                .clamp(-HEADING_BANK_LIMIT, HEADING_BANK_LIMIT)
        }
    };
    let bank_rate =
        ((wanted_bank - roll) / airframe.bank_time_constant_s).clamp(-ROLL_RATE_LIMIT, ROLL_RATE_LIMIT);
    // The coordinated turn's yaw rate, and weathercock towards the flow.
    let yaw_rate = GRAVITY / airspeed * (specific_force[1] / GRAVITY + sin_roll * cos_pitch)
        + flow.sideslip / SIDESLIP_TIME_CONSTANT_S;
    // Euler kinematics: roll' = p + tan(pitch) (q sin(roll) + r cos(roll)).
    let [_, q, r] = state.rate;
    let tan_pitch = sin_pitch / cos_pitch.max(0.05);
    let roll_rate = bank_rate - tan_pitch * (q * sin_roll + r * cos_roll);

    let drag = flow.acceleration_scale(airframe) * flow.drag_coefficient(airframe);
    let wanted_rate = target.airspeed_rate + (target.airspeed - airspeed) / AIRSPEED_TIME_CONSTANT_S;
    let along = (drag + GRAVITY * sin_path + wanted_rate) / libm::cos(flow.angle_of_attack);
    Command { rate: [roll_rate, pitch_rate, yaw_rate], throttle: aerodynamics::throttle_for(airframe, along) }
}
