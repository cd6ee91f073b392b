//! Detects which sensors are present, and which are healthy.

use kf_core::mission::{Counters, SourceCounters};
use kf_core::output::{Rejection, Trust};
use kf_core::sensor::{SENSORS, Sensor};
use mavlink::dialects::common::MavSysStatusSensor;

use super::TickReport;

/// Silence after which a sensor is not healthy, milliseconds: the slowest, a receiver, delivers once a
/// second.
const SILENT_AFTER_MS: u32 = 2_500;

/// Time at which a source last delivered, and whether that was refused.
#[derive(Clone, Copy, Debug, Default)]
struct Source {
    last_ms: Option<u32>,
    refused: bool,
}

/// Every source with a bit in SYS_STATUS.
#[derive(Clone, Copy, Debug)]
pub struct Watch {
    imu: Source,
    barometer: Source,
    receiver: Source,
    imu_slave: Source,
}

impl Source {
    const NONE: Self = Self { last_ms: None, refused: false };

    /// A held fix is no sample, but it is no fault either: between fixes a receiver may repeat itself.
    fn take(&mut self, now_ms: u32, is_there: bool, rejection: Option<Rejection>) {
        if is_there && rejection != Some(Rejection::Held) {
            self.last_ms = Some(now_ms);
            self.refused = rejection.is_some();
        }
    }

    fn is_well(self, now_ms: u32) -> bool {
        !self.refused && self.last_ms.is_some_and(|at_ms| now_ms.wrapping_sub(at_ms) <= SILENT_AFTER_MS)
    }
}

impl Watch {
    pub const fn new() -> Self {
        Self { imu: Source::NONE, barometer: Source::NONE, receiver: Source::NONE, imu_slave: Source::NONE }
    }

    pub fn take(&mut self, report: &TickReport<'_>, now_ms: u32) {
        let (input, output) = (report.input, report.output);
        let [_, slave, baro] = &output.sensors;
        let is_finite = |axes: &[f32; 3]| axes.iter().all(|axis| axis.is_finite());
        let bad_imu =
            input.imu.as_ref().filter(|imu| !is_finite(&imu.accel_mps2) || !is_finite(&imu.gyro_radps));
        self.imu.take(now_ms, input.imu.is_some(), bad_imu.map(|_| Rejection::NotFinite));
        self.barometer.take(now_ms, input.baro.is_some(), baro.rejection);
        self.receiver.take(now_ms, input.gps.is_some(), output.gps_rejection);
        self.imu_slave.take(now_ms, input.imu_slave_altitude_m.is_some(), slave.rejection);
    }

    /// The bits of the sensors that have ever delivered, and of those that are healthy.
    pub fn bits(&self, trust: &[Trust; SENSORS], now_ms: u32) -> (MavSysStatusSensor, MavSysStatusSensor) {
        use MavSysStatusSensor as Bit;
        let is_trusted = |sensor: Sensor| trust.get(sensor.index()) != Some(&Trust::Untrustworthy);
        let sources = [
            (&self.imu, true, Bit::MAV_SYS_STATUS_SENSOR_3D_GYRO | Bit::MAV_SYS_STATUS_SENSOR_3D_ACCEL),
            (&self.barometer, is_trusted(Sensor::Baro), Bit::MAV_SYS_STATUS_SENSOR_ABSOLUTE_PRESSURE),
            (&self.receiver, true, Bit::MAV_SYS_STATUS_SENSOR_GPS),
            (&self.imu_slave, is_trusted(Sensor::ImuSlave), Bit::MAV_SYS_STATUS_AHRS),
        ];
        let (mut present, mut healthy) = (Bit::empty(), Bit::empty());
        for (source, is_trusted, bit) in sources {
            if source.last_ms.is_some() {
                present |= bit;
            }
            if is_trusted && source.is_well(now_ms) {
                healthy |= bit;
            }
        }
        (present, healthy)
    }
}

/// Readings, fixes and signals that the estimator refused: all its counts except held fixes, which are no
/// fault.
pub fn refused(counters: &Counters) -> u32 {
    let of = |source: &SourceCounters| {
        let refused = [source.not_finite, source.stuck, source.variance, source.gated, source.implausible];
        refused.into_iter().fold(0, u32::saturating_add)
    };
    let sensors =
        counters.sensors.iter().fold(of(&counters.gps), |sum, source| sum.saturating_add(of(source)));
    sensors.saturating_add(counters.signals_not_finite)
}
