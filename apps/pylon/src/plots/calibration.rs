//! Figure 2: the estimated parameters over captive flight, with their standard deviations.

use kf_core::sensor::Sensor;
use view::svg::{BLUE, DrawingError, Layer, PALE_BLUE, Panel, range};

use super::envelope::{outline, span};
use super::figure::figure;
use crate::compare::{Comparison, EstimateTrace, Traces};

/// The first part of the flight in which the band may leave the diagram: there it is the prior's.
const PRIOR_SHARE: f64 = 0.04;

pub(super) fn draw(comparison: &Comparison, traces: &Traces) -> Option<Result<String, DrawingError>> {
    let seconds = |time_us: u64| time_us as f64 * 1e-6;
    let x_range = span(std::iter::once(&traces.altitude.value_m), seconds)?;
    let mut panels = Vec::new();
    let mut add = |trace: &EstimateTrace, y_name: String| {
        if !trace.value_m.slots().is_empty() {
            panels.push(panel(trace, y_name, &x_range));
        }
    };
    add(&traces.altitude, "altitude by gps, m".to_owned());
    for sensor in Sensor::ALL {
        add(&traces.biases[sensor.index()], format!("bias of {}, m", sensor.name()));
    }
    if let Some(first) = panels.first_mut() {
        first.has_legend = true;
    }
    if let Some(last) = panels.last_mut() {
        last.x_name = "time, s";
    }
    let title = "Estimated parameters in captive flight (as the paper's Figure 2)";
    Some(figure(title, comparison, &panels))
}

fn panel(trace: &EstimateTrace, y_name: String, x_range: &std::ops::Range<f64>) -> Panel<'static> {
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
    Panel {
        x_range: x_range.clone(),
        y_range,
        x_name: "",
        y_name,
        has_legend: false,
        layers: vec![
            Layer::Band { from: lower, to: upper, colour: PALE_BLUE, name: "± 1 sigma of the filter" },
            Layer::Curve {
                points: outline(&trace.value_m, seconds),
                colour: BLUE,
                width: 3,
                name: "estimate",
            },
        ],
    }
}
