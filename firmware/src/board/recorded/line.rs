//! The telemetry line, paced by TIM3.
//!
//! A frame is given to the wire at once, and counts as being on the line for as long as its bytes take. TIM3
//! runs from the start, because a timer of QEMU that is restarted later is late by the time that has passed.

use core::sync::atomic::{AtomicU32, Ordering};

use cortex_m::peripheral::NVIC;
use stm32f4xx_hal::gpio::PA9;
use stm32f4xx_hal::pac::{Interrupt, TIM3, USART1, interrupt};
use stm32f4xx_hal::rcc::Rcc;
use telemetry::Frame;

use super::machine::{LOOK, TIMER_HZ, Wire};
use crate::downlink::BAUD;
use crate::mutation;

/// Duration of a byte with its start and stop bit, counts of a timer.
const BYTE: u32 = (10 * TIMER_HZ as u64 / BAUD as u64) as u32 * mutation::LINE_SLOWNESS;
/// Below the tick, as for the real board's DMA (RTIC's priority 2, in the upper four bits and counted from
/// above).
const PRIORITY: u8 = (16 - 2) << 4;

/// Remaining time for which what was sent is still on the line, counts of a timer.
static OWED: AtomicU32 = AtomicU32::new(0);

/// The interval between two checks has passed.
#[interrupt]
fn TIM3() {
    // SAFETY: nothing else touches the timer once it runs.
    unsafe { &*TIM3::ptr() }.sr().modify(|_, w| w.uif().clear());
    pass(LOOK);
}

/// Advances the line by this much time, counts of a timer.
pub fn pass(counts: u32) {
    // Never an error: the closure always has a value.
    let _ = OWED.fetch_update(Ordering::AcqRel, Ordering::Acquire, |owed| Some(owed.saturating_sub(counts)));
    NVIC::pend(Interrupt::DMA2_STREAM7);
}

/// The telemetry line.
pub struct Line(Wire);

impl Line {
    /// Takes USART1, its pin and TIM3; `None` if the USART cannot be set to [`BAUD`]. After a restart the
    /// time is advanced from elsewhere ([`pass`]).
    pub fn start(
        usart: USART1,
        pin: PA9,
        timer: TIM3,
        has_restarted: bool,
        nvic: &mut NVIC,
        rcc: &mut Rcc,
    ) -> Option<Self> {
        let wire = Wire::open(usart, pin, rcc)?;
        if has_restarted {
            return Some(Self(wire));
        }
        rcc.apb1enr().modify(|_, w| w.tim3en().enabled());
        // SAFETY: the register has 16 bits, the emulated one 32, and the machine's constant fits.
        timer.arr().write(|w| unsafe { w.bits(LOOK - 1) });
        timer.sr().modify(|_, w| w.uif().clear());
        timer.dier().modify(|_, w| w.uie().enabled());
        // SAFETY: the handler shares only an atomic with the code that runs now.
        unsafe {
            nvic.set_priority(Interrupt::TIM3, PRIORITY);
            NVIC::unmask(Interrupt::TIM3);
        }
        timer.cr1().modify(|_, w| w.cen().enabled());
        Some(Self(wire))
    }

    /// Whether the next frame can be sent: the last one will be finished before the next check.
    pub fn is_free(&mut self) -> bool {
        OWED.load(Ordering::Acquire) < LOOK
    }

    /// Sends a frame on a free line.
    pub fn send(&mut self, frame: &Frame) {
        self.0.send(frame.bytes());
        OWED.fetch_add(frame.bytes().len() as u32 * BYTE, Ordering::AcqRel);
    }
}
