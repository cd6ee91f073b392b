//! What is kept at every tick.

use serde::{Deserialize, Serialize};

use crate::check::{opened, sealed};

/// How far the flight had come.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[repr(u8)]
pub enum Flight {
    /// The UAV was under the pylon.
    Captive = 0,
    /// It flew free.
    Free = 1,
    /// It may have left: that was not decided yet.
    Suspected = 2,
}

impl Flight {
    const fn from_bits(bits: u32) -> Self {
        match bits & 3 {
            1 => Self::Free,
            2 => Self::Suspected,
            _ => Self::Captive,
        }
    }
}

/// When the last tick was, and what a snapshot from before it can not have.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct TickMark {
    /// The mission's time, microseconds.
    pub time_us: u64,
    /// The board's free-running timer at that tick; its unit is the board's.
    pub count: u32,
    /// Raised flags, as a byte.
    pub flags: u8,
    /// Failed checks of what is held or latched, as bits.
    pub failed_checks: u16,
    /// Which suspicion of a launch a snapshot must be of, below 64.
    pub suspicions: u8,
    /// How far the flight had come.
    pub flight: Flight,
}

const WORDS: usize = 5;

/// Two marks, written in turn: a reset while one is written leaves the other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub struct TickMarks {
    marks: [[u32; WORDS]; 2],
}

impl TickMarks {
    /// None.
    pub const EMPTY: Self = Self { marks: [[0; WORDS]; 2] };

    /// Keeps a mark in the place of the older one.
    #[inline]
    pub fn keep(&mut self, mark: &TickMark) {
        let [first, second] = &mut self.marks;
        // The newest must stay whole while the other is written, whether or not the other is sound.
        let place = match (read(first), read(second)) {
            (Some(one), Some(other)) if one.time_us > other.time_us => second,
            (Some(_), None) => second,
            _ => first,
        };
        let bits = u32::from(mark.flags)
            | (mark.flight as u32) << 8
            | u32::from(mark.suspicions & 63) << 10
            | u32::from(mark.failed_checks) << 16;
        *place = sealed([mark.time_us as u32, (mark.time_us >> 32) as u32, mark.count, bits]);
    }

    /// The newest mark whose check is right.
    #[must_use]
    pub fn newest(&self) -> Option<TickMark> {
        let [first, second] = &self.marks;
        match (read(first), read(second)) {
            (Some(first), Some(second)) if second.time_us > first.time_us => Some(second),
            (None, second) => second,
            (first, _) => first,
        }
    }
}

fn read(words: &[u32; WORDS]) -> Option<TickMark> {
    let [low, high, count, bits] = opened(words)?;
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
    use proptest::prelude::*;

    fn mark(time_us: u64) -> TickMark {
        let flight = [Flight::Captive, Flight::Suspected, Flight::Free][(time_us >> 30) as usize % 3];
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
        assert_eq!(TickMarks::EMPTY.newest(), None);
        assert_eq!(TickMarks { marks: [[u32::MAX; WORDS]; 2] }.newest(), None);
    }

    proptest! {
        #[test]
        fn any_word_of_the_write_torn_leaves_this_mark_or_the_last(
            ticks in 1_u64..20, word in 0_usize..2 * WORDS, garbage in any::<u32>(),
        ) {
            let mut marks = TickMarks::EMPTY;
            let mut before = marks;
            for tick in 1..=ticks {
                before = marks;
                marks.keep(&mark(tick << 30));
                prop_assert_eq!(marks.newest(), Some(mark(tick << 30)));
            }
            // One word of what the last write changed has not come through.
            let (copy, word) = (word / WORDS, word % WORDS);
            if marks.marks[copy] != before.marks[copy] {
                marks.marks[copy][word] = garbage;
            }
            let newest = marks.newest();
            let last = (ticks > 1).then(|| mark((ticks - 1) << 30));
            prop_assert!(newest == Some(mark(ticks << 30)) || newest == last, "{:?}", newest);
        }
    }
}
