//! What the flights show, kept so that one more flight can be added before it is flown.
//!
//! A coefficient's variance depends on what is flown and on the noise, not on the sensors' readings: the
//! normal equations of the planned flight, under the noise that was found, are added to those of the flights.
//! What it would make of a set is in `resolution.rs`.

mod resolution;

use executor::Executor;
use kf_core::effect::EffectId;
use kf_core::sensor::{SENSORS, Sensor};
use replay::Replay;

use super::candidates::Candidate;
use super::diagnosis::Diagnosis;
use super::excitation::{detection, is_seen};
use super::from_replay::epochs;
use super::information::Information;
use super::judge::{self, interval::BeyondNoise, is_lift};
use super::named_replay::NamedReplay;
use super::noise::{Noise, NoisePrior};
use super::outlook::{EffectOutlook, Outlook};
use super::physical_range::Bounds;
use super::problem::{Known, Problem};
use super::rivals;
use super::weigher;
use super::wind;
use super::work::{Doubtful, Judged, Work, judged};
use crate::progress::{Cancelled, Progress};

/// What the flights show, for planning.
#[derive(Clone, Debug)]
pub struct Planner {
    candidates: Vec<Candidate>,
    prior: NoisePrior,
    known: Vec<Known>,
    noise: Noise,
    /// Sensors that the flights have.
    has: [bool; SENSORS],
    /// Whether the wind has columns of its own.
    has_wind: bool,
    /// The columns of the normal equations.
    columns: Vec<usize>,
    information: Information,
    /// Columns of the effects that were found.
    found: Vec<usize>,
    effects: Vec<Planned>,
    sets: Vec<Set>,
    tempering: Tempering,
    /// What the search demands of an effect in twice the log likelihood.
    penalty: f64,
    /// What each candidate's coefficient may be.
    bounds: Vec<Bounds>,
}

/// An effect to be planned for.
#[derive(Clone, Debug)]
struct Planned {
    column: usize,
    /// Factor by which the variance of its coefficient exceeds that of its fit.
    inflation: f64,
    /// Variance of the coefficient beyond that of the noise.
    beyond_noise: BeyondNoise,
}

/// A set that the flights cannot tell apart.
#[derive(Clone, Debug)]
struct Set {
    /// The column in whose place one of the set acts.
    column: usize,
    members: Vec<Suspect>,
    /// Effects that the diagnosis does not list. They become more probable where the others become less.
    unlisted: Vec<Suspect>,
    /// Pairs of effects of which the second is at least as probable as the first: it would look like it.
    stand_ins: Vec<(EffectId, EffectId)>,
    /// The probability that none acts, from [`judge::SUSPECT`] on.
    nothing: Option<f64>,
}

/// An effect that may act in a set's place.
#[derive(Clone, Copy, Debug)]
struct Suspect {
    effect: EffectId,
    probability: f64,
    /// Its column; `None` if the flights lack its signal.
    column: Option<usize>,
}

/// Weight of a sum of squares, which is smaller the more the effects explain. Where the climb rate is
/// measured, the shares are those of `rivals.rs`, but of all that is explained, over the whole flight, instead
/// of where two effects differ: a plan should rather promise too little separation than too much.
#[derive(Clone, Debug)]
struct Tempering {
    /// The shares (squares) of what is explained that errors of each candidate's shape may make.
    shapes: Vec<f64>,
}

impl Tempering {
    /// The power of the likelihood where this many squares are explained, against this column.
    fn power(&self, column: usize, explained: f64) -> f64 {
        let shape = self.shapes.get(column).copied().unwrap_or(0.0);
        1.0 / (1.0 / weigher::POWER + shape * explained.max(0.0))
    }
}

/// What a diagnosis provides in addition to its result.
#[derive(Debug)]
pub struct Further {
    /// For planning a further flight.
    pub planner: Planner,
    /// For learning coefficients.
    pub work: Work,
}

