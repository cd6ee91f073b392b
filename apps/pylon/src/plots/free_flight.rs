//! Figure 4: the errors of the sensors in free flight.

use kf_core::sensor::Sensor;
use view::svg::{
    BLACK, DrawingError, GREEN, GREY, LIGHT_BLUE, Layer, MAGENTA, PALE_GREY, Panel, range,
};

use super::envelope::{outline, series, span};
use super::figure::figure;
use crate::compare::{Comparison, SensorComparison, Traces};

pub(super) fn draw(comparison: &Comparison, traces: &Traces) -> Option<Result<String, DrawingError>> {
    let launch_s = comparison.launch_s?;
    let seconds = |time_us: u64| time_us as f64 * 1e-6 - launch_s;
    let free = || Sensor::ALL.into_iter().filter(|sensor| sensor.flies_free());
    let x_range = span(free().map(|sensor| &traces.free_error_m[sensor.index()]), seconds)?;
    let mut panels = Vec::new();
    for sensor in free() {
        let errors = &traces.free_error_m[sensor.index()];
        let Some(found) = comparison.sensors.get(sensor.name()).filter(|_| !errors.slots().is_empty()) else {
            continue;
        };
        let extremes = errors.slots().iter().flat_map(|slot| [slot.least, slot.greatest]).map(f64::from);
        let bounds = found.bound_m.map_or([0.0; 2], |bound| [-bound, bound]);
        let y_range = range(extremes.chain(bounds));
        let average = outline(&traces.moving_average_m[sensor.index()], seconds);
        panels.push(Panel {
            x_range: x_range.clone(),
            y_range,
            x_name: "",
            y_name: format!("error of {}, m", sensor.name()),
            has_legend: true,
            layers: layers(found, series(errors, seconds, LIGHT_BLUE, "error"), average, &x_range),
        });
    }
    if let Some(last) = panels.last_mut() {
        last.x_name = "time after launch, s";
    }
    let title = "Errors of the sensors in free flight (as the paper's Figure 4)";
    Some(figure(title, comparison, &panels))
}

fn layers(
    sensor: &SensorComparison,
    errors: [Layer<'static>; 2],
    average: Vec<(f64, f64)>,
    x_range: &std::ops::Range<f64>,
) -> Vec<Layer<'static>> {
    let mut layers = Vec::new();
    if let Some(bound) = sensor.bound_m {
        let level = |value: f64| vec![(x_range.start, value), (x_range.end, value)];
        layers.push(Layer::Band { from: level(-bound), to: level(bound), colour: PALE_GREY, name: "" });
        layers.push(Layer::Level { value: bound, colour: GREY, name: "alarm limit of the monitor" });
        layers.push(Layer::Level { value: -bound, colour: GREY, name: "" });
    }
    layers.extend(errors);
    layers.push(Layer::Curve { points: average, colour: GREEN, width: 3, name: "moving average" });
    if let Some(at) = sensor.doubtful_after_s {
        layers.push(Layer::Moment { at, colour: MAGENTA, name: format!("doubtful, {at:.2} s") });
    }
    if let Some(at) = sensor.untrustworthy_after_s {
        layers.push(Layer::Moment { at, colour: BLACK, name: format!("untrustworthy, {at:.2} s") });
    }
    layers
}
