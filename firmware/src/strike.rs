//! Planted blows that the flight has to survive: the emulated board reads them from a file
//! ([`flight_record::Strike`]). There are none unless the build asks for them (`PYLON_MUTATE=strike`).

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
    use survival::{PAYLOAD_BYTES, Slots};

    use crate::board;
    use crate::flown_model::FINGERPRINT;

    static STRIKES: Mutex<RefCell<(u64, Vec<Strike, 8>)>> = Mutex::new(RefCell::new((0, Vec::new())));
    static HANG_REPORT: AtomicBool = AtomicBool::new(false);

    /// Reads the blows; those before `resumed_us` have struck.
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

    /// Strikes at the end of a tick what is due by it.
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
            Some(Blow::FlipBit) => poison(|slots| {
                let place = slots.recover(FINGERPRINT).places[0];
                let bytes = core::ptr::from_mut(slots).cast::<u8>();
                let copy = size_of::<Slots>() / 2;
                // SAFETY: within the copies, of which any bits are a value.
                unsafe { *bytes.add(place * copy + 100) ^= 0x10 };
            }),
            Some(Blow::Garbage) => poison(|slots| {
                let bytes = core::ptr::from_mut(slots).cast::<u8>();
                for offset in 0..size_of::<Slots>() {
                    // SAFETY: as above.
                    unsafe { *bytes.add(offset) = (offset * 31 + 7) as u8 };
                }
            }),
            Some(Blow::OtherModel) => poison(|slots| fill(slots, FINGERPRINT ^ 1)),
            Some(Blow::NoSnapshot) => poison(|slots| fill(slots, FINGERPRINT)),
        }
    }

    /// Hangs in the task that writes results.
    pub fn hang_report() {
        if HANG_REPORT.load(Ordering::Relaxed) {
            loop {}
        }
    }

    fn fill(slots: &mut Slots, model: u64) {
        slots.clear();
        for _ in 0..2 {
            let _ = slots.keep(model, |buffer| {
                *buffer = [kf_core::snapshot::SNAPSHOT_VERSION; PAYLOAD_BYTES];
                Some(1_500)
            });
        }
    }

    fn poison(how: impl FnOnce(&mut Slots)) -> ! {
        // SAFETY: nobody else looks at them any more.
        how(unsafe { &mut (*board::retained()).slots });
        SCB::sys_reset()
    }

    #[expect(unconditional_recursion, reason = "planted")]
    fn deeper(depth: u32) -> u32 {
        let frame = black_box([depth; 16]);
        black_box(deeper(depth + 1)) + black_box(frame)[3]
    }
}
