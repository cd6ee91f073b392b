//! What the flights show, kept so that one more flight can be added before it is flown.
//!
//! A coefficient's variance depends on what is flown and on the noise, not on the sensors' readings: the
//! normal equations of the planned flight, under the noise that was found, are added to those of the flights.
//! In a set of effects, each one in turn is assumed to act, with its fitted coefficient. The planned flight's
//! readings are then those that this effect causes, and the likelihoods of the others over all flights are
//! the expected ones; noise scatters them about these values, so that the probabilities are medians. Of two
//! effects that differ by `d` sigmas on the planned flight, the difference of the squares scatters by `2 d`:
//! from that follows how probable it is that the one that acts is identified.
//! Likelihoods are weighted as in the diagnosis, less the more the effects explain: formulas and signals are
//! not quite right.

use executor::Executor;
use kf_core::effect::EffectId;
use kf_core::sensor::{SENSORS, Sensor};
use replay::Replay;
use statistics::normal_above;

use super::candidates::Candidate;
use super::diagnosis::Diagnosis;
use super::excitation::{detection, is_seen};
use super::from_replay::epochs;
use super::information::{Information, Solution};
use super::judge::probable::EMPTY;
use super::judge::{self, interval::BeyondNoise};
use super::judge::{IDENTIFIED, SUSPECT, is_lift};
use super::named_replay::NamedReplay;
use super::noise::{Noise, NoisePrior};
use super::outlook::{EffectOutlook, MemberOutlook, Outlook, SetOutlook};
use super::problem::{Known, Problem};
use super::rivals;
use super::weigher;
use super::wind;
use super::work::{Judged, Work, judged};
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
    members: Vec<(EffectId, f64, Option<usize>)>,
    /// Pairs of effects of which the second is at least as probable as the first: it would look like it.
    stand_ins: Vec<(EffectId, EffectId)>,
    /// The probability that none acts, from [`SUSPECT`] on.
    nothing: Option<f64>,
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
    let (diagnosis, made) = judged(flights, hold_outs, None, progress, executor, of)?;
    let further = made.map(|(mut planner, work)| {
        planner.sets.retain(|set| set.is_reported(&diagnosis));
        Further { planner, work }
    });
    Ok((diagnosis, further))
}

impl Set {
    /// Whether the diagnosis reports this set; it does not where the cause of a misfit is unknown.
    fn is_reported(&self, diagnosis: &Diagnosis) -> bool {
        let names = || self.members.iter().map(|(effect, ..)| effect.name());
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
            let judge::Set { effects: set, nothing, is_identified } = judge.set(rivals);
            // What is not listed is assumed not to act.
            let any: f64 =
                nothing.unwrap_or(0.0) + set.iter().map(|(_, probability)| probability).sum::<f64>();
            let column = |effect: EffectId| {
                let mut all = std::iter::once(rivals.column).chain(rivals.others.iter().copied());
                all.find(|column| candidates[*column].effect() == effect)
            };
            let members = set.into_iter().map(|(effect, share)| (effect, share / any, column(effect)));
            let members: Vec<_> = members.collect();
            let effects: Vec<EffectId> = members.iter().map(|(effect, ..)| *effect).collect();
            let is_lift = members.iter().all(|(.., column)| column.is_some()) && is_lift(&effects);
            let nothing = nothing.map(|nothing| nothing / any);
            let stand_ins = judge.stand_ins(rivals);
            (!is_identified && !is_lift).then_some(Set { column: rivals.column, members, stand_ins, nothing })
        };
        let sets: Vec<Set> = findings.rivals.iter().chain(&findings.weak).filter_map(set).collect();
        let of_sets = sets.iter().flat_map(|set| set.members.iter().filter_map(|(.., column)| *column));
        columns.extend(found.iter().copied().chain(of_sets));
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

