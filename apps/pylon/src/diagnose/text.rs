//! A diagnosis in plain English.

use std::fmt::Write as _;

use view::text::printable;
use view::{Cell, Table, Tone};

use analysis::diagnose::{CandidateFacts, Diagnosis, Glitch, SensorDiagnosis, SensorWander, Verdict};
use analysis::overview::quoted;

/// Number of candidates listed beside the chosen ones.
const OTHERS: usize = 5;

/// Writes a line to a string, which cannot fail.
macro_rules! put {
    ($out:expr, $($arguments:tt)*) => {{
        let _ = writeln!($out, $($arguments)*);
    }};
}

/// The diagnosis as text about 100 columns wide, with colours as ANSI codes if `colour` is true.
#[must_use]
pub fn text(diagnosis: &Diagnosis, colour: bool) -> String {
    let mut out = String::new();
    for flight in &diagnosis.flights {
        put!(
            out,
            "{}: {}; {} blocks of {:.1} s",
            flight.file,
            flight.calibration,
            flight.blocks,
            flight.block_s
        );
        for line in flight.usage.in_the_air().into_iter().chain(flight.usage.lines()) {
            put!(out, "  {line}");
        }
        for Glitch { from_s, to_s } in &flight.glitches {
            put!(out, "  the reference jumped away and back between {from_s:.1} s and {to_s:.1} s; left out");
        }
        if let Some(fault) = &flight.fault {
            put!(out, "  {fault}; it is left out");
        }
        if flight.refused_readings > 0 {
            put!(
                out,
                "  {} readings not finite, implausible or from a stuck sensor; left out",
                flight.refused_readings
            );
        }
        if flight.unreferenced_readings > 0 {
            put!(out, "  {} readings without a reference; left out", flight.unreferenced_readings);
        }
    }
    if !diagnosis.hold_outs.is_empty() {
        put!(out, "held out: {}", diagnosis.hold_outs.join(", "));
    }
    put!(out, "model: {}", diagnosis.model);
    put!(out, "\n{}", headline(diagnosis));
    let has_launch = diagnosis.flights.iter().any(|flight| flight.usage.has_launch);
    for (name, sensor) in &diagnosis.sensors {
        // The reference gets a paragraph only if something is wrong with it.
        if *name != "gps" || sensor.verdict >= Verdict::Identified {
            write_sensor(&mut out, name, sensor, has_launch, colour);
        }
    }
    if let Some(command) = plan_command(diagnosis) {
        put!(out, "\nThe shortest next flight that would resolve this: {command}");
    }
    let noise = &diagnosis.noise;
    put!(
        out,
        "\nNoise: the reference wanders by {:.2} m over {:.0} s and each fix adds {:.2} m;",
        noise.reference_wander_m,
        noise.reference_time_s,
        noise.fix_sigma_m
    );
    let own: Vec<String> = noise
        .sensor_wander
        .iter()
        .map(|(name, SensorWander { sigma_m, time_s })| {
            format!("{name} wanders by {sigma_m:.2} m over {time_s:.1} s")
        })
        .collect();
    put!(out, "{}.", own.join(", "));
    if noise.slow_wander_m > 0.0 {
        let (sigma_m, minutes) = (noise.slow_wander_m, noise.slow_time_s / 60.0);
        put!(out, "Their difference wanders by another {sigma_m:.2} m over {minutes:.0} minutes.");
    }
    for untested in diagnosis.untested.iter().filter(|untested| untested.reason.is_none()) {
        put!(out, "not tested: {} (needs {})", untested.effect, untested.needs.join(", "));
    }
    for (effects, reason) in untested_for_a_reason(diagnosis) {
        put!(out, "not tested: {}: {reason}", effects.join(", "));
    }
    for warning in &diagnosis.warnings {
        put!(out, "warning: {}", printable(warning));
    }
    out
}

/// The command that plans the next flight, where these leave something open.
fn plan_command(diagnosis: &Diagnosis) -> Option<String> {
    let is_open = |sensor: &SensorDiagnosis| {
        sensor.sets().next().is_some() || sensor.verdict == Verdict::InsufficientExcitation
    };
    diagnosis.sensors.values().any(is_open).then(|| {
        let files = diagnosis.flights.iter().map(|flight| format!(" {}", quoted(&flight.file)));
        let model = match diagnosis.model.as_str() {
            "" | "default" => String::new(),
            model => format!(" --model {}", quoted(model)),
        };
        format!("pylon plan{}{model}", files.collect::<String>())
    })
}

