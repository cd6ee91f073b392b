//! Results in one plain sentence each, with the number that matters.

use std::fmt::Write as _;

use analysis::compare::Comparison;
use analysis::diagnose::{CandidateFacts, Diagnosis, SensorDiagnosis, Verdict};
use analysis::discover::{Discovery, Rejected, Why};
use analysis::learn::{Addition, JudgedOn};

use crate::protocol::{Headline, Tone};

/// An effect's usual name in the field.
pub fn title(effect: &str) -> &str {
    match effect {
        "baro.dynamic_pressure" => "static-port error",
        "baro.carrier_field" => "the mother ship's pressure field",
        "baro.angle_of_attack" => "static-port error with angle of attack",
        "baro.sideslip" => "static-port error in sideslip",
        "baro.lag" => "pressure lag",
        "baro.low_pass_lag" => "pressure lag (a low pass)",
        "gps.low_pass_latency" => "latency of the reference (a low pass)",
        "baro.scale" => "scale-factor error",
        "baro.temperature" => "temperature error",
        "baro.warm_up" => "warm-up drift",
        "baro.drift" => "pressure drift (weather)",
        "baro.acceleration" => "acceleration sensitivity",
        "baro.propwash" => "propeller slipstream on the port",
        "imu.velocity_error" => "vertical velocity error at release",
        "imu.accel_bias" => "accelerometer bias",
        "imu.accel_scale" => "accelerometer scale-factor error",
        "imu.tilt" => "attitude error",
        "imu.gyro_bias" => "gyro bias",
        "imu.vibration" => "vibration rectification",
        "imu.gravity_gradient" => "gravity gradient",
        "imu.eotvos" => "Eötvös effect",
        "gps.latency" => "latency of the reference",
        "gps.convergence" => "convergence of the receiver",
        "gps.lever_arm" => "antenna lever arm",
        other => other,
    }
}

/// The sensor that reads wrong, as the beginning of a sentence.
fn subject(sensor: &str) -> &'static str {
    match sensor {
        "baro" => "Your barometer",
        "imu_slave" => "Your inertial altitude",
        "imu_master" => "The mother ship's inertial altitude",
        _ => "Your reference (GPS)",
    }
}

/// Why no law is proposed; `None` if one is.
pub fn why_no_law(discovery: &Discovery) -> Option<String> {
    if !discovery.laws.is_empty() {
        return None;
    }
    if discovery.signals.is_empty() {
        return Some("No recorded signal can be used in a law.".to_owned());
    }
    let searched = format!("No law explains the rest; {} were tried.", discovery.scored);
    let Some(Rejected { on, regressor, why, effect }) = &discovery.rejected else { return Some(searched) };
    let why = match (why, effect) {
        (Why::NotEnoughEvidence, _) => {
            "its fit does not justify its length and the size of the search".to_owned()
        }
        (Why::HeldOut, _) => "it does not make the held-out data more likely".to_owned(),
        (Why::Catalogue, Some(effect)) => format!("{} explains as much", title(effect)),
        (Why::Catalogue, None) => "an effect of the catalogue explains as much".to_owned(),
        (Why::NoFormula, _) => "it is too long for a formula that can be flown".to_owned(),
        (Why::Shape, _) => "it may be an error in the formulas of the effects found".to_owned(),
    };
    Some(format!("{searched} The nearest was {regressor} on {on}: {why}."))
}

/// A number to two digits.
fn short(value: f64) -> String {
    let digits = match value.abs() {
        large if large >= 10.0 => 0,
        middle if middle >= 1.0 => 1,
        small if small >= 0.1 => 2,
        _ => 3,
    };
    format!("{value:.digits$}")
}

/// A coefficient to the first digit of its sigma, with that sigma.
fn with_sigma(value: f64, sigma: f64, unit: &str) -> String {
    if !(sigma.is_finite() && sigma > 0.0) {
        return short(value);
    }
    // The number of digits is only for display.
    let digits = (-sigma.log10().floor()).clamp(0.0, 9.0) as usize;
    let unit = if unit == "1" { String::new() } else { format!(" {unit}") };
    format!("{value:.digits$} ± {sigma:.digits$}{unit}")
}

