//! Compares copies and fills of memory with the same done byte by byte: every length, at every offset in a
//! word that is allowed, and nothing before or after. Runs only in QEMU.
#![no_std]
#![no_main]

use core::ffi::{c_int, c_void};
use core::panic::PanicInfo;

use cortex_m_rt::entry;
use semihosting::eprintln;
use semihosting::process::ExitCode;
// The vector table needs every interrupt of the chip.
use stm32f4xx_hal as _;

#[path = "../copies.rs"]
mod copies;

unsafe extern "C" {
    fn __aeabi_memcpy(to: *mut c_void, from: *const c_void, count: usize);
    fn __aeabi_memcpy4(to: *mut c_void, from: *const c_void, count: usize);
    fn __aeabi_memcpy8(to: *mut c_void, from: *const c_void, count: usize);
    fn __aeabi_memset4(to: *mut c_void, count: usize, byte: c_int);
    fn __aeabi_memset8(to: *mut c_void, count: usize, byte: c_int);
    fn __aeabi_memclr4(to: *mut c_void, count: usize);
    fn __aeabi_memclr8(to: *mut c_void, count: usize);
}

/// Size of a buffer, bytes; the longest lengths tried leave a word on each side.
const BYTES: usize = 264;
const BEFORE: usize = 8;
const LONGEST: usize = BYTES - 2 * BEFORE;
/// Initial content of the buffer.
const BEFOREHAND: u8 = 0xee;

/// Aligned to double words.
#[repr(align(8))]
struct Buffer([u8; BYTES]);

type Copy = unsafe extern "C" fn(*mut c_void, *const c_void, usize);

/// The first length and offsets in a word at which a copy is wrong.
fn first_wrong_copy(copy: Copy, places: usize) -> Option<[usize; 3]> {
    let from = Buffer(core::array::from_fn(|place| (place as u8).wrapping_mul(37).wrapping_add(11)));
    let tried =
        (0..places).flat_map(|a| (0..places).flat_map(move |b| (0..=LONGEST - 4).map(move |n| [n, a, b])));
    tried.into_iter().find(|&[count, to_place, from_place]| {
        let mut to = Buffer([BEFOREHAND; BYTES]);
        let (to_start, from_start) = (BEFORE + to_place, BEFORE + from_place);
        // SAFETY: both pointers have at least `LONGEST - 4` bytes behind them, and are aligned to double
        // words if only offset 0 is tried.
        unsafe {
            copy(to.0.as_mut_ptr().add(to_start).cast(), from.0.as_ptr().add(from_start).cast(), count);
        }
        (0..BYTES).any(|place| {
            let copied = place.checked_sub(to_start).filter(|nth| *nth < count);
            to.0[place] != copied.map_or(BEFOREHAND, |nth| from.0[from_start + nth])
        })
    })
}

/// The first length at which a fill with that byte is wrong.
fn first_wrong_fill(fill: impl Fn(*mut c_void, usize), byte: u8) -> Option<[usize; 3]> {
    let wrong = (0..=LONGEST).find(|&count| {
        let mut to = Buffer([BEFOREHAND; BYTES]);
        fill(to.0[BEFORE..].as_mut_ptr().cast(), count);
        let filled = BEFORE..BEFORE + count;
        (0..BYTES).any(|place| to.0[place] != if filled.contains(&place) { byte } else { BEFOREHAND })
    });
    wrong.map(|count| [count, 0, 0])
}

#[entry]
fn main() -> ! {
    // SAFETY: `first_wrong_fill` passes a pointer aligned to double words with as many bytes behind it. Only
    // the low byte of the int is used.
    let wrong = unsafe {
        [
            ("memcpy", first_wrong_copy(__aeabi_memcpy, 4)),
            ("memcpy4", first_wrong_copy(__aeabi_memcpy4, 1)),
            ("memcpy8", first_wrong_copy(__aeabi_memcpy8, 1)),
            ("memset4", first_wrong_fill(|to, count| __aeabi_memset4(to, count, 0x35a), 0x5a)),
            ("memset8", first_wrong_fill(|to, count| __aeabi_memset8(to, count, -1), 0xff)),
            ("memclr4", first_wrong_fill(|to, count| __aeabi_memclr4(to, count), 0)),
            ("memclr8", first_wrong_fill(|to, count| __aeabi_memclr8(to, count), 0)),
        ]
    };
    if let Some((name, [count, to, from])) =
        wrong.into_iter().find_map(|(name, wrong)| wrong.map(|wrong| (name, wrong)))
    {
        eprintln!("copy_check: {name} of {count} bytes to place {to} from place {from} is wrong");
        ExitCode::FAILURE.exit_process()
    }
    ExitCode::SUCCESS.exit_process()
}

#[panic_handler]
fn panicked(info: &PanicInfo) -> ! {
    eprintln!("copy_check: {info}");
    ExitCode::FAILURE.exit_process()
}
