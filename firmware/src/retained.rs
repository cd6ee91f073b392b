//! The memory that a reset leaves alone.

use core::ptr;

use survival::{CrashRecord, RETAINED_WORDS, WordMemory, keep_crash};

use crate::board;

/// The board's retained memory. Each of its parts is for one owner: the marks for the tick, the snapshots for
/// the task that keeps them, the crash and the history for the start, the board's own words for the board.
pub struct RetainedWords(());

impl RetainedWords {
    /// One owner's way to its part.
    ///
    /// # Safety
    /// After the board has made the memory accessible, and for one part alone at a time.
    pub const unsafe fn claim() -> Self {
        Self(())
    }
}

impl WordMemory for RetainedWords {
    #[inline]
    fn read(&self, word: usize) -> u32 {
        if word >= RETAINED_WORDS {
            return 0;
        }
        // SAFETY: an aligned word within the board's memory, in which there is no Rust object.
        unsafe { ptr::read_volatile(board::retained().wrapping_add(word)) }
    }

    #[inline]
    fn write(&mut self, word: usize, value: u32) {
        if word < RETAINED_WORDS {
            // SAFETY: as above.
            unsafe { ptr::write_volatile(board::retained().wrapping_add(word), value) };
        }
    }
}

/// Keeps a crash. For what never returns to what it interrupted.
pub fn record_crash(record: CrashRecord) {
    // SAFETY: the crash's other owner is the start, which what crashes never goes back to.
    keep_crash(&mut unsafe { RetainedWords::claim() }, record);
}
