//! False alarms and detection delays of a monitor's rule, for a residual's own autocorrelation.
//!
//! The rule of eqs 16 and 17: doubtful once `|error| > threshold`; untrustworthy once, after that,
//! `|moving average| > threshold`. An average lies between the smallest and the largest of its values, so the
//! second condition never holds before the first has. The time of `untrustworthy` is therefore the moving
//! average's first passage alone.

use super::distributions::{normal_above, normal_quantile};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::ResidualModel;
use super::draw_set::DrawSet;
use super::first_passage::{Excursions, Passages, Resolution};
use super::healthy_launches::HealthyLaunches;

/// Draws of a fault, and of the first doubt.
const DRAWS: usize = 256;
/// Share of healthy launches that a recommended rule may call untrustworthy in the first window.
const FIRST_WINDOW_ALARMS: f64 = 0.01;
/// Quantile of the delay by which a rule is chosen.
const CERTAINTY: f64 = 0.9;
/// Ratio of successive windows that are tried.
const WINDOW_RATIO: f64 = std::f64::consts::SQRT_2;
/// Longest window, as a share of the longest lag that the data cover.
const WINDOW_PER_LONGEST_LAG: f64 = 1.0;
/// Longest delay that is considered, seconds.
const HORIZON_S: f64 = 600.0;

/// A monitor's rule: `|moving average over window_s| > threshold_m`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct MonitorRule {
    /// Threshold, metres: the multiplier times sigma.
    pub threshold_m: f64,
    /// Length of the moving average, seconds.
    pub window_s: f64,
}

/// A fault of a sensor that was healthy before.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
#[serde(rename_all = "snake_case")]
pub enum Fault {
    /// An error that appears at once, metres.
    Step {
        /// Size, metres.
        size_m: f64,
    },
    /// An error that grows, metres a second.
    Ramp {
        /// Growth, metres a second.
        rate_mps: f64,
    },
}

impl Fault {
    /// Moving average of the fault alone, at a time after it began.
    #[must_use]
    pub fn moving_average_m(self, window_s: f64, after_s: f64) -> f64 {
        match self {
            Self::Step { size_m } => size_m * (after_s / window_s).min(1.0),
            Self::Ramp { rate_mps } if after_s < window_s => rate_mps * after_s * after_s / (2.0 * window_s),
            Self::Ramp { rate_mps } => rate_mps * (after_s - 0.5 * window_s),
        }
    }

    /// Time at which the fault's own moving average reaches `level_m`; `None` if it never does.
    fn reaches_s(self, window_s: f64, level_m: f64) -> Option<f64> {
        match self {
            Self::Step { size_m } => (size_m >= level_m).then(|| window_s * level_m / size_m),
            Self::Ramp { rate_mps } => {
                let within = (2.0 * window_s * level_m / rate_mps).sqrt();
                Some(if within < window_s { within } else { level_m / rate_mps + 0.5 * window_s })
            }
        }
    }
}

/// Delay from a fault until the sensor is called untrustworthy.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Delay {
    /// The fault.
    pub fault: Fault,
    /// Median delay, seconds; `None` when fewer than half of such faults are ever detected.
    pub median_s: Option<f64>,
    /// Delay of the slowest tenth, seconds; `None` when fewer than nine in ten are ever detected.
    pub ninety_percent_s: Option<f64>,
}

/// False alarms of a rule on a healthy sensor, and its delays of detection.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct RuleQuality {
    /// The rule.
    pub rule: MonitorRule,
    /// Share of a healthy sensor's readings beyond the threshold (eq. 17, left).
    pub healthy_share_beyond: f64,
    /// Median time until a healthy sensor's first reading beyond the threshold, seconds; `None` when
    /// longer than ten minutes.
    pub healthy_first_doubt_s: Option<f64>,
    /// Rate at which a healthy sensor would be called untrustworthy, per hour (eq. 17, right), once the
    /// window is full.
    pub false_alarms_per_hour: f64,
    /// Share of launches at which a healthy sensor would be called untrustworthy before the window is full:
    /// until then the part without readings counts as no error.
    pub healthy_alarm_in_first_window: f64,
    /// Delays for the given faults.
    pub delays: Vec<Delay>,
}

