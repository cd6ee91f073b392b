//! The emulated board: QEMU's `netduinoplus2`, fed with a flight record through semihosting.
//!
//! What QEMU 7.2 has of the STM32F405 is the core with its FPU, the memories, the timers TIM2 to TIM5,
//! the USARTs and some more; it has no clock tree, so waiting for the crystal or the PLL never ends.
//! The timers run at 1 GHz whatever the prescalers of the clock tree say; with `-icount shift=0` an
//! instruction takes one nanosecond, so a timer counts instructions.

use core::sync::atomic::{AtomicBool, Ordering};

use defmt_semihosting as _;
use drivers::ReplayedSuite;
use flight_record::{
    CostUnit, Decoder, Encoder, End, ExitStatus, Header, INPUT_FILE, Kind, MAX_STUFFED, OUTPUT_FILE, Payload,
    Stream, Summary,
};
use heapless::spsc::{Consumer, Producer, Queue};
use kf_core::input::TickInput;
use semihosting::fs::File;
use semihosting::io::{Read, Write};
use stm32f4xx_hal::pac::{Peripherals, TIM5};
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::rcc::Config;

use super::{Board, Next};
use crate::flown_model::FINGERPRINT;
use crate::tick_timer::TickTimer;

/// The board's name.
pub const NAME: &str = "qemu";
/// QEMU's clock of the timers, Hz.
const TIMER_HZ: u32 = 1_000_000_000;
/// Inputs read ahead, one slot of which stays empty.
const INPUTS: usize = 16;
/// Bytes of one read from the host.
const CHUNK: usize = 512;

/// The sensors of the flight record.
pub type Sensors = ReplayedSuite;

/// What the board needs in static memory.
pub struct Storage {
    inputs: Queue<TickInput, INPUTS>,
    ended: AtomicBool,
}

impl Storage {
    /// Empty.
    pub const fn new() -> Self {
        Self { inputs: Queue::new(), ended: AtomicBool::new(false) }
    }
}

/// Starts the board.
pub fn start(
    device: Peripherals,
    _core: cortex_m::Peripherals,
    storage: &'static mut Storage,
) -> Result<Board, ExitStatus> {
    let Storage { inputs, ended } = storage;
    let (inputs_in, inputs_out) = inputs.split();
    let rcc = device.RCC.freeze(Config::hsi());
    CostClock::start(&device.TIM5, &rcc);
    Ok(Board {
        feeder: Feeder::open(inputs_in, ended)?,
        source: Source { inputs: inputs_out, ended },
        sensors: ReplayedSuite::replayed(),
        sink: Sink::create()?,
        timer: TickTimer::start(device.TIM2, &rcc, TIMER_HZ),
    })
}

/// Ends the emulation.
pub fn exit(status: ExitStatus) -> ! {
    semihosting::process::exit(status.code().into())
}

/// Counts instructions: TIM5, which is this clock's alone once it runs.
#[derive(Clone, Copy)]
pub struct CostClock;

impl CostClock {
    /// What it counts.
    pub const UNIT: CostUnit = CostUnit::Instructions;

    fn start(tim5: &TIM5, rcc: &stm32f4xx_hal::pac::RCC) {
        rcc.apb1enr().modify(|_, w| w.tim5en().enabled());
        tim5.psc().write(|w| w.psc().set(0));
        tim5.arr().write(|w| w.arr().set(u32::MAX));
        tim5.egr().write(|w| w.ug().set_bit());
        tim5.cr1().modify(|_, w| w.cen().enabled());
    }

    /// Now, wrapping.
    pub fn now() -> u32 {
        // SAFETY: a read of the counter, which changes nothing; nobody else has TIM5.
        unsafe { (*TIM5::ptr()).cnt().read().bits() }
    }
}

/// Hands the record's inputs to the sensors, one a tick. Time is the record's.
pub struct Source {
    inputs: Consumer<'static, TickInput>,
    ended: &'static AtomicBool,
}

