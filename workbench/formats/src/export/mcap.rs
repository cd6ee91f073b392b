//! MCAP (<https://mcap.dev/spec>), which Foxglove Studio and ROS tools read.
//!
//! One topic a device (`/gps`, `/baro`, `/imu`, ...) and one JSON message for every row in which the device
//! has a new sample. Keys are the column names, which give the units. A sample that is not finite is null.
//! The flight's header is a metadata record named `pylon-flight`. Chunks are not compressed.
//!
//! Where the flight has the position, the fixes are also on `/gps/fix` as `foxglove.LocationFix`
//! (<https://docs.foxglove.dev/docs/visualization/message-schemas/location-fix>), which Foxglove's map shows.

use std::collections::BTreeMap;
use std::io::{self, Write};

use mcap::records::{MessageHeader, Metadata};
use mcap::write::NoSeek;
use mcap::{McapError, WriteOptions, Writer};
use serde_json::{Map, Value, json};

use flight_data::{Channel, Column, Flight};

/// Amount of data written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct McapSummary {
    /// Topics.
    pub topics: usize,
    /// Messages on all topics.
    pub messages: u64,
}

/// The device that a channel belongs to.
const fn topic(channel: Channel) -> &'static str {
    use Channel as C;
    match channel {
        C::Launch | C::LaunchDoubt => "/launch",
        C::GpsAltM | C::GpsVnMps | C::GpsVeMps | C::GpsVdMps | C::GpsVaccM | C::GpsSats | C::GpsTimeS => {
            "/gps"
        }
        C::BaroPa | C::BaroAltM | C::BaroTempC => "/baro",
        C::ImuMasterAltM => "/imu_master",
        C::ImuSlaveAltM => "/imu_slave",
        C::AccelXMps2 | C::AccelYMps2 | C::AccelZMps2 | C::GyroXRadps | C::GyroYRadps | C::GyroZRadps => {
            "/imu"
        }
        C::RollRad | C::PitchRad | C::YawRad => "/attitude",
        C::TasMps | C::AoaRad | C::SideslipRad | C::OatC => "/air",
        C::Throttle => "/throttle",
    }
}

/// The columns of one topic.
struct Device<'a> {
    channel_id: u16,
    columns: Vec<(&'a str, &'a Column)>,
    sequence: u32,
}

/// Topic of the receiver's position.
const FIX_TOPIC: &str = "/gps/fix";
/// JSON schema of the written part of `foxglove.LocationFix`, without its descriptions and the covariance.
const FIX_SCHEMA: &str = r#"{"title":"foxglove.LocationFix","type":"object","properties":{
"timestamp":{"type":"object","title":"time","properties":{"sec":{"type":"integer","minimum":0},
"nsec":{"type":"integer","minimum":0,"maximum":999999999}}},
"frame_id":{"type":"string"},"latitude":{"type":"number"},"longitude":{"type":"number"},"altitude":{"type":"number"}}}"#;

/// The columns of the receiver's position.
struct Fixes<'a> {
    channel_id: u16,
    latitude_deg: &'a Column,
    longitude_deg: &'a Column,
    altitude_m: &'a Column,
}

impl<'a> Fixes<'a> {
    /// The columns of a flight that has them.
    fn of(
        writer: &mut Writer<NoSeek<&mut dyn Write>>,
        flight: &'a Flight,
    ) -> Result<Option<Self>, McapError> {
        let signal =
            |wanted: &str| flight.extra.iter().find_map(|(name, column)| (name == wanted).then_some(column));
        let columns = (signal("latitude_deg"), signal("longitude_deg"), flight.channel(Channel::GpsAltM));
        let (Some(latitude_deg), Some(longitude_deg), Some(altitude_m)) = columns else { return Ok(None) };
        let schema_id = writer.add_schema("foxglove.LocationFix", "jsonschema", FIX_SCHEMA.as_bytes())?;
        let channel_id = writer.add_channel(schema_id, FIX_TOPIC, "json", &BTreeMap::new())?;
        Ok(Some(Self { channel_id, latitude_deg, longitude_deg, altitude_m }))
    }

    /// The fix of a row, if it has one.
    fn message(&self, row: usize, time_ns: u64) -> Option<Value> {
        let of = |column: &Column| cell(column, row).filter(|value| !value.is_null());
        Some(json!({
            "timestamp": { "sec": time_ns / 1_000_000_000, "nsec": time_ns % 1_000_000_000 },
            "frame_id": "gps",
            "latitude": of(self.latitude_deg)?,
            "longitude": of(self.longitude_deg)?,
            "altitude": of(self.altitude_m)?,
        }))
    }
}

/// Writes a flight.
///
/// # Errors
/// Errors of `out`.
pub fn write(out: &mut dyn Write, flight: &Flight) -> io::Result<McapSummary> {
    write_all(out, flight).map_err(|error| match error {
        McapError::Io(error) => error,
        other => io::Error::other(other),
    })
}

