//! CSV for programs that expect the column names in the first line: PlotJuggler, spreadsheets.

use std::io::{self, Write};

use flight_data::{Flight, to_writer};

/// Writes a flight's rows without the header lines of [`flight_data`]'s own CSV; empty cells stay empty.
///
/// # Errors
/// Errors of `out`.
pub fn write(out: &mut dyn Write, flight: &Flight) -> io::Result<()> {
    to_writer(&mut WithoutHeader { out, state: State::LineStart }, flight)
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum State {
    /// At the beginning of a header line.
    LineStart,
    /// Within a header line.
    Header,
    /// After the header.
    Body,
}

/// Drops the header lines, which begin with `#`.
struct WithoutHeader<'a> {
    out: &'a mut dyn Write,
    state: State,
}

impl Write for WithoutHeader<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let mut rest = bytes;
        while self.state != State::Body {
            let Some(first) = rest.first() else { return Ok(bytes.len()) };
            if self.state == State::LineStart {
                self.state = if *first == b'#' { State::Header } else { State::Body };
            } else {
                match memchr::memchr(b'\n', rest) {
                    Some(end) => {
                        rest = rest.get(end + 1..).unwrap_or_default();
                        self.state = State::LineStart;
                    }
                    None => return Ok(bytes.len()),
                }
            }
        }
        self.out.write_all(rest)?;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use flight_data::{Channel, Column};

    #[test]
    fn the_names_come_first_and_every_row_after_them() {
        let mut flight = Flight { time_s: vec![0.0, 0.5], ..Flight::default() };
        flight.header.vehicle = "a # b".to_owned();
        let mut column = Column::default();
        column.push(Some(12.5));
        column.push(None);
        flight.set_channel(Channel::GpsAltM, column);
        let mut text = Vec::new();
        write(&mut text, &flight).unwrap();
        assert_eq!(String::from_utf8(text).unwrap(), "time_s,gps_alt_m\n0,12.5\n0.5,\n");
    }
}