impl Source {
    /// What this tick is for. A replay loses nothing: it waits for its input and for room for the
    /// results.
    pub fn next(&mut self, sensors: &mut Sensors, room: bool) -> Next {
        // Read before the queue: once it is set no input is added.
        let ended = self.ended.load(Ordering::Acquire);
        if !room {
            return Next::Stall;
        }
        match self.inputs.dequeue() {
            Some(input) => {
                sensors.load(&input);
                Next::Tick(input.time_us)
            }
            None if ended => Next::End,
            None => Next::Underrun,
        }
    }
}

/// Reads the record.
pub struct Feeder {
    inputs: Producer<'static, TickInput>,
    ended: &'static AtomicBool,
    bytes: Bytes,
    decoder: Decoder,
    received: u32,
    bad_frames: u32,
    bad_payloads: u32,
    missed_frames: u32,
    cut: bool,
}

impl Feeder {
    /// Opens the record and reads its header.
    fn open(inputs: Producer<'static, TickInput>, ended: &'static AtomicBool) -> Result<Self, ExitStatus> {
        let file = File::open(INPUT_FILE).map_err(|_| ExitStatus::NoInput)?;
        let mut bytes = Bytes { file, chunk: [0; CHUNK], at: 0, len: 0 };
        let mut decoder = Decoder::new();
        let header = loop {
            let byte = bytes.next().ok_or(ExitStatus::NoHeader)?;
            if let Some(frame) = decoder.push(byte).map_err(|_| ExitStatus::NoHeader)? {
                break frame.payload::<Header>().map_err(|_| ExitStatus::NoHeader)?;
            }
        };
        if header != Header::new(Stream::Inputs, header.model) {
            return Err(ExitStatus::NoHeader);
        }
        if header.model != FINGERPRINT {
            defmt::error!("the record is meant for model {=u64:016x}", header.model);
            return Err(ExitStatus::OtherModel);
        }
        Ok(Self {
            inputs,
            ended,
            bytes,
            decoder,
            received: 0,
            bad_frames: 0,
            bad_payloads: 0,
            missed_frames: 0,
            cut: false,
        })
    }

    /// Reads ahead as far as there is room. What is no input is counted and skipped.
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
            // Cannot be full: `ready` was asked above.
            let taken = frame.payload::<TickInput>().is_ok_and(|input| self.inputs.enqueue(input).is_ok());
            let counter = if taken { &mut self.received } else { &mut self.bad_payloads };
            *counter = counter.saturating_add(1);
        }
    }

    fn end(&mut self, cut: bool) {
        self.cut = cut;
        self.ended.store(true, Ordering::Release);
    }

    /// Adds what was wrong with the record.
    pub fn summarise(&self, summary: Summary) -> Summary {
        Summary {
            bad_frames: self.bad_frames,
            bad_payloads: self.bad_payloads,
            missed_frames: self.missed_frames,
            input_cut: self.cut,
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
}

impl Bytes {
    fn next(&mut self) -> Option<u8> {
        if self.at >= self.len {
            // A read that fails is the end of what can be had, and shows as a record that was cut.
            self.len = self.file.read(&mut self.chunk).ok()?;
            self.at = 0;
        }
        let byte = self.chunk.get(..self.len)?.get(self.at).copied()?;
        self.at += 1;
        Some(byte)
    }
}

/// Writes the results.
pub struct Sink {
    file: File,
    encoder: Encoder,
    failed: bool,
}

impl Sink {
    fn create() -> Result<Self, ExitStatus> {
        let file = File::create(OUTPUT_FILE).map_err(|_| ExitStatus::NoOutput)?;
        let mut sink = Self { file, encoder: Encoder::new(), failed: false };
        sink.write(&Header::new(Stream::Outputs, FINGERPRINT));
        Ok(sink)
    }

    /// Writes one result; a failure shows in [`Self::status`].
    pub fn write<P: Payload>(&mut self, payload: &P) {
        let mut buffer = [0; MAX_STUFFED];
        let written = match self.encoder.encode(payload, &mut buffer) {
            Ok(bytes) => self.file.write_all(bytes).is_ok(),
            Err(_) => false,
        };
        self.failed |= !written;
    }

    /// How the flight ended.
    pub const fn status(&self) -> ExitStatus {
        if self.failed { ExitStatus::NoOutput } else { ExitStatus::Finished }
    }
}
