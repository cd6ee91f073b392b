//! Apache Parquet (<https://parquet.apache.org/docs/file-format/>), which pandas, polars and DuckDB read.
//!
//! One row group a flight. `time_s` is a required double, every other column an optional float (positions: an
//! optional double). Null is an empty cell, NaN an invalid sample. The file's metadata has the flight's
//! header (`pylon-flight`, `vehicle`, ...) and `pylon-units`, a JSON object of each column's unit. Pages are
//! not compressed.

use std::io::{self, Write};
use std::sync::Arc;

use parquet::basic::{Repetition, Type as Physical};
use parquet::data_type::{DoubleType, FloatType};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;
use serde_json::{Map, Value};

use flight_data::{Column, Flight};

/// Endings of column names, longer ones first, and the units that they mean.
const UNITS: &[(&str, &str)] = &[
    ("_mps2", "m/s^2"),
    ("_radps", "rad/s"),
    ("_mps", "m/s"),
    ("_rad", "rad"),
    ("_deg", "deg"),
    ("_pa", "Pa"),
    ("_c", "degC"),
    ("_m", "m"),
    ("_s", "s"),
];

/// Writes a flight and returns its number of columns.
///
/// # Errors
/// Errors of `out`.
pub fn write(out: &mut dyn Write, flight: &Flight) -> io::Result<usize> {
    // The writer must be sendable between threads, which `out` may not be.
    let (bytes, columns) = bytes(flight).map_err(io::Error::other)?;
    out.write_all(&bytes)?;
    Ok(columns)
}

fn bytes(flight: &Flight) -> Result<(Vec<u8>, usize), ParquetError> {
    let columns = columns(flight);
    let mut fields = vec![field("time_s", Physical::DOUBLE, Repetition::REQUIRED)?];
    for (name, column) in &columns {
        let physical = if column.is_double() { Physical::DOUBLE } else { Physical::FLOAT };
        fields.push(field(name, physical, Repetition::OPTIONAL)?);
    }
    let count = fields.len();
    let schema = Arc::new(Type::group_type_builder("flight").with_fields(fields).build()?);
    let properties = WriterProperties::builder()
        .set_created_by(format!("pylon {}", env!("CARGO_PKG_VERSION")))
        .set_key_value_metadata(Some(metadata(flight, &columns)))
        .build();
    let mut writer = SerializedFileWriter::new(Vec::new(), schema, Arc::new(properties))?;
    let mut group = writer.next_row_group()?;
    if let Some(mut column) = group.next_column()? {
        column.typed::<DoubleType>().write_batch(&flight.time_s, None, None)?;
        column.close()?;
    }
    for (_, column) in &columns {
        let Some(mut writer) = group.next_column()? else { break };
        let levels: Vec<i16> =
            (0..column.len()).map(|row| i16::from(column.get_f64(row).is_some())).collect();
        if column.is_double() {
            let values: Vec<f64> = column.samples_f64().map(|(_, value)| value).collect();
            writer.typed::<DoubleType>().write_batch(&values, Some(&levels), None)?;
        } else {
            let values: Vec<f32> = column.samples().map(|(_, value)| value).collect();
            writer.typed::<FloatType>().write_batch(&values, Some(&levels), None)?;
        }
        writer.close()?;
    }
    group.close()?;
    Ok((writer.into_inner()?, count))
}

fn field(name: &str, physical: Physical, repetition: Repetition) -> Result<Arc<Type>, ParquetError> {
    Ok(Arc::new(Type::primitive_type_builder(name, physical).with_repetition(repetition).build()?))
}

fn columns(flight: &Flight) -> Vec<(&str, &Column)> {
    let known = flight.channels.iter().map(|(channel, column)| (channel.name(), column));
    known.chain(flight.extra.iter().map(|(name, column)| (name.as_str(), column))).collect()
}

fn metadata(flight: &Flight, columns: &[(&str, &Column)]) -> Vec<KeyValue> {
    let header = &flight.header;
    let names = std::iter::once("time_s").chain(columns.iter().map(|(name, _)| *name));
    let units: Map<String, Value> = names.map(|name| (name.to_owned(), Value::from(unit(name)))).collect();
    let own = [
        ("pylon-flight", "1".to_owned()),
        ("vehicle", header.vehicle.clone()),
        ("source", header.source.clone()),
        ("altitude_datum", header.altitude_datum.name().to_owned()),
        ("pylon-units", Value::Object(units).to_string()),
    ];
    let others = header.other.iter().filter(|(key, _)| !key.is_empty());
    own.into_iter()
        .map(|(key, value)| KeyValue::new(key.to_owned(), value))
        .chain(others.map(|(key, value)| KeyValue::new(key.clone(), value.clone())))
        .collect()
}

/// The unit in a column's name; empty for a plain number, or where the name gives none.
fn unit(name: &str) -> &'static str {
    UNITS.iter().find(|(ending, _)| name.ends_with(ending)).map_or("", |(_, unit)| unit)
}

#[cfg(test)]
mod tests {
    use super::*;
    use flight_data::Channel;

    #[test]
    fn every_known_column_but_numbers_has_a_unit() {
        let without: Vec<&str> =
            Channel::ALL.iter().map(|channel| channel.name()).filter(|name| unit(name).is_empty()).collect();
        assert_eq!(without, ["launch", "launch_doubt", "gps_sats", "throttle"]);
        assert_eq!([unit("gyro_x_radps"), unit("accel_z_mps2"), unit("oat_c")], ["rad/s", "m/s^2", "degC"]);
    }
}
