//! A UART whose receiver a DMA stream empties into a ring: no byte costs an interrupt, and none is lost while
//! a tick computes. At each tick the driver takes what has arrived.
//!
//! # Errors
//! [`RingReader`] defines them. Each is counted ([`LineCounts`]) and discards what has arrived so far: a
//! frame is broken in any case, and the driver finds the next one.

use core::sync::atomic::{AtomicU8, AtomicU32, Ordering, fence};

use drivers::{RingError, RingReader, ublox, umbilical};
use embedded_io::ErrorKind;
use stm32f4xx_hal::ReadFlags;
use stm32f4xx_hal::dma::config::Priority;
use stm32f4xx_hal::dma::traits::{Channel, DMASet, Direction, PeriAddress};
use stm32f4xx_hal::dma::{ChannelX, DmaDataSize, DmaFlag, PeripheralToMemory};
use stm32f4xx_hal::nb;
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::serial::{Flag, Instance, Rx, RxISR, Serial, TxISR};

use super::clock::CostClock;
use super::wiring;

/// Bytes of a ring: 22 ms at 115,200 baud, so that ticks may come 11 ms apart.
const RING_BYTES: usize = 256;
// One poll must be able to take what has arrived in that time.
const _: () = assert!(
    arrived(wiring::RECEIVER_BAUD) <= ublox::MAX_POLL_BYTES
        && arrived(wiring::UMBILICAL_BAUD) <= umbilical::MAX_POLL_BYTES
);
/// Bits per byte on the line: start, data, stop.
const BITS: u64 = 10;

/// Bytes that arrive in 11 ms.
const fn arrived(baud: u32) -> usize {
    baud as usize / BITS as usize * 11 / 1_000
}

/// The memory that the DMA writes to.
pub type Ring = [AtomicU8; RING_BYTES];

/// An empty ring.
pub const fn ring() -> Ring {
    [const { AtomicU8::new(0) }; RING_BYTES]
}

/// Errors on a line since power-up. All counts saturate.
pub struct LineCounts {
    /// Polls that found a framing error or an overrun of the receiver: a wrong rate, a loose wire.
    pub broken: AtomicU32,
    /// Polls so late that bytes may have been overwritten.
    pub late: AtomicU32,
    /// Times that the DMA stream had stopped and was restarted.
    pub stopped: AtomicU32,
}

impl LineCounts {
    /// No errors yet.
    pub const fn new() -> Self {
        Self { broken: AtomicU32::new(0), late: AtomicU32::new(0), stopped: AtomicU32::new(0) }
    }
}

/// Increments a counter. Only the tick writes these.
fn count(counter: &AtomicU32) {
    counter.store(counter.load(Ordering::Relaxed).saturating_add(1), Ordering::Relaxed);
}

/// The line.
pub struct Port<UART: Instance, Stream> {
    serial: Serial<UART>,
    stream: Stream,
    ring: &'static Ring,
    counts: &'static LineCounts,
    reader: RingReader<RING_BYTES>,
}

impl<UART: Instance, Stream: stm32f4xx_hal::dma::traits::Stream> Port<UART, Stream> {
    /// Takes a UART that has been set up to receive by DMA. It compiles only with the UART's own stream and
    /// channel.
    pub fn start<const CHANNEL: u8>(
        serial: Serial<UART>,
        mut stream: Stream,
        ring: &'static Ring,
        counts: &'static LineCounts,
        baud: u32,
    ) -> Self
    where
        ChannelX<CHANNEL>: Channel,
        Rx<UART>: DMASet<Stream, CHANNEL, PeripheralToMemory>,
    {
        let receiver: &Rx<UART> = serial.as_ref();
        // RM0090, 10.3.17, for a stream that a reset has stopped. In direct mode a byte that has been counted
        // is not held back in the FIFO.
        stream.set_peripheral_address(receiver.address());
        stream.set_channel(ChannelX::<CHANNEL>::VALUE);
        stream.set_direction(PeripheralToMemory::direction());
        stream.set_priority(Priority::High);
        stream.set_fifo_enable(false);
        stream.set_memory_increment(true);
        stream.set_circular_mode(true);
        // SAFETY: the data register and the ring are bytes.
        unsafe {
            stream.set_peripheral_size(DmaDataSize::Byte);
            stream.set_memory_size(DmaDataSize::Byte);
        }
        let lap_us = RING_BYTES as u64 * BITS * 1_000_000 / u64::from(baud);
        let mut port =
            Self { serial, stream, ring, counts, reader: RingReader::new(CostClock::time(), lap_us as u32) };
        port.begin();
        port
    }

