//! The sensors: rates, errors, failures. The defaults are today's MEMS parts, without a bias.

use serde::Deserialize;

/// A stretch of time.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Interval {
    /// Start, s since the first row.
    pub start_s: f64,
    /// Its length, s.
    pub duration_s: f64,
}

impl Interval {
    /// Whether a time lies in it (the end is excluded).
    #[must_use]
    pub fn contains(&self, time_s: f64) -> bool {
        time_s >= self.start_s && time_s < self.start_s + self.duration_s
    }
}

/// Additive noise: white, and a Gauss-Markov wander. A part that a scenario leaves out is zero.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Noise {
    /// White part (1 sigma), in the reading's unit.
    pub white: f64,
    /// Wander (1 sigma), in the reading's unit.
    pub wander: f64,
    /// Correlation time of the wander, s.
    pub wander_time_s: f64,
}

/// When a sensor delivers. If set in a scenario, it must give the rate.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sampling {
    /// Samples a second.
    pub rate_hz: f64,
    /// Whether the flight has this sensor.
    #[serde(default = "enabled")]
    pub enabled: bool,
    /// Age of a sample when it is delivered, s.
    #[serde(default)]
    pub latency_s: f64,
    /// Probability that a sample is lost.
    #[serde(default)]
    pub dropout_probability: f64,
    /// Stretches in which every sample is lost.
    #[serde(default)]
    pub outages: Vec<Interval>,
}

const fn enabled() -> bool {
    true
}

impl Sampling {
    /// A sensor that delivers every sample at once.
    #[must_use]
    pub const fn every(rate_hz: f64) -> Self {
        Self { rate_hz, enabled: true, latency_s: 0.0, dropout_probability: 0.0, outages: Vec::new() }
    }
}

/// Error that the mother ship's disturbed flow adds to a sensor under the pylon; none after release.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CarrierFlow {
    /// Spread (1 sigma), m.
    pub sigma_m: f64,
    /// Correlation time, s: an eddy's size over the airspeed.
    pub correlation_time_s: f64,
    /// Factor by which it is larger during the settling time.
    pub settling_factor: f64,
}

impl Default for CarrierFlow {
    fn default() -> Self {
        Self { sigma_m: 0.0, correlation_time_s: 0.02, settling_factor: 1.0 }
    }
}

/// The barometer.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Barometer {
    /// When it delivers.
    pub sampling: Sampling,
    /// Bias, m.
    pub bias_m: f64,
    /// Noise, m.
    pub noise: Noise,
    /// Resolution of the written pressure, Pa; 0 for none.
    pub quantum_pa: f64,
    /// The mother ship's disturbed flow.
    pub carrier_flow: CarrierFlow,
    /// The sensor's own temperature.
    pub temperature: BarometerTemperature,
}

impl Default for Barometer {
    fn default() -> Self {
        Self {
            sampling: Sampling::every(50.0),
            bias_m: 0.0,
            noise: Noise { white: 0.3, wander: 0.3, wander_time_s: 30.0 },
            quantum_pa: 1.0,
            carrier_flow: CarrierFlow { sigma_m: 1.0, ..CarrierFlow::default() },
            temperature: BarometerTemperature::default(),
        }
    }
}

/// The barometer's own temperature: it follows the outside air with a lag, and heats itself.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct BarometerTemperature {
    /// Temperature at the first row, above outside air, degrees Celsius.
    pub initial_excess_c: f64,
    /// Excess over the outside air in equilibrium, degrees Celsius.
    pub self_heating_c: f64,
    /// Time constant, s.
    pub time_constant_s: f64,
    /// Noise (1 sigma), degrees Celsius.
    pub sigma_c: f64,
}

impl Default for BarometerTemperature {
    fn default() -> Self {
        Self { initial_excess_c: 2.0, self_heating_c: 8.0, time_constant_s: 90.0, sigma_c: 0.02 }
    }
}

/// An inertial altitude.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct AltitudeSensor {
    /// When it delivers.
    pub sampling: Sampling,
    /// Bias, m.
    pub bias_m: f64,
    /// Noise, m.
    pub noise: Noise,
    /// Resolution, m; 0 for none.
    pub quantum_m: f64,
    /// The mother ship's disturbed flow.
    pub carrier_flow: CarrierFlow,
}

impl Default for AltitudeSensor {
    fn default() -> Self {
        Self {
            sampling: Sampling::every(50.0),
            bias_m: 0.0,
            noise: Noise { white: 0.2, wander: 0.3, wander_time_s: 60.0 },
            quantum_m: 0.01,
            carrier_flow: CarrierFlow { sigma_m: 0.5, ..CarrierFlow::default() },
        }
    }
}

/// The receiver's altitude error after a cold start.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ColdStart {
    /// Altitude error at the first row, m.
    pub altitude_error_m: f64,
    /// Time constant of its decay, s.
    pub time_constant_s: f64,
    /// Satellites at the first row.
    pub satellites: u8,
}

