//! The properties of QEMU's `netduinoplus2`.
//!
//! QEMU 7.2 emulates of the STM32F405 the core with its FPU, the memories, the timers TIM2 to TIM5, the
//! USARTs and some more. It has no clock tree, so waiting for the crystal or the PLL never ends. The timers
//! run at 1 GHz whatever the prescalers of the clock tree are set to; with `-icount shift=0` an instruction
//! takes one nanosecond, so a timer counts instructions.

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
/// Interval between checks of the line's progress, counts of a timer: not a fifth of a tick, so that within
/// 30 s the checks cover every part of a tick's 5 ms.
pub const LOOK: u32 = 999_967;
/// Size of one read from the host, bytes.
pub const CHUNK: usize = 512;
/// Size of the results gathered for one write, bytes. Each result is written immediately, so that a flight
/// computer that is reset loses none.
pub const BATCH: usize = 0;

/// Whatever the clock tree is set to, the clocks are those of the constants here.
pub const fn has_clocks(_clocks: &Clocks) -> bool {
    true
}

/// No debugger halts anything here.
pub const fn stop_with_the_core(_debug: &DBGMCU) {}

/// Counts of a timer since the last reset, which is where QEMU's count starts, whether or not the timer was
/// started.
pub fn since_reset() -> Option<u32> {
    // SAFETY: a read of the counter of an unused timer.
    Some(unsafe { (*TIM4::ptr()).cnt().read().bits() })
}

/// The output of the telemetry line: QEMU 7.2's USART forwards a byte as soon as it is written, without an
/// interrupt, and QEMU has no DMA.
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
            // The emulated USART always has room and never fails.
            let _ = self.0.write(*byte);
        }
    }
}