/// A diagnosis, and what it provides in addition; nothing without a flight.
///
/// # Errors
/// [`Cancelled`] when `progress` requests it.
pub fn diagnose_further(
    flights: &[NamedReplay<'_>],
    hold_outs: &[NamedReplay<'_>],
    progress: &mut Progress<'_>,
    executor: &dyn Executor,
) -> Result<(Diagnosis, Option<Further>), Cancelled> {
    let of = |judged: &Judged<'_, '_>, _: &mut Progress<'_>| Ok(Planner::of(judged));
    let (diagnosis, made) = judged(flights, hold_outs, None, Doubtful::LeftOut, progress, executor, of)?;
    let further = made.map(|(mut planner, work)| {
        planner.sets.retain(|set| set.is_reported(&diagnosis));
        Further { planner, work }
    });
    Ok((diagnosis, further))
}

impl Set {
    /// All effects that may act.
    fn suspects(&self) -> impl Iterator<Item = &Suspect> {
        self.members.iter().chain(&self.unlisted)
    }

    /// Whether the diagnosis reports this set; it does not where the cause of a misfit is unknown.
    fn is_reported(&self, diagnosis: &Diagnosis) -> bool {
        let names = || self.members.iter().map(|member| member.effect.name());
        let mut said = diagnosis.sensors.values().flat_map(|sensor| &sensor.indistinguishable);
        said.any(|set| set.iter().map(|name| &**name).eq(names()))
    }
}

impl Planner {
    fn of(judged: &Judged<'_, '_>) -> Self {
        let (judge, findings) = (judged.judge, judged.findings());
        let (candidates, suspects) = (&judged.prepared.candidates, judge.suspects);
        let found = findings.explanation.columns.clone();
        let has: [bool; SENSORS] =
            std::array::from_fn(|i| judged.prepared.series.iter().any(|series| series.has(i)));
        let subjects = [Some(Sensor::ImuSlave), Some(Sensor::Baro), None];
        let mut columns: Vec<usize> = subjects
            .into_iter()
            .filter(|subject| subject.is_none_or(|sensor| has[sensor.index()]))
            .flat_map(|subject| judge.one_an_effect(findings, subject))
            .collect();
        // Effects whose regressor does not move in the flights.
        for (column, candidate) in candidates.iter().enumerate() {
            let is_there = candidate.sensor().is_none_or(|sensor| has[sensor.index()])
                && judged.prepared.epochs.iter().all(|epochs| epochs.available[column]);
            let is_known = judge.problem.known.iter().any(|known| {
                candidates.get(known.column).is_some_and(|other| other.effect() == candidate.effect())
            });
            let is_listed = columns.iter().any(|other| candidates[*other].effect() == candidate.effect());
            if is_there && !is_known && !is_listed {
                columns.push(column);
            }
        }
        let planned = |column: &usize| {
            let at = found.iter().position(|found| found == column);
            Planned {
                column: *column,
                inflation: at.and_then(|at| findings.inflation.get(at)).copied().unwrap_or(1.0),
                beyond_noise: judge.beyond_noise(findings, *column),
            }
        };
        let effects: Vec<Planned> = columns.iter().map(planned).collect();
        let set = |rivals: &rivals::Rivals| {
            let judge::Set { effects, unlisted, nothing, is_identified } = judge.set(rivals);
            let all = || effects.iter().chain(&unlisted).map(|(_, probability)| probability);
            // Nothing, where it is too improbable to be listed, is assumed not to be so.
            let any: f64 = nothing.unwrap_or(0.0) + all().sum::<f64>();
            let column = |effect: EffectId| {
                let mut all = std::iter::once(rivals.column).chain(rivals.others.iter().copied());
                all.find(|column| candidates[*column].effect() == effect)
            };
            let names: Vec<EffectId> = effects.iter().map(|(effect, _)| *effect).collect();
            let suspects = |of: Vec<(EffectId, f64)>| -> Vec<Suspect> {
                let suspect =
                    |(effect, share)| Suspect { effect, probability: share / any, column: column(effect) };
                of.into_iter().map(suspect).collect()
            };
            let (members, unlisted) = (suspects(effects), suspects(unlisted));
            let is_lift = members.iter().all(|member| member.column.is_some()) && is_lift(&names);
            let nothing = nothing.map(|nothing| nothing / any);
            let stand_ins = judge.stand_ins(rivals);
            let set = Set { column: rivals.column, members, unlisted, stand_ins, nothing };
            (!is_identified && !is_lift).then_some(set)
        };
        let sets: Vec<Set> = findings.rivals.iter().chain(&findings.weak).filter_map(set).collect();
        let of_sets = || sets.iter().flat_map(Set::suspects).filter_map(|suspect| suspect.column);
        // Together with the planned flight another time constant, or another shape of a delay, may fit better.
        let usable = suspects.usable().iter().copied();
        let alike = usable.filter(|column| of_sets().any(|member| suspects.same_effect(member, *column)));
        columns.extend(found.iter().copied().chain(of_sets()).chain(alike));
        columns.sort_unstable();
        columns.dedup();
        // Half of it where sets have probabilities, as in `weigher.rs`.
        let shape = |column| {
            if findings.posterior.is_some() { 0.5 * weigher::SHAPE } else { suspects.shape(column) }
        };
        let tempering = Tempering { shapes: (0..candidates.len()).map(shape).collect() };
        let noise = findings.explanation.fit.noise;
        Self {
            candidates: candidates.clone(),
            prior: judge.problem.prior.clone(),
            known: judge.problem.known.clone(),
            noise,
            has,
            has_wind: judged.prepared.has_wind(),
            information: judge.problem.information(&noise, &columns),
            columns,
            found,
            effects,
            sets,
            tempering,
            penalty: suspects.penalty(),
            bounds: suspects.bounds().to_vec(),
        }
    }

    /// What the planned flight would show, together with the flights. It must have no column that they lack.
    #[must_use]
    pub fn outlook(&self, planned: &Replay<'_>, executor: &dyn Executor) -> Outlook {
        let mut epochs = epochs(planned, &self.candidates, executor);
        if self.has_wind {
            wind::append(&mut epochs);
        }
        let series = &mut epochs.series;
        for (residuals, readings) in series.residual_m.iter_mut().zip(&mut series.readings) {
            for sensor in 0..SENSORS {
                if self.has[sensor] && residuals[sensor].is_finite() {
                    residuals[sensor] = 0.0;
                } else {
                    residuals[sensor] = f64::NAN;
                    readings[sensor] = 0;
                }
            }
        }
        let flight = std::slice::from_ref(&epochs.series);
        let problem = Problem::new(flight, self.prior.clone(), self.known.clone(), executor);
        let flown = problem.information(&self.noise, &self.columns);
        let both = self.information.plus(&flown);
        let effects = self.effects.iter().map(|effect| self.effect(effect, &both, &epochs.available));
        let mut effects: Vec<EffectOutlook> = effects.collect();
        effects.sort_by_key(|effect| !effect.is_found);
        Outlook { effects, sets: self.sets.iter().map(|set| self.set(set, &flown)).collect() }
    }

    fn positions(&self, columns: &[usize]) -> Vec<usize> {
        let at = |column: &usize| self.columns.iter().position(|own| own == column);
        columns.iter().filter_map(at).collect()
    }

    /// The fit of a column together with the other effects found: the coefficient and its variance.
    fn fit(&self, information: &Information, column: usize) -> Option<(f64, f64)> {
        let effect = |column: usize| self.candidates[column].effect();
        let others = self.found.iter().copied().filter(|other| effect(*other) != effect(column));
        let picks: Vec<usize> = others.chain([column]).collect();
        let solution = information.solve(&self.positions(&picks))?;
        Some((*solution.coefficients.last()?, *solution.covariance.last()?))
    }

    fn effect(&self, of: &Planned, both: &Information, available: &[bool]) -> EffectOutlook {
        let candidate = &self.candidates[of.column];
        let effect = candidate.effect();
        let now = self.fit(&self.information, of.column);
        let coefficient = now.map(|(coefficient, _)| coefficient);
        // The coefficient stays as it is: the planned flight's readings are not known.
        let sigma = |(_, variance): (f64, f64)| {
            // A column that does not move now has nothing beyond its noise.
            let of_noise = now.map_or(1.0, |(_, now)| variance / now);
            let BeyondNoise { lasting, passing, hidden, .. } = of.beyond_noise;
            let beyond = lasting + (passing + hidden) * of_noise;
            (variance * of.inflation + beyond).sqrt()
        };
        let then = self.fit(both, of.column);
        let largest = effect.plausible().iter().fold(0.0_f64, |most, bound| most.max(f64::from(bound.abs())));
        let sigmas = |fit: Option<(f64, f64)>| fit.map_or(0.0, |(_, variance)| largest / variance.sqrt());
        EffectOutlook {
            effect: effect.name().into(),
            sensor: candidate.sensor().map_or("gps", Sensor::name).into(),
            unit: effect.unit().into(),
            is_found: self.found.contains(&of.column),
            coefficient,
            sigma_now: now.map(sigma),
            sigma_then: then.map(sigma),
            largest,
            is_seen_now: is_seen(sigmas(now), self.penalty),
            is_seen_then: is_seen(sigmas(then), self.penalty),
            detection_then: detection(sigmas(then), self.penalty),
            is_planned: available[of.column],
        }
    }
}