/// Effects that went untested for a reason other than missing columns, grouped by the reason.
pub(crate) fn untested_for_a_reason(diagnosis: &Diagnosis) -> Vec<(Vec<&str>, &str)> {
    let mut by_reason: Vec<(Vec<&str>, &str)> = Vec::new();
    for untested in &diagnosis.untested {
        let Some(reason) = untested.reason.as_deref() else { continue };
        match by_reason.iter_mut().find(|(_, other)| *other == reason) {
            Some((effects, _)) => effects.push(&untested.effect),
            None => by_reason.push((vec![&*untested.effect], reason)),
        }
    }
    by_reason
}

pub(crate) fn headline(diagnosis: &Diagnosis) -> String {
    if let Some(why) = diagnosis.untestable() {
        return format!("The model could not be tested: {why}.");
    }
    let missing: Vec<&str> = diagnosis.missing().collect();
    match diagnosis.verdict {
        Verdict::NoSignificantMisfit => {
            "The model fits these flights as well as their noise allows: they show nothing missing."
                .to_owned()
        }
        Verdict::InsufficientExcitation => {
            "The model fits, but these flights could not have revealed most of what it may lack.".to_owned()
        }
        Verdict::Identified => format!("The model lacks {}.", missing.join(" and ")),
        Verdict::Indistinguishable => cannot_tell(diagnosis, &missing),
        Verdict::UnknownEffect => {
            "The model lacks something that nothing in the catalogue explains.".to_owned()
        }
    }
}

/// The headline where effects cannot be told apart, or perhaps none acts.
fn cannot_tell(diagnosis: &Diagnosis, missing: &[&str]) -> String {
    let sets: Vec<_> = diagnosis.sensors.values().flat_map(SensorDiagnosis::sets).collect();
    if sets.iter().any(|set| set.nothing.is_none()) {
        return "The model lacks an effect, and these flights cannot show which of several it is.".to_owned();
    }
    let lacks = if missing.is_empty() {
        "The model may lack".to_owned()
    } else {
        format!("The model lacks {}, and may lack", missing.join(" and "))
    };
    let mut suspects: Vec<&str> = diagnosis.suspects().collect();
    suspects.sort_unstable();
    suspects.dedup();
    match suspects.as_slice() {
        [only] => format!("{lacks} {only}: these flights cannot show whether it acts."),
        _ if missing.is_empty() => {
            "The model may lack an effect: these flights cannot show which, or whether any acts.".to_owned()
        }
        _ => format!("{lacks} another effect: these flights cannot show which, or whether any acts."),
    }
}

pub(crate) fn say(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::NoSignificantMisfit => "no significant misfit",
        Verdict::InsufficientExcitation => "insufficient excitation",
        Verdict::Identified => "identified",
        Verdict::Indistinguishable => "indistinguishable",
        Verdict::UnknownEffect => "unknown effect",
    }
}

fn write_sensor(out: &mut String, name: &str, sensor: &SensorDiagnosis, has_launch: bool, colour: bool) {
    put!(out, "\n{name}: {}", say(sensor.verdict));
    if !sensor.missing.is_empty() {
        let said: Vec<String> =
            sensor.missing.iter().map(|effect| with_probability(sensor, effect)).collect();
        put!(out, "  missing, strongest first: {}", said.join(", "));
    }
    for set in sensor.sets() {
        let members = set.effects.iter().map(|effect| &**effect).zip(set.probabilities.iter().copied());
        let (one_of, said) = set_in_words(members, set.nothing);
        put!(out, "  {one_of}: {said}");
    }
    if let Some(factor) = sensor.free_flight_factor.filter(|factor| *factor > 1.5) {
        put!(
            out,
            "  its own wander is {factor:.1} times larger in {}",
            if has_launch {
                "free flight than in captive flight"
            } else {
                "the flight than while it was calibrated"
            }
        );
    }
    for (effect, share) in hidden_in_noise(sensor) {
        put!(out, "  the noise of its own signals may hide {share} of {effect}'s coefficient");
    }
    for follows in &sensor.follows {
        put!(
            out,
            "  the rest follows {} with a lag of {:.0} s ({:.2} m rms)",
            follows.signal,
            follows.lag_s,
            follows.size_m
        );
    }
    let chosen = sensor.candidates.iter().filter(|candidate| candidate.chosen);
    let others = sensor.candidates.iter().filter(|candidate| !candidate.chosen).take(OTHERS);
    let rows: Vec<&CandidateFacts> = chosen.chain(others).collect();
    if !rows.is_empty() {
        put!(out, "{}", view::text::table(&table(&rows), colour));
    }
    if !sensor.advice.is_empty() {
        put!(out, "  {}", sensor.advice);
    }
}

