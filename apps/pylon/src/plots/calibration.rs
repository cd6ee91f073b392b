//! Figure 2: the estimated parameters over captive flight, with their standard deviations.

use kf_core::sensor::Sensor;
use view::svg::{DrawingError, Legends, range};
use view::{Chart, Role, common_places};

use super::envelope::{outline, span};
use super::figure::figure;
use crate::compare::{Comparison, EstimateTrace, Traces};

/// The first share of the flight, in which the band may leave the diagram because it is still the prior's.
const PRIOR_SHARE: f64 = 0.04;

pub(super) fn draw(comparison: &Comparison, traces: &Traces) -> Option<Result<String, DrawingError>> {
    let seconds = |time_us: u64| time_us as f64 * 1e-6;
    let x_range = span(std::iter::once(&traces.altitude.value_m), seconds)?;
    let mut charts = Vec::new();
    let mut add = |trace: &EstimateTrace, y_name: String| {
        if !trace.value_m.slots().is_empty() {
            charts.push(chart(trace, y_name, &x_range));
        }
    };
    add(&traces.altitude, "altitude by gps, m".to_owned());
    for sensor in Sensor::ALL {
        add(&traces.biases[sensor.index()], format!("bias of {}, m", sensor.name()));
    }
    let title = "Estimated parameters in captive flight (as the paper's Figure 2)";
    Some(figure(title, comparison, &charts, Legends::First))
}

fn chart(trace: &EstimateTrace, y_name: String, x_range: &std::ops::Range<f64>) -> Chart {
    let seconds = |time_us: u64| time_us as f64 * 1e-6;
    let limits = |sign: f64| -> Vec<(f64, f64)> {
        let slots = trace.value_m.slots().iter().zip(trace.sigma_m.slots());
        slots
            .map(|(value, sigma)| {
                (seconds(value.time_us), f64::from(value.last) + sign * f64::from(sigma.last))
            })
            .collect()
    };
    let (lower, upper) = (limits(-1.0), limits(1.0));
    let settled_s = x_range.start + PRIOR_SHARE * (x_range.end - x_range.start);
    let band = lower.iter().chain(&upper).filter(|(time_s, _)| *time_s > settled_s).map(|(_, value)| *value);
    let values = trace.value_m.slots().iter().filter(|slot| seconds(slot.time_us) > settled_s);
    let y_range =
        range(values.flat_map(|slot| [f64::from(slot.least), f64::from(slot.greatest)]).chain(band));
    let estimate = outline(&trace.value_m, seconds);
    let (places, [lower, upper, estimate]) = common_places([&lower, &upper, &estimate]);
    let mut chart = Chart::new(String::new(), String::new(), "time, s", y_name, places)
        .band("± 1 sigma of the filter", Role::Modelled, lower, upper)
        .line("estimate", Role::Modelled, estimate);
    chart.x_range = Some([x_range.start, x_range.end]);
    chart.y_range = Some([y_range.start, y_range.end]);
    chart
}