fn write_all(out: &mut dyn Write, flight: &Flight) -> Result<McapSummary, McapError> {
    let library = format!("pylon {}", env!("CARGO_PKG_VERSION"));
    let options = WriteOptions::new().library(library).compression(None).disable_seeking(true);
    let mut writer: Writer<NoSeek<&mut dyn Write>> = options.create(NoSeek::new(out))?;
    writer.write_metadata(&Metadata { name: "pylon-flight".to_owned(), metadata: header(flight) })?;
    let mut devices = devices(&mut writer, flight)?;
    let fixes = Fixes::of(&mut writer, flight)?;
    let mut summary = McapSummary { topics: devices.len() + usize::from(fixes.is_some()), messages: 0 };
    let mut sequence = 0_u32;
    for (row, time_s) in flight.time_s.iter().enumerate() {
        let time_ns = (time_s * 1e9).round() as u64;
        for device in &mut devices {
            let cells = device.columns.iter().filter_map(|(name, column)| Some((*name, cell(column, row)?)));
            let message: Map<String, Value> = cells.map(|(name, value)| (name.to_owned(), value)).collect();
            if message.is_empty() {
                continue;
            }
            let header = MessageHeader {
                channel_id: device.channel_id,
                sequence: device.sequence,
                log_time: time_ns,
                publish_time: time_ns,
            };
            writer.write_to_known_channel(&header, Value::Object(message).to_string().as_bytes())?;
            device.sequence = device.sequence.wrapping_add(1);
            summary.messages += 1;
        }
        if let Some((fixes, message)) =
            fixes.as_ref().and_then(|fixes| Some((fixes, fixes.message(row, time_ns)?)))
        {
            let header = MessageHeader {
                channel_id: fixes.channel_id,
                sequence,
                log_time: time_ns,
                publish_time: time_ns,
            };
            writer.write_to_known_channel(&header, message.to_string().as_bytes())?;
            sequence = sequence.wrapping_add(1);
            summary.messages += 1;
        }
    }
    writer.finish()?;
    Ok(summary)
}

/// A row's cell in the column's precision; null for a sample that is not finite.
fn cell(column: &Column, row: usize) -> Option<Value> {
    if !column.is_double() {
        return column.get(row).map(number);
    }
    let value = column.get_f64(row)?;
    Some(if value.is_finite() { json!(value) } else { Value::Null })
}

/// The shortest decimal that reads back as the same f32.
fn number(value: f32) -> Value {
    value
        .to_string()
        .parse::<f64>()
        .ok()
        .filter(|value| value.is_finite())
        .map_or(Value::Null, |value| json!(value))
}

fn header(flight: &Flight) -> BTreeMap<String, String> {
    let header = &flight.header;
    let mut keys: BTreeMap<String, String> =
        header.other.iter().filter(|(key, _)| !key.is_empty()).cloned().collect();
    keys.insert("vehicle".to_owned(), header.vehicle.clone());
    keys.insert("source".to_owned(), header.source.clone());
    keys.insert("altitude_datum".to_owned(), header.altitude_datum.name().to_owned());
    keys
}

fn devices<'a>(
    writer: &mut Writer<NoSeek<&mut dyn Write>>,
    flight: &'a Flight,
) -> Result<Vec<Device<'a>>, McapError> {
    let mut by_topic: BTreeMap<&str, Vec<(&str, &Column)>> = BTreeMap::new();
    for (channel, column) in &flight.channels {
        by_topic.entry(topic(*channel)).or_default().push((channel.name(), column));
    }
    for (name, column) in &flight.extra {
        by_topic.entry("/extra").or_default().push((name, column));
    }
    by_topic
        .into_iter()
        .map(|(topic, columns)| {
            let properties: Map<String, Value> = columns
                .iter()
                .map(|(name, _)| ((*name).to_owned(), json!({ "type": ["number", "null"] })))
                .collect();
            let schema = json!({ "type": "object", "properties": properties }).to_string();
            let name = format!("pylon{}", topic.replace('/', "."));
            let schema_id = writer.add_schema(&name, "jsonschema", schema.as_bytes())?;
            let channel_id = writer.add_channel(schema_id, topic, "json", &BTreeMap::new())?;
            Ok(Device { channel_id, columns, sequence: 0 })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_sample_is_read_back() {
        let text = "# pylon-flight: 1\n# vehicle: test\n# source: made for a test\n# campaign: x\n\
            time_s,launch,gps_alt_m,gps_sats,baro_alt_m,flap_deg\n\
            0,0,100.125,9,101.1,\n0.005,,,,nan,3\n0.01,1,,,102.3,\n";
        let flight = flight_data::parse(text.as_bytes()).unwrap().0;
        let mut bytes = Vec::new();
        let summary = write(&mut bytes, &flight).unwrap();
        assert_eq!(summary, McapSummary { topics: 4, messages: 7 });
        let messages: Vec<(String, u64, Value)> = mcap::MessageStream::new(&bytes)
            .unwrap()
            .map(|message| {
                let message = message.unwrap();
                let data = serde_json::from_slice(&message.data).unwrap();
                (message.channel.topic.clone(), message.log_time, data)
            })
            .collect();
        let of = |topic: &str| -> Vec<(u64, Value)> {
            messages
                .iter()
                .filter(|(t, _, _)| t == topic)
                .map(|(_, time, data)| (*time, data.clone()))
                .collect()
        };
        assert_eq!(of("/gps"), vec![(0, json!({"gps_alt_m": 100.125, "gps_sats": 9.0}))]);
        assert_eq!(
            of("/baro"),
            vec![
                (0, json!({"baro_alt_m": 101.1})),
                (5_000_000, json!({"baro_alt_m": null})),
                (10_000_000, json!({"baro_alt_m": 102.3})),
            ]
        );
        assert_eq!(of("/extra"), vec![(5_000_000, json!({"flap_deg": 3.0}))]);
        assert_eq!(of("/launch").len(), 2);
        let read = mcap::Summary::read(&bytes).unwrap().unwrap();
        assert_eq!(read.stats.unwrap().message_count, 7);
        assert_eq!(read.metadata_indexes[0].name, "pylon-flight");
    }
}
