//! The paper's three figures, and measured against modelled, as diagrams of the page.

use kf_core::sensor::Sensor;
use view::{Chart, Moment, Role, Shade};

use super::recording::{AVERAGE, ERROR, MEASURED, MODELLED, Recording, SIGMA, VALUE};
use super::table::{Table, rounded};
use crate::compare::{Comparison, SensorComparison};

/// The first share of captive flight, in which an estimate's sigma is still the prior's: its axis starts
/// later.
const PRIOR_SHARE: f64 = 0.04;

const TIME: &str = "time, s";

/// The diagrams of one figure.
pub(super) type Drawn = Vec<Chart>;

/// The estimated parameters over captive flight (the paper's Figure 2).
pub(super) fn calibration(flight: &str, recording: &Recording) -> Drawn {
    let reference = ("altitude".to_owned(), "altitude by gps, m".to_owned(), &recording.altitude);
    let biases = Sensor::ALL.into_iter().map(|sensor| {
        (sensor.name().to_owned(), format!("bias of {}, m", sensor.name()), &recording.biases[sensor.index()])
    });
    let estimates = std::iter::once(reference).chain(biases).filter(|(_, _, table)| !table.is_empty());
    estimates
        .map(|(name, y_name, table)| {
            let (values, sigmas) = (table.mean(VALUE), table.mean(SIGMA));
            let edge = |sign: f64| {
                let pairs = values.iter().zip(&sigmas);
                pairs.map(|(value, sigma)| Some(rounded((*value)? + sign * (*sigma)?))).collect::<Vec<_>>()
            };
            let (lower, upper) = (edge(-1.0), edge(1.0));
            let settled = (values.len() as f64 * PRIOR_SHARE) as usize;
            let seen = lower.iter().chain(&upper).enumerate();
            let range = range(seen.filter(|(at, _)| at % values.len() >= settled).filter_map(|(_, y)| *y));
            let mut chart = Chart::new(
                format!("{flight}-fig2-{name}"),
                format!("{flight}-captive"),
                TIME,
                y_name,
                table.times_s(0),
            )
            .band("± 1 sigma of the filter", Role::Modelled, lower, upper)
            .line("estimate", Role::Modelled, values);
            chart.y_range = range;
            chart
        })
        .collect()
}

/// The residuals over captive flight (the paper's Figure 3).
pub(super) fn residuals(flight: &str, recording: &Recording, comparison: &Comparison) -> Drawn {
    let reference = ("gps", comparison.reference.captive.spread_m, &recording.reference_residual);
    let sensors = Sensor::ALL.into_iter().map(|sensor| {
        let sigma_m = found(comparison, sensor).and_then(|found| found.residual_sigma_m);
        (sensor.name(), sigma_m, &recording.captive_error[sensor.index()])
    });
    std::iter::once(reference)
        .chain(sensors)
        .filter(|(_, _, table)| !table.is_empty())
        .map(|(name, sigma_m, table)| {
            let (id, group) = (format!("{flight}-fig3-{name}"), format!("{flight}-captive"));
            Chart::new(id, group, TIME, format!("residual of {name}, m"), table.times_s(0))
                .band("residual", Role::Residual, table.least(VALUE), table.greatest(VALUE))
                .bound("± 1 sigma of the residual", Role::Sigma, sigma_m.map(rounded))
        })
        .collect()
}

/// The errors in free flight (the paper's Figure 4).
pub(super) fn free_flight(flight: &str, recording: &Recording, comparison: &Comparison) -> Drawn {
    let Some(launch_us) = recording.launch_us else { return Vec::new() };
    free_sensors(comparison)
        .filter(|(sensor, _)| !recording.free_error[sensor.index()].is_empty())
        .map(|(sensor, found)| {
            let table = &recording.free_error[sensor.index()];
            let mut chart = Chart::new(
                format!("{flight}-fig4-{}", sensor.name()),
                format!("{flight}-free"),
                comparison.words().time_after,
                format!("error of {}, m", sensor.name()),
                table.times_s(launch_us),
            )
            .band("error", Role::Residual, table.least(VALUE), table.greatest(VALUE))
            .line("moving average", Role::Average, table.mean(AVERAGE))
            .bound("alarm limit of the monitor", Role::Bound, found.bound_m.map(rounded));
            chart.moments = flags(found);
            chart
        })
        .collect()
}

