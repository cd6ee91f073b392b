//! The monitor's rule as set, and a recommended one.

use std::fmt::Write as _;

use super::super::words::Words;
use super::number::{NONE, metres, per_hour, percent, plain, seconds};
use super::table::{by_sensor, row};
use super::{in_order, never, put};
use view::Table;

use crate::compare::{Comparison, SensorRules};
use crate::statistics::{Delay, Fault, RuleQuality};

/// Share of launches with a false alarm above which a line reports it.
const NOTEWORTHY_SHARE: f64 = 0.01;

pub(super) fn write(out: &mut String, comparison: &Comparison, colour: bool) {
    let by_name = in_order(&comparison.rules);
    if by_name.is_empty() {
        return;
    }
    let names: Vec<&str> = by_name.iter().map(|(name, _)| *name).collect();
    let columns: Vec<&SensorRules> = by_name.iter().map(|(_, rules)| *rules).collect();
    let monitor = &comparison.monitor;
    let Words { before, residual, .. } = comparison.words();
    put!(out, "\nThe monitor's rule, assessed on each sensor's own {residual}");
    let mut table = by_sensor("fault to detect", &names);
    let row_of = |table: &mut Table, label: &str, cell: &dyn Fn(&SensorRules) -> String| {
        row(table, label, columns.iter().map(|rules| cell(rules)));
    };
    row_of(&mut table, "step", &|rules| rules.step().map_or_else(|| NONE.to_owned(), fault));
    row_of(&mut table, "ramp", &|rules| rules.ramp().map_or_else(|| NONE.to_owned(), fault));

    table.section("current rule");
    row_of(&mut table, "rule", &|_| rule(monitor.multiplier, monitor.window_s));
    quality_rows(&mut table, &columns, |rules| rules.set.as_ref());

    let wanted = columns.first().map(|rules| rules.wanted_false_alarms_per_hour);
    table.section(format!("recommended at {}", per_hour(wanted)));
    row_of(&mut table, "rule", &|rules| {
        rules
            .recommended
            .as_ref()
            .map_or_else(|| format!("{before} too short"), |advice| rule(advice.multiplier, advice.window_s))
    });
    quality_rows(&mut table, &columns, |rules| rules.recommended.as_ref().map(|advice| &advice.quality));
    put!(out, "{}", view::text::table(&table, colour));
    for (name, rules) in by_name {
        notes(out, name, rules, before);
    }
}

fn rule(multiplier: f64, window_s: f64) -> String {
    format!("{} sigma, {} average", plain(Some(multiplier)), seconds(Some(window_s)))
}

fn quality_rows(
    table: &mut Table,
    columns: &[&SensorRules],
    quality: impl for<'a> Fn(&'a SensorRules) -> Option<&'a RuleQuality>,
) {
    let mut row_of = |label: &str, cell: &dyn Fn(&RuleQuality) -> String| {
        let of = |rules: &&SensorRules| quality(rules).map_or_else(|| NONE.to_owned(), cell);
        row(table, label, columns.iter().map(of));
    };
    row_of("alarm limit", &|quality| metres(Some(quality.rule.threshold_m)));
    row_of("healthy readings beyond it", &|quality| percent(Some(quality.healthy_share_beyond)));
    row_of("first doubt on a healthy sensor after", &|quality| {
        quality.healthy_first_doubt_s.map_or_else(|| "> 10 min".to_owned(), |s| seconds(Some(s)))
    });
    row_of("false alarms (untrustworthy)", &|quality| per_hour(Some(quality.false_alarms_per_hour)));
    row_of("step detected after (90 %)", &|quality| delay(quality.delays.first()));
    row_of("ramp detected after (90 %)", &|quality| delay(quality.delays.get(1)));
}

fn fault(fault: Fault) -> String {
    match fault {
        Fault::Step { size_m } => metres(Some(size_m)),
        Fault::Ramp { rate_mps } => format!("{}/s", metres(Some(rate_mps))),
    }
}

/// Median and ninetieth percentile: `1.10 s (1.40 s)`.
fn delay(delay: Option<&Delay>) -> String {
    delay.map_or_else(
        || NONE.to_owned(),
        |delay| format!("{} ({})", never(delay.median_s), never(delay.ninety_percent_s)),
    )
}

fn notes(out: &mut String, name: &str, rules: &SensorRules, before: &str) {
    put!(
        out,
        "{name}: the {before} shows correlation up to {}; these figures do not include slower wander.",
        seconds(Some(rules.residual.longest_lag_s))
    );
    if let Some(advice) = rules.recommended.as_ref().filter(|advice| !advice.detects_step) {
        put!(
            out,
            "{name}: no rule detects that step nine times in ten at that false-alarm rate; the smallest detectable step is {}.",
            metres(Some(advice.smallest_step_m))
        );
    }
    let first_window = |quality: Option<&RuleQuality>| {
        quality.map(|quality| quality.healthy_alarm_in_first_window).filter(|share| *share > NOTEWORTHY_SHARE)
    };
    for (kind, share) in [
        ("current rule", first_window(rules.set.as_ref())),
        ("recommended rule", first_window(rules.recommended.as_ref().map(|advice| &advice.quality))),
    ] {
        if let Some(share) = share {
            put!(
                out,
                "{name}, {kind}: {} of healthy launches are called untrustworthy before the averaging window is full.",
                percent(Some(share))
            );
        }
    }
}
