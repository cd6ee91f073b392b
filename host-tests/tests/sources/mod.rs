//! Models whose generated source is compared with the host's; together they give every key a value that is
//! not the default's.

pub const DEFAULT: &str = "";

pub const PAPER: &str = include_str!("../../../flights/models/paper.toml");

/// Floats that a decimal form could easily lose: a subnormal, the largest, a negative zero.
pub const ESTIMATED: &str = r#"
    settling_s = 0.1
    second_correction = "kalman"
    second_correction_wander_m_per_sqrt_s = 1e-40
    [gps]
    sigma_m = 3.4028235e38
    correlation_time_s = 0.3
    prior_altitude_m = -0.0
    climb_rate_sigma_mps = 0.7
    [sensor.imu_slave]
    prior_bias_m = -72.8909
    [monitor]
    sigma = "covariance"
    multiplier = 1.1
    [quality]
    minimum_satellites = 255
    [[effect]]
    id = "baro.dynamic_pressure"
    coefficient = -0.1
    sigma = 0.3
    estimate = true
    envelope_m = [-0.0, 1e-40]
    [[effect]]
    id = "gps.convergence"
    sigma = 0.3
    estimate = true
    time_constant_s = 0.7
    since = "start"
"#;

pub const CONSTANT: &str = r#"
    second_correction = "moving_average"
    [site]
    latitude_deg = -0.1
    [monitor]
    sigma = "datasheet"
    [[effect]]
    id = "baro.dynamic_pressure"
    coefficient = 0.1
    [[effect]]
    id = "baro.warm_up"
    coefficient = 0.1
    time_constant_s = 1e-40
    [[revision]]
    number = 1
"#;
