//! Statistics of autocorrelated residuals, in f64 and in one pass over a flight.
//!
//! Residuals of altitude sensors are autocorrelated: a hundred readings of an error with a correlation time
//! of about a second are worth two or three. Every uncertainty computed here takes the residual's own
//! autocorrelation into account.

mod batch_means;
mod chi_squared;
mod correlator;
mod distributions;
mod draw_set;
mod first_passage;
mod healthy_launches;
mod moments;
mod monitor_rule;
mod random_effects;
mod residual_model;
mod robust;
mod standard_normal;
mod whiteness;

pub use batch_means::BatchMeans;
pub use chi_squared::{Consistency, NisSummary};
pub use correlator::{Autocovariance, Correlator, Lag};
pub use distributions::{normal_above, normal_quantile};
pub use healthy_launches::HealthyLaunches;
pub use moments::Moments;
pub use monitor_rule::{
    Delay, Fault, MonitorRule, RuleChoice, RuleQuality, RuleSearch, assess_rule, recommend_rule,
};
pub use random_effects::{Estimate, Outlier, Pooled, pooled};
pub use residual_model::{Component, ResidualModel};
pub use robust::RobustSpread;
pub use whiteness::{Whiteness, ljung_box};
