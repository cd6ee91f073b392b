//! Memory of single operations, as numbers in the state.
//!
//! A state is all zeros at the start. Where "nothing yet" must be distinguished from a number, it has a word
//! of its own, so that no NaN is needed.

/// Memory of `N` words from `at` on.
#[inline(always)]
pub(super) fn words<const N: usize>(state: &mut [f32], at: u8) -> Option<&mut [f32; N]> {
    state.get_mut(usize::from(at)..)?.first_chunk_mut()
}

/// The rounded sum, and the part that rounding lost (Kahan, "Further remarks on reducing truncation errors",
/// CACM 8(1), 1965). The second is finite only where the first is: infinity less a number is not finite.
#[inline(always)]
fn plus(sum: f32, lost: f32, addend: f32) -> (f32, f32) {
    let corrected = addend - lost;
    let value = sum + corrected;
    (value, (value - sum) - corrected)
}

/// Word that records how long an operation has waited for its argument to be a number again: 0 if it never
/// was one, this value if it was one at the last tick, otherwise minus the seconds since.
pub(super) const BEGUN: f32 = 1.0;

/// Adds a step to `[sum, lost, last, waited]` by the trapezium rule. `None`, with nothing stored, if the sum
/// is not finite.
#[inline(always)]
pub(super) fn add_trapezium([sum, lost, last, _]: &mut [f32; 4], argument: f32, step_s: f32) -> Option<f32> {
    let (next, next_lost) = plus(*sum, *lost, 0.5 * step_s * (*last + argument));
    if !next_lost.is_finite() {
        return None;
    }
    (*sum, *lost, *last) = (next, next_lost, argument);
    Some(next)
}

/// `[sum, lost, last, waited]`.
#[inline(never)]
pub(super) fn integral(memory: &mut [f32; 4], argument: f32, seconds: f32, launched: bool) -> f32 {
    if !launched {
        *memory = [0.0; 4];
        return if argument.is_nan() { argument } else { 0.0 };
    }
    let [.., last, waited] = memory;
    if argument.is_nan() {
        wait(waited, seconds);
        return argument;
    }
    if *waited == 0.0 {
        (*last, *waited) = (argument, BEGUN);
        return 0.0;
    }
    let step_s = elapsed(*waited, seconds);
    let value = add_trapezium(memory, argument, step_s);
    begun(value, &mut memory[3])
}

/// Adds a step to `[slope, lost, value, lost, last, waited]`, exact for a straight line between two
/// arguments, as `effect::integral` does. `None`, with nothing stored, if a sum is not finite.
#[inline(always)]
pub(super) fn add_twice(
    [slope, slope_lost, value, lost, last, _]: &mut [f32; 6],
    argument: f32,
    step_s: f32,
) -> Option<f32> {
    let gained = step_s * (*slope + step_s * (1.0 / 6.0) * (2.0 * *last + argument));
    let (next_slope, next_slope_lost) = plus(*slope, *slope_lost, 0.5 * step_s * (*last + argument));
    let (next, next_lost) = plus(*value, *lost, gained);
    if !(next_slope_lost.is_finite() && next_lost.is_finite()) {
        return None;
    }
    (*slope, *slope_lost, *value, *lost, *last) = (next_slope, next_slope_lost, next, next_lost, argument);
    Some(next)
}

/// `[slope, lost, value, lost, last, waited]`.
#[inline(never)]
pub(super) fn double_integral(memory: &mut [f32; 6], argument: f32, seconds: f32, launched: bool) -> f32 {
    if !launched {
        *memory = [0.0; 6];
        return if argument.is_nan() { argument } else { 0.0 };
    }
    let [.., last, waited] = memory;
    if argument.is_nan() {
        wait(waited, seconds);
        return argument;
    }
    if *waited == 0.0 {
        (*last, *waited) = (argument, BEGUN);
        return 0.0;
    }
    let step_s = elapsed(*waited, seconds);
    let value = add_twice(memory, argument, step_s);
    begun(value, &mut memory[5])
}

/// The value, if there is one; the operation then stops waiting.
#[inline(always)]
fn begun(value: Option<f32>, waited: &mut f32) -> f32 {
    match value {
        Some(value) => {
            *waited = BEGUN;
            value
        }
        None => f32::NAN,
    }
}

/// Whether the value is above 0 and finite. Tested on its bits: for the two comparisons the compiler emits
/// some thirty instructions.
#[inline(always)]
pub(super) fn is_positive(value: f32) -> bool {
    value.to_bits().wrapping_sub(1) < f32::INFINITY.to_bits() - 1
}

/// Counts one more tick of waiting.
#[inline(always)]
pub(super) fn wait(waited: &mut f32, seconds: f32) {
    if *waited != 0.0 {
        let before_s = if *waited == BEGUN { 0.0 } else { -*waited };
        let now_s = before_s + seconds;
        if is_positive(now_s) {
            *waited = -now_s;
        }
    }
}

/// Seconds since the last argument.
#[inline(always)]
pub(super) fn elapsed(waited: f32, seconds: f32) -> f32 {
    if waited == BEGUN { seconds } else { seconds - waited }
}

