//! The double integrals of the inertial effects, from launch on.

use serde::{Deserialize, Serialize};

use super::catalogue::Uses;
use super::inertial::Inertial;
use super::integral::DoubleIntegral;
use super::reference_motion::ReferenceMotion;

/// Mean radius of the earth, m (WGS 84, R1).
const EARTH_RADIUS_M: f32 = 6_371_008.8;
/// Vertical gradient of gravity in free air, 1/s^2.
const GRAVITY_GRADIENT_PS2: f32 = 3.086e-6;

/// Source of the forward acceleration.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum AccelerationSource {
    /// Specific force and attitude.
    Inertial,
    /// Changes of the speed over ground, along the track: used if specific force or attitude was missing at
    /// launch.
    GroundSpeed,
}

impl AccelerationSource {
    /// The best source available now.
    pub(super) fn now(inertial: &Inertial, motion: &ReferenceMotion) -> Option<Self> {
        if inertial.is_complete() {
            return Some(Self::Inertial);
        }
        motion.velocity_mps().map(|_| Self::GroundSpeed)
    }
}

/// One tick's step of the integrals.
pub(super) struct Step<'a> {
    pub uses: Uses,
    /// Since the last tick.
    pub seconds: f32,
    /// Since launch.
    pub elapsed_s: f32,
    pub has_fix: bool,
    pub height_gained_m: Option<f32>,
    /// `2 Omega cos(latitude)`, rad/s.
    pub eastward_radps: f32,
    pub inertial: &'a Inertial,
    pub motion: &'a ReferenceMotion,
}

/// The integrals; all zero at launch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct FreeFlightIntegrals {
    /// Decided once, at the first tick that has a source.
    pub source: Option<AccelerationSource>,
    /// Horizontal speed that [`Self::forward`] has reached, m/s, where that is its source.
    integrated_speed_mps: Option<f32>,
    /// Constant error of the accelerometers' forward acceleration, m/s^2.
    pub forward_error_mps2: f32,
    pub vertical: DoubleIntegral,
    pub forward: DoubleIntegral,
    pub turning: DoubleIntegral,
    pub gravity: DoubleIntegral,
    pub eotvos: DoubleIntegral,
}

impl FreeFlightIntegrals {
    /// Integrals from zero, without this constant error of the accelerometers' forward acceleration, m/s^2.
    pub(super) fn from_launch(forward_error_mps2: f32) -> Self {
        Self { forward_error_mps2, ..Self::default() }
    }

    /// Advances by one tick; false where a number overflowed and was not taken.
    pub(super) fn advance(&mut self, step: &Step<'_>) -> bool {
        let mut is_taken = true;
        if step.uses.any_of(Uses::VERTICAL.and(Uses::FORWARD)) {
            let accelerations = step.inertial.upward_and_forward_mps2();
            if let (true, Some([upward_mps2, _])) = (step.uses.any_of(Uses::VERTICAL), accelerations) {
                is_taken &= self.vertical.advance(step.seconds, upward_mps2);
            }
            if step.uses.any_of(Uses::FORWARD) {
                is_taken &= self.advance_forward(step, accelerations.map(|[_, forward]| forward));
            }
        }
        if let (true, Some(gained_m)) = (step.uses.any_of(Uses::GRAVITY), step.height_gained_m) {
            is_taken &= self.gravity.advance(step.seconds, GRAVITY_GRADIENT_PS2 * gained_m);
        }
        if let (true, Some([north, east])) = (step.uses.any_of(Uses::EOTVOS), step.motion.velocity_mps()) {
            let curved_mps2 = (north * north + east * east) * (1.0 / EARTH_RADIUS_M);
            is_taken &= self.eotvos.advance(step.seconds, step.eastward_radps * east + curved_mps2);
        }
        is_taken
    }

    fn advance_forward(&mut self, step: &Step<'_>, forward_mps2: Option<f32>) -> bool {
        self.source = self.source.or_else(|| AccelerationSource::now(step.inertial, step.motion));
        match (self.source, forward_mps2) {
            (Some(AccelerationSource::Inertial), Some(forward_mps2)) => {
                let forward_mps2 = forward_mps2 - self.forward_error_mps2;
                self.forward.advance(step.seconds, forward_mps2)
                    & self.turning.advance(step.seconds, forward_mps2 * step.elapsed_s)
            }
            (Some(AccelerationSource::GroundSpeed), _) => {
                let is_new = step.has_fix || self.integrated_speed_mps.is_none();
                let speed_mps = if is_new { step.motion.horizontal_speed_mps() } else { None };
                let gained_mps = match (speed_mps, self.integrated_speed_mps) {
                    (Some(now), Some(before)) => now - before,
                    _ => 0.0,
                };
                self.integrated_speed_mps = speed_mps.or(self.integrated_speed_mps);
                self.forward.kick(step.seconds, gained_mps)
                    & self.turning.kick(step.seconds, gained_mps * step.elapsed_s)
            }
            _ => true,
        }
    }
}
