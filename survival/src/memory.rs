//! The layout of what is kept.

use crate::crash::{self, CrashRecord};
use crate::history::{self, History};
use crate::slots::Slots;
use crate::tick_mark::TickMarks;

/// Words that the board keeps for itself.
pub const BOARD_WORDS: usize = 8;
/// Size of [`RetainedMemory`], bytes: it fits into the 4 KiB of an STM32F405's backup SRAM.
pub const RETAINED_BYTES: usize = size_of::<RetainedMemory>();
const _: () = assert!(RETAINED_BYTES <= 4_096);

/// Everything that is kept. Any bits at all are a value of it, so it can lie over memory that nobody has
/// initialised; what of it can be believed, its checks say.
#[derive(Clone, Debug, PartialEq, Eq)]
#[repr(C)]
pub struct RetainedMemory {
    /// Kept at every tick.
    pub marks: TickMarks,
    /// The mission's snapshots.
    pub slots: Slots,
    /// The last crash.
    pub crash: CrashCell,
    /// The restarts since power-on.
    pub history: HistoryCell,
    /// The board's own.
    pub board: [u32; BOARD_WORDS],
}

impl RetainedMemory {
    /// As a clean start leaves it.
    pub const EMPTY: Self = Self {
        marks: TickMarks::EMPTY,
        slots: Slots::EMPTY,
        crash: CrashCell([0; crash::SEALED_WORDS]),
        history: HistoryCell([0; history::SEALED_WORDS]),
        board: [0; BOARD_WORDS],
    };
}

/// Room for one crash.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(transparent)]
pub struct CrashCell([u32; crash::SEALED_WORDS]);

impl CrashCell {
    /// Keeps the record of a crash.
    pub fn keep(&mut self, record: CrashRecord) {
        self.0 = record.to_words();
    }

    /// The record of a crash, once.
    pub fn take(&mut self) -> Option<CrashRecord> {
        let record = CrashRecord::from_words(&self.0);
        self.0 = [0; crash::SEALED_WORDS];
        record
    }
}

/// Room for the restarts since power-on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(transparent)]
pub struct HistoryCell([u32; history::SEALED_WORDS]);

impl HistoryCell {
    /// The restarts; none if they can not be believed.
    #[must_use]
    pub fn get(&self) -> History {
        History::from_words(&self.0).unwrap_or_default()
    }

    /// Keeps the restarts.
    pub fn keep(&mut self, history: History) {
        self.0 = history.to_words();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Cause;

    #[test]
    fn a_crash_is_told_of_once() {
        let mut memory = RetainedMemory::EMPTY;
        assert_eq!(memory.crash.take(), None);
        let record = CrashRecord::new(Cause::Stuck);
        memory.crash.keep(record);
        assert_eq!((memory.crash.take(), memory.crash.take()), (Some(record), None));
        memory.history.keep(History::default().with_restart(5));
        assert_eq!(memory.history.get().restarts, 1);
        memory.history.0[0] ^= 1;
        assert_eq!(memory.history.get(), History::default());
    }
}
