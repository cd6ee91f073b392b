//! One sensor's errors and innovations in one phase of the flight.

use kf_core::output::SensorOutput;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use statistics::{
    Autocovariance, Consistency, Correlator, Moments, NisSummary, ResidualModel, RobustSpread, Whiteness,
};

/// Accumulates errors and innovations of one source in one phase, in one pass.
#[derive(Clone, Debug, Default)]
pub(super) struct PhaseStatistics {
    moments: Moments,
    spread: RobustSpread,
    errors: Correlator,
    innovations: Correlator,
    nis: NisSummary,
    span_us: Option<(u64, u64)>,
}

/// Statistics of a sensor's errors in one phase. A value that the readings cannot give is `None`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct PhaseSummary {
    /// Number of readings that had a reference to compare with.
    pub readings: u64,
    /// Time from the first of them to the last, seconds.
    pub duration_s: f64,
    /// Mean error (eq. 16, with the latched calibration), metres.
    pub bias_m: Option<f64>,
    /// Standard error of that mean, with the errors' own autocorrelation, metres.
    pub bias_standard_error_m: Option<f64>,
    /// Standard deviation of the error, metres.
    pub spread_m: Option<f64>,
    /// The same from the median absolute deviation, which a few outliers do not move, metres.
    pub robust_spread_m: Option<f64>,
    /// Root mean square of the error, metres.
    pub rms_m: Option<f64>,
    /// How many independent readings they are worth.
    pub effective_readings: Option<f64>,
    /// Correlation time of the error (integrated autocorrelation time), seconds.
    pub correlation_time_s: Option<f64>,
    /// Whiteness of the errors.
    pub error_whiteness: Option<Whiteness>,
    /// Whiteness of the filter's innovations; captive flight only.
    pub innovation_whiteness: Option<Whiteness>,
    /// Normalised innovation squared against its chi-squared bounds; captive flight only.
    pub nis: Option<Consistency>,
}

impl PhaseStatistics {
    /// Takes an error, metres.
    #[inline]
    pub(super) fn take_error(&mut self, time_us: u64, error_m: f64) {
        self.moments.push(error_m);
        self.spread.push(error_m);
        self.errors.push(error_m);
        self.span_us = Some((self.span_us.map_or(time_us, |(first, _)| first), time_us));
    }

    /// Takes a normalised innovation squared that carries the innovation's sign.
    #[inline]
    pub(super) fn take_nis(&mut self, signed_nis: f32) {
        let signed = f64::from(signed_nis);
        self.nis.push(signed.abs());
        self.innovations.push(signed.abs().sqrt().copysign(signed));
    }

    /// Takes a sensor's captive output. The bias estimate of that moment is added back, so that all residuals
    /// have about the same origin however the estimate moved.
    #[inline]
    pub(super) fn take_captive(&mut self, time_us: u64, output: &SensorOutput) {
        if let Some(error_m) = output.error_m {
            self.take_error(time_us, f64::from(error_m) + f64::from(output.bias_m));
        }
        if let Some(signed_nis) = output.signed_nis {
            self.take_nis(signed_nis);
        }
    }

    pub(super) fn readings(&self) -> u64 {
        self.moments.count()
    }

    /// Mean of the errors taken, metres.
    pub(super) fn mean_m(&self) -> Option<f64> {
        self.moments.mean()
    }

    /// Standard deviation of the errors taken, metres.
    pub(super) fn spread_m(&self) -> Option<f64> {
        self.moments.standard_deviation()
    }

    /// Mean time between readings, seconds.
    fn interval_s(&self) -> Option<f64> {
        let (first, last) = self.span_us?;
        let intervals = self.moments.count().checked_sub(1).filter(|count| *count > 0)?;
        let interval = (last - first) as f64 * 1e-6 / intervals as f64;
        (interval > 0.0).then_some(interval)
    }

    /// The errors' stochastic model.
    pub(super) fn residual_model(&self) -> Option<ResidualModel> {
        ResidualModel::fit(&self.errors.autocovariance()?, self.interval_s()?)
    }

    /// Summary with errors counted from `origin_m`.
    pub(super) fn summary(&self, origin_m: f64) -> PhaseSummary {
        let autocovariance = self.errors.autocovariance();
        let span_s = self.span_us.map_or(0.0, |(first, last)| (last - first) as f64 * 1e-6);
        PhaseSummary {
            readings: self.moments.count(),
            duration_s: span_s,
            bias_m: self.moments.mean().map(|mean| mean - origin_m),
            bias_standard_error_m: autocovariance.as_ref().map(Autocovariance::standard_error_of_mean),
            spread_m: self.moments.standard_deviation(),
            robust_spread_m: self.spread.sigma(),
            rms_m: self.moments.rms_about(origin_m),
            effective_readings: autocovariance.as_ref().map(Autocovariance::effective_count),
            correlation_time_s: autocovariance
                .as_ref()
                .zip(self.interval_s())
                .map(|(errors, interval)| errors.integrated_time() * interval),
            error_whiteness: autocovariance.as_ref().and_then(Whiteness::test),
            innovation_whiteness: self.innovations.autocovariance().as_ref().and_then(Whiteness::test),
            nis: self.nis.consistency(),
        }
    }
}
