//! Leaps: a sample that differs from the previous one by more than an aircraft's motion is refused and
//! bridged like a gap.

use super::vector::{Vector, difference};

/// Largest changes between two samples that an aircraft makes, m/s^2 and rad/s: 700 g a second, and 400
/// rad/s^2 at 200 samples a second. A flipped bit that matters (4 g, 125 deg/s of the unit's 16 g and 2,000
/// deg/s) is larger.
const FORCE_STEP_MPS2: f32 = 35.0;
const RATE_STEP_RADPS: f32 = 2.0;
/// After this many such forces in a row it is the aircraft: a push, or a motor igniting.
const LONGEST_PUSH: u8 = 2;
/// But not 12 g: a push builds up over 10 ms or more, and is by then within that of the last sample taken. A
/// flipped sign is 16 g.
const NO_PUSH_MPS2: f32 = 120.0;
/// Nothing pushes in captive flight: a force that leaps by 1.5 g is refused for a second, which is bridged,
/// and a turn rate that leaps is always refused. The limit is no lower because at the release the force leaps
/// before the wire reports it.
const CAPTIVE_FORCE_STEP_MPS2: f32 = 15.0;
/// Likewise: 100 rad/s^2, ten times the roll of a light carrier, and above what its engine shakes a gyro by.
/// The velocity match must find smaller leaps that last.
const CAPTIVE_RATE_STEP_RADPS: f32 = 0.5;
/// This many samples in a row are right, and the sample taken before them is wrong.
pub(super) const LONGEST_BRIDGED: u8 = 200;

/// Whether any component is larger than a limit.
fn is_beyond([x, y, z]: Vector, limit: f32) -> bool {
    x.abs() > limit || y.abs() > limit || z.abs() > limit
}

/// Whether a sample leaps from the last one taken, each as [force, rate], after `refused` samples in a row
/// were refused as leaps.
pub(super) fn is_leap(
    [force, rate]: [Vector; 2],
    [last_force, last_rate]: [Vector; 2],
    is_captive: bool,
    refused: u8,
) -> bool {
    let (force_step_mps2, rate_step_radps) = match (is_captive, refused) {
        (true, _) => (CAPTIVE_FORCE_STEP_MPS2, CAPTIVE_RATE_STEP_RADPS),
        (false, 0..LONGEST_PUSH) => (FORCE_STEP_MPS2, RATE_STEP_RADPS),
        (false, _) => (NO_PUSH_MPS2, RATE_STEP_RADPS),
    };
    refused < LONGEST_BRIDGED
        && (is_beyond(difference(force, last_force), force_step_mps2)
            || is_beyond(difference(rate, last_rate), rate_step_radps))
}
