//! The aircraft's manoeuvres over a whole replay, captive flight included.

use super::kinematics::{MotionSources, SignalMeans, SignalReader, motions};
use super::manoeuvre::{Manoeuvre, Motion};
use super::timeline::without_short_runs;
use replay::Replay;

/// A replay second by second.
#[derive(Clone, Debug, Default)]
pub struct MotionTrack {
    /// Begin of the first second, microseconds.
    pub start_us: u64,
    /// The motion in each second.
    pub motions: Vec<Motion>,
    /// The manoeuvre in each second; as long as `motions`.
    pub manoeuvres: Vec<Manoeuvre>,
    /// The signals from which it was read.
    pub sources: MotionSources,
}

impl MotionTrack {
    /// The track of a replay.
    #[must_use]
    pub fn of(replay: &Replay<'_>) -> Self {
        let mut reader = SignalReader::default();
        let mut seconds: Vec<SignalMeans> = Vec::new();
        let mut start_us = None;
        let mut last_us = None;
        for input in replay.mission_inputs() {
            if last_us.is_some_and(|last_us| input.time_us <= last_us) {
                continue;
            }
            last_us = Some(input.time_us);
            let first_us = *start_us.get_or_insert(input.time_us);
            let index = ((input.time_us - first_us) / 1_000_000) as usize;
            if index >= seconds.len() {
                seconds.resize_with(index + 1, SignalMeans::default);
            }
            if let Some(second) = seconds.last_mut() {
                reader.take(&input, second);
            }
        }
        let (motions, sources) = motions(&seconds);
        let manoeuvres = without_short_runs(motions.iter().map(Manoeuvre::of).collect());
        Self { start_us: start_us.unwrap_or(0), motions, manoeuvres, sources }
    }
}
