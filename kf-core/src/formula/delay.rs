//! Delays a signal, with few stored numbers.

use super::words::{BEGUN, elapsed, is_positive, wait};

/// Number of intervals between kept samples that make up the delay.
const INTERVALS: usize = 16;
/// One interval, as a fraction of the delay.
pub(super) const INTERVAL: f32 = 1.0 / INTERVALS as f32;
/// Number of samples kept.
pub(super) const KEPT: usize = INTERVALS + 1;
/// Words of a delay's memory.
pub const WORDS: usize = KEPT + 4;

/// A delay's memory: the samples in a ring; then the last argument, [`BEGUN`] or how long it waited, the time
/// since the newest sample, and the index of the oldest. Until the ring is full, the last word is [`KEPT`]
/// plus the index of the next sample, which is outside of the ring.
#[inline(always)]
pub(super) fn parts(memory: &mut [f32; WORDS]) -> Option<(&mut [f32; KEPT], &mut [f32; 4])> {
    let (ring, rest) = memory.split_first_chunk_mut::<KEPT>()?;
    Some((ring, rest.try_into().ok()?))
}

/// The value at that fraction of an interval after the oldest sample; `None` where there are too few samples.
#[inline(always)]
pub(super) fn between(ring: &[f32; KEPT], oldest: f32, part: f32) -> Option<f32> {
    let at = oldest as usize;
    let oldest = ring.get(at)?;
    let next = ring.get(if at + 1 >= KEPT { 0 } else { at + 1 })?;
    Some(oldest + (next - oldest) * part)
}

/// The argument sixteen intervals ago. Samples are an interval apart, each on the straight line between two
/// ticks; between samples the value is on a straight line too. NaN until the past is long enough.
#[inline(never)]
pub(super) fn delay(memory: &mut [f32; WORDS], argument: f32, interval_s: f32, seconds: f32) -> f32 {
    let Some((ring, [last, waited, phase_s, oldest])) = parts(memory) else {
        return f32::NAN;
    };
    if argument.is_nan() || !is_positive(interval_s) {
        wait(waited, seconds);
        return f32::NAN;
    }
    if *waited == 0.0 {
        [*last, *waited, *phase_s, *oldest] = [argument, BEGUN, 0.0, (KEPT + 1) as f32];
        ring[0] = argument;
        return f32::NAN;
    }
    let step_s = elapsed(*waited, seconds);
    let (mut due_s, mut since_s) = (interval_s - *phase_s, *phase_s + step_s);
    // After a gap of more than the whole delay, only its end counts.
    let whole_s = interval_s * KEPT as f32;
    if step_s - due_s > whole_s {
        let skipped = ((step_s - due_s - whole_s) / interval_s) as u32;
        due_s += skipped as f32 * interval_s;
    }
    for _ in 0..=KEPT {
        if since_s < interval_s {
            break;
        }
        let place = *oldest as usize;
        let at = if place < KEPT { place } else { place - KEPT };
        let sample = *last + (argument - *last) * (due_s / step_s);
        if let (Some(slot), true) = (ring.get_mut(at), sample.is_finite()) {
            *slot = sample;
        }
        *oldest = if at + 1 >= KEPT { 0.0 } else { (place + 1) as f32 };
        since_s = step_s - due_s;
        due_s += interval_s;
    }
    *phase_s = if since_s > 0.0 && since_s < interval_s { since_s } else { 0.0 };
    (*last, *waited) = (argument, BEGUN);
    between(ring, *oldest, *phase_s / interval_s).unwrap_or(f32::NAN)
}
