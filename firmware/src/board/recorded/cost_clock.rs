//! What a tick costs: TIM5's count, without the models' work.

use core::sync::atomic::{AtomicU32, Ordering};

use chip_models::metered::WorkObserver;
use flight_record::CostUnit;
use stm32f4xx_hal::pac::TIM5;

use super::machine;

/// Counts the flight computer's instructions, or cycles: TIM5, which is this clock's alone once it runs,
/// without those of the models of its chips.
#[derive(Clone, Copy)]
pub struct CostClock;

/// What the models of the chips have taken, counts of [`CostClock`].
static MODELS_WORK: AtomicU32 = AtomicU32::new(0);

/// Keeps the models' work out of the count.
#[derive(Clone, Copy)]
pub struct ModelsWork;

impl WorkObserver for ModelsWork {
    fn begin(&mut self) -> u32 {
        CostClock::time()
    }

    fn end(&mut self, begun: u32) {
        let took = CostClock::time().wrapping_sub(begun);
        // No read-modify-write is needed: only a tick polls sensors, and nothing interrupts it that does.
        MODELS_WORK.store(MODELS_WORK.load(Ordering::Relaxed).wrapping_add(took), Ordering::Relaxed);
    }
}

impl CostClock {
    /// What it counts.
    pub const UNIT: CostUnit = machine::COST_UNIT;

    pub(super) fn start(tim5: &TIM5, rcc: &stm32f4xx_hal::pac::RCC) {
        rcc.apb1enr().modify(|_, w| w.tim5en().enabled());
        tim5.psc().write(|w| w.psc().set(0));
        tim5.arr().write(|w| w.arr().set(u32::MAX));
        tim5.egr().write(|w| w.ug().set_bit());
        tim5.cr1().modify(|_, w| w.cen().enabled());
    }

    /// What share of a tick that is, per mille: none can be said. Instructions are no time, and the cycles
    /// are of another clock than the flight's.
    pub const fn permille_of_a_tick(_cost: u32) -> Option<u16> {
        None
    }

    /// Since the last reset, where that is known.
    pub fn since_reset() -> Option<u32> {
        machine::since_reset()
    }

    /// Now, for what a tick costs: without the models' work; wrapping.
    pub fn now() -> u32 {
        Self::time().wrapping_sub(MODELS_WORK.load(Ordering::Relaxed))
    }

    /// Now, for when a tick begins: all work, wrapping.
    pub fn time() -> u32 {
        // SAFETY: a read of the counter, which changes nothing; nobody else has TIM5.
        unsafe { (*TIM5::ptr()).cnt().read().bits() }
    }
}
