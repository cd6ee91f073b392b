//! An addition and a ladder in plain English.

use std::fmt::Write as _;

use view::Table;

use analysis::learn::{Addition, FlightChange, JudgedOn, Ladder, SensorScore};

/// Writes a line to a string, which cannot fail.
macro_rules! put {
    ($out:expr, $($arguments:tt)*) => {{
        let _ = writeln!($out, $($arguments)*);
    }};
}

fn number(value: Option<f64>, digits: usize) -> String {
    value.map_or_else(|| "-".to_owned(), |value| format!("{value:.digits$}"))
}

/// When a flag was raised: seconds after launch.
fn flag(after_s: Option<f64>) -> String {
    after_s.map_or_else(|| "never".to_owned(), |after_s| format!("{after_s:.1}"))
}

/// Reports what was added to which file.
#[must_use]
pub fn addition_text(addition: &Addition, file: &str) -> String {
    let mut out = String::new();
    let unit = if addition.unit == "1" { String::new() } else { format!(" {}", addition.unit) };
    let how = if addition.estimate { "a state of the filter, with this as its prior" } else { "a constant" };
    put!(
        out,
        "{}: coefficient {} +- {}{unit} (1 sigma), {how}",
        addition.effect,
        addition.coefficient,
        addition.sigma
    );
    if let Some(time_constant_s) = addition.time_constant_s {
        let since = if addition.since.as_deref() == Some("start") { "the first tick" } else { "launch" };
        put!(out, "  time constant {time_constant_s} s, since {since}");
    }
    if let Some(catalogues) = &addition.instead_of {
        put!(
            out,
            "  {catalogues} in the shape that it has here: a low pass, defined in the model; the catalogue's is the climb rate \
             itself"
        );
    }
    if let Some([least, largest]) = addition.envelope_m {
        put!(
            out,
            "  learned while its regressor was {least:.4} to {largest:.4} m per unit; use outside is reported as extrapolated"
        );
    }
    if let Some(replaced) = addition.replaced_coefficient {
        put!(out, "  replaces the model's earlier value, {replaced}{unit}");
    }
    put!(out, "written to {file} as revision {}", addition.revision);
    put!(out, "\nError in free flight (rms, eq. 16) and flags (s after launch), before -> after:\n");
    let mut rows = Table::new()
        .left("flight")
        .left("")
        .left("sensor")
        .right("error, m")
        .right("doubtful")
        .right("untrustworthy");
    for (kind, flights) in [("learned from", &addition.learning), ("held out", &addition.held_out)] {
        for flight in flights {
            add_rows(&mut rows, kind, flight);
        }
    }
    put!(out, "{}", view::text::table(&rows, false));
    put!(out, "\n{}", held_out(addition));
    for concern in &addition.concerns {
        put!(out, "\nwritten despite this (--force): {concern}");
    }
    for warning in &addition.warnings {
        put!(out, "\nwarning: {warning}");
    }
    out
}

/// The result on held-out data: raw errors and likelihood.
fn held_out(addition: &Addition) -> String {
    let mut out = String::new();
    let verdict = &addition.held_out_verdict;
    let of = match addition.judged_on {
        JudgedOn::HeldOutFlights => "Held-out flights",
        JudgedOn::HeldOutManoeuvres => "Held-out manoeuvres of the learning flights",
    };
    put!(
        out,
        "{of}: raw rms {} m without the effect, {} m with it.",
        number(addition.rms_before_m, 2),
        number(addition.rms_after_m, 2)
    );
    let outcome = if verdict.is_worse {
        "worse with the effect, beyond chance"
    } else if verdict.gain > 0.0 {
        "better with it"
    } else {
        "no worse than chance"
    };
    put!(
        out,
        "The decision rests on their likelihood, which allows for the reference's wander: twice its logarithm changes by\n\
         {:+.1} +- {:.1} (1 sigma), and by {:+.1} if the effect acts as learned: {outcome}.",
        verdict.gain,
        verdict.gain_sigma,
        verdict.gain_as_learned
    );
    if let ([Some(before), Some(after)], false) =
        ([addition.rms_before_m, addition.rms_after_m], verdict.is_worse)
        && after > before
    {
        put!(out, "The raw rms is mostly that wander and is larger by chance.");
    }
    if addition.judged_on == JudgedOn::HeldOutManoeuvres {
        put!(out, "Check it on another flight (--hold-out).");
    }
    out.trim_end().to_owned()
}

fn add_rows(rows: &mut Table, kind: &str, flight: &FlightChange) {
    for (name, change) in &flight.sensors {
        let (before, after) = (&change.before, &change.after);
        if before.free_flight_rms_m.is_none() && after.free_flight_rms_m.is_none() {
            continue;
        }
        let both = |show: &dyn Fn(&SensorScore) -> String| format!("{} -> {}", show(before), show(after));
        rows.row([
            flight.file.clone(),
            kind.to_owned(),
            name.to_string(),
            both(&|score| number(score.free_flight_rms_m, 2)),
            both(&|score| flag(score.doubtful_after_s)),
            both(&|score| flag(score.untrustworthy_after_s)),
        ]);
    }
}

/// The results of every revision on every flight.
#[must_use]
pub fn ladder_text(ladder: &Ladder) -> String {
    let mut out = String::new();
    put!(out, "model: {}", ladder.model);
    put!(out, "Errors are rms (eq. 16); flags are seconds after launch.\n");
    let words = ["revision", "added", "flight", "sensor"];
    let mut rows = words.into_iter().fold(Table::new(), Table::left);
    rows = ["captive, m", "free, m", "doubtful", "untrustworthy"].into_iter().fold(rows, Table::right);
    for revision in &ladder.revisions {
        for flight in &revision.flights {
            for (name, score) in &flight.sensors {
                let is_free = score.free_flight_rms_m.is_some();
                let flag_of = |after_s: Option<f64>| if is_free { flag(after_s) } else { "-".to_owned() };
                rows.row([
                    revision.number.to_string(),
                    revision.effect.as_deref().unwrap_or("-").to_owned(),
                    flight.file.clone(),
                    name.to_string(),
                    number(score.captive_rms_m, 2),
                    number(score.free_flight_rms_m, 2),
                    flag_of(score.doubtful_after_s),
                    flag_of(score.untrustworthy_after_s),
                ]);
            }
        }
    }
    put!(out, "{}", view::text::table(&rows, false));
    if ladder.revisions.len() == 1 {
        put!(out, "\nThe model has no revisions; `pylon add` writes one for each effect it learns.");
    }
    out
}
