//! The independent watchdog (RM0090 rev 21, chapter 21).

use stm32f4xx_hal::pac::IWDG;

/// Reload value of the independent watchdog, whose clock of 17 to 47 kHz (DS8626, table 41) is divided by 32:
/// at least 0.4 s, so that the timer of [`crate::watchdog::Watchdog`] expires first, and at most 1.2 s.
const INDEPENDENT_RELOAD: u16 = 600;
/// Its timeout at the clock's typical 32 kHz, microseconds.
pub const INDEPENDENT_WATCHDOG_US: u64 = INDEPENDENT_RELOAD as u64 * 1_000;

/// Feeds the independent watchdog (RM0090, section 21.4.1).
pub fn feed_independent_watchdog() {
    const FEED: u16 = 0xaaaa;
    // SAFETY: a write to the key register, which accepts this key at any time.
    unsafe { (*IWDG::ptr()).kr().write(|w| w.bits(FEED)) };
}

/// Starts it; nothing stops it.
pub fn start_independent_watchdog(watchdog: &IWDG) {
    const START: u16 = 0xcccc;
    const UNLOCK: u16 = 0x5555;
    // SAFETY: the keys, the divider by 32 and the reload are those of the manual. The updates take five of
    // its clocks and need no waiting: nothing else is written until the first feed.
    unsafe {
        watchdog.kr().write(|w| w.bits(START));
        watchdog.kr().write(|w| w.bits(UNLOCK));
        watchdog.pr().write(|w| w.bits(3));
        watchdog.rlr().write(|w| w.bits(INDEPENDENT_RELOAD));
    }
}
