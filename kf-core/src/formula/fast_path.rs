//! Fast paths of the operations with memory, for the common tick: the argument is a number, as at the last
//! tick, and a delay has no sample to take.
//!
//! They are inlined, and test only what separates the common tick from the others. `None` means another tick,
//! with the memory unchanged: the general function in `words` or `delay` then does the work. The arithmetic
//! is written once, there; a property test checks that both give the same bits.

use super::delay;
use super::words::{BEGUN, add_sample, add_to_mean, add_trapezium, add_twice, towards, wait};

/// Whether the argument was a number at the last tick.
#[inline(always)]
fn has_begun(waited: f32) -> bool {
    waited.to_bits() == BEGUN.to_bits()
}

/// As [`super::words::integral`].
#[inline(always)]
pub(super) fn integral(memory: &mut [f32; 4], argument: f32, seconds: f32, launched: bool) -> Option<f32> {
    if launched && has_begun(memory[3]) { add_trapezium(memory, argument, seconds) } else { None }
}

/// As [`super::words::double_integral`].
#[inline(always)]
pub(super) fn double_integral(
    memory: &mut [f32; 6],
    argument: f32,
    seconds: f32,
    launched: bool,
) -> Option<f32> {
    if launched && has_begun(memory[5]) { add_twice(memory, argument, seconds) } else { None }
}

/// As [`super::words::rate`].
#[inline(always)]
pub(super) fn rate(memory: &mut [f32; 4], argument: f32, seconds: f32, is_new: bool) -> Option<f32> {
    if is_new {
        return if has_begun(memory[1]) { add_sample(memory, argument, seconds) } else { None };
    }
    let [_, waited, rate, has_rate] = memory;
    if argument.is_nan() || *has_rate == 0.0 {
        return None;
    }
    wait(waited, seconds);
    Some(*rate)
}

/// As [`super::words::low_pass`]; `time_s` is above 0.
#[inline(always)]
pub(super) fn low_pass(
    [filtered, waited]: &mut [f32; 2],
    argument: f32,
    time_s: f32,
    seconds: f32,
) -> Option<f32> {
    if !has_begun(*waited) {
        return None;
    }
    let next = towards(*filtered, argument, seconds, time_s + seconds);
    if !next.is_finite() {
        return None;
    }
    *filtered = next;
    Some(next)
}

/// As [`super::words::captive`].
#[inline(always)]
pub(super) fn captive(
    memory: &mut [f32; 3],
    argument: f32,
    is_new: impl FnOnce() -> bool,
    launched: bool,
    begins: bool,
) -> Option<f32> {
    if begins || memory[2] <= 0.0 || (!launched && is_new() && !add_to_mean(memory, argument)) {
        return None;
    }
    Some(memory[0])
}

/// As [`super::words::at_launch`].
#[inline(always)]
pub(super) fn at_launch([value, has]: &mut [f32; 2], argument: f32, launched: bool) -> Option<f32> {
    if *has == 0.0 {
        return None;
    }
    if !launched {
        if argument.is_nan() {
            return None;
        }
        *value = argument;
    }
    Some(*value)
}

/// As [`delay::delay`] where no sample is due. The value may be infinite; the caller checks it.
#[inline(always)]
pub(super) fn delay(
    memory: &mut [f32; delay::WORDS],
    argument: f32,
    interval_s: f32,
    seconds: f32,
) -> Option<f32> {
    let (ring, [last, waited, phase_s, oldest]) = delay::parts(memory)?;
    let since_s = *phase_s + seconds;
    if !has_begun(*waited) || argument.is_nan() || since_s >= interval_s {
        return None;
    }
    let value = delay::between(ring, *oldest, since_s / interval_s)?;
    (*last, *phase_s) = (argument, since_s);
    Some(value)
}

#[cfg(test)]
mod tests {
    use super::super::words;
    use super::*;
    use proptest::prelude::*;

