//! The model's history: how the error fell, and when flags were raised, revision by revision.

use maud::{Markup, html};
use model::{Model, Revision};

use super::bars::{bar, bars, share};
use super::{file_name, place};
use crate::compare::text::number::seconds;
use crate::learn::SensorScore;
use crate::report::ladder::{LadderFlight, name};

pub(super) fn section(model: &Model, called: &str, flights: &[LadderFlight<'_>]) -> Markup {
    let has_history = !model.revisions.is_empty();
    html! {
        section #ladder {
            h2 { "How the error fell" }
            @if has_history {
                p {
                    "Each effect that was learned is a revision of the model " b { (called) } ". Here every revision is flown over \
                     every flight once more: a good one makes the error smaller and the flags later, on flights that it was \
                     not learned from too."
                }
            } @else {
                p {
                    "The model " b { (called) } " has no revisions. Each effect that " code { "pylon add" }
                    " learns is written into the model file as one; then this part shows how the error fell from one to the next."
                }
            }
            @for flight in flights { (of_flight(flight, has_history)) }
            @if has_history { (when_learned(model)) }
        }
    }
}

/// Every revision on one flight.
fn of_flight(flight: &LadderFlight<'_>, has_history: bool) -> Markup {
    let scores = || flight.steps.iter().flat_map(|(_, scores)| scores.iter().map(|(_, score)| *score));
    let greatest = scores().filter_map(|score| score.free_flight_rms_m).fold(0.0, f64::max);
    let longest_s = scores().filter_map(|score| score.free_flight_s).fold(0.0, f64::max);
    html! {
        h3 { (file_name(flight.file)) }
        @if scores().next().is_none() {
            p.hint { "No sensor has an error in free flight: there was no launch, or no reference after it." }
        } @else {
            @if let Some(chart) = &flight.chart { (place(chart, false)) }
            div.scroll tabindex="0" {
                table.revisions {
                    thead { tr {
                        th scope="col" { @if has_history { "revision" } @else { "model" } } th scope="col" { "sensor" }
                        th scope="col" { "rms error in free flight" }
                        th scope="col" { "trusted for how long, of " (seconds(Some(longest_s))) " of free flight" }
                    } }
                    tbody {
                        @for (revision, scores) in &flight.steps {
                            @for (sensor, score) in scores {
                                tr {
                                    th scope="row" { @if has_history { (name(revision)) } @else { "as it is" } }
                                    td { (sensor) }
                                    td { @if let Some(rms_m) = score.free_flight_rms_m { (bar(rms_m, greatest)) } }
                                    td { (trust(score, longest_s)) }
                                }
                            }
                        }
                    }
                }
            }
        }
    }
}

/// From launch to the end of the flight: trusted, doubtful, untrustworthy, as lengths and in words.
fn trust(score: &SensorScore, longest_s: f64) -> Markup {
    let end_s = score.free_flight_s.unwrap_or(longest_s);
    let doubtful_s = score.doubtful_after_s.unwrap_or(end_s);
    let untrustworthy_s = score.untrustworthy_after_s.unwrap_or(end_s);
    let words = match (score.doubtful_after_s, score.untrustworthy_after_s) {
        (None, _) => "never doubtful".to_owned(),
        (Some(doubtful), None) => format!("doubtful after {}, never untrustworthy", seconds(Some(doubtful))),
        (Some(doubtful), Some(untrustworthy)) => format!(
            "doubtful after {}, untrustworthy after {}",
            seconds(Some(doubtful)),
            seconds(Some(untrustworthy))
        ),
    };
    let parts = [
        ("trusted", doubtful_s),
        ("doubtful", untrustworthy_s - doubtful_s),
        ("untrustworthy", end_s - untrustworthy_s),
    ];
    html! {
        div.strip aria-hidden="true" {
            @for (kind, length_s) in parts.into_iter().filter(|(_, length_s)| *length_s > 0.0) {
                span class=(kind) title=(kind) style=(format!("width: {:.1}%", share(length_s, longest_s))) {}
            }
        }
        span.value { (words) }
    }
}

/// What was measured when each revision was made, on flights that need not be on this page.
fn when_learned(model: &Model) -> Markup {
    let greatest = model.revisions.iter().flat_map(errors).flatten().fold(0.0, f64::max);
    html! {
        h3 { "When each was learned" }
        p {
            "What was measured then and written into the model: the rms error before and after, on the flight that it was \
             learned from and on one that was held out. Shorter is better; the held-out one counts."
        }
        div.scroll tabindex="0" {
            table.ladder {
                thead { tr {
                    th.number scope="col" { "revision" } th scope="col" { "added" } th scope="col" { "learned from" }
                    th scope="col" { "rms error, learning flight" } th scope="col" { "rms error, held out" }
                } }
                tbody { @for revision in &model.revisions { (row(revision, greatest)) } }
            }
        }
    }
}

fn row(revision: &Revision, greatest: f64) -> Markup {
    let [before, after, held_before, held_after] = errors(revision);
    html! {
        tr {
            td.number { (revision.number) }
            th scope="row" {
                (revision.effect.map_or("another change", |effect| effect.name()))
                @if let Some(date) = &revision.date { span.note { (date) } }
            }
            td { (revision.learned_from.as_deref().map_or_else(|| "-".to_owned(), file_names)) }
            td { (bars(("before", before), ("after", after), greatest)) }
            td { (bars(("before", held_before), ("after", held_after), greatest)) }
        }
    }
}

/// Before and after on the learning flight, before and after on the held-out one, metres.
fn errors(revision: &Revision) -> [Option<f64>; 4] {
    let Revision { rms_before_m, rms_after_m, held_out_before_m, held_out_after_m, .. } = *revision;
    [rms_before_m, rms_after_m, held_out_before_m, held_out_after_m]
}

/// Several files, as a model names them.
fn file_names(paths: &str) -> String {
    paths.split(", ").map(file_name).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_strip_is_as_long_as_the_flight() {
        let score = SensorScore {
            free_flight_rms_m: Some(3.0),
            free_flight_s: Some(100.0),
            doubtful_after_s: Some(20.0),
            untrustworthy_after_s: Some(50.0),
            ..SensorScore::default()
        };
        let widths = |score: &SensorScore| {
            let page = trust(score, 200.0).into_string();
            let widths = page.split("width: ").skip(1).map(|rest| rest.split('%').next().unwrap().to_owned());
            (widths.collect::<Vec<_>>(), page)
        };
        let (parts, page) = widths(&score);
        assert_eq!(parts, ["10.0", "15.0", "25.0"]);
        assert!(page.contains("doubtful after 20.00 s, untrustworthy after 50.00 s"), "{page}");
        let (parts, page) =
            widths(&SensorScore { doubtful_after_s: None, untrustworthy_after_s: None, ..score });
        assert_eq!((parts, page.contains("never doubtful")), (vec!["50.0".to_owned()], true));
        let (parts, page) = widths(&SensorScore { untrustworthy_after_s: None, ..score });
        assert_eq!(parts, ["10.0", "40.0"]);
        assert!(page.contains("never untrustworthy"), "{page}");
    }
}
