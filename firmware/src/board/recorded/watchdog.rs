//! SysTick as the watchdog's timer, and after a restart also in place of all other timers.

use core::sync::atomic::{AtomicBool, AtomicU32, Ordering};

use cortex_m::peripheral::scb::SystemHandler;
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m::peripheral::{NVIC, SCB, SYST};
use cortex_m_rt::exception;
use stm32f4xx_hal::pac::Interrupt;

use super::line;
use super::machine::{CORE_HZ, TIMER_HZ};
use crate::tick_timer::TICK_HZ;
use crate::watchdog::{TIMEOUT_MS, unmask};

/// Ticks left before the watchdog expires.
static TICKS_LEFT: AtomicU32 = AtomicU32::new(TIMEOUT_MS * TICK_HZ / 1_000);

/// Whether SysTick stands in for the other timers.
static HAS_RESTARTED: AtomicBool = AtomicBool::new(false);

/// SysTick, which pends the watchdog's interrupt unless it is fed.
pub struct Watchdog;

impl Watchdog {
    pub(super) fn start(mut timer: SYST, scb: &mut SCB, nvic: &mut NVIC, has_restarted: bool) -> Self {
        HAS_RESTARTED.store(has_restarted, Ordering::Relaxed);
        // SAFETY: above every critical section of RTIC; the handler touches nothing that these protect.
        unsafe { scb.set_priority(SystemHandler::SysTick, 0) };
        unmask(nvic);
        timer.set_clock_source(SystClkSource::Core);
        timer.set_reload(CORE_HZ / TICK_HZ - 1);
        timer.clear_current();
        timer.enable_counter();
        timer.enable_interrupt();
        Self
    }

    /// Restarts the countdown.
    pub fn feed(&mut self) {
        TICKS_LEFT.store(TIMEOUT_MS * TICK_HZ / 1_000, Ordering::Relaxed);
    }
}

#[exception]
fn SysTick() {
    let left = TICKS_LEFT.load(Ordering::Relaxed);
    TICKS_LEFT.store(left.saturating_sub(1), Ordering::Relaxed);
    if left == 0 {
        NVIC::pend(Interrupt::TIM4);
    } else if HAS_RESTARTED.load(Ordering::Relaxed) {
        NVIC::pend(Interrupt::TIM2);
        line::pass(TIMER_HZ / TICK_HZ);
    }
}
