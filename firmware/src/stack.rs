//! Largest use of the stack: the runtime paints the stack at reset, and this module finds how far down the
//! paint is gone.

use core::ptr;

use cortex_m_rt::STACK_PAINT_VALUE;

unsafe extern "C" {
    /// Where the stack starts; it grows down from here.
    static _stack_start: u32;
    /// Where it must end: the first word that is not a static variable.
    static _stack_end: u32;
    /// Where the static variables start.
    static __sdata: u32;
}

/// Stack use since reset.
#[derive(Clone, Copy)]
pub struct Usage {
    /// Largest use, bytes.
    pub used_bytes: u32,
    /// Size of the stack, bytes.
    pub size_bytes: u32,
}

/// Inspects the paint.
pub fn usage() -> Usage {
    let start = &raw const _stack_start;
    let end = &raw const _stack_end;
    let mut lowest = end;
    while lowest < start {
        // SAFETY: the linker script puts nothing but the stack between the two addresses, which are
        // word-aligned RAM. Volatile, because the words belong to no Rust object.
        if unsafe { ptr::read_volatile(lowest) } != STACK_PAINT_VALUE {
            break;
        }
        lowest = lowest.wrapping_add(1);
    }
    let bytes = |from: *const u32, to: *const u32| (to as usize - from as usize) as u32;
    Usage { used_bytes: bytes(lowest, start), size_bytes: bytes(end, start) }
}

/// Words at the end of the stack that the supervisor watches.
const WATCHED_WORDS: usize = 8;

/// End of the stack, as an address.
pub fn end() -> usize {
    &raw const _stack_end as usize
}

/// Size of the stack, bytes.
pub fn size() -> usize {
    &raw const _stack_start as usize - end()
}

/// Whether an overflow hits no variable: the stack lies below all of them.
pub fn is_guarded() -> bool {
    end() + size() <= &raw const __sdata as usize
}

/// Whether this many bytes from an address on lie in the stack.
pub fn contains(address: usize, bytes: usize) -> bool {
    address >= end() && address.checked_add(bytes).is_some_and(|past| past <= end() + size())
}

/// Whether the last words before the stack's end are still unwritten.
pub fn is_whole() -> bool {
    let end = &raw const _stack_end;
    (0..WATCHED_WORDS).all(|word| {
        // SAFETY: as in `usage`.
        let word = unsafe { ptr::read_volatile(end.wrapping_add(word)) };
        word == STACK_PAINT_VALUE
    })
}
