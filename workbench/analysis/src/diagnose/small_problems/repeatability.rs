//! Whether coefficients repeat from part to part.

use super::*;
use crate::diagnose::repeatability::{Repeatability, repeatability};

const BLOCKS: usize = 400;

fn of(small: &Small) -> Repeatability {
    let flights = [small.series.clone()];
    repeatability(&problem(&flights), &NOISE, &[0])[0]
}

fn lag(small: Small) -> Small {
    small.candidate(EffectId::BaroLag, |block| sine(0, block))
}

#[test]
fn a_coefficient_that_is_the_same_everywhere_repeats_exactly() {
    let found = of(&lag(Small::new(BLOCKS, 0).noiseless()).error(|block| 2.0 * sine(0, block)));
    assert_eq!(found.inflation, 1.0);
    assert!(found.unevenness < 1e-9, "{found:?}");
}

/// With noise as the likelihood assumes it, the deviations have the expected size. Their mean square over
/// nine degrees of freedom is below 3.1 in 999 of 1000 flights, and the mean over forty flights is within 4
/// sigmas, sqrt(2 / 9 / 40) each, of one.
#[test]
fn noise_alone_makes_deviations_of_the_size_that_they_should_have() {
    let count = 40.0;
    let mean = (100..140).map(|seed| of(&lag(Small::new(BLOCKS, seed))).unevenness).sum::<f64>() / count;
    assert!((mean - 1.0).abs() < 4.0 * (2.0 / 9.0 / count).sqrt(), "{mean}");
}

/// A wrong formula: right in one half, with the wrong sign in the other.
#[test]
fn a_coefficient_that_turns_over_is_uneven() {
    let sign = |block: usize| if block < BLOCKS / 2 { 2.0 } else { -1.0 };
    let found = of(&lag(Small::new(BLOCKS, 3)).error(|block| sign(block) * sine(0, block)));
    assert!(found.unevenness > 5.0 && found.inflation > 2.4, "{found:?}");
}

/// Ten per cent of a coefficient are tolerated, however small the noise; but its sigma has to allow for them.
#[test]
fn a_few_per_cent_from_part_to_part_are_forgiven() {
    let size = |block: usize| if block < BLOCKS / 2 { 41.0 } else { 39.0 };
    let found = of(&lag(Small::new(BLOCKS, 4).noiseless()).error(|block| size(block) * sine(0, block)));
    assert!(found.unevenness < 1.0 && found.inflation > 2.4, "{found:?}");
}

/// Without the one part that shows it a coefficient is unknown: that is no evidence about repeatability.
#[test]
fn one_part_alone_is_no_witness() {
    let only = |block: usize| if (40..80).contains(&block) { sine(0, block) } else { 0.0 };
    let small =
        Small::new(BLOCKS, 5).candidate(EffectId::BaroLag, only).error(move |block| 2.0 * only(block));
    let found = of(&small);
    assert_eq!(found.inflation, 1.0);
    assert!(found.unevenness < 5.0, "{found:?}");
}

#[test]
fn columns_that_can_not_be_told_apart_have_no_repeatability() {
    let small = lag(lag(Small::new(BLOCKS, 6)));
    let flights = [small.series];
    assert_eq!(repeatability(&problem(&flights), &NOISE, &[0, 1]), []);
}
