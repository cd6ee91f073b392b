//! The results: a file on the host, frame by frame.

use flight_record::{Encoder, ExitStatus, Header, Kind, MAX_STUFFED, OUTPUT_FILE, Payload, Stream};
use flown_mission::FINGERPRINT;
use heapless::Vec;
use semihosting::fs::File;
use semihosting::io::{Seek, SeekFrom, Write};

use super::machine::BATCH;

/// Writes the results.
pub struct Sink {
    file: File,
    encoder: Encoder,
    /// Results not yet written.
    batch: &'static mut Vec<u8, BATCH>,
    failed: bool,
}

impl Sink {
    /// Begins a stream of outputs for a stream of inputs. After a restart it continues in the same file, with
    /// another header.
    pub(super) fn open(
        inputs: &Header,
        goes_on: bool,
        batch: &'static mut Vec<u8, BATCH>,
    ) -> Result<Self, ExitStatus> {
        let mut options = File::options();
        let options = options.write(true).append(goes_on).truncate(!goes_on);
        let mut file = options.create(true).open(OUTPUT_FILE).map_err(|_| ExitStatus::NoOutput)?;
        if goes_on {
            // QEMU 7.2 opens for appending but then writes at the start.
            file.seek(SeekFrom::End(0)).map_err(|_| ExitStatus::NoOutput)?;
        }
        let mut sink = Self { file, encoder: Encoder::new(), batch, failed: false };
        sink.write(&Header::new(Stream::Outputs, FINGERPRINT, inputs.sensors));
        Ok(sink)
    }

    /// Writes one result; a failure shows in [`Self::status`]. Only ticks may be held back in a batch:
    /// everything else is written at once, so after the summary nothing is left.
    pub fn write<P: Payload>(&mut self, payload: &P) {
        let mut buffer = [0; MAX_STUFFED];
        let written = match self.encoder.encode(payload, &mut buffer) {
            Ok(bytes) if BATCH == 0 => self.file.write_all(bytes).is_ok(),
            Ok(bytes) => self.gather(bytes, P::KIND == Kind::Tick),
            Err(_) => false,
        };
        self.failed |= !written;
    }

    /// Adds to the batch, and writes it if it is full or may not wait.
    fn gather(&mut self, bytes: &[u8], may_wait: bool) -> bool {
        let has_room = self.batch.capacity() - self.batch.len() >= bytes.len();
        let made_room = has_room || self.flush();
        let gathered = self.batch.extend_from_slice(bytes).is_ok();
        let flushed = may_wait || self.flush();
        made_room && gathered && flushed
    }

    fn flush(&mut self) -> bool {
        let written = self.file.write_all(self.batch).is_ok();
        self.batch.clear();
        written
    }

    /// How the flight ended.
    pub const fn status(&self) -> ExitStatus {
        if self.failed { ExitStatus::NoOutput } else { ExitStatus::Finished }
    }
}
