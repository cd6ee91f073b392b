//! The properties of an STM32F405 on the desk: it is fed through its debug link and runs at the 16 MHz of its
//! internal oscillator, so that it needs no crystal and no wires but the probe's.

use flight_record::CostUnit;
use stm32f4xx_hal::gpio::PA9;
use stm32f4xx_hal::pac::{DBGMCU, USART1};
use stm32f4xx_hal::rcc::{Clocks, Rcc};

/// The board's name.
pub const NAME: &str = "hil";
/// Clock of the timers, Hz: no prescaler divides the oscillator's.
pub const TIMER_HZ: u32 = 16_000_000;
/// Clock of SysTick, Hz: the core's.
pub const CORE_HZ: u32 = 16_000_000;
/// What a timer counts: its clock is the core's.
pub const COST_UNIT: CostUnit = CostUnit::Cycles;
/// Interval between checks of the line's progress, counts of a timer: just under a millisecond, and not a
/// fifth of a tick. TIM3 has 16 bits.
pub const LOOK: u32 = 15_999;
/// Size of one read from the host, bytes. A semihosting call takes milliseconds, however much it transfers.
pub const CHUNK: usize = 2_048;
/// Size of the results gathered for one write, bytes, for the same reason.
pub const BATCH: usize = 4_096;

/// Whether the clocks are those of the constants here.
pub fn has_clocks(clocks: &Clocks) -> bool {
    clocks.timclk1().raw() == TIMER_HZ && clocks.hclk().raw() == CORE_HZ
}

/// A semihosting call halts the core. The timers must stop with it, or each call would cost ticks, and the
/// tick that it interrupts would include the host's time.
pub fn stop_with_the_core(debug: &DBGMCU) {
    debug.apb1_fz().modify(|_, w| {
        w.dbg_tim2_stop()
            .set_bit()
            .dbg_tim3_stop()
            .set_bit()
            .dbg_tim4_stop()
            .set_bit()
            .dbg_tim5_stop()
            .set_bit()
    });
}

/// Not known: no counter runs before the start.
pub const fn since_reset() -> Option<u32> {
    None
}

/// The output of the telemetry line: none. A radio that is wired to the board must not send a simulated
/// flight.
pub struct Wire;

impl Wire {
    /// Leaves USART1 and its pin as the reset left them.
    pub const fn open(_usart: USART1, _pin: PA9, _rcc: &mut Rcc) -> Option<Self> {
        Some(Self)
    }

    /// Keeps the line busy for as long as the frame would have taken, and sends nothing.
    pub const fn send(&mut self, _bytes: &[u8]) {}
}
