//! Level alignment by velocity matching: the horizontal velocity integrated from the inertial samples is
//! compared with that of the reference, so that an acceleration of the aircraft is not mistaken for a tilt.
//!
//! Levelling on specific force alone takes every horizontal acceleration for a tilt, 0.1 rad a g; here only
//! the part that the reference's velocity does not explain is one. Error model in north-east-down axes,
//! linear (Titterton and Weston, sections 12.3 and 10.4; P. D. Groves, "Principles of GNSS, Inertial, and
//! Multisensor Integrated Navigation Systems", 2nd edition, Artech House 2013, section 14.2):
//!
//! `phi' = -C b`, `dv' = f x phi`; measured is `dv`, the integrated velocity less the fix's.
//!
//! `phi` is the small rotation of the computed axes against the true ones (tilts, heading), `b` the remaining
//! gyro bias in body axes, `C` body to navigation axes, `f` specific force. Heading and the bias about the
//! vertical are only weakly visible in the accelerations of straight flight, so the track is measured too:
//! heading and crab angle. The crab angle is a state, because wind and trim do not change fast. Every fix is
//! fed back once it is measured, so the states are zero between fixes. In straight flight a horizontal bias
//! of the accelerometer cannot be distinguished from a tilt, and counts as one. So does the Coriolis
//! acceleration (4 mm/s^2 at 28 m/s), which is not in the model.
//!
//! One fix a second is used. The update is spread over the nineteen samples after it, so that no tick has to
//! do all of it.

use super::sum::Sum;
use super::vector::{Down, Vector, cross, difference, dot, scaled, sum};
use crate::error::FilterError;
use crate::root::reciprocal_root;
use crate::time::seconds_between;
use crate::ud::{NoiseVariance, Row, UdFilter};

/// Errors of velocity north and east (m/s), tilt north and east, heading (rad), gyro bias x, y, z (rad/s),
/// crab angle (rad). In this order each is driven by later ones only, so the transition is unit upper
/// triangular.
const STATES: usize = 9;
const VELOCITY: usize = 0;
const TILT: usize = 2;
const HEADING: usize = 4;
const BIAS: usize = 5;
const CRAB: usize = 8;

/// Variances at the start: a tilt from an acceleration of 1 m/s^2, a crab angle of 0.3 rad, the bias of a
/// MEMS gyro (0.02 rad/s), and the fix's velocity.
const START: [f32; 4] = [0.01, 0.09, 4e-4, 0.02];
/// Variance of a fix's velocity, (m/s)^2: 0.1 m/s, which includes a latency of 0.2 s at 0.5 m/s^2.
const FIX_M2PS2: f32 = 0.01;
/// Noise densities. Angle: 0.02 deg/s/sqrt(Hz), rad^2/s.
const ANGLE_DENSITY: f32 = 1.2e-7;
/// Bias: wanders by 10 deg/h in a quarter of an hour, (rad/s)^2/s.
const BIAS_DENSITY: f32 = 2.6e-12;
/// Velocity: vibration of 0.5 m/s^2 sampled 200 times a second, (m/s)^2/s.
const VELOCITY_DENSITY: f32 = 1.2e-3;

/// Crab: wind and trim change it by 0.03 rad in 100 s, rad^2/s; and in a turn by a wind of up to a fifth of
/// the airspeed.
const CRAB_DENSITY: f32 = 1e-5;
const CRAB_BY_TURN: f32 = 0.04;
/// A gust across the track turns it by the gust over the speed. Variance of 2 m/s, (m/s)^2: 0.8 m/s that last
/// for several fixes.
const GUST_M2PS2: f32 = 4.0;

