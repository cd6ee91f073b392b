//! Turns a replay's ticks into [`Epochs`].

use executor::Executor;
use flight_data::Channel;
use kf_core::effect::EffectSubject;
use kf_core::input::TickInput;
use kf_core::sensor::{SENSORS, Sensor};
use model::Model;

use super::blocks::Builder;
use super::candidates::Candidate;
use super::diagnosis::Glitch;
use super::epochs::Epochs;
use super::follower::Follower;
use super::glitches;
use super::latent_path;
use super::physical_range::measures_climb_rate;
use super::reference_path::{Fix, ReferencePath};
use super::residuals::known_m;
use replay::steps::{self, Step};
use replay::{Observer, Replay};

/// Sensors that show the path besides the receiver, the best first.
const PATH_SENSORS: [Sensor; 2] = [Sensor::Baro, Sensor::ImuSlave];

/// Makes block means of a flight, in two passes over its ticks. The reference's path must be known as a whole
/// before a residual can be computed from it, because its outliers are found and its gaps filled from both
/// sides.
#[must_use]
pub fn epochs(replay: &Replay<'_>, candidates: &[Candidate], executor: &dyn Executor) -> Epochs {
    let mut measured = Measured::of(replay);
    for input in replay.inputs() {
        measured.take_tick(&input);
    }
    measured.epochs(replay, candidates, executor)
}

/// One sensor's readings: `(time, metres)`.
type Path = Vec<(u64, f64)>;

/// The first of the two passes: the fixes that are measurements, and every sensor's own readings. It can
/// observe a pass that another part of the program runs.
pub struct Measured {
    model: Model,
    follower: Follower,
    fixes: Vec<Fix>,
    paths: [Path; SENSORS],
    makes_inertial_altitude: bool,
}

impl Measured {
    /// For a replay, before its first tick.
    #[must_use]
    pub fn of(replay: &Replay<'_>) -> Self {
        Self {
            model: replay.model().clone(),
            follower: Follower::new(replay.model()),
            fixes: Vec::new(),
            paths: [const { Vec::new() }; SENSORS],
            makes_inertial_altitude: replay.makes_inertial_altitude(),
        }
    }

    fn take_tick(&mut self, input: &TickInput) {
        let taken = self.follower.take(input);
        if let (true, Some(fix)) = (taken.has_fix, input.gps) {
            let known_m = known_m(&self.model, &self.follower, EffectSubject::Gps);
            self.fixes.push(Fix {
                time_us: input.time_us,
                altitude_m: f64::from(fix.altitude_m) - known_m,
                climb_mps: fix.velocity_down_mps.map(|down| -f64::from(down)),
            });
        }
        for (path, reading) in self.paths.iter_mut().zip(taken.readings_m) {
            path.extend(reading.map(|metres| (input.time_us, metres)));
        }
    }

    /// The block means, for which the second pass computes residuals and regressors.
    #[must_use]
    pub fn epochs(self, replay: &Replay<'_>, candidates: &[Candidate], executor: &dyn Executor) -> Epochs {
        let Self { model, fixes, paths, .. } = self;
        let (fixes, glitches_us) = glitches::split(fixes, &paths);
        let lost_after_s = f64::from(model.reference.lost_after_s);
        let mut path = ReferencePath::new(fixes, lost_after_s);
        let readings = PATH_SENSORS.iter().map(|sensor| &paths[sensor.index()]).find(|path| !path.is_empty());
        if let (false, Some(readings)) = (measures_climb_rate(replay), readings)
            && let Some(points) = latent_path::path(path.fixes(), readings, path.interval_s(), executor)
        {
            path.set_path(&points);
        }
        // Frees every single reading of the flight, which takes as much memory as the flight itself.
        drop(paths);
        let mut builder = Builder::new(replay, candidates, path);
        builder.run(replay, &model, candidates);
        let mut epochs = builder.finish();
        let glitch = |(from_us, to_us): &(u64, u64)| Glitch {
            from_s: *from_us as f64 * 1e-6,
            to_s: *to_us as f64 * 1e-6,
        };
        epochs.glitches = glitches_us.iter().map(glitch).collect();
        let of_sensor = |step: &Step| Some((sensor(step.channel)?, step.time_s));
        epochs.steps = steps::find(replay.flight()).iter().filter_map(of_sensor).collect();
        epochs
    }
}

/// The sensor whose altitude is in a column; `None` for the receiver's.
const fn sensor(channel: Channel) -> Option<Sensor> {
    match channel {
        Channel::BaroPa | Channel::BaroAltM => Some(Sensor::Baro),
        Channel::ImuSlaveAltM => Some(Sensor::ImuSlave),
        Channel::ImuMasterAltM => Some(Sensor::ImuMaster),
        _ => None,
    }
}

/// A mission's ticks. An inertial altitude that the flight computer computes is not one of a diagnosis'
/// readings.
impl Observer for Measured {
    fn take(&mut self, ticks: &[TickInput]) {
        for input in ticks {
            if self.makes_inertial_altitude {
                self.take_tick(&TickInput { imu_slave_altitude_m: None, ..*input });
            } else {
                self.take_tick(input);
            }
        }
    }
}

impl std::fmt::Debug for Measured {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.debug_struct("Measured").field("fixes", &self.fixes.len()).finish_non_exhaustive()
    }
}
