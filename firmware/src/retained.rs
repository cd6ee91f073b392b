//! Memory that a reset leaves unchanged.

use core::ptr;

use survival::{CrashRecord, RETAINED_WORDS, WordMemory, keep_crash};

use crate::board;

/// The board's retained memory. Each part has one owner: the tick owns the marks, the task that keeps
/// snapshots owns those, the start owns the crash and the history, and the board owns its own words.
pub struct RetainedWords(());

impl RetainedWords {
    /// One owner's access to its part.
    ///
    /// # Safety
    /// Call it after the board has made the memory accessible, and for only one part at a time.
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

/// Records a crash. For handlers that never return to what they interrupted.
pub fn record_crash(record: CrashRecord) {
    // SAFETY: the crash record's other owner is the start, and execution never returns to it after a crash.
    keep_crash(&mut unsafe { RetainedWords::claim() }, record);
}
