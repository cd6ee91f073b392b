//! The board that flies a flight record, which it reads from the host through semihosting: in QEMU's
//! `netduinoplus2` (`emulated.rs`), or in an STM32F405 on its debug link (`silicon.rs`).
//!
//! Time is the record's. The pace of the ticks, and whether they wait for the host, does not affect the
//! flight.
//!
//! The first interrupt of a QEMU timer comes late by the time at which the timer was started, which after a
//! reset is the whole flight so far. So after a restart SysTick, which is the watchdog's timer, also drives
//! the tick and paces the line.

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

/// The board's static memory.
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

/// The sensors, whose chips keep their state over a reset of the flight computer: in memory that the start
/// does not clear.
struct KeptSensors {
    /// [`Self::MADE`] once they exist; an emulation starts with zeros.
    made: u32,
    sensors: MaybeUninit<RecordedSensors<ModelsWork>>,
}

#[unsafe(link_section = ".uninit.sensors")]
static mut SENSORS: MaybeUninit<KeptSensors> = MaybeUninit::uninit();

impl KeptSensors {
    const MADE: u32 = 0x4348_4950;

    /// The sensors: after a restart the existing ones, with new drivers.
    ///
    /// # Safety
    /// Only once.
    unsafe fn claim(source: SensorSource, has_restarted: bool) -> Sensors {
        let kept: *mut Self = (&raw mut SENSORS).cast();
        // SAFETY: nothing else uses them, as the caller guarantees; any bits are a valid number.
        let Self { made, sensors } = unsafe { &mut *kept };
        if has_restarted && *made == Self::MADE {
            // SAFETY: they were made, and are in a valid state: a reset comes at a tick's end, when no model
            // is running.
            let sensors = unsafe { sensors.assume_init_mut() };
            sensors.restart();
            return sensors;
        }
        let sensors = sensors.write(RecordedSensors::new(source, &ModelsWork));
        *made = Self::MADE;
        sensors
    }
}

/// Time from the last tick to the first after a restart, microseconds, in addition to the time for which
/// something hung: the record continues for as long as the flight computer may take.
const RESTART_US: u64 = 100_000;

unsafe extern "C" {
    /// Start of memory in which the linker places nothing (`memory.x`).
    static _retained_start: u32;
}

/// The retained memory: RAM, whose content survives a reset.
pub fn retained() -> *mut u32 {
    (&raw const _retained_start).cast_mut()
}

/// Nothing guards the memory, and there is nothing to wait for.
pub const fn prepare(_device: &Peripherals) {}

/// There is no crystal that could fail.
pub const fn clock_is_internal() -> bool {
    false
}

/// A reset has no other source. Before a flight the memory is all zeros, so nothing is retained: QEMU's RAM
/// starts that way, and the host writes zeros into a board's. The wire's state is not known before the first
/// tick.
pub const fn reset_facts() -> ResetFacts {
    ResetFacts {
        source: ResetSource::Software,
        umbilical_is_open: None,
        counts_per_us: TIMER_HZ / 1_000_000,
        // There is none.
        independent_watchdog_us: 0,
        restart_us: RESTART_US,
    }
}

/// There is nothing to wait for: the record continues where standby has ended.
pub fn stand_by(report: &RestartReport, line: &mut Line, _watchdog: &mut Watchdog) {
    line.send(&telemetry::standby(report, 0));
}

/// Starts the board; after a restart at the place in the record that belongs to the clock's time.
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
    // SAFETY: called only here.
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

/// Ends the flight and passes the status to the host.
pub fn exit(status: ExitStatus) -> ! {
    semihosting::process::exit(status.code().into())
}
