//! Leaps: a sample that differs from the previous one by more than an aircraft's motion is refused and
//! bridged like a gap.

use super::vector::{Vector, difference, dot};

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

/// Whether a sample leads back from the last one taken, towards rest.
fn leads_back(part: Vector, last: Vector, rest: Vector) -> bool {
    let (apart, last_apart) = (difference(part, rest), difference(last, rest));
    dot(apart, apart) < dot(last_apart, last_apart)
}

/// How a sample follows the last one taken, each as [force, rate], after `refused` samples in a row were
/// refused as leaps. `rest_force`: the specific force of level flight, body axes.
///
/// If a sample leaps towards rest, the last one taken is the wrong one of the two, a wild sample that was
/// just no leap: a carrier is never far from rest, and a vehicle seldom turns by more than a rate that leaps.
/// In free flight [`LONGEST_PUSH`] samples must leap so first, and a force never does: a vehicle pulls.
pub(super) fn follow(
    [force, rate]: [Vector; 2],
    [last_force, last_rate]: [Vector; 2],
    rest_force: Vector,
    is_captive: bool,
    refused: u8,
) -> Step {
    if refused >= LONGEST_BRIDGED {
        return Step::Back;
    }
    let (force_step_mps2, rate_step_radps) = match (is_captive, refused) {
        (true, _) => (CAPTIVE_FORCE_STEP_MPS2, CAPTIVE_RATE_STEP_RADPS),
        (false, 0..LONGEST_PUSH) => (FORCE_STEP_MPS2, RATE_STEP_RADPS),
        (false, _) => (NO_PUSH_MPS2, RATE_STEP_RADPS),
    };
    let step = |part, last, limit, rest, may_lead_back| {
        if !is_beyond(difference(part, last), limit) {
            Step::Usual
        } else if may_lead_back && leads_back(part, last, rest) {
            Step::Back
        } else {
            Step::Leap
        }
    };
    let may_turn_back = is_captive || refused >= LONGEST_PUSH;
    let by_force = step(force, last_force, force_step_mps2, rest_force, is_captive);
    match (by_force, step(rate, last_rate, rate_step_radps, [0.0; 3], may_turn_back)) {
        (Step::Leap, _) | (_, Step::Leap) => Step::Leap,
        (Step::Usual, Step::Usual) => Step::Usual,
        (Step::Back, _) | (_, Step::Back) => Step::Back,
    }
}
