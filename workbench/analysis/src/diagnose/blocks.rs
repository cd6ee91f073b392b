//! Gathers ticks into blocks, and computes the blocks' means.

use std::sync::Arc;

use kf_core::effect::{EffectId, EffectSubject};
use kf_core::input::TickInput;
use kf_core::sensor::{SENSORS, Sensor};
use model::Model;

use super::candidates::Candidate;
use super::column_noise::ColumnNoise;
use super::delay::DelayFilter;
use super::epochs::Epochs;
use super::follower::{Follower, Moment, Phase, Taken};
use super::reference_path::ReferencePath;
use super::residuals::known_m;
use super::series::{BySensor, Series};
use super::signal_errors::read_ahead;
use super::signals::{NAMES, SignalMeans, offered};
use replay::Replay;

/// Largest number of blocks of a flight, approximately; a longer flight has longer blocks.
const MOST_BLOCKS: f64 = 2000.0;
/// Shortest block, seconds. Means over a second keep an airframe's motion and average out most of the noise
/// of the signals in regressors. A noisy regressor fits worse than a wrong one without noise, the more so the
/// more the likelihood weights fast errors.
const SHORTEST_BLOCK_S: f64 = 1.0;
const GRAVITY_MPS2: f64 = kf_core::atmosphere::STANDARD_GRAVITY_MPS2 as f64;
/// Largest share of missing values of an available column.
const MOST_MISSING: f64 = 0.1;

/// The block being filled.
struct Open {
    key: (bool, i64),
    time_s: f64,
    ticks: u32,
    fixes: u32,
    residual_sum: BySensor,
    readings: [u32; SENSORS],
    column_sums: Vec<f64>,
    /// Sum and number of the load factor's regressors at all ticks: between two readings of the barometer
    /// there are several of the accelerometer, and each contains vibration.
    load_factor: (f64, u32),
}

pub(super) struct Builder {
    path: ReferencePath,
    climb: DelayFilter,
    block_s: f64,
    /// The sensors on which each candidate acts: one, or all for the reference.
    acts_on: Vec<[bool; SENSORS]>,
    /// Assumed lateness of each candidate's signal, seconds.
    late_s: Vec<f32>,
    load_factor_column: Option<usize>,
    open: Option<Open>,
    signals: SignalMeans,
    signal_names: Vec<String>,
    series: Series,
    /// The series' columns.
    columns: Vec<Vec<BySensor>>,
    signal_blocks: Vec<Vec<f64>>,
    asked: Vec<u64>,
    missing: Vec<u64>,
    noise: Vec<ColumnNoise>,
    unreferenced: u64,
    refused: u64,
    next_fix: usize,
}

impl Builder {
    pub(super) fn new(replay: &Replay<'_>, candidates: &[Candidate], path: ReferencePath) -> Self {
        let times = replay.times_s();
        let first_s = times.iter().copied().fold(f64::INFINITY, f64::min);
        let last_s = times.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let block_s = SHORTEST_BLOCK_S.max(path.interval_s()).max((last_s - first_s) / MOST_BLOCKS);
        let extra = &replay.flight().extra;
        let names = NAMES.iter().map(|name| (*name).to_owned());
        let acts_on = candidates.iter().map(|candidate| match candidate.sensor() {
            None => [true; SENSORS],
            Some(sensor) => std::array::from_fn(|i| i == sensor.index()),
        });
        Self {
            block_s,
            climb: DelayFilter::default(),
            acts_on: acts_on.collect(),
            late_s: candidates.iter().map(|candidate| candidate.signal.late_s).collect(),
            load_factor_column: candidates
                .iter()
                .position(|candidate| candidate.effect() == EffectId::BaroAcceleration),
            open: None,
            signals: SignalMeans::new(offered(extra).count()),
            signal_names: names.chain(offered(extra).map(|(name, _)| name.clone())).collect(),
            series: Series { block_s, ..Series::default() },
            columns: vec![Vec::new(); candidates.len()],
            signal_blocks: Vec::new(),
            noise: vec![ColumnNoise::default(); candidates.len()],
            asked: vec![0; candidates.len()],
            missing: vec![0; candidates.len()],
            unreferenced: 0,
            refused: 0,
            next_fix: 0,
            path,
        }
    }

    pub(super) fn run(&mut self, replay: &Replay<'_>, model: &Model, candidates: &[Candidate]) {
        let mut follower = Follower::knowing(model, candidates.iter().map(|candidate| candidate.regressor));
        let mut inputs = replay.inputs();
        loop {
            let row = inputs.next_row();
            let Some(input) = inputs.next() else { break };
            let Taken { phase, readings_m: readings, refused, .. } = follower.take(&input);
            if phase == Phase::Ignored {
                continue;
            }
            self.enter_block(&input, phase == Phase::Free, candidates.len());
            if let (Some(open), Some(imu)) =
                (&mut self.open, input.imu.filter(|imu| imu.accel_mps2[2].is_finite()))
            {
                // Body axes point down: a level flight has a specific force of -g along z.
                let excess = -f64::from(imu.accel_mps2[2]) / GRAVITY_MPS2 - 1.0;
                open.load_factor.0 += excess;
                open.load_factor.1 += 1;
                if let Some(column) = self.load_factor_column {
                    self.noise[column].take(excess);
                }
            }
            let climbed_m = follower.climbed_m(input.time_us).map(|metres| metres as f32);
            self.signals.take(&input, climbed_m, row, &replay.flight().extra);
            self.refused += u64::from(refused);
            if readings.iter().all(Option::is_none) {
                continue;
            }
            let Some(reference) = self.path.at(input.time_us) else {
                self.unreferenced += readings.iter().flatten().count() as u64;
                continue;
            };
            let climb = self.climb.take(input.time_us, reference.climb_mps);
            let moment = Moment { time_us: input.time_us, reference, climb, readings };
            self.take_readings(&moment, model, &follower, candidates);
        }
        self.close_block();
        self.series.forward_sigma_mps2 = f64::from(follower.tracker.forward_sigma_mps2());
    }

