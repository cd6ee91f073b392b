//! The calibration and the flags: the paper's Table 1 and section 4, for this flight.

use kf_core::sensor::Sensor;
use maud::{Markup, html};
use view::{Cell, Table};

use super::scrolled;
use crate::compare::SensorComparison;
use crate::compare::text::meaning;
use crate::compare::text::number::{grouped, metres, plain, seconds, signed_m, with_sigma_m};
use crate::compare::words::Words;
use crate::report::FlightReport;

pub(super) fn section(report: &FlightReport) -> Markup {
    let comparison = &report.comparison;
    let calibration = &comparison.calibration;
    let sensors: Vec<(&str, &SensorComparison)> = Sensor::ALL
        .iter()
        .filter_map(|sensor| Some((sensor.name(), comparison.sensors.get(sensor.name())?)))
        .collect();
    html! {
        section {
            h3 { "Calibration and its outcome" }
            p {
                @match &calibration.quality {
                    Some(quality) => { "Calibration: " b { (quality) } ", " (seconds(calibration.duration_s)) " long. " }
                    None => "Nothing was latched. ",
                }
                "Its end was decided by: " (calibration.source) "."
            }
            @if !calibration.failed_checks.is_empty() {
                ul.failed {
                    @for check in &calibration.failed_checks { li { b { (check) } ": " (meaning(check)) } }
                }
            }
            @if !sensors.is_empty() { (scrolled(&table(&sensors, comparison.launch_s.is_some(), comparison.words()))) }
            (effects(report))
        }
    }
}

fn table(
    sensors: &[(&str, &SensorComparison)],
    is_launched: bool,
    Words { before, event, .. }: Words,
) -> Table {
    let [rms_before, mean_after, rms_after] = [
        format!("rms error in {before}"),
        format!("mean error after {event}"),
        format!("rms error after {event}"),
    ];
    let [readings, seconds_after] =
        [format!("used, before and after {event}"), format!("seconds after {event}")];
    type Value = fn(&SensorComparison) -> String;
    let captive: [(&str, &str, Value); 5] = [
        ("bias", "what is subtracted from its readings, and the filter's uncertainty", |s| {
            with_sigma_m(s.bias_m, s.bias_sigma_m)
        }),
        ("spread of the residual", "one standard deviation of what is left", |s| metres(s.residual_sigma_m)),
        (&rms_before, "by that bias", |s| metres(s.captive_rms_m)),
        ("error correlation time", "readings closer together are not independent", |s| {
            seconds(s.captive.correlation_time_s)
        }),
        ("readings", &readings, |s| grouped(s.captive.readings + s.free_flight.readings)),
    ];
    let free: [(&str, &str, Value); 7] =
        [
            ("alarm limit of the monitor", "an error beyond it makes the sensor doubtful", |s| {
                metres(s.bound_m)
            }),
            (&mean_after, "", |s| signed_m(s.free_flight.bias_m)),
            (&rms_after, "", |s| metres(s.free_flight_rms_m)),
            ("moving average at the end", "", |s| signed_m(s.moving_average_end_m)),
            ("doubtful", &seconds_after, |s| flag(s, s.doubtful_after_s)),
            ("untrustworthy", &seconds_after, |s| flag(s, s.untrustworthy_after_s)),
            ("trust at the end", "", |s| {
                if s.flies_free { s.trust.to_string() } else { "stays behind".to_owned() }
            }),
        ];
    let mut table = sensors.iter().fold(Table::new().left("quantity"), |table, (name, _)| table.right(*name));
    for (name, explanation, value) in captive.iter().chain(free.iter().filter(|_| is_launched)) {
        let heading = Cell::explained(*name, *explanation);
        let cells = sensors.iter().map(|(_, sensor)| Cell::from(value(sensor)));
        table.row(std::iter::once(heading).chain(cells));
    }
    table
}

fn flag(sensor: &SensorComparison, after_s: Option<f64>) -> String {
    match after_s {
        Some(after_s) => seconds(Some(after_s)),
        None if sensor.flies_free => "never".to_owned(),
        None => "-".to_owned(),
    }
}

fn effects(report: &FlightReport) -> Markup {
    let effects = &report.comparison.effects;
    let mut table =
        Table::new().left("effect").right("coefficient").right("± 1 sigma").left("unit").left("from");
    for effect in effects {
        table.row([
            effect.effect.to_string(),
            plain(Some(effect.coefficient)),
            plain(Some(effect.sigma)),
            effect.unit.to_string(),
            if effect.estimated { "estimated in captive flight" } else { "the model" }.to_owned(),
        ]);
    }
    html! {
        @if !effects.is_empty() {
            h4 { "Effects that the model accounts for" }
            (scrolled(&table))
        }
    }
}
