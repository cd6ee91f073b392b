//! A signal as it was some time ago, from few numbers.

use super::words::{BEGUN, elapsed, is_positive, wait};

/// Intervals of the delay between samples that are kept.
const INTERVALS: usize = 16;
const KEPT: usize = INTERVALS + 1;
/// Words of a delay's memory.
pub const WORDS: usize = KEPT + 5;

/// The argument `delay_s` ago: samples on a grid of a sixteenth of the delay, each on the straight line between two ticks, and straight
/// lines between those. NaN until there is enough of the past.
///
/// Memory: the samples in a ring, the last argument, [`BEGUN`] or how long it waited, the time since the newest sample, where that is,
/// how many there are.
pub(super) fn delay(memory: &mut [f32; WORDS], argument: f32, delay_s: f32, seconds: f32) -> f32 {
    let Some((ring, [last, waited, phase_s, newest, count])) = memory
        .split_first_chunk_mut::<KEPT>()
        .and_then(|(ring, rest)| Some((ring, <&mut [f32; 5]>::try_from(rest).ok()?)))
    else {
        return f32::NAN;
    };
    let interval_s = delay_s * (1.0 / INTERVALS as f32);
    if argument.is_nan() || !is_positive(interval_s) {
        wait(waited, seconds);
        return f32::NAN;
    }
    if *waited == 0.0 {
        [*last, *waited, *phase_s, *newest, *count] = [argument, BEGUN, 0.0, 0.0, 1.0];
        ring[0] = argument;
        return f32::NAN;
    }
    let step_s = elapsed(*waited, seconds);
    let from_s = *phase_s;
    let mut due_s = interval_s - from_s;
    // After a gap of more than the whole delay, only its end counts.
    let whole_s = interval_s * KEPT as f32;
    if step_s - due_s > whole_s {
        let skipped = ((step_s - due_s - whole_s) / interval_s) as u32;
        due_s += skipped as f32 * interval_s;
    }
    for _ in 0..=KEPT {
        if due_s > step_s {
            break;
        }
        let at = *newest as usize + 1;
        let at = if at >= KEPT { 0 } else { at };
        let sample = *last + (argument - *last) * (due_s / step_s);
        if let (Some(slot), true) = (ring.get_mut(at), sample.is_finite()) {
            *slot = sample;
        }
        *newest = at as f32;
        *count = if *count < KEPT as f32 { *count + 1.0 } else { KEPT as f32 };
        due_s += interval_s;
    }
    let since_s = step_s - (due_s - interval_s);
    *phase_s = if since_s > 0.0 && since_s < interval_s { since_s } else { 0.0 };
    (*last, *waited) = (argument, BEGUN);
    if *count < KEPT as f32 {
        return f32::NAN;
    }
    let oldest = *newest as usize + 1;
    let oldest = if oldest >= KEPT { 0 } else { oldest };
    let next = if oldest + 1 >= KEPT { 0 } else { oldest + 1 };
    match (ring.get(oldest), ring.get(next)) {
        (Some(oldest), Some(next)) => oldest + (next - oldest) * (*phase_s / interval_s),
        _ => f32::NAN,
    }
}
