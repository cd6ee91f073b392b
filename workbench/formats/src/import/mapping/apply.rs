//! Turns a table into a flight, by a mapping.

use super::document::{ColumnName, Mapping, Signal, TimeBase};
use super::error::{ColumnError, Fault, MappingError, SignalError, TableError};
use super::quantity::{Quantity, plausible};
use super::table::LoggedTable;
use crate::import::damage::percent;
use crate::import::gps_time::utc_text;
use crate::import::stamps;
use crate::import::table::{Destination, Filling, Samples, Table, assemble};
use crate::import::velocity::{Position, velocities};
use flight_data::{Channel, Column, CsvProblem, Flight, Header, Note};

/// A time farther than this from the median of the others is invalid, seconds (30 years).
const FAR_S: f64 = 1e9;
/// Half a day, seconds: a time of day that goes back by more has passed midnight.
const HALF_DAY_S: f64 = 43_200.0;
/// Possible times of a log, seconds since 1970: 2000 to 2100.
pub const EPOCH_S: std::ops::Range<f64> = 946_684_800.0..4_102_444_800.0;

/// Makes the flight.
pub fn apply(table: &LoggedTable, mapping: &Mapping, name: &str) -> Result<(Flight, Vec<Note>), Fault> {
    let Some(base) = &mapping.time else { return Err(MappingError::NoTimeBase.into()) };
    let mut notes = Vec::new();
    let seconds = seconds(table, base)?;
    let Times { times_us, epoch_s } = times(table, &seconds, &mut notes)?;
    let mut fillings = Vec::new();
    let mut used = vec![false; table.columns.len()];
    if let Some(column) = &base.column {
        mark(&mut used, time_place(table, column)?);
    }
    let fixes = fix_rows(table, mapping)?;
    let nowhere = nowhere(table, mapping);
    let count = nowhere.iter().filter(|is_nowhere| **is_nowhere).count();
    if count > 0 {
        notes.push(format!(
            "rows at latitude 0 and longitude 0, which a receiver without a fix records; their fixes are left out: {count} ({})",
            percent(count, table.lines.len())
        ));
    }
    for (destination, signal) in &mapping.signals {
        let column = signal_place(table, destination, signal)?;
        mark(&mut used, column);
        let mut samples = samples(table, column, destination, signal, fixes.as_deref());
        if is_of_fix(destination) {
            samples.retain(|(row, _)| !nowhere.get(*row as usize).copied().unwrap_or(false));
        }
        notes.extend(remarks(table, column, destination, &samples));
        let destination = Channel::from_name(destination)
            .map_or_else(|| Destination::signal(destination), Destination::Channel);
        fillings.push(Filling { destination, samples: Samples::Double(samples) });
    }
    let mut header = Header {
        vehicle: mapping.flight.vehicle.trim().replace(char::is_control, " "),
        source: format!("imported table, by {name}"),
        altitude_datum: mapping.datum()?,
        other: vec![("log_format".to_owned(), "table".to_owned())],
    };
    mapping.datums().for_each(|(column, datum)| header.set_datum(column, datum));
    let Table { mut flight, repeated, start_us, .. } = assemble(header, &times_us, fillings);
    flight.require_altitudes().map_err(|problem| {
        let has = |channel: Channel| mapping.signals.contains_key(channel.name());
        match problem {
            CsvProblem::Missing { name, .. } if !has(Channel::GpsAltM) => {
                Fault::from(MappingError::NoReference { name: name.to_string() })
            }
            CsvProblem::Missing { name, .. } => TableError::NoValue { name: name.to_string() }.into(),
            other => MappingError::Flight(Box::new(other)).into(),
        }
    })?;
    if let Some(epoch_s) = epoch_s {
        let start = utc_text((epoch_s + start_us as f64 / 1e6).floor() as i64);
        flight.header.other.extend(start.map(|start| ("start_utc".to_owned(), start)));
    }
    if derive_velocity(table, mapping, &times_us, start_us, &mut flight) {
        flight.header.other.push(("gps_velocity".to_owned(), "derived from positions".to_owned()));
        notes.push("gps_vn_mps and gps_ve_mps are derived from positions".to_owned());
    }
    if repeated > 0 {
        notes.push(format!("values that share their time with a later one, which counts: {repeated}"));
    }
    let left: Vec<&str> =
        table.names.iter().zip(&used).filter_map(|(name, used)| (!used).then_some(name.as_str())).collect();
    if !left.is_empty() {
        notes.push(format!("columns that the mapping does not name, left out: {}", left.join(", ")));
    }
    let lines = table.lines.len() + table.unread;
    notes.insert(
        0,
        format!("{lines} {}s over {:.1} s", table.row_name(), flight.time_s.last().copied().unwrap_or(0.0)),
    );
    if table.unread > 0 {
        notes.push(format!(
            "damaged: lines with another number of cells than the {} expected, or with a quote that is never closed, left \
             out: {} ({}), the first is line {}",
            table.columns.len(),
            table.unread,
            percent(table.unread, lines),
            table.first_unread
        ));
    }
    notes.extend(table.notes.iter().cloned());
    Ok((flight, notes.into_iter().map(Note::new).collect()))
}

