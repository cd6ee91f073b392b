//! What the model lacks, as far as the flights can show it.

use maud::{Markup, html};

use super::bars::bars;
use super::effects::meaning;
use crate::compare::text::number::{metres, seconds};
use crate::diagnose::text::{hidden_in_noise, per_cent, probability, say, untested_for_a_reason, with_sigma};
use crate::diagnose::{CandidateFacts, Diagnosis, SensorDiagnosis, Verdict};

/// Number of candidates shown beside the chosen ones; the rest open on demand.
const OTHERS: usize = 5;
/// Half-width of a 95 % interval, sigmas.
const INTERVAL: f64 = 1.96;
/// A corrected p-value above this is not evidence of an effect.
const NO_SIGN: f64 = 0.05;

pub(super) fn section(diagnosis: &Diagnosis) -> Markup {
    // The reference gets a paragraph only if something is wrong with it. Effects that were found come first.
    let mut sensors: Vec<_> = diagnosis
        .sensors
        .iter()
        .filter(|(name, sensor)| **name != "gps" || sensor.verdict >= Verdict::Identified)
        .collect();
    sensors.sort_by_key(|(_, sensor)| std::cmp::Reverse(sensor.verdict));
    html! {
        section #diagnosis {
            h2 { "What the model lacks" }
            p {
                "Every physical effect in Pylon's catalogue was fitted to all sensors together, allowing for the reference's wander and \
                 correlated noise. \"Cannot tell\" is an answer too: it says what to fly next."
            }
            @for (name, sensor) in sensors { (of_sensor(name, sensor)) }
            (details(diagnosis))
        }
    }
}

fn of_sensor(name: &str, sensor: &SensorDiagnosis) -> Markup {
    let (chosen, others): (Vec<_>, Vec<_>) = sensor.candidates.iter().partition(|candidate| candidate.chosen);
    let (shown, rest) = others.split_at(others.len().min(OTHERS));
    html! {
        article class=(format!("finding {}", sensor.verdict.name())) {
            h3 { (name) ": " span.outcome { (say(sensor.verdict)) } }
            @if !sensor.missing.is_empty() {
                p { "Missing, strongest first:" }
                ul { @for id in &sensor.missing { li { (effect(id)) (sure(sensor, id)) } } }
            }
            @for set in sensor.sets() {
                @match (set.nothing, set.effects.len()) {
                    (None, _) => p { "One of these is missing, and the flights cannot show which; most probable first:" }
                    (Some(_), 1) => p { "This may be missing; the flights cannot show whether it is:" }
                    (Some(_), _) => p { "One of these may be missing; the flights cannot show which, or whether any is:" }
                }
                ul.group {
                    @for (id, probability) in set.effects.iter().zip(set.probabilities) { li { (effect(id)) ", " (per_cent(*probability)) } }
                    @if let Some(nothing) = set.nothing { li { "nothing, " (per_cent(nothing)) } }
                }
            }
            @for follows in &sensor.follows {
                p {
                    "The rest follows " b { (follows.signal) } ", " (seconds(Some(follows.lag_s))) " behind it: "
                    (metres(Some(follows.size_m))) " rms."
                }
            }
            @if let Some(factor) = sensor.free_flight_factor.filter(|factor| *factor > 1.5) {
                p { "Its own wander is " (format!("{factor:.1}")) " times larger in free flight than under the pylon." }
            }
            @for (id, share) in hidden_in_noise(sensor) {
                p { "The noise of its own signals may hide " (share) " of the coefficient of " code { (id) } "." }
            }
            @if !sensor.advice.is_empty() { p.advice { b { "What to do: " } (sensor.advice) } }
            @if !sensor.candidates.is_empty() {
                (table(sensor, chosen.iter().chain(shown)))
                @if !rest.is_empty() {
                    details {
                        summary { (rest.len()) " more that were tried" }
                        (table(sensor, rest.iter()))
                    }
                }
            }
        }
    }
}

/// The probability that an effect acts, if known.
fn sure(sensor: &SensorDiagnosis, id: &str) -> Markup {
    let of_effect = sensor.candidates.iter().find(|candidate| candidate.effect == id);
    let probability = of_effect.and_then(|candidate| candidate.probability);
    html! { @if let Some(probability) = probability { ", " (per_cent(probability)) } }
}

