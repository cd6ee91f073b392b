//! Figure 3: the residuals over captive flight.

use kf_core::sensor::Sensor;
use view::svg::{DrawingError, LIGHT_BLUE, Layer, ORANGE, Panel, range};

use super::envelope::{series, span};
use super::figure::figure;
use crate::compare::{Comparison, Envelope, Traces};

pub(super) fn draw(comparison: &Comparison, traces: &Traces) -> Option<Result<String, DrawingError>> {
    let seconds = |time_us: u64| time_us as f64 * 1e-6;
    let all = || std::iter::once(&traces.reference_residual_m).chain(&traces.captive_error_m);
    let x_range = span(all(), seconds)?;
    let mut panels = Vec::new();
    let mut add = |envelope: &Envelope, y_name: String, sigma_m: Option<f64>| {
        if envelope.slots().is_empty() {
            return;
        }
        let bounds = sigma_m.map_or([0.0; 2], |sigma| [-sigma, sigma]);
        let extremes = envelope.slots().iter().flat_map(|slot| [slot.least, slot.greatest]).map(f64::from);
        let mut layers = Vec::from(series(envelope, seconds, LIGHT_BLUE, "residual"));
        if let Some(sigma) = sigma_m {
            layers.push(Layer::Level { value: sigma, colour: ORANGE, name: "± 1 sigma of the residual" });
            layers.push(Layer::Level { value: -sigma, colour: ORANGE, name: "" });
        }
        panels.push(Panel {
            x_range: x_range.clone(),
            y_range: range(extremes.chain(bounds)),
            x_name: "",
            y_name,
            layers,
            has_legend: false,
        });
    };
    add(&traces.reference_residual_m, "residual of gps, m".to_owned(), comparison.reference.captive.spread_m);
    for sensor in Sensor::ALL {
        let sigma_m = comparison.sensors.get(sensor.name()).and_then(|found| found.residual_sigma_m);
        add(&traces.captive_error_m[sensor.index()], format!("residual of {}, m", sensor.name()), sigma_m);
    }
    if let Some(first) = panels.first_mut() {
        first.has_legend = true;
    }
    if let Some(last) = panels.last_mut() {
        last.x_name = "time, s";
    }
    let title = "Filtered residuals in captive flight (as the paper's Figure 3)";
    Some(figure(title, comparison, &panels))
}