/// A sensor's largest error due to an effect: "reads up to 6.3 m high at 45 m/s".
fn reads(candidate: &CandidateFacts) -> Option<String> {
    let ends = candidate.envelope_m.map(|regressor_m| (regressor_m, candidate.coefficient * regressor_m));
    let (regressor_m, metres) = ends.into_iter().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))?;
    if !metres.is_finite() || metres == 0.0 {
        return None;
    }
    let side = if metres > 0.0 { "high" } else { "low" };
    let mut text = format!("reads up to {} m {side}", short(metres.abs()));
    match &*candidate.effect {
        "baro.dynamic_pressure" | "baro.carrier_field" if regressor_m > 0.0 => {
            let _ = write!(text, " at {:.0} m/s", (2.0 * 9.806_65 * regressor_m).sqrt());
        }
        "baro.lag" | "gps.latency" => {
            let climbs = if regressor_m < 0.0 { "climbing" } else { "descending" };
            let _ = write!(text, " {climbs} at {} m/s", short(regressor_m.abs()));
        }
        _ => {}
    }
    Some(text)
}

fn candidate<'a>(sensor: &'a SensorDiagnosis, effect: &str) -> Option<&'a CandidateFacts> {
    sensor.candidates.iter().find(|candidate| candidate.effect == effect)
}

/// The error before and after on held-out data, if known: "; on what was held out the error falls from 3.4 m
/// to 0.5 m".
fn falls(before_m: Option<f64>, after_m: Option<f64>, on: &str) -> String {
    match (before_m, after_m) {
        (Some(before_m), Some(after_m)) if after_m < before_m => {
            format!("; {on} the error falls from {} m to {} m", short(before_m), short(after_m))
        }
        (Some(before_m), Some(after_m)) => {
            format!(
                "; {on} the error does not fall ({} m before, {} m after)",
                short(before_m),
                short(after_m)
            )
        }
        _ => String::new(),
    }
}

fn on_what(diagnosis: &Diagnosis) -> &'static str {
    if diagnosis.hold_outs.is_empty() { "on held-out stretches" } else { "on the next flight" }
}

/// The headline of a diagnosis.
pub fn of_diagnosis(diagnosis: &Diagnosis) -> Headline {
    if let Some(why) = diagnosis.untestable() {
        let sentence = format!("The model could not be tested: {why}.");
        return Headline { sentence, tone: Tone::Caution, effect: None };
    }
    let of_verdict = diagnosis.sensors.iter().find(|(_, sensor)| sensor.verdict == diagnosis.verdict);
    let Some((name, sensor)) = of_verdict else {
        let sentence = "There is no sensor in this flight to diagnose.".to_owned();
        return Headline { sentence, tone: Tone::Caution, effect: None };
    };
    let subject = subject(name);
    match diagnosis.verdict {
        Verdict::Identified => {
            let effect = sensor.missing.first().map(|effect| effect.to_string()).unwrap_or_default();
            let found = candidate(sensor, &effect);
            let reads = found.and_then(reads).unwrap_or_else(|| "is off".to_owned());
            let coefficient = found.map_or_else(String::new, |found| {
                format!(", {}", with_sigma(found.coefficient, found.sigma, &found.unit))
            });
            let falls = found.map_or_else(String::new, |found| {
                falls(found.rms_before_m, found.rms_after_m, on_what(diagnosis))
            });
            let others = match sensor.missing.len() {
                0 | 1 => String::new(),
                2 => " and another effect".to_owned(),
                more => format!(" and {} other effects", more - 1),
            };
            let sentence = format!("{subject} {reads}: {}{coefficient}{others}{falls}.", title(&effect));
            Headline { sentence, tone: Tone::Caution, effect: Some(effect) }
        }
        Verdict::Indistinguishable => {
            let first = sensor.sets().next();
            let set = first.map_or(&[][..], |set| set.effects);
            let chances = first.map_or(&[][..], |set| set.probabilities);
            let mut listed: Vec<String> = set
                .iter()
                .enumerate()
                .map(|(place, effect)| match chances.get(place) {
                    Some(chance) => format!("{} ({:.0} %)", title(effect), 100.0 * chance),
                    None => title(effect).to_owned(),
                })
                .collect();
            let nothing = first.and_then(|set| set.nothing);
            listed.extend(nothing.map(|nothing| format!("nothing ({:.0} %)", 100.0 * nothing)));
            let reads = set
                .first()
                .and_then(|effect| candidate(sensor, effect))
                .and_then(reads)
                .unwrap_or_else(|| "is off".to_owned());
            let sentence =
                format!("{subject} {reads}, and this flight cannot show why: {}.", listed.join(" or "));
            Headline { sentence, tone: Tone::Caution, effect: set.first().map(ToString::to_string) }
        }
        Verdict::UnknownEffect => {
            let follows = sensor.follows.first().map_or_else(
                || "it follows no signal of this flight".to_owned(),
                |follows| format!("it follows {}, by {} m rms", follows.signal, short(follows.size_m)),
            );
            let sentence =
                format!("{subject} is off in a way that nothing in the catalogue explains; {follows}.");
            Headline { sentence, tone: Tone::Bad, effect: None }
        }
        Verdict::InsufficientExcitation => Headline {
            sentence: format!(
                "The model fits, but this flight was flown too evenly to show what it may lack ({}).",
                subject.trim_start_matches("Your ")
            ),
            tone: Tone::Caution,
            effect: None,
        },
        Verdict::NoSignificantMisfit => Headline {
            sentence: "The model fits this flight as well as the noise allows: nothing is missing."
                .to_owned(),
            tone: Tone::Good,
            effect: None,
        },
    }
}

