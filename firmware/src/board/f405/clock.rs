//! The board's clocks: the core's, the cost of a tick measured with it, and the mission's time.

use cortex_m::peripheral::{DCB, DWT};
use flight_record::CostUnit;
use stm32f4xx_hal::gpio::Output;
use stm32f4xx_hal::pac::{RCC, TIM5};
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::rcc::Config;
use survival::WideClock;

use super::Sensors;
use super::wiring::{CORE_MHZ, CRYSTAL_MHZ, Led};
use crate::board::Next;
use crate::tick_timer::TICK_HZ;

/// The timers' clock, MHz: APB1 runs at a quarter of the core's, its timers at twice that.
const TIMER_MHZ: u16 = 84;
/// The same in Hz.
pub const TIMER_HZ: u32 = TIMER_MHZ as u32 * 1_000_000;

/// Prescaler that divides the timers' clock to 10 kHz.
pub const TIMER_10_KHZ: u16 = TIMER_MHZ * 100 - 1;

/// The clock tree: the crystal or the internal oscillator, through the PLL. Both are running and locked by
/// now (`oscillator.rs`), so the HAL does not wait.
pub fn tree(is_internal: bool) -> Config {
    let config = if is_internal { Config::hsi() } else { Config::hse(CRYSTAL_MHZ.MHz()) };
    config.sysclk(CORE_MHZ.MHz()).require_pll48clk()
}

/// Counts the core's cycles, for the cost of a tick, and microseconds, for points in time. The cycle counter
/// stops while some cores sleep, so it cannot measure idle time.
#[derive(Clone, Copy)]
pub struct CostClock;

impl CostClock {
    /// Unit of the cost.
    pub const UNIT: CostUnit = CostUnit::Cycles;

    pub(super) fn start(mut dcb: DCB, mut dwt: DWT) {
        dcb.enable_trace();
        dwt.enable_cycle_counter();
    }

    /// A cost as a share of a tick, per mille.
    pub const fn permille_of_a_tick(cost: u32) -> Option<u16> {
        const CYCLES: u64 = (CORE_MHZ * 1_000_000 / TICK_HZ) as u64;
        let permille = cost as u64 * 1_000 / CYCLES;
        Some(if permille > u16::MAX as u64 { u16::MAX } else { permille as u16 })
    }

    /// Not known: the counter starts with the board.
    pub const fn since_reset() -> Option<u32> {
        None
    }

    /// Current cycle count, for the cost of a tick; wraps.
    pub fn now() -> u32 {
        DWT::cycle_count()
    }

    /// Current time, for the start of a tick, microseconds: the low half of the mission's time; wraps.
    pub fn time() -> u32 {
        // SAFETY: reading the timer changes nothing.
        unsafe { (*TIM5::ptr()).cnt().read().bits() }
    }
}

/// Starts TIM5: the low half of the mission's microseconds. It runs whatever the core does.
pub(super) fn start_timer(tim5: &TIM5, rcc: &RCC, now_us: u64) {
    rcc.apb1enr().modify(|_, w| w.tim5en().enabled());
    tim5.psc().write(|w| w.psc().set(TIMER_MHZ - 1));
    tim5.arr().write(|w| w.arr().set(u32::MAX));
    tim5.egr().write(|w| w.ug().set_bit());
    tim5.cnt().write(|w| w.set(now_us as u32));
    tim5.cr1().modify(|_, w| w.cen().enabled());
}

/// The mission's clock: TIM5 in microseconds, extended beyond its 32 bits at every tick. The LED toggles
/// every half second as long as there are ticks.
pub struct Source {
    tim5: TIM5,
    clock: WideClock,
    led: Led<Output>,
    ticks_to_blink: u32,
}

impl Source {
    /// Uses the timer that [`start_timer`] has set to this time.
    pub(super) fn start(tim5: TIM5, led: Led, now_us: u64) -> Self {
        let clock = WideClock::new(now_us, now_us as u32);
        Self { tim5, clock, led: led.into_push_pull_output(), ticks_to_blink: 0 }
    }

    /// Every tick runs the mission, because a flight cannot wait.
    pub fn next(&mut self, _sensors: &mut Sensors, _room: bool) -> Next {
        if self.ticks_to_blink == 0 {
            self.led.toggle();
            self.ticks_to_blink = TICK_HZ / 2;
        }
        self.ticks_to_blink -= 1;
        Next::Tick(self.clock.at(self.tim5.cnt().read().bits()))
    }
}
