//! A comparison in plain English and tables.

mod failures;
pub(crate) mod number;
mod rules;
mod sensors;
mod table;

use std::collections::BTreeMap;
use std::fmt::Write as _;

use analysis::name::Name;
use kf_core::sensor::Sensor;

use self::number::{grouped, metres, plain, seconds, signed_m};
use self::table::{by_sensor, row};
use super::words::Words;
use super::{Comparison, CrossCheckFacts, SensorComparison};
use view::text::printable;

/// Writes a line to a string, which cannot fail.
macro_rules! put {
    ($out:expr, $($arguments:tt)*) => {{
        let _ = writeln!($out, $($arguments)*);
    }};
}
use put;

/// The comparison as text about 100 columns wide, with colours as ANSI codes if `colour` is true.
#[must_use]
pub fn text(comparison: &Comparison, colour: bool) -> String {
    let mut out = String::new();
    heading(&mut out, comparison);
    sensors::write(&mut out, comparison, colour);
    failures::write(&mut out, comparison, colour);
    rules::write(&mut out, comparison, colour);
    remedies(&mut out, comparison, colour);
    lines(&mut out, "Data that was refused or changed", &comparison.warnings);
    lines(&mut out, "Missing from this flight", &comparison.failures.missing);
    out
}

/// Entries in the order of the sensors, not of their names.
fn in_order<T>(by_name: &BTreeMap<Name, T>) -> Vec<(&'static str, &T)> {
    Sensor::ALL.iter().filter_map(|sensor| Some((sensor.name(), by_name.get(sensor.name())?))).collect()
}

fn heading(out: &mut String, comparison: &Comparison) {
    let flight = &comparison.flight;
    let launch = match comparison.launch_s {
        None => "no launch".to_owned(),
        Some(launch_s) if flight.usage.has_launch => format!("launch at {launch_s:.3} s"),
        Some(launch_s) => format!("calibrated until {launch_s:.0} s"),
    };
    put!(
        out,
        "{}: {} in {} rows, {launch}",
        flight.file,
        seconds(Some(flight.duration_s)),
        grouped(flight.rows)
    );
    for (key, value) in
        [("vehicle", &flight.vehicle), ("source", &flight.source), ("model", &comparison.model)]
    {
        if !value.is_empty() {
            put!(out, "  {key:<9}{}", printable(value));
        }
    }
    if let Some(in_the_air) = flight.usage.in_the_air() {
        put!(out, "  flight   {in_the_air}");
    }
    for line in flight.usage.lines() {
        put!(out, "  {line}");
    }
    put!(out, "");
    let words = comparison.words();
    let calibration = &comparison.calibration;
    match &calibration.quality {
        None => put!(out, "Calibration: nothing was latched ({}).", calibration.source),
        Some(quality) => {
            let duration = seconds(calibration.duration_s);
            put!(out, "Calibration: {quality}, {duration} long ({}).", calibration.source);
            for check in &calibration.failed_checks {
                put!(out, "  failed: {check} - {}", meaning(check));
            }
        }
    }
    for effect in &comparison.effects {
        let unit = if effect.unit == "1" { String::new() } else { format!(" {}", effect.unit) };
        let how = if effect.estimated {
            format!("estimated in {}", words.before)
        } else {
            "constant in the model".to_owned()
        };
        put!(
            out,
            "Effect {}: {} ± {}{unit}, {how}.",
            effect.effect,
            plain(Some(effect.coefficient)),
            plain(Some(effect.sigma))
        );
        if let (Some([least, largest]), 1..) = (effect.envelope_m, effect.extrapolated_ticks) {
            put!(
                out,
                "  extrapolated at {} ticks: its regressor was {} to {} m when it was learned",
                grouped(effect.extrapolated_ticks.into()),
                plain(Some(least)),
                plain(Some(largest))
            );
        }
    }
    if comparison.launch_s.is_some() {
        for (name, sensor) in in_order(&comparison.sensors) {
            if sensor.flies_free {
                put!(out, "{name}: {}", verdict(sensor, words));
            }
        }
        if let Some(check) = &comparison.cross_check {
            put!(out, "{}", without_reference(check, words));
        }
    }
}

