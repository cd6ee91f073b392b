//! Selects which random numbers are drawn.

/// A set of random numbers. A residual gives the same answer with the same set; with another set the answer
/// differs by the sampling error of the draws.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct DrawSet(pub(super) u16);

impl DrawSet {
    /// The set's own version of a seed below 2^48.
    pub(super) const fn seed(self, seed: u64) -> u64 {
        seed ^ ((self.0 as u64) << 48)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::first_passage::{Excursions, Resolution};
    use crate::monitor_rule::samples_of;
    use crate::{
        Component, Fault, HealthyLaunches, Moments, ResidualModel, RuleChoice, RuleSearch, assess_rule,
        recommend_rule,
    };

    const SETS: u16 = 32;
    /// Largest ratio of the sample deviation of this many values to the true one: four sigmas, for normal
    /// values.
    fn most_of_a_deviation() -> f64 {
        1.0 + 4.0 / f64::sqrt(2.0 * f64::from(SETS - 1))
    }

    /// Residuals of barometers in logs of `shared/flights/real`, from `pylon compare --json`, and made-up
    /// ones.
    fn residuals() -> Vec<(&'static str, ResidualModel)> {
        let model =
            |sample_interval_s, white_variance_m2, parts: &[(f64, f64)], longest_lag_s| ResidualModel {
                sample_interval_s,
                white_variance_m2,
                components: parts
                    .iter()
                    .map(|&(time_s, variance_m2)| Component { time_s, variance_m2 })
                    .collect(),
                longest_lag_s,
            };
        vec![
            ("frrs_ekf_failure.ulg", model(0.207, 0.0, &[(0.446, 0.485), (0.961, 5.02)], 7.46)),
            ("frrs_motor_failure.ulg", model(0.411, 0.0, &[(0.411, 0.607), (8.86, 0.0377)], 7.40)),
            ("dronekit_flight_replay.tlog", model(0.365, 0.0, &[(1.70, 0.468), (3.65, 0.120)], 7.30)),
            ("made, white and of 1 s", model(0.02, 4.0, &[(1.0, 1.0)], 20.0)),
            ("made, white", model(0.02, 4.0, &[], 20.0)),
        ]
    }

    /// Medians and ninetieth percentiles of the delay of a step and of a ramp, and the time until a healthy
    /// sensor is doubtful, seconds; the threshold that healthy launches require, metres.
    const FIGURES: [&str; 6] = ["step", "90 %", "ramp", "90 %", "doubt", "launch"];

    /// The rule recommended with a set of draws, for `compare`'s own requirements.
    fn recommended(model: &ResidualModel, draws: DrawSet) -> (RuleChoice, [Option<f64>; FIGURES.len()]) {
        let sigma_m = model.variance().sqrt();
        let step = Fault::Step { size_m: 5.0 * sigma_m };
        let ramp = Fault::Ramp { rate_mps: 0.1 * sigma_m };
        let search = RuleSearch { false_alarms_per_hour: 0.1, fault: step, windows_s: (0.1, 60.0) };
        let launches = HealthyLaunches::draw_set(model, &search.lengths_s(model), draws);
        let choice = recommend_rule(&launches, &search).unwrap();
        let quality = assess_rule(&launches, choice.rule, &[step, ramp]).unwrap();
        let delays = quality.delays.iter().flat_map(|delay| [delay.median_s, delay.ninety_percent_s]);
        let mut figures =
            delays.chain([quality.healthy_first_doubt_s, Some(choice.first_window_threshold_m)]);
        (choice, std::array::from_fn(|_| figures.next().unwrap()))
    }

    /// The last digit of a variance, or a component that explains nothing, does not change any other part's
    /// random numbers.
    #[test]
    fn what_is_no_change_of_a_residual_changes_no_recommendation() {
        for (name, model) in residuals() {
            let (choice, figures) = recommended(&model, DrawSet::default());
            let mut others = Vec::new();
            for nudge in 1..4 {
                let mut other = model.clone();
                let nudged = 1.0 + f64::from(nudge) * f64::EPSILON;
                other.white_variance_m2 *= nudged;
                other.components.iter_mut().for_each(|part| part.variance_m2 *= nudged);
                others.push(other);
            }
            let mut other = model.clone();
            other
                .components
                .insert(0, Component { time_s: 100.0 * model.sample_interval_s, variance_m2: 0.0 });
            others.push(other);
            for other in others {
                let (other_choice, other_figures) = recommended(&other, DrawSet::default());
                // Other draws differ by per cents, roundings by some 1e-15.
                let is_same = |one: f64, other: f64| (other / one - 1.0).abs() < 1e-9;
                let (rule, other_rule) = (choice.rule, other_choice.rule);
                assert!(is_same(rule.window_s, other_rule.window_s), "{name}: {rule:?} {other_rule:?}");
                assert!(is_same(rule.threshold_m, other_rule.threshold_m), "{name}: {rule:?} {other_rule:?}");
                for ((figure, other), what) in figures.iter().zip(other_figures).zip(FIGURES) {
                    let is_same =
                        figure.zip(other).map_or(figure.is_none() && other.is_none(), |(a, b)| is_same(a, b));
                    assert!(is_same, "{name}, {what}: {figure:?} {other:?}");
                }
            }
        }
    }

    fn percent(values: impl Iterator<Item = f64>) -> Option<f64> {
        let mut moments = Moments::default();
        values.for_each(|value| moments.push(value));
        Some(100.0 * moments.standard_deviation()? / moments.mean()?)
    }

    /// How much the recommendation depends on the draws; reported in `docs/monitor-rules.md`.
    #[test]
    #[expect(
        clippy::disallowed_macros,
        reason = "a test has a terminal, and its figures are in the documents"
    )]
    fn the_draws_error_of_recommended_rules() {
        println!(
            "Standard deviations over {SETS} sets of draws, in per cent of the mean. Alarms: an hour, of one and the same rule."
        );
        println!("Bound: where the window is that of the first set. The others: whatever the window.");
        print!("{:<28}{:>8}{:>8}", "residual", "alarms", "bound");
        FIGURES.iter().for_each(|figure| print!("{figure:>8}"));
        println!("  windows, s");
        for (name, model) in residuals() {
            let sets: Vec<_> = (0..SETS).map(|set| recommended(&model, DrawSet(set))).collect();
            let rule = sets[0].0.rule;
            let window = samples_of(&model, rule.window_s);
            let rate_per_s = |set| {
                Excursions::draw(&model, window, Resolution::FINE, DrawSet(set))
                    .unwrap()
                    .rate_per_s(rule.threshold_m)
            };
            let alarms = percent((0..SETS).map(rate_per_s)).unwrap();
            let same = sets.iter().filter(|(choice, _)| choice.rule.window_s == rule.window_s);
            let bound = percent(same.map(|(choice, _)| choice.rule.threshold_m)).unwrap();
            print!("{name:<28}{alarms:>8.1}{bound:>8.2}");
            for index in 0..FIGURES.len() {
                let spread = percent(sets.iter().filter_map(|(_, figures)| figures[index]));
                print!("{:>8}", spread.map_or_else(|| "-".to_owned(), |spread| format!("{spread:.1}")));
            }
            let mut windows_s: Vec<f64> = sets.iter().map(|(choice, _)| choice.rule.window_s).collect();
            windows_s.sort_by(f64::total_cmp);
            windows_s.dedup();
            println!("  {windows_s:.2?}");
            // As stated at `Resolution::FINE`. A rate goes with exp(-z^2 / 2), so the threshold's error is
            // the rate's over z^2.
            assert!(alarms < 5.0 * most_of_a_deviation(), "{name}: {alarms}");
            let sigmas = rule.threshold_m / model.variance_of_mean(window).sqrt();
            assert!(bound < 5.0 * most_of_a_deviation() / (sigmas * sigmas), "{name}: {bound}");
        }
    }
}
