//! The aircraft's true motion: a point mass with attitude, over a flat earth, in double precision.
//!
//! Position, velocity, attitude, body rates and thrust are integrated together (Runge-Kutta, fourth order,
//! one step a row), so that they are consistent: the specific force moves the aircraft, the body rates turn
//! it, and the flow angles follow from both and the wind. Moments are not modelled: the autopilot commands
//! body rates, which follow with a first-order lag. Altitude is geopotential, gravity constant.

mod aerodynamics;
mod autopilot;
mod gusts;

use super::atmosphere::{Air, GRAVITY, ZERO_CELSIUS};
use super::random::{Random, Stream};
use super::rotation::{Attitude, Vector, minus};
use super::scenario::{Airframe, Scenario};
use aerodynamics::Flow;
use autopilot::{Plan, Target};
use gusts::Gusts;

/// The truth at one row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TruthSample {
    /// Time since the first row, s.
    pub time_s: f64,
    /// Whether the UAV still hangs under the pylon.
    pub captive: bool,
    /// Position north and east of the first row, m.
    pub position_m: [f64; 2],
    /// Altitude, m.
    pub altitude_m: f64,
    /// Velocity over ground, north-east-down, m/s.
    pub velocity_mps: [f64; 3],
    /// Attitude quaternion, body to north-east-down, scalar first.
    pub attitude: [f64; 4],
    /// Roll, pitch, yaw, rad.
    pub euler_rad: [f64; 3],
    /// Specific force, body axes, m/s^2; without vibration.
    pub specific_force_mps2: [f64; 3],
    /// Body rates, rad/s.
    pub rate_radps: [f64; 3],
    /// True airspeed, gusts included, m/s.
    pub airspeed_mps: f64,
    /// Angle of attack, rad.
    pub angle_of_attack_rad: f64,
    /// Sideslip, rad.
    pub sideslip_rad: f64,
    /// The UAV's throttle, 0 to 1.
    pub throttle: f64,
    /// Vibration of each body axis (1 sigma), m/s^2.
    pub vibration_mps2: f64,
    /// Pressure altitude of the undisturbed air, m.
    pub pressure_altitude_m: f64,
    /// Outside air temperature, degrees Celsius.
    pub air_temperature_c: f64,
    /// Temperature of the barometer itself, degrees Celsius.
    pub baro_temperature_c: f64,
}

impl TruthSample {
    /// Climb rate, m/s.
    #[must_use]
    pub fn climb_rate_mps(&self) -> f64 {
        -self.velocity_mps[2]
    }

    /// Load factor: minus the body z specific force over g.
    #[must_use]
    pub fn load_factor(&self) -> f64 {
        -self.specific_force_mps2[2] / GRAVITY
    }

    /// Acceleration over ground, north-east-down, m/s^2.
    #[must_use]
    pub fn acceleration_mps2(&self) -> [f64; 3] {
        let [north, east, down] = Attitude(self.attitude).to_ned(self.specific_force_mps2);
        [north, east, down + GRAVITY]
    }
}

/// Why a flight ended before its plan.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum MotionError {
    /// It flew below sea level.
    #[error("the flight is below sea level at {time_s:.2} s: start higher, or dive less")]
    Ground {
        /// When it happened, s.
        time_s: f64,
    },
    /// The linear aerodynamics do not apply.
    #[error(
        "the flight leaves its envelope at {time_s:.2} s (airspeed {airspeed_mps:.1} m/s, angle of attack \
         {angle_of_attack_deg:.0} degrees): ask for a gentler manoeuvre or another airspeed"
    )]
    Envelope {
        /// When it happened, s.
        time_s: f64,
        /// Airspeed then, m/s.
        airspeed_mps: f64,
        /// Angle of attack then, degrees.
        angle_of_attack_deg: f64,
    },
}

/// Largest flow angle of the linear aerodynamics, rad.
const ENVELOPE_RAD: f64 = 0.6;

const STATES: usize = 15;

/// The integrated state.
#[derive(Clone, Copy)]
struct State {
    /// North, east, down of the first row's point at sea level, m.
    position: Vector,
    velocity: Vector,
    attitude: Attitude,
    rate: Vector,
    /// Thrust over maximum thrust of the aircraft that is being integrated.
    thrust: f64,
    baro_temperature_k: f64,
}

impl State {
    fn pack(&self) -> [f64; STATES] {
        let ([n, e, d], [vn, ve, vd], [p, q, r]) = (self.position, self.velocity, self.rate);
        let [w, x, y, z] = self.attitude.0;
        [n, e, d, vn, ve, vd, w, x, y, z, p, q, r, self.thrust, self.baro_temperature_k]
    }