fn effect(id: &str) -> Markup {
    html! { code { (id) } @if !meaning(id).is_empty() { ": " (meaning(id)) } }
}

fn table<'a>(sensor: &SensorDiagnosis, rows: impl Iterator<Item = &'a &'a CandidateFacts>) -> Markup {
    html! {
        div.scroll tabindex="0" {
            table.candidates {
                thead { tr {
                    th scope="col" { "candidate" } th.number scope="col" { "coefficient ± sigma" }
                    th.number scope="col" { "95 % interval" }
                    th.number scope="col" { "chance by noise alone" } th scope="col" { "rms error, held out" }
                    th scope="col" { "verdict" }
                } }
                tbody { @for candidate in rows { (row(sensor, candidate)) } }
            }
        }
    }
}

fn row(sensor: &SensorDiagnosis, candidate: &CandidateFacts) -> Markup {
    let greatest = candidate.rms_before_m.unwrap_or(0.0).max(candidate.rms_after_m.unwrap_or(0.0));
    let unit = if candidate.unit == "1" { "" } else { &*candidate.unit };
    let reach = INTERVAL * candidate.sigma;
    let bound =
        |value: f64| with_sigma(value, candidate.sigma).split(' ').next().unwrap_or_default().to_owned();
    html! {
        tr.chosen[candidate.chosen] {
            th scope="row" {
                (candidate.effect)
                span.note {
                    (meaning(&candidate.effect))
                    @if let Some(time_s) = candidate.time_constant_s { " (time constant " (seconds(Some(time_s))) ")" }
                }
            }
            td.number { (with_sigma(candidate.coefficient, candidate.sigma)) " " (unit) }
            td.number { (bound(candidate.coefficient - reach)) " to " (bound(candidate.coefficient + reach)) }
                        td.number { (probability(candidate.p_value)) }
            td { (bars(("without", candidate.rms_before_m), ("with", candidate.rms_after_m), greatest)) }
            td { (verdict(sensor, candidate)) }
        }
    }
}

fn verdict(sensor: &SensorDiagnosis, candidate: &CandidateFacts) -> String {
    let rivals = sensor.indistinguishable.iter().find(|set| set.contains(&candidate.effect));
    if let Some(set) = rivals {
        let others: Vec<&str> = set.iter().map(|id| &**id).filter(|id| *id != candidate.effect).collect();
        if others.is_empty() {
            return "may be missing from the model".to_owned();
        }
        return format!("indistinguishable from {}", others.join(", "));
    }
    if sensor.missing.contains(&candidate.effect) {
        return "missing from the model".to_owned();
    }
    let word = match (candidate.chosen, candidate.p_value > NO_SIGN) {
        (true, _) => "part of the best fit, not certain enough to be named",
        (false, true) => "no sign of it",
        (false, false) => "not strong enough to be named",
    };
    word.to_owned()
}