impl RuleQuality {
    /// The same if the error must also have been beyond the threshold for a given time, seconds
    /// (`[monitor] persistence_s`): no delay is shorter than that time plus the fault's own time to the
    /// threshold. False alarms are kept as upper limits.
    #[must_use]
    pub fn with_persistence(mut self, persistence_s: f64) -> Self {
        for delay in &mut self.delays {
            let beyond_s = match delay.fault {
                Fault::Step { .. } => 0.0,
                Fault::Ramp { rate_mps } => self.rule.threshold_m / rate_mps,
            };
            for quantile_s in [&mut delay.median_s, &mut delay.ninety_percent_s] {
                *quantile_s = quantile_s.map(|delay_s| delay_s.max(beyond_s + persistence_s));
            }
        }
        self
    }
}

pub(super) fn samples_of(model: &ResidualModel, window_s: f64) -> u64 {
    (window_s / model.sample_interval_s).round().max(1.0) as u64
}

/// Assesses a rule for a residual.
///
/// `None` for a residual without spread or a rule without a positive threshold and window.
#[must_use]
pub fn assess_rule(
    launches: &HealthyLaunches<'_>,
    rule: MonitorRule,
    faults: &[Fault],
) -> Option<RuleQuality> {
    let (model, draws) = (launches.model(), launches.draws());
    let positive = |value: f64| value.is_finite() && value > 0.0;
    if !positive(rule.threshold_m) || !positive(rule.window_s) || !positive(model.variance()) {
        return None;
    }
    let window = samples_of(model, rule.window_s);
    let healthy_share_beyond = 2.0 * normal_above(rule.threshold_m / model.variance().sqrt());
    let rate = Excursions::draw(model, window, Resolution::FINE, draws)?.rate_per_s(rule.threshold_m);
    Some(RuleQuality {
        rule,
        healthy_share_beyond,
        healthy_first_doubt_s: first_doubt_s(model, rule.threshold_m, healthy_share_beyond, draws),
        false_alarms_per_hour: rate * 3_600.0,
        healthy_alarm_in_first_window: launches.alarms(rule.threshold_m, window),
        delays: faults.iter().map(|&fault| delay(model, rule, fault, draws)).collect(),
    })
}

/// Median time to the first reading beyond the threshold.
fn first_doubt_s(model: &ResidualModel, threshold_m: f64, share_beyond: f64, draws: DrawSet) -> Option<f64> {
    // Drawn sample by sample while that is cheap; otherwise from the rate of excursions of single readings.
    const DRAWN_SAMPLES: f64 = 2_000.0;
    let interval = model.sample_interval_s;
    if share_beyond > 20.0 / DRAWN_SAMPLES {
        let mut first: Vec<u64> = (0..DRAWS as u64)
            .map(|index| {
                let draw = model.simulate(1, draws.seed(index)).take(DRAWN_SAMPLES as usize);
                draw.take_while(|error| error.abs() <= threshold_m).count() as u64
            })
            .collect();
        first.sort_unstable();
        let median = first[first.len() / 2];
        if (median as f64) < DRAWN_SAMPLES {
            return Some((median + 1) as f64 * interval);
        }
    }
    let rate = Excursions::draw(model, 1, Resolution::FINE, draws)?.rate_per_s(threshold_m);
    let median = std::f64::consts::LN_2 / rate;
    (median < HORIZON_S).then_some(median)
}

fn delay(model: &ResidualModel, rule: MonitorRule, fault: Fault, draws: DrawSet) -> Delay {
    let window = samples_of(model, rule.window_s);
    let margin = 3.0 * model.variance_of_mean(window).sqrt();
    let certain_s = fault.reaches_s(rule.window_s, rule.threshold_m + margin);
    let horizon_s = certain_s.unwrap_or(HORIZON_S).min(HORIZON_S) + 4.0 * rule.window_s;
    let signal = |after_s| fault.moving_average_m(rule.window_s, after_s);
    let passages = Passages::draw(model, window, rule.threshold_m, horizon_s, DRAWS, draws, signal);
    Delay { fault, median_s: passages.quantile_s(0.5), ninety_percent_s: passages.quantile_s(CERTAINTY) }
}

/// Requirements for a rule.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RuleSearch {
    /// Largest rate of false alarms, per hour.
    pub false_alarms_per_hour: f64,
    /// The fault whose detection delay is to be shortest.
    pub fault: Fault,
    /// Shortest and longest window to consider, seconds.
    pub windows_s: (f64, f64),
}

