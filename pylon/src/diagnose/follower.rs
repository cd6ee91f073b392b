//! Follows the ticks of a flight the way the mission does, for the diagnosis: phases, signals, and the altitude gained.

use std::collections::VecDeque;

use kf_core::config::ReferenceConfig;
use kf_core::effect::{EffectId, SignalTracker};
use kf_core::input::TickInput;
use kf_core::reference::ReferenceTracker;
use kf_core::sensor::SENSORS;
use model::Model;

use super::candidates::Candidate;
use super::reference_path::Reference;
use super::smoothed_climb::SmoothedClimb;

/// Follows the ticks the way the mission does: settling, calibration, free flight.
pub(super) struct Follower {
    pub(super) tracker: SignalTracker,
    reference: ReferenceTracker,
    settling_us: u64,
    first_us: Option<u64>,
    last_us: Option<u64>,
    calibrating: bool,
    free: bool,
    climb: Option<Climb>,
    /// Climb at the start of the calibration, metres.
    climb_base_m: Option<f64>,
    /// Altitude of the first fix of the calibration, metres.
    altitude_base_m: Option<f64>,
    /// The climb at launch.
    launch: Option<LaunchClimb>,
    /// The last climb rates, m/s, from which the one at launch is averaged.
    recent_mps: VecDeque<(u64, f64)>,
}

/// The climb at launch.
#[derive(Clone, Copy)]
struct LaunchClimb {
    time_us: u64,
    climbed_m: f64,
    rate_mps: f64,
}

/// Climb rates of that long before launch are averaged, microseconds.
const BEFORE_LAUNCH_US: u64 = 1_000_000;

/// Integral of the climb rate at the last fix.
#[derive(Clone, Copy)]
struct Climb {
    time_us: u64,
    metres: f64,
    rate_mps: f64,
}

/// Where a tick stands.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Phase {
    Ignored,
    Captive,
    Free,
}

impl Follower {
    pub(super) fn new(model: &Model) -> Self {
        let reference = ReferenceConfig { lost_after_s: model.reference.lost_after_s, ..model.reference };
        let mut tracker = SignalTracker::default();
        tracker.set_latitude_deg(model.latitude_deg);
        Self {
            tracker,
            reference: ReferenceTracker::new(&reference),
            settling_us: (f64::from(model.settling_s) * 1e6) as u64,
            first_us: None,
            last_us: None,
            calibrating: false,
            free: false,
            climb: None,
            climb_base_m: None,
            altitude_base_m: None,
            launch: None,
            recent_mps: VecDeque::new(),
        }
    }

    /// Altitude gained since the start of the calibration by the integral of the climb rate, metres.
    pub(super) fn climbed_m(&self, time_us: u64) -> Option<f64> {
        let climb = self.climb?;
        let since_s = time_us.saturating_sub(climb.time_us) as f64 * 1e-6;
        Some(climb.metres + climb.rate_mps * since_s - self.climb_base_m?)
    }

    /// A candidate's regressor now, metres per unit.
    ///
    /// The altitude gained is taken from the climb rate where there is one, else averaged over some seconds:
    /// the fixes' own altitude has the reference's error in it, which the residual has too, so that in level
    /// flight the one explains the other with a coefficient of -1. The climb rate is taken between the fixes:
    /// held since the last one it is late by half their interval, and that is what an acceleration would look like.
    pub(super) fn regressor_m(&self, candidate: &Candidate, moment: &Moment) -> Option<f64> {
        let regressor = candidate.regressor;
        match regressor.id {
            EffectId::BaroScale => {
                let gained_m = || Some(moment.reference.smooth_m - self.altitude_base_m?);
                self.climbed_m(moment.time_us).or_else(gained_m)
            }
            EffectId::BaroLag | EffectId::GpsLatency => {
                moment.climb.mps(candidate.smoothing_s).map(|mps| -mps)
            }
            // The second integral of the vertical acceleration since launch: what was climbed, but for the climb
            // rate at launch. The receiver's own says it without the attitude's error in it.
            EffectId::ImuAccelScale => match (self.launch, self.climbed_m(moment.time_us)) {
                (None, Some(_)) => Some(0.0),
                (Some(launch), Some(climbed_m)) => {
                    let since_s = moment.time_us.saturating_sub(launch.time_us) as f64 * 1e-6;
                    Some(climbed_m - launch.climbed_m - launch.rate_mps * since_s)
                }
                (_, None) => self.tracker.regressor_m(regressor).map(f64::from),
            },
            _ => self.tracker.regressor_m(regressor).map(f64::from),
        }
    }

    /// Takes a tick; says its phase and whether its fix is a measurement.
    pub(super) fn take(&mut self, input: &TickInput) -> (Phase, bool) {
        if self.last_us.is_some_and(|last_us| input.time_us <= last_us) {
            return (Phase::Ignored, false);
        }
        self.last_us = Some(input.time_us);
        let first_us = *self.first_us.get_or_insert(input.time_us);
        let taken = input.gps.and_then(|fix| Some((fix, self.reference.take(input.time_us, &fix).ok()?)));
        if let Some((fix, measured)) = taken
            && let (Some(rest_m), Some(down_mps)) = (measured.altitude_minus_climb_m, fix.velocity_down_mps)
        {
            self.climb = Some(Climb {
                time_us: input.time_us,
                metres: f64::from(fix.altitude_m) - f64::from(rest_m),
                rate_mps: -f64::from(down_mps),
            });
        }
        if let (false, Some((fix, _))) = (self.free, taken)
            && let Some(down_mps) = fix.velocity_down_mps
        {
            self.recent_mps.push_back((input.time_us, -f64::from(down_mps)));
            while self.recent_mps.front().is_some_and(|(at, _)| input.time_us - at > BEFORE_LAUNCH_US) {
                self.recent_mps.pop_front();
            }
        }
        if self.calibrating && self.climb_base_m.is_none() {
            self.climb_base_m = self.climb.map(|climb| climb.metres);
        }
        if self.calibrating && self.altitude_base_m.is_none() {
            self.altitude_base_m = taken.map(|(fix, _)| f64::from(fix.altitude_m));
        }
        let accepted = taken.is_some();
        if !self.calibrating && input.time_us - first_us >= self.settling_us {
            self.calibrating = true;
            self.tracker.begin_calibration();
        }
        if input.launch && !self.free {
            self.free = true;
            self.launch = self.climbed_m(input.time_us).map(|climbed_m| LaunchClimb {
                time_us: input.time_us,
                climbed_m,
                rate_mps: self.recent_mps.iter().map(|(_, rate)| rate).sum::<f64>()
                    / self.recent_mps.len().max(1) as f64,
            });
            self.tracker.begin_free_flight(input.time_us);
        }
        self.tracker.take(input, input.gps.as_ref().filter(|_| accepted));
        let phase = match (self.free, self.calibrating) {
            (true, _) => Phase::Free,
            (false, true) => Phase::Captive,
            (false, false) => Phase::Ignored,
        };
        (phase, accepted)
    }
}

/// Readings, and the reference at their time.
pub(super) struct Moment {
    pub(super) time_us: u64,
    pub(super) reference: Reference,
    pub(super) climb: SmoothedClimb,
    pub(super) readings: [Option<f64>; SENSORS],
}
