//! The flight computer: an STM32F405RG at 168 MHz from an 8 MHz crystal, with the chips and lines of [`wiring`].

mod absent;
mod break_wire;
mod clock;
mod line;
mod results;
mod sensors;
mod spi;
mod uart;
mod watched;
mod wiring;

use cortex_m::peripheral::SCB;
use defmt_rtt as _;
use flight_record::{ExitStatus, Summary};
use stm32f4xx_hal::dma::StreamsTuple;
use stm32f4xx_hal::pac::Peripherals;
use stm32f4xx_hal::prelude::*;
use telemetry::Frame;

pub use clock::{CostClock, Source};
pub use line::Line;
pub use results::Sink;
pub use sensors::Sensors;

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

/// Starts the board.
pub fn start(
    device: Peripherals,
    core: cortex_m::Peripherals,
    storage: &'static mut Storage,
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

    Ok(Board {
        source: Source::start(device.TIM5, pins.led, &rcc),
        feeder: Feeder { teller: storage.teller() },
        is_recording: false,
        sensors: sensors::suite(storage, receiver, barometer, imu, umbilical, break_wire),
        sink: Sink::start(device.USART6, pins.results, &mut rcc)?,
        line: line.ok_or(ExitStatus::NoOutput)?,
        timer: TickTimer::start(device.TIM2, &rcc, clock::TIMER_HZ),
    })
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
