//! Guards against single faults, and a switch to remove one.
//!
//! A fault campaign that finds nothing is evidence only if it would have noticed a missing guard. With the
//! feature `removable-guards`, which no board image has, a guard can be removed at run time; without it
//! [`Guard::stands`] is a compile-time `true` and costs nothing.

/// A guard that stops one kind of fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Guard {
    /// Innovations are gated once the filter has converged.
    InnovationGate = 0,
    /// The residual's sigma is robust against outliers.
    RobustSigma = 1,
    /// Readings that no aircraft can have are refused before anything uses them.
    PlausibleReading = 2,
    /// The moving average flags a sensor only with enough readings in its window.
    FilledWindow = 3,
    /// A jump of the reference in free flight is not blamed on the sensors.
    ReferenceJump = 4,
    /// The umbilical is read until the launch is decided.
    ListenUntilDecided = 5,
    /// Only the mother ship's own messages count.
    KnownSender = 6,
    /// Near free fall overrules a closed wire only together with silence.
    ClosedWireHolds = 7,
    /// A configuration that reads back wrong is read again and rewritten before the chip is reset.
    ReadBackAgain = 8,
    /// The receiver's port speaks UBX only.
    UbxOnly = 9,
    /// The strapdown channel's tie to the reference accounts for gaps between fixes.
    TieKnowsGaps = 10,
    /// The strapdown channel bridges the gap that a reset of the inertial unit makes.
    InertialBridge = 11,
    /// Only crashes of the program count towards standby.
    OnlyCrashesCount = 12,
    /// Standby ends: the flight computer tries again, with its previous latch.
    StandbyEnds = 13,
}

impl Guard {
    /// Every guard, in the order of its bit.
    pub const ALL: [Self; 14] = [
        Self::InnovationGate,
        Self::RobustSigma,
        Self::PlausibleReading,
        Self::FilledWindow,
        Self::ReferenceJump,
        Self::ListenUntilDecided,
        Self::KnownSender,
        Self::ClosedWireHolds,
        Self::ReadBackAgain,
        Self::UbxOnly,
        Self::TieKnowsGaps,
        Self::InertialBridge,
        Self::OnlyCrashesCount,
        Self::StandbyEnds,
    ];

    /// Whether the guard is in place: true unless a campaign has removed it.
    #[must_use]
    #[inline(always)]
    #[cfg(not(feature = "removable-guards"))]
    pub const fn stands(self) -> bool {
        true
    }

    /// Whether the guard is in place: true unless a campaign has removed it.
    #[must_use]
    #[inline]
    #[cfg(feature = "removable-guards")]
    pub fn stands(self) -> bool {
        removed::BITS.load(core::sync::atomic::Ordering::Relaxed) & (1 << self as u8) == 0
    }

    /// Removes these guards in the whole process and puts all others back.
    #[cfg(feature = "removable-guards")]
    pub fn remove_only(guards: &[Self]) {
        let bits = guards.iter().fold(0, |bits, guard| bits | 1 << *guard as u8);
        removed::BITS.store(bits, core::sync::atomic::Ordering::Relaxed);
    }
}

#[cfg(feature = "removable-guards")]
mod removed {
    use core::sync::atomic::AtomicU32;

    /// One bit for each removed guard.
    pub static BITS: AtomicU32 = AtomicU32::new(0);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_guard_has_its_own_bit_and_stands() {
        for (k, guard) in Guard::ALL.into_iter().enumerate() {
            assert_eq!(guard as usize, k);
            assert!(guard.stands());
        }
    }
}
