//! Which laws are proposed.

use kf_core::sensor::Sensor;
use model::formula::{Columns, Formula};

use super::advice::{Equals, to_separate};
use super::discovery::{Discovery, Equal, FoundLaw, Rejected, Why};
use super::fit::{Bench, Fitted, OnHeldOut};
use super::grammar::MOST_PARTS;
use super::picture::Picture;
use super::screen::Subject;
use super::search::BIT;
use super::weigh::{DOMINATED, EQUAL, EVIDENCE, MOST_LAWS, PROPOSED, Weight, front, probabilities};
use crate::diagnose::parts::{BETTER, SHAPE, SHAPE_WITHOUT_CLIMB_RATE};
use crate::name::Name;
use crate::progress::{Cancelled, Progress, step};

/// Number of laws that are examined closely, the most probable first.
const LOOKED_AT: usize = 24;
/// A law with lower odds against the best than this is not examined: twice the logarithm of a thousand.
const HOPELESS: f64 = 14.0;

/// Adds the fitted laws that pass all tests to a discovery.
pub fn judge(
    bench: &Bench<'_>,
    mut fitted: Vec<Fitted>,
    discovery: &mut Discovery,
    progress: &mut Progress<'_>,
) -> Result<(), Cancelled> {
    fitted.sort_by(|a, b| b.merit().total_cmp(&a.merit()));
    let Some(best) = fitted.first() else { return Ok(()) };
    // The fit without a law may have ended in a worse maximum of its likelihood: start from the best law's
    // noise.
    let columns = &bench.explanation.columns;
    let again = bench.problem.fit_noise(&bench.problem.prior, columns, &best.fit.values);
    step(progress)?;
    let missed = (again.twice_log_posterior - bench.explanation.fit.twice_log_posterior).max(0.0);
    for one in &mut fitted {
        one.weight.evidence -= missed / one.inflation;
    }
    fitted.sort_by(|a, b| b.merit().total_cmp(&a.merit()));
    let names = bench.search.signals.names();
    let most = fitted.first().map_or(0.0, Fitted::merit);
    // The best of each number of parts is kept: the front has simple laws with less evidence as well.
    let mut parts_seen = [false; MOST_PARTS + 1];
    fitted.retain(|one| {
        let is_first = !std::mem::replace(&mut parts_seen[one.law.parts().min(MOST_PARTS)], true);
        is_first || one.merit() > most - HOPELESS
    });
    let mut looked_at = 0;
    fitted.retain(|one| {
        looked_at += 1;
        looked_at <= LOOKED_AT || one.merit() <= most - HOPELESS
    });

    let mut standing: Vec<(Fitted, OnHeldOut)> = Vec::new();
    let mut reject = |one: &Fitted, why: Why, effect: Option<Name>| {
        let rejected = Rejected { on: on(one.subject), regressor: one.law.formula(&names), why, effect };
        discovery.rejected.get_or_insert(rejected);
    };
    for one in fitted {
        if one.merit() <= 0.0 {
            reject(&one, Why::NotEnoughEvidence, None);
            continue;
        }
        match catalogue(bench, &one) {
            Alike::Effect(column) => {
                let effect = bench.prepared.candidates.get(column).map(|c| Name::from(c.effect().name()));
                reject(&one, Why::Catalogue, effect);
                continue;
            }
            Alike::Shape => {
                reject(&one, Why::Shape, None);
                continue;
            }
            Alike::None => {}
        }
        if coefficient_unit(&one.law.formula(&names)).is_none() {
            reject(&one, Why::NoFormula, None);
            continue;
        }
        if bench.gain_alone(&one) <= 0.0 || !bench.lessens_errors(&one) {
            reject(&one, Why::Shape, None);
            continue;
        }
        let held = bench.held_out(&one);
        step(progress)?;
        let is_harmful = |verdict: &crate::diagnose::HeldOutVerdict| verdict.is_worse || verdict.gain <= 0.0;
        // No physics supports a law: data that it was not learned from must.
        if is_harmful(&held.stretches) || held.flights.as_ref().is_some_and(is_harmful) {
            reject(&one, Why::HeldOut, None);
            continue;
        }
        standing.push((one, held));
    }
    let odds: Vec<f64> = standing.iter().map(|(one, _)| one.merit()).collect();
    let (probability, none) = probabilities(&odds);
    discovery.none = none;
    if 1.0 - none < PROPOSED {
        if let Some((one, _)) = standing.first() {
            reject(one, Why::NotEnoughEvidence, None);
        }
        return Ok(());
    }
    discovery.rejected = None;
    let weights: Vec<Weight> = standing.iter().map(|(one, _)| one.weight).collect();
    let front = front(&weights);
    let correlations = correlations(bench, &standing);
    step(progress)?;
    // One of the equal laws represents all of them. Then follows the best one of fewer parts, and where room
    // is left, the equal ones.
    let parts = |k: usize| standing[k].0.law.parts();
    let mut chosen: Vec<usize> = Vec::new();
    for (simpler, with_equals) in [(false, false), (true, true), (false, true)] {
        for k in 0..standing.len() {
            let is_equal = chosen.iter().any(|other| correlations[*other][k] > EQUAL);
            let is_probable = odds[k] > odds[0] - HOPELESS;
            let is_simpler = chosen.iter().all(|other| parts(*other) > parts(k));
            let is_wanted = front[k] && !chosen.contains(&k) && (with_equals || !is_equal);
            if is_wanted && (if simpler { is_simpler } else { is_probable }) && chosen.len() < MOST_LAWS {
                chosen.push(k);
            }
        }
    }
    chosen.sort_unstable();
    for k in chosen {
        let (one, held) = &standing[k];
        let equals: Vec<usize> =
            (0..standing.len()).filter(|other| *other != k && correlations[k][*other] > EQUAL).collect();
        let with_equals = probability[k] + equals.iter().map(|other| probability[*other]).sum::<f64>();
        let mut equal_to: Vec<Equal> = equals
            .iter()
            .map(|other| Equal {
                law: standing[*other].0.law.formula(&names),
                correlation: correlations[k][*other],
                probability: Some(probability[*other]),
            })
            .collect();
        let (alike, columns_alike) = effects_alike(bench, one);
        let laws: Vec<&Fitted> = equals.iter().map(|other| &standing[*other].0).collect();
        let named: Vec<String> = alike.iter().chain(&equal_to).map(|equal| equal.law.clone()).collect();
        let equals = Equals { effects: &columns_alike, laws: &laws, names: &named };
        let advice = to_separate(bench, one, &equals, &bench.trim);
        equal_to.extend(alike);
        step(progress)?;
        let dropped = bench.explanation.columns.iter().filter(|column| !one.beside.contains(column));
        let effect =
            |column: &usize| bench.prepared.candidates.get(*column).map(|c| Name::from(c.effect().name()));
        let regressor = one.law.formula(&names);
        discovery.laws.push(FoundLaw {
            on: on(one.subject),
            unit: coefficient_unit(&regressor).unwrap_or_default(),
            regressor,
            coefficient: one.coefficient,
            sigma: one.sigma,
            probability: probability[k],
            probability_with_equals: with_equals,
            rms_before_m: held.rms_before_m,
            rms_after_m: held.rms_after_m,
            bits: one.weight.bits,
            evidence: one.weight.evidence,
            held_out_gain: held.flights.map_or(held.stretches.gain, |flights| flights.gain),
            size_m: one.coefficient.abs() * one.spread,
            instead_of: dropped.filter_map(effect).collect(),
            equal_to,
            advice,
            picture: Picture::of(bench, one),
        });
    }
    Ok(())
}

