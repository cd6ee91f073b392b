//! How the replay of a record ended.

/// Exit status of a flight computer that replays a record. QEMU and OpenOCD themselves use 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum ExitStatus {
    /// The record was flown to its end, whatever it contained; the summary reports its errors.
    Finished = 0,
    /// There is no record, or it cannot be opened.
    NoInput = 10,
    /// The record does not start with a header of this version of the format.
    NoHeader = 11,
    /// The record is for another model than the compiled-in one.
    OtherModel = 12,
    /// The mission refused its configuration.
    Configuration = 13,
    /// The results cannot be written.
    NoOutput = 14,
    /// The firmware panicked: a bug.
    Panic = 101,
    /// The core faulted: a bug.
    HardFault = 102,
    /// The firmware restarted too often within too short a time.
    Standby = 103,
}

impl ExitStatus {
    /// Every status.
    pub const ALL: [Self; 9] = [
        Self::Finished,
        Self::NoInput,
        Self::NoHeader,
        Self::OtherModel,
        Self::Configuration,
        Self::NoOutput,
        Self::Panic,
        Self::HardFault,
        Self::Standby,
    ];

    /// The status as a number.
    #[must_use]
    pub const fn code(self) -> u8 {
        self as u8
    }

    /// The status of that number, or `None`.
    #[must_use]
    pub fn from_code(code: i32) -> Option<Self> {
        Self::ALL.into_iter().find(|status| i32::from(status.code()) == code)
    }
}
