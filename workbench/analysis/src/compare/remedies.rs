//! Effect of a second correction in free flight (the paper's section 4).

use kf_core::output::{Phase, TickOutput};
use kf_core::sensor::{SENSORS, Sensor};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::flags::Flags;
use crate::name::Name;
use statistics::Moments;

/// Errors in free flight with one second correction.
#[derive(Clone, Debug, Default)]
pub(super) struct RemedyTally {
    errors: [Moments; SENSORS],
    flags: [Flags; SENSORS],
    launch_us: Option<u64>,
}

/// Result of a second correction for one sensor.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct RemedyFigures {
    /// The sensor.
    pub sensor: Name,
    /// Mean error in free flight, metres.
    pub mean_m: f64,
    /// Root mean square error in free flight, metres.
    pub rms_m: f64,
    /// When the sensor became doubtful, seconds after launch.
    pub doubtful_after_s: Option<f64>,
    /// When it became untrustworthy, seconds after launch.
    pub untrustworthy_after_s: Option<f64>,
}

/// One second correction, for every sensor that flies free.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Remedy {
    /// `none`, `moving_average` or `kalman`.
    pub second_correction: Name,
    /// The sensors.
    pub sensors: Vec<RemedyFigures>,
}

impl RemedyTally {
    /// Takes one tick.
    #[inline]
    pub(super) fn take(&mut self, output: &TickOutput) {
        if output.out_of_order || output.phase != Phase::FreeFlight {
            return;
        }
        self.launch_us.get_or_insert(output.time_us);
        for ((errors, flags), sensor) in self.errors.iter_mut().zip(&mut self.flags).zip(&output.sensors) {
            if let Some(error_m) = sensor.error_m {
                errors.push(f64::from(error_m));
            }
            flags.take(output.time_us, sensor.trust);
        }
    }

    /// The figures, with the name of the correction.
    pub(super) fn figures(&self, second_correction: &'static str) -> Remedy {
        let after_s = |time_us: Option<u64>| {
            let (time_us, launch_us) = time_us.zip(self.launch_us)?;
            Some(time_us.saturating_sub(launch_us) as f64 * 1e-6)
        };
        let sensors = Sensor::ALL.into_iter().filter(|sensor| sensor.flies_free()).filter_map(|sensor| {
            let (errors, flags) = (&self.errors[sensor.index()], &self.flags[sensor.index()]);
            Some(RemedyFigures {
                sensor: sensor.name().into(),
                mean_m: errors.mean()?,
                rms_m: errors.rms_about(0.0)?,
                doubtful_after_s: after_s(flags.doubtful_us),
                untrustworthy_after_s: after_s(flags.untrustworthy_us),
            })
        });
        Remedy { second_correction: second_correction.into(), sensors: sensors.collect() }
    }
}
