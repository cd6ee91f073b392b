//! The results line.

use flight_record::{Encoder, ExitStatus, Header, MAX_STUFFED, Payload, SensorSource, Stream};
use stm32f4xx_hal::nb;
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::rcc::Rcc;
use stm32f4xx_hal::serial::{Config, Tx};

use super::wiring::{RESULTS_BAUD, ResultsTx, ResultsUart};
use flown_mission::FINGERPRINT;

/// Sends results, each a frame of the flight record.
pub struct Sink {
    line: Tx<ResultsUart>,
    encoder: Encoder,
    failed: bool,
}

impl Sink {
    pub(super) fn start(usart: ResultsUart, pin: ResultsTx, rcc: &mut Rcc) -> Result<Self, ExitStatus> {
        let config = Config::default().baudrate(RESULTS_BAUD.bps());
        let line = usart.tx(pin, config, rcc).map_err(|_| ExitStatus::NoOutput)?;
        let mut sink = Self { line, encoder: Encoder::new(), failed: false };
        // A reset may have cut a frame. Without a zero before it, the header would be appended to that frame
        // and lost with it.
        sink.failed = !sink.send(&[0]);
        sink.write(&Header::new(Stream::Outputs, FINGERPRINT, SensorSource::Chips));
        Ok(sink)
    }

    /// Sends one result; waits for the line, and the ticks preempt the wait. A failure shows in
    /// [`Self::status`].
    pub fn write<P: Payload>(&mut self, payload: &P) {
        let mut buffer = [0; MAX_STUFFED];
        let sent = match self.encoder.encode(payload, &mut buffer) {
            Ok(bytes) => self.send(bytes),
            Err(_) => false,
        };
        self.failed |= !sent;
    }

    /// Byte by byte, because the HAL's `embedded_io::Write` reports zero bytes written when the line is busy,
    /// on which its `write_all` panics.
    fn send(&mut self, bytes: &[u8]) -> bool {
        bytes.iter().all(|&byte| nb::block!(self.line.write(byte)).is_ok())
    }

    /// How the flight ended.
    pub const fn status(&self) -> ExitStatus {
        if self.failed { ExitStatus::NoOutput } else { ExitStatus::Finished }
    }
}