/// Shortest and longest time between two fixes that are used, seconds. The error model is still linear over
/// the longest.
const SHORTEST_S: f32 = 0.9;
const LONGEST_S: f32 = 20.0;
/// Speed below which a track gives no heading, m/s.
const LEAST_SPEED_MPS: f32 = 5.0;
/// A velocity further off than this many sigmas, squared, is refused; after this many refusals in a row the
/// filter is wrong.
const GATE: f32 = 25.0;
const REFUSALS: u8 = 5;
/// Fixes, one a second, after which a match counts as good: from [`START`] its tilts are by then known to
/// 0.005 rad, and the gyro's bias, which would change them within the next fixes, to 0.001 rad/s. A later
/// contradiction is a disturbance, not an error of the level at the start.
const LASTING: u8 = 10;

/// Work of the next inertial sample.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Stage {
    Idle,
    Compare(Fix),
    /// Transition of one state.
    Propagate {
        state: usize,
        seconds: f32,
        gained: [f32; 3],
        fix: Apart,
    },
    /// Noise of one state.
    Diffuse {
        state: usize,
        seconds: f32,
        fix: Apart,
    },
    Measure(Component, Apart),
    FeedBack,
}

/// Measured component of a fix.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Component {
    North,
    East,
    Track,
}

/// A fix, and the values computed for its time.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Fix {
    /// Time since the last one, seconds.
    seconds: f32,
    /// Integral of the specific force since then, m/s.
    gained: Vector,
    velocity_mps: [f32; 2],
    integrated_mps: [f32; 2],
    /// North and east parts of the body's x.
    ahead: [f32; 2],
}

/// Difference of a fix from the values computed for its time.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Apart {
    velocity_mps: [f32; 2],
    /// Track less heading less crab (rad), and its variance; `None` if the speed is too low for a track.
    track: Option<[f32; 2]>,
    /// Square of the change of track since the last fix, rad^2.
    turned: f32,
}

/// Row of a measurement of one state, or of the sum of two.
const fn row_of(first: usize, second: usize) -> Row<STATES> {
    let mut tail = [0.0; STATES];
    tail[first] = 1.0;
    tail[second] = 1.0;
    Row { head: None, tail, first }
}

/// Transition of a state by the angles and by the gyro's bias.
const fn row([a, b, c]: Vector, [x, y, z]: Vector) -> [f32; STATES] {
    let mut row = [0.0; STATES];
    [row[TILT], row[TILT + 1], row[HEADING]] = [a, b, c];
    [row[BIAS], row[BIAS + 1], row[BIAS + 2]] = [x, y, z];
    row
}

/// A direction in the level plane from its components; `None` if they are too short.
fn unit([north, east]: [f32; 2], least: f32) -> Option<[f32; 2]> {
    let squared = north * north + east * east;
    if squared < least * least {
        return None;
    }
    let scale = reciprocal_root(squared);
    Some([north * scale, east * scale])
}

/// The track of a velocity, and north in body axes if the nose points along the track; `None` if it cannot be
/// determined.
fn directions(velocity_mps: [f32; 2], down: &Down) -> Option<([f32; 2], Vector)> {
    let track = unit(velocity_mps, LEAST_SPEED_MPS)?;
    let down = down.get();
    let level = 1.0 - down[0] * down[0];
    if level < 0.25 {
        return None;
    }
    // The body's x made level, and the direction to its right.
    let ahead = scaled(difference([1.0, 0.0, 0.0], scaled(down, down[0])), reciprocal_root(level));
    let right = cross(down, ahead);
    let [cosine, sine] = track;
    Some((track, difference(scaled(ahead, cosine), scaled(right, sine))))
}

#[derive(Clone, Debug, PartialEq)]
pub(super) struct VelocityMatch {
    filter: UdFilter<0, STATES>,
    north: Down,
    /// Integrated horizontal velocity, m/s.
    velocity: [Sum; 2],
    crab_rad: f32,
    /// Track of the last fix that was used.
    track: [f32; 2],
    last_force: Option<Vector>,
    /// Integral of the specific force since the last fix that was used, m/s.
    gained: Vector,
    fix_us: u64,
    refusals: u8,
    /// Number of fixes that agreed with it.
    agreed: u8,
    /// Variances of velocity ((m/s)^2) and angle (rad^2) from gaps between samples since the last fix.
    bridged: [f32; 2],
    stage: Stage,
}

