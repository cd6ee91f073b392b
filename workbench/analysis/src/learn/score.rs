//! A mission's errors on a flight, as a score of a model, without the rest of a comparison.

use std::collections::BTreeMap;

use kf_core::effect::EffectSubject;
use kf_core::input::TickInput;
use kf_core::latch::LatchRecord;
use kf_core::output::{Phase, TickOutput, Trust};
use kf_core::sensor::{SENSORS, Sensor};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::addition::NamedFlight;
use crate::name::Name;
use model::Model;
use replay::{AnyMission, Observer, Replay, ReplayError, mission};

/// One sensor's errors on one flight (eq. 16), and its flags.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct SensorScore {
    /// Root mean square error in captive flight, with the latched bias, metres; `None` without a reading.
    pub captive_rms_m: Option<f64>,
    /// Root mean square error in free flight, metres; `None` without a reading.
    pub free_flight_rms_m: Option<f64>,
    /// When it became doubtful, seconds after launch; `None`: never.
    pub doubtful_after_s: Option<f64>,
    /// When it became untrustworthy, seconds after launch; `None`: never.
    pub untrustworthy_after_s: Option<f64>,
    /// Duration of its free flight, from launch to the flight's last tick, seconds; `None` without launch.
    pub free_flight_s: Option<f64>,
    /// Ticks of free flight with an error.
    #[serde(skip)]
    pub ticks: u64,
}

/// The scores of a flight's sensors by name; those without a single reading are left out.
pub type Scores = BTreeMap<Name, SensorScore>;

/// Sums over one sensor's ticks.
#[derive(Clone, Copy, Default)]
struct Tally {
    captive: [f64; 3],
    free: [f64; 2],
    doubtful_us: Option<u64>,
    untrustworthy_us: Option<u64>,
}

/// Scores a model on a flight: [`flown`], or a function that keeps its earlier results.
pub type Scorer<'a> = dyn FnMut(&NamedFlight<'_>, &Model) -> Result<Scores, ReplayError> + 'a;

/// Flies a model over a flight and scores every sensor.
///
/// # Errors
/// When a flight cannot be flown, or no mission can be made from the model.
pub fn flown(named: &NamedFlight<'_>, model: &Model) -> Result<Scores, ReplayError> {
    score(&Replay::new(named.flight, model, named.given)?)
}

/// Flies a replay's model over its flight and scores every sensor.
///
/// # Errors
/// When no mission can be made from the model.
pub fn score(replay: &Replay<'_>) -> Result<Scores, ReplayError> {
    let mut tally = ScoreTally::default();
    let summary = replay.run(&mut |_, output| tally.take(output))?;
    Ok(tally.scores(summary.latch.as_ref()))
}

/// Scores being accumulated from the outputs of a mission.
#[derive(Clone, Default)]
pub(crate) struct ScoreTally {
    tallies: [Tally; SENSORS],
    launch_us: Option<u64>,
    last_us: Option<u64>,
}

impl ScoreTally {
    /// Processes one tick.
    #[inline]
    pub(crate) fn take(&mut self, output: &TickOutput) {
        if output.out_of_order {
            return;
        }
        if output.latched_now {
            self.launch_us = Some(output.time_us);
        }
        self.last_us = Some(output.time_us);
        for (tally, sensor) in self.tallies.iter_mut().zip(&output.sensors) {
            match (output.phase, sensor.error_m) {
                (Phase::Calibrating, Some(error_m)) => {
                    // Without the current bias: the latched one is only known at the end.
                    let raw_m = f64::from(error_m) + f64::from(sensor.bias_m);
                    tally.captive[0] += 1.0;
                    tally.captive[1] += raw_m;
                    tally.captive[2] += raw_m * raw_m;
                }
                (Phase::FreeFlight, Some(error_m)) => {
                    tally.free[0] += 1.0;
                    tally.free[1] += f64::from(error_m) * f64::from(error_m);
                }
                _ => {}
            }
            if output.phase == Phase::FreeFlight {
                if matches!(sensor.trust, Trust::Doubtful | Trust::Untrustworthy) {
                    tally.doubtful_us.get_or_insert(output.time_us);
                }
                if sensor.trust == Trust::Untrustworthy {
                    tally.untrustworthy_us.get_or_insert(output.time_us);
                }
            }
        }
    }

