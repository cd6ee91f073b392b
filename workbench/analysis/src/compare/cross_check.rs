//! Cross-check of the sensors with each other without a reference.

use kf_core::output::{Agreement, CrossCheckOutput};

use super::comparison::CrossCheckFacts;

/// Gathers the cross-checks of one flight.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct CrossChecks {
    pairs: u64,
    largest_m: f32,
    doubtful_us: Option<u64>,
    disagree_us: Option<u64>,
    last: Option<Agreement>,
}

impl CrossChecks {
    pub(super) fn take(&mut self, time_us: u64, check: &CrossCheckOutput) {
        self.pairs += 1;
        if check.difference_m.abs() > self.largest_m.abs() {
            self.largest_m = check.difference_m;
        }
        if check.agreement != Agreement::Agree {
            self.doubtful_us.get_or_insert(time_us);
        }
        if check.agreement == Agreement::Disagree {
            self.disagree_us.get_or_insert(time_us);
        }
        self.last = Some(check.agreement);
    }

    /// `after_s` converts a time to seconds after launch.
    pub(super) fn facts(&self, after_s: impl Fn(Option<u64>) -> Option<f64>) -> Option<CrossCheckFacts> {
        self.last.map(|last| CrossCheckFacts {
            pairs: self.pairs,
            largest_difference_m: self.largest_m.into(),
            agreement: last.name().into(),
            doubtful_after_s: after_s(self.doubtful_us),
            disagree_after_s: after_s(self.disagree_us),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keeps_the_first_times_and_the_farthest_difference_with_its_sign() {
        let mut checks = CrossChecks::default();
        assert_eq!(checks.facts(|_| None), None);
        for (time_us, difference_m, agreement) in [
            (10, 1.0, Agreement::Agree),
            (20, -9.0, Agreement::Doubtful),
            (30, 8.0, Agreement::Disagree),
            (40, 7.0, Agreement::Disagree),
        ] {
            checks.take(time_us, &CrossCheckOutput { difference_m, moving_average_m: 0.0, agreement });
        }
        let facts = checks.facts(|time_us| time_us.map(|time_us| time_us as f64)).unwrap();
        let expected = CrossCheckFacts {
            pairs: 4,
            largest_difference_m: -9.0,
            agreement: "disagree".into(),
            doubtful_after_s: Some(20.0),
            disagree_after_s: Some(30.0),
        };
        assert_eq!(facts, expected);
    }
}