/// The headline of a comparison: about the sensor with the worst result.
pub fn of_comparison(comparison: &Comparison) -> Headline {
    const WORST_FIRST: [&str; 5] = ["untrustworthy", "doubtful", "unmonitored", "trusted", "calibrating"];
    let rank = |trust: &str| WORST_FIRST.iter().position(|word| *word == trust).unwrap_or(WORST_FIRST.len());
    let flying = comparison.sensors.iter().filter(|(_, sensor)| sensor.flies_free);
    let worst = flying.min_by_key(|(_, sensor)| rank(&sensor.trust));
    let Some((name, sensor)) = worst else {
        let sentence = "There is no sensor in this flight to compare.".to_owned();
        return Headline { sentence, tone: Tone::Caution, effect: None };
    };
    let subject = subject(name);
    let after = if comparison.flight.usage.has_launch { "launch" } else { "calibration" };
    let rms = sensor
        .free_flight_rms_m
        .map_or_else(String::new, |rms_m| format!(": {} m rms error after {after}", short(rms_m)));
    let limit =
        sensor.bound_m.map_or_else(String::new, |bound_m| format!(", alarm limit {} m", short(bound_m)));
    let when = |after_s: Option<f64>| {
        after_s.map_or_else(String::new, |after_s| format!(" {after_s:.0} s after {after}"))
    };
    let (sentence, tone) = match &*sensor.trust {
        "untrustworthy" => (
            format!("{subject} became untrustworthy{}{rms}{limit}.", when(sensor.untrustworthy_after_s)),
            Tone::Bad,
        ),
        "doubtful" => (
            format!("{subject} became doubtful{}{rms}{limit}.", when(sensor.doubtful_after_s)),
            Tone::Caution,
        ),
        "trusted" => (format!("{subject} stayed within its alarm limit{rms}{limit}."), Tone::Good),
        "unmonitored" => {
            (format!("{subject} was not watched at the end: the reference was lost{rms}."), Tone::Caution)
        }
        _ => (format!("{subject} was only calibrated: this flight has no free flight."), Tone::Caution),
    };
    Headline { sentence, tone, effect: None }
}

/// The headline of an added effect.
pub fn of_addition(addition: &Addition) -> Headline {
    let on = match addition.judged_on {
        JudgedOn::HeldOutFlights => "on the next flight",
        JudgedOn::HeldOutManoeuvres => "on held-out stretches",
    };
    let coefficient = with_sigma(addition.coefficient.into(), addition.sigma.into(), &addition.unit);
    let mut name = title(&addition.effect).to_owned();
    if let Some(first) = name.get(..1).map(str::to_uppercase) {
        name.replace_range(..1, &first);
    }
    let falls = falls(addition.rms_before_m, addition.rms_after_m, on);
    let (doubt, tone) = match addition.concerns.first() {
        None => (String::new(), Tone::Good),
        Some(concern) => (format!(". But {concern}"), Tone::Caution),
    };
    Headline {
        sentence: format!("{name} added: {coefficient}{falls}{doubt}."),
        tone,
        effect: Some(addition.effect.to_string()),
    }
}