    /// Starts the stream at the beginning of the ring.
    fn begin(&mut self) {
        self.stream.clear_flags(
            DmaFlag::TransferComplete
                | DmaFlag::HalfTransfer
                | DmaFlag::TransferError
                | DmaFlag::DirectModeError
                | DmaFlag::FifoError,
        );
        self.stream.set_memory_address(self.ring.as_ptr() as u32);
        self.stream.set_number_of_transfers(RING_BYTES as u16);
        // Bytes from before are not needed, but have left an error behind.
        self.serial.clear_idle_interrupt();
        self.reader.restart(CostClock::time());
        // SAFETY: the stream is stopped and set up; the ring is static, and only the stream writes to it.
        unsafe { self.stream.enable() };
    }

    /// Checks how far the DMA has come.
    fn look(&mut self) -> Result<(), ErrorKind> {
        // A bus error stops the stream (RM0090, 10.3.18).
        if !self.stream.is_enabled() {
            count(&self.counts.stopped);
            self.begin();
            return Err(ErrorKind::Other);
        }
        // After counting a byte the DMA needs a few bus cycles to write it to memory. Reading the flags, over
        // the slower peripheral bus, takes longer, and no byte is read earlier. Reading the flags clears
        // them, together with the DMA's next fetch (RM0090, 30.6.1).
        let remaining = self.stream.number_of_transfers();
        let flags = self.serial.flags();
        fence(Ordering::Acquire);
        let has_broken = flags.contains(Flag::FramingError) || flags.contains(Flag::Overrun);
        self.reader.look(CostClock::time(), remaining.into(), has_broken).map_err(|error| match error {
            RingError::Broken => {
                count(&self.counts.broken);
                ErrorKind::InvalidData
            }
            RingError::Late => {
                count(&self.counts.late);
                ErrorKind::Other
            }
        })
    }
}

impl<UART: Instance, Stream> embedded_io::ErrorType for Port<UART, Stream> {
    type Error = ErrorKind;
}

impl<UART: Instance, Stream: stm32f4xx_hal::dma::traits::Stream> embedded_io::ReadReady
    for Port<UART, Stream>
{
    fn read_ready(&mut self) -> Result<bool, ErrorKind> {
        if self.reader.is_empty() {
            self.look()?;
        }
        Ok(!self.reader.is_empty())
    }
}

impl<UART: Instance, Stream: stm32f4xx_hal::dma::traits::Stream> embedded_io::Read for Port<UART, Stream> {
    /// Takes what has arrived, without waiting; it may be 0 bytes.
    fn read(&mut self, bytes: &mut [u8]) -> Result<usize, ErrorKind> {
        let mut taken = 0;
        for byte in bytes {
            let Some(arrived) = self.reader.take().and_then(|place| self.ring.get(place)) else { break };
            *byte = arrived.load(Ordering::Relaxed);
            taken += 1;
        }
        Ok(taken)
    }
}

impl<UART: Instance, Stream> embedded_io::WriteReady for Port<UART, Stream> {
    fn write_ready(&mut self) -> Result<bool, ErrorKind> {
        Ok(self.serial.is_tx_empty())
    }
}

impl<UART: Instance, Stream> embedded_io::Write for Port<UART, Stream> {
    /// Sends one byte; a line that was ready does not wait.
    fn write(&mut self, bytes: &[u8]) -> Result<usize, ErrorKind> {
        let Some(&byte) = bytes.first() else { return Ok(0) };
        nb::block!(self.serial.write(byte)).map_err(|_| ErrorKind::Other)?;
        Ok(1)
    }

    fn flush(&mut self) -> Result<(), ErrorKind> {
        nb::block!(self.serial.flush()).map_err(|_| ErrorKind::Other)
    }
}
