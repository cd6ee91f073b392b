//! Missions of any shape.

use kf_core::input::TickInput;
use kf_core::mission::Mission;
use kf_core::output::TickOutput;
use kf_core::snapshot::{MissionMark, MissionSnapshot, SnapshotError};

/// Turns a tick's input into its output: a [`Mission`] whose shape is known at compile time, or one behind a
/// pointer.
pub trait Estimation {
    /// See [`Mission::tick`].
    fn tick(&mut self, input: &TickInput) -> TickOutput;
}

impl<const HEAD: usize, const TAIL: usize, const E: usize> Estimation for Mission<HEAD, TAIL, E> {
    fn tick(&mut self, input: &TickInput) -> TickOutput {
        Self::tick(self, input)
    }
}

/// For a mission that is too large to be moved.
impl<E: Estimation> Estimation for &mut E {
    fn tick(&mut self, input: &TickInput) -> TickOutput {
        E::tick(self, input)
    }
}

/// A mission that can continue after a restart.
pub trait Retainable: Estimation {
    /// See [`Mission::last_us`].
    fn last_us(&self) -> u64;
    /// See [`Mission::mark`].
    fn mark(&self) -> MissionMark;
    /// See [`Mission::snapshot`].
    fn snapshot(&self) -> Option<MissionSnapshot>;
    /// See [`Mission::restore_snapshot`].
    ///
    /// # Errors
    /// As in [`Mission::restore_snapshot`].
    fn restore_snapshot(&mut self, bytes: &[u8], mark: &MissionMark) -> Result<u64, SnapshotError>;
}

impl<const HEAD: usize, const TAIL: usize, const E: usize> Retainable for Mission<HEAD, TAIL, E> {
    fn last_us(&self) -> u64 {
        Self::last_us(self)
    }

    fn mark(&self) -> MissionMark {
        Self::mark(self)
    }

    fn snapshot(&self) -> Option<MissionSnapshot> {
        Self::snapshot(self)
    }

    fn restore_snapshot(&mut self, bytes: &[u8], mark: &MissionMark) -> Result<u64, SnapshotError> {
        Self::restore_snapshot(self, bytes, mark)
    }
}

impl<M: Retainable> Retainable for &mut M {
    fn last_us(&self) -> u64 {
        M::last_us(self)
    }

    fn mark(&self) -> MissionMark {
        M::mark(self)
    }

    fn snapshot(&self) -> Option<MissionSnapshot> {
        M::snapshot(self)
    }

    fn restore_snapshot(&mut self, bytes: &[u8], mark: &MissionMark) -> Result<u64, SnapshotError> {
        M::restore_snapshot(self, bytes, mark)
    }
}
