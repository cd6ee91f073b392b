//! Counts instructions: under QEMU's `-icount shift=0` one instruction is one nanosecond of virtual
//! time, and QEMU clocks TIM2 at 1 GHz, so TIM2 counts instructions.

use core::hint::black_box;

use stm32f4xx_hal::pac::{RCC, TIM2};

/// A counter of instructions.
pub struct Counter {
    tim2: TIM2,
    overhead: u32,
}

/// What is counted: one call through a vtable, so that the same instructions make every call.
pub trait Call {
    /// The call.
    fn call(&mut self);
}

/// Instructions per call, over a number of calls.
#[derive(Clone, Copy)]
pub struct Count {
    /// The cheapest call.
    pub least: u32,
    /// The most expensive call.
    pub most: u32,
    /// The mean.
    pub mean: f32,
}

impl Counter {
    /// Starts TIM2 and measures the cost of an empty call (mostly the call and the return), to subtract it.
    ///
    /// `None` if the clock is not what this module assumes: 100 `nop`s must count as 100.
    pub fn new(tim2: TIM2, rcc: &RCC) -> Option<Self> {
        rcc.apb1enr().modify(|_, w| w.tim2en().enabled());
        tim2.psc().write(|w| w.psc().set(0));
        tim2.arr().write(|w| w.arr().set(u32::MAX));
        tim2.egr().write(|w| w.ug().set_bit());
        tim2.cr1().modify(|_, w| w.cen().enabled());
        let mut counter = Self { tim2, overhead: 0 };
        counter.overhead = counter.once(&mut Nothing);
        (counter.once(&mut Nothing) == 0 && counter.once(&mut HundredNops) == 100).then_some(counter)
    }

    /// Instructions of one call, less the overhead.
    #[inline(never)]
    fn once(&self, call: &mut dyn Call) -> u32 {
        let call = black_box(call);
        let start = self.tim2.cnt().read().bits();
        call.call();
        let end = self.tim2.cnt().read().bits();
        end.wrapping_sub(start).wrapping_sub(self.overhead)
    }

    /// Instructions of a number of calls, each after `ready`.
    pub fn count<C: Call>(&self, calls: u32, call: &mut C, mut ready: impl FnMut(&mut C)) -> Count {
        let mut count = Count { least: u32::MAX, most: 0, mean: 0.0 };
        let mut sum = 0;
        for _ in 0..calls {
            ready(call);
            let one = self.once(call);
            count.least = count.least.min(one);
            count.most = count.most.max(one);
            sum += one;
        }
        count.mean = sum as f32 / calls as f32;
        count
    }
}

struct Nothing;

impl Call for Nothing {
    fn call(&mut self) {}
}

struct HundredNops;

impl Call for HundredNops {
    fn call(&mut self) {
        // SAFETY: `nop` touches nothing.
        unsafe { core::arch::asm!(".rept 100", "nop", ".endr", options(nomem, nostack, preserves_flags)) }
    }
}
