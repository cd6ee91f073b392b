//! Laws in plain English.

use std::fmt::Write as _;

use analysis::discover::{Discovery, FoundLaw, Why, id};

/// Writes a line to a string, which cannot fail.
macro_rules! put {
    ($out:expr, $($arguments:tt)*) => {{
        let _ = writeln!($out, $($arguments)*);
    }};
}

/// The result as text, with the commands that continue from it; `command` is the one that was run, without
/// its own options.
#[must_use]
pub fn text(discovery: &Discovery, command: &str) -> String {
    let mut out = String::new();
    for warning in &discovery.warnings {
        put!(out, "{warning}");
    }
    put!(out, "flights: {}", discovery.flights.join(", "));
    if !discovery.hold_outs.is_empty() {
        put!(out, "held out: {}", discovery.hold_outs.join(", "));
    }
    put!(out, "model: {}", discovery.model);
    put!(out, "\n{}", headline(discovery));
    for (k, law) in discovery.laws.iter().enumerate() {
        write_law(&mut out, k + 1, law);
    }
    if !discovery.laws.is_empty() {
        put!(
            out,
            "\nProbabilities are among the laws that were looked at and none (none: {}); a law's own is small where others are equal to it.",
            percent(discovery.none)
        );
    }
    put!(
        out,
        "\nSearched: {} laws of {} signals ({}), {} of them with the noise fitted anew.",
        discovery.scored,
        discovery.signals.len(),
        discovery.signals.join(", "),
        discovery.fitted
    );
    if !discovery.without_unit.is_empty() {
        put!(
            out,
            "Plain numbers, because neither their names nor the model say a unit: {}.",
            discovery.without_unit.join(", ")
        );
    }
    if !discovery.unnamed.is_empty() {
        put!(
            out,
            "Left out, because a formula cannot name them (letters, digits and _ only): {}.",
            discovery.unnamed.join(", ")
        );
    }
    if let Some(law) = discovery.laws.first() {
        let id = id(law, &discovery.signals);
        put!(out, "\nTo go on with law 1 (or another: its number):");
        put!(out, "  touch ours.toml");
        put!(out, "  {command} --write ours.toml 1");
        let first = discovery.flights.first().map_or("FLIGHT", String::as_str);
        put!(out, "  pylon add {id} --model ours.toml --from {first}");
    }
    out
}

fn headline(discovery: &Discovery) -> String {
    let explained = match discovery.catalogue.as_slice() {
        [] => String::new(),
        some => {
            let names: Vec<&str> = some.iter().map(|name| &**name).collect();
            format!("The catalogue explains part of it: {} (`pylon diagnose`). ", names.join(", "))
        }
    };
    if let Some(law) = discovery.laws.first() {
        let many = match discovery.laws.len() {
            1 => "One law explains".to_owned(),
            n => format!("{n} laws are proposed; the most probable one explains"),
        };
        return format!("{explained}{many} {:.2} m of what {} shows in free flight.", law.size_m, law.on);
    }
    if discovery.signals.is_empty() {
        return format!("{explained}No signal is recorded that a law could be made of.");
    }
    let nearest = discovery.rejected.as_ref().map_or_else(String::new, |rejected| {
        let why = match (rejected.why, &rejected.effect) {
            (Why::NotEnoughEvidence, _) => {
                "it does not pay for its length and for the size of the search".to_owned()
            }
            (Why::HeldOut, _) => "what it was not learned from does not become more likely by it".to_owned(),
            (Why::Catalogue, Some(effect)) => {
                format!("{effect} of the catalogue explains as much: see `pylon diagnose`")
            }
            (Why::Catalogue, None) => "an effect of the catalogue explains as much".to_owned(),
            (Why::NoFormula, _) => "it is too long for a formula that flies".to_owned(),
            (Why::Shape, _) => "it is what the formulas of the effects found may miss".to_owned(),
        };
        format!("\nThe nearest was {} on {}: {why}.", rejected.regressor, rejected.on)
    });
    format!("{explained}No law of this grammar explains the rest.{nearest}")
}

fn write_law(out: &mut String, number: usize, law: &FoundLaw) {
    put!(out, "\n{number}. {} += c * {}", law.on, law.regressor);
    put!(
        out,
        "   c = {} +- {} {}; probability {} ({} with those it is equal to here); {:.0} bits",
        significant(law.coefficient),
        significant(law.sigma),
        law.unit,
        percent(law.probability),
        percent(law.probability_with_equals),
        law.bits
    );
    match (law.rms_before_m, law.rms_after_m) {
        (Some(before), Some(after)) => {
            put!(out, "   held out: {before:.2} m rms without it, {after:.2} m with it");
        }
        _ => put!(out, "   held out: not reliable, most of the error would be the coefficient's own"),
    }
    if !law.instead_of.is_empty() {
        let names: Vec<&str> = law.instead_of.iter().map(|name| &**name).collect();
        put!(out, "   in the place of {}, which the diagnosis takes it for", names.join(", "));
    }
    for equal in &law.equal_to {
        let own = equal.probability.map_or_else(String::new, |own| format!(", probability {}", percent(own)));
        put!(out, "   equal here to {} (correlation {:.3}{own})", equal.law, equal.correlation);
    }
    if !law.advice.is_empty() {
        put!(out, "   {}", law.advice);
    }
}

fn percent(share: f64) -> String {
    let percent = 100.0 * share;
    if percent > 99.5 {
        "> 99 %".to_owned()
    } else if percent < 0.5 {
        "< 1 %".to_owned()
    } else {
        format!("{percent:.0} %")
    }
}

/// A value with three significant digits.
pub fn significant(value: f64) -> String {
    let magnitude = value.abs();
    if magnitude == 0.0 {
        return "0".to_owned();
    }
    if !(1e-3..1e5).contains(&magnitude) {
        return format!("{value:.2e}");
    }
    let digits = (2 - magnitude.log10().floor() as i32).max(0) as usize;
    format!("{value:.digits$}")
}
