//! Handles failures that must not happen: the cause is kept in the retained memory, and the board is reset.
//! The next start reports it ([`crate::restart`]).

use core::arch::naked_asm;
use core::panic::PanicInfo;
use core::ptr;
use core::sync::atomic::{AtomicBool, Ordering};

use cortex_m::peripheral::SCB;
use survival::{Cause, CrashRecord};

use crate::board::CostClock;
use crate::{SUPERVISOR, retained, stack};

/// Stack of the fault handlers, bytes: the interrupted stack may be the fault.
const CRASH_STACK_BYTES: usize = 1_024;

#[repr(C, align(8))]
struct CrashStack([u8; CRASH_STACK_BYTES]);

static mut CRASH_STACK: CrashStack = CrashStack([0; CRASH_STACK_BYTES]);

/// CFSR: the frame could not be stacked (MSTKERR, STKERR; ARMv7-M ARM B3.2.15).
const STACKING: u32 = 1 << 4 | 1 << 12;
/// CFSR: MMFAR, BFAR hold the address (MMARVALID, BFARVALID).
const ADDRESSES_VALID: [u32; 2] = [1 << 7, 1 << 15];

#[panic_handler]
fn panicked(info: &PanicInfo) -> ! {
    /// Set by the first panic, so that a panic during its handling does not overwrite its record.
    static PANICKED: AtomicBool = AtomicBool::new(false);
    // No read-modify-write: nothing that runs after a failure returns to the code before it.
    if !PANICKED.load(Ordering::Relaxed) {
        PANICKED.store(true, Ordering::Relaxed);
        let record = context(CrashRecord::new(Cause::Panic));
        retained::record_crash(match info.location() {
            Some(location) => record.at(location.file(), location.line()),
            None => record,
        });
    }
    SCB::sys_reset()
}

/// A handler that switches to a stack known to be good, and continues with the address of the frame that the
/// core stacked on the interrupted one.
macro_rules! on_crash_stack {
    ($(#[$doc:meta])* $handler:ident => $goes_on:ident) => {
        $(#[$doc])*
        #[unsafe(naked)]
        #[unsafe(no_mangle)]
        unsafe extern "C" fn $handler() -> ! {
            naked_asm!(
                "mrs r0, msp",
                "movw r1, #:lower16:{stack}",
                "movt r1, #:upper16:{stack}",
                "add r1, r1, #{size}",
                "msr msp, r1",
                "b {goes_on}",
                stack = sym CRASH_STACK,
                size = const CRASH_STACK_BYTES,
                goes_on = sym $goes_on,
            )
        }
    };
}

on_crash_stack! {
    /// Every fault of the core.
    HardFault => faulted
}

on_crash_stack! {
    /// The watchdog's timer, at a priority that only a critical section of all interrupts masks.
    TIM4 => stuck
}

extern "C" fn faulted(frame: *const u32) -> ! {
    let record = context(interrupted(CrashRecord::new(Cause::HardFault), frame));
    let below = |address: u32| (address as usize) < stack::end();
    let [memory_valid, bus_valid] = ADDRESSES_VALID.map(|bit| record.cfsr & bit != 0);
    // The frame, or what was pushed, did not fit; an address far below has another cause.
    let is_overflow = below(frame as u32)
        || record.cfsr & STACKING != 0
        || memory_valid && below(record.mmfar) && stack::end() - record.mmfar as usize <= stack::size()
        || bus_valid && below(record.bfar) && stack::end() - record.bfar as usize <= stack::size();
    let cause = if is_overflow { Cause::StackOverflow } else { Cause::HardFault };
    retained::record_crash(CrashRecord { cause, ..record });
    SCB::sys_reset()
}

extern "C" fn stuck(frame: *const u32) -> ! {
    let record = context(interrupted(CrashRecord::new(Cause::Stuck), frame));
    retained::record_crash(CrashRecord { late: SUPERVISOR.late().bits(), ..record });
    SCB::sys_reset()
}

/// The interrupted program location: the frame that the core stacked (ARMv7-M ARM B1.5.6), if there is one.
fn interrupted(record: CrashRecord, frame: *const u32) -> CrashRecord {
    const LR: usize = 5;
    const PC: usize = 6;
    let is_frame = frame.is_aligned() && stack::contains(frame as usize, size_of::<[u32; 8]>());
    if !is_frame {
        return record;
    }
    // SAFETY: aligned words of the stack, which lies in RAM.
    let word = |index| unsafe { ptr::read_volatile(frame.wrapping_add(index)) };
    CrashRecord { lr: word(LR), pc: word(PC), ..record }
}

/// The core's fault registers.
fn context(record: CrashRecord) -> CrashRecord {
    // SAFETY: reads of the core's registers, which change nothing.
    let scb = unsafe { &*SCB::PTR };
    CrashRecord {
        cfsr: scb.cfsr.read(),
        hfsr: scb.hfsr.read(),
        mmfar: scb.mmfar.read(),
        bfar: scb.bfar.read(),
        exception: (scb.icsr.read() & 0x1ff) as u16,
        count: CostClock::time(),
        ..record
    }
}
