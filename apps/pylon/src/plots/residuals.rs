//! Figure 3: the residuals over captive flight.

use kf_core::sensor::Sensor;
use view::svg::{DrawingError, Legends, range};
use view::{Chart, Role, common_places};

use super::envelope::{edges, outline, span};
use super::figure::figure;
use crate::compare::{Comparison, Envelope, Traces};

pub(super) fn draw(comparison: &Comparison, traces: &Traces) -> Option<Result<String, DrawingError>> {
    let seconds = |time_us: u64| time_us as f64 * 1e-6;
    let all = || std::iter::once(&traces.reference_residual_m).chain(&traces.captive_error_m);
    let x_range = span(all(), seconds)?;
    let mut charts = Vec::new();
    let mut add = |envelope: &Envelope, y_name: String, sigma_m: Option<f64>| {
        if envelope.slots().is_empty() {
            return;
        }
        let bounds = sigma_m.map_or([0.0; 2], |sigma| [-sigma, sigma]);
        let extremes = envelope.slots().iter().flat_map(|slot| [slot.least, slot.greatest]).map(f64::from);
        let [least, greatest] = edges(envelope, seconds);
        let (places, [least, greatest, line]) =
            common_places([&least, &greatest, &outline(envelope, seconds)]);
        let mut chart = Chart::new(String::new(), String::new(), "time, s", y_name, places)
            .band("", Role::Residual, least, greatest)
            .line("residual", Role::Residual, line)
            .bound("± 1 sigma of the residual", Role::Sigma, sigma_m);
        let y_range = range(extremes.chain(bounds));
        chart.x_range = Some([x_range.start, x_range.end]);
        chart.y_range = Some([y_range.start, y_range.end]);
        charts.push(chart);
    };
    add(&traces.reference_residual_m, "residual of gps, m".to_owned(), comparison.reference.captive.spread_m);
    for sensor in Sensor::ALL {
        let sigma_m = comparison.sensors.get(sensor.name()).and_then(|found| found.residual_sigma_m);
        add(&traces.captive_error_m[sensor.index()], format!("residual of {}, m", sensor.name()), sigma_m);
    }
    let title = "Filtered residuals in captive flight (as the paper's Figure 3)";
    Some(figure(title, comparison, &charts, Legends::First))
}
