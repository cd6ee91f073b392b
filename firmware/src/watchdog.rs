//! The watchdog: a timer that records what was late and resets ([`crate::failure`]). Behind it, where the
//! board has one, an independent watchdog covers what the timer cannot catch.
//!
//! The tick feeds it, once everything that must be alive has been seen ([`survival::Supervisor`]).

use cortex_m::peripheral::NVIC;
use stm32f4xx_hal::pac::Interrupt;

/// Time after which anything is late, milliseconds: fifty ticks.
pub const TIMEOUT_MS: u32 = 250;

/// Gives the watchdog's interrupt priority over everything except a critical section of all interrupts.
pub fn unmask(nvic: &mut NVIC) {
    // SAFETY: the highest priority is above every critical section of RTIC; the handler touches nothing
    // that these protect, and never returns.
    unsafe {
        nvic.set_priority(Interrupt::TIM4, 0);
        NVIC::unmask(Interrupt::TIM4);
    }
}
