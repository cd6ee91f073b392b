//! TIM2, which times the mission's ticks.

use stm32f4xx_hal::pac::{RCC, TIM2};

/// Ticks a second.
pub const TICK_HZ: u32 = 200;

/// TIM2, interrupting [`TICK_HZ`] times a second.
pub struct TickTimer(TIM2);

impl TickTimer {
    /// Starts the timer, which the board clocks at `timer_hz`.
    pub fn start(tim2: TIM2, rcc: &RCC, timer_hz: u32) -> Self {
        rcc.apb1enr().modify(|_, w| w.tim2en().enabled());
        // Counter and prescaler keep their reset values. No update event is generated: QEMU 7.2 would add the
        // time since its start to every period.
        tim2.arr().write(|w| w.arr().set(timer_hz / TICK_HZ - 1));
        tim2.sr().modify(|_, w| w.uif().clear());
        tim2.dier().modify(|_, w| w.uie().enabled());
        tim2.cr1().modify(|_, w| w.cen().enabled());
        Self(tim2)
    }

    /// The timer's interrupt without the timer: another source pends it.
    #[cfg(feature = "recorded")]
    pub const fn pended(tim2: TIM2) -> Self {
        Self(tim2)
    }

    /// Acknowledges the timer's interrupt.
    pub fn acknowledge(&mut self) {
        self.0.sr().modify(|_, w| w.uif().clear());
    }
}
