//! kf-core on the same problem.

use kf_core::config::{
    MissionConfig, MonitorConfig, QualityConfig, ReferenceConfig, SecondCorrection, SensorConfig, SigmaSource,
};
use kf_core::effect::{EffectId, EffectTerm};
use kf_core::estimator::{ConfigError, Estimator, MeasurementNoise};
use kf_core::input::{BaroReading, Columns, GpsFix, LaunchDoubt, Signals, TickInput};
use kf_core::mission::Mission;
use kf_core::monitor::Monitor;
use kf_core::sensor::Sensor;

use crate::problem::{Filter, NOISE, NOISE_SIGMAS, PRIOR_SIGMAS, STATE};

/// The paper's preset, with `E` effects on the barometer as states.
pub fn configuration<const E: usize>() -> MissionConfig<E> {
    let sensor = |i: usize| SensorConfig {
        sigma_m: NOISE_SIGMAS[i],
        correlation_time_s: 0.0,
        prior_bias_m: STATE[i],
        prior_sigma_m: PRIOR_SIGMAS[i],
        wander_m_per_sqrt_s: 0.0,
    };
    MissionConfig {
        settling_s: 0.0,
        reference: ReferenceConfig {
            sigma_m: NOISE_SIGMAS[0],
            correlation_time_s: 0.0,
            prior_altitude_m: Some(STATE[0]),
            prior_sigma_m: PRIOR_SIGMAS[0],
            climb_rate: None,
            lost_after_s: 1.0,
        },
        latitude_deg: 45.0,
        sensors: [sensor(1), sensor(2), sensor(3)],
        monitor: MonitorConfig {
            sigma: SigmaSource::Residual,
            multiplier: 1.0,
            window_s: 2.0,
            persistence_s: 0.0,
            reference_check: false,
        },
        second_correction: SecondCorrection::Off,
        quality: QualityConfig {
            minimum_duration_s: 1.0,
            trimmed_altitude_m: 10.0,
            trimmed_airspeed_mps: 10.0,
            reference_drift_m: 10.0,
            minimum_satellites: 4,
            vertical_accuracy_m: 30.0,
            bias_drift_sigmas: 1.0,
            implausible_share: 0.1,
        },
        estimated_effects: [EffectTerm::new(EffectId::BaroDynamicPressure, 0.0, 0.1); E],
        constant_effects: heapless::Vec::new(),
    }
}

/// The sensors whose biases are states.
const SENSORS: [Sensor; 3] = [Sensor::ImuMaster, Sensor::ImuSlave, Sensor::Baro];

/// The filter, compensated, with `E` effects on the barometer as states.
pub struct UdFilter<const HEAD: usize, const TAIL: usize, const E: usize> {
    estimator: Estimator<HEAD, TAIL, E>,
    noise: [MeasurementNoise; 4],
    /// For each sensor: zero except for the barometer's, which the filter does not know in advance.
    regressors_m: [[f32; E]; 3],
    refused: u32,
}

impl<const HEAD: usize, const TAIL: usize, const E: usize> UdFilter<HEAD, TAIL, E> {
    /// The filter on the paper's problem.
    pub fn new() -> Result<Self, ConfigError> {
        let noise = |i: usize| MeasurementNoise::from_variance_m2(NOISE[i]);
        Ok(Self {
            estimator: Estimator::new(&configuration::<E>(), STATE[0])?,
            noise: [noise(0)?, noise(1)?, noise(2)?, noise(3)?],
            regressors_m: [[0.0; E], [0.0; E], core::array::from_fn(|effect| 10.0 + effect as f32)],
            refused: 0,
        })
    }
}

impl<const HEAD: usize, const TAIL: usize, const E: usize> Filter for UdFilter<HEAD, TAIL, E> {
    #[inline(always)]
    fn tick(&mut self, _time_us: u64, measurements: &[f32; 4]) {
        let [gps, master, slave, baro] = *measurements;
        let [gps_noise, noise @ ..] = &self.noise;
        let readings_m = [master, slave, baro];
        let result = self.estimator.update_together(
            gps,
            &[0.0; E],
            *gps_noise,
            &readings_m,
            &self.regressors_m,
            noise,
            |_| true,
        );
        if result.is_err() {
            self.refused += 1;
        }
    }

