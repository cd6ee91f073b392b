//! Reads the record ahead: bytes of a file on the host in, inputs and faults out, one per tick.

use core::sync::atomic::{AtomicBool, Ordering};

use chip_models::flown::ChipFault;
use flight_record::{Decoder, End, ExitStatus, Header, INPUT_FILE, Kind, Stream, Summary};
use flown_mission::FINGERPRINT;
use heapless::spsc::{Consumer, Producer};
use kf_core::input::TickInput;
use semihosting::fs::File;
use semihosting::io::{Read, Seek, SeekFrom};
use survival::{BOARD, BOARD_WORDS, WordMemory as _};

use super::machine::CHUNK;
use super::{Next, Sensors};
use crate::retained::RetainedWords;

/// Capacity of the inputs read ahead; one slot stays empty.
pub(super) const INPUTS: usize = 16;

/// An item of a record, in its order.
pub(super) enum Item {
    /// A tick.
    Tick(TickInput),
    /// A chip's fault, from the next tick on.
    Fault(ChipFault),
}

/// Passes the record's inputs to the sensors, one per tick. Time is the record's.
pub struct Source {
    inputs: Consumer<'static, Item>,
    ended: &'static AtomicBool,
}

impl Source {
    /// Takes inputs from the queue that the feeder fills.
    pub(super) const fn new(inputs: Consumer<'static, Item>, ended: &'static AtomicBool) -> Self {
        Self { inputs, ended }
    }

    /// The purpose of this tick. A replay loses nothing: it waits for its input and for room for the results.
    pub fn next(&mut self, sensors: &mut Sensors, room: bool) -> Next {
        // Read before the queue: once it is set, no input is added.
        let ended = self.ended.load(Ordering::Acquire);
        if !room {
            return Next::Stall;
        }
        loop {
            return match self.inputs.dequeue() {
                Some(Item::Fault(fault)) => {
                    if !sensors.inject(fault) {
                        defmt::warn!("a fault of a chip is ignored: the record flies without chips");
                    }
                    continue;
                }
                Some(Item::Tick(input)) => {
                    sensors.load(&input);
                    Next::Tick(input.time_us)
                }
                None if ended => Next::End,
                None => Next::Underrun,
            };
        }
    }
}

/// A position in the record, between two frames.
#[derive(Clone, Copy)]
struct Place {
    /// Bytes before it.
    offset: u32,
    /// Number of the next frame.
    sequence: u32,
    /// Inputs before it.
    received: u32,
}

impl Place {
    fn keep(self, kept: &mut RetainedWords) {
        let Self { offset, sequence, received } = self;
        let words = [offset, sequence, received, !(offset ^ sequence ^ received)];
        const { assert!(BOARD_WORDS >= 4) };
        words.into_iter().enumerate().for_each(|(word, value)| kept.write(BOARD + word, value));
    }

    fn kept(kept: &RetainedWords) -> Option<Self> {
        let [offset, sequence, received, check] = [0, 1, 2, 3].map(|word| kept.read(BOARD + word));
        (check == !(offset ^ sequence ^ received)).then_some(Self { offset, sequence, received })
    }
}

/// Reads the record.
pub struct Feeder {
    inputs: Producer<'static, Item>,
    ended: &'static AtomicBool,
    bytes: Bytes,
    decoder: Decoder,
    /// Inputs before this time passed while the flight computer restarted.
    from_us: u64,
    skipped: u32,
    /// Positions of the waiting inputs and of those before them, which may not have been flown. A chip's
    /// fault this shortly before a reset is repeated after it.
    places: [Place; INPUTS],
    oldest: usize,
    kept: RetainedWords,
    received: u32,
    bad_frames: u32,
    bad_payloads: u32,
    missed_frames: u32,
    cut: bool,
}