    fn set(&self, set: &Set, flown: &Information) -> SetOutlook {
        let members: Vec<MemberOutlook> = set
            .members
            .iter()
            .map(|(effect, probability, column)| {
                let would = column.and_then(|column| self.if_it_acts(set, column, flown));
                MemberOutlook {
                    effect: effect.name().into(),
                    probability: *probability,
                    probability_then: would.as_ref().map(|would| would.probability),
                    left: would.as_ref().map(|would| would.left),
                    sigmas: would.as_ref().map(|would| would.sigmas),
                    identified: would.map(|would| would.identified),
                }
            })
            .collect();
        let of_members = members.iter().map(|member| member.probability * member.identified.unwrap_or(0.0));
        let cleared = set.nothing.map(|_| self.if_nothing_acts(set, flown));
        let of_nothing = set.nothing.unwrap_or(0.0) * cleared.unwrap_or(0.0);
        let resolved = of_members.sum::<f64>() + of_nothing;
        SetOutlook { members, nothing: set.nothing, cleared, resolved }
    }

    /// Columns of the effects found elsewhere, without those of this column's effect.
    fn beside(&self, set: &Set, column: usize) -> Vec<usize> {
        let effect = self.candidates[column].effect();
        let found = self.found.iter().copied().filter(|found| *found != set.column);
        found.filter(|other| self.candidates[*other].effect() != effect).collect()
    }

    /// What would be found with the planned flight if this member of a set is the one that acts.
    fn if_it_acts(&self, set: &Set, truth: usize, flown: &Information) -> Option<Would> {
        let beside = self.beside(set, truth);
        let with = |column: usize| self.positions(&[beside.as_slice(), &[column]].concat());
        let acting = with(truth);
        let truth_now = self.information.solve(&acting)?;
        let both = self.information.plus(&flown.with_response(&acting, &truth_now.coefficients));
        let truth_then = both.solve(&acting)?;
        let power_now = self.tempering.power(truth, self.information.total() - truth_now.rest);
        let power_then = self.tempering.power(truth, both.total() - truth_then.rest);
        // The worth of an effect's fit, without what all of the set share.
        let worth = |power: f64, solution: &Solution| {
            let variance = solution.covariance.last().copied().unwrap_or(f64::INFINITY);
            0.5 * libm::log(variance) - 0.5 * power * solution.rest
        };
        let of_truth = worth(power_then, &truth_then) - worth(power_now, &truth_now);
        let other = |probability: f64, column: usize| {
            let picks = with(column);
            let (now, then) = (self.information.solve(&picks)?, both.solve(&picks)?);
            let gain = worth(power_then, &then) - worth(power_now, &now) - of_truth;
            let squares = (then.rest - truth_then.rest) - (now.rest - truth_now.rest);
            Some(Other::new(probability, gain, squares, power_then))
        };
        let mut others = Vec::new();
        let mut own = 0.0;
        for (effect, probability, column) in &set.members {
            if *column == Some(truth) {
                own = *probability;
                continue;
            }
            let by_itself = column.and_then(|column| other(*probability, column));
            // What it would look like: the one that acts, or another one.
            let alike = set.stand_ins.iter().filter(|(_, hidden)| hidden == effect).map(|(seen, _)| *seen);
            let as_another = alike.filter_map(|seen| {
                let (_, probability, column) = set.members.iter().find(|(effect, ..)| *effect == seen)?;
                let column = (*column)?;
                if column == truth {
                    Some(Other::unchanged(*probability))
                } else {
                    other(*probability, column)
                }
            });
            let heaviest = by_itself
                .into_iter()
                .chain(as_another)
                .max_by(|one, another| one.weight(0.0).total_cmp(&another.weight(0.0)));
            others.push(heaviest.unwrap_or_else(|| Other::unchanged(*probability)));
        }
        let without = self.positions(&beside);
        let (none_now, none_then) = (self.information.solve(&without)?, both.solve(&without)?);
        let shown = (none_then.rest - truth_then.rest).max(0.0);
        if let Some(nothing) = set.nothing {
            let gain = -0.5 * power_then * none_then.rest + 0.5 * power_now * none_now.rest - of_truth;
            let squares = shown - (none_now.rest - truth_now.rest);
            others.push(Other::new(nothing, gain, squares, power_then));
        }
        let total = own + others.iter().map(|other| other.weight(0.0)).sum::<f64>();
        let is_suspect = |weight: f64| weight / total >= SUSPECT;
        // Nothing is no member.
        let effects = others.len() - usize::from(set.nothing.is_some());
        let left = others[..effects].iter().filter(|other| is_suspect(other.weight(0.0))).count();
        let least = others.iter().map(|other| other.sigmas).fold(f64::INFINITY, f64::min);
        Some(Would {
            probability: own / total,
            left: left + usize::from(is_suspect(own)),
            sigmas: least,
            identified: identified(own, &others).min(detection(shown.sqrt(), self.penalty)),
        })
    }

