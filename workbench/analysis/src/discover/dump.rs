//! The input of a search for laws as a table, for other programs to try their own methods on.

use std::io::{self, Write};

use replay::Replay;

use super::signals::Signals;
use crate::diagnose::parts::epochs;
use kf_core::sensor::Sensor;

/// Writes a flight's block means as CSV: a row for every block in which the barometer was read, with the
/// columns `time_s`, `free` (0/1), `residual_m` (the barometer's) and then the signals that laws use, in SI
/// units; the heading is `sin_yaw` and `cos_yaw`.
///
/// # Errors
/// When the output cannot be written.
pub fn dump(replay: &Replay<'_>, out: &mut dyn Write) -> io::Result<()> {
    let epochs = epochs(replay, &[], &executor::Inline);
    let series = &epochs.series;
    let signals = Signals::new(&[(series, epochs.signals.as_slice())], &epochs.signal_names, &[]);
    let Some(blocks) = signals.flights.first() else { return Ok(()) };
    let mut columns: Vec<(&str, Vec<f64>)> = Vec::new();
    for (number, signal) in signals.signals.iter().enumerate() {
        let values = blocks.values_of(number);
        if signal.is_heading {
            columns.push(("sin_yaw", values.iter().map(|yaw| libm::sin(*yaw)).collect()));
            columns.push(("cos_yaw", values.iter().map(|yaw| libm::cos(*yaw)).collect()));
        } else {
            columns.push((&signal.name.name, values));
        }
    }
    write!(out, "time_s,free,residual_m")?;
    for (name, _) in &columns {
        write!(out, ",{name}")?;
    }
    writeln!(out)?;
    for block in 0..series.len() {
        let residual_m = series.residual_m[block][Sensor::Baro.index()];
        if !residual_m.is_finite() {
            continue;
        }
        let free = u8::from(series.free[block]);
        write!(out, "{:.6},{free},{residual_m:.9e}", series.time_s[block])?;
        for (_, values) in &columns {
            write!(out, ",{:.9e}", values[block])?;
        }
        writeln!(out)?;
    }
    Ok(())
}
