//! The memory that a reset leaves alone.

use survival::{BOARD_WORDS, CrashCell, CrashRecord, HistoryCell, RetainedMemory, Slots, TickMarks};

use crate::board;

/// The parts of the retained memory, each for one owner.
pub struct Retained {
    /// For the tick.
    pub marks: &'static mut TickMarks,
    /// For the task that keeps snapshots.
    pub slots: &'static mut Slots,
    /// For the start alone: afterwards, [`keep_crash`] has it.
    pub crash: &'static mut CrashCell,
    /// For the start.
    pub history: &'static mut HistoryCell,
}

/// Takes the memory apart; the words are the board's own.
///
/// # Safety
/// Once only, after the board has made the memory accessible.
pub unsafe fn claim() -> (Retained, &'static mut [u32; BOARD_WORDS]) {
    let memory: *mut RetainedMemory = board::retained();
    // SAFETY: the board's address is aligned RAM of that size which nothing else lies in, any bits are a
    // value of the type, and the caller promises that there is no other reference.
    unsafe {
        let retained = Retained {
            marks: &mut (*memory).marks,
            slots: &mut (*memory).slots,
            crash: &mut (*memory).crash,
            history: &mut (*memory).history,
        };
        (retained, &mut (*memory).board)
    }
}

/// Keeps a crash. For what never returns to what it interrupted.
pub fn keep_crash(record: CrashRecord) {
    let memory: *mut RetainedMemory = board::retained();
    // SAFETY: as in `claim`; the cell's other owner is the start, which what crashes never goes back to.
    let cell = unsafe { &mut (*memory).crash };
    cell.keep(record);
}