    /// The probability that the set is no longer reported, if none of its effects acts: that nothing is then
    /// more probable than they are. An effect that fitted by chance explains, with the planned flight, only as
    /// much less as its coefficient becomes more certain.
    fn if_nothing_acts(&self, set: &Set, flown: &Information) -> f64 {
        let nothing = set.nothing.unwrap_or(0.0);
        let odds = |scatter: f64| -> f64 {
            let of_member = |(_, probability, column): &(EffectId, f64, Option<usize>)| {
                let gain = column.and_then(|column| self.chance(set, column, flown, scatter));
                probability / nothing * libm::exp(gain.unwrap_or(0.0))
            };
            set.members.iter().map(of_member).sum()
        };
        // Nothing has a probability of at least EMPTY where these odds are at most this.
        let limit = (1.0 - EMPTY) / EMPTY;
        probability_below(|scatter| odds(scatter) <= limit)
    }

    /// The gain in log odds of an effect that does not act, where the planned flight's noise is this many
    /// sigmas in its favour.
    fn chance(&self, set: &Set, column: usize, flown: &Information, scatter: f64) -> Option<f64> {
        let beside = self.beside(set, column);
        let (with, without) =
            (self.positions(&[beside.as_slice(), &[column]].concat()), self.positions(&beside));
        let now = self.information.solve(&with)?;
        let without_now = self.information.solve(&without)?;
        let then = self.information.plus(flown).solve(&with)?;
        let share = then.covariance.last()? / now.covariance.last()?;
        let power = self.tempering.power(column, self.information.total() - now.rest);
        let shown = (without_now.rest - now.rest).max(0.0);
        Some(gain_by_chance(shown, share, power, scatter))
    }
}

/// The gain in log odds of an effect that fitted by chance: `shown` squares now, with a variance that the
/// planned flight reduces to this share, where that flight's noise is `scatter` sigmas in its favour. It
/// grows with the scatter: a coefficient that turns its sign counts as none, since it would have to become as
/// certain the other way, which is less probable by far.
fn gain_by_chance(shown: f64, share: f64, power: f64, scatter: f64) -> f64 {
    let root = (shown * share).sqrt() + scatter * (1.0 - share).max(0.0).sqrt();
    0.5 * power * (root.max(0.0).powi(2) - shown) + 0.5 * libm::log(share)
}

/// What would be found.
struct Would {
    probability: f64,
    left: usize,
    sigmas: f64,
    identified: f64,
}

/// Another explanation than the one that acts.
#[derive(Clone, Copy, Debug)]
struct Other {
    /// Its probability now.
    now: f64,
    /// The expected change of the logarithm of its weight, relative to the one that acts.
    gain: f64,
    /// How many sigmas the planned flight distinguishes it by.
    sigmas: f64,
    /// The power of the likelihood.
    power: f64,
}

impl Other {
    fn new(now: f64, gain: f64, squares: f64, power: f64) -> Self {
        Self { now, gain: gain.min(0.0), sigmas: squares.max(0.0).sqrt(), power }
    }

