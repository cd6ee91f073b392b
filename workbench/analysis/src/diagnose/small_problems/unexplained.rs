//! Signals that a remainder follows which no effect explains.

use super::*;
use crate::diagnose::search::Search;
use crate::diagnose::unknown::{Doubts, Unexplained, unexplained};

const BLOCKS: usize = 300;
const TOGETHER: Doubts = Doubts { is_alone: false, has_climb_rate: true };
const ALONE: Doubts = Doubts { is_alone: true, has_climb_rate: true };

/// Tests the remainder of a flight with a roll angle and a throttle, given the chosen columns.
fn rest(small: &Small, chosen: &[usize], own: &[usize], explained: f64, doubts: Doubts) -> Unexplained {
    let roll = |block: usize| 0.4 * sine(0, block);
    let throttle = |block: usize| 0.5 + 0.3 * sine(1, block);
    let epochs = [small.epochs(&[("roll_rad", &roll), ("throttle", &throttle)])];
    let flights = [small.series.clone()];
    let (problem, suspects) = (problem(&flights), small.suspects());
    let fit = Search::new(&problem, &suspects).fit(chosen, &problem.prior.means());
    unexplained(&problem, &epochs, &fit, chosen, own, explained, BARO, doubts)
}

#[test]
fn noise_follows_nothing() {
    for seed in 0..3 {
        let found = rest(&Small::new(BLOCKS, seed), &[], &[], 0.0, TOGETHER);
        assert_eq!(found, Unexplained::default(), "{seed}");
    }
}

#[test]
fn a_rest_that_follows_a_signal_says_which_and_how_large_it_is() {
    let small = Small::new(BLOCKS, 10).error(|block| 2.0 * 0.4 * sine(0, block));
    let found = rest(&small, &[], &[], 0.0, TOGETHER);
    let first = &found.follows[0];
    assert_eq!((first.signal.as_str(), first.lag_s), ("roll_rad", 0.0));
    // The rms of a sine of 0.8 m; the noise moves it by the coefficient's sigma, some 0.3 / sqrt(300 / 2) m.
    assert!((first.size_m - 0.8 / 2.0_f64.sqrt()).abs() < 0.1, "{first:?}");
    assert!(!found.is_better, "nothing was chosen that it could be better than");
}

/// The same shape is in the catalogue: it belongs to a candidate, and the candidate was not strong enough to
/// be chosen.
#[test]
fn what_a_candidate_explains_is_no_unknown_effect() {
    let small = Small::new(BLOCKS, 11)
        .candidate(EffectId::BaroSideslip, |block| 0.4 * sine(0, block))
        .error(|block| 2.0 * 0.4 * sine(0, block));
    // After a low pass the signal has another shape, which no candidate has.
    let at_once = |own: &[usize]| {
        let found = rest(&small, &[], own, 0.0, TOGETHER);
        found.follows.iter().any(|follows| follows.signal == "roll_rad" && follows.lag_s == 0.0)
    };
    assert!(at_once(&[]) && !at_once(&[0]));
}

/// Formulas are right to some per cent: the small remainder of a large effect is not an effect of its own.
#[test]
fn a_rest_that_is_small_beside_what_was_explained_is_forgiven() {
    let small = Small::new(BLOCKS, 12).error(|block| 0.8 * sine(0, block));
    let evidence = rest(&small, &[], &[], 0.0, TOGETHER).follows[0].evidence;
    assert_eq!(rest(&small, &[], &[], 21.0 * evidence, TOGETHER).follows, []);
    assert_ne!(rest(&small, &[], &[], 19.0 * evidence, TOGETHER).follows, []);
}

/// A signal that explains everything that the chosen effect does, and more.
#[test]
fn a_signal_can_be_better_than_what_was_chosen() {
    let small = Small::new(BLOCKS, 13)
        .candidate(EffectId::BaroLag, |block| sine(0, block) + sine(2, block))
        .error(|block| 3.0 * sine(0, block));
    assert!(rest(&small, &[0], &[0], 100.0, TOGETHER).is_better);
    let right = Small::new(BLOCKS, 13)
        .candidate(EffectId::BaroLag, |block| sine(0, block))
        .error(|block| 3.0 * sine(0, block));
    assert!(!rest(&right, &[0], &[0], 100.0, TOGETHER).is_better);
}

#[test]
fn a_jump_is_found_where_it_is_unless_it_may_be_the_receivers() {
    let small = Small::new(BLOCKS, 14).error(|block| if block >= 220 { 4.0 } else { 0.0 });
    let found = rest(&small, &[], &[], 0.0, TOGETHER);
    assert_eq!(found.follows[0].signal, "a lasting jump at 220 s");
    let alone = rest(&small, &[], &[], 0.0, ALONE);
    assert!(alone.follows.iter().all(|follows| !follows.signal.contains("jump")), "{alone:?}");
}
