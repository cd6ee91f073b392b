//! The board that flies a flight record, which the host gives it through semihosting: in QEMU's
//! `netduinoplus2` (`emulated.rs`), or in an STM32F405 on its debug link (`silicon.rs`).
//!
//! Time is the record's. How fast the ticks come, and whether they wait for the host, is nothing to the
//! flight.
//!
//! The first interrupt of one of QEMU's timers comes after the period and, once more, the time at which the
//! timer was started, which after a reset is the whole flight so far. So after a restart SysTick, which is
//! the watchdog's timer, makes the tick as well and paces the line.

#[cfg(feature = "board-qemu")]
mod emulated;
mod line;
#[cfg(feature = "board-hil")]
mod silicon;

use core::mem::MaybeUninit;
use core::sync::atomic::{AtomicBool, AtomicU32, Ordering};

use chip_models::flown::{ChipFault, RecordedSensors};
use chip_models::metered::WorkObserver;
use cortex_m::peripheral::scb::SystemHandler;
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m::peripheral::{NVIC, SCB, SYST};
use cortex_m_rt::exception;
use defmt_semihosting as _;
use flight_computer::ResetFacts;
use flight_record::{
    CostUnit, Decoder, Encoder, End, ExitStatus, Header, INPUT_FILE, Kind, MAX_STUFFED, OUTPUT_FILE, Payload,
    SensorSource, Stream, Summary,
};
use heapless::Vec;
use heapless::spsc::{Consumer, Producer, Queue};
use kf_core::input::TickInput;
use semihosting::fs::File;
use semihosting::io::{Read, Seek, SeekFrom, Write};
use stm32f4xx_hal::pac::{Interrupt, Peripherals, TIM5};
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::rcc::Config;
use survival::{BOARD, BOARD_WORDS, ResetSource, RestartReport, WordMemory as _};

#[cfg(feature = "board-qemu")]
use emulated as machine;
#[cfg(feature = "board-hil")]
use silicon as machine;

pub use line::Line;
pub use machine::NAME;
use machine::{BATCH, CHUNK, CORE_HZ, TIMER_HZ};

use super::{Board, Next};
use crate::retained::RetainedWords;
use crate::tick_timer::{TICK_HZ, TickTimer};
use crate::watchdog::{TIMEOUT_MS, unmask};
use flown_mission::FINGERPRINT;

/// Inputs read ahead, one slot of which stays empty.
const INPUTS: usize = 16;
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
    batch: Vec<u8, BATCH>,
}

impl Storage {
    /// Empty.
    pub const fn new() -> Self {
        Self { inputs: Queue::new(), ended: AtomicBool::new(false), batch: Vec::new() }
    }
}

/// The sensors, whose chips a reset of the flight computer leaves as they are: where the start clears no
/// memory.
struct KeptSensors {
    /// [`Self::MADE`] once they are there; an emulation begins with zeros.
    made: u32,
    sensors: MaybeUninit<RecordedSensors<ModelsWork>>,
}

#[unsafe(link_section = ".uninit.sensors")]
static mut SENSORS: MaybeUninit<KeptSensors> = MaybeUninit::uninit();

impl KeptSensors {
    const MADE: u32 = 0x4348_4950;

    /// The sensors: after a restart those that there are, with new drivers.
    ///
    /// # Safety
    /// Once only.
    unsafe fn claim(source: SensorSource, has_restarted: bool) -> Sensors {
        let kept: *mut Self = (&raw mut SENSORS).cast();
        // SAFETY: nobody else has them, as the caller promises; any bits are a number.
        let Self { made, sensors } = unsafe { &mut *kept };
        if has_restarted && *made == Self::MADE {
            // SAFETY: they were made, and are a value: a blow strikes at a tick's end, when no model works.
            let sensors = unsafe { sensors.assume_init_mut() };
            sensors.restart();
            return sensors;
        }
        let sensors = sensors.write(RecordedSensors::new(source, &ModelsWork));
        *made = Self::MADE;
        sensors
    }
}

/// From the last tick to the first after a restart, microseconds, beside the time that something hung: the
/// record goes on for as long as the flight computer may take.
const RESTART_US: u64 = 100_000;

unsafe extern "C" {
    /// Where the linker puts nothing (`memory.x`).
    static _retained_start: u32;
}

/// The retained memory: RAM, which a reset leaves as it is.
pub fn retained() -> *mut u32 {
    (&raw const _retained_start).cast_mut()
}