    fn state(&self) -> [f32; 4] {
        let [master, slave, baro] = SENSORS.map(|sensor| self.estimator.bias_m(sensor));
        // A refused measurement must not look like a cheap one.
        let altitude_m = if self.refused == 0 { self.estimator.altitude_m() } else { f32::NAN };
        [altitude_m, master, slave, baro]
    }

    fn variances(&self) -> [f32; 4] {
        let [master, slave, baro] = SENSORS.map(|sensor| self.estimator.bias_variance_m2(sensor));
        [self.estimator.altitude_variance_m2(), master, slave, baro]
    }
}

/// Table 1's biases of the sensors that fly free: a monitor subtracts latched biases.
const LATCHED_BIASES_M: [f32; 2] = [-72.8909, -121.8691];

/// The filter, followed by the monitors of the two sensors that fly free (eqs 16 and 17).
pub struct Monitored {
    filter: UdFilter<3, 1, 0>,
    monitors: [Monitor; 2],
    averages_m: [f32; 2],
}

impl Monitored {
    /// On the paper's problem, with the alarm limits of Table 1 and a window of 3 s.
    pub fn new() -> Result<Self, ConfigError> {
        let monitors =
            [Monitor::new(32.4422 * 32.4422, 3_000_000), Monitor::new(40.3308 * 40.3308, 3_000_000)];
        Ok(Self { filter: UdFilter::new()?, monitors, averages_m: [0.0; 2] })
    }
}

impl Filter for Monitored {
    #[inline(always)]
    fn tick(&mut self, time_us: u64, measurements: &[f32; 4]) {
        self.filter.tick(time_us, measurements);
        let [gps, _, slave, baro] = *measurements;
        let errors_m = [slave - LATCHED_BIASES_M[0] - gps, baro - LATCHED_BIASES_M[1] - gps];
        for ((monitor, error_m), average_m) in
            self.monitors.iter_mut().zip(errors_m).zip(&mut self.averages_m)
        {
            *average_m = monitor.update(time_us, error_m);
        }
    }

    fn state(&self) -> [f32; 4] {
        self.filter.state()
    }

    fn variances(&self) -> [f32; 4] {
        self.filter.variances()
    }
}

/// A whole tick of the mission: plausibility, signals, filter, statistics, monitors, output.
pub struct WholeTick<const HEAD: usize, const TAIL: usize, const E: usize> {
    mission: Mission<HEAD, TAIL, E>,
    launch_us: u64,
    state: [f32; 4],
    variances: [f32; 4],
}

impl<const HEAD: usize, const TAIL: usize, const E: usize> WholeTick<HEAD, TAIL, E> {
    /// On the paper's problem; launched after this many ticks.
    pub fn new(launch_after: u64) -> Result<Self, ConfigError> {
        Ok(Self {
            mission: Mission::new(&configuration::<E>())?,
            launch_us: launch_after.saturating_mul(crate::TICK_US),
            state: STATE,
            variances: [0.0; 4],
        })
    }
}

impl<const HEAD: usize, const TAIL: usize, const E: usize> Filter for WholeTick<HEAD, TAIL, E> {
    fn tick(&mut self, time_us: u64, measurements: &[f32; 4]) {
        let [gps, master, slave, baro] = *measurements;
        let input = TickInput {
            time_us,
            launch: time_us > self.launch_us,
            launch_doubt: LaunchDoubt::None,
            gps: Some(GpsFix { altitude_m: gps, ..GpsFix::default() }),
            baro: Some(BaroReading::AltitudeM(baro)),
            imu_master_altitude_m: Some(master),
            imu_slave_altitude_m: Some(slave),
            imu: None,
            signals: Signals { true_airspeed_mps: Some(60.0), ..Signals::default() },
            columns: Columns::default(),
        };
        let output = self.mission.tick(&input);
        let [master, slave, baro] = output.sensors;
        self.state = [output.altitude_m, master.bias_m, slave.bias_m, baro.bias_m];
        self.variances = [
            output.altitude_variance_m2,
            master.bias_variance_m2,
            slave.bias_variance_m2,
            baro.bias_variance_m2,
        ];
    }

    fn state(&self) -> [f32; 4] {
        self.state
    }

    fn variances(&self) -> [f32; 4] {
        self.variances
    }
}
