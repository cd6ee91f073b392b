//! Leaps: a sample that differs from the previous one by more than an aircraft's motion is refused and
//! bridged like a gap.

use super::vector::{Down, Vector, difference, dot, scaled};
use crate::atmosphere::STANDARD_GRAVITY_MPS2;

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
const LONGEST_BRIDGED: u8 = 200;

/// Whether any component is larger than a limit.
fn is_beyond([x, y, z]: Vector, limit: f32) -> bool {
    x.abs() > limit || y.abs() > limit || z.abs() > limit
}

/// How a sample follows the last one taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Step {
    /// As an aircraft moves.
    Usual,
    /// It leaps, and is refused.
    Leap,
    /// It is right, and the last one taken is wrong.
    Back,
}

/// A sample, or a limit: force, m/s^2, and rate, rad/s, body axes.
type Pair<T> = [T; 2];

/// How a sample follows the last one taken, after `refused` samples in a row were refused as leaps.
///
/// If a sample leaps towards rest, the last one taken is the wrong one of the two, a wild sample that was
/// just no leap: a carrier is never far from rest, and a vehicle seldom turns by more than a rate that leaps.
/// In free flight [`LONGEST_PUSH`] samples must leap so first, and a force never does: a vehicle pulls.
#[inline]
pub(super) fn follow(
    sample: Pair<Vector>,
    last: Pair<Vector>,
    down: &Down,
    is_captive: bool,
    refused: u8,
) -> Step {
    let limits = match (is_captive, refused) {
        (_, LONGEST_BRIDGED..) => return Step::Back,
        (true, _) => [CAPTIVE_FORCE_STEP_MPS2, CAPTIVE_RATE_STEP_RADPS],
        (false, 0..LONGEST_PUSH) => [FORCE_STEP_MPS2, RATE_STEP_RADPS],
        (false, _) => [NO_PUSH_MPS2, RATE_STEP_RADPS],
    };
    let [force, rate] = sample;
    let [last_force, last_rate] = last;
    let is_far = [
        is_beyond(difference(force, last_force), limits[0]),
        is_beyond(difference(rate, last_rate), limits[1]),
    ];
    if is_far == [false; 2] {
        return Step::Usual;
    }
    let may_lead_back = [is_captive, is_captive || refused >= LONGEST_PUSH];
    follow_far(sample, last, down, is_far, may_lead_back)
}

#[cold]
fn follow_far(
    [force, rate]: Pair<Vector>,
    [last_force, last_rate]: Pair<Vector>,
    down: &Down,
    is_far: Pair<bool>,
    may_lead_back: Pair<bool>,
) -> Step {
    let rest_force = scaled(down.get(), -STANDARD_GRAVITY_MPS2);
    let leads_back = [leads_back(force, last_force, rest_force), leads_back(rate, last_rate, [0.0; 3])];
    let leaps = |k: usize| is_far[k] && !(may_lead_back[k] && leads_back[k]);
    if leaps(0) || leaps(1) { Step::Leap } else { Step::Back }
}

/// Whether a sample is nearer to rest than the last one.
fn leads_back(part: Vector, last: Vector, rest: Vector) -> bool {
    let (apart, last_apart) = (difference(part, rest), difference(last, rest));
    dot(apart, apart) < dot(last_apart, last_apart)
}