/// Nothing guards the memory, and nothing has to be waited for.
pub const fn prepare(_device: &Peripherals) {}

/// There is no crystal that could fail.
pub const fn clock_is_internal() -> bool {
    false
}

/// There is no other source; before a flight the memory is full of zeros, in which nothing was kept: QEMU's
/// RAM comes so, and the host writes them into a board's. The wire is not known before the first tick.
pub const fn reset_facts() -> ResetFacts {
    ResetFacts {
        source: ResetSource::Software,
        umbilical_is_open: None,
        counts_per_us: TIMER_HZ / 1_000_000,
        // None runs.
        independent_watchdog_us: 0,
        restart_us: RESTART_US,
    }
}

/// There is nothing to wait for: the record goes on where standby has ended.
pub fn stand_by(report: &RestartReport, line: &mut Line, _watchdog: &mut Watchdog) {
    line.send(&telemetry::standby(report, 0));
}

/// Starts the board; after a restart, where the record is by the time at which the clock goes on.
pub fn start(
    device: Peripherals,
    mut core: cortex_m::Peripherals,
    storage: &'static mut Storage,
    restart: Option<&RestartReport>,
    kept: RetainedWords,
) -> Result<Board, ExitStatus> {
    let Storage { inputs, ended, batch } = storage;
    let resumed_us = restart.map(|report| report.resumed_us);
    let has_restarted = resumed_us.is_some();
    let (inputs_in, inputs_out) = inputs.split();
    machine::stop_with_the_core(&device.DBGMCU);
    let mut rcc = device.RCC.freeze(Config::hsi());
    if !machine::has_clocks(&rcc.clocks) {
        return Err(ExitStatus::Configuration);
    }
    let port_a = device.GPIOA.split(&mut rcc);
    let line = Line::start(device.USART1, port_a.pa9, device.TIM3, has_restarted, &mut core.NVIC, &mut rcc)
        .ok_or(ExitStatus::NoOutput)?;
    CostClock::start(&device.TIM5, &rcc);
    let (feeder, header) = Feeder::open(inputs_in, ended, resumed_us, kept)?;
    // SAFETY: here alone.
    let sensors = unsafe { KeptSensors::claim(header.sensors, has_restarted) };
    Ok(Board {
        feeder,
        source: Source { inputs: inputs_out, ended },
        is_recording: header.sensors == SensorSource::Ideal,
        sensors,
        sink: Sink::open(&header, has_restarted, batch)?,
        line,
        watchdog: Watchdog::start(core.SYST, &mut core.SCB, &mut core.NVIC, has_restarted),
        timer: match has_restarted {
            true => TickTimer::pended(device.TIM2),
            false => TickTimer::start(device.TIM2, &rcc, TIMER_HZ),
        },
    })
}

/// Ends the flight: the host gets the status.
pub fn exit(status: ExitStatus) -> ! {
    semihosting::process::exit(status.code().into())
}

/// Ticks that are left before the watchdog strikes.
static TICKS_LEFT: AtomicU32 = AtomicU32::new(TIMEOUT_MS * TICK_HZ / 1_000);

/// Whether SysTick stands in for the other timers.
static HAS_RESTARTED: AtomicBool = AtomicBool::new(false);

/// SysTick, which pends the watchdog's interrupt unless it is fed.
pub struct Watchdog;

impl Watchdog {
    fn start(mut timer: SYST, scb: &mut SCB, nvic: &mut NVIC, has_restarted: bool) -> Self {
        HAS_RESTARTED.store(has_restarted, Ordering::Relaxed);
        // SAFETY: above every critical section of RTIC; the handler touches nothing that these protect.
        unsafe { scb.set_priority(SystemHandler::SysTick, 0) };
        unmask(nvic);
        timer.set_clock_source(SystClkSource::Core);
        timer.set_reload(CORE_HZ / TICK_HZ - 1);
        timer.clear_current();
        timer.enable_counter();
        timer.enable_interrupt();
        Self
    }

    /// All is well for another while.
    pub fn feed(&mut self) {
        TICKS_LEFT.store(TIMEOUT_MS * TICK_HZ / 1_000, Ordering::Relaxed);
    }
}

#[exception]
fn SysTick() {
    let left = TICKS_LEFT.load(Ordering::Relaxed);
    TICKS_LEFT.store(left.saturating_sub(1), Ordering::Relaxed);
    if left == 0 {
        NVIC::pend(Interrupt::TIM4);
    } else if HAS_RESTARTED.load(Ordering::Relaxed) {
        NVIC::pend(Interrupt::TIM2);
        line::pass(TIMER_HZ / TICK_HZ);
    }
}

