//! The telemetry's line: USART1, at the pace of TIM3.
//!
//! QEMU 7.2's USART hands on a byte as soon as it is written and raises no interrupt for it, nor has QEMU the DMA; so
//! a frame is written whole, and is on the line until as much time has passed as its bytes take. TIM3 runs on from the
//! start, for an emulated timer that is started again later is late by the time that has passed.

use core::sync::atomic::{AtomicU32, Ordering};

use cortex_m::peripheral::NVIC;
use stm32f4xx_hal::gpio::PA9;
use stm32f4xx_hal::pac::{Interrupt, TIM3, USART1, interrupt};
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::rcc::Rcc;
use stm32f4xx_hal::serial::{self, Tx};
use telemetry::Frame;

use crate::downlink::BAUD;
use crate::mutation;

/// How often the line's progress is looked at, nanoseconds: not a fifth of a tick, so that within 30 s a look has come at
/// every part of a tick's 5 ms.
const LOOK_NS: u32 = 999_967;
/// What a byte takes with its start and stop bit, nanoseconds.
const BYTE_NS: u32 = (10_000_000_000 / BAUD as u64) as u32 * mutation::LINE_SLOWNESS;
/// Below the tick, as the real board's DMA (RTIC's priority 2, in the upper four bits and counted from above).
const PRIORITY: u8 = (16 - 2) << 4;

/// For how long what was sent is still on the line, nanoseconds.
static OWED: AtomicU32 = AtomicU32::new(0);

/// The time between two looks has passed.
#[interrupt]
fn TIM3() {
    // SAFETY: nobody else touches the timer once it runs.
    unsafe { &*TIM3::ptr() }.sr().modify(|_, w| w.uif().clear());
    pass(LOOK_NS);
}

/// So much time has passed, nanoseconds.
pub fn pass(ns: u32) {
    // Never an error: the closure always has a value.
    let _ = OWED.fetch_update(Ordering::AcqRel, Ordering::Acquire, |owed| Some(owed.saturating_sub(ns)));
    NVIC::pend(Interrupt::DMA2_STREAM7);
}

/// The timers count nanoseconds.
const _: () = assert!(super::TIMER_HZ == 1_000_000_000);

/// The line.
pub struct Line(Tx<USART1>);

impl Line {
    /// Takes USART1, its pin and TIM3; `None` if the USART cannot be set to [`BAUD`].
    /// After a restart something else says that time passes ([`pass`]).
    pub fn start(
        usart: USART1,
        pin: PA9,
        timer: TIM3,
        has_restarted: bool,
        nvic: &mut NVIC,
        rcc: &mut Rcc,
    ) -> Option<Self> {
        let config = serial::Config::default().baudrate(BAUD.bps());
        let usart = usart.tx(pin, config, rcc).ok()?;
        if has_restarted {
            return Some(Self(usart));
        }
        rcc.apb1enr().modify(|_, w| w.tim3en().enabled());
        // SAFETY: the emulated register has 32 bits.
        timer.arr().write(|w| unsafe { w.bits(LOOK_NS - 1) });
        timer.sr().modify(|_, w| w.uif().clear());
        timer.dier().modify(|_, w| w.uie().enabled());
        // SAFETY: the handler shares nothing with what runs now but an atomic.
        unsafe {
            nvic.set_priority(Interrupt::TIM3, PRIORITY);
            NVIC::unmask(Interrupt::TIM3);
        }
        timer.cr1().modify(|_, w| w.cen().enabled());
        Some(Self(usart))
    }

    /// Whether the next frame can go: the last one will be through before the next look.
    pub fn is_free(&mut self) -> bool {
        OWED.load(Ordering::Acquire) < LOOK_NS
    }

    /// Sends a frame on a free line.
    pub fn send(&mut self, frame: &Frame) {
        for byte in frame.bytes() {
            // The emulated USART always has room and knows no error.
            let _ = self.0.write(*byte);
        }
        OWED.fetch_add(frame.bytes().len() as u32 * BYTE_NS, Ordering::AcqRel);
    }
}
