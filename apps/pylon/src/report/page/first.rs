//! The first screen: the finding, and the errors that support it.

use maud::{Markup, html};

use super::{file_name, place};
use crate::compare::words::Words;
use crate::diagnose::text::headline;
use crate::report::{Chart, FlightReport, Report};

/// Limit on the diagrams side by side.
const MOST: usize = 2;

pub(super) fn section(report: &Report<'_>) -> Markup {
    // The sensor with the gravest verdict, which the sentence is about.
    let sensors = report.diagnosis.sensors.iter().filter(|(name, _)| **name != "gps");
    let gravest = sensors.max_by_key(|(_, sensor)| sensor.verdict).map(|(name, _)| &**name);
    let drawn = report.flights.iter().filter(|flight| flight.is_drawn);
    let shown: Vec<_> =
        drawn.filter_map(|flight| Some((flight, error(flight, gravest)?))).take(MOST).collect();
    html! {
        section #found {
            p.verdict { (headline(report.diagnosis)) }
            div.firsts {
                @for (flight, chart) in shown {
                    figure {
                        figcaption { (caption(flight, chart)) }
                        (place(chart, true))
                    }
                }
            }
        }
    }
}

/// The errors after the calibration of this sensor, or else of another; without any, the residuals of the
/// calibration.
fn error<'a>(flight: &'a FlightReport, sensor: Option<&str>) -> Option<&'a Chart> {
    let of_sensor = |chart: &&Chart| sensor.is_some_and(|sensor| chart.id.ends_with(&format!("-{sensor}")));
    flight
        .free_flight
        .iter()
        .find(of_sensor)
        .or_else(|| flight.free_flight.first().or_else(|| flight.residuals.first()))
}

fn caption(flight: &FlightReport, chart: &Chart) -> String {
    let sensor = chart.id.rsplit('-').next().unwrap_or_default();
    let Words { event, .. } = flight.comparison.words();
    let file = file_name(&flight.comparison.flight.file);
    if flight.free_flight.is_empty() {
        format!("{file}: the residual of {sensor}")
    } else {
        format!("{file}: the error of {sensor} after {event}")
    }
}