/// Counts the flight computer's instructions, or cycles: TIM5, which is this clock's alone once it runs,
/// without those of the models of its chips.
#[derive(Clone, Copy)]
pub struct CostClock;

/// What the models of the chips have taken, counts of [`CostClock`].
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
    pub const UNIT: CostUnit = machine::COST_UNIT;

    fn start(tim5: &TIM5, rcc: &stm32f4xx_hal::pac::RCC) {
        rcc.apb1enr().modify(|_, w| w.tim5en().enabled());
        tim5.psc().write(|w| w.psc().set(0));
        tim5.arr().write(|w| w.arr().set(u32::MAX));
        tim5.egr().write(|w| w.ug().set_bit());
        tim5.cr1().modify(|_, w| w.cen().enabled());
    }

    /// What share of a tick that is, per mille: none can be said. Instructions are no time, and the cycles
    /// are of another clock than the flight's.
    pub const fn permille_of_a_tick(_cost: u32) -> Option<u16> {
        None
    }

    /// Since the last reset, where that is known.
    pub fn since_reset() -> Option<u32> {
        machine::since_reset()
    }

    /// Now, for what a tick costs: without the models' work; wrapping.
    pub fn now() -> u32 {
        Self::time().wrapping_sub(MODELS_WORK.load(Ordering::Relaxed))
    }

    /// Now, for when a tick begins: all work, wrapping.
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

/// A place in the record, between two frames.
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
    /// Inputs before this time have passed while the flight computer restarted.
    from_us: u64,
    skipped: u32,
    /// Where the inputs that are waiting began, and those before them: all that may not have been flown. A
    /// chip's fault so shortly before a reset comes once more after it.
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
    /// Opens the record, reads its header and, after a restart, goes to where it had come.
    fn open(
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
                    // Cannot be full: `ready` was asked above.
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

    /// Adds what was wrong with the record.
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
            // A read that fails is the end of what can be had, and shows as a record that was cut.
            self.len = self.file.read(&mut self.chunk).ok()?;
            self.at = 0;
            self.read = self.read.wrapping_add(self.len as u32);
        }
        let byte = self.chunk.get(..self.len)?.get(self.at).copied()?;
        self.at += 1;
        Some(byte)
    }

    /// Where the next byte is in the file.
    fn offset(&self) -> u32 {
        self.read.wrapping_sub(self.len.saturating_sub(self.at) as u32)
    }

    fn go_to(&mut self, offset: u32) -> semihosting::io::Result<()> {
        self.file.seek(SeekFrom::Start(offset.into()))?;
        (self.at, self.len, self.read) = (0, 0, offset);
        Ok(())
    }
}

/// Writes the results.
pub struct Sink {
    file: File,
    encoder: Encoder,
    /// What is not written yet.
    batch: &'static mut Vec<u8, BATCH>,
    failed: bool,
}

impl Sink {
    /// Begins a stream of outputs for a stream of inputs; after a restart in the same file, from another
    /// header on.
    fn open(inputs: &Header, goes_on: bool, batch: &'static mut Vec<u8, BATCH>) -> Result<Self, ExitStatus> {
        let mut options = File::options();
        let options = options.write(true).append(goes_on).truncate(!goes_on);
        let mut file = options.create(true).open(OUTPUT_FILE).map_err(|_| ExitStatus::NoOutput)?;
        if goes_on {
            // QEMU 7.2 opens for appending and then writes at the start.
            file.seek(SeekFrom::End(0)).map_err(|_| ExitStatus::NoOutput)?;
        }
        let mut sink = Self { file, encoder: Encoder::new(), batch, failed: false };
        sink.write(&Header::new(Stream::Outputs, FINGERPRINT, inputs.sensors));
        Ok(sink)
    }

    /// Writes one result; a failure shows in [`Self::status`]. Only ticks may wait for more of them: whatever
    /// else is told is told now, and after the summary nothing is left.
    pub fn write<P: Payload>(&mut self, payload: &P) {
        let mut buffer = [0; MAX_STUFFED];
        let written = match self.encoder.encode(payload, &mut buffer) {
            Ok(bytes) if BATCH == 0 => self.file.write_all(bytes).is_ok(),
            Ok(bytes) => self.gather(bytes, P::KIND == Kind::Tick),
            Err(_) => false,
        };
        self.failed |= !written;
    }

    /// Adds to the batch, and writes it when it is full or may not wait.
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
