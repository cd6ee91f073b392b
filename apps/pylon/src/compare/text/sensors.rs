//! The table of the sensors, phase by phase.

use std::fmt::Write as _;

use super::number::{NONE, grouped, metres, plain, seconds, signed_m, with_sigma_m};
use super::table::{by_sensor, row};
use super::{in_order, never, put};
use view::{Cell, Table, Tone};

use crate::compare::{Comparison, PhaseSummary, SensorComparison};
use crate::statistics::Whiteness;

/// A sequence is reported as white if a white sequence would look less white at least this often.
const WHITE_P_VALUE: f64 = 0.01;

pub(super) fn write(out: &mut String, comparison: &Comparison, colour: bool) {
    let sensors = in_order(&comparison.sensors);
    if sensors.is_empty() {
        return;
    }
    let names: Vec<&str> = sensors.iter().map(|(name, _)| *name).collect();
    let columns: Vec<&SensorComparison> = sensors.iter().map(|(_, sensor)| *sensor).collect();
    let mut table = by_sensor(comparison.words().before, &names);
    captive(&mut table, &columns);
    if comparison.launch_s.is_some() {
        table.section(comparison.words().after);
        free_flight(&mut table, &columns);
    }
    put!(out, "\n{}", view::text::table(&table, colour));
    let reference = &comparison.reference.captive;
    if reference.readings > 0 {
        put!(
            out,
            "gps, the reference: innovations {} rms, mean NIS {}, white: {}",
            metres(reference.rms_m),
            nis(reference),
            white(reference.innovation_whiteness.as_ref())
        );
    }
}

fn captive(table: &mut Table, columns: &[&SensorComparison]) {
    let mut row_of = |label: &str, cell: &dyn Fn(&SensorComparison) -> String| {
        row(table, label, columns.iter().map(|sensor| cell(sensor)));
    };
    row_of("bias (filter estimate)", &|sensor| with_sigma_m(sensor.bias_m, sensor.bias_sigma_m));
    row_of("standard error of the mean residual", &|sensor| metres(sensor.captive.bias_standard_error_m));
    row_of("spread of the residual (1 sigma)", &|sensor| metres(sensor.residual_sigma_m));
    row_of("robust spread (1 sigma)", &|sensor| metres(sensor.captive.robust_spread_m));
    row_of("rms error", &|sensor| metres(sensor.captive_rms_m));
    row_of("error correlation time", &|sensor| seconds(sensor.captive.correlation_time_s));
    row_of("readings (effective)", &|sensor| readings(&sensor.captive));
    row_of("innovations white", &|sensor| white(sensor.captive.innovation_whiteness.as_ref()));
    row_of("mean NIS (95 % limits if consistent)", &|sensor| nis(&sensor.captive));
}

fn free_flight(table: &mut Table, columns: &[&SensorComparison]) {
    let mut row_of = |label: &str, cell: &dyn Fn(&SensorComparison) -> Cell| {
        let cells =
            columns.iter().map(|sensor| if sensor.flies_free { cell(sensor) } else { Cell::from(NONE) });
        row(table, label, cells);
    };
    let neutral = |text: String| Cell::from(text);
    row_of("mean error", &|sensor| neutral(signed_m(sensor.free_flight.bias_m)));
    row_of("spread of the error", &|sensor| neutral(metres(sensor.free_flight.spread_m)));
    row_of("rms error", &|sensor| neutral(metres(sensor.free_flight_rms_m)));
    row_of("error correlation time", &|sensor| neutral(seconds(sensor.free_flight.correlation_time_s)));
    row_of("errors white", &|sensor| neutral(white(sensor.free_flight.error_whiteness.as_ref())));
    row_of("alarm limit of the monitor", &|sensor| neutral(metres(sensor.bound_m)));
    row_of("moving average at the end", &|sensor| neutral(signed_m(sensor.moving_average_end_m)));
    row_of("doubtful after", &|sensor| flag(sensor, sensor.doubtful_after_s, Tone::Doubt));
    row_of("untrustworthy after", &|sensor| flag(sensor, sensor.untrustworthy_after_s, Tone::Bad));
    row_of("trust at the end", &|sensor| Cell::toned(sensor.trust.to_string(), tone(&sensor.trust)));
}

fn flag(sensor: &SensorComparison, after_s: Option<f64>, raised: Tone) -> Cell {
    match after_s {
        Some(_) => Cell::toned(never(after_s), raised),
        None if sensor.free_flight.readings > 0 => Cell::toned(never(None), Tone::Good),
        None => Cell::from(NONE),
    }
}

fn tone(trust: &str) -> Tone {
    match trust {
        "trusted" => Tone::Good,
        "untrustworthy" => Tone::Bad,
        "doubtful" | "unmonitored" => Tone::Doubt,
        _ => Tone::Neutral,
    }
}

fn readings(phase: &PhaseSummary) -> String {
    match phase.effective_readings {
        Some(effective) => format!("{} ({})", grouped(phase.readings), grouped(effective.round() as u64)),
        None => grouped(phase.readings),
    }
}

fn white(whiteness: Option<&Whiteness>) -> String {
    let Some(whiteness) = whiteness else { return NONE.to_owned() };
    if whiteness.p_value < WHITE_P_VALUE {
        format!("no, lag 1: {:+.2}", whiteness.lag_one)
    } else {
        format!("yes, p {:.2}", whiteness.p_value)
    }
}

fn nis(phase: &PhaseSummary) -> String {
    phase.nis.as_ref().map_or_else(
        || NONE.to_owned(),
        |nis| format!("{} ({} to {})", plain(Some(nis.mean)), plain(Some(nis.lower)), plain(Some(nis.upper))),
    )
}
