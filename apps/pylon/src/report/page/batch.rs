//! Several flights, one by one: what the model lacks on each, each vehicle's coefficients, and the flights
//! that do not belong with the others.

use maud::{Markup, html};
use view::Table;

use super::{file_name, scrolled};
use crate::batch::{Batch, EffectResult, FlightResult, VehicleResult};
use crate::compare::text::number::seconds;
use crate::diagnose::text::{probability, say, with_sigma};
use crate::report::{FlightReport, figures::free_sensors, summary as words};

pub(super) fn section(batch: &Batch, flights: &[FlightReport]) -> Markup {
    let odd = || batch.by_vehicle.iter().flat_map(|vehicle| vehicle.effects.iter());
    html! {
        section #batch {
            h2 { "Flight by flight" }
            @if odd().any(|effect| !effect.outliers.is_empty()) {
                p.lead { "These do not belong with the other flights of their vehicle:" }
                ul { @for effect in odd() { @for outlier in outliers(effect) { li { (outlier) } } } }
            } @else if odd().next().is_some() {
                p { "No flight's coefficients are far from those of the others of its vehicle." }
            }
            @for vehicle in batch.by_vehicle.iter().filter(|vehicle| !vehicle.effects.is_empty()) {
                h3 {
                    @if vehicle.vehicle.is_empty() { "Vehicles without a name" } @else { (vehicle.vehicle) }
                    ", " (vehicle.flights) @if vehicle.flights == 1 { " flight" } @else { " flights" }
                }
                (scrolled(&coefficients(vehicle)))
            }
            p.hint {
                "Each flight diagnosed by itself; bold: that flight alone shows that the effect is missing. The trust is that at the \
                 flight's end. Diagrams are drawn of the flights whose names are links."
            }
            div.scroll tabindex="0" { table {
                thead { tr {
                    th scope="col" { "flight" } th.number scope="col" { "length" } th scope="col" { "verdict" }
                    @for effect in batch.effects() { th.number scope="col" { (effect) } }
                    th scope="col" { "sensors" }
                } }
                tbody { @for flight in &batch.by_flight { (row(batch, flight, flights)) } }
            } }
        }
    }
}

fn coefficients(vehicle: &VehicleResult) -> Table {
    let spread = "from flight to flight, 1 sigma";
    let mut table = Table::new().left("effect").right("flights").right("mean").left("unit").right(spread);
    for effect in &vehicle.effects {
        table.row([
            effect.effect.to_string(),
            effect.flights.to_string(),
            with_sigma(effect.mean, effect.sigma),
            if effect.unit == "1" { String::new() } else { effect.unit.to_string() },
            if effect.flights > 1 { format!("{:.2e}", effect.spread) } else { "-".to_owned() },
        ]);
    }
    table
}

fn outliers(effect: &EffectResult) -> impl Iterator<Item = String> + '_ {
    effect.outliers.iter().map(|odd| {
        format!(
            "{}: {} is {}, while the others are {} (chance {})",
            file_name(&odd.file),
            effect.effect,
            with_sigma(odd.coefficient, odd.sigma),
            with_sigma(effect.mean, effect.sigma),
            probability(odd.p_value)
        )
    })
}

fn row(batch: &Batch, flight: &FlightResult, flights: &[FlightReport]) -> Markup {
    let report = flights.iter().find(|report| report.comparison.flight.file == flight.file);
    let name = file_name(&flight.file);
    html! { tr {
        th scope="row" {
            @match report.filter(|report| report.is_drawn) {
                Some(report) => a href=(format!("#{}", report.id)) { (name) },
                None => (name),
            }
        }
        td.number { @if let Some(report) = report { (seconds(Some(report.comparison.flight.duration_s))) } }
        td { @match (&flight.failed, flight.verdict) {
            (Some(why), _) => { "not diagnosed because of a bug in pylon: " (why) }
            (None, Some(verdict)) => (say(verdict)),
            (None, None) => "",
        } }
        @for effect in batch.effects() {
            td.number { @match flight.coefficients.get(effect) {
                Some(one) if one.identified => b { (with_sigma(one.value, one.sigma)) },
                Some(one) => (with_sigma(one.value, one.sigma)),
                None => "-",
            } }
        }
        td { @if let Some(report) = report {
            @for (sensor, found) in free_sensors(&report.comparison) {
                @let outcome = words::outcome(&found.trust);
                span title=(outcome.meaning) { (outcome.sign) " " (sensor.name()) " " (outcome.word) " " }
            }
        } }
    } }
}