impl RuleSearch {
    /// The windows that are tried, seconds: none longer than the residual's record covers.
    #[must_use]
    pub fn lengths_s(&self, model: &ResidualModel) -> Vec<f64> {
        let longest_s = self.windows_s.1.min(WINDOW_PER_LONGEST_LAG * model.longest_lag_s);
        let shortest_s = self.windows_s.0.max(model.sample_interval_s);
        std::iter::successors(Some(shortest_s), |window_s| Some(window_s * WINDOW_RATIO))
            .take_while(|window_s| *window_s <= longest_s)
            .collect()
    }
}

/// A recommended rule.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RuleChoice {
    /// The rule.
    pub rule: MonitorRule,
    /// The smallest step that it detects nine times in ten, metres.
    pub smallest_step_m: f64,
    /// Whether it detects the given fault nine times in ten.
    pub detects_fault: bool,
    /// The threshold that healthy launches require in the first window, metres.
    pub first_window_threshold_m: f64,
}

/// Finds the rule that detects the fault soonest (nine times in ten) at the given false-alarm rate; if none
/// detects it, the rule that detects the smallest step.
///
/// For each window the threshold follows from that rate, and from the condition that at most one in a hundred
/// healthy launches is called untrustworthy before the window is full. Windows longer than the longest lag
/// that the residual's record covers are not considered, because the autocorrelation there is unknown. `None`
/// if the residual has no spread, or its record is too short for any window.
#[must_use]
pub fn recommend_rule(launches: &HealthyLaunches<'_>, search: &RuleSearch) -> Option<RuleChoice> {
    let (model, draws) = (launches.model(), launches.draws());
    let target_per_s = search.false_alarms_per_hour / 3_600.0;
    let windows_s = search.lengths_s(model);
    let mut soonest: Option<(f64, RuleChoice)> = None;
    let mut finest: Option<RuleChoice> = None;
    for window_s in windows_s {
        let window = samples_of(model, window_s);
        let mut first = launches.barriers(window);
        first.sort_by(f64::total_cmp);
        let launch_m =
            first.get(((1.0 - FIRST_WINDOW_ALARMS) * first.len() as f64) as usize).copied().unwrap_or(0.0);
        let excursions = Excursions::draw(model, window, Resolution::COARSE, draws)?;
        let sigma_m = model.variance_of_mean(window).sqrt();
        let steady_m = threshold_of_rate(&excursions, sigma_m, target_per_s);
        let threshold_m = steady_m.max(launch_m);
        let certain_m = threshold_m + normal_quantile(CERTAINTY) * sigma_m;
        let delay_s = search.fault.reaches_s(window_s, certain_m);
        let choice = RuleChoice {
            rule: MonitorRule { threshold_m, window_s },
            smallest_step_m: certain_m,
            detects_fault: delay_s.is_some(),
            first_window_threshold_m: launch_m,
        };
        if let Some(delay_s) = delay_s
            && soonest.is_none_or(|(best_s, _)| delay_s < best_s)
        {
            soonest = Some((delay_s, choice));
        }
        if finest.is_none_or(|best| certain_m < best.smallest_step_m) {
            finest = Some(choice);
        }
    }
    let choice = soonest.map(|(_, choice)| choice).or(finest)?;
    refined(launches, target_per_s, choice)
}

/// The choice with its threshold computed again at fine resolution.
fn refined(launches: &HealthyLaunches<'_>, target_per_s: f64, choice: RuleChoice) -> Option<RuleChoice> {
    let (model, draws) = (launches.model(), launches.draws());
    let window = samples_of(model, choice.rule.window_s);
    let sigma_m = model.variance_of_mean(window).sqrt();
    let excursions = Excursions::draw(model, window, Resolution::FINE, draws)?;
    let fine_m = threshold_of_rate(&excursions, sigma_m, target_per_s);
    let threshold_m = fine_m.max(choice.first_window_threshold_m);
    let grown_m = threshold_m - choice.rule.threshold_m;
    Some(RuleChoice {
        rule: MonitorRule { threshold_m, ..choice.rule },
        smallest_step_m: choice.smallest_step_m + grown_m,
        ..choice
    })
}

/// The threshold at which excursions have that rate, by bisection between 0 and 12 sigmas.
fn threshold_of_rate(excursions: &Excursions, sigma_m: f64, rate_per_s: f64) -> f64 {
    let (mut low, mut high) = (0.0, 12.0 * sigma_m);
    for _ in 0..18 {
        let middle = 0.5 * (low + high);
        if excursions.rate_per_s(middle) > rate_per_s {
            low = middle;
        } else {
            high = middle;
        }
    }
    high
}

