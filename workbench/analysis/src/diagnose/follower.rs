//! Follows the ticks of a flight as the mission does, for the diagnosis: phases, signals, which inputs are
//! measurements, and the altitude gained. It has no filter, so it accepts what the mission refuses for being
//! far from its filter's prediction.

use std::collections::VecDeque;

use kf_core::atmosphere::pressure_altitude_m;
use kf_core::config::ReferenceConfig;
use kf_core::effect::{EffectId, Regressor, SignalTracker};
use kf_core::input::{BaroReading, GpsFix, TickInput};
use kf_core::plausible;
use kf_core::reading::StuckDetector;
use kf_core::reference::ReferenceTracker;
use kf_core::sensor::SENSORS;
use model::Model;

use super::candidates::Candidate;
use super::delay::DelayedClimb;
use super::formulas::Formulas;
use super::forward_motion::ForwardMotion;
use super::reference_path::Reference;

/// Follows the ticks as the mission does: settling, calibration, free flight.
pub(super) struct Follower {
    pub(super) tracker: SignalTracker,
    formulas: Formulas,
    reference: ReferenceTracker,
    stuck: [StuckDetector; SENSORS],
    sigma_m: [f32; SENSORS],
    reference_sigma_m: f32,
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
    forward: ForwardMotion,
}

/// The climb at launch.
#[derive(Clone, Copy)]
struct LaunchClimb {
    time_us: u64,
    climbed_m: f64,
    rate_mps: f64,
}

/// Climb rates of this time before launch are averaged, microseconds.
const BEFORE_LAUNCH_US: u64 = 1_000_000;

/// Integral of the climb rate at the last fix.
#[derive(Clone, Copy)]
struct Climb {
    time_us: u64,
    metres: f64,
    rate_mps: f64,
}

/// A tick as the mission accepts it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Taken {
    pub(super) phase: Phase,
    /// Whether its fix is a measurement.
    pub(super) has_fix: bool,
    /// The readings that are measurements, by sensor, metres.
    pub(super) readings_m: [Option<f64>; SENSORS],
    /// How many readings were invalid: not finite, implausible, or of a sensor that is stuck.
    pub(super) refused: u32,
}

/// The phase of a tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Phase {
    Ignored,
    Captive,
    Free,
}

impl Follower {
    /// A follower that also computes these regressors, whatever their time constants.
    pub(super) fn knowing(model: &Model, regressors: impl IntoIterator<Item = Regressor>) -> Self {
        Self { formulas: Formulas::of(model, regressors), ..Self::new(model) }
    }

    /// The current value of the regressor, metres per unit, as in the estimator.
    pub(super) fn value_m(&self, regressor: Regressor) -> Option<f32> {
        match regressor.id {
            EffectId::Defined(_) => self.formulas.value_m(regressor),
            _ => self.tracker.regressor_m(regressor),
        }
    }

    pub(super) fn new(model: &Model) -> Self {
        let reference = ReferenceConfig { lost_after_s: model.reference.lost_after_s, ..model.reference };
        let mut tracker = SignalTracker::default();
        tracker.set_latitude_deg(model.latitude_deg);
        Self {
            tracker,
            formulas: Formulas::of(model, None),
            reference: ReferenceTracker::new(&reference),
            stuck: std::array::from_fn(|_| StuckDetector::default()),
            sigma_m: std::array::from_fn(|i| model.sensors[i].sigma_m),
            reference_sigma_m: model.reference.sigma_m,
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
            forward: ForwardMotion::default(),
        }
    }

    /// Altitude gained since the start of the calibration, by integrating the climb rate, metres.
    pub(super) fn climbed_m(&self, time_us: u64) -> Option<f64> {
        let climb = self.climb?;
        let since_s = time_us.saturating_sub(climb.time_us) as f64 * 1e-6;
        Some(climb.metres + climb.rate_mps * since_s - self.climb_base_m?)
    }

