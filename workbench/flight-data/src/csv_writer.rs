//! Writing a flight as CSV.

use std::collections::BTreeSet;
use std::io::{self, Write};

use super::column::Column;
use super::error::FlightError;
use super::names;
use super::{Channel, Flight, MAX_TIME_S};

/// Bytes of rows that are written at once.
const WRITTEN_AT_ONCE: usize = 1 << 16;
/// Smaller numbers have no exponent or a negative one.
const LARGE: f32 = 1e12;

/// Writes a flight as CSV text: the known channels in the order of [`Channel::ALL`], then the others.
///
/// # Errors
/// Errors of `out`; [`io::ErrorKind::InvalidInput`] with a [`FlightError`] for a flight whose text would not
/// read back as the same flight. In that case nothing is written.
pub fn to_writer<W: Write>(out: W, flight: &Flight) -> io::Result<()> {
    check(flight).map_err(|error| io::Error::new(io::ErrorKind::InvalidInput, error))?;
    let mut out = out;
    write_header(&mut out, flight)?;
    let known = Channel::ALL
        .iter()
        .filter_map(|channel| flight.channel(*channel).map(|column| (channel.name(), column)));
    let extra = flight.extra.iter().map(|(name, column)| (name.as_str(), column));
    let (names, columns): (Vec<&str>, Vec<&Column>) = known.chain(extra).unzip();

    let mut csv = csv::WriterBuilder::new().from_writer(Vec::new());
    csv.write_record(std::iter::once(names::TIME).chain(names))?;
    let mut text = csv.into_inner().map_err(csv::IntoInnerError::into_error)?;
    // A number needs no quotes, and every row has its time: most of the text need not be searched for
    // characters to escape.
    let mut buffer = zmij::Buffer::new();
    let mut marks = Marks::new(&columns);
    for (row, time_s) in flight.time_s.iter().enumerate() {
        put(&mut text, buffer.format(*time_s), false);
        // Most cells are empty: their commas are written with the next cell that is not.
        let mut written = 0;
        marks.each_sample(row, |place, column| {
            text.resize(text.len() + place + 1 - written, b',');
            written = place + 1;
            if column.is_double() {
                let value = column.get_f64(row).unwrap_or(f64::NAN);
                put(&mut text, buffer.format(value), value.abs() >= f64::from(LARGE));
            } else {
                let value = column.get(row).unwrap_or(f32::NAN);
                put(&mut text, buffer.format(value), value.abs() >= LARGE);
            }
        });
        text.resize(text.len() + columns.len() - written, b',');
        text.push(b'\n');
        if text.len() >= WRITTEN_AT_ONCE {
            out.write_all(&text)?;
            text.clear();
        }
    }
    out.write_all(&text)?;
    out.flush()
}

/// Which columns have a sample in which row, found for a block of rows one column after another: a column is
/// contiguous in memory, a row is not.
struct Marks<'a> {
    columns: &'a [&'a Column],
    /// For each row of the block, bits for 64 columns, then those for the next 64, ...
    bits: Vec<u64>,
}

/// Rows of a block.
const BLOCK: usize = 256;

impl<'a> Marks<'a> {
    fn new(columns: &'a [&'a Column]) -> Self {
        Self { columns, bits: vec![0; BLOCK * columns.len().div_ceil(64)] }
    }

    /// Passes on every column with a sample in a row, and its index. Rows must be requested in order, from
    /// the first.
    fn each_sample(&mut self, row: usize, mut take: impl FnMut(usize, &Column)) {
        if row.is_multiple_of(BLOCK) {
            self.bits.fill(0);
            for (columns, bits) in self.columns.chunks(64).zip(self.bits.chunks_mut(BLOCK)) {
                for (column, bit) in columns.iter().zip(0..) {
                    column.mark_samples(row..(row + BLOCK).min(column.len()), bit, bits);
                }
            }
        }
        for (block, (columns, bits)) in self.columns.chunks(64).zip(self.bits.chunks(BLOCK)).enumerate() {
            let mut left = bits.get(row % BLOCK).copied().unwrap_or(0);
            while left != 0 {
                let bit = left.trailing_zeros() as usize;
                left &= left - 1;
                if let Some(column) = columns.get(bit) {
                    take(block * 64 + bit, column);
                }
            }
        }
    }
}

/// Appends a number without the `.0` of whole ones and without the plus sign of a large number's exponent;
/// `nan` in lower case, as the format requires.
fn put(text: &mut Vec<u8>, number: &str, is_large: bool) {
    if number == "NaN" {
        text.extend_from_slice(b"nan");
    } else if let Some((before, after)) = is_large.then(|| number.split_once('+')).flatten() {
        text.extend_from_slice(before.as_bytes());
        text.extend_from_slice(after.as_bytes());
    } else {
        text.extend_from_slice(number.strip_suffix(".0").unwrap_or(number).as_bytes());
    }
}

fn write_header<W: Write>(out: &mut W, flight: &Flight) -> io::Result<()> {
    let header = &flight.header;
    writeln!(out, "# pylon-flight: 1")?;
    for (key, value) in [("vehicle", &header.vehicle), ("source", &header.source)] {
        if !value.trim().is_empty() {
            writeln!(out, "# {key}: {}", value.trim())?;
        }
    }
    writeln!(out, "# altitude_datum: {}", header.altitude_datum.name())?;
    for (key, value) in &header.other {
        match (key.trim(), value.trim()) {
            ("", "") => writeln!(out, "#")?,
            // After an empty key, so that the text before the remark's colon does not become a key.
            ("", remark) if remark.contains(':') => writeln!(out, "# : {remark}")?,
            ("", remark) => writeln!(out, "# {remark}")?,
            (key, "") => writeln!(out, "# {key}:")?,
            (key, value) => writeln!(out, "# {key}: {value}")?,
        }
    }
    Ok(())
}

