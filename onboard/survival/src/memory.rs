//! Memory that a reset leaves unchanged, and the layout of its contents.
//!
//! It is read and written in whole aligned words only. The backup SRAM of an STM32F405 is in the peripherals'
//! part of the address space, which is Device memory (ARMv7-M ARM, section B3.1): an unaligned access faults
//! there, and a copy routine may make some. Bytes are therefore assembled in ordinary memory.

use crate::check::of_words;
use crate::crash::{self, CrashRecord};
use crate::history::{self, History};
use crate::slots::SLOTS_WORDS;
use crate::tick_mark::MARKS_WORDS;

/// Number of words reserved for the board.
pub const BOARD_WORDS: usize = 8;
/// First word of the marks.
pub(crate) const MARKS: usize = 0;
/// First word of the snapshots' copies.
pub(crate) const SLOTS: usize = MARKS + MARKS_WORDS;
const CRASH: usize = SLOTS + SLOTS_WORDS;
/// Two copies of the history, written one after the other: a reset in between leaves one of them intact.
const HISTORIES: [usize; 2] =
    [CRASH + crash::SEALED_WORDS, CRASH + crash::SEALED_WORDS + history::SEALED_WORDS];
/// First of the board's own words.
pub const BOARD: usize = HISTORIES[1] + history::SEALED_WORDS;
/// Words of what the force was like under the pylon.
const FORCE_WORDS: usize = 8;
const FORCE: usize = BOARD + BOARD_WORDS;
/// Number of words in all: they fit into the 4 KiB of an STM32F405's backup SRAM.
pub const RETAINED_WORDS: usize = FORCE + FORCE_WORDS + 1;
const _: () = assert!(RETAINED_WORDS <= 1_024);

/// Memory of [`RETAINED_WORDS`] words that a reset leaves unchanged. Its initial content is arbitrary; the
/// checks decide which of it is valid.
pub trait WordMemory {
    /// The word at that place; 0 beyond the end.
    fn read(&self, word: usize) -> u32;

    /// Writes a word; does nothing beyond the end. Writes take effect in the order of their calls.
    fn write(&mut self, word: usize, value: u32);
}

/// Words from `start` on, if the check after them is right.
#[inline]
pub(crate) fn read_sealed<const N: usize>(memory: &impl WordMemory, start: usize) -> Option<[u32; N]> {
    let words: [u32; N] = core::array::from_fn(|word| memory.read(start + word));
    (of_words(&words) == memory.read(start + N)).then_some(words)
}

/// Writes words from `start` on, and their check after them.
#[inline]
pub(crate) fn write_sealed<const N: usize>(memory: &mut impl WordMemory, start: usize, words: [u32; N]) {
    let check = of_words(&words);
    for (word, value) in words.into_iter().chain([check]).enumerate() {
        memory.write(start + word, value);
    }
}

/// Keeps the record of a crash.
pub fn keep_crash(memory: &mut impl WordMemory, record: CrashRecord) {
    write_sealed(memory, CRASH, record.to_words());
}

/// Returns the record of a crash, and clears it.
pub fn take_crash(memory: &mut impl WordMemory) -> Option<CrashRecord> {
    let record = read_sealed(memory, CRASH).and_then(CrashRecord::from_words);
    (CRASH..CRASH + crash::SEALED_WORDS).for_each(|word| memory.write(word, 0));
    record
}

/// The restarts since power-on; none if neither copy is valid.
#[must_use]
pub fn history(memory: &impl WordMemory) -> History {
    HISTORIES
        .into_iter()
        .find_map(|start| read_sealed(memory, start))
        .map(History::from_words)
        .unwrap_or_default()
}

/// Keeps the restarts.
pub fn keep_history(memory: &mut impl WordMemory, history: History) {
    HISTORIES.into_iter().for_each(|start| write_sealed(memory, start, history.to_words()));
}

/// What the force was like under the pylon, if its check is right: `CaptiveForce` of the launch detector.
#[inline(never)]
pub fn captive_force(memory: &impl WordMemory) -> Option<[u32; FORCE_WORDS]> {
    read_sealed(memory, FORCE)
}

/// Keeps what the force is like under the pylon. A reset meanwhile leaves nothing of it.
#[inline(never)]
pub fn keep_captive_force(memory: &mut impl WordMemory, words: [u32; FORCE_WORDS]) {
    write_sealed(memory, FORCE, words);
}

/// Retained memory on the host: in the state after power-on until something is written. Its supply can be cut
/// at any word of a write.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RetainedImage {
    words: [u32; RETAINED_WORDS],
    writes_left: Option<u32>,
}

impl Default for RetainedImage {
    fn default() -> Self {
        Self { words: [0; RETAINED_WORDS], writes_left: None }
    }
}

impl RetainedImage {
    /// Keeps this many more writes, and then none until [`Self::restore_supply`].
    pub const fn cut_after(&mut self, writes: u32) {
        self.writes_left = Some(writes);
    }

    /// Whether a write has been lost since [`Self::cut_after`].
    #[must_use]
    pub const fn is_cut(&self) -> bool {
        matches!(self.writes_left, Some(0))
    }

    /// Keeps writes again.
    pub const fn restore_supply(&mut self) {
        self.writes_left = None;
    }

    /// Its words, to inspect or to change.
    pub const fn words_mut(&mut self) -> &mut [u32; RETAINED_WORDS] {
        &mut self.words
    }
}

impl WordMemory for RetainedImage {
    fn read(&self, word: usize) -> u32 {
        self.words.get(word).copied().unwrap_or(0)
    }

    fn write(&mut self, word: usize, value: u32) {
        match &mut self.writes_left {
            Some(0) => return,
            Some(left) => *left -= 1,
            None => {}
        }
        if let Some(kept) = self.words.get_mut(word) {
            *kept = value;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Cause;

    #[test]
    fn a_crash_is_reported_once() {
        let mut memory = RetainedImage::default();
        assert_eq!(take_crash(&mut memory), None);
        let record = CrashRecord::new(Cause::Stuck);
        keep_crash(&mut memory, record);
        assert_eq!((take_crash(&mut memory), take_crash(&mut memory)), (Some(record), None));
    }

    #[test]
    fn a_history_survives_a_cut_at_any_word_of_its_write() {
        let old = History::default().with_restart(true, 5, 6);
        let new = old.with_restart(true, 50, 60);
        for writes in 0..=2 * history::SEALED_WORDS as u32 {
            let mut memory = RetainedImage::default();
            keep_history(&mut memory, old);
            memory.cut_after(writes);
            keep_history(&mut memory, new);
            let expected = if writes >= history::SEALED_WORDS as u32 { new } else { old };
            assert_eq!(history(&memory), expected, "{writes}");
        }
        assert_eq!(history(&RetainedImage::default()), History::default());
    }

    #[test]
    fn nothing_lies_over_anything_else() {
        let mut memory = RetainedImage::default();
        keep_crash(&mut memory, CrashRecord::new(Cause::Panic));
        keep_history(&mut memory, History::default().with_restart(false, 1, 2));
        for word in BOARD..RETAINED_WORDS {
            assert_eq!(memory.read(word), 0);
            memory.write(word, u32::MAX);
        }
        memory.write(RETAINED_WORDS, 1);
        assert_eq!(memory.read(RETAINED_WORDS), 0);
        assert_eq!(history(&memory).restarts, 1);
        assert_eq!(take_crash(&mut memory), Some(CrashRecord::new(Cause::Panic)));
    }
}
