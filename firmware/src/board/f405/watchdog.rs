//! The watchdog's timer: TIM4, in front of the independent watchdog.

use cortex_m::peripheral::NVIC;
use stm32f4xx_hal::pac::{RCC, TIM4};

use super::clock::TIMER_10_KHZ;
use super::independent_watchdog::feed_independent_watchdog;
use crate::watchdog::{TIMEOUT_MS, unmask};

/// TIM4, running towards a reset.
pub struct Watchdog(TIM4);

impl Watchdog {
    pub(super) fn start(tim4: TIM4, rcc: &RCC, nvic: &mut NVIC) -> Self {
        rcc.apb1enr().modify(|_, w| w.tim4en().enabled());
        tim4.psc().write(|w| w.psc().set(TIMER_10_KHZ));
        tim4.arr().write(|w| w.arr().set((10 * TIMEOUT_MS) as u16));
        // A feed must not look like an expiry of the timer.
        tim4.cr1().write(|w| w.urs().set_bit());
        tim4.egr().write(|w| w.ug().set_bit());
        tim4.sr().modify(|_, w| w.uif().clear());
        tim4.dier().modify(|_, w| w.uie().enabled());
        tim4.cr1().modify(|_, w| w.cen().enabled());
        unmask(nvic);
        Self(tim4)
    }

    /// Restarts the timer.
    pub fn feed(&mut self) {
        self.0.egr().write(|w| w.ug().set_bit());
        feed_independent_watchdog();
    }
}