    /// A candidate's current regressor, metres per unit.
    ///
    /// The altitude gained is taken from the climb rate if there is one, else from the path that all
    /// altitudes show (`latent_path`). The fixes' own altitude contains the reference's error, which the
    /// residual contains too, so in level flight the one would explain the other with a coefficient of -1.
    /// The climb rate is interpolated between the fixes: held since the last one it would be late by half
    /// their interval, which would look like an acceleration.
    pub(super) fn regressor_m(&self, candidate: &Candidate, moment: &Moment) -> Option<f64> {
        let regressor = candidate.regressor;
        match regressor.id {
            EffectId::BaroScale => {
                let gained_m = || Some(moment.reference.smooth_m - self.altitude_base_m?);
                self.climbed_m(moment.time_us).or_else(gained_m)
            }
            EffectId::BaroLag | EffectId::GpsLatency => moment.climb.mps(candidate.delay).map(|mps| -mps),
            // The second integral of the vertical acceleration since launch: the altitude gained less the
            // part from the climb rate at launch. The receiver's altitude gives it without the attitude's
            // error.
            EffectId::ImuAccelScale => match (self.launch, self.climbed_m(moment.time_us)) {
                (None, Some(_)) => Some(0.0),
                (Some(launch), Some(climbed_m)) => {
                    let since_s = moment.time_us.saturating_sub(launch.time_us) as f64 * 1e-6;
                    Some(climbed_m - launch.climbed_m - launch.rate_mps * since_s)
                }
                (_, None) => self.raw_m(regressor).map(f64::from),
            },
            EffectId::ImuTilt if candidate.signal.is_by_velocity => {
                self.forward.integrals(moment.time_us).map(|[forward_m, _]| forward_m)
            }
            EffectId::ImuGyroBias if candidate.signal.is_by_velocity => {
                self.forward.integrals(moment.time_us).map(|[_, turning_m_s]| turning_m_s)
            }
            EffectId::BaroAngleOfAttack if candidate.signal.offset_rad != 0.0 => {
                let head = Regressor { id: EffectId::BaroDynamicPressure, ..regressor };
                let turned_m = f64::from(candidate.signal.offset_rad) * f64::from(self.raw_m(head)?);
                self.raw_m(regressor).map(|metres| f64::from(metres) + turned_m)
            }
            _ => self.raw_m(regressor).map(f64::from),
        }
    }

    /// A regressor as in the mission, metres per unit.
    pub(super) fn raw_m(&self, regressor: Regressor) -> Option<f32> {
        match regressor.id {
            EffectId::Defined(_) => self.formulas.value_m(regressor),
            _ => self.tracker.regressor_m(regressor),
        }
    }

    /// Processes a tick.
    pub(super) fn take(&mut self, input: &TickInput) -> Taken {
        if self.last_us.is_some_and(|last_us| input.time_us <= last_us) {
            return Taken { phase: Phase::Ignored, has_fix: false, readings_m: [None; SENSORS], refused: 0 };
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
            self.formulas.begin_calibration();
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
            self.forward.launch(input.time_us);
        }
        let fix = input.gps.as_ref().filter(|_| accepted);
        self.take_forward(input, fix);
        self.tracker.take(input, fix);
        self.formulas.take(input, fix, &self.tracker);
        let phase = match (self.free, self.calibrating) {
            (true, _) => Phase::Free,
            (false, true) => Phase::Captive,
            (false, false) => Phase::Ignored,
        };
        let (readings_m, refused) = self.measurements(input);
        Taken { phase, has_fix: accepted, readings_m, refused }
    }

    fn take_forward(&mut self, input: &TickInput, fix: Option<&GpsFix>) {
        if let Some([.., heading_rad]) = input.signals.attitude_rad {
            self.forward.turn_to(heading_rad);
        }
        let velocity = fix.and_then(|fix| fix.velocity_north_mps.zip(fix.velocity_east_mps));
        if let Some((north, east)) = velocity {
            self.forward.take(input.time_us, [north, east]);
        }
    }

    /// The valid readings, and the number of invalid ones.
    fn measurements(&mut self, input: &TickInput) -> ([Option<f64>; SENSORS], u32) {
        let baro_m = input.baro.map(|reading| match reading {
            BaroReading::PressurePa(pressure_pa) => pressure_altitude_m(pressure_pa).unwrap_or(f32::NAN),
            BaroReading::AltitudeM(altitude_m) => altitude_m,
        });
        let raw_m = [input.imu_master_altitude_m, input.imu_slave_altitude_m, baro_m];
        let reference_m = self.reference.altitude_m(input.time_us);
        let mut readings_m = [None; SENSORS];
        let mut refused = 0;
        for (i, raw_m) in raw_m.into_iter().enumerate() {
            let Some(raw_m) = raw_m else { continue };
            let is_measurement = plausible::altitude(raw_m).is_none()
                && !self.stuck[i].is_stuck(
                    input.time_us,
                    raw_m,
                    reference_m,
                    self.sigma_m[i],
                    self.reference_sigma_m,
                );
            if is_measurement {
                readings_m[i] = Some(f64::from(raw_m));
            } else {
                refused += 1;
            }
        }
        (readings_m, refused)
    }
}

