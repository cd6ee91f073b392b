//! The umbilical's break-wire: a pin that is pulled up and that the mother ship holds at ground.
//!
//! The tick polls its level, and nothing else reads it. A resolution of one tick, 5 ms, is enough to decide
//! the launch, and with an interrupt for every edge a dangling wire could starve the tick.

use cortex_m::asm;
use drivers::{LaunchDiscrete, SensorError};
use stm32f4xx_hal::gpio::Input;
use stm32f4xx_hal::pac::{GPIOA, RCC};

use super::wiring::BreakWirePin;

/// The wire.
pub struct BreakWire {
    pin: BreakWirePin<Input>,
    opened_us: Option<u64>,
    closings: u32,
}

impl BreakWire {
    /// Takes its pin.
    pub fn start(pin: BreakWirePin) -> Self {
        Self { pin: pin.into_pull_up_input(), opened_us: None, closings: 0 }
    }

    /// Time of the poll at which it was first open, microseconds of the mission; `None` if it is closed.
    pub const fn opened_us(&self) -> Option<u64> {
        self.opened_us
    }

    /// Number of times that it has closed again; saturates.
    pub const fn closings(&self) -> u32 {
        self.closings
    }
}

/// Whether the wire is open, before the board has been started.
pub fn umbilical_is_open() -> Option<bool> {
    /// Cycles, at the 16 MHz clock after a reset, in which the pull-up of at most 50 kOhm (DS8626 rev 10,
    /// table 48) charges the wire: 60 us are twenty times 50 kOhm and 60 pF.
    const SETTLING_CYCLES: u32 = 1_000;
    // SAFETY: nothing else uses these before the board has been started, and the start sets them all again.
    let (rcc, port) = unsafe { (&*RCC::ptr(), &*GPIOA::ptr()) };
    rcc.ahb1enr().modify(|_, w| w.gpioaen().enabled());
    port.moder().modify(|_, w| w.moder3().input());
    port.pupdr().modify(|_, w| w.pupdr3().pull_up());
    asm::delay(SETTLING_CYCLES);
    Some(port.idr().read().idr3().bit_is_set())
}

impl LaunchDiscrete for BreakWire {
    fn poll(&mut self, now_us: u64) -> Result<bool, SensorError> {
        let is_open = self.pin.is_high();
        if is_open {
            self.opened_us.get_or_insert(now_us);
        } else if self.opened_us.take().is_some() {
            self.closings = self.closings.saturating_add(1);
        }
        Ok(is_open)
    }
}