fn details(diagnosis: &Diagnosis) -> Markup {
    let noise = &diagnosis.noise;
    html! {
        details {
            summary { "How sure is that, and what was left out?" }
            ul {
                li {
                    "Noise that was found beside the effects: the reference wanders by " (metres(Some(noise.reference_wander_m)))
                    " over " (seconds(Some(noise.reference_time_s))) ", and each fix adds " (metres(Some(noise.fix_sigma_m))) "."
                }
                @for (name, wander) in &noise.sensor_wander {
                    li { (name) " wanders by " (metres(Some(wander.sigma_m))) " over " (seconds(Some(wander.time_s))) "." }
                }
                @if diagnosis.hold_outs.is_empty() {
                    li { "Held-out errors: each part of the flights was left out in turn and predicted from the others." }
                } @else {
                    li { "Held-out errors are those on " (diagnosis.hold_outs.join(", ")) "." }
                }
                @for flight in &diagnosis.flights {
                    @for glitch in &flight.glitches {
                        li { (flight.file) ": the reference jumped away from " (seconds(Some(glitch.from_s))) " to " (seconds(Some(glitch.to_s))) "; left out." }
                    }
                    @if flight.refused_readings > 0 {
                        li { (flight.file) ": " (flight.refused_readings) " readings not finite, implausible or of a sensor that is stuck; left out." }
                    }
                    @if flight.unreferenced_readings > 0 {
                        li { (flight.file) ": " (flight.unreferenced_readings) " readings without a reference around them; left out." }
                    }
                }
                @for untested in diagnosis.untested.iter().filter(|untested| untested.reason.is_none()) {
                    li { "Not tested: " (effect(&untested.effect)) " (needs " (untested.needs.join(", ")) ")." }
                }
                @for (effects, reason) in untested_for_a_reason(diagnosis) {
                    li { "Not tested: " (effects.join(", ")) ": " (reason) "." }
                }
                @for warning in &diagnosis.warnings { li { (warning) } }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::Follows;

    fn candidate(effect: &'static str, chosen: bool, p_value: f64) -> CandidateFacts {
        CandidateFacts {
            effect: effect.into(),
            coefficient: 0.5,
            sigma: 0.1,
            unit: "s".into(),
            probability: Some(0.98),
            p_value,
            rms_before_m: Some(4.0),
            rms_after_m: Some(1.0),
            chosen,
            time_constant_s: None,
            smoothing_s: None,
            pure_delay_s: None,
            noise_share: 0.0,
            since: None,
            size_m: 3.0,
            envelope_m: [-10.0, 10.0],
        }
    }

    #[test]
    fn every_verdict_of_a_candidate_has_its_words() {
        let sensor = SensorDiagnosis {
            verdict: Verdict::Indistinguishable,
            missing: vec!["baro.lag".into()],
            indistinguishable: vec![
                vec!["baro.angle_of_attack".into(), "baro.acceleration".into()],
                vec!["baro.warm_up".into()],
                vec!["baro.temperature".into(), "baro.sideslip".into()],
            ],
            probabilities: vec![vec![0.6, 0.4], vec![0.7], vec![0.5, 0.2]],
            nothing: vec![None, Some(0.3), Some(0.3)],
            advice: "fly a level speed sweep".to_owned(),
            follows: vec![Follows { signal: "<flap>".to_owned(), lag_s: 2.0, size_m: 1.5, evidence: 40.0 }],
            free_flight_factor: Some(3.04),
            candidates: vec![
                candidate("baro.lag", true, 1e-9),
                candidate("baro.angle_of_attack", true, 1e-8),
                candidate("baro.acceleration", false, 1e-7),
                candidate("baro.scale", true, 1e-3),
                candidate("baro.drift", false, 1e-3),
                candidate("baro.propwash", false, 0.8),
                candidate("baro.warm_up", true, 1e-3),
            ],
        };
        for (row, words) in sensor.candidates.iter().zip([
            "missing from the model",
            "indistinguishable from baro.acceleration",
            "indistinguishable from baro.angle_of_attack",
            "part of the best fit, not certain enough to be named",
            "not strong enough to be named",
            "no sign of it",
            "may be missing from the model",
        ]) {
            assert_eq!(verdict(&sensor, row), words, "{}", row.effect);
        }
        let page = of_sensor("baro", &sensor).into_string();
        for text in [
            "finding indistinguishable",
            "One of these is missing, and the flights cannot show which;",
            "This may be missing; the flights cannot show whether it is:",
            "One of these may be missing; the flights cannot show which, or whether any is:",
            "<li>nothing, 30 %</li>",
            "fly a level speed sweep",
            "&lt;flap&gt;",
            "+0.50 ± 0.10 s",
            "+0.30 to +0.70",
            "without 4.00 m",
            "with 1.00 m",
            "3.0 times larger",
        ] {
            assert!(page.contains(text), "{text} in {page}");
        }
    }

    #[test]
    fn what_is_found_comes_first_and_a_healthy_reference_is_left_out() {
        let with = |verdict| SensorDiagnosis { verdict, ..SensorDiagnosis::default() };
        let mut diagnosis = Diagnosis::default();
        diagnosis.sensors.insert("baro".into(), with(Verdict::NoSignificantMisfit));
        diagnosis.sensors.insert("gps".into(), with(Verdict::NoSignificantMisfit));
        diagnosis.sensors.insert("imu_slave".into(), with(Verdict::UnknownEffect));
        let page = section(&diagnosis).into_string();
        assert!(page.find("imu_slave: ").unwrap() < page.find("baro: ").unwrap());
        assert!(!page.contains("gps: <"), "{page}");
    }
}
