//! The two presets, and the sources of their numbers.

use kf_core::config::{
    ClimbRate, MonitorConfig, QualityConfig, ReferenceConfig, SecondCorrection, SensorConfig, SigmaSource,
};

use crate::Model;
use crate::definitions::Definitions;

/// Wander of the Kalman filter of section 4 if a model does not give one, m per root second: an error that
/// grows by about 10 m within the 100 s of a dive and level-off.
pub const SECOND_CORRECTION_WANDER_M_PER_SQRT_S: f32 = 1.0;

impl Default for Model {
    /// Today's MEMS sensors (ICM-42688-P, MS5611) and a single-frequency multi-constellation receiver.
    fn default() -> Self {
        Self {
            settling_s: 10.0,
            reference: ReferenceConfig {
                // Data sheets give about 2 m CEP, 1.7 m a horizontal axis; the vertical is worse, SBAS
                // improves it. Logs show 1 to 5 m of wander over minutes (ionosphere, ephemerides,
                // multipath): its correlation time is of the order of a minute.
                sigma_m: 2.0,
                correlation_time_s: 60.0,
                prior_altitude_m: None,
                // About the first fix; wide, because that fix is then also used as a measurement.
                prior_sigma_m: 50.0,
                // Doppler: 0.05 m/s (50 %) a horizontal axis by the data sheets, twice to three times that in
                // the vertical; its errors come from multipath and the clock and last some seconds.
                climb_rate: Some(ClimbRate { sigma_mps: 0.15, correlation_time_s: 5.0 }),
                // Without fixes the climb rate becomes old as well: 0.2 m/s^2 of it is 2.5 m in 5 s, more
                // than a fix's own error. Slow loggers (a fix every 4 s) stay below this.
                lost_after_s: 5.0,
            },
            latitude_deg: kf_core::effect::DEFAULT_LATITUDE_DEG,
            sensors: [
                // The mother ship's inertial altitude, baro-damped: some metres of slow oscillation.
                SensorConfig {
                    sigma_m: 3.0,
                    correlation_time_s: 10.0,
                    prior_bias_m: 0.0,
                    prior_sigma_m: 100.0,
                    wander_m_per_sqrt_s: 0.1,
                },
                // Strapdown vertical channel of a MEMS unit: 1 mg of uncompensated accelerometer bias
                // (temperature, g-dependence) is 18 m after 60 s, and the bias estimate follows it with a
                // wander of the same size: 18 m / sqrt(60 s) = 2.3 m per root second.
                SensorConfig {
                    sigma_m: 1.0,
                    correlation_time_s: 1.0,
                    prior_bias_m: 0.0,
                    prior_sigma_m: 150.0,
                    wander_m_per_sqrt_s: 2.3,
                },
                // MS5611: 0.1 m of noise, 12 m of accuracy. The rest is air: static-port turbulence of
                // some 0.5 m over half a second; a sea-level pressure that differs from the standard by
                // 10 hPa (1 sigma), hence 85 m, and by some tens of metres of geoid on an ellipsoidal
                // datum; weather of 1 hPa an hour, hence 8.4 m / sqrt(3600 s) = 0.14 m per root second.
                SensorConfig {
                    sigma_m: 0.5,
                    correlation_time_s: 0.5,
                    prior_bias_m: 0.0,
                    prior_sigma_m: 100.0,
                    wander_m_per_sqrt_s: 0.14,
                },
            ],
            // A limit of one sigma would raise `doubtful` on every healthy sensor within a second or two.
            monitor: MonitorConfig {
                sigma: SigmaSource::Residual,
                multiplier: 3.0,
                window_s: 2.0,
                // A transient of a second passes, with a quarter for the time until a chip delivers again.
                // Drifts are not delayed: a drift's average follows its error a second later.
                persistence_s: 1.25,
                reference_check: true,
            },
            second_correction: SecondCorrection::Off,
            quality: QualityConfig {
                // Half a correlation time of the reference: if shorter, its wander becomes the bias's error.
                minimum_duration_s: 30.0,
                // An autopilot's altitude and speed hold in light turbulence.
                trimmed_altitude_m: 10.0,
                trimmed_airspeed_mps: 2.0,
                // A receiver that has not converged drifts by metres against its own Doppler. A converged one
                // drifts by its 2 m of wander, and by 0.47 m per root second of Doppler, 2.6 m in the last 30
                // s of a minute. 6 m is two sigma of both.
                reference_drift_m: 6.0,
                // Four solve for position and clock; six leave two for detecting a bad one.
                minimum_satellites: 6,
                vertical_accuracy_m: 5.0,
                bias_drift_sigmas: 1.0,
                // A Gaussian has 0.27 % beyond three sigmas; ten times that is a different distribution.
                implausible_share: 0.027,
            },
            definitions: Definitions::default(),
            effects: Vec::new(),
            revisions: Vec::new(),
        }
    }
}

impl Model {
    /// The paper's section 3.2: x0, P0 and R as printed, A = I, Q = 0, no effect, and eq. 17 at 1 sigma of
    /// the captive residual.
    ///
    /// Values that the paper does not print are chosen here: the moving average's length (2.5 s, the one that
    /// gives its four flag times on its reconstruction; flights/README.md), when the reference counts as
    /// lost, and the thresholds of the calibration's checks, which its data (a trimmed mother ship, 70 s, a
    /// GPS of 25 m) would pass.
    #[must_use]
    pub fn paper() -> Self {
        let sensor = |sigma_m, prior_sigma_m| SensorConfig {
            sigma_m,
            correlation_time_s: 0.0,
            prior_bias_m: 0.0,
            prior_sigma_m,
            wander_m_per_sqrt_s: 0.0,
        };
        Self {
            settling_s: 10.0,
            reference: ReferenceConfig {
                sigma_m: 25.0,
                correlation_time_s: 0.0,
                prior_altitude_m: Some(2100.0),
                prior_sigma_m: 50.0,
                climb_rate: None,
                lost_after_s: 5.0,
            },
            latitude_deg: kf_core::effect::DEFAULT_LATITUDE_DEG,
            sensors: [sensor(50.0, 100.0), sensor(70.0, 150.0), sensor(150.0, 300.0)],
            // In the paper both sensors drift away from the reference alike, and are flagged for it.
            monitor: MonitorConfig {
                sigma: SigmaSource::Residual,
                multiplier: 1.0,
                window_s: 2.5,
                persistence_s: 0.0,
                reference_check: false,
            },
            second_correction: SecondCorrection::Off,
            quality: QualityConfig {
                minimum_duration_s: 30.0,
                trimmed_altitude_m: 25.0,
                trimmed_airspeed_mps: 5.0,
                reference_drift_m: 25.0,
                minimum_satellites: 4,
                vertical_accuracy_m: 25.0,
                bias_drift_sigmas: 1.0,
                implausible_share: 0.027,
            },
            definitions: Definitions::default(),
            effects: Vec::new(),
            revisions: Vec::new(),
        }
    }

    /// The preset with this name, `default` or `paper`.
    #[must_use]
    pub fn preset(name: &str) -> Option<Self> {
        match name {
            "default" => Some(Self::default()),
            "paper" => Some(Self::paper()),
            _ => None,
        }
    }
}
