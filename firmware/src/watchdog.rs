//! The watchdog: a timer that keeps who was late and resets ([`crate::failure`]), and behind it, where the
//! board has one, an independent watchdog for what the timer cannot catch.
//!
//! It is fed by the tick, when everything that must be alive has been seen ([`survival::Supervisor`]).

use cortex_m::peripheral::NVIC;
use stm32f4xx_hal::pac::Interrupt;

/// So long may anything be late, milliseconds: fifty ticks.
pub const TIMEOUT_MS: u32 = 250;

/// Lets the watchdog's interrupt through everything but a critical section of all interrupts.
pub fn unmask(nvic: &mut NVIC) {
    // SAFETY: the highest priority is above every critical section of RTIC; the handler touches nothing
    // that these protect, and never returns.
    unsafe {
        nvic.set_priority(Interrupt::TIM4, 0);
        NVIC::unmask(Interrupt::TIM4);
    }
}
