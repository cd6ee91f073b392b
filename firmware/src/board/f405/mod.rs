//! The flight computer: an STM32F405RG at 168 MHz from an 8 MHz crystal, with the chips and lines of
//! [`wiring`].

mod absent;
mod backup;
mod break_wire;
mod clock;
mod independent_watchdog;
mod line;
mod oscillator;
mod results;
mod sensors;
mod spi;
mod uart;
mod watchdog;
mod watched;
mod wiring;

use cortex_m::peripheral::SCB;
use defmt_rtt as _;
use flight_computer::ResetFacts;
use flight_record::{ExitStatus, Summary};
use stm32f4xx_hal::dma::StreamsTuple;
use stm32f4xx_hal::pac::Peripherals;
use stm32f4xx_hal::prelude::*;
use survival::{NoClock, Oscillator, RestartReport};
use telemetry::Frame;
use wiring::CORE_MHZ;

pub use backup::retained;
pub use clock::{CostClock, Source};
pub use line::Line;
pub use oscillator::clock_is_internal;
pub use results::Sink;
pub use sensors::Sensors;
pub use watchdog::Watchdog;

use break_wire::BreakWire;
use sensors::{SensorHealthLog, SensorStorage};
use wiring::Pins;

use super::Board;
use crate::retained::RetainedWords;
use crate::tick_timer::TickTimer;

/// The board's name.
pub const NAME: &str = "f405";

/// The board's static memory.
pub struct Storage {
    sensors: SensorStorage,
    /// The frames that the telemetry's DMA reads.
    frames: [Frame; 2],
}

impl Storage {
    /// Empty.
    pub const fn new() -> Self {
        Self { sensors: SensorStorage::new(), frames: [Frame::EMPTY; 2] }
    }
}

/// Time from a reset to the first tick, microseconds: 2 ms until the crystal runs (DS8626, table 39), 0.3 ms
/// until the PLL has locked (table 42), the first period of the tick, and the start's code, most of it at 16
/// MHz: some 8 ms. A closed wire, which no vehicle in free flight has, takes 20 ms more.
const RESTART_US: u64 = 15_000;
/// Additional time if the crystal does not start, microseconds: 64,000 polls of five to ten cycles at 16 MHz.
const CRYSTAL_WAIT_US: u64 = 30_000;

/// Runs before anything else: starts the watchdog, which bounds every later wait, then the clock and the
/// retained memory.
pub fn prepare(device: &Peripherals) {
    // The watchdogs stop while a debugger halts the core, so that they do not reset it.
    device.DBGMCU.apb1_fz().modify(|_, w| w.dbg_iwdg_stop().set_bit().dbg_tim4_stop().set_bit());
    independent_watchdog::start_independent_watchdog(&device.IWDG);
    match oscillator::start(&device.RCC) {
        Ok(Oscillator::Crystal) => {}
        Ok(Oscillator::Internal) => defmt::error!("no crystal: the clock is 1 % to 4 % off"),
        Err(NoClock) => exit(ExitStatus::Configuration),
    }
    backup::open_retained(device);
}

/// Whether the wire is open, or opens within the 20 ms of the launch's debounce. A separation that shakes the
/// supply also makes the wire bounce, and a single reading while it is closed would discard the latch as one
/// from an earlier flight.
fn umbilical_is_open() -> Option<bool> {
    /// Number of polls, each of which takes 63 us at the 16 MHz clock after a reset: 20 ms in total.
    const LOOKS: u32 = 320;
    Some((0..LOOKS).any(|_| break_wire::umbilical_is_open() == Some(true)))
}

/// The facts about the reset that are known before the board is started.
pub fn reset_facts() -> ResetFacts {
    ResetFacts {
        source: backup::reset_source(),
        umbilical_is_open: umbilical_is_open(),
        counts_per_us: 1,
        independent_watchdog_us: independent_watchdog::INDEPENDENT_WATCHDOG_US,
        restart_us: if clock_is_internal() { RESTART_US + CRYSTAL_WAIT_US } else { RESTART_US },
    }
}