impl VelocityMatch {
    /// A match without a fix.
    const BLANK: Self = Self {
        filter: {
            let [tilt, heading, bias, velocity] = START;
            UdFilter::at_zero([], [velocity, velocity, tilt, tilt, heading, bias, bias, bias, heading])
        },
        north: Down::from_unit([0.0; 3]),
        velocity: [Sum::new(0.0); 2],
        crab_rad: 0.0,
        track: [0.0; 2],
        last_force: None,
        gained: [0.0; 3],
        fix_us: 0,
        refusals: 0,
        agreed: 0,
        bridged: [0.0; 2],
        stage: Stage::Idle,
    };

    /// Starts again in `matching` from a fix's north and east velocity, m/s; `None` if the track gives no
    /// heading, or the nose points up or down. Built in place and mostly from a constant: it is large, and
    /// starts in a tick that also has to process a fix.
    pub(super) fn begin(
        matching: &mut Option<Self>,
        time_us: u64,
        [north_mps, east_mps]: [f32; 2],
        down: &Down,
    ) {
        let Some((track, north)) = directions([north_mps, east_mps], down) else {
            *matching = None;
            return;
        };
        let begun = matching.insert(Self::BLANK);
        begun.north = Down::from_unit(north);
        begun.velocity = [Sum::new(north_mps), Sum::new(east_mps)];
        begun.track = track;
        begun.fix_us = time_us;
    }

    /// Whether the last velocity contradicted it.
    pub(super) const fn is_doubted(&self) -> bool {
        self.refusals > 0
    }

    /// Whether velocities have contradicted it once too often.
    pub(super) const fn is_contradicted(&self) -> bool {
        self.refusals >= REFUSALS
    }

    /// Whether a velocity has agreed with it.
    pub(super) const fn has_agreed(&self) -> bool {
        self.agreed > 0
    }

    /// Whether it has agreed with velocities for [`LASTING`] seconds.
    pub(super) const fn has_lasted(&self) -> bool {
        self.agreed >= LASTING
    }

    /// Whether fixes have been absent for so long that the match is void.
    pub(super) fn is_void(&self, time_us: u64) -> bool {
        self.is_contradicted() || seconds_between(self.fix_us, time_us) > LONGEST_S
    }

    /// Takes a sample: `angle` is the rotation of the axes since the last one (rad, body), already applied to
    /// `down`. Corrects `down` and `gyro_bias` when an update is due.
    pub(super) fn take(
        &mut self,
        down: &mut Down,
        gyro_bias: &mut [Sum; 3],
        force: Vector,
        angle: Vector,
        step_s: f32,
    ) {
        self.north.rotate(angle);
        let [north, east, vertical] = self.axes(down);
        let now = [dot(north, force), dot(east, force), dot(vertical, force)];
        let before = self.last_force.replace(now).unwrap_or(now);
        for axis in 0..3 {
            let gained = 0.5 * step_s * (before[axis] + now[axis]);
            self.gained[axis] += gained;
            if let Some(velocity) = self.velocity.get_mut(axis) {
                velocity.add(gained);
            }
        }
        match self.stage {
            Stage::Idle => {}
            Stage::Compare(fix) => {
                let Fix { seconds, gained, .. } = fix;
                self.stage = Stage::Propagate { state: 0, seconds, gained, fix: self.compare(&fix) };
            }
            Stage::Propagate { state, seconds, gained, fix } => {
                self.stage = if state + 1 < BIAS {
                    Stage::Propagate { state: state + 1, seconds, gained, fix }
                } else {
                    Stage::Diffuse { state: 0, seconds, fix }
                };
                if self.propagate(state, down, seconds, gained).is_err() {
                    self.refusals = REFUSALS;
                }
            }
            Stage::Diffuse { state, seconds, fix } => {
                if self.diffuse(state, seconds, fix.turned).is_err() {
                    self.refusals = REFUSALS;
                }
                self.stage = if state + 1 < STATES {
                    if state == HEADING {
                        self.bridged = [0.0; 2];
                    }
                    Stage::Diffuse { state: state + 1, seconds, fix }
                } else if self.is_plausible(&fix) {
                    self.refusals = 0;
                    self.agreed = self.agreed.saturating_add(1);
                    Stage::Measure(Component::North, fix)
                } else {
                    self.refusals = self.refusals.saturating_add(1);
                    Stage::Idle
                };
            }
            Stage::Measure(component, fix) => {
                self.stage = match component {
                    Component::North => Stage::Measure(Component::East, fix),
                    Component::East => Stage::Measure(Component::Track, fix),
                    Component::Track => Stage::FeedBack,
                };
                if self.measure(component, &fix).is_err() {
                    self.refusals = REFUSALS;
                }
            }
            Stage::FeedBack => {
                self.stage = Stage::Idle;
                self.filter.fold();
                self.feed_back(down, gyro_bias);
            }
        }
    }

