//! One flight: its summary, its figures, and where the model fails.

use maud::{Markup, html};

use super::{calibration, file_name, place, signals};
use crate::compare::text::number::{grouped, metres, percent, seconds, signed_m};
use crate::compare::words::Words;
use crate::report::figures::free_sensors;
use crate::report::{Chart, FlightReport, summary as words};

/// A flight's summary, at a glance.
pub(super) fn summary(report: &FlightReport, is_one_of_many: bool) -> Markup {
    let comparison = &report.comparison;
    let facts = &comparison.flight;
    html! {
        section.summary aria-label=(format!("Summary of {}", file_name(&facts.file))) {
            @if is_one_of_many { h2 { (file_name(&facts.file)) } }
            p.meta {
                (seconds(Some(facts.duration_s))) " in " (grouped(facts.rows)) " rows"
                @if let Some(launch_s) = comparison.launch_s {
                    @if facts.usage.has_launch { ", launched at " } @else { ", calibrated until " } (seconds(Some(launch_s)))
                }
                @if let Some(in_the_air) = facts.usage.in_the_air() { ", " (in_the_air) }
                @if !facts.vehicle.is_empty() { " · " (facts.vehicle) }
                @if !facts.source.is_empty() { " · source: " (facts.source) }
            }
            @for line in facts.usage.lines() { p.unused { (line) } }
            p { (words::calibration(comparison)) }
            div.cards {
                @for (sensor, found) in free_sensors(comparison) {
                    @let outcome = words::outcome(&found.trust);
                    article class=(format!("card {}", outcome.word)) {
                        h3 { (sensor.name()) }
                        p.outcome title=(outcome.meaning) {
                            span.sign aria-hidden="true" { (outcome.sign) } " " (outcome.word)
                        }
                        @for sentence in words::sensor(sensor.name(), found, comparison) { p { (sentence) } }
                    }
                }
            }
            @if !comparison.warnings.is_empty() {
                details.warnings open {
                    summary { "Data that was refused or changed (" (comparison.warnings.len()) ")" }
                    ul { @for warning in &comparison.warnings { li { (warning) } } }
                }
            }
        }
    }
}

/// All sections of a flight.
pub(super) fn section(report: &FlightReport) -> Markup {
    let Words { before, event, .. } = report.comparison.words();
    html! {
        section id=(report.id) {
            h2 { "Flight " (file_name(&report.comparison.flight.file)) }
            p.hint {
                "Drag in a diagram to zoom, double-click to see all again. With the keyboard: Tab to a diagram, arrow keys move the \
                 cursor, + and − zoom, 0 resets. Diagrams over the same time move together."
            }
            (measured(report))
            (failures(report))
            (calibration::section(report))
            (figure(
                &format!("Figure 2: what was estimated in {before}"),
                "The reference's altitude and each sensor's bias while the filter learns them, with the filter's own \
                 standard deviation. A bias that has settled stays level and its band narrows.",
                &report.calibration,
            ))
            (figure(
                &format!("Figure 3: what was left over in {before}"),
                "Residuals: readings minus the filter's predictions. They should look like noise about zero. A slow wave means \
                 that something is correlated that the model treats as independent.",
                &report.residuals,
            ))
            (figure(
                &format!("Figure 4: errors after {event}"),
                &format!("Each sensor's error after {event}, by its calibration. Doubtful: the error has exceeded the alarm limit once. \
                 Untrustworthy: after that, its moving average has too."),
                &report.free_flight,
            ))
            (signals::section(report))
            @if !report.comparison.failures.missing.is_empty() {
                h3 { "Missing from this flight" }
                ul { @for missing in &report.comparison.failures.missing { li { (missing) } } }
            }
        }
    }
}

fn figure(title: &str, words: &str, charts: &[Chart]) -> Markup {
    html! {
        @if !charts.is_empty() {
            section.figure {
                h3 { (title) }
                p { (words) }
                @for chart in charts { (place(chart, false)) }
            }
        }
    }
}

fn measured(report: &FlightReport) -> Markup {
    html! {
        @if !report.measured.is_empty() {
            section.figure {
                h3 { "Measured against modelled" }
                p {
                    "What each sensor read, what the model says it should have read, and below the difference. "
                    @if report.comparison.launch_s.is_some() {
                        "Shaded: the stretches of " (report.comparison.words().after) " with the largest errors."
                    }
                }
                @for (sensor, charts) in &report.measured {
                    h4 { (sensor) }
                    @for chart in charts { (place(chart, false)) }
                }
            }
        }
    }
}

fn failures(report: &FlightReport) -> Markup {
    let failures = &report.comparison.failures;
    let Words { after, event, .. } = report.comparison.words();
    html! {
        @if !failures.worst.is_empty() {
            section {
                h3 { "Where the model fails" }
                p { "The stretches of " (after) " with the largest errors, and what the aircraft was doing then." }
                div.scroll tabindex="0" {
                    table {
                        thead { tr {
                            th scope="col" { "sensor" } th scope="col" { "after " (event) } th scope="col" { "what it was doing" }
                            th.number scope="col" { "mean error" } th.number scope="col" { "rms error" }
                            th.number scope="col" { "share of all squared error" }
                        } }
                        tbody {
                            @for stretch in &failures.worst {
                                tr {
                                    th scope="row" { (stretch.sensor) }
                                    td { (format!("{:.0} to {:.0} s", stretch.from_s, stretch.to_s)) }
                                    td { (stretch.doing.name()) " (" (stretch.motion.to_string()) ")" }
                                    td.number { (signed_m(Some(stretch.mean_m))) }
                                    td.number { (metres(Some(stretch.rms_m))) }
                                    td.number { (percent(Some(stretch.share_of_squared_error))) }
                                }
                            }
                        }
                    }
                }
                (by_manoeuvre(report))
            }
        }
    }
}

fn by_manoeuvre(report: &FlightReport) -> Markup {
    let manoeuvres = &report.comparison.failures.by_manoeuvre;
    let Some(first) = manoeuvres.first() else { return html! {} };
    html! {
        h4 { "By manoeuvre" }
        div.scroll tabindex="0" {
            table {
                thead { tr {
                    th scope="col" { "manoeuvre" } th.number scope="col" { "for" } th scope="col" { "on average" }
                    @for (sensor, _) in &first.sensors { th.number scope="col" { (sensor) ": mean, rms error" } }
                } }
                tbody {
                    @for manoeuvre in manoeuvres {
                        tr {
                            th scope="row" { (manoeuvre.doing.name()) }
                            td.number { (format!("{:.0} s", manoeuvre.seconds)) }
                            td { (manoeuvre.motion.to_string()) }
                            @for (_, errors) in &manoeuvre.sensors {
                                td.number {
                                    @match errors {
                                        Some(errors) => { (signed_m(Some(errors.mean_m))) ", " (metres(Some(errors.rms_m))) }
                                        None => "-",
                                    }
                                }
                            }
                        }
                    }
                }
            }
        }
    }
}