/// Starts the board. After a restart its clock continues from the time in the report, less the remaining
/// standby.
pub fn start(
    device: Peripherals,
    mut core: cortex_m::Peripherals,
    storage: &'static mut Storage,
    restart: Option<&RestartReport>,
    _kept: RetainedWords,
) -> Result<Board, ExitStatus> {
    let Storage { sensors: storage, frames } = storage;
    let storage = &*storage;
    let mut rcc = device.RCC.freeze(clock::tree(clock_is_internal()));
    if rcc.clocks.timclk1().raw() != clock::TIMER_HZ {
        return Err(ExitStatus::Configuration);
    }
    CostClock::start(core.DCB, core.DWT);
    let now_us = restart.map_or(0, |report| report.resumed_us.saturating_sub(report.pause_us));
    clock::start_timer(&device.TIM5, &rcc, now_us);
    let ports = (device.GPIOA.split(&mut rcc), device.GPIOB.split(&mut rcc), device.GPIOC.split(&mut rcc));
    let pins = Pins::take(ports.0, ports.1, ports.2);

    let Ok(imu) = spi::imu(device.SPI1, pins.imu, pins.imu_select, &mut rcc);
    let Ok(barometer) = spi::barometer(device.SPI3, pins.baro, pins.baro_select, &mut rcc);
    let streams = StreamsTuple::new(device.DMA1, &mut rcc);
    let receiver = sensors::receiver_port(device.USART3, pins.receiver, streams.1, storage, &mut rcc)
        .map_err(|_| ExitStatus::Configuration)?;
    let umbilical = sensors::umbilical_port(device.UART4, pins.umbilical, streams.2, storage, &mut rcc)
        .map_err(|_| ExitStatus::Configuration)?;
    let line = Line::start(
        device.USART1,
        pins.telemetry,
        StreamsTuple::new(device.DMA2, &mut rcc).7,
        frames,
        &mut rcc,
    );
    let break_wire = BreakWire::start(pins.break_wire);

    Ok(Board {
        source: Source::start(device.TIM5, pins.led, now_us),
        feeder: Feeder { health_log: storage.health_log() },
        is_recording: false,
        sensors: sensors::suite(storage, receiver, barometer, imu, umbilical, break_wire),
        sink: Sink::start(device.USART6, pins.results, &mut rcc)?,
        line: line.ok_or(ExitStatus::NoOutput)?,
        timer: TickTimer::start(device.TIM2, &rcc, clock::TIMER_HZ),
        watchdog: Watchdog::start(device.TIM4, &rcc, &mut core.NVIC),
    })
}

/// Standby of a flight computer that keeps crashing: no sensor is reported, and log and telemetry give the
/// reason once a second.
pub fn stand_by(report: &RestartReport, line: &mut Line, watchdog: &mut Watchdog) {
    for (second, _) in (0_u8..).zip(0..report.pause_us / 1_000_000) {
        defmt::error!("standby after {=str}", report.cause.name());
        // It is free a second after the last frame.
        if line.is_free() {
            line.send(&telemetry::standby(report, second));
        }
        for _ in 0..10 {
            cortex_m::asm::delay(CORE_MHZ * 100_000);
            watchdog.feed();
        }
    }
}

/// Restarts, because a flight computer does not stop.
pub fn exit(_status: ExitStatus) -> ! {
    SCB::sys_reset()
}

/// The chips need no input from here, so this only logs their health.
pub struct Feeder {
    health_log: SensorHealthLog,
}

impl Feeder {
    /// Called after every tick.
    pub fn feed(&mut self) {
        self.health_log.log_changes();
    }

    /// Nothing to add.
    pub fn summarise(&self, summary: Summary) -> Summary {
        summary
    }
}