/// Takes a new sample into `[last, waited, rate, has a rate]`. `None`, with nothing stored, if the rate is
/// not finite.
#[inline(always)]
pub(super) fn add_sample(
    [last, _, rate, has_rate]: &mut [f32; 4],
    argument: f32,
    step_s: f32,
) -> Option<f32> {
    let next = (argument - *last) / step_s;
    if !next.is_finite() {
        return None;
    }
    (*last, *rate, *has_rate) = (argument, next, 1.0);
    Some(next)
}

/// `[last, waited, rate, has a rate]`. `is_new`: whether the argument's signals have a new sample.
#[inline(never)]
pub(super) fn rate(memory: &mut [f32; 4], argument: f32, seconds: f32, is_new: bool) -> f32 {
    let [last, waited, rate, has_rate] = memory;
    if *waited == 0.0 {
        if !argument.is_nan() {
            (*last, *waited) = (argument, BEGUN);
        }
        return f32::NAN;
    }
    if argument.is_nan() || !is_new {
        wait(waited, seconds);
        return if *has_rate == 0.0 || argument.is_nan() { f32::NAN } else { *rate };
    }
    let step_s = elapsed(*waited, seconds);
    let value = add_sample(memory, argument, step_s);
    begun(value, &mut memory[1])
}

/// A first-order low pass after a step towards `argument`, by the backward Euler rule; `whole_s` is the time
/// constant plus the step.
#[inline(always)]
pub(super) fn towards(filtered: f32, argument: f32, step_s: f32, whole_s: f32) -> f32 {
    filtered + (argument - filtered) * (step_s / whole_s)
}

/// `[filtered, waited]`.
#[inline(never)]
pub(super) fn low_pass([filtered, waited]: &mut [f32; 2], argument: f32, time_s: f32, seconds: f32) -> f32 {
    if argument.is_nan() || time_s.is_nan() || time_s < 0.0 {
        wait(waited, seconds);
        return f32::NAN;
    }
    let next = if *waited == 0.0 {
        argument
    } else {
        let step_s = elapsed(*waited, seconds);
        let whole_s = time_s + step_s;
        if whole_s > 0.0 { towards(*filtered, argument, step_s, whole_s) } else { argument }
    };
    if !next.is_finite() {
        return f32::NAN;
    }
    [*filtered, *waited] = [next, BEGUN];
    next
}

/// Adds a sample to `[mean, lost, count]`. Returns whether the mean is finite; if not, nothing is stored.
#[inline(always)]
pub(super) fn add_to_mean([mean, lost, count]: &mut [f32; 3], argument: f32) -> bool {
    let next_count = *count + 1.0;
    let (next, next_lost) = plus(*mean, *lost, (argument - *mean) / next_count);
    if !next_lost.is_finite() {
        return false;
    }
    (*mean, *lost, *count) = (next, next_lost, next_count);
    true
}

/// `[mean, lost, count]`. The mean restarts at the first sample of the calibration: until then the count is
/// negative. `is_new` is called only where a sample would be taken.
#[inline(never)]
pub(super) fn captive(
    memory: &mut [f32; 3],
    argument: f32,
    is_new: impl FnOnce() -> bool,
    launched: bool,
    begins: bool,
) -> f32 {
    if begins && memory[2] > 0.0 {
        memory[2] = -memory[2];
    }
    if !launched && !argument.is_nan() && is_new() {
        if memory[2] > 0.0 {
            add_to_mean(memory, argument);
        } else {
            *memory = [argument, 0.0, 1.0];
        }
    }
    let [mean, _, count] = *memory;
    if count == 0.0 { f32::NAN } else { mean }
}

/// `[value, 0 none | 1 taken | 2 to be taken again]`.
#[inline(never)]
pub(super) fn at_calibration(
    [value, has]: &mut [f32; 2],
    argument: f32,
    is_new: impl FnOnce() -> bool,
    begins: bool,
) -> f32 {
    if begins && *has == 1.0 {
        *has = 2.0;
    }
    if *has != 1.0 && !argument.is_nan() && is_new() {
        (*value, *has) = (argument, 1.0);
    }
    if *has == 0.0 { f32::NAN } else { *value }
}

/// `[value, has]`.
#[inline(never)]
pub(super) fn at_launch([value, has]: &mut [f32; 2], argument: f32, launched: bool) -> f32 {
    if (!launched || *has == 0.0) && !argument.is_nan() {
        (*value, *has) = (argument, 1.0);
    }
    if !launched && argument.is_nan() || *has == 0.0 { f32::NAN } else { *value }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn what_is_rounded_off_is_finite_only_where_the_sum_is(
            sum in proptest::num::f32::NORMAL,
            lost in proptest::num::f32::NORMAL,
            addend in proptest::num::f32::ANY,
        ) {
            let (value, rounded_off) = plus(sum, lost, addend);
            prop_assert!(value.is_finite() || !rounded_off.is_finite(), "{sum} {lost} {addend}: {value} {rounded_off}");
        }

        #[test]
        fn positive_is_above_zero_and_finite(value in proptest::num::f32::ANY) {
            prop_assert_eq!(is_positive(value), value > 0.0 && value.is_finite(), "{}", value);
        }
    }

    #[test]
    fn positive_has_its_bounds_right() {
        for value in
            [0.0, -0.0, f32::from_bits(1), f32::MAX, f32::INFINITY, f32::NEG_INFINITY, f32::NAN, -1.0]
        {
            assert_eq!(is_positive(value), value > 0.0 && value.is_finite(), "{value}");
        }
    }
}
