//! An overview as text.

use std::fmt::Write as _;

use super::{AirborneTime, Overview, SensorState};
use crate::flight::AltitudeDatum;
use crate::replay::clock;

/// Writes a line to a string, which cannot fail.
macro_rules! put {
    ($out:expr, $($arguments:tt)*) => {{
        let _ = writeln!($out, $($arguments)*);
    }};
}

/// The overview in plain English.
#[must_use]
pub fn text(overview: &Overview) -> String {
    let mut out = String::new();
    let Overview { file, format, vehicle, .. } = overview;
    let of = if vehicle.is_empty() { String::new() } else { format!(", {vehicle}") };
    put!(out, "{file}: {format}{of}");
    // A problem that makes the flight unusable or doubtful comes first.
    if let Some(why) = overview.refused.as_ref().or(overview.barometer_fault.as_ref()) {
        let what = if overview.refused.is_some() { "not usable:" } else { "beware:" };
        put!(out, "  {what:<11} {why}");
    }
    put!(
        out,
        "  the log    {} in {} rows, from {:.0} s to {:.0} s of its own clock",
        duration(overview.duration_s),
        overview.rows,
        overview.first_s,
        overview.first_s + overview.duration_s
    );
    flights(&mut out, overview);
    if let Some(calibration) = &overview.calibration {
        put!(out, "  calibrated {}", calibration.strip_prefix("calibrated ").unwrap_or(calibration));
    }
    if overview.refused.is_none() {
        let used = |share: f64| format!("{:.1} %", 100.0 * share);
        let (compared, diagnosed) = (used(overview.usage.used_share), overview.diagnosed_share.map(used));
        // A diagnosis estimates the biases along with everything else, so it also uses what was flown before
        // a calibration.
        match diagnosed.filter(|diagnosed| *diagnosed != compared) {
            Some(diagnosed) => {
                put!(out, "  used       {compared} of the log by compare, {diagnosed} by diagnose")
            }
            None => put!(out, "  used       {compared} of the log"),
        }
        for part in &overview.usage.unused {
            put!(out, "             {}", part.text());
        }
    }
    put!(out, "\nSensors");
    for sensor in &overview.sensors {
        let rate = sensor.rate_hz.map_or_else(String::new, |rate| format!(" at {}", hertz(rate)));
        let said = match sensor.state {
            SensorState::Present => {
                let datum = sensor.datum.as_deref().and_then(AltitudeDatum::from_name);
                let datum = datum.map_or_else(String::new, |datum| format!(", {}", datum.words()));
                format!("{} samples{rate} ({}){datum}", sensor.samples, sensor.columns.join(", "))
            }
            SensorState::Stuck => format!("stuck: {} samples, all the same", sensor.samples),
            SensorState::Copied => "no barometer: a copy of the receiver's altitude".to_owned(),
            SensorState::Absent => "none".to_owned(),
        };
        put!(out, "  {:<23}{said}", sensor.sensor);
    }
    if !overview.notes.is_empty() {
        put!(out, "\nRemarks");
        for note in &overview.notes {
            put!(out, "  {note}");
        }
    }
    if !overview.next.is_empty() {
        put!(out, "\nNext");
        for command in &overview.next {
            put!(out, "  {command}");
        }
    }
    out
}

fn flights(out: &mut String, overview: &Overview) {
    if let Some(launch_s) = overview.launch_s {
        put!(out, "  launch     at {}, by the log's launch column", clock(launch_s));
        return;
    }
    if overview.usage.has_launch {
        put!(out, "  launch     none: the launch column is never 1");
        return;
    }
    let several = overview.airborne.len() > 1;
    for (place, interval) in overview.airborne.iter().enumerate() {
        let number = if several { format!("{} ", place + 1) } else { String::new() };
        let is_used = several && overview.usage.flight == Some(place + 1);
        let used = if is_used { "; this one is used" } else { "" };
        let is_last = place + 1 == overview.airborne.len();
        put!(out, "  flight {number:<4}{}{used}", ends(interval, place == 0, is_last));
    }
    if overview.airborne.is_empty() {
        put!(out, "  flight     no take-off or landing in this log: treated as one flight");
    }
    if let Some(drop_s) = overview.drop_s {
        put!(out, "  drop       at {}, from a carrier, by how it falls", clock(drop_s));
    }
    if let Some(seconds) = overview.ground_before_s {
        put!(out, "  ground     {} before take-off", duration(seconds));
    }
    if let Some(seconds) = overview.after_landing_s {
        put!(out, "             {} after landing, not analysed", duration(seconds));
    }
}

/// A missing landing or take-off between two flights means a long gap in the log.
fn ends(interval: &AirborneTime, is_first: bool, is_last: bool) -> String {
    let take_off = interval.take_off_s.map_or_else(
        || {
            let when =
                if is_first { "the log begins (or just about to take off)" } else { "a gap in the log ends" };
            format!("in the air when {when}")
        },
        |at_s| format!("take-off at {}", clock(at_s)),
    );
    let landing = interval.landing_s.map_or_else(
        || {
            let when = if is_last { "it ends (or just landed)" } else { "a gap in the log begins" };
            format!("in the air when {when}")
        },
        |at_s| format!("landing at {}", clock(at_s)),
    );
    format!("{take_off}, {landing}, {} in the air", duration(interval.duration_s))
}

fn duration(seconds: f64) -> String {
    match seconds {
        short if short < 120.0 => format!("{short:.0} s"),
        middle if middle < 7_200.0 => format!("{:.1} min", middle / 60.0),
        long => format!("{:.1} h", long / 3_600.0),
    }
}

fn hertz(rate: f64) -> String {
    if rate < 0.95 { format!("one every {:.0} s", 1.0 / rate) } else { format!("{rate:.0} Hz") }
}