/// For each sensor its reading and the model's prediction of it, and below them the difference, over the
/// whole flight. Where the model fails is shaded.
pub(super) fn measured(
    flight: &str,
    recording: &Recording,
    comparison: &Comparison,
) -> Vec<(&'static str, Drawn)> {
    let origin_us = recording.launch_us.unwrap_or(0);
    let x_name = if recording.launch_us.is_some() { comparison.words().time_after } else { TIME };
    let group = format!("{flight}-whole");
    let chart = |kind: &str, sensor: Sensor, y_name: String, table: &Table| {
        let id = format!("{flight}-{kind}-{}", sensor.name());
        let mut chart = Chart::new(id, group.clone(), x_name, y_name, table.times_s(origin_us));
        chart.shades = failing(comparison, sensor);
        if recording.launch_us.is_some() {
            chart.moments.push(Moment {
                name: comparison.words().event.to_owned(),
                role: Role::Event,
                x: 0.0,
            });
        }
        chart
    };
    // Sensors that stay with the mother ship come last.
    let mut sensors = Sensor::ALL;
    sensors.sort_by_key(|sensor| !sensor.flies_free());
    let present = sensors.into_iter().filter_map(|sensor| Some((sensor, found(comparison, sensor)?)));
    present
        .filter(|(sensor, _)| !recording.whole[sensor.index()].is_empty())
        .map(|(sensor, found)| {
            let (name, table) = (sensor.name(), &recording.whole[sensor.index()]);
            let mut charts = Vec::new();
            let readings = table.mean(MEASURED);
            if readings.iter().any(Option::is_some) {
                charts.push(
                    chart("altitude", sensor, format!("{name}, m"), table)
                        .line("measured", Role::Measured, readings)
                        .line("modelled", Role::Modelled, table.mean(MODELLED)),
                );
            }
            let mut difference = chart("difference", sensor, "measured - modelled, m".to_owned(), table)
                .band("measured - modelled", Role::Residual, table.least(ERROR), table.greatest(ERROR))
                .bound(
                    "alarm limit of the monitor",
                    Role::Bound,
                    found.bound_m.filter(|_| sensor.flies_free()).map(rounded),
                );
            difference.moments.extend(flags(found));
            charts.push(difference);
            (name, charts)
        })
        .collect()
}

/// The sensors that fly free, with their results.
pub(super) fn free_sensors(comparison: &Comparison) -> impl Iterator<Item = (Sensor, &SensorComparison)> {
    let free = Sensor::ALL.into_iter().filter(|sensor| sensor.flies_free());
    free.filter_map(|sensor| Some((sensor, found(comparison, sensor)?)))
}

fn found(comparison: &Comparison, sensor: Sensor) -> Option<&SensorComparison> {
    comparison.sensors.get(sensor.name())
}

fn flags(sensor: &SensorComparison) -> Vec<Moment> {
    let moment = |name: &str, role, at: Option<f64>| {
        at.map(|x| Moment { name: format!("{name}, {x:.2} s"), role, x: rounded(x) })
    };
    [
        moment("doubtful", Role::Doubtful, sensor.doubtful_after_s),
        moment("untrustworthy", Role::Untrustworthy, sensor.untrustworthy_after_s),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// The stretches in which the model is worst for a sensor.
fn failing(comparison: &Comparison, sensor: Sensor) -> Vec<Shade> {
    let worst = comparison.failures.worst.iter().filter(|stretch| stretch.sensor == sensor.name());
    worst
        .map(|stretch| Shade {
            name: format!("{}: {:+.1} m", stretch.doing.name(), stretch.mean_m),
            from: stretch.from_s,
            to: stretch.to_s,
        })
        .collect()
}

/// Least and greatest with a margin.
fn range(values: impl Iterator<Item = f64>) -> Option<[f64; 2]> {
    let (least, greatest) = values
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(least, greatest), y| (least.min(y), greatest.max(y)));
    let margin = 0.05 * (greatest - least);
    (least <= greatest).then(|| [rounded(least - margin), rounded(greatest + margin)])
}