    /// The scores, with the latched biases.
    pub(crate) fn scores(&self, latch: Option<&LatchRecord>) -> Scores {
        let after_s = |time_us: Option<u64>| {
            let (time_us, launch_us) = time_us.zip(self.launch_us)?;
            Some(time_us.saturating_sub(launch_us) as f64 * 1e-6)
        };
        let scores = Sensor::ALL.into_iter().zip(&self.tallies).filter_map(|(sensor, tally)| {
            let [captive, sum, squares] = tally.captive;
            let [free, free_squares] = tally.free;
            if captive + free == 0.0 {
                return None;
            }
            let latched_m = latch.map(|latch| f64::from(latch.sensors[sensor.index()].bias_m));
            let captive_rms = |bias_m: f64| {
                (squares / captive - 2.0 * bias_m * sum / captive + bias_m * bias_m).max(0.0).sqrt()
            };
            let score = SensorScore {
                captive_rms_m: (captive > 0.0).then(|| captive_rms(latched_m.unwrap_or(sum / captive))),
                free_flight_rms_m: (free > 0.0).then(|| (free_squares / free).sqrt()),
                doubtful_after_s: after_s(tally.doubtful_us),
                untrustworthy_after_s: after_s(tally.untrustworthy_us),
                free_flight_s: after_s(self.last_us),
                ticks: free as u64,
            };
            Some((sensor.name().into(), score))
        });
        scores.collect()
    }
}

/// A model's scores, from a mission of its own that observes a pass' ticks.
pub(crate) struct Scoring {
    mission: Box<dyn AnyMission>,
    tally: ScoreTally,
}

impl Scoring {
    /// A new mission with the model as in a replay.
    ///
    /// # Errors
    /// When no mission can be made from the model.
    pub(crate) fn new(model: &Model) -> Result<Self, ReplayError> {
        Ok(Self { mission: mission(model)?, tally: ScoreTally::default() })
    }

    /// The scores, after the pass.
    pub(crate) fn scores(&self) -> Scores {
        self.tally.scores(self.mission.latch())
    }
}

impl Observer for Scoring {
    fn take(&mut self, ticks: &[TickInput]) {
        for input in ticks {
            self.tally.take(&self.mission.tick(input));
        }
    }
}

/// Root mean square error in free flight over some flights, of the sensors that an effect acts on (for the
/// reference: all that fly free), metres; `None` without a reading.
#[must_use]
pub fn pooled_rms_m<'a>(scores: impl IntoIterator<Item = &'a Scores>, subject: EffectSubject) -> Option<f64> {
    let mut sum = 0.0;
    let mut ticks = 0;
    for (name, score) in scores.into_iter().flatten() {
        let concerns = match subject {
            EffectSubject::Gps => true,
            EffectSubject::Sensor(sensor) => sensor.name() == *name,
        };
        if let Some(rms_m) = score.free_flight_rms_m.filter(|_| concerns) {
            sum += rms_m * rms_m * score.ticks as f64;
            ticks += score.ticks;
        }
    }
    (ticks > 0).then(|| (sum / ticks as f64).sqrt())
}

#[cfg(test)]
mod tests {
    use kf_core::sensor::Sensor;

    use super::*;

    /// Errors of several flights are pooled by their ticks: with one tick at 3 m and three times as many at 1
    /// m the mean square is 3. For the reference all sensors count.
    #[test]
    fn errors_are_pooled_by_their_ticks() {
        let score = |rms_m, ticks| SensorScore { free_flight_rms_m: rms_m, ticks, ..SensorScore::default() };
        let flight = |baro: SensorScore| -> Scores {
            [("baro".into(), baro), ("imu_slave".into(), score(Some(5.0), 100))].into_iter().collect()
        };
        let flights =
            [flight(score(Some(3.0), 100)), flight(score(Some(1.0), 300)), flight(score(None, 900))];
        let baro = EffectSubject::Sensor(Sensor::Baro);
        assert_eq!(pooled_rms_m(&flights, baro), Some(3.0_f64.sqrt()));
        let all = pooled_rms_m(&flights[..1], EffectSubject::Gps).unwrap();
        assert!((all - 17.0_f64.sqrt()).abs() < 1e-12);
        assert_eq!(pooled_rms_m(&flights[2..], baro), None);
    }
}
