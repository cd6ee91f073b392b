//! The board that flies a flight record, which the host gives it through semihosting: in QEMU's
//! `netduinoplus2` (`emulated.rs`), or in an STM32F405 on its debug link (`silicon.rs`).
//!
//! Time is the record's. How fast the ticks come, and whether they wait for the host, is nothing to the
//! flight.
//!
//! The first interrupt of one of QEMU's timers comes after the period and, once more, the time at which the
//! timer was started, which after a reset is the whole flight so far. So after a restart SysTick, which is
//! the watchdog's timer, makes the tick as well and paces the line.

mod cost_clock;
#[cfg(feature = "board-qemu")]
mod emulated;
mod line;
mod reader;
#[cfg(feature = "board-hil")]
mod silicon;
mod sink;
mod watchdog;

use core::mem::MaybeUninit;
use core::sync::atomic::AtomicBool;

use chip_models::flown::RecordedSensors;
use defmt_semihosting as _;
use flight_computer::ResetFacts;
use flight_record::{ExitStatus, SensorSource};
use heapless::Vec;
use heapless::spsc::Queue;
use stm32f4xx_hal::pac::Peripherals;
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::rcc::Config;
use survival::{ResetSource, RestartReport};

#[cfg(feature = "board-qemu")]
use emulated as machine;
#[cfg(feature = "board-hil")]
use silicon as machine;

pub use cost_clock::{CostClock, ModelsWork};
pub use line::Line;
pub use machine::NAME;
use machine::{BATCH, TIMER_HZ};
pub use reader::{Feeder, Source};
use reader::{INPUTS, Item};
pub use sink::Sink;
pub use watchdog::Watchdog;

use super::{Board, Next};
use crate::retained::RetainedWords;
use crate::tick_timer::TickTimer;

/// The sensors of the flight record.
pub type Sensors = &'static mut RecordedSensors<ModelsWork>;

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
        source: Source::new(inputs_out, ended),
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
