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
            "\nProbabilities compare all laws tried, and no law at all (no law: {}); a law's own is small where other laws fit equally well.",
            percent(discovery.none)
        );
    }
    put!(
        out,
        "\nSearched: {} laws of {} signals ({}), {} of them with the noise fitted again.",
        discovery.scored,
        discovery.signals.len(),
        discovery.signals.join(", "),
        discovery.fitted
    );
    if !discovery.without_unit.is_empty() {
        put!(
            out,
            "Treated as plain numbers, because neither their names nor the model give a unit: {}.",
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
        put!(out, "\nTo continue with law 1 (or another, by its number):");
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
        return format!("{explained}No recorded signal can be used in a law.");
    }
    let nearest = discovery.rejected.as_ref().map_or_else(String::new, |rejected| {
        let why = match (rejected.why, &rejected.effect) {
            (Why::NotEnoughEvidence, _) => {
                "its fit does not justify its length and the size of the search".to_owned()
            }
            (Why::HeldOut, _) => "it does not make the held-out data more likely".to_owned(),
            (Why::Catalogue, Some(effect)) => {
                format!("{effect} of the catalogue explains as much: see `pylon diagnose`")
            }
            (Why::Catalogue, None) => "an effect of the catalogue explains as much".to_owned(),
            (Why::NoFormula, _) => "it is too long for a formula that can be flown".to_owned(),
            (Why::Shape, _) => "it may be an error in the formulas of the effects found".to_owned(),
        };
        format!("\nThe nearest was {} on {}: {why}.", rejected.regressor, rejected.on)
    });
    format!("{explained}No law of this grammar explains the rest.{nearest}")
}

fn write_law(out: &mut String, number: usize, law: &FoundLaw) {
    put!(out, "\n{number}. {} += c * {}", law.on, law.regressor);
    put!(
        out,
        "   c = {} +- {} {}; probability {} ({} with those equal to it here); {:.0} bits",
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
        put!(out, "   instead of {}, which the diagnosis takes it for", names.join(", "));
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