/// The unit that makes a law metres, by the formulas' own rules; `None` where it is not a formula.
fn coefficient_unit(regressor: &str) -> Option<String> {
    let formula = Formula::compile(regressor, &mut Columns::default()).ok()?;
    Some(formula.coefficient_unit().to_string())
}

fn on(subject: Subject) -> Name {
    match subject {
        Subject::Sensor(sensor) => Sensor::ALL.get(sensor).map_or("?", |sensor| sensor.name()).into(),
        Subject::Reference => "gps".into(),
    }
}

/// The part of the catalogue that a law is no better than.
enum Alike {
    /// An effect that would explain as much.
    Effect(usize),
    /// A possible error of the formulas of the effects found.
    Shape,
    /// Nothing.
    None,
}

/// Whether an effect of the catalogue in a law's place explains as much, or the law may be an error of the
/// formulas of the effects found.
fn catalogue(bench: &Bench<'_>, one: &Fitted) -> Alike {
    let law = bench.law_column();
    let series = bench.with_columns(bench.problem.flights, &[(one.subject, &one.column)]);
    let problem = bench.problem_of(&series);
    let usable = bench.suspects.usable();
    let mut picks: Vec<usize> = bench.explanation.columns.clone();
    picks.extend(usable.iter().copied().filter(|column| !bench.explanation.columns.contains(column)));
    picks.push(law);
    let information = problem.information(&one.fit.noise, &picks);
    let at = |column: &usize| picks.iter().position(|pick| pick == column);
    let rest = |columns: &[usize]| {
        let at: Vec<usize> = columns.iter().filter_map(at).collect();
        information.solve(&at)
    };
    let with = |more: usize| -> Vec<usize> { one.beside.iter().copied().chain([more]).collect() };
    let rest_of = |columns: &[usize]| rest(columns).map_or(f64::INFINITY, |solution| solution.rest);
    let (beside, with_law) = (rest_of(&one.beside), rest_of(&with(law)));
    let gain = beside - with_law;
    // What the catalogue explains where the law acts, under the same noise.
    let chosen = &bench.explanation.columns;
    let shape = if bench.prepared.has_climb_rate { SHAPE } else { SHAPE_WITHOUT_CLIMB_RATE };
    let better = if bench.prepared.has_climb_rate { BETTER } else { SHAPE_WITHOUT_CLIMB_RATE };
    let own = bench.variants(one.subject).pop().unwrap_or_default();
    let explained = (rest_of(&own) - rest_of(chosen)).max(0.0);
    let is_beside = one.beside == *chosen;
    if is_beside && gain < shape * explained {
        return Alike::Shape;
    }
    if !is_beside && rest_of(chosen) - with_law < better * explained {
        return Alike::Shape;
    }
    let price = BIT * one.weight.bits + EVIDENCE;
    for column in usable.iter().filter(|column| !one.beside.contains(column)) {
        let set = with(*column);
        let Some(solution) = rest(&set) else { continue };
        let other = beside - solution.rest;
        let pays = other - bench.suspects.penalty() >= gain - price || gain - other < better * gain;
        if pays && other > bench.suspects.penalty() && bench.suspects.is_possible(&set, &solution) {
            return Alike::Effect(*column);
        }
    }
    Alike::None
}

