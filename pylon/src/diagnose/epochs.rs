//! A flight's ticks as block means of residuals and regressors.

use std::collections::VecDeque;

use kf_core::atmosphere::pressure_altitude_m;
use kf_core::config::ReferenceConfig;
use kf_core::effect::{EffectId, EffectSubject, Regressor, SignalTracker};
use kf_core::input::{BaroReading, TickInput};
use kf_core::reference::ReferenceTracker;
use kf_core::sensor::{SENSORS, Sensor};
use model::Model;

use super::candidates::Candidate;
use super::glitches;
use super::reference_path::{Fix, Reference, ReferencePath};
use super::series::{BySensor, Series};
use super::signals::{NAMES, SignalMeans};
use crate::replay::Replay;

/// A flight has at most about this many blocks; a longer one has longer blocks.
const MOST_BLOCKS: f64 = 2000.0;
/// Shortest block, seconds. Means over a second keep what an airframe does and average out most of the
/// noise of the signals that regressors are made of: a regressor with noise in it fits worse than a
/// wrong one without, the sharper the likelihood looks at fast errors.
const SHORTEST_BLOCK_S: f64 = 1.0;
const GRAVITY_MPS2: f64 = kf_core::atmosphere::STANDARD_GRAVITY_MPS2 as f64;
/// A column that lacks more than this share of its values is not available.
const MOST_MISSING: f64 = 0.1;

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
    /// Means of the signals in each block, by [`NAMES`] and then the unknown columns.
    pub signals: Vec<Vec<f64>>,
    /// Names of the signals.
    pub signal_names: Vec<String>,
    /// Intervals in which the reference was off and came back, seconds.
    pub glitches_s: Vec<(f64, f64)>,
    /// Readings left out because the reference was lost around them.
    pub unreferenced: u64,
}

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
    fn climbed_m(&self, time_us: u64) -> Option<f64> {
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
    fn regressor_m(&self, regressor: Regressor, moment: &Moment) -> Option<f64> {
        match regressor.id {
            EffectId::BaroScale => {
                let gained_m = || Some(moment.reference.smooth_m - self.altitude_base_m?);
                self.climbed_m(moment.time_us).or_else(gained_m)
            }
            EffectId::BaroLag | EffectId::GpsLatency => Some(-moment.reference.climb_mps),
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

/// The readings of a tick by sensor, metres, where they are finite.
fn readings(input: &TickInput) -> [Option<f64>; SENSORS] {
    let baro_m = input.baro.and_then(|reading| match reading {
        BaroReading::PressurePa(pressure_pa) => pressure_altitude_m(pressure_pa),
        BaroReading::AltitudeM(altitude_m) => Some(altitude_m),
    });
    [input.imu_master_altitude_m, input.imu_slave_altitude_m, baro_m]
        .map(|reading| reading.filter(|metres| metres.is_finite()).map(f64::from))
}

/// Sum of the effects that the model knows on one subject, metres.
fn known_m(model: &Model, tracker: &SignalTracker, subject: EffectSubject) -> f64 {
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

/// Readings, and the reference at their time.
struct Moment {
    time_us: u64,
    reference: Reference,
    readings: [Option<f64>; SENSORS],
}

/// The block that is being filled.
struct Open {
    key: (bool, i64),
    time_s: f64,
    ticks: u32,
    fixes: u32,
    residual_sum: BySensor,
    readings: [u32; SENSORS],
    column_sums: Vec<f64>,
    /// Sum and number of the load factor's regressors of all ticks: between the barometer's readings there are
    /// several of the accelerometer, and vibration is in every single one.
    load_factor: (f64, u32),
}

/// How much a regressor's samples differ from a straight line through their neighbours: what a flight does
/// within some hundredths of a second is straight, so that this is the noise of its signals (after von
/// Neumann, "Distribution of the ratio of the mean square successive difference to the variance", 1941). Samples
/// that are held do not count.
#[derive(Clone, Copy, Debug, Default)]
struct Roughness {
    last: [Option<f64>; 2],
    squares: f64,
    bends: u64,
}

/// Fewer bends than this tell nothing of noise.
const FEW_BENDS: u64 = 20;

impl Roughness {
    fn take(&mut self, value: f64) {
        if self.last[0] == Some(value) {
            return;
        }
        if let [Some(last), Some(before)] = self.last {
            let bend = value - 2.0 * last + before;
            self.squares += bend * bend;
            self.bends += 1;
        }
        self.last = [Some(value), self.last[0]];
    }

    /// Variance of the mean of a block's samples. A bend is made of three samples, with weights whose
    /// squares add up to 6.
    fn of_mean(&self, blocks: usize) -> f64 {
        if self.bends < FEW_BENDS || blocks == 0 {
            return 0.0;
        }
        let one = self.squares / (6.0 * self.bends as f64);
        one / (self.bends as f64 / blocks as f64).max(1.0)
    }
}

struct Builder {
    path: ReferencePath,
    block_s: f64,
    /// Which sensors each candidate acts on: one, or all for the reference.
    acts_on: Vec<[bool; SENSORS]>,
    load_factor_column: Option<usize>,
    open: Option<Open>,
    signals: SignalMeans,
    signal_names: Vec<String>,
    series: Series,
    signal_blocks: Vec<Vec<f64>>,
    asked: Vec<u64>,
    missing: Vec<u64>,
    roughness: Vec<Roughness>,
    unreferenced: u64,
    next_fix: usize,
}

impl Builder {
    fn new(replay: &Replay<'_>, candidates: &[Candidate], path: ReferencePath) -> Self {
        let times = &replay.flight().time_s;
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
            acts_on: acts_on.collect(),
            load_factor_column: candidates
                .iter()
                .position(|candidate| candidate.effect() == EffectId::BaroAcceleration),
            open: None,
            signals: SignalMeans::new(extra.len()),
            signal_names: names.chain(extra.iter().map(|(name, _)| name.clone())).collect(),
            series: Series { columns: vec![Vec::new(); candidates.len()], block_s, ..Series::default() },
            signal_blocks: Vec::new(),
            roughness: vec![Roughness::default(); candidates.len()],
            asked: vec![0; candidates.len()],
            missing: vec![0; candidates.len()],
            unreferenced: 0,
            next_fix: 0,
            path,
        }
    }

    fn run(&mut self, replay: &Replay<'_>, model: &Model, candidates: &[Candidate]) {
        let mut follower = Follower::new(model);
        let mut inputs = replay.inputs();
        loop {
            let row = inputs.next_row();
            let Some(input) = inputs.next() else { break };
            let (phase, _) = follower.take(&input);
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
                    self.roughness[column].take(excess);
                }
            }
            let climbed_m = follower.climbed_m(input.time_us).map(|metres| metres as f32);
            self.signals.take(&input, climbed_m, row, &replay.flight().extra);
            let readings = readings(&input);
            if readings.iter().all(Option::is_none) {
                continue;
            }
            let Some(reference) = self.path.at(input.time_us) else {
                self.unreferenced += readings.iter().flatten().count() as u64;
                continue;
            };
            let moment = Moment { time_us: input.time_us, reference, readings };
            self.take_readings(&moment, model, &follower, candidates);
        }
        self.close_block();
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
            open.residual_sum[i] += reading_m
                - known_m(model, &follower.tracker, EffectSubject::Sensor(sensor))
                - reference.altitude_m;
        }
        for (c, candidate) in candidates.iter().enumerate() {
            let acts_on = self.acts_on[c];
            if !(0..SENSORS).any(|i| acts_on[i] && readings[i].is_some()) {
                continue;
            }
            self.asked[c] += 1;
            let regressor_m = follower.regressor_m(candidate.regressor, moment);
            let Some(regressor_m) = regressor_m.filter(|metres| metres.is_finite()) else {
                self.missing[c] += 1;
                continue;
            };
            if Some(c) != self.load_factor_column {
                self.roughness[c].take(regressor_m);
            }
            // An error of the reference enters the residual with the other sign.
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
        // A block shorter than the fixes' interval, or between two fixes, rests on part of one.
        let part = self.block_s / self.path.interval_s().max(1e-3);
        series.fixes.push(if open.fixes > 0 { f64::from(open.fixes) } else { part.min(1.0) });
        series.free.push(open.key.0);
        series.residual_m.push(std::array::from_fn(|i| mean(open.residual_sum[i], open.readings[i])));
        series.readings.push(open.readings);
        let (load_sum, loads) = open.load_factor;
        for (c, sums) in open.column_sums.chunks_exact(SENSORS).enumerate() {
            let of_every_tick = loads > 0 && Some(c) == self.load_factor_column;
            series.columns[c].push(std::array::from_fn(|i| match open.readings[i] {
                0 => 0.0,
                _ if of_every_tick && self.acts_on[c][i] => load_sum / f64::from(loads),
                readings => sums[i] / f64::from(readings),
            }));
        }
        self.signal_blocks.push(signals);
    }

    fn finish(mut self) -> Epochs {
        let available: Vec<bool> = self
            .asked
            .iter()
            .zip(&self.missing)
            .map(|(asked, missing)| *asked > 0 && (*missing as f64) <= MOST_MISSING * *asked as f64)
            .collect();
        for (column, available) in self.series.columns.iter_mut().zip(&available) {
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
        let blocks = self.series.len();
        Epochs {
            column_noise_m2: self.roughness.iter().map(|roughness| roughness.of_mean(blocks)).collect(),
            series: self.series,
            available,
            signals: self.signal_blocks,
            signal_names: self.signal_names,
            glitches_s: Vec::new(),
            unreferenced: self.unreferenced,
        }
    }
}