    fn unpack([n, e, d, vn, ve, vd, w, x, y, z, p, q, r, thrust, temperature]: [f64; STATES]) -> Self {
        Self {
            position: [n, e, d],
            velocity: [vn, ve, vd],
            attitude: Attitude([w, x, y, z]),
            rate: [p, q, r],
            thrust,
            baro_temperature_k: temperature,
        }
    }

    fn altitude_m(&self) -> f64 {
        -self.position[2]
    }
}

/// Everything in the scenario that the equations of motion need.
struct World<'a> {
    scenario: &'a Scenario,
    air: Air,
}

/// One evaluation of the equations of motion.
struct Evaluation {
    derivative: [f64; STATES],
    specific_force: Vector,
    flow: Flow,
}

impl World<'_> {
    fn airframe(&self, captive: bool) -> &Airframe {
        if captive { &self.scenario.carrier } else { &self.scenario.vehicle.airframe }
    }

    /// Steady wind at an altitude, north-east-down, m/s.
    fn wind(&self, altitude_m: f64) -> Vector {
        let wind = &self.scenario.wind;
        let above = altitude_m - self.scenario.captive.altitude_m;
        [wind.north_mps + wind.shear_north_per_s * above, wind.east_mps + wind.shear_east_per_s * above, 0.0]
    }

    fn evaluate(&self, state: &State, gust: Vector, captive: bool, target: &Target) -> Evaluation {
        let airframe = self.airframe(captive);
        let air = self.air.at(state.altitude_m());
        let wind = self.wind(state.altitude_m());
        let air_velocity = minus(minus(state.velocity, wind), gust);
        let flow = Flow::new(state.attitude.to_body(air_velocity), air.density);
        let specific_force = flow.specific_force(airframe, state.thrust);
        let [an, ae, ad] = state.attitude.to_ned(specific_force);
        let command = autopilot::command(airframe, state, &flow, specific_force, target);

        let temperature = &self.scenario.sensors.baro.temperature;
        let equilibrium = air.temperature_k + temperature.self_heating_c;
        let mut derivative = State {
            position: state.velocity,
            velocity: [an, ae, ad + GRAVITY],
            attitude: Attitude(state.attitude.derivative(state.rate)),
            rate: [0.0; 3],
            thrust: (command.throttle - state.thrust) / airframe.engine_time_constant_s,
            baro_temperature_k: (equilibrium - state.baro_temperature_k) / temperature.time_constant_s,
        };
        for ((slope, commanded), rate) in derivative.rate.iter_mut().zip(command.rate).zip(state.rate) {
            *slope = (commanded - rate) / airframe.rate_time_constant_s;
        }
        Evaluation { derivative: derivative.pack(), specific_force, flow }
    }

    /// One row's step. Gusts change linearly over it, so that the specific force is continuous.
    fn step(
        &self,
        plan: &Plan,
        state: &State,
        time_s: f64,
        dt: f64,
        gusts: [Vector; 2],
        captive: bool,
    ) -> State {
        let [before, after] = gusts;
        let middle = [0, 1, 2].map(|axis| 0.5 * (before[axis] + after[axis]));
        let x = state.pack();
        let slope = |stage: [f64; STATES], gust: Vector, offset: f64| {
            // The target is that of the row, so that a manoeuvre begins at a row.
            let target = plan.target(time_s, time_s + offset);
            self.evaluate(&State::unpack(stage), gust, captive, &target).derivative
        };
        let advance = |k: &[f64; STATES], h: f64| {
            let mut stage = x;
            for (value, rate) in stage.iter_mut().zip(k) {
                *value += h * rate;
            }
            stage
        };
        let k1 = slope(x, before, 0.0);
        let k2 = slope(advance(&k1, 0.5 * dt), middle, 0.5 * dt);
        let k3 = slope(advance(&k2, 0.5 * dt), middle, 0.5 * dt);
        let k4 = slope(advance(&k3, dt), after, dt);
        let mut next = x;
        for (i, value) in next.iter_mut().enumerate() {
            *value += dt / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]);
        }
        State::unpack(next)
    }

    /// The mother ship in trim at the first row.
    fn initial(&self, target: &Target) -> State {
        let scenario = self.scenario;
        let captive = &scenario.captive;
        let airframe = self.airframe(true);
        let altitude = captive.altitude_m;
        let air = self.air.at(altitude);
        let heading = captive.heading_deg.to_radians();
        let path = libm::asin(
            (target.climb_rate(captive.airspeed_mps, altitude) / captive.airspeed_mps).clamp(-0.5, 0.5),
        );
        let trim = aerodynamics::trim(airframe, air.density, captive.airspeed_mps, path);
        let (sine, cosine) = libm::sincos(path);
        let (east, north) = libm::sincos(heading);
        let wind = self.wind(altitude);
        let airspeed = captive.airspeed_mps;
        let temperature = &scenario.sensors.baro.temperature;
        State {
            position: [0.0, 0.0, -altitude],
            velocity: [
                airspeed * cosine * north + wind[0],
                airspeed * cosine * east + wind[1],
                -airspeed * sine,
            ],
            attitude: Attitude::from_euler([0.0, path + trim.angle_of_attack_rad, heading]),
            rate: [0.0; 3],
            thrust: trim.throttle,
            baro_temperature_k: air.temperature_k + temperature.initial_excess_c,
        }
    }

    fn sample(&self, state: &State, evaluation: &Evaluation, time_s: f64, captive: bool) -> TruthSample {
        let scenario = self.scenario;
        let air = self.air.at(state.altitude_m());
        let throttle = if captive { scenario.captive.uav_throttle } else { state.thrust };
        TruthSample {
            time_s,
            captive,
            position_m: [state.position[0], state.position[1]],
            altitude_m: state.altitude_m(),
            velocity_mps: state.velocity,
            attitude: state.attitude.0,
            euler_rad: state.attitude.euler(),
            specific_force_mps2: evaluation.specific_force,
            rate_radps: state.rate,
            airspeed_mps: evaluation.flow.airspeed,
            angle_of_attack_rad: evaluation.flow.angle_of_attack,
            sideslip_rad: evaluation.flow.sideslip,
            throttle,
            vibration_mps2: scenario.vehicle.vibration_mps2 * throttle,
            pressure_altitude_m: air.pressure_altitude_m,
            air_temperature_c: air.temperature_k - ZERO_CELSIUS,
            baro_temperature_c: state.baro_temperature_k - ZERO_CELSIUS,
        }
    }
}

