//! Several flights, one by one, in plain English.

use std::fmt::Write as _;

use view::Table;
use view::text::printable;

use super::{Batch, FlightResult, VehicleResult};
use crate::diagnose::text::{probability, say, with_sigma};

/// The tables as text.
#[must_use]
pub fn text(batch: &Batch) -> String {
    let mut out = String::new();
    let _ = writeln!(
        out,
        "\nFlight by flight (each diagnosed by itself; * this flight alone shows the effect to be missing):"
    );
    let effects: Vec<&str> = batch.effects().collect();
    let mut table = Table::new().left("  flight").left("verdict");
    for (effect, unit) in batch.units() {
        table = table.right(match unit {
            "1" => effect.to_string(),
            unit => format!("{effect}, {unit}"),
        });
    }
    for flight in &batch.by_flight {
        table.row(row(flight, &effects));
    }
    let _ = writeln!(out, "{}", view::text::table(&table, false));
    for flight in &batch.by_flight {
        if let Some(why) = &flight.failed {
            let _ = writeln!(out, "  {}: a bug in pylon, please report it: {why}", flight.file);
        }
    }
    for vehicle in batch.by_vehicle.iter().filter(|vehicle| !vehicle.effects.is_empty()) {
        write_vehicle(&mut out, vehicle);
    }
    out
}

fn row(flight: &FlightResult, effects: &[&str]) -> Vec<String> {
    let verdict = flight.verdict.map_or("failed", say);
    let cells = effects.iter().map(|effect| match flight.coefficients.get(*effect) {
        Some(one) => {
            format!("{}{}", with_sigma(one.value, one.sigma), if one.identified { " *" } else { "  " })
        }
        None => "-  ".to_owned(),
    });
    [format!("  {}", flight.file), verdict.to_owned()].into_iter().chain(cells).collect()
}

fn write_vehicle(out: &mut String, vehicle: &VehicleResult) {
    let name =
        if vehicle.vehicle.is_empty() { "of unnamed vehicles".into() } else { printable(&vehicle.vehicle) };
    let flights =
        if vehicle.flights == 1 { "1 flight".to_owned() } else { format!("{} flights", vehicle.flights) };
    let _ = writeln!(out, "\n{name}: {flights}");
    let mut table =
        Table::new().left("  effect").right("flights").right("mean").left("").right("from flight to flight");
    for effect in &vehicle.effects {
        let spread = if effect.spread > 0.0 {
            with_sigma(effect.mean, effect.spread)
                .rsplit_once(' ')
                .map_or_else(String::new, |(_, one)| format!("± {one}"))
        } else {
            "no more than their sigmas".to_owned()
        };
        let spread = if effect.flights > 1 { spread } else { "-".to_owned() };
        table.row([
            format!("  {}", effect.effect),
            effect.flights.to_string(),
            with_sigma(effect.mean, effect.sigma),
            if effect.unit == "1" { String::new() } else { effect.unit.to_string() },
            spread,
        ]);
    }
    let _ = writeln!(out, "{}", view::text::table(&table, false));
    for effect in &vehicle.effects {
        for odd in &effect.outliers {
            let _ = writeln!(
                out,
                "  outlier: {}: {} is {}, while the others are {} (chance {})",
                odd.file,
                effect.effect,
                with_sigma(odd.coefficient, odd.sigma),
                with_sigma(effect.mean, effect.sigma),
                probability(odd.p_value)
            );
        }
    }
}