/// The receiver.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Gps {
    /// When it delivers.
    pub sampling: Sampling,
    /// Bias of the altitude, m.
    pub bias_m: f64,
    /// Noise of the altitude, m.
    pub noise: Noise,
    /// Noise of each velocity component (1 sigma), m/s.
    pub velocity_sigma_mps: f64,
    /// Resolution of the altitude, m; 0 for none.
    pub quantum_m: f64,
    /// The receiver's own low-pass filter of the altitude, s; 0 for none.
    pub smoothing_s: f64,
    /// Satellites in use.
    pub satellites: u8,
    /// Ratio of the reported accuracy to the true spread.
    pub accuracy_factor: f64,
    /// Cold start at the first row; if missing, the receiver has converged.
    pub cold_start: Option<ColdStart>,
    /// Whether rows between fixes repeat the last one.
    pub hold: bool,
    /// Whether the flight has the receiver's time of each fix (`gps_time_s`), which identifies held fixes.
    pub fix_time: bool,
    /// Stretches in which the receiver keeps sending the last fix.
    pub freezes: Vec<Interval>,
}

impl Default for Gps {
    fn default() -> Self {
        Self {
            sampling: Sampling::every(5.0),
            bias_m: 0.0,
            noise: Noise { white: 0.4, wander: 1.5, wander_time_s: 60.0 },
            velocity_sigma_mps: 0.1,
            quantum_m: 0.001,
            smoothing_s: 0.0,
            satellites: 14,
            accuracy_factor: 1.0,
            cold_start: None,
            hold: false,
            fix_time: true,
            freezes: Vec::new(),
        }
    }
}

/// Accelerometers and gyroscopes.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Inertial {
    /// When they deliver.
    pub sampling: Sampling,
    /// Accelerometer noise, m/s^2.
    pub accel_noise: Noise,
    /// Accelerometer bias, body axes, m/s^2.
    pub accel_bias_mps2: [f64; 3],
    /// Accelerometer resolution, m/s^2; 0 for none.
    pub accel_quantum_mps2: f64,
    /// Gyroscope noise, rad/s.
    pub gyro_noise: Noise,
    /// Gyroscope bias, body axes, rad/s.
    pub gyro_bias_radps: [f64; 3],
    /// Gyroscope resolution, rad/s; 0 for none.
    pub gyro_quantum_radps: f64,
}

/// Noise density and resolution of TDK's ICM-42688-P (DS-000347, tables 1 and 2) at 200 Hz, +-16 g and
/// +-2000 deg/s.
impl Default for Inertial {
    fn default() -> Self {
        Self {
            sampling: Sampling::every(200.0),
            accel_noise: Noise { white: 0.007, wander: 0.003, wander_time_s: 100.0 },
            accel_bias_mps2: [0.0; 3],
            accel_quantum_mps2: 9.806_65 / 2048.0,
            gyro_noise: Noise { white: 0.000_5, wander: 0.000_1, wander_time_s: 100.0 },
            gyro_bias_radps: [0.0; 3],
            gyro_quantum_radps: core::f64::consts::PI / 180.0 / 16.4,
        }
    }
}

/// Airspeed, flow angles and outside air temperature.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct AirData {
    /// When they deliver.
    pub sampling: Sampling,
    /// Noise of the true airspeed (1 sigma), m/s.
    pub airspeed_sigma_mps: f64,
    /// Noise of the flow angles (1 sigma), rad.
    pub angle_sigma_rad: f64,
    /// Noise of the outside air temperature (1 sigma), degrees Celsius.
    pub temperature_sigma_c: f64,
}

impl Default for AirData {
    fn default() -> Self {
        Self {
            sampling: Sampling::every(50.0),
            airspeed_sigma_mps: 0.3,
            angle_sigma_rad: 0.003,
            temperature_sigma_c: 0.1,
        }
    }
}

/// Attitude and throttle.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct AttitudeSensor {
    /// When they deliver.
    pub sampling: Sampling,
    /// Noise of each angle (1 sigma), rad.
    pub sigma_rad: f64,
}

impl Default for AttitudeSensor {
    fn default() -> Self {
        Self { sampling: Sampling::every(50.0), sigma_rad: 0.002 }
    }
}

/// All sensors.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Sensors {
    /// The reference.
    pub gps: Gps,
    /// The UAV's barometer.
    pub baro: Barometer,
    /// The mother ship's inertial altitude, captive flight only.
    pub imu_master: AltitudeSensor,
    /// The UAV's inertial altitude.
    pub imu_slave: AltitudeSensor,
    /// The UAV's accelerometers and gyroscopes.
    pub inertial: Inertial,
    /// The UAV's air data.
    pub air_data: AirData,
    /// The UAV's attitude and throttle.
    pub attitude: AttitudeSensor,
}
