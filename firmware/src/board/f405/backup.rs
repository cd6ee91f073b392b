//! State across a reset: the backup SRAM, and the cause of the reset.

use stm32f4xx_hal::pac::{Peripherals, RCC};
use survival::ResetSource;

/// Start of the 4 KiB of backup SRAM (RM0090 rev 21, table 1).
const BACKUP_SRAM: usize = 0x4002_4000;
/// The backup regulator is ready after at most 100 us (DS8626 rev 10, table 22: tBRR); polling it this many
/// times takes longer.
const REGULATOR_LOOKS: u32 = 20_000;

/// The retained memory: the backup SRAM, which keeps its content over a reset, and over a loss of power as
/// long as VBAT is present. It is Device memory: only aligned accesses are allowed (ARMv7-M ARM, section
/// A3.2.1).
pub const fn retained() -> *mut u32 {
    BACKUP_SRAM as *mut u32
}

/// Enables access to the backup domain, clocks its SRAM and turns its regulator on (RM0090, sections 5.1.2
/// and 7.3).
pub fn open_retained(device: &Peripherals) {
    device.RCC.apb1enr().modify(|_, w| w.pwren().enabled());
    device.PWR.cr().modify(|_, w| w.dbp().set_bit());
    device.RCC.ahb1enr().modify(|_, w| w.bkpsramen().enabled());
    device.PWR.csr().modify(|_, w| w.bre().set_bit());
    // Without the regulator the SRAM still works, but is lost with VDD. That is no reason not to start.
    let is_ready = (0..REGULATOR_LOOKS).any(|_| device.PWR.csr().read().brr().bit_is_set());
    if !is_ready {
        defmt::warn!("the backup regulator does not come up: a loss of power loses the calibration");
    }
}

/// The cause of the reset (RM0090, section 7.3.21). Clears the flags for the next one.
pub fn reset_source() -> ResetSource {
    // SAFETY: before the board has started nothing else uses the RCC, and nothing ever uses these bits.
    let rcc = unsafe { &*RCC::ptr() };
    let flags = rcc.csr().read();
    rcc.csr().modify(|_, w| w.rmvf().set_bit());
    // Every cause also pulls the reset pin.
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
