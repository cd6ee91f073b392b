//! From flights to a diagnosis: prepare, search, judge.

use executor::Executor;
use kf_core::effect::EffectId;
use kf_core::sensor::Sensor;
use model::Model;

use super::candidates::Candidate;
use super::diagnosis::{DiagnosedFlight, Diagnosis, Untested, Verdict};
use super::epochs::Epochs;
use super::judge::{Findings, Judge};
use super::learning_problem::LearningProblem;
use super::named_replay::NamedReplay;
use super::noise::NoisePrior;
use super::prepare::Prepared;
use super::problem::{Known, Problem};
use super::search::{Explanation, Search, Seen};
use super::wanted_effect::{Tried, WantedEffect};
use crate::progress::{Cancelled, Progress, step};
use replay::scatter::{self, Scatter};
use replay::{Usage, barometer};

/// Finds what the model lacks; all replays have the same model. `progress` is called once for each fit. The
/// result does not depend on the executor.
///
/// # Errors
/// [`Cancelled`] when `progress` requests it.
pub fn diagnose(
    flights: &[NamedReplay<'_>],
    hold_outs: &[NamedReplay<'_>],
    progress: &mut Progress<'_>,
    executor: &dyn Executor,
) -> Result<Diagnosis, Cancelled> {
    Ok(judged(flights, hold_outs, None, Doubtful::LeftOut, progress, executor, |_, _| Ok(()))?.0)
}

/// What a diagnosis does with a sensor on which something outside the catalogue acts, where sets of effects
/// concern the reference.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Doubtful {
    /// Diagnoses the others again without it. An effect of the reference is in all sensors. If an effect on
    /// another sensor cancels it there, the two together look like an error of this sensor alone.
    LeftOut,
    /// Keeps it, because its error is what is looked for.
    Kept,
}

/// A diagnosis, and what it is based on.
pub(crate) struct Judged<'a, 'b> {
    pub(crate) judge: &'b Judge<'a>,
    pub(crate) prepared: &'b Prepared,
    findings: &'b Findings,
}

impl Judged<'_, '_> {
    /// What the verdicts are based on.
    pub(super) const fn findings(&self) -> &Findings {
        self.findings
    }

    /// The effects that explain the residuals, and the noise fitted with them.
    pub(crate) const fn explanation(&self) -> &Explanation {
        &self.findings.explanation
    }
}

/// A diagnosis, its work, and the result of `then` from what it is based on (nothing without a flight).
/// `tried`: what a study tries; `None`: the whole catalogue.
pub(crate) fn judged<T>(
    flights: &[NamedReplay<'_>],
    hold_outs: &[NamedReplay<'_>],
    tried: Option<Tried<'_>>,
    doubtful: Doubtful,
    progress: &mut Progress<'_>,
    executor: &dyn Executor,
    then: impl FnOnce(&Judged<'_, '_>, &mut Progress<'_>) -> Result<T, Cancelled>,
) -> Result<(Diagnosis, Option<(T, Work)>), Cancelled> {
    let Some(first) = flights.first() else { return Ok((Diagnosis::default(), None)) };
    let model = first.replay.model();
    let mut prepared = Prepared::new(flights, hold_outs, model, tried, executor);
    let mut without: Option<(Sensor, Diagnosis)> = None;
    let mut then = Some(then);
    loop {
        let prior = noise_prior(&prepared, model);
        let bench = Bench { prepared: &prepared, prior: &prior, executor };
        let (diagnosis, outcome) = bench.work(|judge| {
            let mut search = Search::new(judge.problem, judge.suspects);
            let explanation =
                if prepared.has_climb_rate { search.run(progress)? } else { search.start(progress)? };
            let (mut diagnosis, findings) = judge.verdicts(&mut search, explanation, progress)?;
            diagnosis.untested = untested(&prepared.candidates, flights, &prepared.epochs);
            let is_alone = judge.problem.is_alone();
            diagnosis.warnings = limits(flights, &prepared.epochs, model, &diagnosis, is_alone);
            let may_leave_out =
                |sensor: &Sensor| tried.is_none_or(|tried| !tried.wanted.effect.acts_on(*sensor));
            if let Some((sensor, first)) = &without {
                take_over(&mut diagnosis, *sensor, first);
            } else if prepared.has_climb_rate
                && doubtful == Doubtful::LeftOut
                && let Some(sensor) = doubtful_sensor(&diagnosis).filter(may_leave_out)
            {
                return Ok((diagnosis, Outcome::Without(sensor)));
            }
            diagnosis.version = Diagnosis::VERSION;
            let named = flights.iter().zip(&prepared.epochs);
            diagnosis.flights = named.map(|(named, epochs)| facts(named, epochs)).collect();
            diagnosis.hold_outs = hold_outs.iter().map(|named| named.file.clone()).collect();
            let judged = Judged { judge, prepared: &prepared, findings: &findings };
            let made = then.take().map(|then| then(&judged, progress)).transpose()?;
            Ok((diagnosis, Outcome::Final(Box::new((made, findings, search.into_seen())))))
        })?;
        match outcome {
            Outcome::Without(sensor) => {
                prepared.leave_out(sensor);
                without = Some((sensor, diagnosis));
            }
            Outcome::Final(result) => {
                let (made, findings, seen) = *result;
                let left_out = without.map(|(sensor, _)| sensor);
                let work = Work { diagnosis: diagnosis.clone(), prepared, prior, findings, seen, left_out };
                return Ok((diagnosis, made.map(|made| (made, work))));
            }
        }
    }
}

/// What becomes of a diagnosis.
enum Outcome<T> {
    /// It is to be made again without this sensor ([`Doubtful::LeftOut`]).
    Without(Sensor),
    /// The result of `then`, and what it is based on.
    Final(Box<(Option<T>, Findings, Seen)>),
}

/// The sensor on which something unknown acts, if sets concern the reference and nothing is identified. An
/// identified effect has been distinguished from all others, perhaps with this sensor's help. Sets of another
/// sensor's own effects come from that sensor's readings.
fn doubtful_sensor(diagnosis: &Diagnosis) -> Option<Sensor> {
    let free = || Sensor::ALL.into_iter().filter(|sensor| sensor.flies_free());
    let of = |sensor: Sensor| diagnosis.sensors.get(sensor.name());
    let mut unknown =
        free().filter(|sensor| of(*sensor).is_some_and(|found| found.verdict == Verdict::UnknownEffect));
    let sensor = unknown.next()?;
    let has_other = free().any(|other| other != sensor && of(other).is_some());
    let is_identified = diagnosis.missing().next().is_some();
    let is_of_reference = diagnosis.sensors.get("gps").is_some_and(|gps| !gps.indistinguishable.is_empty());
    (unknown.next().is_none() && has_other && is_of_reference && !is_identified).then_some(sensor)
}

/// Adds to a diagnosis that was made without a sensor what the first one, made with all sensors, says of it.
fn take_over(diagnosis: &mut Diagnosis, sensor: Sensor, first: &Diagnosis) {
    let name = sensor.name();
    if let Some(found) = first.sensors.get(name) {
        diagnosis.sensors.insert(name.into(), found.clone());
    }
    if first.verdict == Verdict::UnknownEffect || diagnosis.verdict < Verdict::Identified {
        diagnosis.verdict = Verdict::UnknownEffect;
    }
    diagnosis.untested.clone_from(&first.untested);
    diagnosis.warnings.push(format!(
        "{name} has an error that no effect of the catalogue explains: the other sensors are diagnosed without it"
    ));
}

fn noise_prior(prepared: &Prepared, model: &Model) -> NoisePrior {
    let prior = NoisePrior::new(&prepared.series, &model.reference, &model.sensors);
    if prepared.has_climb_rate { prior } else { prior.with_slow_wander() }
}

/// What a diagnosis works with.
struct Bench<'a> {
    prepared: &'a Prepared,
    prior: &'a NoisePrior,
    executor: &'a dyn Executor,
}

impl Bench<'_> {
    fn work<T>(&self, judging: impl FnOnce(&Judge<'_>) -> T) -> T {
        let Self { prepared, prior, executor } = *self;
        let problem = |series| Problem::new(series, prior.clone(), prepared.known.clone(), executor);
        let (problem, held) = (problem(&prepared.series), problem(&prepared.held));
        judging(&Judge {
            problem: &problem,
            held: (!prepared.held.is_empty()).then_some(&held),
            candidates: &prepared.candidates,
            suspects: &prepared.suspects(&problem),
            epochs: &prepared.epochs,
            has_climb_rate: prepared.has_climb_rate,
        })
    }
}

/// The kept work of a diagnosis. Learning from the same flights under the same model uses it instead of
/// repeating it, with identical digits.
pub struct Work {
    diagnosis: Diagnosis,
    prepared: Prepared,
    prior: NoisePrior,
    findings: Findings,
    seen: Seen,
    /// The sensor that it was made without ([`Doubtful::LeftOut`]).
    left_out: Option<Sensor>,
}

impl Work {
    /// Whether a study of this effect, with the catalogue's time constants if it has one, would repeat
    /// exactly this work. It would not where it has time constants of its own to try, where the model had the
    /// effect already, or where its sensor was left out.
    pub(super) fn serves(&self, wanted: WantedEffect) -> bool {
        let candidates = &self.prepared.candidates;
        let mut narrowed = candidates.clone();
        wanted.narrow(&mut narrowed, &[]);
        let is_known = |known: &Known| {
            candidates.get(known.column).is_some_and(|candidate| candidate.effect() == wanted.effect)
        };
        let is_left_out = self.left_out.is_some_and(|sensor| wanted.effect.acts_on(sensor));
        narrowed == *candidates && !self.prepared.known.iter().any(is_known) && !is_left_out
    }

    /// The diagnosis that it found.
    pub(super) const fn diagnosis(&self) -> &Diagnosis {
        &self.diagnosis
    }

    /// The candidates in a problem of this work besides the effect to learn.
    pub(super) fn others(&self, problem: &LearningProblem) -> Vec<Candidate> {
        let free = problem.terms.iter().skip(1).filter(|term| term.known_sigma.is_none());
        free.filter_map(|term| self.prepared.candidates.get(term.column).copied()).collect()
    }

    /// What the effect's coefficient is to be learned from; `None` where the flights do not excite it.
    pub(super) fn problem(&self, effect: EffectId, executor: &dyn Executor) -> Option<LearningProblem> {
        let bench = Bench { prepared: &self.prepared, prior: &self.prior, executor };
        bench.work(|judge| {
            let mut search = Search::resumed(judge.problem, judge.suspects, self.seen.clone());
            judge.problem(&mut search, self.findings.clone(), effect)
        })
    }

    /// The problem of an effect with other time constants: the best of them, together with the other
    /// candidates that act, the noise fitted again starting from this work's. `None` where the flights do not
    /// excite the effect.
    ///
    /// # Errors
    /// [`Cancelled`] when `progress` requests it.
    pub(super) fn refined(
        &self,
        flights: &[NamedReplay<'_>],
        hold_outs: &[NamedReplay<'_>],
        tried: Tried<'_>,
        progress: &mut Progress<'_>,
        executor: &dyn Executor,
    ) -> Result<Option<LearningProblem>, Cancelled> {
        let Some(first) = flights.first() else { return Ok(None) };
        let model = first.replay.model();
        let mut prepared = Prepared::new(flights, hold_outs, model, Some(tried), executor);
        if let Some(sensor) = self.left_out {
            prepared.leave_out(sensor);
        }
        step(progress)?;
        let prior = noise_prior(&prepared, model);
        let bench = Bench { prepared: &prepared, prior: &prior, executor };
        let start = &self.findings.explanation.fit.values;
        bench.work(|judge| {
            let mut search = Search::new(judge.problem, judge.suspects);
            judge.refined_problem(&mut search, tried.wanted.effect, start, progress)
        })
    }
}

impl std::fmt::Debug for Work {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.debug_struct("Work").field("diagnosis", &self.diagnosis).finish_non_exhaustive()
    }
}

fn facts(named: &NamedReplay<'_>, epochs: &Epochs) -> DiagnosedFlight {
    DiagnosedFlight {
        file: named.file.clone(),
        calibration: named.replay.source().to_string(),
        usage: Usage::of(&named.replay),
        blocks: epochs.series.len(),
        block_s: epochs.series.block_s,
        glitches: epochs.glitches.clone(),
        unreferenced_readings: epochs.unreferenced,
        refused_readings: epochs.refused,
        fault: barometer::faults(named.replay.flight()),
    }
}

/// A reference that is worse than a sensor is said where it is this many times as noisy as the model has it:
/// as far as a monitor of three sigmas lets it go.
const WORSE: f64 = 3.0;
/// Fewest correlation times of the reference in a flight whose slow effects can be told from its wander: in
/// two it takes two independent values.
const LEAST_TIMES: f64 = 2.0;

/// What limits a diagnosis: a reference that is worse than the sensor, and a flight too short for slow
/// effects.
fn limits(
    flights: &[NamedReplay<'_>],
    epochs: &[Epochs],
    model: &Model,
    diagnosis: &Diagnosis,
    is_alone: bool,
) -> Vec<String> {
    let noise = &diagnosis.noise;
    let allowed_m = f64::from(model.reference.sigma_m);
    let mut limits = Vec::new();
    for (named, epochs) in flights.iter().zip(epochs) {
        let worse = scatter::find(named.replay.flight()).filter(|scatter| {
            scatter.receiver_m > WORSE * allowed_m && scatter.receiver_m > WORSE * scatter.sensor_m
        });
        if let Some(Scatter { channel, receiver_m, sensor_m }) = worse {
            limits.push(format!(
                "{}: the reference is worse than the sensor: its fixes scatter by {receiver_m:.1} m about their neighbours, {} \
                 by {sensor_m:.1} m, and the model has {allowed_m:.1} m for the reference; an error shows only where it \
                 exceeds the reference's",
                named.file,
                channel.name()
            ));
        }
        let series = &epochs.series;
        let long_s = series.len() as f64 * series.block_s;
        let time_s = noise.reference_time_s.max(f64::from(model.reference.correlation_time_s));
        if long_s > 0.0 && long_s < LEAST_TIMES * time_s {
            limits.push(format!(
                "{}: {long_s:.0} s of flight; the reference's own error lasts {time_s:.0} s, so a drift, a warming up or a \
                 height's error cannot be distinguished from it",
                named.file
            ));
        }
    }
    // Two sensors that agree show which error is the reference's; one does not.
    let own_m = noise.sensor_wander.values().map(|wander| wander.sigma_m).fold(0.0, f64::max);
    if !is_alone && noise.reference_wander_m > WORSE * allowed_m.max(own_m) {
        limits.push(format!(
            "the reference is worse than the sensors: it wanders by {:.1} m, they by {own_m:.1} m at most, and the model has \
             {allowed_m:.1} m for the reference; an error that all of them show is taken for the reference's",
            noise.reference_wander_m
        ));
    }
    limits
}

/// Why the effects on a UAV's inertial altitude are not tried where the flight computer computes that
/// altitude itself. Before the launch it is not a measurement independent of the reference. After it, its
/// error grows with the square of the time and faster, while every term of the fitted noise is stationary.
const MADE: &str = "the UAV's inertial altitude is computed here from its accelerometer and gyro: until the launch it follows the \
    reference, and afterwards it drifts without bound, so its errors cannot be distinguished from the fitted noise";

/// Effects on sensors that the flights have, whose signals they lack, and those on an altitude that cannot be
/// judged.
fn untested(candidates: &[Candidate], flights: &[NamedReplay<'_>], epochs: &[Epochs]) -> Vec<Untested> {
    let is_made = flights.iter().any(|named| named.replay.makes_inertial_altitude());
    let mut untested: Vec<Untested> = Vec::new();
    for (column, candidate) in candidates.iter().enumerate() {
        let effect = candidate.effect();
        if untested.iter().any(|other| other.effect == effect.name()) {
            continue;
        }
        let has_sensor =
            candidate.sensor().is_none_or(|sensor| epochs.iter().any(|e| e.series.has(sensor.index())));
        if has_sensor && epochs.iter().any(|epochs| !epochs.available[column]) {
            let needs = effect.needs().iter().map(|column| (*column).into()).collect();
            untested.push(Untested { effect: effect.name().into(), needs, reason: None });
        } else if !has_sensor && is_made && candidate.sensor() == Some(Sensor::ImuSlave) {
            let reason = Some(MADE.to_owned());
            untested.push(Untested { effect: effect.name().into(), needs: Vec::new(), reason });
        }
    }
    untested
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::diagnosis::SensorDiagnosis;
    use crate::name::Name;

    fn unknown() -> SensorDiagnosis {
        SensorDiagnosis { verdict: Verdict::UnknownEffect, ..SensorDiagnosis::default() }
    }

    fn set(effects: [&'static str; 2]) -> SensorDiagnosis {
        SensorDiagnosis {
            verdict: Verdict::Indistinguishable,
            indistinguishable: vec![effects.map(Name::from).to_vec()],
            ..SensorDiagnosis::default()
        }
    }

    fn diagnosis(imu: SensorDiagnosis, baro: Option<SensorDiagnosis>, gps: SensorDiagnosis) -> Diagnosis {
        let mut diagnosis = Diagnosis::default();
        diagnosis.sensors.insert("imu_slave".into(), imu);
        diagnosis.sensors.insert("gps".into(), gps);
        if let Some(baro) = baro {
            diagnosis.sensors.insert("baro".into(), baro);
        }
        diagnosis
    }

    #[test]
    fn an_unknown_effect_is_left_out_only_beside_sets_of_the_reference() {
        let quiet = SensorDiagnosis::default;
        let cancelling = || set(["baro.warm_up", "gps.convergence"]);
        let found = |imu, baro, gps| doubtful_sensor(&diagnosis(imu, baro, gps));
        assert_eq!(found(unknown(), Some(cancelling()), cancelling()), Some(Sensor::ImuSlave));
        assert_eq!(found(unknown(), Some(quiet()), cancelling()), Some(Sensor::ImuSlave));
        let shared = || set(["imu.velocity_error", "gps.convergence"]);
        assert_eq!(found(shared(), Some(unknown()), shared()), Some(Sensor::Baro));
        assert_eq!(found(set(["imu.tilt", "imu.gyro_bias"]), Some(unknown()), quiet()), None);
        // There is nothing else to diagnose, or nothing to diagnose it by.
        assert_eq!(found(unknown(), Some(quiet()), quiet()), None);
        assert_eq!(found(unknown(), Some(unknown()), cancelling()), None);
        assert_eq!(found(unknown(), None, cancelling()), None);
        assert_eq!(found(quiet(), Some(cancelling()), cancelling()), None);
        // What is identified may have been by the other sensor's help.
        let identified = SensorDiagnosis { missing: vec!["baro.lag".into()], ..cancelling() };
        assert_eq!(found(unknown(), Some(identified), cancelling()), None);
    }

    #[test]
    fn the_unknown_effect_is_said_with_the_diagnosis_of_the_others() {
        let first = diagnosis(unknown(), Some(set(["baro.warm_up", "gps.convergence"])), unknown());
        let mut again = Diagnosis::default();
        again.sensors.insert("baro".into(), SensorDiagnosis::default());
        take_over(&mut again, Sensor::ImuSlave, &first);
        assert_eq!(again.verdict, Verdict::UnknownEffect);
        assert_eq!(again.sensors["imu_slave"], first.sensors["imu_slave"]);
        assert_eq!(again.sensors["baro"], SensorDiagnosis::default());
        assert!(again.warnings[0].starts_with("imu_slave has an error that no effect"), "{again:?}");
    }
}