    /// North, east and down in body axes.
    fn axes(&self, down: &Down) -> [Vector; 3] {
        let (north, down) = (self.north.get(), down.get());
        [north, cross(down, north), down]
    }

    #[cfg(test)]
    pub(super) fn variance(&self, state: usize) -> f32 {
        self.filter.variance(state)
    }

    /// Drops the part of a fix that is not processed yet: from now on only samples count. The processed part
    /// that is not fed back stays in the filter's state, for the next time.
    pub(super) fn hold(&mut self) {
        self.stage = Stage::Idle;
    }

    /// Adds the cost of a gap between samples, (m/s)^2 and rad^2.
    pub(super) fn bridge(&mut self, velocity_m2ps2: f32, angle_rad2: f32) {
        self.bridged[0] += velocity_m2ps2;
        self.bridged[1] += angle_rad2;
    }

    /// Takes the velocity of a fix, m/s, if one is due.
    pub(super) fn reference(&mut self, time_us: u64, velocity_mps: [f32; 2], down: &Down) {
        let seconds = seconds_between(self.fix_us, time_us);
        if self.stage != Stage::Idle || seconds < SHORTEST_S {
            return;
        }
        let [north, east, _] = self.axes(down);
        self.stage = Stage::Compare(Fix {
            seconds,
            gained: self.gained,
            velocity_mps,
            integrated_mps: self.velocity.map(Sum::value),
            ahead: [north[0], east[0]],
        });
        self.gained = [0.0; 3];
        self.fix_us = time_us;
    }

    /// Difference of the fix from the values computed for its time.
    fn compare(&mut self, fix: &Fix) -> Apart {
        let ([fixed_north, fixed_east], [north, east]) = (fix.velocity_mps, fix.integrated_mps);
        let mut apart =
            Apart { velocity_mps: [north - fixed_north, east - fixed_east], track: None, turned: 0.0 };
        let ahead = unit(fix.ahead, 0.5);
        let track = unit(fix.velocity_mps, LEAST_SPEED_MPS);
        if let (Some([ahead_north, ahead_east]), Some([track_north, track_east])) = (ahead, track) {
            let sine = ahead_north * track_east - ahead_east * track_north;
            let cosine = ahead_north * track_north + ahead_east * track_east;
            let speed_squared = fixed_north * fixed_north + fixed_east * fixed_east;
            apart.track = Some([libm::atan2f(sine, cosine) - self.crab_rad, GUST_M2PS2 / speed_squared]);
            let turned = self.track[0] * track_east - self.track[1] * track_north;
            apart.turned = turned * turned;
            self.track = [track_north, track_east];
        }
        apart
    }

