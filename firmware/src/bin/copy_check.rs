//! Holds the copies of aligned memory against copies byte by byte: every length, and nothing before or after. Only QEMU can
//! run it.
#![no_std]
#![no_main]

use core::ffi::c_void;
use core::panic::PanicInfo;

use cortex_m_rt::entry;
use semihosting::eprintln;
use semihosting::process::ExitCode;
// The vector table needs every interrupt of the chip.
use stm32f4xx_hal as _;

#[path = "../copies.rs"]
mod copies;

unsafe extern "C" {
    fn __aeabi_memcpy4(to: *mut c_void, from: *const c_void, count: usize);
    fn __aeabi_memcpy8(to: *mut c_void, from: *const c_void, count: usize);
}

/// Bytes of a buffer; lengths are tried up to those that leave a word on each side.
const BYTES: usize = 264;
const BEFORE: usize = 8;
const LONGEST: usize = BYTES - 2 * BEFORE;

/// At whole double words.
#[repr(align(8))]
struct Buffer([u8; BYTES]);

/// The first length at which a copy is none.
fn first_wrong(copy: unsafe extern "C" fn(*mut c_void, *const c_void, usize)) -> Option<usize> {
    let from = Buffer(core::array::from_fn(|place| (place as u8).wrapping_mul(37).wrapping_add(11)));
    (0..=LONGEST).find(|&count| {
        let mut to = Buffer([0xee; BYTES]);
        // SAFETY: both pointers are at whole double words, with at least `LONGEST` bytes behind them.
        unsafe {
            copy(to.0.as_mut_ptr().add(BEFORE).cast(), from.0.as_ptr().add(BEFORE).cast(), count);
        }
        let copied = BEFORE..BEFORE + count;
        (0..BYTES).any(|place| to.0[place] != if copied.contains(&place) { from.0[place] } else { 0xee })
    })
}

#[entry]
fn main() -> ! {
    let wrong = [first_wrong(__aeabi_memcpy4), first_wrong(__aeabi_memcpy8)];
    if let Some(count) = wrong.into_iter().flatten().next() {
        eprintln!("copy_check: {count} bytes are not copied as they should be");
        ExitCode::FAILURE.exit_process()
    }
    ExitCode::SUCCESS.exit_process()
}

#[panic_handler]
fn panicked(info: &PanicInfo) -> ! {
    eprintln!("copy_check: {info}");
    ExitCode::FAILURE.exit_process()
}
