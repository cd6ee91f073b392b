//! Figure 4: the errors of the sensors in free flight.

use std::ops::Range;

use kf_core::sensor::Sensor;
use view::svg::{DrawingError, Legends, range};
use view::{Chart, Moment, Role, common_places};

use super::envelope::{edges, outline, span};
use super::figure::figure;
use crate::compare::{Comparison, SensorComparison, Traces};

pub(super) fn draw(comparison: &Comparison, traces: &Traces) -> Option<Result<String, DrawingError>> {
    let launch_s = comparison.launch_s?;
    let seconds = |time_us: u64| time_us as f64 * 1e-6 - launch_s;
    let free = || Sensor::ALL.into_iter().filter(|sensor| sensor.flies_free());
    let x_range = span(free().map(|sensor| &traces.free_error_m[sensor.index()]), seconds)?;
    let drawn = free().filter_map(|sensor| {
        let has_errors = !traces.free_error_m[sensor.index()].slots().is_empty();
        let found = comparison.sensors.get(sensor.name()).filter(|_| has_errors)?;
        Some(chart(sensor, found, traces, &x_range, seconds))
    });
    let charts: Vec<Chart> = drawn.collect();
    let title = "Errors of the sensors in free flight (as the paper's Figure 4)";
    Some(figure(title, comparison, &charts, Legends::Each))
}

fn chart(
    sensor: Sensor,
    found: &SensorComparison,
    traces: &Traces,
    x_range: &Range<f64>,
    seconds: impl Fn(u64) -> f64 + Copy,
) -> Chart {
    let errors = &traces.free_error_m[sensor.index()];
    let extremes = errors.slots().iter().flat_map(|slot| [slot.least, slot.greatest]).map(f64::from);
    let limits = found.bound_m.map_or([0.0; 2], |bound| [-bound, bound]);
    let y_range = range(extremes.chain(limits));
    let [least, greatest] = edges(errors, seconds);
    let level = |y: f64| [(x_range.start, y), (x_range.end, y)];
    let (places, [least, greatest, error, average, lower, upper]) = common_places([
        &least,
        &greatest,
        &outline(errors, seconds),
        &outline(&traces.moving_average_m[sensor.index()], seconds),
        &level(limits[0]),
        &level(limits[1]),
    ]);
    let y_name = format!("error of {}, m", sensor.name());
    let mut chart = Chart::new(String::new(), String::new(), "time after launch, s", y_name, places);
    if found.bound_m.is_some() {
        chart = chart.band("", Role::Bound, lower, upper);
    }
    chart = chart
        .bound("alarm limit of the monitor", Role::Bound, found.bound_m)
        .band("", Role::Residual, least, greatest)
        .line("error", Role::Residual, error)
        .line("moving average", Role::Average, average);
    let flags = [
        ("doubtful", Role::Doubtful, found.doubtful_after_s),
        ("untrustworthy", Role::Untrustworthy, found.untrustworthy_after_s),
    ];
    chart.moments = flags
        .into_iter()
        .filter_map(|(word, role, at)| Some(Moment { name: format!("{word}, {:.2} s", at?), role, x: at? }))
        .collect();
    chart.x_range = Some([x_range.start, x_range.end]);
    chart.y_range = Some([y_range.start, y_range.end]);
    chart
}
