//! Warnings about data of a flight that could not be used unchanged.

use kf_core::mission::Counters;
use model::Model;

use super::comparison::{Comparison, ReadingCounts};
use flight_data::Flight;
use replay::{InputSummary, column_notes, missing_columns};

/// One line for each kind of cell that did not become part of a tick.
pub(super) fn input_warnings(summary: &InputSummary) -> Vec<String> {
    let inputs = &summary.counters;
    let kinds = [
        (
            u32::try_from(summary.skipped_rows).unwrap_or(u32::MAX),
            "rows before the calibration window were not used",
        ),
        (inputs.fixes_without_altitude, "fixes without gps_alt_m were not used"),
        (
            inputs.satellites_not_a_count,
            "satellite counts are not whole numbers from 0 to 255; their fixes were used without them",
        ),
        (inputs.partial_attitudes, "attitudes with only some of roll, pitch and yaw were not used"),
        (inputs.partial_imu_samples, "inertial samples with only some of their six cells were not used"),
    ];
    let mut lines: Vec<_> = kinds
        .into_iter()
        .filter(|(count, _)| *count > 0)
        .map(|(count, what)| format!("{count} {what}"))
        .collect();
    if let Some((counts, channel)) = &summary.inertial_altitude {
        lines.push(match counts.delivered {
            0 => "imu_slave: the flight has no imu_slave_alt_m, and its inertial samples could not be aligned to compute it".to_owned(),
            delivered => format!(
                "imu_slave: the flight has no imu_slave_alt_m; its {delivered} altitudes were computed from accelerometer and gyro"
            ),
        });
        if channel.refused > 0 {
            lines.push(format!("{} inertial samples were refused by the strapdown channel", channel.refused));
        }
        if channel.bridged > 0 {
            lines.push(format!(
                "{} gaps between inertial samples were bridged by the strapdown channel",
                channel.bridged
            ));
        }
    }
    lines
}

/// One line for each effect of the model for which the flight lacks columns.
pub(super) fn effect_warnings(model: &Model, flight: &Flight) -> Vec<String> {
    let lacking = model.effects.iter().filter_map(|effect| {
        let id = effect.term.id();
        let columns = missing_columns(flight, id);
        (!columns.is_empty()).then(|| {
            format!(
                "effect {} of the model was not applied: the flight lacks {}",
                id.name(),
                columns.join(", ")
            )
        })
    });
    lacking.chain(column_notes(flight, model)).collect()
}

/// One line for each kind of input that was refused or is missing, with its count.
pub(super) fn warnings(counters: &Counters, has_settled: bool, comparison: &Comparison) -> Vec<String> {
    let mut lines = Vec::new();
    let mut count = |count: u32, one: &str, many: &str| match count {
        0 => {}
        1 => lines.push(format!("1 {one}")),
        _ => lines.push(format!("{count} {many}")),
    };
    count(
        counters.out_of_order,
        "row was ignored: its time is not later than the previous row's",
        "rows were ignored: their times are not later than the previous row's",
    );
    let mut source = |name: &str, counts: &ReadingCounts| {
        let refused = |what: &str| (format!("{name} reading {what}"), format!("{name} readings {what}"));
        for (number, what) in [
            (counts.not_finite, "refused: not finite, or an invalid pressure"),
            (counts.held, "ignored: the receiver held its last fix"),
            (counts.stuck, "ignored: the sensor is stuck: bit-identical readings"),
            (counts.variance, "refused by the filter: innovation variance not positive"),
            (counts.implausible, "refused: no aircraft can be there or do that"),
            (counts.gated, "refused as outliers: too far from the filter's prediction"),
        ] {
            let (one, many) = refused(what);
            count(number, &one, &many);
        }
    };
    source("gps", &comparison.reference.fixes);
    for (name, sensor) in &comparison.sensors {
        source(name, &sensor.readings);
    }
    count(
        counters.readings_unjudged,
        "reading in free flight was not judged: its error may be the reference's",
        "readings in free flight were not judged: their error may be the reference's",
    );
    count(
        counters.signals_not_finite,
        "signal refused: not finite, or impossible for an aircraft",
        "signals refused: not finite, or impossible for an aircraft",
    );
    count(
        counters.effects_without_signal,
        "reading was used without an effect of the model: the effect's signal was missing",
        "readings were used without an effect of the model: the effect's signal was missing",
    );
    count(
        counters.effects_silent,
        "time an effect by formula had no value although its signals were available: a division by zero, a root of a negative number or \
         an overflow; nothing was added then",
        "times an effect by formula had no value although its signals were available: a division by zero, a root of a negative number or \
         an overflow; nothing was added then",
    );
    count(
        counters.effects_extrapolated,
        "reading was corrected by an effect outside of the range in which its coefficient was learned",
        "readings were corrected by an effect outside of the range in which its coefficient was learned",
    );
    count(
        counters.launch_repeats,
        "change of the launch discrete after launch was ignored: the first launch counts",
        "changes of the launch discrete after launch were ignored: the first launch counts",
    );
    count(
        counters.restarts,
        "restart of the mission from its snapshot",
        "restarts of the mission from its snapshots",
    );
    if !has_settled {
        lines.push("the flight is shorter than the settling time: nothing was calibrated".to_owned());
    }
    if comparison.launch_s.is_none() {
        lines.push(
            "no launch: the whole flight is captive, nothing was latched and no sensor was monitored \
             (--calibrate START..END sets a launch at END)"
                .to_owned(),
        );
    }
    for (name, sensor) in &comparison.sensors {
        if sensor.flies_free && sensor.unmonitored_s > 0.0 {
            lines.push(format!(
                "{name} was not monitored for {:.1} s: no reference, or no reading",
                sensor.unmonitored_s
            ));
        }
    }
    if comparison.sensors.is_empty() {
        lines.push("no sensor has a reading while the reference is available".to_owned());
    }
    lines
}
