//! The input of a diagnosis as a table, for other programs to try their own methods on.

use std::io::{self, Write};

use kf_core::sensor::{SENSORS, Sensor};

use super::candidates::catalogue;
use super::from_replay::epochs;
use super::physical_range::measures_climb_rate;
use replay::Replay;

/// Writes a flight's block means as CSV: a row for each block and sensor with readings in it, with the
/// columns `time_s`, `free` (0/1), `sensor`, `residual_m` and then every available candidate's regressor in
/// metres per unit of its coefficient (zero where it does not act on the sensor; an effect of the reference
/// acts on all). A candidate with a time constant is `id@clock:seconds`. For a lag and for effects of a
/// signal's error, only the catalogue's own shape is written. The blocks are those that [`super::diagnose`]
/// uses.
///
/// # Errors
/// When the output cannot be written.
pub fn dump(replay: &Replay<'_>, out: &mut dyn Write) -> io::Result<()> {
    let candidates = catalogue(replay.model(), measures_climb_rate(replay));
    let epochs = epochs(replay, &candidates, &executor::Inline);
    let series = &epochs.series;
    let columns: Vec<usize> = (0..candidates.len())
        .filter(|column| candidates[*column].is_catalogues())
        .filter(|column| epochs.available[*column])
        .collect();
    write!(out, "time_s,free,sensor,residual_m")?;
    for column in &columns {
        let candidate = &candidates[*column];
        let name = candidate.effect().name();
        if candidate.effect().has_time_constant() {
            let regressor = &candidate.regressor;
            write!(out, ",{name}@{}:{}", regressor.since.name(), regressor.time_constant_s)?;
        } else {
            write!(out, ",{name}")?;
        }
    }
    writeln!(out)?;
    for block in 0..series.len() {
        for (i, sensor) in Sensor::ALL.into_iter().enumerate().take(SENSORS) {
            let residual_m = series.residual_m[block][i];
            if !residual_m.is_finite() {
                continue;
            }
            let free = u8::from(series.free[block]);
            write!(out, "{:.6},{free},{},{residual_m:.9e}", series.time_s[block], sensor.name())?;
            for column in &columns {
                write!(out, ",{:.9e}", series.columns[*column][block][i])?;
            }
            writeln!(out)?;
        }
    }
    Ok(())
}
