//! A mission over a flight, tick by tick: the data for curves.

use analysis::compare::MotionTrack;
use kf_core::input::TickInput;
use kf_core::latch::LatchRecord;
use kf_core::output::{Phase, TickOutput};
use kf_core::sensor::{SENSORS, Sensor};
use replay::{Replay, reading_m};

use crate::engine::{Progress, Refused, refused};

/// Ticks between progress reports.
const TICKS_PER_REPORT: usize = 1 << 14;

/// One sensor, one value per tick; NaN if there is none. Empty for a sensor without readings.
#[derive(Debug, Default)]
pub struct SensorTrack {
    /// Its altitude as measured, m.
    pub measured_m: Vec<f32>,
    /// Its error, m.
    pub error_m: Vec<f32>,
    /// Moving average of the error over the monitor's window, m.
    pub average_m: Vec<f32>,
    /// Its trust, as spans of ticks: the first tick of each.
    pub trust: Vec<(usize, &'static str)>,
    /// The alarm limit, m.
    pub bound_m: Option<f64>,
}

/// A mission over a flight.
#[derive(Debug, Default)]
pub struct Recording {
    /// Times of the ticks, seconds, increasing.
    pub time_s: Vec<f64>,
    /// The sensors, in the order of [`Sensor`].
    pub sensors: [SensorTrack; SENSORS],
    /// The reference's altitude at its accepted fixes, m.
    pub reference_m: Vec<f32>,
    /// The estimated altitude in captive flight, m.
    pub estimate_m: Vec<f32>,
    /// The mission's phases: the first tick of each.
    pub phases: Vec<(usize, &'static str)>,
    /// When it was launched, seconds.
    pub launch_s: Option<f64>,
    /// The aircraft's motion.
    pub motion: MotionTrack,
}

impl Recording {
    /// Flies the replay.
    pub fn take(replay: &Replay<'_>, progress: &mut Progress<'_>) -> Result<Self, Refused> {
        let mut recording = Self::default();
        let rows = replay.times_s().len() as u64;
        let summary = replay.run(&mut |input, output| {
            if !output.out_of_order {
                recording.tick(input, output);
            }
            if recording.time_s.len().is_multiple_of(TICKS_PER_REPORT) {
                progress("flying", recording.time_s.len() as u64, rows);
            }
        });
        let latch = summary.map_err(refused)?.latch;
        recording.finish(latch.as_ref());
        recording.motion = MotionTrack::of(replay);
        Ok(recording)
    }

    fn tick(&mut self, input: &TickInput, output: &TickOutput) {
        let tick = self.time_s.len();
        self.time_s.push(output.time_us as f64 * 1e-6);
        if output.latched_now {
            self.launch_s = self.time_s.last().copied();
        }
        let phase = match output.phase {
            Phase::Settling => "settling",
            Phase::Calibrating => "calibrating",
            Phase::FreeFlight => "free_flight",
        };
        note(&mut self.phases, tick, phase);
        let fix = input.gps.filter(|_| output.gps_rejection.is_none());
        self.reference_m.push(fix.map_or(f32::NAN, |fix| fix.altitude_m));
        let is_captive = output.phase == Phase::Calibrating;
        self.estimate_m.push(if is_captive { output.altitude_m } else { f32::NAN });
        for ((track, said), sensor) in self.sensors.iter_mut().zip(&output.sensors).zip(Sensor::ALL) {
            track.measured_m.push(reading_m(sensor, input).unwrap_or(f32::NAN));
            track.error_m.push(said.error_m.unwrap_or(f32::NAN));
            let average_m = said.moving_average_m.filter(|_| output.phase == Phase::FreeFlight);
            track.average_m.push(average_m.unwrap_or(f32::NAN));
            note(&mut track.trust, tick, said.trust.name());
        }
    }

    fn finish(&mut self, latch: Option<&LatchRecord>) {
        for (track, sensor) in self.sensors.iter_mut().zip(Sensor::ALL) {
            if track.measured_m.iter().chain(&track.error_m).all(|metres| metres.is_nan()) {
                *track = SensorTrack::default();
                continue;
            }
            let bound_m = latch.map(|latch| f64::from(latch.sensors[sensor.index()].bound_m()));
            track.bound_m = bound_m.filter(|bound_m| *bound_m > 0.0);
        }
    }
}

/// Starts a new span at a tick if the label has changed.
fn note(spans: &mut Vec<(usize, &'static str)>, tick: usize, what: &'static str) {
    if spans.last().is_none_or(|(_, last)| *last != what) {
        spans.push((tick, what));
    }
}
