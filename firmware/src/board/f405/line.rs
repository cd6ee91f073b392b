//! The telemetry line: USART1's transmitter, fed by DMA.
//!
//! Stream and channel are part of [`Transfer`]'s type. It compiles only if the HAL's table of RM0090's
//! mapping contains this combination.

use embedded_dma::ReadBuffer;
use stm32f4xx_hal::dma::config::DmaConfig;
use stm32f4xx_hal::dma::{DmaFlag, MemoryToPeripheral, Transfer};
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::rcc::Rcc;
use stm32f4xx_hal::serial::{self, Tx};
use telemetry::Frame;

use super::wiring::{TELEMETRY_CHANNEL, TelemetryStream, TelemetryTx, TelemetryUart};
use crate::downlink::BAUD;

/// A frame that the DMA reads; it does not move during the transfer.
struct Loaded(&'static mut Frame);

// SAFETY: the frame is static, so it is neither moved nor dropped. The pointer and the length are those of a
// slice of it, which nothing writes to while the transfer holds it.
unsafe impl ReadBuffer for Loaded {
    type Word = u8;

    unsafe fn read_buffer(&self) -> (*const u8, usize) {
        let bytes = self.0.bytes();
        (bytes.as_ptr(), bytes.len())
    }
}

/// The telemetry line.
pub struct Line {
    transfer: Transfer<TelemetryStream, TELEMETRY_CHANNEL, Tx<TelemetryUart>, MemoryToPeripheral, Loaded>,
    /// The frame that the DMA does not hold; only a DMA error could keep both.
    spare: Option<Loaded>,
    busy: bool,
}

impl Line {
    /// Takes the UART, its pin, its stream and two frames to send from; `None` if the USART cannot be set to
    /// [`BAUD`].
    pub fn start(
        usart: TelemetryUart,
        pin: TelemetryTx,
        stream: TelemetryStream,
        frames: &'static mut [Frame; 2],
        rcc: &mut Rcc,
    ) -> Option<Self> {
        let config = serial::Config::default().baudrate(BAUD.bps()).dma(serial::config::DmaConfig::Tx);
        let usart = usart.tx(pin, config, rcc).ok()?;
        let config = DmaConfig::default()
            .memory_increment(true)
            .transfer_complete_interrupt(true)
            .transfer_error_interrupt(true);
        let [first, second] = frames;
        let transfer = Transfer::init_memory_to_peripheral(stream, usart, Loaded(first), None, config);
        Some(Self { transfer, spare: Some(Loaded(second)), busy: false })
    }

    /// Whether the next frame can be sent; called by the interrupt, which may also have been pended by
    /// software.
    pub fn is_free(&mut self) -> bool {
        // A frame on which the DMA failed is lost; the receiver notices the missing sequence number.
        if self.busy && (self.transfer.is_transfer_complete() || self.transfer.is_transfer_error()) {
            self.transfer.clear_flags(DmaFlag::TransferComplete | DmaFlag::TransferError);
            self.busy = false;
        }
        !self.busy
    }

    /// Sends a frame on a free line.
    pub fn send(&mut self, frame: &Frame) {
        let Some(next) = self.spare.take() else { return };
        *next.0 = *frame;
        match self.transfer.next_transfer(next) {
            Ok((sent, _)) => {
                self.spare = Some(sent);
                self.busy = true;
            }
            // Without double buffering this error cannot occur. If it did, the frame would be lost and the
            // next one tried.
            Err(error) => self.spare = Some(returned(error)),
        }
    }
}

fn returned(error: stm32f4xx_hal::dma::DMAError<Loaded>) -> Loaded {
    use stm32f4xx_hal::dma::DMAError::{NotReady, Overrun, SmallBuffer};
    match error {
        NotReady(frame) | SmallBuffer(frame) | Overrun(frame) => frame,
    }
}
