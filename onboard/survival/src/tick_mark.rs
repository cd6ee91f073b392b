//! The mark that is kept at every tick.

use serde::{Deserialize, Serialize};

use crate::memory::{MARKS, WordMemory, read_sealed, write_sealed};

/// Stage of the flight.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[repr(u8)]
pub enum Flight {
    /// The UAV was under the pylon.
    Captive = 0,
    /// The UAV was in free flight.
    Free = 1,
    /// The UAV may have left; this was not decided yet.
    Suspected = 2,
    /// The UAV was under the pylon, and its break-wire was known to be broken.
    CaptiveUnwired = 3,
}

impl Flight {
    const fn from_bits(bits: u32) -> Self {
        match bits & 3 {
            1 => Self::Free,
            2 => Self::Suspected,
            3 => Self::CaptiveUnwired,
            _ => Self::Captive,
        }
    }
}

/// Time of the last tick, and state that an older snapshot cannot have.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct TickMark {
    /// The mission's time, microseconds.
    pub time_us: u64,
    /// The board's free-running timer at that tick, in the board's own unit.
    pub count: u32,
    /// Raised flags, as a byte.
    pub flags: u8,
    /// Failed checks of the held or latched calibration, as bits.
    pub failed_checks: u16,
    /// Number of the launch suspicion that a snapshot must belong to, below 64.
    pub suspicions: u8,
    /// Stage of the flight.
    pub flight: Flight,
}

const WORDS: usize = 4;
const SEALED_WORDS: usize = WORDS + 1;
pub(crate) const MARKS_WORDS: usize = 2 * SEALED_WORDS;

const fn start(place: usize) -> usize {
    MARKS + place * SEALED_WORDS
}

/// Writes marks to two places in turn: a reset during a write leaves the other mark intact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MarkWriter {
    /// Place of the older mark.
    next: usize,
}

impl MarkWriter {
    /// Continues after the existing marks.
    #[must_use]
    pub fn find(memory: &impl WordMemory) -> Self {
        let [first, second] = [0, 1].map(|place| read(memory, place));
        Self { next: usize::from(is_first_newest(first, second)) }
    }

    /// Keeps a mark in the place of the older one.
    #[inline]
    pub fn keep(&mut self, memory: &mut impl WordMemory, mark: &TickMark) {
        let bits = u32::from(mark.flags)
            | (mark.flight as u32) << 8
            | u32::from(mark.suspicions & 63) << 10
            | u32::from(mark.failed_checks) << 16;
        let words = [mark.time_us as u32, (mark.time_us >> 32) as u32, mark.count, bits];
        write_sealed(memory, start(self.next), words);
        self.next ^= 1;
    }
}

/// The newest mark whose check is right.
#[must_use]
pub fn newest_mark(memory: &impl WordMemory) -> Option<TickMark> {
    let [first, second] = [0, 1].map(|place| read(memory, place));
    if is_first_newest(first, second) { first } else { second }
}

/// Empties both places.
pub fn clear_marks(memory: &mut impl WordMemory) {
    (MARKS..MARKS + MARKS_WORDS).for_each(|word| memory.write(word, 0));
}

fn is_first_newest(first: Option<TickMark>, second: Option<TickMark>) -> bool {
    match (first, second) {
        (Some(first), Some(second)) => first.time_us >= second.time_us,
        (first, _) => first.is_some(),
    }
}

fn read(memory: &impl WordMemory, place: usize) -> Option<TickMark> {
    let [low, high, count, bits] = read_sealed(memory, start(place))?;
    Some(TickMark {
        time_us: u64::from(low) | u64::from(high) << 32,
        count,
        flags: bits as u8,
        failed_checks: (bits >> 16) as u16,
        suspicions: (bits >> 10 & 63) as u8,
        flight: Flight::from_bits(bits >> 8),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::RetainedImage;
    use proptest::prelude::*;

    fn mark(time_us: u64) -> TickMark {
        let flight = [Flight::Captive, Flight::Suspected, Flight::Free, Flight::CaptiveUnwired]
            [(time_us >> 30) as usize % 4];
        TickMark {
            time_us,
            count: time_us as u32,
            flags: 0x24,
            failed_checks: 0x8001,
            suspicions: 42,
            flight,
        }
    }

    #[test]
    fn nothing_and_garbage_are_no_mark() {
        let mut memory = RetainedImage::default();
        assert_eq!(newest_mark(&memory), None);
        memory.words_mut().fill(u32::MAX);
        assert_eq!(newest_mark(&memory), None);
    }

    proptest! {
        #[test]
        fn a_write_cut_at_any_word_leaves_this_mark_or_the_last_and_the_next_start_goes_on_from_it(
            ticks in 1_u64..20, cut in 0_u32..=SEALED_WORDS as u32,
        ) {
            let mut memory = RetainedImage::default();
            let mut writer = MarkWriter::find(&memory);
            for tick in 1..=ticks {
                writer.keep(&mut memory, &mark(tick << 30));
                prop_assert_eq!(newest_mark(&memory), Some(mark(tick << 30)));
            }
            memory.cut_after(cut);
            writer.keep(&mut memory, &mark((ticks + 1) << 30));
            let last = if cut == SEALED_WORDS as u32 { ticks + 1 } else { ticks };
            prop_assert_eq!(newest_mark(&memory), Some(mark(last << 30)));
            memory.restore_supply();
            // The next start overwrites the torn mark: cut again, the same mark is left.
            let mut writer = MarkWriter::find(&memory);
            memory.cut_after(2);
            writer.keep(&mut memory, &mark((ticks + 2) << 30));
            prop_assert_eq!(newest_mark(&memory), Some(mark(last << 30)));
        }
    }
}
