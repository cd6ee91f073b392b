//! MCAP that `pylon export` wrote, as the flight that it was.
//!
//! Every topic's JSON messages have the flight's columns as keys; messages of one time are one row. What is no finite number was
//! written as null, and is read as NaN; rows without a sample were not written.

use std::collections::{BTreeMap, BTreeSet};

use crc::{CRC_32_ISO_HDLC, Crc};
use mcap::parse_record;
use mcap::records::{Record, op};
use serde_json::Value;

use super::{ImportError, Importer};
use crate::flight::{AltitudeDatum, Channel, Column, Flight, Header, MAX_TIME_S, Note};

/// What every MCAP begins with.
const MAGIC: &[u8] = b"\x89MCAP0\r\n";

/// The importer of MCAP.
#[derive(Clone, Copy, Debug)]
pub struct Mcap;

impl Importer for Mcap {
    fn name(&self) -> &'static str {
        "Pylon's MCAP"
    }

    fn recognises(&self, log: &[u8]) -> bool {
        log.starts_with(MAGIC)
    }

    fn import(&self, log: &[u8]) -> Result<(Flight, Vec<Note>), ImportError> {
        let mut reader = Reader::default();
        let mut damage = Vec::new();
        let bytes = log.get(MAGIC.len()..).unwrap_or_default();
        all_records(bytes, &mut damage, &mut |record| reader.take(record));
        let Some(header) = reader.header.take() else { return Err(ImportError::ForeignMcap) };
        let mut notes = Vec::new();
        if let Some(first) = damage.first() {
            let message = format!(
                "damaged: {} places could not be read and were left out; the first: {first}",
                damage.len()
            );
            notes.push(Note::new(message));
        }
        if reader.unread > 0 {
            notes.push(Note::new(format!(
                "messages that are no row of a flight, left out: {} of {}",
                reader.unread, reader.messages
            )));
        }
        Ok((reader.flight(header), notes))
    }
}