/// Readings, and the reference at their time.
pub(super) struct Moment {
    pub(super) time_us: u64,
    pub(super) reference: Reference,
    pub(super) climb: DelayedClimb,
    pub(super) readings: [Option<f64>; SENSORS],
}

#[cfg(test)]
mod tests {
    use std::fmt::Write as _;

    use kf_core::output::{Phase as MissionPhase, Rejection};
    use replay::Replay;

    use super::*;

    /// Two minutes at 10 Hz, launched after one, with some spoilt samples.
    fn spoilt() -> flight_data::Flight {
        let mut csv = "# pylon-flight: 1\ntime_s,launch,gps_alt_m,gps_vn_mps,gps_ve_mps,gps_vd_mps,baro_alt_m,imu_slave_alt_m\n"
            .to_owned();
        for k in 0..1200_u32 {
            let t = 0.1 * f64::from(k);
            let rough = f64::from((k * 37) % 19) / 19.0 - 0.5;
            let altitude_m = 500.0 + 60.0 * (t / 9.0).sin();
            // A barometer that is stuck for six seconds, before the launch and after it, and has one
            // nonsensical reading.
            let baro_m = match k {
                300..360 | 800..860 => 498.25,
                700 => 5.0e6,
                _ => altitude_m + 3.0 + rough,
            };
            // A fix a second, one of them a repetition of the last one; altitudes and times that no aircraft
            // has.
            let fix = match k {
                500 => "200000,0,0,0".to_owned(),
                410 => format!("{:.3},30,40,0", 500.0 + 60.0 * (40.0_f64 / 9.0).sin()),
                _ if k % 10 == 0 => format!("{altitude_m:.3},30,40,0"),
                _ => ",,,".to_owned(),
            };
            let time_s = if k == 650 { t - 0.3 } else { t };
            let _ = writeln!(
                csv,
                "{time_s:.3},{},{fix},{baro_m:.3},{:.3}",
                u8::from(k >= 600),
                altitude_m - 2.0 + rough
            );
        }
        flight_data::parse(csv.as_bytes()).unwrap().0
    }

    /// The follower and the mission see the same flight, except for what the mission's filter refuses as far
    /// from its prediction.
    #[test]
    fn a_tick_is_to_the_follower_what_it_is_to_the_mission() {
        let flight = spoilt();
        let replay = Replay::new(&flight, &Model::default(), None).unwrap();
        let mut follower = Follower::new(replay.model());
        let (mut stuck, mut implausible, mut held, mut out_of_order) = (0, 0, 0, 0);
        let summary = replay.run(&mut |input, output| {
            let taken = follower.take(input);
            if output.out_of_order {
                out_of_order += 1;
                assert_eq!(taken.phase, Phase::Ignored);
                return;
            }
            let phase = match output.phase {
                MissionPhase::Settling => Phase::Ignored,
                MissionPhase::Calibrating => Phase::Captive,
                MissionPhase::FreeFlight => Phase::Free,
            };
            assert_eq!(taken.phase, phase, "{}", input.time_us);
            let is_other =
                |rejection: Option<Rejection>| rejection.is_some_and(|why| why != Rejection::Gated);
            held += u32::from(output.gps_rejection == Some(Rejection::Held));
            assert_eq!(
                taken.has_fix,
                input.gps.is_some() && !is_other(output.gps_rejection),
                "{}",
                input.time_us
            );
            for (reading_m, sensor) in taken.readings_m.iter().zip(&output.sensors) {
                stuck += u32::from(sensor.rejection == Some(Rejection::Stuck));
                implausible += u32::from(sensor.rejection == Some(Rejection::Implausible));
                assert!(reading_m.is_none() || !is_other(sensor.rejection), "{}", input.time_us);
            }
            let refused = output.sensors.iter().filter(|sensor| is_other(sensor.rejection)).count();
            assert_eq!(taken.refused as usize, refused, "{}", input.time_us);
        });
        assert!(summary.unwrap().latch.is_some());
        assert!(
            stuck > 40 && implausible > 0 && held > 0 && out_of_order > 0,
            "{stuck} {implausible} {held}"
        );
    }
}
