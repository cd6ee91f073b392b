//! The climb rate of the fixes: evidence of a fall that does not depend on the accelerometer.

/// A loss of climb rate that no mother ship flies in the time of a suspicion, m/s: in 3 s it is a push-over
/// to 0.83 g, which she does not begin, with a vehicle under her, in the moment in which its cable tears.
/// Near free fall takes 0.7 s for it.
const FALL_MPS: f32 = 5.0;
/// Change of climb rate that a released vehicle makes sooner or later, m/s. One that leaves with a share of
/// its weight on its own wings loses some metres a second before it has levelled out; one that carries itself
/// changes its climb rate as soon as it is steered. In a few seconds gusts and swings of a mother ship move
/// her by half of it.
const OWN_MPS: f32 = 2.0;
/// The same later: in a minute she moves by twice as much, from the bottom of her swings to the top.
const LATER_MPS: f32 = 4.0;
/// Largest age of a fix that counts, microseconds: at 1 Hz, one may be late.
const FRESH_US: u64 = 1_500_000;
/// No aircraft of this class climbs or sinks faster, m/s.
const FASTEST_MPS: f32 = 500.0;

#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Climb {
    last_us: Option<u64>,
    last_mps: f32,
    captive_us: Option<u64>,
    captive_mps: f32,
}

impl Climb {
    /// Takes a fix's climb rate, upward, m/s.
    pub(super) fn take(&mut self, now_us: u64, climb_mps: f32, is_captive: bool) {
        // NaN is refused too.
        if climb_mps.is_nan() || climb_mps.abs() > FASTEST_MPS {
            return;
        }
        self.last_us = Some(now_us);
        self.last_mps = climb_mps;
        if is_captive {
            self.captive_us = Some(now_us);
            self.captive_mps = climb_mps;
        }
    }

    /// Whether it has fallen since the suspicion began at that time.
    pub(super) fn has_fallen(&self, since_us: u64) -> bool {
        self.was_known(since_us) && self.captive_mps - self.last_mps >= FALL_MPS
    }

    /// Whether it has changed since the suspicion began, which is soon after that or later: weak evidence,
    /// used where nothing else on board can show a release.
    pub(super) fn is_another(&self, is_soon: bool) -> bool {
        (self.captive_mps - self.last_mps).abs() >= if is_soon { OWN_MPS } else { LATER_MPS }
    }

    /// Whether a fall would have been seen.
    #[inline(never)]
    pub(super) fn is_known(&self, since_us: u64, now_us: u64) -> bool {
        self.was_known(since_us)
            && self.last_us.is_some_and(|last_us| now_us.saturating_sub(last_us) <= FRESH_US)
    }

    #[inline(never)]
    fn was_known(&self, since_us: u64) -> bool {
        self.captive_us.is_some_and(|captive_us| since_us.saturating_sub(captive_us) <= FRESH_US)
    }
}