impl Feeder {
    /// Opens the record, reads its header and, after a restart, continues from where it stopped.
    pub(super) fn open(
        inputs: Producer<'static, Item>,
        ended: &'static AtomicBool,
        resumed_us: Option<u64>,
        mut kept: RetainedWords,
    ) -> Result<(Self, Header), ExitStatus> {
        let file = File::open(INPUT_FILE).map_err(|_| ExitStatus::NoInput)?;
        let mut bytes = Bytes { file, chunk: [0; CHUNK], at: 0, len: 0, read: 0 };
        let mut decoder = Decoder::new();
        let header = loop {
            let byte = bytes.next().ok_or(ExitStatus::NoHeader)?;
            if let Some(frame) = decoder.push(byte).map_err(|_| ExitStatus::NoHeader)? {
                break frame.payload::<Header>().map_err(|_| ExitStatus::NoHeader)?;
            }
        };
        if header != Header::new(Stream::Inputs, header.model, header.sensors) {
            return Err(ExitStatus::NoHeader);
        }
        if header.model != FINGERPRINT {
            defmt::error!("the record is meant for model {=u64:016x}", header.model);
            return Err(ExitStatus::OtherModel);
        }
        let mut place = Place { offset: bytes.offset(), sequence: 1, received: 0 };
        if let (Some(there), true) = (Place::kept(&kept), resumed_us.is_some()) {
            bytes.go_to(there.offset).map_err(|_| ExitStatus::NoInput)?;
            decoder = Decoder::at(there.sequence);
            place = there;
        }
        place.keep(&mut kept);
        let feeder = Self {
            inputs,
            ended,
            bytes,
            decoder,
            from_us: resumed_us.unwrap_or(0),
            skipped: 0,
            places: [place; INPUTS],
            oldest: 0,
            kept,
            received: place.received,
            bad_frames: 0,
            bad_payloads: 0,
            missed_frames: 0,
            cut: false,
        };
        Ok((feeder, header))
    }

    /// Reads ahead as far as there is room. Anything that is not an input is counted and skipped.
    pub fn feed(&mut self) {
        while self.inputs.ready() && !self.ended.load(Ordering::Relaxed) {
            let Some(byte) = self.bytes.next() else {
                self.end(true);
                return;
            };
            let frame = match self.decoder.push(byte) {
                Ok(None) => continue,
                Ok(Some(frame)) => frame,
                Err(_) => {
                    self.bad_frames = self.bad_frames.saturating_add(1);
                    continue;
                }
            };
            self.missed_frames = self.missed_frames.saturating_add(frame.missed);
            if frame.kind == Kind::End {
                let whole = frame.payload::<End>().is_ok_and(|end| end.inputs == self.received);
                self.end(!whole);
                return;
            }
            let sequence = frame.sequence.wrapping_add(1);
            let is_fault = frame.kind == Kind::ChipFault;
            let item =
                if is_fault { frame.payload().map(Item::Fault) } else { frame.payload().map(Item::Tick) };
            let taken = match item {
                Ok(Item::Tick(input)) if input.time_us < self.from_us => {
                    self.skipped = self.skipped.saturating_add(1);
                    true
                }
                Ok(item) => {
                    if !is_fault {
                        self.from_us = 0;
                    }
                    // Cannot be full: `ready` was checked above.
                    self.inputs.enqueue(item).is_ok()
                }
                Err(_) => false,
            };
            if !taken {
                self.bad_payloads = self.bad_payloads.saturating_add(1);
            }
            if !taken || is_fault {
                continue;
            }
            self.received = self.received.saturating_add(1);
            let place = Place { offset: self.bytes.offset(), sequence, received: self.received };
            if let Some(oldest) = self.places.get_mut(self.oldest) {
                oldest.keep(&mut self.kept);
                *oldest = place;
            }
            self.oldest = (self.oldest + 1) % INPUTS;
        }
    }

    fn end(&mut self, cut: bool) {
        self.cut = cut;
        self.ended.store(true, Ordering::Release);
    }

    /// Adds the faults found in the record.
    pub fn summarise(&self, summary: Summary) -> Summary {
        Summary {
            bad_frames: self.bad_frames,
            bad_payloads: self.bad_payloads,
            missed_frames: self.missed_frames,
            input_cut: self.cut,
            skipped_inputs: self.skipped,
            ..summary
        }
    }
}

/// A file, byte by byte.
struct Bytes {
    file: File,
    chunk: [u8; CHUNK],
    at: usize,
    len: usize,
    /// Bytes read from the file.
    read: u32,
}

impl Bytes {
    fn next(&mut self) -> Option<u8> {
        if self.at >= self.len {
            // A failed read is the end of the available data, and is reported as a record that was cut.
            self.len = self.file.read(&mut self.chunk).ok()?;
            self.at = 0;
            self.read = self.read.wrapping_add(self.len as u32);
        }
        let byte = self.chunk.get(..self.len)?.get(self.at).copied()?;
        self.at += 1;
        Some(byte)
    }

    /// Position of the next byte in the file.
    fn offset(&self) -> u32 {
        self.read.wrapping_sub(self.len.saturating_sub(self.at) as u32)
    }

    fn go_to(&mut self, offset: u32) -> semihosting::io::Result<()> {
        self.file.seek(SeekFrom::Start(offset.into()))?;
        (self.at, self.len, self.read) = (0, 0, offset);
        Ok(())
    }
}
