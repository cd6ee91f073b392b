//! The mission, whatever its shape.

use kf_core::input::TickInput;
use kf_core::mission::Mission;
use kf_core::output::TickOutput;
use kf_core::snapshot::{MissionMark, MissionSnapshot, SnapshotError};

/// What takes a tick's input and says what it means: a [`Mission`] whose shape is known when it is compiled,
/// or one behind a pointer.
pub trait Estimation {
    /// See [`Mission::tick`].
    fn tick(&mut self, input: &TickInput) -> TickOutput;
}

impl<const HEAD: usize, const TAIL: usize, const E: usize> Estimation for Mission<HEAD, TAIL, E> {
    fn tick(&mut self, input: &TickInput) -> TickOutput {
        Self::tick(self, input)
    }
}

/// Where it is too large to be moved about.
impl<E: Estimation> Estimation for &mut E {
    fn tick(&mut self, input: &TickInput) -> TickOutput {
        E::tick(self, input)
    }
}

/// A mission that a restart can go on with.
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
    /// As there.
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
