//! The page's text and tables; `assets/` has its style and the script that draws its diagrams.

mod bars;
mod batch;
mod calibration;
mod diagnosis;
mod effects;
mod first;
mod flight;
mod glossary;
mod ladder;
mod signals;

use maud::{DOCTYPE, Markup, PreEscaped, html};
use view::Table;

use super::ladder::LadderFlight;
use super::{Chart, Report};

const STYLE: &str = include_str!("../assets/report.css");
const PAGE: &str = include_str!("../assets/page.js");
const UPLOT: &str = include_str!(concat!(env!("OUT_DIR"), "/uplot.js"));
const UPLOT_STYLE: &str = include_str!(concat!(env!("OUT_DIR"), "/uplot.css"));
const UPLOT_LICENCE: &str = include_str!(concat!(env!("OUT_DIR"), "/uplot-license.txt"));

pub(super) fn page(report: &Report<'_>) -> String {
    let title = title(report);
    let mut revisions = super::ladder::flights(report.ladder);
    let undrawn = |revision: &LadderFlight<'_>| {
        report.flights.iter().any(|flight| !flight.is_drawn && flight.comparison.flight.file == revision.file)
    };
    for revision in revisions.iter_mut().filter(|revision| undrawn(revision)) {
        revision.chart = None;
    }
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                meta name="generator" content=(format!("pylon {}", env!("CARGO_PKG_VERSION")));
                // No network: if the page requests anything, that is a mistake in it, and the request is
                // blocked.
                meta http-equiv="Content-Security-Policy"
                    content="default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data:";
                link rel="icon" href="data:,";
                title { (title) }
                style { (PreEscaped(UPLOT_STYLE)) (PreEscaped(view::page::style())) (PreEscaped(STYLE)) }
            }
            body {
                a.skip href="#main" { "Skip to the content" }
                (header(report, &title))
                main #main {
                    (first::section(report))
                    @match report.batch {
                        // For several flights, the joint result comes first.
                        Some(batch) => {
                            (diagnosis::section(report.diagnosis))
                            (batch::section(batch, report.flights))
                            (opening(report))
                            (summaries(report))
                        }
                        None => {
                            (opening(report))
                            @for found in report.flights { (flight::summary(found, report.flights.len() > 1)) }
                            (diagnosis::section(report.diagnosis))
                        }
                    }
                    (ladder::section(report.model, report.model_name, &revisions))
                    @for found in report.flights.iter().filter(|flight| flight.is_drawn) { (flight::section(found)) }
                    (glossary::section())
                }
                (footer())
                script #chart-data type="application/json" { (PreEscaped(data(report, &revisions))) }
                script { (PreEscaped(UPLOT)) }
                script { (PreEscaped(view::page::SCRIPT)) }
                script { (PreEscaped(PAGE)) }
            }
        }
    }
    .into_string()
}

fn title(report: &Report<'_>) -> String {
    match report.flights {
        [only] => format!("{}: a flight report", file_name(&only.comparison.flight.file)),
        flights => format!("{} flights: a report", flights.len()),
    }
}

fn header(report: &Report<'_>, title: &str) -> Markup {
    html! {
        header.top {
            div.brand {
                h1 { (title) }
                p.sub { "model " b { (report.model_name) } ", by pylon " (env!("CARGO_PKG_VERSION")) }
            }
            nav aria-label="Parts of this page" {
                a href="#diagnosis" { "What is missing" }
                a href="#ladder" { "How the error fell" }
                @if report.batch.is_some() { a href="#batch" { "Flight by flight" } }
                @for found in report.flights.iter().filter(|flight| flight.is_drawn) {
                    a href=(format!("#{}", found.id)) {
                        @if report.flights.len() > 1 { (file_name(&found.comparison.flight.file)) } @else { "Flight" }
                    }
                }
                a href="#words" { "Words" }
            }
            button #theme type="button" aria-label="◐ auto: the system's colours" { "◐ auto" }
        }
    }
}

/// A summary of every flight; those without diagrams open on demand.
fn summaries(report: &Report<'_>) -> Markup {
    let (drawn, others): (Vec<_>, Vec<_>) = report.flights.iter().partition(|flight| flight.is_drawn);
    html! {
        @for found in drawn { (flight::summary(found, true)) }
        @if !others.is_empty() {
            details {
                summary { (others.len()) " more flights, in words" }
                @for found in others { (flight::summary(found, true)) }
            }
        }
    }
}

fn opening(report: &Report<'_>) -> Markup {
    // For a vehicle that flies on its own wings the text does not mention a pylon.
    let is_launched = report.flights.iter().any(|flight| flight.comparison.flight.usage.has_launch);
    html! {
        section.lead {
            p {
                @if is_launched {
                    "A UAV hangs under its mother ship's pylon until it is launched. While it hangs there, Pylon compares its \
                     altitude sensors with gps and learns what is wrong with them. From launch on it subtracts these errors, "
                } @else {
                    "On one quiet stretch of a flight Pylon compares its altitude sensors with gps and learns what is wrong with \
                     them. From then on it subtracts these errors, "
                }
                "watches the sensors, and reports when one can no longer be trusted. This page shows how well the model "
                b { (report.model_name) }
                " described "
                @if report.flights.len() == 1 { "one flight" } @else { (report.flights.len()) " flights" }
                ", and where it did not."
            }
        }
    }
}

fn footer() -> Markup {
    html! {
        footer {
            p { "Made by pylon " (env!("CARGO_PKG_VERSION")) ". Everything is in this file; it loads nothing from a network." }
            details {
                summary { "The diagrams are drawn by uPlot, under this licence" }
                pre { (UPLOT_LICENCE) }
            }
        }
    }
}

/// The diagrams' data.
fn data(report: &Report<'_>, revisions: &[LadderFlight<'_>]) -> String {
    let flights = report.flights.iter().flat_map(super::FlightReport::charts);
    let charts = flights.chain(revisions.iter().filter_map(|flight| flight.chart.as_ref()));
    // Numbers and text only, which always serialise.
    view::page::data(charts).unwrap_or_default()
}

/// The place where a script draws a diagram. Without scripts it says so.
fn place(chart: &Chart, small: bool) -> Markup {
    html! {
        div.chart.small[small] data-chart=(chart.id) tabindex="0" role="group"
            aria-label=(format!("Diagram: {} over {}. Arrow keys move the cursor, plus and minus zoom, zero resets.", chart.y_name, chart.x_name)) {
            noscript { "This diagram needs JavaScript." }
        }
    }
}

/// A table that scrolls sideways on a narrow screen.
fn scrolled(table: &Table) -> Markup {
    html! { div.scroll tabindex="0" { (PreEscaped(view::page::table(table))) } }
}

/// A file's name on the page, without its folders: the page may be shared, and the author's folders are
/// private.
pub fn file_name(path: &str) -> String {
    std::path::Path::new(path)
        .file_name()
        .map_or_else(|| path.to_owned(), |name| name.to_string_lossy().into_owned())
}
