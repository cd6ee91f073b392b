//! Leaps: a sample that is further from the one before than an aircraft moves in between is refused, and
//! bridged like a gap.

use super::vector::{Vector, difference};

/// Largest changes between two samples that an aircraft makes, m/s^2 and rad/s: 700 g a second, and 400
/// rad/s^2 at 200 samples a second. One bit of a sample that is flipped and matters (4 g, 125 deg/s of the
/// unit's 16 g and 2,000 deg/s) is more.
const FORCE_STEP_MPS2: f32 = 35.0;
const RATE_STEP_RADPS: f32 = 2.0;
/// After so many such forces in a row it is the aircraft: a push, a motor that is lit.
const LONGEST_PUSH: u8 = 2;
/// But not 12 g: what pushes builds up over 10 ms or more, and is within that of the last sample taken by
/// then. A sign that is flipped is 16 g.
const NO_PUSH_MPS2: f32 = 120.0;
/// Under the pylon nothing pushes: a force that leaps by 1.5 g is refused for a second, which is bridged; and
/// so is, always, a turn rate that leaps. No less than that, for at the release it leaps before the wire says
/// so.
const CAPTIVE_FORCE_STEP_MPS2: f32 = 15.0;
/// Likewise: 100 rad/s^2, ten times what a light carrier rolls with, and above what its engine shakes a gyro
/// by. Smaller leaps that last are the velocity match's to find.
const CAPTIVE_RATE_STEP_RADPS: f32 = 0.5;
/// So many samples in a row are right, and the one that was taken before them is not.
pub(super) const LONGEST_BRIDGED: u8 = 200;

/// Whether any part is larger than a limit.
fn is_beyond([x, y, z]: Vector, limit: f32) -> bool {
    x.abs() > limit || y.abs() > limit || z.abs() > limit
}

/// Whether a sample leaps from the last one that was taken, [force, rate] both, after so many in a row that
/// were refused for that.
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