/// Goes through the records (<https://mcap.dev/spec>): a byte that says what it is, its length in eight bytes, and so many bytes.
/// The crate's own readers subtract without looking where a damaged chunk's lengths contradict each other.
///
/// What can not be read goes to `damage`.
fn records(mut bytes: &[u8], damage: &mut Vec<String>, take: &mut dyn FnMut(Record<'_>)) {
    while let Some((head, rest)) = bytes.split_first_chunk::<9>() {
        let [kind, length @ ..] = *head;
        let length = usize::try_from(u64::from_le_bytes(length)).unwrap_or(usize::MAX);
        let Some((body, rest)) = rest.split_at_checked(length) else {
            damage.push("it ends within a record".to_owned());
            return;
        };
        bytes = rest;
        // Pylon writes none, and the crate panics on one that is shorter than its own head.
        if kind == op::ATTACHMENT {
            continue;
        }
        match parse_record(kind, body) {
            Ok(Record::DataEnd(_)) => return,
            Ok(record) => take(record),
            Err(error) => damage.push(error.to_string()),
        }
    }
}

/// As [`records`], of a whole file, whose chunks hold most of them. A chunk with a wrong checksum is left out.
fn all_records(bytes: &[u8], damage: &mut Vec<String>, take: &mut dyn FnMut(Record<'_>)) {
    let mut of_chunks = Vec::new();
    records(bytes, damage, &mut |record| match record {
        Record::Chunk { header, .. } if !header.compression.is_empty() => {
            of_chunks.push("a chunk is compressed, which pylon does to none".to_owned());
        }
        Record::Chunk { header, data } => {
            let expected = header.uncompressed_crc;
            if expected != 0 && expected != Crc::<u32>::new(&CRC_32_ISO_HDLC).checksum(&data) {
                of_chunks.push(format!("a chunk of {} bytes has a wrong checksum", data.len()));
            } else {
                // Chunks are not within chunks.
                records(&data, &mut of_chunks, take);
            }
        }
        record => take(record),
    });
    damage.append(&mut of_chunks);
}

#[derive(Default)]
struct Reader {
    header: Option<Header>,
    time_s: Vec<f64>,
    /// Of each column the rows that have a cell.
    cells: BTreeMap<String, Vec<(usize, f32)>>,
    /// The columns that the newest row has.
    in_row: BTreeSet<String>,
    messages: usize,
    unread: usize,
}

impl Reader {
    fn take(&mut self, record: Record<'_>) {
        match record {
            Record::Metadata(metadata) if metadata.name == "pylon-flight" => {
                self.header = Some(header(metadata.metadata));
            }
            Record::Message { header, data } => {
                self.messages += 1;
                let time_s = header.log_time as f64 / 1e9;
                match serde_json::from_slice(&data) {
                    Ok(Value::Object(cells)) if time_s <= MAX_TIME_S => self.row(time_s, &cells),
                    _ => self.unread += 1,
                }
            }
            _ => {}
        }
    }

    fn row(&mut self, time_s: f64, cells: &serde_json::Map<String, Value>) {
        let is_new =
            self.time_s.last() != Some(&time_s) || cells.keys().any(|name| self.in_row.contains(name));
        if is_new {
            self.time_s.push(time_s);
            self.in_row.clear();
        }
        let row = self.time_s.len() - 1;
        for (name, cell) in cells {
            let value = cell.as_f64().map_or(f32::NAN, |value| value as f32);
            self.in_row.insert(name.clone());
            self.cells.entry(name.clone()).or_default().push((row, value));
        }
    }

    fn flight(self, header: Header) -> Flight {
        let rows = self.time_s.len();
        let mut flight = Flight { header, time_s: self.time_s, ..Flight::default() };
        for (name, cells) in self.cells {
            let mut column = Column::empty(rows);
            for (row, value) in cells {
                column.set(row, Some(value));
            }
            match Channel::from_name(&name) {
                Some(channel) => flight.set_channel(channel, column),
                None => flight.extra.push((name, column)),
            }
        }
        flight
    }
}

fn header(mut keys: BTreeMap<String, String>) -> Header {
    // A damaged file may have line ends where a flight's header can have none.
    let clean = |text: String| text.replace(['\n', '\r'], " ");
    let mut take = |key: &str| clean(keys.remove(key).unwrap_or_default());
    let (vehicle, source, datum) = (take("vehicle"), take("source"), take("altitude_datum"));
    let altitude_datum =
        if datum == AltitudeDatum::Ellipsoid.name() { AltitudeDatum::Ellipsoid } else { AltitudeDatum::Msl };
    let other = keys.into_iter().filter(|(key, _)| !key.trim().is_empty() && key.trim() != "pylon-flight");
    let other = other.map(|(key, value)| (clean(key).replace(':', " "), clean(value))).collect();
    Header { vehicle, source, altitude_datum, other }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::export::mcap::write;
    use crate::flight::{parse, to_writer};

    const FLIGHT: &str = "# pylon-flight: 1\n# vehicle: test\n# source: made for a test\n# altitude_datum: ellipsoid\n# campaign: \
        x\ntime_s,launch,gps_alt_m,gps_sats,baro_alt_m,flap_deg\n0,0,100.125,9,101.1,\n0.005,,,,nan,3\n0.01,1,,,102.3,\n0.01,1,,,102.4,\n";

    fn exported() -> Vec<u8> {
        let mut bytes = Vec::new();
        write(&mut bytes, &parse(FLIGHT.as_bytes()).unwrap().0).unwrap();
        bytes
    }

    #[test]
    fn what_was_exported_comes_back_byte_for_byte() {
        let (flight, notes) = crate::import::import(&exported()).unwrap();
        let mut written = Vec::new();
        to_writer(&mut written, &flight).unwrap();
        assert_eq!(String::from_utf8(written).unwrap(), FLIGHT);
        assert_eq!(notes, []);
    }

    #[test]
    fn one_that_is_cut_or_changed_is_read_up_to_there_or_refused() {
        let whole = exported();
        for cut in 0..whole.len() {
            let _ = Mcap.import(&whole[..cut]);
        }
        for at in 0..whole.len() {
            for flip in [1, 0x80, 0xff] {
                let mut bytes = whole.clone();
                bytes[at] ^= flip;
                if let Ok((flight, _)) = Mcap.import(&bytes) {
                    assert!(flight.rows() <= 4);
                }
            }
        }
        assert_eq!(Mcap.import(b"\x89MCAP0\r\n").unwrap_err(), ImportError::ForeignMcap);
    }
}