#[cfg(test)]
mod tests {
    use super::*;

    /// With launches drawn for this rule alone.
    fn assess_rule(model: &ResidualModel, rule: MonitorRule, faults: &[Fault]) -> Option<RuleQuality> {
        super::assess_rule(&HealthyLaunches::draw(model, &[]), rule, faults)
    }

    fn recommend_rule(model: &ResidualModel, search: &RuleSearch) -> Option<RuleChoice> {
        super::recommend_rule(&HealthyLaunches::draw(model, &search.lengths_s(model)), search)
    }
    use crate::healthy_launches::FIRST_DRAWS;
    use crate::{Component, Moments};

    fn residual() -> ResidualModel {
        ResidualModel {
            sample_interval_s: 0.02,
            white_variance_m2: 4.0,
            components: vec![Component { time_s: 1.0, variance_m2: 1.0 }],
            longest_lag_s: 20.0,
        }
    }

    const STEP: Fault = Fault::Step { size_m: 6.0 };

    #[test]
    fn paper_rule_doubts_a_healthy_sensor_at_once() {
        let model = residual();
        let rule = MonitorRule { threshold_m: model.variance().sqrt(), window_s: 2.0 };
        let quality = assess_rule(&model, rule, &[STEP]).unwrap();
        assert!((quality.healthy_share_beyond - 0.317_3).abs() < 1e-3);
        // Nearly independent readings at 31.7 %: the second or third is beyond the threshold.
        assert!(quality.healthy_first_doubt_s.unwrap() <= 0.06);
        assert!(quality.delays[0].median_s.unwrap() < 2.0);
    }

    #[test]
    fn recommended_rule_keeps_its_false_alarm_rate() {
        let model = residual();
        let search = RuleSearch { false_alarms_per_hour: 0.1, fault: STEP, windows_s: (0.1, 60.0) };
        let rule = recommend_rule(&model, &search).unwrap().rule;
        assert!(rule.window_s <= model.longest_lag_s);
        let quality = assess_rule(&model, rule, &[STEP]).unwrap();
        // Found with 64 draws, assessed with 256; the launch may require more.
        assert!(quality.false_alarms_per_hour < 0.1 * 0.3_f64.exp(), "{quality:?}");
        assert!(quality.healthy_alarm_in_first_window <= 0.01, "{quality:?}");
        // No neighbouring window detects the step sooner by more than the sampling error, over 32 sets of
        // draws.
        let delays_s = |window_s: f64| {
            let (window, mut delays_s) = (samples_of(&model, window_s), Moments::default());
            for set in (0..32).map(DrawSet) {
                let excursions = Excursions::draw(&model, window, Resolution::FINE, set).unwrap();
                let sigma_m = model.variance_of_mean(window).sqrt();
                let threshold_m = threshold_of_rate(&excursions, sigma_m, 0.1 / 3_600.0);
                let found = delay(&model, MonitorRule { threshold_m, window_s }, STEP, set);
                delays_s.push(found.ninety_percent_s.unwrap());
            }
            delays_s
        };
        let own_s = delays_s(rule.window_s);
        for factor in [0.5, 2.0] {
            let other_s = delays_s(rule.window_s * factor);
            let error_s = ((own_s.variance().unwrap() + other_s.variance().unwrap()) / 32.0).sqrt();
            let sooner_s = own_s.mean().unwrap() - other_s.mean().unwrap();
            assert!(sooner_s < 4.0 * error_s, "{factor}: {sooner_s} +- {error_s}");
        }
    }

    #[test]
    fn first_window_of_independent_readings_follows_the_normal_distribution() {
        let model = ResidualModel { components: vec![], ..residual() };
        // Two readings only: the first beyond 1 sigma and so is the mean of both. For thresholds a on
        // both, P = P(|x| > a, |x + y| > 2 a) = 2 integral over x > a of phi(x) [Q(2a - x) + Q(2a + x)].
        let sigma = model.variance().sqrt();
        let steps = 20_000;
        let expected: f64 = (0..steps)
            .map(|k| 1.0 + (f64::from(k) + 0.5) * 9.0 / f64::from(steps))
            .map(|x| {
                let density = (-0.5 * x * x).exp() / (2.0 * std::f64::consts::PI).sqrt();
                2.0 * density * (normal_above(2.0 - x) + normal_above(2.0 + x)) * 9.0 / f64::from(steps)
            })
            .sum();
        let got = HealthyLaunches::draw(&model, &[2.0 * model.sample_interval_s]).alarms(sigma, 2);
        let error = (expected * (1.0 - expected) / FIRST_DRAWS as f64).sqrt();
        assert!((got - expected).abs() < 4.0 * error, "{got} {expected}");
    }

