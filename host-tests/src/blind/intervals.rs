//! How far the identified effects' coefficients are from the truth, and how far they are reported to be.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use super::score::Share;
use super::trial::Trial;
use crate::median::median;

/// An identified effect's coefficient beside the true one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Deviation {
    /// Name of the effect.
    pub effect: &'static str,
    /// The true coefficient, in the effect's unit.
    pub truth: f64,
    /// Estimate less truth, in the effect's unit.
    pub error: f64,
    /// The reported standard deviation, in the effect's unit.
    pub sigma: f64,
}

impl Deviation {
    /// The error in sigmas.
    #[must_use]
    pub fn sigmas(&self) -> f64 {
        self.error / self.sigma
    }

    /// Whether the reported interval of 95 % contains the truth.
    #[must_use]
    pub fn is_covered(&self) -> bool {
        self.sigmas().abs() < 1.96
    }
}

/// For each effect, how many intervals contain the truth, and the (upper) medians of the relative errors and
/// of the reported relative sigmas.
#[must_use]
pub fn intervals(trials: &[Trial]) -> String {
    let mut effects: BTreeMap<&str, Vec<Deviation>> = BTreeMap::new();
    for deviation in trials.iter().flat_map(|trial| &trial.deviations) {
        effects.entry(deviation.effect).or_default().push(*deviation);
    }
    let mut text =
        format!("{:<24} {:>17} {:>16} {:>16}\n", "", "within 1.96 sigma", "error, median", "sigma, median");
    for (effect, deviations) in effects {
        let mut covered = Share::default();
        deviations.iter().for_each(|deviation| covered.count(deviation.is_covered()));
        let percent = |of: &dyn Fn(&Deviation) -> f64| {
            median(deviations.iter().map(|one| 100.0 * (of(one) / one.truth).abs()).collect())
        };
        let _ = writeln!(
            text,
            "{effect:<24} {:>10} of {:>3} {:>14.1} % {:>14.1} %",
            covered.hits,
            covered.of,
            percent(&|deviation| deviation.error),
            percent(&|deviation| deviation.sigma)
        );
    }
    text
}
