//! The trials of each log, and their diagnoses.

use std::ops::Range;
use std::time::Instant;

use kf_core::effect::EffectId;
use pylon::diagnose::{Diagnosis, SensorDiagnosis};
use pylon::flight::{Channel, Column, Flight};
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;

use super::added::{UNITS, sized};
use super::logs::{Log, hash};
use super::made::Track;
use crate::real_logs::{Injection, diagnosis};

/// Number of flights without any effect that are generated from each log.
const NULLS: u64 = 2;

/// Kind of a trial.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Case {
    /// The log as it is.
    Plain,
    /// Its first or its second half.
    Half(usize),
    /// A flight generated from its track, without any effect.
    Null,
    /// The same with one effect.
    Made(Injection),
    /// The log with one effect added.
    Added(Injection),
}

/// A trial and its result.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// The log's name.
    pub log: String,
    /// The case.
    pub case: Case,
    /// Noise of the difference of both altitudes, rms, metres; 0 where it is not known.
    pub noise_m: f64,
    /// The diagnosis, or the reason why there is none.
    pub said: Result<Diagnosis, String>,
    /// For [`Case::Added`]: effects named for the log as it is.
    pub before: Vec<&'static str>,
    /// Duration of the diagnosis, seconds.
    pub took_s: f64,
}

impl Outcome {
    /// The identified effects.
    #[must_use]
    pub fn identified(&self) -> Vec<&'static str> {
        self.said.as_ref().map_or_else(|_| Vec::new(), identified)
    }

    /// Sets that can't be distinguished; one that is listed under several sensors counts once.
    #[must_use]
    pub fn sets(&self) -> Vec<Vec<&'static str>> {
        let mut sets: Vec<Vec<&'static str>> = Vec::new();
        for set in self.said.iter().flat_map(|d| d.sensors.values()).flat_map(|s| &s.indistinguishable) {
            let catalogued = set.iter().filter_map(|effect| EffectId::from_name(effect));
            let mut set: Vec<&str> = catalogued.map(EffectId::name).collect();
            set.sort_unstable();
            if !sets.contains(&set) {
                sets.push(set);
            }
        }
        sets
    }

    /// Members of the smallest set that contains an effect, nothing among them where the set offers it.
    #[must_use]
    pub fn fewest(&self, effect: &str) -> Option<usize> {
        let sets = self.said.iter().flat_map(|d| d.sensors.values()).flat_map(SensorDiagnosis::sets);
        let holding = sets.filter(|set| set.effects.iter().any(|other| other == effect));
        holding.map(|set| set.effects.len() + usize::from(set.nothing.is_some())).min()
    }

    /// The reported probability of every effect that has one.
    #[must_use]
    pub fn probabilities(&self) -> Vec<(&'static str, f64)> {
        let sensors = self.said.iter().flat_map(|diagnosis| diagnosis.sensors.values());
        let candidates = sensors.flat_map(|sensor| &sensor.candidates);
        let said = candidates.filter_map(|candidate| {
            Some((EffectId::from_name(&candidate.effect)?.name(), candidate.probability?))
        });
        said.collect()
    }

    /// The coefficient of an effect and its sigma.
    #[must_use]
    pub fn fitted(&self, effect: &str) -> Option<(f64, f64)> {
        fitted(self.said.as_ref().ok()?, effect)
    }
}

fn identified(diagnosis: &Diagnosis) -> Vec<&'static str> {
    diagnosis.missing().filter_map(EffectId::from_name).map(EffectId::name).collect()
}

fn fitted(diagnosis: &Diagnosis, effect: &str) -> Option<(f64, f64)> {
    let mut candidates = diagnosis.sensors.values().flat_map(|sensor| &sensor.candidates);
    candidates.find(|candidate| candidate.effect == effect).map(|c| (c.coefficient, c.sigma))
}

/// Runs all trials of one log; `done` is called after every diagnosis.
#[must_use]
pub fn of_log(log: &Log, done: &(dyn Fn() + Sync)) -> Vec<Outcome> {
    let seed = hash(&log.name);
    let mut outcomes = Vec::new();
    let track = Track::of(&log.flight);
    let noise_m = track.as_ref().map_or(0.0, Track::noise_m);
    let mut run = |case: Case, flight: &Flight, before: Vec<&'static str>| {
        let start = Instant::now();
        let said = diagnosis(flight).map_err(|error| format!("{error:#}"));
        let took_s = start.elapsed().as_secs_f64();
        outcomes.push(Outcome { log: log.name.clone(), case, noise_m, said, before, took_s });
        done();
    };
    run(Case::Plain, &log.flight, Vec::new());
    let Ok(track) = track else { return outcomes };
    for (k, half) in halves(&log.flight, &track).iter().enumerate() {
        run(Case::Half(k), half, Vec::new());
    }
    let clean = track.clean(&log.flight);
    for k in 0..NULLS {
        // One with an airspeed, one without.
        run(Case::Null, &track.noisy(&clean, seed.wrapping_add(k), k % 2 == 0), Vec::new());
    }
    let plain = diagnosis(&log.flight).ok();
    for (k, unit) in UNITS.into_iter().enumerate() {
        let seed = seed.wrapping_add(100 + k as u64);
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        if let Some(injection) = sized(unit, 0.0, &clean, &track, &mut random) {
            let mut flight = clean.clone();
            if injection.inject(&mut flight).is_ok() {
                let has_airspeed = k % 2 == 1;
                run(Case::Made(injection), &track.noisy(&flight, seed, has_airspeed), Vec::new());
            }
        }
        let Some(plain) = &plain else { continue };
        // The added effect must not cancel the log's own.
        let own = fitted(plain, unit.effect()).map_or(0.0, |(own, _)| own);
        let is_against = own * unit.coefficient() < 0.0;
        // Only one of the two kinds of lag, and one of the signs.
        if is_against || matches!(unit, Injection::LagLowPass(_)) {
            continue;
        }
        // Both together must be within the physical range.
        let reported = if said_of(plain).contains(&unit.effect()) { own } else { 0.0 };
        if let Some(injection) = sized(unit, reported, &log.flight, &track, &mut random) {
            let mut flight = log.flight.clone();
            if injection.inject(&mut flight).is_ok() {
                run(Case::Added(injection), &flight, said_of(plain));
            }
        }
    }
    outcomes
}

/// All effects that a diagnosis names, in a set or not.
fn said_of(diagnosis: &Diagnosis) -> Vec<&'static str> {
    diagnosis
        .missing()
        .chain(diagnosis.suspects())
        .filter_map(EffectId::from_name)
        .map(EffectId::name)
        .collect()
}

/// The two halves of the rows that a diagnosis uses.
fn halves(flight: &Flight, track: &Track) -> [Flight; 2] {
    let middle = usize::midpoint(track.used.start, track.used.end);
    [track.used.start..middle, middle..track.used.end].map(|rows| part(flight, rows))
}

/// These rows of a flight, as a log without a launch.
#[must_use]
pub fn part(flight: &Flight, rows: Range<usize>) -> Flight {
    let cut = |column: &Column| {
        let mut part = Column::with_capacity(rows.len());
        for row in rows.clone() {
            part.push(column.get(row));
        }
        part
    };
    Flight {
        header: flight.header.clone(),
        time_s: flight.time_s[rows.clone()].to_vec(),
        channels: flight
            .channels
            .iter()
            .filter(|(channel, _)| *channel != Channel::Launch)
            .map(|(channel, column)| (*channel, cut(column)))
            .collect(),
        extra: flight.extra.iter().map(|(name, column)| (name.clone(), cut(column))).collect(),
    }
}
