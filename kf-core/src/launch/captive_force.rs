//! What a restart in a suspicion needs to know of the time before it. The wire has opened and the force has
//! not departed, so the cable has torn, unless the force is another now.

use super::{LaunchDetector, LaunchState};

/// Number of words of a [`CaptiveForce`].
pub const CAPTIVE_FORCE_WORDS: usize = 8;

/// The captive means of the force's character (three axes, m/s^2, and roughness, (m/s^2)^2), and its
/// variances.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CaptiveForce([f32; CAPTIVE_FORCE_WORDS]);

impl CaptiveForce {
    /// The values as words for retained memory.
    #[must_use]
    pub fn to_words(self) -> [u32; CAPTIVE_FORCE_WORDS] {
        self.0.map(f32::to_bits)
    }

    /// The values from retained memory; `None` if one is not finite.
    #[must_use]
    pub fn from_words(words: [u32; CAPTIVE_FORCE_WORDS]) -> Option<Self> {
        let values = words.map(f32::from_bits);
        values.iter().all(|value| value.is_finite()).then_some(Self(values))
    }
}

impl LaunchDetector {
    /// What the force was like under the pylon, while a launch is suspected by a wire that has opened without
    /// a departure of the force.
    #[must_use]
    #[inline(never)]
    pub fn captive_force(&self) -> Option<CaptiveForce> {
        self.unmoved_us.filter(|_| matches!(self.state, LaunchState::Suspected { .. }))?;
        let ([x, y, z, rough], [xx, yy, zz, rr]) = self.character.captive();
        Some(CaptiveForce([x, y, z, rough, xx, yy, zz, rr]))
    }

    /// Continues the suspicion of a wire that had opened without a departure of the force.
    #[inline(never)]
    pub(super) const fn resume_unmoved(&mut self, CaptiveForce(before): CaptiveForce) {
        let [x, y, z, rough, xx, yy, zz, rr] = before;
        self.character.resume([x, y, z, rough], [xx, yy, zz, rr]);
        self.unmoved_us = Some(0);
    }
}
