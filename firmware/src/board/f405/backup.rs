//! What a reset leaves: the backup SRAM, and what the reset was.

use stm32f4xx_hal::pac::{Peripherals, RCC};
use survival::ResetSource;

/// Start of the 4 KiB of backup SRAM (RM0090 rev 21, table 1).
const BACKUP_SRAM: usize = 0x4002_4000;
/// The backup regulator is ready after at most 100 us (DS8626 rev 10, table 22: tBRR); so many looks at
/// it take longer.
const REGULATOR_LOOKS: u32 = 20_000;

/// The retained memory: the backup SRAM, which keeps its content over a reset, and over a loss of power as
/// long as VBAT is there. It is Device memory: only aligned accesses are allowed (ARMv7-M ARM, section
/// A3.2.1).
pub const fn retained() -> *mut u32 {
    BACKUP_SRAM as *mut u32
}

/// Opens the backup domain, clocks its SRAM and turns its regulator on (RM0090, sections 5.1.2 and 7.3).
pub fn open_retained(device: &Peripherals) {
    device.RCC.apb1enr().modify(|_, w| w.pwren().enabled());
    device.PWR.cr().modify(|_, w| w.dbp().set_bit());
    device.RCC.ahb1enr().modify(|_, w| w.bkpsramen().enabled());
    device.PWR.csr().modify(|_, w| w.bre().set_bit());
    // Without it the SRAM works all the same, but is lost with VDD: no reason not to start.
    let is_ready = (0..REGULATOR_LOOKS).any(|_| device.PWR.csr().read().brr().bit_is_set());
    if !is_ready {
        defmt::warn!("the backup regulator does not come up: a loss of power loses the calibration");
    }
}

/// What the reset was (RM0090, section 7.3.21); the flags are cleared for the next.
pub fn reset_source() -> ResetSource {
    // SAFETY: before the board has started nobody else has the RCC, and these bits nobody ever.
    let rcc = unsafe { &*RCC::ptr() };
    let flags = rcc.csr().read();
    rcc.csr().modify(|_, w| w.rmvf().set_bit());
    // Every one pulls the pin as well.
    if flags.porrstf().bit_is_set() || flags.borrstf().bit_is_set() {
        ResetSource::Supply
    } else if flags.wdgrstf().bit_is_set() {
        ResetSource::IndependentWatchdog
    } else if flags.sftrstf().bit_is_set() {
        ResetSource::Software
    } else {
        ResetSource::Pin
    }
}