    const fn unchanged(now: f64) -> Self {
        Self { now, gain: 0.0, sigmas: 0.0, power: 0.0 }
    }

    /// Its weight with the planned flight, where that flight's noise is this many sigmas in its favour.
    fn weight(self, scatter: f64) -> f64 {
        self.now * libm::exp(self.gain + scatter * self.power * self.sigmas)
    }
}

/// The probability that what acts, now of this probability, is identified against the others.
fn identified(own: f64, others: &[Other]) -> f64 {
    probability_below(|scatter| {
        let total: f64 = others.iter().map(|other| other.weight(scatter)).sum();
        own >= IDENTIFIED * (own + total)
    })
}

/// Largest scatter considered, sigmas: beyond it a probability is not a number that differs from zero.
const SCATTER: f64 = 37.0;
/// Bisections of it: to a thousandth of a sigma.
const HALVINGS: u32 = 16;

/// The probability that a standard normal scatter is below the limit up to which something holds; it holds for
/// every smaller scatter, too.
fn probability_below(holds: impl Fn(f64) -> bool) -> f64 {
    if holds(SCATTER) {
        return 1.0;
    }
    if !holds(-SCATTER) {
        return 0.0;
    }
    let (mut low, mut high) = (-SCATTER, SCATTER);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if holds(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    normal_above(-low)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two effects, equally probable now, that differ by `d` sigmas: the logarithm of their odds becomes
    /// `d^2 / 2` with a scatter of `d`, and 95 % are odds of 19.
    #[test]
    fn an_effect_is_identified_as_often_as_its_odds_scatter_above_19() {
        for d in [1.5, 3.0, 4.5] {
            let other = Other::new(0.5, -0.5 * d * d, d * d, 1.0);
            let wanted = normal_above((libm::log(19.0) - 0.5 * d * d) / d);
            assert!((identified(0.5, &[other]) - wanted).abs() < 1e-3, "{d}");
            // Half the likelihood's power halves the expected odds and their scatter.
            let half = Other::new(0.5, -0.25 * d * d, d * d, 0.5);
            let wanted = normal_above((libm::log(19.0) - 0.25 * d * d) / (0.5 * d));
            assert!((identified(0.5, &[half]) - wanted).abs() < 1e-3, "{d}");
        }
    }

    /// An effect of three sigmas that does not act, and a flight that is three times as informative: odds of
    /// two become less than one unless the new noise is that much in its favour. The limit of the root is
    /// where `root^2 = 9 - 2 ln 2 - ln 1/4`, and the root has a mean of 3/2 and a variance of 3/4.
    #[test]
    fn an_effect_by_chance_is_mostly_no_longer_reported() {
        let gain = |scatter| gain_by_chance(9.0, 0.25, 1.0, scatter);
        let cleared = probability_below(|scatter| 2.0 * libm::exp(gain(scatter)) <= 1.0);
        let wanted = normal_above((1.5 - 3.0) / 0.75_f64.sqrt());
        assert!((cleared - wanted).abs() < 1e-3, "{cleared} {wanted}");
        for scatter in [-37.0, -5.0, -1.0, 0.0, 1.0] {
            assert!(gain(scatter) <= gain(scatter + 0.5), "{scatter}");
        }
    }

    #[test]
    fn what_the_plan_does_not_distinguish_is_never_identified() {
        let apart = Other::new(0.25, -50.0, 100.0, 1.0);
        assert!(identified(0.5, &[apart]) > 0.999);
        assert!(identified(0.5, &[apart, Other::unchanged(0.25)]) < 1e-12);
        // Improbable already, an indistinguishable rival keeps nothing from being identified.
        assert!(identified(0.5, &[apart, Other::unchanged(0.5 / 19.0 - 0.001)]) > 0.9);
        assert!((identified(1.0, &[]) - 1.0).abs() < f64::EPSILON);
    }
}
