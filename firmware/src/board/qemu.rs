//! The emulated board: QEMU's `netduinoplus2`, fed with a flight record through semihosting.
//!
//! What QEMU 7.2 has of the STM32F405 is the core with its FPU, the memories, the timers TIM2 to TIM5,
//! the USARTs and some more; it has no clock tree, so waiting for the crystal or the PLL never ends.
//! The timers run at 1 GHz whatever the prescalers of the clock tree say; with `-icount shift=0` an
//! instruction takes one nanosecond, so a timer counts instructions.

mod line;

use core::sync::atomic::{AtomicBool, AtomicU32, Ordering};

use chip_models::flown::{ChipFault, RecordedSensors};
use chip_models::metered::WorkObserver;
use defmt_semihosting as _;
use flight_record::{
    CostUnit, Decoder, Encoder, End, ExitStatus, Header, INPUT_FILE, Kind, MAX_STUFFED, OUTPUT_FILE, Payload,
    SensorSource, Stream, Summary,
};
use heapless::Vec;
use heapless::spsc::{Consumer, Producer, Queue};
use kf_core::input::TickInput;
use semihosting::fs::File;
use semihosting::io::{Read, Write};
use stm32f4xx_hal::pac::{Peripherals, TIM5};
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::rcc::Config;

pub use line::Line;

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
pub type Sensors = &'static mut RecordedSensors<ModelsWork>;

/// What a record brings, in its order.
enum Item {
    /// A tick.
    Tick(TickInput),
    /// A chip's fault, from the next tick on.
    Fault(ChipFault),
}

/// What the board needs in static memory.
pub struct Storage {
    inputs: Queue<Item, INPUTS>,
    ended: AtomicBool,
    /// None before the start; empty, unlike an `Option` of them, it takes no flash.
    sensors: Vec<RecordedSensors<ModelsWork>, 1>,
}

impl Storage {
    /// Empty.
    pub const fn new() -> Self {
        Self { inputs: Queue::new(), ended: AtomicBool::new(false), sensors: Vec::new() }
    }
}

/// Starts the board.
pub fn start(
    device: Peripherals,
    mut core: cortex_m::Peripherals,
    storage: &'static mut Storage,
) -> Result<Board, ExitStatus> {
    let Storage { inputs, ended, sensors } = storage;
    let (inputs_in, inputs_out) = inputs.split();
    let mut rcc = device.RCC.freeze(Config::hsi());
    let port_a = device.GPIOA.split(&mut rcc);
    let line = Line::start(device.USART1, port_a.pa9, device.TIM3, &mut core.NVIC, &mut rcc)
        .ok_or(ExitStatus::NoOutput)?;
    CostClock::start(&device.TIM5, &rcc);
    let (feeder, header) = Feeder::open(inputs_in, ended)?;
    if sensors.push(RecordedSensors::new(header.sensors, &ModelsWork)).is_err() {
        return Err(ExitStatus::Configuration);
    }
    let sensors = sensors.first_mut().ok_or(ExitStatus::Configuration)?;
    Ok(Board {
        feeder,
        source: Source { inputs: inputs_out, ended },
        is_recording: header.sensors == SensorSource::Ideal,
        sensors,
        sink: Sink::create(&header)?,
        line,
        timer: TickTimer::start(device.TIM2, &rcc, TIMER_HZ),
    })
}

/// Ends the emulation.
pub fn exit(status: ExitStatus) -> ! {
    semihosting::process::exit(status.code().into())
}

/// Counts the flight computer's instructions: TIM5, which is this clock's alone once it runs, without those of the models of
/// its chips.
#[derive(Clone, Copy)]
pub struct CostClock;

/// Instructions that the models of the chips have taken.
static MODELS_WORK: AtomicU32 = AtomicU32::new(0);

/// Keeps the models' work out of the count.
#[derive(Clone, Copy)]
pub struct ModelsWork;

impl WorkObserver for ModelsWork {
    fn begin(&mut self) -> u32 {
        CostClock::time()
    }

    fn end(&mut self, begun: u32) {
        let took = CostClock::time().wrapping_sub(begun);
        // No read-modify-write is needed: only a tick polls sensors, and nothing interrupts it that does.
        MODELS_WORK.store(MODELS_WORK.load(Ordering::Relaxed).wrapping_add(took), Ordering::Relaxed);
    }
}

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

    /// What share of a tick that is, per mille; instructions are no time.
    pub const fn permille_of_a_tick(_cost: u32) -> Option<u16> {
        None
    }

    /// Now, for what a tick costs: without the models' instructions; wrapping.
    pub fn now() -> u32 {
        Self::time().wrapping_sub(MODELS_WORK.load(Ordering::Relaxed))
    }

    /// Now, for when a tick begins: all instructions, wrapping.
    pub fn time() -> u32 {
        // SAFETY: a read of the counter, which changes nothing; nobody else has TIM5.
        unsafe { (*TIM5::ptr()).cnt().read().bits() }
    }
}

/// Hands the record's inputs to the sensors, one a tick. Time is the record's.
pub struct Source {
    inputs: Consumer<'static, Item>,
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
        loop {
            return match self.inputs.dequeue() {
                Some(Item::Fault(fault)) => {
                    if !sensors.inject(fault) {
                        defmt::warn!("a fault of a chip, and the record flies without chips");
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

/// Reads the record.
pub struct Feeder {
    inputs: Producer<'static, Item>,
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
    fn open(
        inputs: Producer<'static, Item>,
        ended: &'static AtomicBool,
    ) -> Result<(Self, Header), ExitStatus> {
        let file = File::open(INPUT_FILE).map_err(|_| ExitStatus::NoInput)?;
        let mut bytes = Bytes { file, chunk: [0; CHUNK], at: 0, len: 0 };
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
        let feeder = Self {
            inputs,
            ended,
            bytes,
            decoder,
            received: 0,
            bad_frames: 0,
            bad_payloads: 0,
            missed_frames: 0,
            cut: false,
        };
        Ok((feeder, header))
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
            let is_fault = frame.kind == Kind::ChipFault;
            let item =
                if is_fault { frame.payload().map(Item::Fault) } else { frame.payload().map(Item::Tick) };
            // Cannot be full: `ready` was asked above.
            let taken = item.is_ok_and(|item| self.inputs.enqueue(item).is_ok());
            let counter = match (taken, is_fault) {
                (true, true) => continue,
                (true, false) => &mut self.received,
                (false, _) => &mut self.bad_payloads,
            };
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
    /// Begins a stream of outputs for a stream of inputs.
    fn create(inputs: &Header) -> Result<Self, ExitStatus> {
        let file = File::create(OUTPUT_FILE).map_err(|_| ExitStatus::NoOutput)?;
        let mut sink = Self { file, encoder: Encoder::new(), failed: false };
        sink.write(&Header::new(Stream::Outputs, FINGERPRINT, inputs.sensors));
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