    fn enter_block(&mut self, input: &TickInput, free: bool, columns: usize) {
        let time_s = input.time_us as f64 * 1e-6;
        let key = (free, (time_s / self.block_s).floor() as i64);
        if self.open.as_ref().is_none_or(|open| open.key != key) {
            self.close_block();
            self.open = Some(Open {
                key,
                time_s: 0.0,
                ticks: 0,
                fixes: 0,
                residual_sum: [0.0; SENSORS],
                readings: [0; SENSORS],
                column_sums: vec![0.0; columns * SENSORS],
                load_factor: (0.0, 0),
            });
        }
        if let Some(open) = &mut self.open {
            open.time_s += time_s;
            open.ticks += 1;
            let fixes = self.path.fixes().get(self.next_fix..).unwrap_or_default();
            let passed = fixes.iter().take_while(|fix| fix.time_us <= input.time_us).count();
            self.next_fix += passed;
            open.fixes += passed as u32;
        }
    }

    fn take_readings(
        &mut self,
        moment: &Moment,
        model: &Model,
        follower: &Follower,
        candidates: &[Candidate],
    ) {
        let Some(open) = &mut self.open else { return };
        let Moment { reference, readings, .. } = *moment;
        for (sensor, reading) in Sensor::ALL.into_iter().zip(readings) {
            let Some(reading_m) = reading else { continue };
            let i = sensor.index();
            open.readings[i] += 1;
            open.residual_sum[i] +=
                reading_m - known_m(model, follower, EffectSubject::Sensor(sensor)) - reference.altitude_m;
        }
        for (c, candidate) in candidates.iter().enumerate() {
            let acts_on = self.acts_on[c];
            if !(0..SENSORS).any(|i| acts_on[i] && readings[i].is_some()) {
                continue;
            }
            self.asked[c] += 1;
            let regressor_m = follower.regressor_m(candidate, moment);
            let Some(regressor_m) = regressor_m.filter(|metres| metres.is_finite()) else {
                self.missing[c] += 1;
                continue;
            };
            if Some(c) != self.load_factor_column {
                self.noise[c].take(regressor_m);
            }
            // An error of the reference enters the residual with the opposite sign.
            let sign = if candidate.sensor().is_none() { -1.0 } else { 1.0 };
            for i in 0..SENSORS {
                if acts_on[i] && readings[i].is_some() {
                    open.column_sums[c * SENSORS + i] += sign * regressor_m;
                }
            }
        }
    }

    fn close_block(&mut self) {
        let signals = self.signals.close();
        let Some(open) = self.open.take() else { return };
        if open.readings.iter().all(|count| *count == 0) {
            return;
        }
        let mean = |sum: f64, count: u32| if count > 0 { sum / f64::from(count) } else { f64::NAN };
        let series = &mut self.series;
        series.time_s.push(open.time_s / f64::from(open.ticks));
        // A block that is shorter than the fixes' interval, or between two fixes, contains only part of a
        // fix.
        let part = self.block_s / self.path.interval_s().max(1e-3);
        series.fixes.push(if open.fixes > 0 { f64::from(open.fixes) } else { part.min(1.0) });
        series.free.push(open.key.0);
        series.residual_m.push(std::array::from_fn(|i| mean(open.residual_sum[i], open.readings[i])));
        series.readings.push(open.readings);
        let (load_sum, loads) = open.load_factor;
        for (c, sums) in open.column_sums.chunks_exact(SENSORS).enumerate() {
            let of_every_tick = loads > 0 && Some(c) == self.load_factor_column;
            self.columns[c].push(std::array::from_fn(|i| match open.readings[i] {
                0 => 0.0,
                _ if of_every_tick && self.acts_on[c][i] => load_sum / f64::from(loads),
                readings => sums[i] / f64::from(readings),
            }));
        }
        self.signal_blocks.push(signals);
    }

    pub(super) fn finish(mut self) -> Epochs {
        let available: Vec<bool> = self
            .asked
            .iter()
            .zip(&self.missing)
            .map(|(asked, missing)| *asked > 0 && (*missing as f64) <= MOST_MISSING * *asked as f64)
            .collect();
        for (column, available) in self.columns.iter_mut().zip(&available) {
            if !available {
                column.fill([0.0; SENSORS]);
            }
        }
        self.series.full_block = std::array::from_fn(|i| {
            let mut counts: Vec<u32> =
                self.series.readings.iter().map(|readings| readings[i]).filter(|count| *count > 0).collect();
            counts.sort_unstable();
            counts.get(counts.len() / 2).map_or(1.0, |count| f64::from(*count))
        });
        for (column, late_s) in
            self.columns.iter_mut().zip(&self.late_s).filter(|(_, late_s)| **late_s != 0.0)
        {
            read_ahead(&self.series, column, *late_s);
        }
        self.series.columns = self.columns.into_iter().map(Arc::new).collect();
        let blocks = self.series.len();
        Epochs {
            climb_noise_m2: self.path.climb_noise_m2()
                / (self.series.block_s / self.path.interval_s()).max(1.0),
            column_noise_m2: self.noise.iter().map(|noise| noise.of_mean(blocks)).collect(),
            series: self.series,
            available,
            signals: self.signal_blocks,
            signal_names: self.signal_names,
            glitches: Vec::new(),
            steps: Vec::new(),
            unreferenced: self.unreferenced,
            refused: self.refused,
        }
    }
}