/// Flies a scenario: one sample a row.
///
/// # Errors
/// When the flight meets sea level or leaves the envelope of the linear aerodynamics.
pub fn fly(scenario: &Scenario, seed: u64) -> Result<Vec<TruthSample>, MotionError> {
    let atmosphere = &scenario.atmosphere;
    let world =
        World { scenario, air: Air::new(atmosphere.temperature_offset_c, atmosphere.sea_level_pressure_pa) };
    let plan = Plan::new(scenario);
    let mut random = Random::new(seed, Stream::Turbulence);
    let mut gusts = Gusts::new(scenario.turbulence);

    let rows = libm::round(scenario.duration_s() * scenario.rate_hz) as usize;
    let dt = 1.0 / scenario.rate_hz;
    let mut state = world.initial(&plan.target(0.0, 0.0));
    let mut gust = gusts.next(&mut random, scenario.captive.airspeed_mps, dt);
    let mut samples = Vec::with_capacity(rows);
    let mut was_captive = true;
    for row in 0..rows {
        let time_s = row as f64 / scenario.rate_hz;
        let captive = scenario.launch_s().is_none_or(|launch_s| time_s < launch_s);
        if was_captive && !captive {
            // From here on the thrust is the UAV's, at the setting it had under the pylon.
            state.thrust = scenario.captive.uav_throttle;
        }
        was_captive = captive;

        let now = world.evaluate(&state, gust, captive, &plan.target(time_s, time_s));
        let flow = &now.flow;
        // Written so that a NaN counts as outside.
        if !(flow.angle_of_attack.abs() < ENVELOPE_RAD && flow.sideslip.abs() < ENVELOPE_RAD) {
            let angle_of_attack_deg = flow.angle_of_attack.to_degrees();
            return Err(MotionError::Envelope { time_s, airspeed_mps: flow.airspeed, angle_of_attack_deg });
        }
        if state.altitude_m() < 0.0 {
            return Err(MotionError::Ground { time_s });
        }
        samples.push(world.sample(&state, &now, time_s, captive));

        let next_gust = gusts.next(&mut random, now.flow.airspeed, dt);
        state = world.step(&plan, &state, time_s, dt, [gust, next_gust], captive);
        gust = next_gust;
    }
    Ok(samples)
}

#[cfg(test)]
mod tests;
