//! The guards against single faults, and a switch to take one out.
//!
//! A fault campaign that finds nothing proves something only if it would have found a guard missing. With the
//! feature `removable-guards`, which no image of a board has, a guard can be taken out while the program
//! runs; without it [`Guard::stands`] is `true` when the code is compiled, and costs nothing.

/// A guard that one kind of fault is stopped by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Guard {
    /// Innovations are gated once the filter has converged.
    InnovationGate = 0,
    /// The residual's sigma is robust against outliers.
    RobustSigma = 1,
    /// Readings that no aircraft can have are refused before anything believes them.
    PlausibleReading = 2,
    /// The moving average flags a sensor only with enough readings in its window.
    FilledWindow = 3,
    /// A jump of the reference in free flight is not blamed on the sensors.
    ReferenceJump = 4,
    /// The umbilical is listened to until the launch is decided.
    ListenUntilDecided = 5,
    /// Only the mother ship's own messages count.
    KnownSender = 6,
    /// A closed wire is overruled by near free fall only together with silence.
    ClosedWireHolds = 7,
    /// A configuration that reads back wrong is read again, and rewritten, before the chip is reset.
    ReadBackAgain = 8,
    /// The receiver's port speaks UBX only.
    UbxOnly = 9,
    /// The strapdown channel's tie to the reference knows of gaps between fixes.
    TieKnowsGaps = 10,
    /// The strapdown channel bridges what a reset of the inertial unit takes.
    InertialBridge = 11,
    /// Only crashes of the program count towards standby.
    OnlyCrashesCount = 12,
    /// Standby ends: the flight computer tries again, with the latch that it had.
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

    /// Whether it stands: true, unless a campaign has taken it out.
    #[must_use]
    #[inline(always)]
    #[cfg(not(feature = "removable-guards"))]
    pub const fn stands(self) -> bool {
        true
    }

    /// Whether it stands: true, unless a campaign has taken it out.
    #[must_use]
    #[inline]
    #[cfg(feature = "removable-guards")]
    pub fn stands(self) -> bool {
        removed::BITS.load(core::sync::atomic::Ordering::Relaxed) & (1 << self as u8) == 0
    }

    /// Takes these guards out, in the whole process, and puts all others back.
    #[cfg(feature = "removable-guards")]
    pub fn remove_only(guards: &[Self]) {
        let bits = guards.iter().fold(0, |bits, guard| bits | 1 << *guard as u8);
        removed::BITS.store(bits, core::sync::atomic::Ordering::Relaxed);
    }
}

#[cfg(feature = "removable-guards")]
mod removed {
    use core::sync::atomic::AtomicU32;

    /// One bit a guard that is out.
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