/// The meaning of a failed check.
pub(crate) fn meaning(check: &str) -> &'static str {
    match check {
        "settled" => "launched before the settling time had passed",
        "long_enough" => "the calibration was too short",
        "trimmed_altitude" => "the altitude was not quiet",
        "trimmed_airspeed" => "the airspeed was not quiet",
        "reference_converged" => {
            "the receiver's altitude was still drifting, or the receiver reported poor accuracy"
        }
        "reference_fresh" => "the reference was lost during the calibration or at launch",
        "biases_stationary" => "a bias drifted",
        "innovations_plausible" => "innovations were larger than the model predicts",
        "inputs_valid" => "values were not finite, or time ran backward",
        "sensors_alive" => "a sensor was stuck or silent",
        "launch_confirmed" => "only the umbilical's wire indicated the launch",
        "readings_consistent" => {
            "a source had many outliers, stepped during the calibration, has ten times the spread in the model, or a bias that its prior \
             rules out"
        }
        _ => "see the documentation of kf_core::quality",
    }
}

/// How the sensors agreed with each other without the reference.
fn without_reference(check: &CrossCheckFacts, Words { event, .. }: Words) -> String {
    let most = signed_m(Some(check.largest_difference_m));
    let said = match (check.disagree_after_s, check.doubtful_after_s) {
        (Some(after_s), _) => format!(
            "disagree from {} after {event}: one of them is wrong, and nothing shows which",
            seconds(Some(after_s))
        ),
        (None, Some(after_s)) => format!("are doubtful from {} after {event}", seconds(Some(after_s))),
        (None, None) => "agree".to_owned(),
    };
    format!("Without the reference baro and imu_slave {said} (at most {most} apart).")
}

fn verdict(sensor: &SensorComparison, Words { after, event, .. }: Words) -> String {
    if sensor.free_flight.readings == 0 {
        return format!("{}; no reading in {after} had a reference.", sensor.trust);
    }
    let rms = metres(sensor.free_flight_rms_m);
    match (sensor.doubtful_after_s, sensor.untrustworthy_after_s) {
        (Some(doubtful), Some(untrustworthy)) => format!(
            "doubtful {} after {event}, untrustworthy {} later; rms error in {after} {rms}.",
            seconds(Some(doubtful)),
            seconds(Some(untrustworthy - doubtful)),
        ),
        (Some(doubtful), None) => format!(
            "doubtful {} after {event}, never untrustworthy; rms error in {after} {rms}.",
            seconds(Some(doubtful)),
        ),
        _ => format!("never doubtful, {} at the end; rms error in {after} {rms}.", sensor.trust),
    }
}

fn never(after_s: Option<f64>) -> String {
    after_s.map_or_else(|| "never".to_owned(), |after_s| seconds(Some(after_s)))
}

fn remedies(out: &mut String, comparison: &Comparison, colour: bool) {
    let Some(first) = comparison.remedies.first() else { return };
    put!(
        out,
        "\nSecond corrections in {} (section 4 of the paper), each run on this flight",
        comparison.words().after
    );
    let names: Vec<&str> = first.sensors.iter().map(|figures| &*figures.sensor).collect();
    let mut table = by_sensor("mean and rms error; untrustworthy after", &names);
    for remedy in &comparison.remedies {
        let label = match &*remedy.second_correction {
            "moving_average" => "moving average",
            "kalman" => "Kalman filter",
            other => other,
        };
        let cells = remedy.sensors.iter().map(|figures| {
            format!(
                "{}, {}; {}",
                signed_m(Some(figures.mean_m)),
                metres(Some(figures.rms_m)),
                never(figures.untrustworthy_after_s)
            )
        });
        row(&mut table, label, cells);
    }
    put!(out, "{}", view::text::table(&table, colour));
    put!(
        out,
        "Both learn from the reference: they show how slow the errors are, not that the sensor is right."
    );
}

fn lines(out: &mut String, title: &str, lines: &[String]) {
    if lines.is_empty() {
        return;
    }
    put!(out, "\n{title}");
    for line in lines {
        put!(out, "  {}", printable(line));
    }
}
