//! The emulation's input and output files.

use std::fs::File;
use std::io::{BufReader, BufWriter, Read, Write};
use std::path::Path;

use flight_record::{
    Decoder, Encoder, End, Header, Kind, MAX_STUFFED, Payload, SensorSource, Stream, Summary, TickRecord,
};
use kf_core::latch::LatchRecord;
use survival::RestartReport;

use super::error::{FlyError, ResultsError};
use super::fault_script::Item;

/// Bytes read at a time.
const CHUNK: usize = 64 * 1024;

/// Writes a whole flight record and returns how many inputs it holds.
pub(super) fn write_inputs(
    path: &Path,
    model: u64,
    sensors: SensorSource,
    items: impl Iterator<Item = Item>,
) -> Result<u32, FlyError> {
    let file = File::create(path).map_err(FlyError::io(path.display().to_string()))?;
    let mut writer = Writer { file: BufWriter::new(file), path, encoder: Encoder::new() };
    writer.write(&Header::new(Stream::Inputs, model, sensors))?;
    let mut count = 0_u32;
    for item in items {
        let input = match item {
            Item::Fault(fault) => {
                writer.write(&fault)?;
                continue;
            }
            Item::Tick(input) => input,
        };
        writer.write(&input)?;
        count = count.checked_add(1).ok_or(FlyError::TooManyRows)?;
    }
    writer.write(&End { inputs: count })?;
    writer.file.flush().map_err(FlyError::io(path.display().to_string()))?;
    Ok(count)
}

struct Writer<'a> {
    file: BufWriter<File>,
    path: &'a Path,
    encoder: Encoder,
}

impl Writer<'_> {
    fn write<P: Payload>(&mut self, payload: &P) -> Result<(), FlyError> {
        let mut buffer = [0; MAX_STUFFED];
        let frame = self.encoder.encode(payload, &mut buffer).map_err(|_| FlyError::TickTooLong)?;
        self.file.write_all(frame).map_err(FlyError::io(self.path.display().to_string()))
    }
}

/// One result of the flight computer.
#[derive(Clone, Debug, PartialEq)]
pub enum FlightResult {
    /// The output of a tick.
    Tick(TickRecord),
    /// The calibration, after the tick that latched it.
    Latch(LatchRecord),
    /// The flight computer has restarted; what follows is from after the restart.
    Restart(RestartReport),
    /// The counters; the last result.
    Summary(Summary),
}

/// The results of an emulation, read on demand.
pub struct Results {
    file: BufReader<File>,
    decoder: Decoder,
    header: Option<Header>,
}

impl Results {
    /// Opens the file that the firmware wrote.
    pub(super) fn open(path: &Path) -> Result<Self, FlyError> {
        let file = File::open(path).map_err(FlyError::io(path.display().to_string()))?;
        Ok(Self { file: BufReader::with_capacity(CHUNK, file), decoder: Decoder::new(), header: None })
    }

    /// The next result; `None` at the end of the file.
    ///
    /// # Errors
    /// [`FlyError::Results`] for anything that is not a result, or if a result before it is missing.
    pub fn next_result(&mut self) -> Result<Option<FlightResult>, FlyError> {
        loop {
            let mut byte = [0];
            let read = self.file.read(&mut byte).map_err(FlyError::io("reading the results"))?;
            if read == 0 {
                if self.decoder.is_inside_frame() {
                    return Err(ResultsError::Cut.into());
                }
                return Ok(None);
            }
            let pushed = self.decoder.push(byte[0]);
            let frame = pushed.map_err(ResultsError::Frame)?;
            let Some(frame) = frame else { continue };
            if frame.missed > 0 {
                return Err(ResultsError::Missing(frame.missed).into());
            }
            let bad_payload = |error| FlyError::Results(ResultsError::Payload(error));
            match (frame.kind, self.header) {
                // A later header: the flight computer has restarted.
                (Kind::Header, _) => {
                    let header: Header = frame.payload().map_err(bad_payload)?;
                    if header != Header::new(Stream::Outputs, header.model, header.sensors) {
                        return Err(ResultsError::Version.into());
                    }
                    self.header = Some(header);
                }
                (_, None) => return Err(ResultsError::NoHeader.into()),
                (Kind::Tick, _) => {
                    return frame.payload().map(FlightResult::Tick).map(Some).map_err(bad_payload);
                }
                (Kind::Latch, _) => {
                    return frame.payload().map(FlightResult::Latch).map(Some).map_err(bad_payload);
                }
                (Kind::Summary, _) => {
                    return frame.payload().map(FlightResult::Summary).map(Some).map_err(bad_payload);
                }
                (Kind::Restart, _) => {
                    return frame.payload().map(FlightResult::Restart).map(Some).map_err(bad_payload);
                }
                (kind @ (Kind::Input | Kind::ChipFault | Kind::End), _) => {
                    return Err(ResultsError::Misplaced(kind).into());
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use flight_record::FrameError;

    use super::*;

    /// The error that reading these bytes as results ends with.
    fn read(bytes: &[u8]) -> FlyError {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), bytes).unwrap();
        let mut results = Results::open(file.path()).unwrap();
        loop {
            match results.next_result() {
                Ok(Some(_)) => {}
                Ok(None) => panic!("they are whole"),
                Err(error) => return error,
            }
        }
    }

    /// The frames of some payloads, one after another.
    fn frames(stream: Stream, ends: u32) -> Vec<Vec<u8>> {
        let (mut encoder, mut buffer) = (Encoder::new(), [0; MAX_STUFFED]);
        let header = Header::new(stream, 7, SensorSource::Ideal);
        let mut all = vec![encoder.encode(&header, &mut buffer).unwrap().to_vec()];
        for inputs in 0..ends {
            all.push(encoder.encode(&End { inputs }, &mut buffer).unwrap().to_vec());
        }
        all
    }

    #[test]
    fn damaged_results_say_how() {
        let whole = frames(Stream::Outputs, 2);
        let cut = &whole.concat()[..3];
        let mut spoilt = whole[0].clone();
        let middle = spoilt.len() / 2;
        spoilt[middle] ^= 0x10;
        for (bytes, expected, words) in [
            (cut.to_vec(), ResultsError::Cut, "the last one is cut"),
            (spoilt, ResultsError::Frame(FrameError::Check), "a frame's checksum is wrong"),
            (whole[1].clone(), ResultsError::Missing(1), "1 are missing"),
            (
                frames(Stream::Inputs, 0).concat(),
                ResultsError::Version,
                "they are of another version of the format",
            ),
            (whole[..2].concat(), ResultsError::Misplaced(Kind::End), "a frame is out of place"),
        ] {
            let error = read(&bytes);
            assert!(matches!(&error, FlyError::Results(found) if *found == expected), "{error:?}");
            assert_eq!(error.to_string(), format!("the results of the flight computer are damaged: {words}"));
            let source = std::error::Error::source(&error).and_then(|source| source.downcast_ref());
            assert_eq!(source, Some(&expected));
        }
    }
}