/// Effects of the catalogue that cannot be distinguished from a law, and the column of each.
fn effects_alike(bench: &Bench<'_>, one: &Fitted) -> (Vec<Equal>, Vec<usize>) {
    let series = bench.with_columns(bench.problem.flights, &[(one.subject, &one.column)]);
    let problem = bench.problem_of(&series);
    let mut picks: Vec<usize> = bench.suspects.usable().to_vec();
    picks.push(bench.law_column());
    let information = problem.information(&one.fit.noise, &picks);
    let law = picks.len() - 1;
    let mut found: Vec<Equal> = Vec::new();
    let mut columns: Vec<usize> = Vec::new();
    for (at, column) in picks[..law].iter().enumerate() {
        let correlation = information.shared(law, at, &[]).unwrap_or(0.0).sqrt();
        let Some(candidate) = bench.prepared.candidates.get(*column) else { continue };
        let name = candidate.effect().name();
        if correlation > EQUAL && !found.iter().any(|equal| equal.law == name) {
            found.push(Equal { law: name.to_owned(), correlation, probability: None });
            columns.push(*column);
        }
    }
    (found, columns)
}

/// Correlations of the laws' whitened columns under the best one's noise; zero for laws on different
/// subjects.
fn correlations(bench: &Bench<'_>, standing: &[(Fitted, OnHeldOut)]) -> Vec<Vec<f64>> {
    let n = standing.len();
    let mut correlations = vec![vec![0.0; n]; n];
    let Some((best, _)) = standing.first() else { return correlations };
    let columns: Vec<_> = standing.iter().map(|(one, _)| (one.subject, &one.column)).collect();
    let series = bench.with_columns(bench.problem.flights, &columns);
    let problem = bench.problem_of(&series);
    let first = bench.law_column();
    let picks: Vec<usize> = (first..first + n).collect();
    let information = problem.information(&best.fit.noise, &picks);
    for a in 0..n {
        for b in 0..n {
            if a != b && standing[a].0.subject == standing[b].0.subject {
                correlations[a][b] = information.shared(a, b, &[]).unwrap_or(0.0).sqrt();
            }
        }
    }
    correlations
}

const _: () = assert!(DOMINATED < HOPELESS);
