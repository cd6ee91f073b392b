//! How many parts a law may have: cross-validation that includes the choice of the law.
//!
//! A law that the grammar lacks leaves a shape that longer and longer products fit, and compared with a large
//! misfit the bits of a part are negligible. The value of a part shows on data that it was not chosen by.
//! Each of ten stretches of free flight is left out, the law is chosen and its coefficient fitted by the
//! rest, for every maximum number of parts, and the gain in twice the log likelihood is taken on the stretch
//! (Stone, "Cross-validatory choice and assessment of statistical predictions", Journal of the Royal
//! Statistical Society B 36, 1974). The number that gains most is taken, the smaller of equal ones. The rule
//! that prefers a simpler one within a standard error (Breiman and others, 1984) is not used: a law often
//! acts in a few stretches, whose gains differ by more than the margin of the right law.

use super::screen::{ByStretch, STRETCHES};

/// A law as used for choosing the length.
#[derive(Clone, Copy, Debug)]
pub struct Chosen<'a> {
    /// Number of factors and terms.
    pub parts: usize,
    /// The cost of its length in twice the log likelihood.
    pub price: f64,
    /// Its evidence by stretch.
    pub stretches: &'a ByStretch,
}

/// The largest number of parts that pays; at least one.
#[must_use]
pub fn parts_that_pay(laws: &[Chosen<'_>], most: usize) -> usize {
    let gains: Vec<[f64; STRETCHES]> = (1..=most).map(|parts| held_out(laws, parts)).collect();
    let sum = |gains: &[f64; STRETCHES]| gains.iter().sum::<f64>();
    let best = (0..most).reduce(|best, n| if sum(&gains[n]) > sum(&gains[best]) { n } else { best });
    1 + best.unwrap_or(0)
}

/// What each stretch gains by the law with at most this many parts that the others choose.
fn held_out(laws: &[Chosen<'_>], parts: usize) -> [f64; STRETCHES] {
    std::array::from_fn(|left_out| {
        let mut best = (0.0, 0.0);
        for law in laws.iter().filter(|law| law.parts <= parts) {
            let of = |k: usize| -> f64 { law.stretches.iter().map(|stretch| stretch[k]).sum() };
            let [own_score, own_information] = law.stretches[left_out];
            let (score, information) = (of(0) - own_score, of(1) - own_information);
            // A law that only the left-out stretch shows cannot be learned from the others.
            if information <= 1e-9 * of(1) {
                continue;
            }
            let merit = score * score / information - law.price;
            if merit > best.0 {
                let coefficient = score / information;
                best = (merit, coefficient * (2.0 * own_score - coefficient * own_information));
            }
        }
        best.1
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Stretches with this much information each, in which the coefficient is given by `truth`.
    fn stretches(information: f64, truth: [f64; STRETCHES]) -> ByStretch {
        let mut all = [[0.0; 2]; STRETCHES + 1];
        for (stretch, truth) in all.iter_mut().zip(truth) {
            *stretch = [information * truth, information];
        }
        all
    }

    /// Nine of ten stretches support each of ten long laws, each time a different nine: a choice by all ten
    /// overrates them.
    #[test]
    fn a_part_must_pay_where_it_was_not_chosen() {
        let simple = stretches(40.0, [1.0; STRETCHES]);
        // Twice the information of the same: each stretch gains.
        let right = stretches(80.0, [1.0; STRETCHES]);
        let lucky: Vec<ByStretch> = (0..STRETCHES)
            .map(|bad| stretches(40.0, std::array::from_fn(|k| if k == bad { -0.5 } else { 1.5 })))
            .collect();
        let law = |parts: usize, stretches| Chosen { parts, price: 10.0 * parts as f64, stretches };
        assert_eq!(parts_that_pay(&[law(1, &simple), law(2, &right)], 3), 2);
        let mut laws = vec![law(1, &simple)];
        laws.extend(lucky.iter().map(|stretches| law(3, stretches)));
        assert_eq!(parts_that_pay(&laws, 3), 1);
        // Of equal ones the shorter is chosen.
        assert_eq!(parts_that_pay(&[law(1, &simple), law(3, &simple)], 3), 1);
        assert_eq!(parts_that_pay(&[law(2, &right)], 3), 2);
        assert_eq!(parts_that_pay(&[], 3), 1);
    }

    /// A law that only the left-out stretch shows has no influence on its prediction: the stretch's own
    /// information is a million million times that of the others.
    #[test]
    fn what_one_stretch_alone_shows_predicts_nothing_in_it() {
        let mut alone = [[0.1, 1e-6]; STRETCHES + 1];
        alone[3] = [1e6, 1e6];
        let law = Chosen { parts: 1, price: 1.0, stretches: &alone };
        assert_eq!(held_out(&[law], 1)[3], 0.0);
        // A law that the others show alike predicts it: twice the score less the information, by a
        // coefficient of one.
        let alike = stretches(40.0, [1.0; STRETCHES]);
        let law = Chosen { parts: 1, price: 1.0, stretches: &alike };
        assert!(held_out(&[law], 1).iter().all(|gain| (gain - 40.0).abs() < 1e-9));
        // A price that nothing pays.
        assert_eq!(held_out(&[Chosen { price: 1e6, ..law }], 1), [0.0; STRETCHES]);
    }
}
