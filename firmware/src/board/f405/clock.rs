//! The board's clocks: the core's, what a tick costs by it, and the mission's time.

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

/// The timers' clock: APB1 runs at a quarter of the core's, its timers at twice that.
const TIMER_MHZ: u16 = 84;
/// The same in Hz.
pub const TIMER_HZ: u32 = TIMER_MHZ as u32 * 1_000_000;

/// Prescaler that makes 10 kHz of the timers' clock.
pub const TIMER_10_KHZ: u16 = TIMER_MHZ * 100 - 1;

/// The clock tree: the crystal or the internal oscillator, through the PLL. Both run and are locked by now
/// (`oscillator.rs`): the HAL waits for nothing.
pub fn tree(is_internal: bool) -> Config {
    let config = if is_internal { Config::hsi() } else { Config::hse(CRYSTAL_MHZ.MHz()) };
    config.sysclk(CORE_MHZ.MHz()).require_pll48clk()
}

/// Counts the core's cycles, for what a tick costs, and microseconds, for when something is. The cycle
/// counter stands still while some cores sleep: it cannot say how long nothing was done.
#[derive(Clone, Copy)]
pub struct CostClock;

impl CostClock {
    /// What it counts.
    pub const UNIT: CostUnit = CostUnit::Cycles;

    pub(super) fn start(mut dcb: DCB, mut dwt: DWT) {
        dcb.enable_trace();
        dwt.enable_cycle_counter();
    }

    /// What share of a tick that is, per mille.
    pub const fn permille_of_a_tick(cost: u32) -> Option<u16> {
        const CYCLES: u64 = (CORE_MHZ * 1_000_000 / TICK_HZ) as u64;
        let permille = cost as u64 * 1_000 / CYCLES;
        Some(if permille > u16::MAX as u64 { u16::MAX } else { permille as u16 })
    }

    /// Not known: the counter starts with the board.
    pub const fn since_reset() -> Option<u32> {
        None
    }

    /// Now, for what a tick costs, cycles; wrapping.
    pub fn now() -> u32 {
        DWT::cycle_count()
    }

    /// Now, for when a tick begins, microseconds: the low half of the mission's; wrapping.
    pub fn time() -> u32 {
        // SAFETY: reading the timer changes nothing.
        unsafe { (*TIM5::ptr()).cnt().read().bits() }
    }
}

/// Starts TIM5: the low half of the mission's microseconds, which runs whatever the core does.
pub(super) fn start_timer(tim5: &TIM5, rcc: &RCC, now_us: u64) {
    rcc.apb1enr().modify(|_, w| w.tim5en().enabled());
    tim5.psc().write(|w| w.psc().set(TIMER_MHZ - 1));
    tim5.arr().write(|w| w.arr().set(u32::MAX));
    tim5.egr().write(|w| w.ug().set_bit());
    tim5.cnt().write(|w| w.set(now_us as u32));
    tim5.cr1().modify(|_, w| w.cen().enabled());
}

/// The clock of the mission: TIM5 in microseconds, carried beyond its 32 bits at every tick. The LED changes
/// every half second as long as there are ticks.
pub struct Source {
    tim5: TIM5,
    clock: WideClock,
    led: Led<Output>,
    ticks_to_blink: u32,
}

impl Source {
    /// With the timer that [`start_timer`] has set to that time.
    pub(super) fn start(tim5: TIM5, led: Led, now_us: u64) -> Self {
        let clock = WideClock::new(now_us, now_us as u32);
        Self { tim5, clock, led: led.into_push_pull_output(), ticks_to_blink: 0 }
    }

    /// Every tick runs the mission; a flight cannot wait.
    pub fn next(&mut self, _sensors: &mut Sensors, _room: bool) -> Next {
        if self.ticks_to_blink == 0 {
            self.led.toggle();
            self.ticks_to_blink = TICK_HZ / 2;
        }
        self.ticks_to_blink -= 1;
        Next::Tick(self.clock.at(self.tim5.cnt().read().bits()))
    }
}
