//! The model's history: how the error fell, revision by revision.

use maud::{Markup, html};
use model::{Model, Revision};

use super::bars::bars;

pub(super) fn section(model: &Model, name: &str) -> Markup {
    let greatest = model.revisions.iter().flat_map(errors).flatten().fold(0.0, f64::max);
    html! {
        section #ladder {
            h2 { "How the model got here" }
            @if model.revisions.is_empty() {
                p {
                    "The model " b { (name) } " has no revisions. Each effect that " code { "pylon add" }
                    " learns is written into the model file as one, with the error before and after."
                }
            } @else {
                p {
                    "One row a change: the rms error before and after it, on the flight that it was learned from and on one \
                     that was held out. Shorter is better; the held-out one counts."
                }
                div.scroll {
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
            td { (revision.learned_from.as_deref().unwrap_or("-")) }
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
