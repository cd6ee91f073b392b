//! A flight's ticks as block means of residuals and regressors.

use kf_core::atmosphere::pressure_altitude_m;
use kf_core::effect::{EffectSubject, SignalTracker};
use kf_core::input::{BaroReading, TickInput};
use kf_core::sensor::SENSORS;
use model::Model;

use super::blocks::Builder;
use super::candidates::Candidate;
use super::follower::Follower;
use super::glitches;
use super::reference_path::{Fix, ReferencePath};
use super::series::Series;
use crate::replay::Replay;

/// A flight ready to be diagnosed.
#[derive(Clone, Debug)]
pub struct Epochs {
    /// Residuals, and one column a candidate (all zero where it is not available).
    pub series: Series,
    /// Which candidates' signals the flight has.
    pub available: Vec<bool>,
    /// Variance of the noise in every candidate's block means, m^2 per squared unit of the coefficient: a
    /// regressor is made of measured signals.
    pub column_noise_m2: Vec<f64>,
    /// Means of the signals in each block, by [`super::signals::NAMES`] and then the unknown columns.
    pub signals: Vec<Vec<f64>>,
    /// Names of the signals.
    pub signal_names: Vec<String>,
    /// Intervals in which the reference was off and came back, seconds.
    pub glitches_s: Vec<(f64, f64)>,
    /// Readings left out because the reference was lost around them.
    pub unreferenced: u64,
}

/// The readings of a tick by sensor, metres, where they are finite.
pub(super) fn readings(input: &TickInput) -> [Option<f64>; SENSORS] {
    let baro_m = input.baro.and_then(|reading| match reading {
        BaroReading::PressurePa(pressure_pa) => pressure_altitude_m(pressure_pa),
        BaroReading::AltitudeM(altitude_m) => Some(altitude_m),
    });
    [input.imu_master_altitude_m, input.imu_slave_altitude_m, baro_m]
        .map(|reading| reading.filter(|metres| metres.is_finite()).map(f64::from))
}

/// Sum of the effects that the model knows on one subject, metres.
pub(super) fn known_m(model: &Model, tracker: &SignalTracker, subject: EffectSubject) -> f64 {
    let terms = model.effects.iter().filter(|effect| effect.term.regressor.id.subject() == subject);
    let metres = terms.map(|effect| {
        let regressor_m = tracker.regressor_m(effect.term.regressor).unwrap_or(0.0);
        f64::from(effect.term.coefficient) * f64::from(regressor_m)
    });
    metres.sum()
}

/// Makes block means of a flight.
#[must_use]
pub fn epochs(replay: &Replay<'_>, candidates: &[Candidate]) -> Epochs {
    let model = replay.model();
    let fixes = accepted_fixes(replay, model);
    let (fixes, glitches_us) = glitches::split(fixes, &sensor_paths(replay));
    let lost_after_s = f64::from(model.reference.lost_after_s);
    let path = ReferencePath::new(fixes, lost_after_s);
    let mut builder = Builder::new(replay, candidates, path);
    builder.run(replay, model, candidates);
    let mut epochs = builder.finish();
    epochs.glitches_s = glitches_us.iter().map(|(a, b)| (*a as f64 * 1e-6, *b as f64 * 1e-6)).collect();
    epochs
}

fn accepted_fixes(replay: &Replay<'_>, model: &Model) -> Vec<Fix> {
    let mut follower = Follower::new(model);
    let mut fixes = Vec::new();
    for input in replay.inputs() {
        let (_, accepted) = follower.take(&input);
        if let (true, Some(fix)) = (accepted, input.gps) {
            fixes.push(Fix {
                time_us: input.time_us,
                altitude_m: f64::from(fix.altitude_m) - known_m(model, &follower.tracker, EffectSubject::Gps),
                climb_mps: fix.velocity_down_mps.map(|down| -f64::from(down)),
            });
        }
    }
    fixes
}

/// Every sensor's own readings, `(time, metres)`.
fn sensor_paths(replay: &Replay<'_>) -> [Vec<(u64, f64)>; SENSORS] {
    let mut paths = [const { Vec::new() }; SENSORS];
    for input in replay.inputs() {
        for (path, reading) in paths.iter_mut().zip(readings(&input)) {
            let in_order = path.last().is_none_or(|(last_us, _)| *last_us < input.time_us);
            if let (Some(metres), true) = (reading, in_order) {
                path.push((input.time_us, metres));
            }
        }
    }
    paths
}
