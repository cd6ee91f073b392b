//! The flight computer: an STM32F405RG at 168 MHz from an 8 MHz crystal.
//!
//! The drivers of its chips come with their own issue; until then every sensor of this board says that
//! there is no such device, and the mission runs without samples.

mod absent;
mod clock;
mod results;
mod wiring;

use absent::Absent;
use cortex_m::peripheral::SCB;
use defmt_rtt as _;
use drivers::Suite;
use flight_record::{ExitStatus, Summary};
use stm32f4xx_hal::pac::Peripherals;
use stm32f4xx_hal::prelude::*;

pub use clock::{CostClock, Source};
pub use results::Sink;

use super::Board;
use crate::tick_timer::TickTimer;

/// The board's name.
pub const NAME: &str = "f405";

/// The sensors of this board.
pub type Sensors = Suite<Absent, Absent, Absent, Absent, Absent, Absent, Absent>;

/// What the board needs in static memory: nothing.
pub struct Storage;

impl Storage {
    /// Empty.
    pub const fn new() -> Self {
        Self
    }
}

/// Starts the board.
pub fn start(
    device: Peripherals,
    core: cortex_m::Peripherals,
    _storage: &'static mut Storage,
) -> Result<Board, ExitStatus> {
    let mut rcc = device.RCC.freeze(clock::tree());
    if rcc.clocks.timclk1().raw() != clock::TIMER_HZ {
        return Err(ExitStatus::Configuration);
    }
    let port_a = device.GPIOA.split(&mut rcc);
    CostClock::start(core.DCB, core.DWT);
    Ok(Board {
        source: Source::start(device.TIM5, &rcc),
        feeder: Feeder,
        sensors: Suite::new(Absent, Absent, Absent, Absent, Absent, Absent, Absent),
        sink: Sink::start(device.USART1, port_a.pa9, &mut rcc)?,
        timer: TickTimer::start(device.TIM2, &rcc, clock::TIMER_HZ),
    })
}

/// Starts again: a flight computer does not stop.
pub fn exit(_status: ExitStatus) -> ! {
    SCB::sys_reset()
}

/// The chips feed themselves.
pub struct Feeder;

impl Feeder {
    /// Nothing to do.
    pub fn feed(&mut self) {}

    /// Nothing to add.
    pub fn summarise(&self, summary: Summary) -> Summary {
        summary
    }
}