/// From this share of a regressor's squares on, the noise of its signals is worth a line. Less is within the
/// two to five per cent by which a signal's scale is uncertain anyway, twice over.
const HIDES: f64 = 0.1;

/// The chosen effects of which a good part may be hidden in the noise of their own signals, and that part.
pub(crate) fn hidden_in_noise(sensor: &SensorDiagnosis) -> impl Iterator<Item = (&str, String)> {
    let chosen =
        sensor.candidates.iter().filter(|candidate| candidate.chosen && candidate.noise_share >= HIDES);
    chosen.map(|candidate| (&*candidate.effect, per_cent(candidate.noise_share)))
}

/// What a set is called, and its effects with their probabilities and that of nothing.
pub(crate) fn set_in_words<'a>(
    members: impl Iterator<Item = (&'a str, f64)>,
    nothing: Option<f64>,
) -> (&'static str, String) {
    let mut said: Vec<String> =
        members.map(|(effect, probability)| format!("{effect} ({})", per_cent(probability))).collect();
    let name = if said.len() == 1 { "perhaps" } else { "one of" };
    said.extend(nothing.map(|nothing| format!("or nothing ({})", per_cent(nothing))));
    (name, said.join(", "))
}

/// An effect and how probable it is that it acts, where that is known.
pub(crate) fn with_probability(sensor: &SensorDiagnosis, effect: &str) -> String {
    let of_effect = sensor.candidates.iter().find(|candidate| candidate.effect == effect);
    match of_effect.and_then(|candidate| candidate.probability) {
        Some(probability) => format!("{effect} ({})", per_cent(probability)),
        None => effect.to_owned(),
    }
}

fn table(rows: &[&CandidateFacts]) -> Table {
    let mut table = Table::new().left("  candidate").right("coefficient").left("");
    table = ["probability", "p-value", "held-out rms", "size, rms"].into_iter().fold(table, Table::right);
    for row in rows {
        let mark = if row.chosen { "*" } else { " " };
        let time = row.time_constant_s.map_or_else(String::new, |tau| format!(" ({tau:.0} s)"));
        let tone = if row.chosen { Tone::Good } else { Tone::Neutral };
        table.row([
            Cell::toned(format!("{mark} {}{time}", row.effect), tone),
            with_sigma(row.coefficient, row.sigma).into(),
            (*row.unit).into(),
            row.probability.map_or_else(|| "-".to_owned(), per_cent).into(),
            probability(row.p_value).into(),
            before_after(row.rms_before_m, row.rms_after_m).into(),
            format!("{:.2} m", row.size_m).into(),
        ]);
    }
    table
}

/// A value with its sigma, to two digits of the sigma.
pub(crate) fn with_sigma(value: f64, sigma: f64) -> String {
    if !(value.is_finite() && sigma.is_finite() && sigma > 0.0) {
        return "-".to_owned();
    }
    let decimals = 1 - sigma.log10().floor() as i32;
    if decimals > 6 {
        return format!("{value:+.3e} ± {sigma:.0e}");
    }
    let decimals = usize::try_from(decimals).unwrap_or(0);
    format!("{value:+.decimals$} ± {sigma:.decimals$}")
}

pub(crate) fn probability(p: f64) -> String {
    match p {
        p if p >= 0.1 => format!("{p:.1}"),
        p if p >= 0.001 => format!("{p:.3}"),
        p if p >= 1e-12 => format!("{p:.0e}"),
        _ => "< 1e-12".to_owned(),
    }
}

fn before_after(before_m: Option<f64>, after_m: Option<f64>) -> String {
    match (before_m, after_m) {
        (Some(before_m), Some(after_m)) => format!("{before_m:.2} m -> {after_m:.2} m"),
        (Some(before_m), None) => format!("{before_m:.2} m -> not reliable"),
        (None, Some(after_m)) => format!("not reliable -> {after_m:.2} m"),
        (None, None) => "not reliable".to_owned(),
    }
}