fn mark(used: &mut [bool], column: usize) {
    if let Some(slot) = used.get_mut(column) {
        *slot = true;
    }
}

/// Index of a column, from 0.
fn place(table: &LoggedTable, column: &ColumnName) -> Result<usize, ColumnError> {
    let count = table.columns.len();
    match column {
        ColumnName::Place(place) if (1..=count).contains(place) => Ok(place - 1),
        ColumnName::Place(place) => Err(ColumnError::Place { place: *place, count }),
        ColumnName::Name(name) => {
            let found: Vec<usize> = table
                .names
                .iter()
                .enumerate()
                .filter_map(|(place, own)| (own == name).then_some(place))
                .collect();
            match found.as_slice() {
                [place] => Ok(*place),
                [] => {
                    let near = table.names.iter().min_by_key(|own| strsim::osa_distance(own, name));
                    let near = near.filter(|own| strsim::osa_distance(own, name) <= 2).cloned();
                    Err(ColumnError::Unknown { name: name.clone(), near, names: table.names.clone() })
                }
                several => {
                    let places = several.iter().map(|place| place + 1).collect();
                    Err(ColumnError::Ambiguous { name: name.clone(), places })
                }
            }
        }
    }
}

/// Index of the time's column, from 0.
fn time_place(table: &LoggedTable, column: &ColumnName) -> Result<usize, MappingError> {
    place(table, column).map_err(|error| MappingError::TimeColumn(Box::new(error)))
}

/// Index of a signal's column, from 0.
fn signal_place(table: &LoggedTable, name: &str, signal: &Signal) -> Result<usize, MappingError> {
    place(table, &signal.column).map_err(|error| {
        let source = Box::new(SignalError::Column(error));
        MappingError::Signal { name: name.to_owned(), source }
    })
}

/// Time of each row, seconds by the log's own clock; NaN where there is none.
fn seconds(table: &LoggedTable, base: &TimeBase) -> Result<Vec<f64>, Fault> {
    let rows = table.lines.len();
    let (Some(column), None) = (&base.column, base.rate_hz) else {
        let rate_hz = base.rate_hz.unwrap_or(1.0);
        return Ok((0..rows).map(|row| row as f64 / rate_hz).collect());
    };
    let column = time_place(table, column)?;
    let Some(cells) = table.columns.get(column) else { return Ok(Vec::new()) };
    let is_number = cells.numbers >= cells.clocks + cells.dates;
    let unit = base.unit.as_deref().and_then(|unit| Quantity::Time.unit(unit));
    match (is_number, unit) {
        (true, Some(unit)) => Ok(cells.values.iter().map(|value| value * unit.factor).collect()),
        (true, None) => Err(MappingError::NoTimeUnit(table.name(column).to_owned()).into()),
        (false, Some(_)) => Err(MappingError::UnitOfClock(table.name(column).to_owned()).into()),
        (false, None) if cells.dates > 0 => Ok(cells.values.clone()),
        (false, None) => Ok(past_midnight(&cells.values)),
    }
}

/// Times of day that continue past midnight.
pub fn past_midnight(values: &[f64]) -> Vec<f64> {
    let (mut days_s, mut before) = (0.0, f64::NAN);
    let next = |value: &f64| {
        if *value < before - HALF_DAY_S {
            days_s += 86_400.0;
        }
        before = if value.is_nan() { before } else { *value };
        value + days_s
    };
    values.iter().map(next).collect()
}

