//! The umbilical's break-wire: a pin that is pulled up, and that the mother ship holds at ground.
//!
//! The tick polls its level. An interrupt above every other dates the edge to a microsecond, and counts openings that were over
//! before the next poll: those are told to the log and to nobody else.

use core::sync::atomic::{AtomicU32, Ordering};

use cortex_m::peripheral::NVIC;
use drivers::{LaunchDiscrete, SensorError};
use stm32f4xx_hal::gpio::{Edge, ExtiPin, Input, Pin};
use stm32f4xx_hal::pac::{EXTI, GPIOA, RCC, TIM5, interrupt};
use stm32f4xx_hal::syscfg::SysCfg;

use super::wiring::BreakWirePin;

/// Openings since the last poll, and when the first of them was, in the low half of the mission's microseconds.
static OPENINGS: AtomicU32 = AtomicU32::new(0);
static FIRST_US: AtomicU32 = AtomicU32::new(0);

/// The wire.
pub struct BreakWire {
    pin: BreakWirePin<Input>,
    opened_us: Option<u64>,
    short_openings: u32,
}

impl BreakWire {
    /// Takes its pin, and EXTI, which has no other use on this board.
    pub fn start(pin: BreakWirePin, mut exti: EXTI, syscfg: &mut SysCfg) -> Self {
        let mut pin = pin.into_pull_up_input();
        is_on_line_3(&pin);
        pin.make_interrupt_source(syscfg);
        pin.trigger_on_edge(&mut exti, Edge::Rising);
        pin.clear_interrupt_pending_bit();
        pin.enable_interrupt(&mut exti);
        // SAFETY: the handler shares nothing with others but atomics, and masks no critical section.
        unsafe { NVIC::unmask(pin.interrupt()) };
        Self { pin, opened_us: None, short_openings: 0 }
    }

    /// When it opened, microseconds of the mission, to a microsecond; `None`: it is closed, or has been open since before
    /// the flight computer started.
    pub const fn opened_us(&self) -> Option<u64> {
        self.opened_us
    }

    /// Openings that no poll has seen; saturates.
    pub const fn short_openings(&self) -> u32 {
        self.short_openings
    }
}

/// Whether the wire is open, before the board has been started.
pub fn umbilical_is_open() -> Option<bool> {
    /// Cycles of the 16 MHz that a reset leaves for the pull-up of at most 50 kOhm (DS8626 rev 10, table 48) to load the
    /// wire: 60 us are twenty times 50 kOhm and 60 pF.
    const SETTLING_CYCLES: u32 = 1_000;
    // SAFETY: nobody else has these before the board has been started, and that sets them all again.
    let (rcc, port) = unsafe { (&*RCC::ptr(), &*GPIOA::ptr()) };
    rcc.ahb1enr().modify(|_, w| w.gpioaen().enabled());
    port.moder().modify(|_, w| w.moder3().input());
    port.pupdr().modify(|_, w| w.pupdr3().pull_up());
    cortex_m::asm::delay(SETTLING_CYCLES);
    Some(port.idr().read().idr3().bit_is_set())
}

impl LaunchDiscrete for BreakWire {
    fn poll(&mut self, now_us: u64) -> Result<bool, SensorError> {
        let openings = OPENINGS.swap(0, Ordering::Relaxed);
        let is_open = self.pin.is_high();
        if !is_open {
            self.opened_us = None;
            self.short_openings = self.short_openings.saturating_add(openings);
        } else if openings > 0 && self.opened_us.is_none() {
            // An edge after `now_us` was taken lies ahead of it.
            let age_us = (now_us as u32).wrapping_sub(FIRST_US.load(Ordering::Relaxed)) as i32;
            self.opened_us = now_us.checked_sub_signed(age_us.into());
        }
        Ok(is_open)
    }
}

/// Another pin needs another handler: with this one it does not compile.
const fn is_on_line_3<const PORT: char, Mode>(_pin: &Pin<PORT, 3, Mode>) {}

/// An opening edge.
#[interrupt]
fn EXTI3() {
    // SAFETY: the pending bits are cleared by writing 1 to those meant and to no other (RM0090, 12.3.6), and reading the
    // timer changes nothing.
    let now_us = unsafe {
        (*EXTI::ptr()).pr().write(|w| w.pr3().clear_bit_by_one());
        (*TIM5::ptr()).cnt().read().bits()
    };
    let openings = OPENINGS.load(Ordering::Relaxed);
    if openings == 0 {
        FIRST_US.store(now_us, Ordering::Relaxed);
    }
    OPENINGS.store(openings.saturating_add(1), Ordering::Relaxed);
}
