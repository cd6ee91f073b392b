//! The record that a crash leaves.

use serde::{Deserialize, Serialize};

/// Number of bytes kept of the name of a panic's source file: its end.
pub const PLACE_BYTES: usize = 16;

/// What ended the last run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[repr(u8)]
pub enum Cause {
    /// A reset by software that left no record: by a debugger, or by a board that could not start.
    Unrecorded = 0,
    /// A panic: a bug.
    Panic = 1,
    /// A fault of the core.
    HardFault = 2,
    /// A fault of the core with the stack at its end.
    StackOverflow = 3,
    /// A supervised activity showed no sign of life ([`crate::Supervisor`]).
    Stuck = 4,
    /// The supply was away or too low.
    Supply = 5,
    /// The reset pin.
    ResetPin = 6,
    /// The independent watchdog: all interrupts were masked, or the core itself was gone.
    IndependentWatchdog = 7,
}

impl Cause {
    const fn from_byte(byte: u8) -> Option<Self> {
        match byte {
            0 => Some(Self::Unrecorded),
            1 => Some(Self::Panic),
            2 => Some(Self::HardFault),
            3 => Some(Self::StackOverflow),
            4 => Some(Self::Stuck),
            5 => Some(Self::Supply),
            6 => Some(Self::ResetPin),
            7 => Some(Self::IndependentWatchdog),
            _ => None,
        }
    }

    /// The name used in logs and reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Unrecorded => "a reset without a record",
            Self::Panic => "a panic",
            Self::HardFault => "a hard fault",
            Self::StackOverflow => "a stack overflow",
            Self::Stuck => "something stuck",
            Self::Supply => "a loss of power",
            Self::ResetPin => "a reset by the pin",
            Self::IndependentWatchdog => "the independent watchdog",
        }
    }
}

/// The record of a crash. Values that were not available are zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct CrashRecord {
    /// What happened.
    pub cause: Cause,
    /// Bits of the late activities ([`crate::Late`]).
    pub late: u8,
    /// Number of the exception that ran (ICSR.VECTACTIVE, ARMv7-M ARM B3.2.4); 0 for none.
    pub exception: u16,
    /// Program counter at the crash.
    pub pc: u32,
    /// Link register: where the program would have returned to.
    pub lr: u32,
    /// Configurable Fault Status Register (ARMv7-M ARM B3.2.15).
    pub cfsr: u32,
    /// HardFault Status Register (B3.2.16).
    pub hfsr: u32,
    /// MemManage Fault Address Register (B3.2.18).
    pub mmfar: u32,
    /// BusFault Address Register (B3.2.19).
    pub bfar: u32,
    /// The board's free-running timer.
    pub count: u32,
    /// Line of a panic.
    pub line: u32,
    /// End of the name of its source file, padded with zeros.
    pub place: [u8; PLACE_BYTES],
}

pub(crate) const WORDS: usize = 9 + PLACE_BYTES / 4;
/// A record with its check.
pub(crate) const SEALED_WORDS: usize = WORDS + 1;

impl CrashRecord {
    /// A record with its cause only.
    #[must_use]
    pub const fn new(cause: Cause) -> Self {
        Self {
            cause,
            late: 0,
            exception: 0,
            pc: 0,
            lr: 0,
            cfsr: 0,
            hfsr: 0,
            mmfar: 0,
            bfar: 0,
            count: 0,
            line: 0,
            place: [0; PLACE_BYTES],
        }
    }

    /// Adds the place of a panic.
    #[must_use]
    pub fn at(self, file: &str, line: u32) -> Self {
        let bytes = file.as_bytes();
        let end = bytes.get(bytes.len().saturating_sub(PLACE_BYTES)..).unwrap_or_default();
        let mut place = [0; PLACE_BYTES];
        for (slot, byte) in place.iter_mut().zip(end) {
            *slot = *byte;
        }
        Self { line, place, ..self }
    }

    /// End of the name of a panic's source file; empty if there was no panic.
    #[must_use]
    pub fn file(&self) -> &str {
        let length = self.place.iter().position(|byte| *byte == 0).unwrap_or(PLACE_BYTES);
        self.place.get(..length).and_then(|name| core::str::from_utf8(name).ok()).unwrap_or_default()
    }

    pub(crate) fn to_words(self) -> [u32; WORDS] {
        let cause = u32::from(self.cause as u8) | u32::from(self.late) << 8 | u32::from(self.exception) << 16;
        let mut place = [0; PLACE_BYTES / 4];
        for (word, bytes) in place.iter_mut().zip(self.place.chunks_exact(4)) {
            *word = bytes.iter().rev().fold(0, |word, byte| word << 8 | u32::from(*byte));
        }
        let [one, two, three, four] = place;
        [
            cause, self.pc, self.lr, self.cfsr, self.hfsr, self.mmfar, self.bfar, self.count, self.line, one,
            two, three, four,
        ]
    }

    pub(crate) fn from_words(words: [u32; WORDS]) -> Option<Self> {
        let [first, pc, lr, cfsr, hfsr, mmfar, bfar, count, line, name @ ..] = words;
        let mut bytes = name.iter().flat_map(|word| word.to_le_bytes());
        Some(Self {
            cause: Cause::from_byte(first as u8)?,
            late: (first >> 8) as u8,
            exception: (first >> 16) as u16,
            pc,
            lr,
            cfsr,
            hfsr,
            mmfar,
            bfar,
            count,
            line,
            place: core::array::from_fn(|_| bytes.next().unwrap_or(0)),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comes_back_as_it_went() {
        for cause in (0..=u8::MAX).filter_map(Cause::from_byte) {
            let record = CrashRecord {
                late: 5,
                exception: 44,
                pc: 0x0800_1234,
                lr: 0xffff_fff1,
                cfsr: 0x0001_8200,
                hfsr: 1 << 30,
                mmfar: 3,
                bfar: 0x1fff_fff0,
                count: u32::MAX,
                ..CrashRecord::new(cause).at("firmware/src/mutation.rs", 77)
            };
            assert_eq!(CrashRecord::from_words(record.to_words()), Some(record));
            assert_eq!(record.file(), "/src/mutation.rs");
        }
        assert_eq!((0..=u8::MAX).filter_map(Cause::from_byte).count(), 8);
        assert_eq!(CrashRecord::new(Cause::Panic).at("a.rs", 1).file(), "a.rs");
    }
}