    #[test]
    fn a_lower_rate_costs_a_longer_delay() {
        let model = residual();
        let delay_at = |false_alarms_per_hour| {
            let search = RuleSearch { false_alarms_per_hour, fault: STEP, windows_s: (0.1, 60.0) };
            let rule = recommend_rule(&model, &search).unwrap().rule;
            assess_rule(&model, rule, &[STEP]).unwrap().delays[0].ninety_percent_s.unwrap()
        };
        assert!(delay_at(10.0) < delay_at(0.1));
        assert!(delay_at(0.1) < delay_at(0.001));
    }

    #[test]
    fn without_a_rule_for_the_fault_the_finest_one_is_recommended() {
        let model = residual();
        let search = |size_m| RuleSearch {
            false_alarms_per_hour: 0.1,
            fault: Fault::Step { size_m },
            windows_s: (0.1, 60.0),
        };
        let choice = recommend_rule(&model, &search(0.01)).unwrap();
        assert!(!choice.detects_fault);
        // A step just above the claimed smallest one is detected in time by this or another rule, one below
        // by none.
        assert!(recommend_rule(&model, &search(1.01 * choice.smallest_step_m)).unwrap().detects_fault);
        assert!(!recommend_rule(&model, &search(0.99 * choice.smallest_step_m)).unwrap().detects_fault);
        let fault = Fault::Step { size_m: choice.smallest_step_m };
        let delay = assess_rule(&model, choice.rule, &[fault]).unwrap().delays[0];
        assert!(delay.ninety_percent_s.is_some(), "{delay:?}");
    }

    #[test]
    fn a_step_below_the_threshold_is_not_detected() {
        let model = residual();
        let rule = MonitorRule { threshold_m: 20.0, window_s: 2.0 };
        let delays = assess_rule(&model, rule, &[STEP]).unwrap().delays;
        assert_eq!((delays[0].median_s, delays[0].ninety_percent_s), (None, None));
    }

    #[test]
    fn persistence_bounds_every_delay_from_below() {
        let rule = MonitorRule { threshold_m: 6.0, window_s: 2.0 };
        let faults = [Fault::Step { size_m: 60.0 }, Fault::Ramp { rate_mps: 60.0 }, STEP];
        let quality = assess_rule(&residual(), rule, &faults).unwrap();
        let lasting = quality.clone().with_persistence(1.25);
        assert!(quality.delays[0].median_s.unwrap() < 0.5);
        assert_eq!(lasting.delays[0].median_s, Some(1.25));
        assert_eq!(lasting.delays[1].ninety_percent_s, Some(1.35));
        assert_eq!(quality.clone().with_persistence(0.0).delays[0], quality.delays[0]);
    }

    #[test]
    fn fault_averages_are_the_integrals() {
        for fault in [STEP, Fault::Ramp { rate_mps: 1.5 }] {
            let error = |t: f64| match fault {
                Fault::Step { size_m } => {
                    if t > 0.0 {
                        size_m
                    } else {
                        0.0
                    }
                }
                Fault::Ramp { rate_mps } => rate_mps * t.max(0.0),
            };
            for after_s in [0.3, 1.9, 2.1, 7.0] {
                let n = 20_000;
                let integral: f64 =
                    (0..n).map(|i| error(after_s - 2.0 * (f64::from(i) + 0.5) / f64::from(n))).sum::<f64>()
                        / f64::from(n);
                assert!((fault.moving_average_m(2.0, after_s) - integral).abs() < 1e-3);
                let level = fault.moving_average_m(2.0, after_s);
                if level < 6.0 {
                    assert!((fault.reaches_s(2.0, level).unwrap() - after_s).abs() < 1e-9);
                }
            }
        }
    }

    #[test]
    fn refuses_rules_that_are_none() {
        for (threshold_m, window_s) in [(0.0, 1.0), (1.0, 0.0), (f64::NAN, 1.0), (1.0, f64::INFINITY)] {
            assert_eq!(assess_rule(&residual(), MonitorRule { threshold_m, window_s }, &[]), None);
        }
    }
}