    /// Propagates one state by later ones; biases and crab angle stay as they are. The axes are those of this
    /// sample: those at the end of the interval are no better, and the few samples between the first state
    /// and the last are negligible.
    fn propagate(
        &mut self,
        state: usize,
        down: &Down,
        seconds: f32,
        gained: Vector,
    ) -> Result<(), FilterError> {
        let by_bias = self.axes(down).map(|axis| scaled(axis, -seconds));
        // Velocity by the tilt in the middle of the interval: half of the bias's effect on it.
        let [north, east, fall] = gained;
        let [a, b, c] = by_bias;
        let velocity = |parts: Vector| {
            let bias = sum(sum(scaled(a, parts[0]), scaled(b, parts[1])), scaled(c, parts[2]));
            row(parts, scaled(bias, 0.5))
        };
        let moved = match state {
            0 => velocity([0.0, -fall, east]),
            1 => velocity([fall, 0.0, -north]),
            2 => row([0.0; 3], a),
            3 => row([0.0; 3], b),
            _ => row([0.0; 3], c),
        };
        self.filter.propagate_row(state, &moved)
    }

    fn diffuse(&mut self, state: usize, seconds: f32, turned: f32) -> Result<(), FilterError> {
        let variance = match state {
            VELOCITY..TILT => VELOCITY_DENSITY * seconds + self.bridged[0],
            TILT..BIAS => ANGLE_DENSITY * seconds + self.bridged[1],
            BIAS..CRAB => BIAS_DENSITY * seconds,
            _ => CRAB_DENSITY * seconds + CRAB_BY_TURN * turned,
        };
        self.filter.add_tail_noise(state, variance)
    }

    fn is_plausible(&self, fix: &Apart) -> bool {
        fix.velocity_mps
            .into_iter()
            .zip(VELOCITY..)
            .all(|(apart, state)| apart * apart <= GATE * (self.filter.variance(state) + FIX_M2PS2))
    }

    fn measure(&mut self, component: Component, fix: &Apart) -> Result<(), FilterError> {
        let [north, east] = fix.velocity_mps;
        let (row, value, variance) = match component {
            Component::North => (const { row_of(VELOCITY, VELOCITY) }, north, FIX_M2PS2),
            Component::East => (const { row_of(VELOCITY + 1, VELOCITY + 1) }, east, FIX_M2PS2),
            Component::Track => match fix.track {
                Some([apart_rad, variance]) => (const { row_of(HEADING, CRAB) }, apart_rad, variance),
                None => return Ok(()),
            },
        };
        self.filter.update(&row, value, NoiseVariance::new(variance)?).map(|_| ())
    }

    /// Corrects the quantities by the error states, and sets the states to zero.
    fn feed_back(&mut self, down: &mut Down, gyro_bias: &mut [Sum; 3]) {
        let error = *self.filter.tail();
        let axes = self.axes(down);
        let [north, east, vertical] = axes;
        let tilt = sum(scaled(north, -error[TILT]), scaled(east, -error[TILT + 1]));
        let turn = sum(tilt, scaled(vertical, -error[HEADING]));
        down.rotate(turn);
        self.north.rotate(turn);
        // Rounding lets the two axes lean towards each other by some 1e-7 a tick.
        let lean = dot(self.north.get(), down.get());
        let straight = down.get().map(|part| -lean * part);
        self.north.shift(straight);
        for axis in 0..3 {
            gyro_bias[axis].add(error[BIAS + axis]);
        }
        for axis in 0..2 {
            self.velocity[axis].add(-error[VELOCITY + axis]);
        }
        self.crab_rad += error[CRAB];
        for (state, value) in error.into_iter().enumerate() {
            // Cannot fail: a finite value of an existing state.
            let _ = self.filter.shift_tail(state, -value);
        }
        self.filter.fold();
    }
}