fn check(flight: &Flight) -> Result<(), FlightError> {
    let expected = flight.rows();
    let known = flight.channels.iter().map(|(channel, column)| (channel.name(), column));
    let extra = flight.extra.iter().map(|(name, column)| (name.as_str(), column));
    let mut seen = BTreeSet::from([names::TIME]);
    for (name, column) in known.chain(extra) {
        if column.len() != expected {
            return Err(FlightError::Ragged { column: name.to_owned(), found: column.len(), expected });
        }
        let reason = if seen.contains(name) {
            "another column has that name"
        } else if name.trim() != name || name.is_empty() || name.contains(['\n', '\r', '\0']) {
            "it is empty, or has spaces around it, or a line end in it"
        } else {
            seen.insert(name);
            continue;
        };
        return Err(FlightError::Text { what: "the column name", text: name.to_owned(), reason });
    }
    if let Some((index, found)) =
        flight.time_s.iter().copied().enumerate().find(|(_, time)| !(0.0..=MAX_TIME_S).contains(time))
    {
        return Err(FlightError::Time { index, found });
    }
    let text = |what, text: &str, reason| FlightError::Text { what, text: text.to_owned(), reason };
    let values = [&flight.header.vehicle, &flight.header.source];
    for value in values.into_iter().chain(flight.header.other.iter().map(|(_, value)| value)) {
        if value.contains(['\n', '\r']) {
            return Err(text("the value", value, "it has a line end in it"));
        }
    }
    for (key, _) in &flight.header.other {
        if key.contains(['\n', '\r', ':']) {
            return Err(text("the key", key, "it has a colon or a line end in it"));
        }
        if matches!(key.trim(), "pylon-flight" | "vehicle" | "source" | "altitude_datum") {
            return Err(text("the key", key, "it has a field of its own"));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{AltitudeDatum, Header, parse};

    fn flight() -> Flight {
        let mut flight = Flight {
            header: Header {
                vehicle: "drop model".into(),
                source: "written by hand".into(),
                altitude_datum: AltitudeDatum::Ellipsoid,
                other: vec![("site".into(), "a: b".into()), (String::new(), "a remark".into())],
            },
            time_s: vec![0.0, 0.005, 1e-7],
            ..Flight::default()
        };
        for (channel, cells) in [
            (Channel::BaroPa, [Some(101_325.0), None, Some(-0.0)]),
            (Channel::GpsAltM, [None, Some(f32::NAN), Some(f32::NEG_INFINITY)]),
        ] {
            let mut column = Column::default();
            cells.into_iter().for_each(|cell| column.push(cell));
            flight.set_channel(channel, column);
        }
        let mut column = Column::default();
        [Some(0.1), Some(1e16), Some(1.175_494_4e-38)].into_iter().for_each(|cell| column.push(cell));
        flight.extra.push(("flap, left".into(), column));
        flight
    }

    fn text(flight: &Flight) -> String {
        let mut out = Vec::new();
        to_writer(&mut out, flight).unwrap();
        String::from_utf8(out).unwrap()
    }

    #[test]
    fn writes_the_format_with_as_few_digits_as_give_the_value_back() {
        assert_eq!(
            text(&flight()),
            "# pylon-flight: 1\n# vehicle: drop model\n# source: written by hand\n# altitude_datum: ellipsoid\n\
             # site: a: b\n# a remark\ntime_s,gps_alt_m,baro_pa,\"flap, left\"\n0,,101325,0.1\n0.005,nan,,1e16\n\
             1e-7,-inf,-0,1.1754944e-38\n"
        );
    }

    /// A remark with a colon (found by fuzzing: an empty key) does not become a key when it is written and
    /// read again.
    #[test]
    fn a_remark_with_a_colon_stays_one() {
        let mut flight = flight();
        flight.header.other = vec![(String::new(), "taken at 12:30".to_owned())];
        let written = text(&flight);
        assert_eq!(parse(written.as_bytes()).unwrap().0.header, flight.header);
    }

    #[test]
    fn what_it_wrote_reads_back_byte_for_byte() {
        let written = text(&flight());
        let (read, notes) = parse(written.as_bytes()).unwrap();
        assert_eq!(notes, []);
        assert_eq!(read.header, flight().header);
        assert_eq!(text(&read), written);
    }

    #[test]
    fn refuses_a_flight_that_would_read_back_as_another_and_writes_nothing() {
        let refused = |change: fn(&mut Flight)| {
            let mut flight = flight();
            change(&mut flight);
            let mut out = Vec::new();
            let error = to_writer(&mut out, &flight).unwrap_err();
            assert_eq!((error.kind(), out.len()), (io::ErrorKind::InvalidInput, 0));
            error.to_string()
        };
        assert_eq!(
            refused(|flight| flight.time_s.push(2.0)),
            "column baro_pa has 3 cells, expected 4, one a row"
        );
        assert!(
            refused(|flight| flight.time_s[1] = f64::NAN).starts_with("row 1 of the flight has time NaN s")
        );
        assert!(refused(|flight| flight.time_s[0] = -1.0).contains("time -1 s"));
        assert!(refused(|flight| flight.extra[0].0 = "baro_pa".into()).contains("another column"));
        assert!(refused(|flight| flight.extra[0].0 = "a\nb".into()).contains("line end"));
        assert!(refused(|flight| flight.header.vehicle = "a\n# b".into()).contains("line end"));
        assert!(refused(|flight| flight.header.other[0].0 = "a:b".into()).contains("colon"));
        assert!(refused(|flight| flight.header.other[0].0 = "source".into()).contains("field of its own"));
    }
}
