//! Memory of single operations, as numbers in the state.
//!
//! A state is all zeros at the start. Where "nothing yet" has to be told from a number it is a word of its own, so that no NaN is needed.

/// Memory of that many words from `at` on.
#[inline(always)]
pub(super) fn words<const N: usize>(state: &mut [f32], at: u8) -> Option<&mut [f32; N]> {
    state.get_mut(usize::from(at)..)?.first_chunk_mut()
}

/// What an addition keeps, and what it rounds off (Kahan, "Further remarks on reducing truncation errors", CACM 8(1), 1965). The second
/// is finite only where the first is: an infinity less a number is no finite one.
#[inline(always)]
pub(super) fn plus(sum: f32, lost: f32, addend: f32) -> (f32, f32) {
    let corrected = addend - lost;
    let value = sum + corrected;
    (value, (value - sum) - corrected)
}

/// A word that says how long an operation has waited for its argument to be a number again: 0 where it never was one, this where it was
/// one at the last tick, and else minus the seconds.
pub(super) const BEGUN: f32 = 1.0;

/// `[sum, lost, last, waited]`.
#[inline(never)]
pub(super) fn integral(
    [sum, lost, last, waited]: &mut [f32; 4],
    argument: f32,
    seconds: f32,
    launched: bool,
) -> f32 {
    if !launched {
        [*sum, *lost, *last, *waited] = [0.0; 4];
        return if argument.is_nan() { argument } else { 0.0 };
    }
    if argument.is_nan() {
        wait(waited, seconds);
        return argument;
    }
    if *waited == 0.0 {
        (*last, *waited) = (argument, BEGUN);
        return 0.0;
    }
    let step_s = elapsed(*waited, seconds);
    let (next, next_lost) = plus(*sum, *lost, 0.5 * step_s * (*last + argument));
    if !next_lost.is_finite() {
        return f32::NAN;
    }
    [*sum, *lost, *last, *waited] = [next, next_lost, argument, BEGUN];
    next
}

/// `[slope, lost, value, lost, last, waited]`.
#[inline(never)]
pub(super) fn double_integral(memory: &mut [f32; 6], argument: f32, seconds: f32, launched: bool) -> f32 {
    if !launched {
        *memory = [0.0; 6];
        return if argument.is_nan() { argument } else { 0.0 };
    }
    let [slope, slope_lost, value, value_lost, last, waited] = *memory;
    if argument.is_nan() {
        let [.., waited] = memory;
        wait(waited, seconds);
        return argument;
    }
    if waited == 0.0 {
        *memory = [0.0, 0.0, 0.0, 0.0, argument, BEGUN];
        return 0.0;
    }
    // Exact for a straight line between two arguments, as `effect::integral` is.
    let step_s = elapsed(waited, seconds);
    let (next_slope, next_slope_lost) = plus(slope, slope_lost, 0.5 * step_s * (last + argument));
    let gained = step_s * (slope + step_s * (1.0 / 6.0) * (2.0 * last + argument));
    let (next, next_lost) = plus(value, value_lost, gained);
    if !(next_slope_lost.is_finite() && next_lost.is_finite()) {
        return f32::NAN;
    }
    *memory = [next_slope, next_slope_lost, next, next_lost, argument, BEGUN];
    next
}

/// Whether it is above 0 and finite. By its bits: the compiler makes some thirty instructions of the two comparisons.
#[inline(always)]
pub(super) fn is_positive(value: f32) -> bool {
    value.to_bits().wrapping_sub(1) < f32::INFINITY.to_bits() - 1
}

/// One tick more of waiting.
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

/// `[last, waited, rate, has a rate]`. `is_new`: whether the argument's signals have a sample.
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
    let next = (argument - *last) / step_s;
    if !next.is_finite() {
        return f32::NAN;
    }
    [*last, *waited, *rate, *has_rate] = [argument, BEGUN, next, 1.0];
    next
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
        if whole_s > 0.0 { *filtered + (argument - *filtered) * (step_s / whole_s) } else { argument }
    };
    if !next.is_finite() {
        return f32::NAN;
    }
    [*filtered, *waited] = [next, BEGUN];
    next
}

/// `[mean, lost, count]`. At the first sample of the calibration it starts anew: the count is then negative. Whether there is a sample is
/// asked only where one would be taken.
#[inline(never)]
pub(super) fn captive(
    memory: &mut [f32; 3],
    argument: f32,
    is_new: impl FnOnce() -> bool,
    launched: bool,
    begins: bool,
) -> f32 {
    let [mean, lost, count] = memory;
    if begins && *count > 0.0 {
        *count = -*count;
    }
    if !launched && !argument.is_nan() && is_new() {
        let next_count = if *count < 0.0 { 1.0 } else { *count + 1.0 };
        let next = if next_count == 1.0 {
            (argument, 0.0)
        } else {
            plus(*mean, *lost, (argument - *mean) / next_count)
        };
        if next.1.is_finite() {
            (*mean, *lost) = next;
            *count = next_count;
        }
    }
    if *count == 0.0 { f32::NAN } else { *mean }
}

/// `[value, 0 none | 1 taken | 2 due anew]`.
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