/// The probability of an effect, in per cent; near certainty is given as a limit, never as 100 %.
pub(crate) fn per_cent(probability: f64) -> String {
    match probability {
        p if p < 0.01 => "< 1 %".to_owned(),
        p if p > 0.99 => "> 99 %".to_owned(),
        p => format!("{:.0} %", 100.0 * p),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_show_two_digits_of_their_sigma() {
        assert_eq!(with_sigma(-0.043_21, 0.001_3), "-0.0432 ± 0.0013");
        assert_eq!(with_sigma(12.3, 0.45), "+12.30 ± 0.45");
        assert_eq!(with_sigma(1234.0, 210.0), "+1234 ± 210");
        assert_eq!(with_sigma(2.5e-8, 3e-9), "+2.500e-8 ± 3e-9");
        assert_eq!(probability(0.5), "0.5");
        assert_eq!(probability(3e-5), "3e-5");
        assert_eq!(probability(0.0), "< 1e-12");
    }

    /// What a signal's noise may hide of a chosen effect's coefficient is said from a tenth on.
    #[test]
    fn what_noise_hides_is_said() {
        let of = |noise_share: f64, chosen: bool| {
            let facts =
                CandidateFacts { effect: "baro.lag".into(), chosen, noise_share, ..Default::default() };
            let sensor = SensorDiagnosis { candidates: vec![facts], ..SensorDiagnosis::default() };
            let mut text = String::new();
            write_sensor(&mut text, "baro", &sensor, true, false);
            text
        };
        let line = "  the noise of its own signals may hide 32 % of baro.lag's coefficient\n";
        assert!(of(0.32, true).contains(line), "{}", of(0.32, true));
        assert!(!of(0.09, true).contains("noise") && !of(0.32, false).contains("noise"));
    }

    /// Effects, their probabilities, and that of nothing.
    type Set = (&'static [&'static str], &'static [f64], Option<f64>);

    /// The headline and the lines of a barometer with these sets.
    fn said(missing: &[&'static str], sets: &[Set]) -> (String, String) {
        let sensor = SensorDiagnosis {
            verdict: Verdict::Indistinguishable,
            missing: missing.iter().map(|effect| (*effect).into()).collect(),
            indistinguishable: sets
                .iter()
                .map(|(effects, ..)| effects.iter().map(|effect| (*effect).into()).collect())
                .collect(),
            probabilities: sets.iter().map(|(_, probabilities, _)| probabilities.to_vec()).collect(),
            nothing: sets.iter().map(|(.., nothing)| *nothing).collect(),
            ..SensorDiagnosis::default()
        };
        let mut lines = String::new();
        write_sensor(&mut lines, "baro", &sensor, false, false);
        let diagnosis = Diagnosis {
            verdict: Verdict::Indistinguishable,
            sensors: [("baro".into(), sensor)].into(),
            ..Diagnosis::default()
        };
        (headline(&diagnosis), lines)
    }

    /// Where perhaps nothing acts, the text does not claim that an effect is missing.
    #[test]
    fn what_may_be_nothing_is_reported_as_a_possibility() {
        let drift: Set = (&["baro.drift"], &[0.57], Some(0.43));
        let (headline, lines) = said(&[], &[drift]);
        assert_eq!(headline, "The model may lack baro.drift: these flights cannot show whether it acts.");
        assert!(lines.contains("  perhaps: baro.drift (57 %), or nothing (43 %)\n"), "{lines}");
        let several: Set = (&["baro.drift", "baro.scale"], &[0.5, 0.3], Some(0.2));
        let (headline, lines) = said(&["baro.lag"], &[several]);
        assert_eq!(
            headline,
            "The model lacks baro.lag, and may lack another effect: these flights cannot show which, or whether any acts."
        );
        assert!(
            lines.contains("  one of: baro.drift (50 %), baro.scale (30 %), or nothing (20 %)\n"),
            "{lines}"
        );
        // One set whose effect acts for sure is enough.
        let sure: Set = (&["baro.lag", "gps.latency"], &[0.6, 0.38], None);
        let (headline, lines) = said(&[], &[drift, sure]);
        assert_eq!(
            headline,
            "The model lacks an effect, and these flights cannot show which of several it is."
        );
        assert!(lines.contains("  one of: baro.lag (60 %), gps.latency (38 %)\n"), "{lines}");
    }
}
