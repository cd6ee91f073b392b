//! State of a mission from the first suspicion of its launch on, so that it can continue after a restart.
//!
//! It holds what cannot be recovered from the configuration: the latch, the monitors with their moving
//! averages and flags, the signals and their integrals, the last fix, the counters. A mission in captive
//! flight has no snapshot: its calibration starts again.
//!
//! A snapshot is a kilobyte, too expensive for the tick that launches. It is therefore made while the launch
//! is only suspected. What changes at once, or at the confirmation, is a single word that every tick can
//! store: [`MissionMark`].

use serde::{Deserialize, Serialize};

use crate::config::MAX_ESTIMATED_EFFECTS;
use crate::effect::{FormulaWords, SignalTracker};
use crate::free_flight::{KeptFreeFlight, KeptWatch};
use crate::latch::LatchRecord;
use crate::mission::Counters;
use crate::output::Trust;
use crate::reading::StuckDetector;
use crate::reference::ReferenceTracker;
use crate::reference_check::Standing;
use crate::sensor::{SENSORS, Sensor};

/// Version of the layout: of this struct, of every type in it, and of the [`MissionMark`] that goes with it.
pub const SNAPSHOT_VERSION: u8 = 10;
/// Longest snapshot, bytes: two of them fit into the 4 KiB of an STM32F405's backup SRAM. Snapshots of the
/// largest model fit, with windows of up to 2^14 samples a bin and a month after power-on
/// (`mission::tests::resume`).
pub const MAX_SNAPSHOT_BYTES: usize = 1_920;

/// Why a snapshot was not written, not read or not accepted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SnapshotError {
    /// The buffer is too short.
    BufferTooShort,
    /// The bytes are not a snapshot.
    Format,
    /// The snapshot has another version of the layout.
    Version,
    /// The snapshot belongs to a mission with another configuration.
    OtherMission,
    /// The state was held at another suspicion of a launch, or no launch was suspected by the last tick.
    OtherLaunch,
}

/// A mission in free flight, or held for a suspected launch; made by [`crate::mission::Mission::snapshot`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MissionSnapshot {
    pub(crate) first_us: u64,
    pub(crate) last_us: u64,
    pub(crate) launch_was: bool,
    pub(crate) latch: LatchRecord,
    pub(crate) free_flight: KeptFreeFlight,
    /// Flag of the cross-check; its moving average starts again, or the largest snapshot would not fit.
    pub(crate) cross_check: Trust,
    pub(crate) signals: SignalTracker,
    pub(crate) formulas: FormulaWords,
    pub(crate) tracker: ReferenceTracker,
    pub(crate) fix_regressors_m: heapless::Vec<f32, MAX_ESTIMATED_EFFECTS>,
    pub(crate) stuck: [StuckDetector; SENSORS],
    pub(crate) last_accepted_us: [Option<u64>; SENSORS],
    pub(crate) counters: Counters,
}

impl MissionSnapshot {
    /// Time of the mission's last tick, microseconds.
    #[must_use]
    pub const fn time_us(&self) -> u64 {
        self.last_us
    }

    /// Writes version and snapshot (postcard) and returns the number of bytes of `buffer` used;
    /// [`MAX_SNAPSHOT_BYTES`] are always enough. It contains no checksum: the code that stores it adds one.
    ///
    /// # Errors
    /// [`SnapshotError::BufferTooShort`].
    // The code that writes each field is generic and compiled where this is: in the crate that stores it, for
    // size.
    #[inline]
    pub fn to_bytes(&self, buffer: &mut [u8]) -> Result<usize, SnapshotError> {
        postcard::to_slice(&(SNAPSHOT_VERSION, self), buffer)
            .map(|bytes| bytes.len())
            .map_err(|_| SnapshotError::BufferTooShort)
    }
}

/// A snapshot's bytes, read one field at a time in the order of [`MissionSnapshot`]: as a whole it takes six
/// kilobytes of stack to read, and two and a half to hold.
#[derive(Clone, Copy)]
pub(crate) struct Fields<'a>(&'a [u8]);

impl<'a> Fields<'a> {
    /// The fields of bytes with this version.
    pub(crate) fn of(bytes: &'a [u8]) -> Result<Self, SnapshotError> {
        let (version, fields) = bytes.split_first().ok_or(SnapshotError::Format)?;
        if *version == SNAPSHOT_VERSION { Ok(Self(fields)) } else { Err(SnapshotError::Version) }
    }

