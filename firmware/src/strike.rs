//! Planted strikes that the flight must survive: the emulated board reads them from a file
//! ([`flight_record::Strike`]). Only a build that asks for them (`PYLON_MUTATE=strike`) has any.

#[cfg(not(pylon_mutate = "strike"))]
mod none {
    pub const fn arm(_resumed_us: u64) {}
    pub const fn strike(_now_us: u64) {}
    pub const fn hang_report() {}
}
#[cfg(not(pylon_mutate = "strike"))]
pub use none::{arm, hang_report, strike};

#[cfg(pylon_mutate = "strike")]
pub use planted::{arm, hang_report, strike};

#[cfg(pylon_mutate = "strike")]
#[expect(clippy::panic, clippy::empty_loop, reason = "planted")]
mod planted {
    use core::cell::RefCell;
    use core::hint::black_box;
    use core::sync::atomic::{AtomicBool, Ordering};

    use cortex_m::interrupt::Mutex;
    use cortex_m::peripheral::SCB;
    use flight_record::{Blow, STRIKE_BYTES, STRIKES_FILE, Strike};
    use heapless::Vec;
    use semihosting::fs::File;
    use semihosting::io::Read;
    use survival::{BOARD, PAYLOAD_BYTES, SlotOrder, WordMemory};

    use crate::retained::RetainedWords;
    use flown_mission::FINGERPRINT;

    static STRIKES: Mutex<RefCell<(u64, Vec<Strike, 8>)>> = Mutex::new(RefCell::new((0, Vec::new())));
    static HANG_REPORT: AtomicBool = AtomicBool::new(false);

    /// Reads the strikes; those before `resumed_us` are over.
    pub fn arm(resumed_us: u64) {
        let Ok(mut file) = File::open(STRIKES_FILE) else { return };
        cortex_m::interrupt::free(|token| {
            let mut strikes = STRIKES.borrow(token).borrow_mut();
            strikes.0 = resumed_us;
            let mut bytes = [0; STRIKE_BYTES];
            while file.read(&mut bytes).is_ok_and(|read| read == STRIKE_BYTES) {
                if let Some(strike) = Strike::from_bytes(bytes) {
                    let _ = strikes.1.push(strike);
                }
            }
        });
    }

    /// Executes the strike that is due, at the end of a tick.
    pub fn strike(now_us: u64) {
        let due = cortex_m::interrupt::free(|token| {
            let (last_us, strikes) = &mut *STRIKES.borrow(token).borrow_mut();
            let due = strikes.iter().find(|strike| (*last_us..=now_us).contains(&strike.time_us)).copied();
            *last_us = now_us.saturating_add(1);
            due
        });
        match due.map(|strike| strike.blow) {
            None => {}
            Some(Blow::Reset) => SCB::sys_reset(),
            Some(Blow::Panic) => panic!("planted"),
            Some(Blow::Fault) => cortex_m::asm::udf(),
            Some(Blow::HangTick) => loop {},
            Some(Blow::HangReport) => HANG_REPORT.store(true, Ordering::Relaxed),
            Some(Blow::StackOverflow) => {
                black_box(deeper(0));
            }
            Some(Blow::FlipBit) => poison(|memory| {
                let newest = order(memory).newest_first[0];
                // A word of the newest copy's payload.
                let word = 10 + newest * (6 + PAYLOAD_BYTES / 4) + 30;
                memory.write(word, memory.read(word) ^ 0x10);
            }),
            Some(Blow::Garbage) => poison(|memory| {
                // The copies, between the marks and the words after them.
                for word in 10..10 + 2 * (6 + PAYLOAD_BYTES / 4) {
                    memory.write(word, (word as u32).wrapping_mul(0x9e37_79b9) | 1);
                }
            }),
            Some(Blow::OtherModel) => poison(|memory| fill(memory, FINGERPRINT ^ 1)),
            Some(Blow::NoSnapshot) => poison(|memory| fill(memory, FINGERPRINT)),
        }
    }

    /// Hangs the task that writes results.
    pub fn hang_report() {
        if HANG_REPORT.load(Ordering::Relaxed) {
            loop {}
        }
    }

    fn order(memory: &RetainedWords) -> SlotOrder {
        SlotOrder::find(memory, FINGERPRINT, &mut [0; PAYLOAD_BYTES])
    }

    fn fill(memory: &mut RetainedWords, model: u64) {
        let mut order = order(memory);
        for _ in 0..2 {
            let _ = order.keep(memory, model, &[kf_core::snapshot::SNAPSHOT_VERSION; 1_500]);
        }
    }

    fn poison(how: impl FnOnce(&mut RetainedWords)) -> ! {
        const { assert!(BOARD > 10 + 2 * (6 + PAYLOAD_BYTES / 4)) };
        // SAFETY: nothing else accesses it any more.
        how(&mut unsafe { RetainedWords::claim() });
        SCB::sys_reset()
    }

    #[expect(unconditional_recursion, reason = "planted")]
    fn deeper(depth: u32) -> u32 {
        let frame = black_box([depth; 16]);
        black_box(deeper(depth + 1)) + black_box(frame)[3]
    }
}
