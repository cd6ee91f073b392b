//! Reads MCAP written by `pylon export` back as the original flight.
//!
//! Every topic's JSON messages have the flight's columns as keys; messages of the same time are one row. A
//! value that is not finite was written as null, and is read as NaN; rows without a sample were not written.

use std::collections::{BTreeMap, BTreeSet};

use crc::{CRC_32_ISO_HDLC, Crc};
use mcap::parse_record;
use mcap::records::{Record, op};
use serde_json::Value;

use super::own_header::{own_header, put_column};
use super::{ImportError, Importer};
use flight_data::{Column, Flight, Header, MAX_TIME_S, Note};

/// First bytes of every MCAP file.
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
                "messages that are not rows of a flight, left out: {} of {}",
                reader.unread, reader.messages
            )));
        }
        let flight = reader.flight(header, &mut notes);
        Ok((flight, notes))
    }
}

/// Walks over the records (<https://mcap.dev/spec>): a byte that gives the kind, the length in eight bytes,
/// and that many bytes. The crate's own readers subtract without checking if a damaged chunk's lengths
/// contradict each other.
///
/// What cannot be read is added to `damage`.
fn records(mut bytes: &[u8], damage: &mut Vec<String>, take: &mut dyn FnMut(Record<'_>)) {
    while let Some((head, rest)) = bytes.split_first_chunk::<9>() {
        let [kind, length @ ..] = *head;
        let length = usize::try_from(u64::from_le_bytes(length)).unwrap_or(usize::MAX);
        let Some((body, rest)) = rest.split_at_checked(length) else {
            damage.push("it ends within a record".to_owned());
            return;
        };
        bytes = rest;
        // Other records are not needed, and the crate panics on an attachment shorter than its own header.
        if !matches!(kind, op::METADATA | op::CHUNK | op::MESSAGE | op::DATA_END) {
            continue;
        }
        if !has_its_texts(kind, body) {
            damage.push("a record's texts are longer than the record".to_owned());
            continue;
        }
        match parse_record(kind, body) {
            Ok(Record::DataEnd(_)) => return,
            Ok(record) => take(record),
            Err(error) => damage.push(error.to_string()),
        }
    }
}

/// A text, preceded by its length in four bytes; and the bytes after it.
fn text(bytes: &[u8]) -> Option<(&[u8], &[u8])> {
    let (length, rest) = bytes.split_first_chunk()?;
    rest.split_at_checked(usize::try_from(u32::from_le_bytes(*length)).ok()?)
}

/// Whether the texts of a record are within it: the crate allocates the given length before it checks.
fn has_its_texts(kind: u8, body: &[u8]) -> bool {
    /// Bytes of a chunk before the name of its compression.
    const CHUNK_HEAD: usize = 28;
    match kind {
        op::METADATA => text(body).and_then(|(_, rest)| text(rest)).is_some_and(|(mut pairs, _)| {
            // For a key without a value, the crate would read one from the bytes that follow.
            while let Some((_, rest)) = text(pairs).and_then(|(_, value)| text(value)) {
                pairs = rest;
            }
            pairs.is_empty()
        }),
        op::CHUNK => body.get(CHUNK_HEAD..).is_some_and(|rest| text(rest).is_some()),
        _ => true,
    }
}

/// As [`records`], for a whole file, most of whose records are in chunks. A chunk with a wrong checksum is
/// left out.
fn all_records(bytes: &[u8], damage: &mut Vec<String>, take: &mut dyn FnMut(Record<'_>)) {
    let mut of_chunks = Vec::new();
    records(bytes, damage, &mut |record| match record {
        Record::Chunk { header, .. } if !header.compression.is_empty() => {
            of_chunks.push("a chunk is compressed, which Pylon's never are".to_owned());
        }
        Record::Chunk { header, data } => {
            let expected = header.uncompressed_crc;
            if expected != 0 && expected != Crc::<u32>::new(&CRC_32_ISO_HDLC).checksum(&data) {
                of_chunks.push(format!("a chunk of {} bytes has a wrong checksum", data.len()));
            } else {
                // Chunks do not contain chunks.
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
    /// For each column, the rows that have a cell.
    cells: BTreeMap<String, Vec<(usize, f64)>>,
    /// The columns of the newest row.
    in_row: BTreeSet<String>,
    messages: usize,
    unread: usize,
}

impl Reader {
    fn take(&mut self, record: Record<'_>) {
        match record {
            Record::Metadata(metadata) if metadata.name == "pylon-flight" => {
                self.header = Some(own_header(metadata.metadata));
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
        // A `foxglove.LocationFix` only repeats the columns.
        if cells.get("frame_id").is_some_and(Value::is_string) {
            return;
        }
        let is_new =
            self.time_s.last() != Some(&time_s) || cells.keys().any(|name| self.in_row.contains(name));
        if is_new {
            self.time_s.push(time_s);
            self.in_row.clear();
        }
        let row = self.time_s.len() - 1;
        for (name, cell) in cells {
            let value = cell.as_f64().unwrap_or(f64::NAN);
            self.in_row.insert(name.clone());
            self.cells.entry(name.clone()).or_default().push((row, value));
        }
    }

    fn flight(self, header: Header, notes: &mut Vec<Note>) -> Flight {
        let rows = self.time_s.len();
        let mut flight = Flight { header, time_s: self.time_s, ..Flight::default() };
        for (name, cells) in self.cells {
            let mut column = Column::empty_named(&name, rows);
            for (row, value) in cells {
                column.set_f64(row, Some(value));
            }
            notes.extend(put_column(&mut flight, &name, column));
        }
        flight
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::export::mcap::write;
    use flight_data::parse;

    const FLIGHT: &str = "# pylon-flight: 1\n# vehicle: test\n# source: made for a test\n# altitude_datum: ellipsoid\n# campaign: \
        x\ntime_s,launch,gps_alt_m,gps_sats,baro_alt_m,flap_deg\n0,0,100.125,9,101.1,\n0.005,,,,nan,3\n0.01,1,,,102.3,\n0.01,1,,,102.4,\n";

    fn exported() -> Vec<u8> {
        let mut bytes = Vec::new();
        write(&mut bytes, &parse(FLIGHT.as_bytes()).unwrap().0).unwrap();
        bytes
    }

    #[test]
    fn what_was_exported_comes_back_byte_for_byte() {
        assert_eq!(crate::import::testing::written(&exported()), FLIGHT);
    }

    /// Found by fuzzing: a header of 39 bytes that declared a text of 2.3 GB, for which memory was allocated.
    #[test]
    fn no_room_is_made_for_texts_that_are_not_there() {
        let said = |kind: u8, body: &[u8]| {
            let record = [&[kind][..], &(body.len() as u64).to_le_bytes(), body].concat();
            let (mut damage, mut taken) = (Vec::new(), 0);
            records(&record, &mut damage, &mut |_| taken += 1);
            (damage.concat(), taken)
        };
        let longer = 0x8900_0000_u32.to_le_bytes();
        let name = [&4_u32.to_le_bytes()[..], b"name"].concat();
        let pair = [&name[..], &name].concat();
        let whole = [&name[..], &(pair.len() as u32).to_le_bytes(), &pair].concat();
        assert_eq!(said(op::METADATA, &whole), (String::new(), 1));
        let refused = ("a record's texts are longer than the record".to_owned(), 0);
        assert_eq!(said(op::METADATA, &longer), refused);
        assert_eq!(said(op::METADATA, &[&name[..], &longer].concat()), refused);
        let within = [&name[..], &8_u32.to_le_bytes(), &longer, &longer].concat();
        assert_eq!(said(op::METADATA, &within), refused);
        // A key whose value would be what follows the pairs.
        let odd = [&name[..], &(name.len() as u32).to_le_bytes(), &name, &longer].concat();
        assert_eq!(said(op::METADATA, &odd), refused);
        assert_eq!(said(op::CHUNK, &[&[0; 28][..], &longer].concat()), refused);
        assert_eq!(said(op::HEADER, &longer), (String::new(), 0));
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
        assert!(matches!(Mcap.import(b"\x89MCAP0\r\n").unwrap_err(), ImportError::ForeignMcap));
    }
}