    /// The next field.
    #[inline(always)]
    fn next<T: Deserialize<'a>>(&mut self) -> Result<T, SnapshotError> {
        let (field, rest) = postcard::take_from_bytes(self.0).map_err(|_| SnapshotError::Format)?;
        self.0 = rest;
        Ok(field)
    }

    /// Checks that no bytes follow.
    pub(crate) const fn end(self) -> Result<(), SnapshotError> {
        if self.0.is_empty() { Ok(()) } else { Err(SnapshotError::Format) }
    }
}

/// A separate function for each field: its code is in an image once, compiled with this crate, and the
/// field's stack is freed when its caller returns.
macro_rules! fields {
    ($($(#[$doc:meta])* $name:ident: $field:ty;)*) => {
        impl Fields<'_> {
            $($(#[$doc])*
            #[inline(never)]
            pub(crate) fn $name(&mut self) -> Result<$field, SnapshotError> {
                self.next()
            })*
        }
    };
}

fields! {
    /// `first_us`, `last_us`, `launch_was`.
    times: (u64, u64, bool);
    latch: LatchRecord;
    /// The first part of `free_flight`.
    standing: Standing;
    /// The watch of each sensor that leaves with the UAV: the rest of `free_flight`.
    watch: Option<KeptWatch>;
    cross_check: Trust;
    signals: SignalTracker;
    formulas: FormulaWords;
    tracker: ReferenceTracker;
    fix_regressors_m: heapless::Vec<f32, MAX_ESTIMATED_EFFECTS>;
    stuck: [StuckDetector; SENSORS];
    last_accepted_us: [Option<u64>; SENSORS];
    counters: Counters;
}

/// Progress of the launch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Stage {
    /// Captive flight.
    #[default]
    Captive,
    /// A launch is suspected and the calibration is held.
    Suspected,
    /// Launched, and the calibration is latched.
    Launched,
}

/// Record of a mission that is stored at every tick: which snapshot goes with it, and what that snapshot may
/// lack. Small enough to be stored with the tick's time; made by [`crate::mission::Mission::mark`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MissionMark {
    /// Progress of the launch.
    pub stage: Stage,
    /// The flags that were raised.
    pub flags: RaisedFlags,
    /// Bits of [`crate::quality::FailedChecks`] of the held or latched calibration; one of them is whether
    /// the launch was confirmed.
    pub failed_checks: u16,
    /// Number of withdrawn suspicions, modulo [`Self::SUSPICIONS`]: a state held for one suspicion is not the
    /// state held for the next.
    pub suspicions: u8,
}

impl MissionMark {
    /// The count of suspicions wraps here.
    pub const SUSPICIONS: u8 = 64;
}

/// The flags raised so far, two bits each: small enough to be stored at every tick, so that none is lost
/// between two snapshots.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct RaisedFlags(u8);

impl RaisedFlags {
    /// Flags from a byte of [`Self::bits`]; a pattern that it never returns counts as the more serious flag.
    #[must_use]
    pub const fn from_bits(bits: u8) -> Self {
        Self(bits)
    }

    /// As a byte.
    #[must_use]
    pub const fn bits(self) -> u8 {
        self.0
    }

    /// The flag of a sensor.
    #[must_use]
    pub const fn of(self, sensor: Sensor) -> Option<Trust> {
        self.at(sensor as u8)
    }

    /// The flag of the cross-check.
    #[must_use]
    pub const fn of_cross_check(self) -> Option<Trust> {
        self.at(SENSORS as u8)
    }

    const fn at(self, place: u8) -> Option<Trust> {
        match self.0 >> (2 * place) & 3 {
            0 => None,
            1 => Some(Trust::Doubtful),
            _ => Some(Trust::Untrustworthy),
        }
    }

    const fn with(self, place: u8, flag: Option<Trust>) -> Self {
        let bits = match flag {
            Some(Trust::Doubtful) => 1,
            Some(Trust::Untrustworthy) => 2,
            _ => 0,
        };
        Self(self.0 | bits << (2 * place))
    }

    pub(crate) const fn with_sensor(self, sensor: Sensor, flag: Option<Trust>) -> Self {
        self.with(sensor as u8, flag)
    }

    pub(crate) const fn with_cross_check(self, flag: Option<Trust>) -> Self {
        self.with(SENSORS as u8, flag)
    }
}
