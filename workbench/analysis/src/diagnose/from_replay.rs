//! A replay's ticks made into [`Epochs`].

use executor::Executor;
use kf_core::effect::EffectSubject;
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
use replay::Replay;

/// Sensors that show the path beside the receiver, the best first.
const PATH_SENSORS: [Sensor; 2] = [Sensor::Baro, Sensor::ImuSlave];

/// Makes block means of a flight.
#[must_use]
pub fn epochs(replay: &Replay<'_>, candidates: &[Candidate], executor: &dyn Executor) -> Epochs {
    let model = replay.model();
    let (fixes, paths) = measured(replay, model);
    let (fixes, glitches_us) = glitches::split(fixes, &paths);
    let lost_after_s = f64::from(model.reference.lost_after_s);
    let mut path = ReferencePath::new(fixes, lost_after_s);
    let readings = PATH_SENSORS.iter().map(|sensor| &paths[sensor.index()]).find(|path| !path.is_empty());
    if let (false, Some(readings)) = (measures_climb_rate(replay), readings)
        && let Some(points) = latent_path::path(path.fixes(), readings, path.interval_s(), executor)
    {
        path.set_path(&points);
    }
    let mut builder = Builder::new(replay, candidates, path);
    builder.run(replay, model, candidates);
    let mut epochs = builder.finish();
    let glitch =
        |(from_us, to_us): &(u64, u64)| Glitch { from_s: *from_us as f64 * 1e-6, to_s: *to_us as f64 * 1e-6 };
    epochs.glitches = glitches_us.iter().map(glitch).collect();
    epochs
}

/// One sensor's readings: `(time, metres)`.
type Path = Vec<(u64, f64)>;

/// The fixes that are measurements, and every sensor's own readings.
fn measured(replay: &Replay<'_>, model: &Model) -> (Vec<Fix>, [Path; SENSORS]) {
    let mut follower = Follower::new(model);
    let mut fixes = Vec::new();
    let mut paths = [const { Vec::new() }; SENSORS];
    for input in replay.inputs() {
        let taken = follower.take(&input);
        if let (true, Some(fix)) = (taken.has_fix, input.gps) {
            fixes.push(Fix {
                time_us: input.time_us,
                altitude_m: f64::from(fix.altitude_m) - known_m(model, &follower, EffectSubject::Gps),
                climb_mps: fix.velocity_down_mps.map(|down| -f64::from(down)),
            });
        }
        for (path, reading) in paths.iter_mut().zip(taken.readings_m) {
            path.extend(reading.map(|metres| (input.time_us, metres)));
        }
    }
    (fixes, paths)
}
