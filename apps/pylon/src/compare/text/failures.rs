//! Where the model fails.

use std::fmt::Write as _;

use super::number::{NONE, metres, percent, signed_m};
use super::put;
use super::table::{by_sensor, row};
use crate::compare::{Comparison, ErrorFigures, Motion, Stretch, without_minus_zero};

pub(super) fn write(out: &mut String, comparison: &Comparison, colour: bool) {
    let failures = &comparison.failures;
    if failures.worst.is_empty() {
        return;
    }
    let words = comparison.words();
    put!(
        out,
        "\nWhere the model fails: the worst stretches of {}, seconds after {}",
        words.after,
        words.event
    );
    let mut last = "";
    for stretch in &failures.worst {
        let name = if stretch.sensor == last { "" } else { &*stretch.sensor };
        last = &stretch.sensor;
        put!(out, "  {name:<10} {}", stretch_line(stretch));
    }
    let Some(first) = failures.by_manoeuvre.first() else { return };
    let mut heads = vec!["for", "climb", "speed", "load", "turn"];
    heads.extend(first.sensors.iter().map(|(name, _)| &**name));
    let mut table = by_sensor("mean, rms error", &heads);
    for kind in &failures.by_manoeuvre {
        let mut cells = vec![format!("{:.0} s", kind.seconds)];
        cells.extend(motion_cells(&kind.motion));
        cells.extend(kind.sensors.iter().map(|(_, errors)| errors.as_ref().map_or_else(dash, pair)));
        row(&mut table, kind.doing.name(), cells.into_iter());
    }
    put!(out, "\n{}", view::text::table(&table, colour));
}

fn dash() -> String {
    NONE.to_owned()
}

fn pair(errors: &ErrorFigures) -> String {
    format!("{}, {}", signed_m(Some(errors.mean_m)), metres(Some(errors.rms_m)))
}

fn motion_cells(motion: &Motion) -> [String; 4] {
    [
        motion.climb_rate_mps.map_or_else(dash, |climb| format!("{:+.0} m/s", without_minus_zero(climb))),
        motion.speed_mps.map_or_else(dash, |speed| format!("{speed:.0} m/s")),
        motion.load_factor.map_or_else(dash, |load| format!("{load:.1} g")),
        motion
            .turn_rate_radps
            .map_or_else(dash, |rate| format!("{:+.0} deg/s", without_minus_zero(rate.to_degrees()))),
    ]
}

fn stretch_line(stretch: &Stretch) -> String {
    let motion = stretch.motion.to_string();
    let motion = if motion.is_empty() { motion } else { format!(" ({motion})") };
    format!(
        "{:.0} to {:.0} s {}{motion}: {}, {} rms; {} of its squared error",
        stretch.from_s,
        stretch.to_s,
        stretch.doing.phrase(),
        signed_m(Some(stretch.mean_m)),
        metres(Some(stretch.rms_m)),
        percent(Some(stretch.share_of_squared_error))
    )
}
