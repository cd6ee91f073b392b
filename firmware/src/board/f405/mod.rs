//! The flight computer: an STM32F405RG at 168 MHz from an 8 MHz crystal, with the chips and lines of [`wiring`].

mod absent;
mod backup;
mod break_wire;
mod clock;
mod independent_watchdog;
mod line;
mod results;
mod sensors;
mod spi;
mod uart;
mod watchdog;
mod watched;
mod wiring;

use cortex_m::peripheral::SCB;
use defmt_rtt as _;
use flight_record::{ExitStatus, Summary};
use stm32f4xx_hal::dma::StreamsTuple;
use stm32f4xx_hal::pac::Peripherals;
use stm32f4xx_hal::prelude::*;
use survival::{BOARD_WORDS, RestartReport};
use telemetry::Frame;
use wiring::CORE_MHZ;

pub use backup::{open_retained, reset_source, retained};
pub use break_wire::umbilical_is_open;
pub use clock::{CostClock, Source, microseconds};
pub use independent_watchdog::INDEPENDENT_WATCHDOG_US;
pub use line::Line;
pub use results::Sink;
pub use sensors::Sensors;
pub use watchdog::Watchdog;

use break_wire::BreakWire;
use sensors::{SensorStorage, SensorTeller};
use wiring::Pins;

use super::Board;
use crate::tick_timer::TickTimer;

/// The board's name.
pub const NAME: &str = "f405";

/// What the board needs in static memory.
pub struct Storage {
    sensors: SensorStorage,
    /// What the telemetry's DMA reads.
    frames: [Frame; 2],
}

impl Storage {
    /// Empty.
    pub const fn new() -> Self {
        Self { sensors: SensorStorage::new(), frames: [Frame::EMPTY; 2] }
    }
}

/// From a reset to the first tick, microseconds: 2 ms until the crystal runs (DS8626, table 39), 0.3 ms until the PLL has
/// locked (table 42), the first period of the tick, and the start's code, most of it at 16 MHz: some 8 ms.
pub const RESTART_US: u64 = 15_000;

/// Starts the board; after a restart its clock goes on at `resumed_us`.
pub fn start(
    device: Peripherals,
    mut core: cortex_m::Peripherals,
    storage: &'static mut Storage,
    resumed_us: Option<u64>,
    _kept: &'static mut [u32; BOARD_WORDS],
) -> Result<Board, ExitStatus> {
    let Storage { sensors: storage, frames } = storage;
    let storage = &*storage;
    let mut rcc = device.RCC.freeze(clock::tree());
    if rcc.clocks.timclk1().raw() != clock::TIMER_HZ {
        return Err(ExitStatus::Configuration);
    }
    CostClock::start(core.DCB, core.DWT);
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
    let break_wire = BreakWire::start(pins.break_wire, device.EXTI, &mut device.SYSCFG.constrain(&mut rcc));

    // A debugger that halts the core must not find it reset.
    device.DBGMCU.apb1_fz().modify(|_, w| w.dbg_iwdg_stop().set_bit().dbg_tim4_stop().set_bit());
    independent_watchdog::start_independent_watchdog(&device.IWDG);
    Ok(Board {
        source: Source::start(device.TIM5, pins.led, &rcc, resumed_us.unwrap_or(0)),
        feeder: Feeder { teller: storage.teller() },
        is_recording: false,
        sensors: sensors::suite(storage, receiver, barometer, imu, umbilical, break_wire),
        sink: Sink::start(device.USART6, pins.results, &mut rcc)?,
        line: line.ok_or(ExitStatus::NoOutput)?,
        timer: TickTimer::start(device.TIM2, &rcc, clock::TIMER_HZ),
        watchdog: Watchdog::start(device.TIM4, &rcc, &mut core.NVIC),
    })
}

/// Without a mission: nothing is said of any sensor, and log and telemetry go on saying why.
pub fn stand_by(report: &RestartReport, mut line: Line) -> ! {
    let mut sequence = 0_u8;
    loop {
        defmt::error!("standby after {=str}", report.cause.name());
        // Free, a second after the last one.
        if line.is_free() {
            line.send(&telemetry::standby(report, sequence));
        }
        sequence = sequence.wrapping_add(1);
        for _ in 0..10 {
            cortex_m::asm::delay(CORE_MHZ * 100_000);
            independent_watchdog::feed_independent_watchdog();
        }
    }
}

/// Starts again: a flight computer does not stop.
pub fn exit(_status: ExitStatus) -> ! {
    SCB::sys_reset()
}

/// The chips feed themselves: what is left is to say in the log how they do.
pub struct Feeder {
    teller: SensorTeller,
}

impl Feeder {
    /// Called after every tick.
    pub fn feed(&mut self) {
        self.teller.tell();
    }

    /// Nothing to add.
    pub fn summarise(&self, summary: Summary) -> Summary {
        summary
    }
}