    /// Runs the fast path and the general function tick by tick. Wherever the fast path has a value, both
    /// must agree in value and memory, to the bit; elsewhere it must have changed nothing. Returns how many
    /// ticks the fast path served.
    fn agree<const N: usize>(
        ticks: &[(f32, bool, bool, bool)],
        fast: impl Fn(&mut [f32; N], (f32, bool, bool, bool)) -> Option<f32>,
        general: impl Fn(&mut [f32; N], (f32, bool, bool, bool)) -> f32,
    ) -> Result<usize, TestCaseError> {
        let mut memory = [0.0; N];
        let mut served = 0;
        for tick in ticks {
            let mut fast_memory = memory;
            let answer = fast(&mut fast_memory, *tick);
            let before = memory;
            let value = general(&mut memory, *tick);
            match answer {
                // The caller must reject a delay's infinite value.
                Some(answer) if answer.is_finite() => {
                    served += 1;
                    prop_assert_eq!(answer.to_bits(), value.to_bits(), "{:?} at {:?}", tick, before);
                    prop_assert_eq!(
                        fast_memory.map(f32::to_bits),
                        memory.map(f32::to_bits),
                        "{:?} at {:?}",
                        tick,
                        before
                    );
                }
                Some(_) => {}
                None => {
                    prop_assert_eq!(
                        fast_memory.map(f32::to_bits),
                        before.map(f32::to_bits),
                        "it kept something"
                    )
                }
            }
        }
        Ok(served)
    }

    proptest! {
        #[test]
        fn the_fast_path_has_the_general_functions_bits(
            arguments in proptest::collection::vec(
                (
                    prop_oneof![12 => -50.0_f32..50.0, 1 => Just(f32::NAN), 1 => Just(3e38_f32), 1 => Just(-3e38_f32)],
                    proptest::bool::weighted(0.7),
                    proptest::bool::weighted(0.03),
                ),
                1..400,
            ),
            launch in 0..300_usize,
            suspected in 1..300_usize,
            seconds in prop_oneof![Just(0.005_f32), Just(0.05), Just(0.0), 0.001_f32..2.0],
        ) {
            let ticks: Vec<_> = (0..)
                .zip(&arguments)
                // A suspicion may be withdrawn: then it is captive flight again.
                .map(|(k, (argument, is_new, begins))| {
                    (*argument, *is_new, *begins, (launch..launch + suspected).contains(&k))
                })
                .collect();
            agree(&ticks, |m, (a, _, _, l)| integral(m, a, seconds, l), |m, (a, _, _, l)| words::integral(m, a, seconds, l))?;
            agree(
                &ticks,
                |m, (a, _, _, l)| double_integral(m, a, seconds, l),
                |m, (a, _, _, l)| words::double_integral(m, a, seconds, l),
            )?;
            agree(&ticks, |m, (a, n, ..)| rate(m, a, seconds, n), |m, (a, n, ..)| words::rate(m, a, seconds, n))?;
            agree(&ticks, |m, (a, ..)| low_pass(m, a, 0.7, seconds), |m, (a, ..)| words::low_pass(m, a, 0.7, seconds))?;
            agree(
                &ticks,
                |m, (a, n, b, l)| captive(m, a, || n, l, b),
                |m, (a, n, b, l)| words::captive(m, a, || n, l, b),
            )?;
            agree(&ticks, |m, (a, _, _, l)| at_launch(m, a, l), |m, (a, _, _, l)| words::at_launch(m, a, l))?;
            agree(&ticks, |m, (a, ..)| delay(m, a, 0.04, seconds), |m, (a, ..)| delay::delay(m, a, 0.04, seconds))?;
        }
    }

    #[test]
    fn the_fast_path_serves_most_ticks() {
        let ticks: Vec<_> =
            (0..400_u16).map(|k| (f32::from(k % 17), k % 5 == 0, k == 20, k >= 200)).collect();
        let served = [
            agree(
                &ticks,
                |m, (a, _, _, l)| integral(m, a, 0.01, l),
                |m, (a, _, _, l)| words::integral(m, a, 0.01, l),
            ),
            agree(&ticks, |m, (a, n, ..)| rate(m, a, 0.01, n), |m, (a, n, ..)| words::rate(m, a, 0.01, n)),
            agree(
                &ticks,
                |m, (a, ..)| low_pass(m, a, 0.7, 0.01),
                |m, (a, ..)| words::low_pass(m, a, 0.7, 0.01),
            ),
            agree(
                &ticks,
                |m, (a, n, b, l)| captive(m, a, || n, l, b),
                |m, (a, n, b, l)| words::captive(m, a, || n, l, b),
            ),
            agree(
                &ticks,
                |m, (a, ..)| delay(m, a, 0.0625, 0.01),
                |m, (a, ..)| delay::delay(m, a, 0.0625, 0.01),
            ),
        ]
        .map(Result::unwrap);
        // An integral is 0 before launch. A rate has no value before the second sample, and the general
        // function handles a new sample after ticks without one. A delay of a second takes a sample at every
        // sixth tick, and has a value after a second.
        for (served, least) in served.into_iter().zip([199, 316, 399, 398, 240]) {
            assert!(served >= least, "{served} of 400, {least} at least");
        }
    }
}
