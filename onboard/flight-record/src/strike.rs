//! Blows: faults injected into an emulated flight, to prove that it survives them.

use core::ffi::CStr;

/// Name of the file of blows, in the directory where the emulator runs.
pub const STRIKES_FILE: &CStr = c"strikes";
/// Bytes of one blow.
pub const STRIKE_BYTES: usize = 9;

/// Kind of a blow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Blow {
    /// A reset without a record: a brown-out.
    Reset = 1,
    /// A panic in the tick.
    Panic = 2,
    /// A fault of the core in the tick.
    Fault = 3,
    /// The tick never ends.
    HangTick = 4,
    /// The task that writes results never ends.
    HangReport = 5,
    /// The tick calls itself until the stack is used up.
    StackOverflow = 6,
    /// One bit of the newest snapshot flips, then a reset.
    FlipBit = 7,
    /// Garbage replaces both snapshots, then a reset.
    Garbage = 8,
    /// Both snapshots become another model's, then a reset.
    OtherModel = 9,
    /// Both snapshots get other contents with a right check, then a reset.
    NoSnapshot = 10,
}

impl Blow {
    /// Every blow.
    pub const ALL: [Self; 10] = [
        Self::Reset,
        Self::Panic,
        Self::Fault,
        Self::HangTick,
        Self::HangReport,
        Self::StackOverflow,
        Self::FlipBit,
        Self::Garbage,
        Self::OtherModel,
        Self::NoSnapshot,
    ];
}

/// A blow and its time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Strike {
    /// Kind of the blow.
    pub blow: Blow,
    /// The blow comes at the end of the first tick at or after this time, microseconds. A tick that a restart
    /// skips has no blow.
    pub time_us: u64,
}

impl Strike {
    /// Converts it to bytes of the file.
    #[must_use]
    pub fn to_bytes(self) -> [u8; STRIKE_BYTES] {
        let [a, b, c, d, e, f, g, h] = self.time_us.to_le_bytes();
        [self.blow as u8, a, b, c, d, e, f, g, h]
    }

    /// Converts from bytes of the file; `None` if they are invalid.
    #[must_use]
    pub fn from_bytes([blow, a, b, c, d, e, f, g, h]: [u8; STRIKE_BYTES]) -> Option<Self> {
        let blow = Blow::ALL.into_iter().find(|known| *known as u8 == blow)?;
        Some(Self { blow, time_us: u64::from_le_bytes([a, b, c, d, e, f, g, h]) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comes_back_as_it_went() {
        for blow in Blow::ALL {
            let strike = Strike { blow, time_us: 1 << 50 };
            assert_eq!(Strike::from_bytes(strike.to_bytes()), Some(strike));
        }
        assert_eq!(Strike::from_bytes([0; STRIKE_BYTES]), None);
    }
}
