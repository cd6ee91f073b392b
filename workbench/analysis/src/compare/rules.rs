//! Judges the monitor's rule by each sensor's own residual, and recommends a better one.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use statistics::{
    Fault, HealthyLaunches, MonitorRule, ResidualModel, RuleQuality, RuleSearch, assess_rule, recommend_rule,
};

/// Shortest and longest moving average that may be recommended, seconds.
const WINDOWS_S: (f64, f64) = (0.1, 60.0);
/// Default step to detect, in sigmas of the captive residual.
const STEP_SIGMAS: f64 = 5.0;
/// Default ramp: one sigma in this many seconds.
const RAMP_SECONDS_PER_SIGMA: f64 = 10.0;

/// Criteria for the rules.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RuleRequirements {
    /// Largest false-alarm rate of a recommended rule, per hour.
    pub false_alarms_per_hour: f64,
    /// The step to detect, metres; `None`: five sigmas of the captive residual.
    pub step_m: Option<f64>,
    /// The ramp, m/s; `None`: one sigma of the captive residual in ten seconds.
    pub ramp_mps: Option<f64>,
}

impl Default for RuleRequirements {
    fn default() -> Self {
        Self { false_alarms_per_hour: 0.1, step_m: None, ramp_mps: None }
    }
}

/// The configured rule and the recommended one, for one sensor.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct SensorRules {
    /// The residual's stochastic model, fitted to its autocovariance in captive flight.
    pub residual: ResidualModel,
    /// The rule that was flown.
    pub set: Option<RuleQuality>,
    /// The rule that detects the step soonest at the wanted false-alarm rate.
    pub recommended: Option<Recommendation>,
    /// The wanted false-alarm rate, per hour.
    pub wanted_false_alarms_per_hour: f64,
}

impl SensorRules {
    /// The step by which the rules were judged.
    #[must_use]
    pub fn step(&self) -> Option<Fault> {
        Some(self.quality()?.delays.first()?.fault)
    }

    /// The ramp by which the rules were judged.
    #[must_use]
    pub fn ramp(&self) -> Option<Fault> {
        Some(self.quality()?.delays.get(1)?.fault)
    }

    fn quality(&self) -> Option<&RuleQuality> {
        self.set.as_ref().or(self.recommended.as_ref().map(|advice| &advice.quality))
    }
}

/// A recommended rule.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Recommendation {
    /// Value for `[monitor] multiplier`.
    pub multiplier: f64,
    /// Value for `[monitor] window_s`.
    pub window_s: f64,
    /// Whether it detects the step nine times in ten. If not, no rule does at that false-alarm rate, and this
    /// one detects the smallest step.
    pub detects_step: bool,
    /// The smallest step that it detects nine times in ten, metres.
    pub smallest_step_m: f64,
    /// Its false alarms and its detection.
    pub quality: RuleQuality,
}

/// Judges the rule of one sensor. `bound_m` is the flown alarm limit, `multiplier` sigmas; `persistence_s` is
/// the model's.
pub(super) fn judge(
    residual: ResidualModel,
    bound_m: Option<f64>,
    multiplier: f64,
    window_s: f64,
    persistence_s: f64,
    requirements: &RuleRequirements,
) -> SensorRules {
    let sigma_m = residual.variance().sqrt();
    let step = Fault::Step { size_m: requirements.step_m.unwrap_or(STEP_SIGMAS * sigma_m) };
    let ramp = Fault::Ramp { rate_mps: requirements.ramp_mps.unwrap_or(sigma_m / RAMP_SECONDS_PER_SIGMA) };
    let search = RuleSearch {
        false_alarms_per_hour: requirements.false_alarms_per_hour,
        fault: step,
        windows_s: WINDOWS_S,
    };
    let mut windows_s = search.lengths_s(&residual);
    if bound_m.is_some() {
        windows_s.push(window_s);
    }
    let launches = HealthyLaunches::draw(&residual, &windows_s);
    let set = bound_m
        .and_then(|threshold_m| assess_rule(&launches, MonitorRule { threshold_m, window_s }, &[step, ramp]))
        .map(|quality| quality.with_persistence(persistence_s));
    let recommended = recommend_rule(&launches, &search).and_then(|choice| {
        let monitor_sigma_m = bound_m.map_or(sigma_m, |bound| bound / multiplier);
        Some(Recommendation {
            multiplier: choice.rule.threshold_m / monitor_sigma_m,
            window_s: choice.rule.window_s,
            detects_step: choice.detects_fault,
            smallest_step_m: choice.smallest_step_m,
            quality: assess_rule(&launches, choice.rule, &[step, ramp])?.with_persistence(persistence_s),
        })
    });
    SensorRules {
        residual,
        set,
        recommended,
        wanted_false_alarms_per_hour: requirements.false_alarms_per_hour,
    }
}