struct Times {
    times_us: Vec<Option<u64>>,
    /// Seconds since 1970 at zero of these times, if the log gives it.
    epoch_s: Option<f64>,
}

/// The median of some numbers; `None` without numbers.
pub fn middle(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    let mut values: Vec<f64> = values.into_iter().filter(|value| value.is_finite()).collect();
    let half = values.len() / 2;
    (!values.is_empty()).then(|| *values.select_nth_unstable_by(half, f64::total_cmp).1)
}

fn times(table: &LoggedTable, seconds: &[f64], notes: &mut Vec<String>) -> Result<Times, Fault> {
    let Some(center) = middle(seconds.iter().copied()) else {
        return Err(TableError::NoTime.into());
    };
    let is_near = |value: &f64| (value - center).abs() <= FAR_S;
    let first = seconds.iter().copied().filter(is_near).fold(f64::INFINITY, f64::min);
    let stamps_us: Vec<u64> = seconds
        .iter()
        .map(|value| if is_near(value) { ((value - first) * 1e6).round() as u64 } else { stamps::NO_TIME })
        .collect();
    let pace_s = middle(seconds.windows(2).filter_map(|pair| match pair {
        [one, other] if other > one => Some(other - one),
        _ => None,
    }));
    let pace_us = (pace_s.unwrap_or(0.0) * 1e6).clamp(0.0, 1e15) as u64;
    let described =
        |stamp: usize| format!("{} {}", table.row_name(), table.lines.get(stamp).copied().unwrap_or(0));
    let believed = stamps::believe_paced(&stamps_us, pace_us, std::iter::empty(), described);
    let without = stamps_us.iter().filter(|stamp| **stamp == stamps::NO_TIME).count();
    if without > 0 {
        let at = stamps_us.iter().position(|stamp| *stamp == stamps::NO_TIME).unwrap_or(0);
        notes.push(format!(
            "rows without a time, or with one decades away, left out: {without} ({}), the first is {}",
            percent(without, stamps_us.len()),
            described(at)
        ));
    }
    notes.extend(believed.notes);
    let epoch_s = EPOCH_S.contains(&first).then_some(first);
    Ok(Times { times_us: believed.times_us, epoch_s })
}

/// Whether a signal is the receiver's: held signals of the receiver change together.
fn is_of_fix(destination: &str) -> bool {
    destination.starts_with("gps_") || matches!(destination, "latitude_deg" | "longitude_deg")
}

/// Rows whose position is exactly at zero latitude and longitude: what receivers report without a position.
fn nowhere(table: &LoggedTable, mapping: &Mapping) -> Vec<bool> {
    let column = |name: &str| place(table, &mapping.signals.get(name)?.column).ok();
    let (Some(latitude), Some(longitude)) = (column("latitude_deg"), column("longitude_deg")) else {
        return Vec::new();
    };
    let pairs = table.values(latitude).iter().zip(table.values(longitude));
    pairs.map(|(latitude, longitude)| *latitude == 0.0 && *longitude == 0.0).collect()
}

/// For the receiver's held columns: the rows in which one of them differs from the row before.
fn fix_rows(table: &LoggedTable, mapping: &Mapping) -> Result<Option<Vec<bool>>, Fault> {
    let held = mapping.signals.iter().filter(|(name, signal)| signal.held && is_of_fix(name));
    let mut rows: Option<Vec<bool>> = None;
    for (name, signal) in held {
        let column = signal_place(table, name, signal)?;
        let rows = rows.get_or_insert_with(|| vec![false; table.lines.len()]);
        for (slot, is_new) in rows.iter_mut().zip(changes(table.values(column))) {
            *slot |= is_new;
        }
    }
    Ok(rows)
}

/// Whether each value differs from the one before.
pub fn changes(values: &[f64]) -> impl Iterator<Item = bool> + '_ {
    let mut before = f64::NAN;
    values.iter().map(move |value| {
        let is_new = !value.is_nan() && *value != before;
        before = if value.is_nan() { before } else { *value };
        is_new
    })
}

