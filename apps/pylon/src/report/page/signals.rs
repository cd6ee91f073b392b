//! The sensors' errors against every signal of the flight.

use maud::{Markup, html};

use super::place;
use crate::compare::text::number::percent;
use crate::report::{FlightReport, SensorDependences};

/// Number of diagrams shown at once; the rest open on demand.
const SHOWN: usize = 6;

pub(super) fn section(report: &FlightReport) -> Markup {
    let captive = report.comparison.launch_s.is_none();
    html! {
        @if !report.dependences.is_empty() {
            section.figure {
                h3 { "The error against every signal" }
                p {
                    "Each dot is the mean error of a short stretch of "
                    @if captive { "captive" } @else { "free" }
                    " flight; the line is the mean of the dots near it, the band their spread. A flat line means that the error does not \
                     depend on that signal. One that is not flat is a hint, not yet a cause: signals change together in a \
                     manoeuvre, and a slowly wandering gps can look like anything."
                }
                @for found in &report.dependences { (of_sensor(found)) }
            }
        }
    }
}

fn of_sensor(found: &SensorDependences) -> Markup {
    let (shown, rest) = found.charts.split_at(found.charts.len().min(SHOWN));
    let card = |(share, chart): &(f64, super::Chart)| {
        html! {
            figure {
                figcaption { (chart.x_name) " " span.note { (percent(Some(*share))) " of the variance" } }
                (place(chart, true))
            }
        }
    };
    html! {
        h4 { (found.sensor) }
        p.hint { "Stretches of " (format!("{:.1} s", found.block_s)) ", the most informative signals first." }
        div.grid { @for one in shown { (card(one)) } }
        @if !rest.is_empty() {
            details {
                summary { (rest.len()) " more signals" }
                div.grid { @for one in rest { (card(one)) } }
            }
        }
        @if !found.quiet.is_empty() {
            p.hint { "Changed too little, or came too rarely, to tell: " (found.quiet.join(", ")) "." }
        }
    }
}
