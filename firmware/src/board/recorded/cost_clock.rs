//! The cost of a tick: TIM5's count, without the work of the chip models.

use core::sync::atomic::{AtomicU32, Ordering};

use chip_models::metered::WorkObserver;
use flight_record::CostUnit;
use stm32f4xx_hal::pac::TIM5;

use super::machine;

/// Counts the flight computer's instructions or cycles with TIM5, which only this clock uses once it runs.
/// The work of the models of its chips is excluded.
#[derive(Clone, Copy)]
pub struct CostClock;

/// The work of the chip models, counts of [`CostClock`].
static MODELS_WORK: AtomicU32 = AtomicU32::new(0);

/// Excludes the models' work from the count.
#[derive(Clone, Copy)]
pub struct ModelsWork;

impl WorkObserver for ModelsWork {
    fn begin(&mut self) -> u32 {
        CostClock::time()
    }

    fn end(&mut self, begun: u32) {
        let took = CostClock::time().wrapping_sub(begun);
        // No read-modify-write is needed: only a tick polls sensors, and no interrupt of a tick does.
        MODELS_WORK.store(MODELS_WORK.load(Ordering::Relaxed).wrapping_add(took), Ordering::Relaxed);
    }
}

impl CostClock {
    /// Unit of the cost.
    pub const UNIT: CostUnit = machine::COST_UNIT;

    pub(super) fn start(tim5: &TIM5, rcc: &stm32f4xx_hal::pac::RCC) {
        rcc.apb1enr().modify(|_, w| w.tim5en().enabled());
        tim5.psc().write(|w| w.psc().set(0));
        tim5.arr().write(|w| w.arr().set(u32::MAX));
        tim5.egr().write(|w| w.ug().set_bit());
        tim5.cr1().modify(|_, w| w.cen().enabled());
    }

    /// A cost as a share of a tick, per mille: not defined. Instructions are not time, and the cycles are
    /// those of another clock than the flight's.
    pub const fn permille_of_a_tick(_cost: u32) -> Option<u16> {
        None
    }

    /// Counts since the last reset, if known.
    pub fn since_reset() -> Option<u32> {
        machine::since_reset()
    }

    /// Current count without the models' work, for the cost of a tick; wraps.
    pub fn now() -> u32 {
        Self::time().wrapping_sub(MODELS_WORK.load(Ordering::Relaxed))
    }

    /// Current count including all work, for the start of a tick; wraps.
    pub fn time() -> u32 {
        // SAFETY: reading the counter changes nothing; nothing else uses TIM5.
        unsafe { (*TIM5::ptr()).cnt().read().bits() }
    }
}
