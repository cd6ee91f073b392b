//! What QEMU's `netduinoplus2` has of its own.
//!
//! What QEMU 7.2 has of the STM32F405 is the core with its FPU, the memories, the timers TIM2 to TIM5,
//! the USARTs and some more; it has no clock tree, so waiting for the crystal or the PLL never ends.
//! The timers run at 1 GHz whatever the prescalers of the clock tree say; with `-icount shift=0` an
//! instruction takes one nanosecond, so a timer counts instructions.

use flight_record::CostUnit;
use stm32f4xx_hal::gpio::PA9;
use stm32f4xx_hal::pac::{DBGMCU, TIM4, USART1};
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::rcc::{Clocks, Rcc};
use stm32f4xx_hal::serial::{self, Tx};

use crate::downlink::BAUD;

/// The board's name.
pub const NAME: &str = "qemu";
/// QEMU's clock of the timers, Hz.
pub const TIMER_HZ: u32 = 1_000_000_000;
/// QEMU's clock of SysTick, Hz.
pub const CORE_HZ: u32 = 168_000_000;
/// What a timer counts.
pub const COST_UNIT: CostUnit = CostUnit::Instructions;
/// How often the line's progress is looked at, counts of a timer: not a fifth of a tick, so that within 30 s
/// a look has come at every part of a tick's 5 ms.
pub const LOOK: u32 = 999_967;
/// Bytes of one read from the host.
pub const CHUNK: usize = 512;
/// Bytes of results that are gathered for one write: each is written as it comes, so that a flight computer
/// that is struck has lost none.
pub const BATCH: usize = 0;

/// Whatever the clock tree is set to, its clocks are those of the constants here.
pub const fn has_clocks(_clocks: &Clocks) -> bool {
    true
}

/// Nothing here is halted by a debugger.
pub const fn stop_with_the_core(_debug: &DBGMCU) {}

/// Counts of a timer since the last reset: QEMU's count from there on, started or not.
pub fn since_reset() -> Option<u32> {
    // SAFETY: a read of the counter of a timer that nobody has.
    Some(unsafe { (*TIM4::ptr()).cnt().read().bits() })
}

/// What the telemetry's line goes out on: QEMU 7.2's USART hands on a byte as soon as it is written and
/// raises no interrupt for it, nor has QEMU the DMA.
pub struct Wire(Tx<USART1>);

impl Wire {
    /// Takes USART1 and its pin; `None` if it cannot be set to [`BAUD`].
    pub fn open(usart: USART1, pin: PA9, rcc: &mut Rcc) -> Option<Self> {
        let config = serial::Config::default().baudrate(BAUD.bps());
        Some(Self(usart.tx(pin, config, rcc).ok()?))
    }

    /// Sends a frame.
    pub fn send(&mut self, bytes: &[u8]) {
        for byte in bytes {
            // The emulated USART always has room and knows no error.
            let _ = self.0.write(*byte);
        }
    }
}