fn samples(
    table: &LoggedTable,
    column: usize,
    destination: &str,
    signal: &Signal,
    fixes: Option<&[bool]>,
) -> Vec<(u32, f64)> {
    let values = table.values(column);
    let own: Vec<bool>;
    let is_new: Option<&[bool]> = match (signal.held, fixes) {
        (false, _) => None,
        (true, Some(fixes)) if is_of_fix(destination) => Some(fixes),
        (true, _) => {
            own = changes(values).collect();
            Some(&own)
        }
    };
    let (factor, offset) = signal.conversion(destination);
    let kept = |row: usize| is_new.is_none_or(|is_new| is_new.get(row).copied().unwrap_or(false));
    let converted = values.iter().enumerate().zip(0_u32..).filter_map(|((row, value), stamp)| {
        (!value.is_nan() && kept(row)).then_some((stamp, value * factor + offset))
    });
    converted.filter(|(_, value)| (*value as f32).is_finite()).collect()
}

/// Notes on unusual values of a signal.
fn remarks(table: &LoggedTable, column: usize, destination: &str, samples: &[(u32, f64)]) -> Vec<String> {
    let mut found = Vec::new();
    let name = table.name(column);
    if samples.is_empty() {
        found.push(format!("{destination}: column '{name}' has no numbers"));
    }
    let words = table.columns.get(column).map_or(0, |cells| cells.words);
    if words > 0 && !samples.is_empty() {
        found.push(format!(
            "{destination}: cells of column '{name}' that are not numbers, taken as empty: {words}"
        ));
    }
    let usual = middle(samples.iter().map(|(_, value)| *value));
    if let (Some((low, high)), Some(usual)) = (plausible(destination), usual)
        && !(low..=high).contains(&usual)
    {
        found.push(format!(
            "{destination}: its values are about {usual:.4}, expected {low} to {high}: is the unit of column '{name}' right?"
        ));
    }
    found
}

/// Adds north and east velocity where positions are mapped and velocities are not; returns whether it did.
fn derive_velocity(
    table: &LoggedTable,
    mapping: &Mapping,
    times_us: &[Option<u64>],
    start_us: u64,
    flight: &mut Flight,
) -> bool {
    let has = |channel: Channel| mapping.signals.contains_key(channel.name());
    let (Some(latitude), Some(longitude)) =
        (mapping.signals.get("latitude_deg"), mapping.signals.get("longitude_deg"))
    else {
        return false;
    };
    if has(Channel::GpsVnMps) || has(Channel::GpsVeMps) {
        return false;
    }
    // From the cells directly: f32 would round a position to a metre.
    let degrees = |name: &str, signal: &Signal| {
        let (factor, offset) = signal.conversion(name);
        let column = place(table, &signal.column).unwrap_or(usize::MAX);
        table.values(column).iter().map(|value| value * factor + offset).collect::<Vec<f64>>()
    };
    let (latitudes, longitudes) = (degrees("latitude_deg", latitude), degrees("longitude_deg", longitude));
    let is_held = latitude.held || longitude.held;
    let mut positions = Vec::new();
    let mut before = (f64::NAN, f64::NAN);
    for ((latitude_deg, longitude_deg), time_us) in latitudes.into_iter().zip(longitudes).zip(times_us) {
        let Some(time_us) = time_us else { continue };
        let is_nowhere = latitude_deg == 0.0 && longitude_deg == 0.0;
        if latitude_deg.is_nan() || longitude_deg.is_nan() || is_nowhere {
            continue;
        }
        if !is_held || before != (latitude_deg, longitude_deg) {
            positions.push((*time_us as f64 / 1e6, Position { latitude_deg, longitude_deg }));
        }
        before = (latitude_deg, longitude_deg);
    }
    positions.sort_by(|one, other| one.0.total_cmp(&other.0));
    let start_s = start_us as f64 / 1e6;
    let (mut north, mut east) = (Column::empty(flight.rows()), Column::empty(flight.rows()));
    let mut any = false;
    for ((time_s, _), velocity) in positions.iter().zip(velocities(positions.iter().copied())) {
        let at_s = time_s - start_s;
        let row = flight.time_s.partition_point(|row_s| *row_s < at_s - 1e-7);
        let Some((north_mps, east_mps)) = velocity else { continue };
        if flight.time_s.get(row).is_some_and(|row_s| (row_s - at_s).abs() < 1e-6) {
            any |= north.set(row, Some(north_mps)) && east.set(row, Some(east_mps));
        }
    }
    if any {
        flight.set_channel(Channel::GpsVnMps, north);
        flight.set_channel(Channel::GpsVeMps, east);
    }
    any
}

#[cfg(test)]
#[path = "tests.rs"]
mod tests;
