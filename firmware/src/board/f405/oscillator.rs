//! The registers of the clock tree (RM0090 rev 21, chapter 7), before the HAL takes over the running clock.

use core::sync::atomic::{AtomicBool, Ordering};

use stm32f4xx_hal::pac::RCC;
use survival::{ClockTree, NoClock, Oscillator, start_clock};

use super::wiring::{CORE_MHZ, CRYSTAL_MHZ};

/// The internal oscillator's frequency, MHz.
const INTERNAL_MHZ: u32 = 16;
/// The PLL's input, MHz: the one with the least jitter (RM0090, section 7.3.2).
const INPUT_MHZ: u32 = 2;
const _: () = assert!(CRYSTAL_MHZ.is_multiple_of(INPUT_MHZ));

/// Whether the core runs on the internal oscillator.
static IS_INTERNAL: AtomicBool = AtomicBool::new(false);

/// Starts the crystal, or else the internal oscillator, and the PLL.
pub fn start(rcc: &RCC) -> Result<Oscillator, NoClock> {
    let oscillator = start_clock(&mut Registers(rcc))?;
    IS_INTERNAL.store(oscillator == Oscillator::Internal, Ordering::Relaxed);
    Ok(oscillator)
}

/// Whether the core runs on the internal oscillator, because the crystal did not start.
pub fn clock_is_internal() -> bool {
    IS_INTERNAL.load(Ordering::Relaxed)
}

struct Registers<'a>(&'a RCC);

impl ClockTree for Registers<'_> {
    fn turn_crystal(&mut self, on: bool) {
        self.0.cr().modify(|_, w| w.hseon().bit(on));
    }

    fn crystal_runs(&self) -> bool {
        self.0.cr().read().hserdy().bit_is_set()
    }

    fn start_pll(&mut self, oscillator: Oscillator) {
        let is_crystal = oscillator == Oscillator::Crystal;
        let divider = if is_crystal { CRYSTAL_MHZ / INPUT_MHZ } else { INTERNAL_MHZ / INPUT_MHZ };
        // The PLL runs at twice the core's clock (P = 2, which is 0), and a seventh of that is 48 MHz (Q).
        // SAFETY: values within the fields' ranges.
        self.0.pllcfgr().write(|w| unsafe {
            w.pllm().bits(divider as u8);
            w.plln().bits((2 * CORE_MHZ / INPUT_MHZ) as u16);
            w.pllq().bits(7);
            w.pllsrc().bit(is_crystal)
        });
        self.0.cr().modify(|_, w| w.pllon().set_bit());
    }

    fn stop_pll(&mut self) {
        self.0.cr().modify(|_, w| w.pllon().clear_bit());
    }

    fn pll_is_locked(&self) -> bool {
        self.0.cr().read().pllrdy().bit_is_set()
    }
}
