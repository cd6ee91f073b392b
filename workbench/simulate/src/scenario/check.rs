//! Checks a scenario's numbers. Every message gives the key, its value and what was expected.

use super::plan::{Manoeuvre, Segment};
use super::problem::{Expected, ScenarioProblem};
use super::sensors::{
    AirData, AltitudeSensor, AttitudeSensor, Barometer, CarrierFlow, Gps, Inertial, Interval, Noise, Sampling,
};
use super::{Airframe, Captive, Effect, EffectId, Scenario};

type Check = Result<(), ScenarioProblem>;

fn fail(key: &str, value: f64, expected: Expected) -> Check {
    Err(ScenarioProblem::Number { key: key.to_owned(), value, expected })
}

fn finite(key: &str, value: f64) -> Check {
    if value.is_finite() { Ok(()) } else { fail(key, value, Expected::Finite) }
}

fn positive(key: &str, value: f64) -> Check {
    finite(key, value)?;
    if value > 0.0 { Ok(()) } else { fail(key, value, Expected::Positive) }
}

fn not_negative(key: &str, value: f64) -> Check {
    finite(key, value)?;
    if value >= 0.0 { Ok(()) } else { fail(key, value, Expected::NotNegative) }
}

fn between(key: &str, value: f64, low: f64, high: f64) -> Check {
    finite(key, value)?;
    if (low..=high).contains(&value) { Ok(()) } else { fail(key, value, Expected::Between(low, high)) }
}

impl Scenario {
    /// Returns the first thing that cannot be simulated.
    pub(super) fn check(&self) -> Check {
        if self.name.is_empty() || self.name.contains(['\n', '\r']) {
            return Err(ScenarioProblem::NotOneLine { keys: "`name`", is: "is empty or has a line break" });
        }
        if self.source.contains(['\n', '\r']) || self.vehicle.name.contains(['\n', '\r']) {
            return Err(ScenarioProblem::NotOneLine {
                keys: "`source` or `vehicle.name`",
                is: "has a line break",
            });
        }
        between("rate_hz", self.rate_hz, 1.0, 2000.0)?;
        between("latitude_deg", self.latitude_deg, -90.0, 90.0)?;
        not_negative("vehicle.vibration_mps2", self.vehicle.vibration_mps2)?;
        self.vehicle.airframe.check("vehicle.airframe")?;
        self.carrier.check("carrier")?;
        between("atmosphere.temperature_offset_c", self.atmosphere.temperature_offset_c, -60.0, 60.0)?;
        let pressure = self.atmosphere.sea_level_pressure_pa;
        between("atmosphere.sea_level_pressure_pa", pressure, 85_000.0, 110_000.0)?;
        finite("wind.north_mps", self.wind.north_mps)?;
        finite("wind.east_mps", self.wind.east_mps)?;
        finite("wind.shear_north_per_s", self.wind.shear_north_per_s)?;
        finite("wind.shear_east_per_s", self.wind.shear_east_per_s)?;
        not_negative("turbulence.horizontal_sigma_mps", self.turbulence.horizontal_sigma_mps)?;
        not_negative("turbulence.vertical_sigma_mps", self.turbulence.vertical_sigma_mps)?;
        positive("turbulence.length_m", self.turbulence.length_m)?;
        self.captive.check()?;
        for (index, segment) in self.free_flight.iter().enumerate() {
            segment.check(&format!("free_flight[{index}]"))?;
        }
        // Rows are counted in 32 bits, and their times kept exact in double precision.
        between("captive.duration_s + free_flight", self.duration_s(), 1.0 / self.rate_hz, 1e6)?;
        let sensors = &self.sensors;
        sensors.gps.check(self.rate_hz)?;
        sensors.baro.check(self.rate_hz)?;
        sensors.imu_master.check("sensors.imu_master", self.rate_hz)?;
        sensors.imu_slave.check("sensors.imu_slave", self.rate_hz)?;
        sensors.inertial.check(self.rate_hz)?;
        sensors.air_data.check(self.rate_hz)?;
        sensors.attitude.check(self.rate_hz)?;
        self.effect
            .iter()
            .enumerate()
            .try_for_each(|(index, effect)| effect.check(&format!("effect[{index}]")))
    }
}

impl Airframe {
    fn check(&self, at: &str) -> Check {
        for (key, value) in [
            ("mass_kg", self.mass_kg),
            ("wing_area_m2", self.wing_area_m2),
            ("lift_slope_per_rad", self.lift_slope_per_rad),
            ("side_force_slope_per_rad", self.side_force_slope_per_rad),
            ("path_time_constant_s", self.path_time_constant_s),
            ("bank_time_constant_s", self.bank_time_constant_s),
            ("rate_time_constant_s", self.rate_time_constant_s),
            ("engine_time_constant_s", self.engine_time_constant_s),
        ] {
            positive(&format!("{at}.{key}"), value)?;
        }
        for (key, value) in [
            ("zero_lift_drag", self.zero_lift_drag),
            ("induced_drag", self.induced_drag),
            ("maximum_thrust_n", self.maximum_thrust_n),
        ] {
            not_negative(&format!("{at}.{key}"), value)?;
        }
        between(&format!("{at}.zero_lift_angle_deg"), self.zero_lift_angle_deg, -20.0, 20.0)?;
        between(&format!("{at}.maximum_angle_deg"), self.maximum_angle_deg, self.zero_lift_angle_deg, 25.0)?;
        between(&format!("{at}.minimum_load_factor"), self.minimum_load_factor, -10.0, 1.0)?;
        between(&format!("{at}.maximum_load_factor"), self.maximum_load_factor, 1.0, 50.0)
    }
}

impl Captive {
    fn check(&self) -> Check {
        positive("captive.duration_s", self.duration_s)?;
        between("captive.altitude_m", self.altitude_m, 0.0, 20_000.0)?;
        positive("captive.airspeed_mps", self.airspeed_mps)?;
        finite("captive.heading_deg", self.heading_deg)?;
        not_negative("captive.phugoid_amplitude_m", self.phugoid_amplitude_m)?;
        positive("captive.phugoid_period_s", self.phugoid_period_s)?;
        not_negative("captive.settling_s", self.settling_s)?;
        between("captive.uav_throttle", self.uav_throttle, 0.0, 1.0)
    }
}

impl Segment {
    fn check(&self, at: &str) -> Check {
        positive(&format!("{at}.duration_s"), self.duration_s)?;
        if let Some(path) = self.flight_path_deg {
            between(&format!("{at}.flight_path_deg"), path, -80.0, 80.0)?;
        }
        if let Some(airspeed) = self.airspeed_mps {
            positive(&format!("{at}.airspeed_mps"), airspeed)?;
        }
        if let Some(bank) = self.bank_deg {
            between(&format!("{at}.bank_deg"), bank, -75.0, 75.0)?;
        }
        if let Some(load_factor) = self.load_factor {
            between(&format!("{at}.load_factor"), load_factor, -10.0, 50.0)?;
        }
        let (path, bank, airspeed, load) = match self.manoeuvre {
            Manoeuvre::Straight => (None, false, false, false),
            Manoeuvre::Dive => (Some(-1.0), false, false, true),
            Manoeuvre::Climb | Manoeuvre::PullUp => (Some(1.0), false, false, true),
            Manoeuvre::LevelOff => (None, false, false, true),
            Manoeuvre::Turn => (None, true, false, false),
            Manoeuvre::Accelerate | Manoeuvre::Decelerate => (None, false, true, false),
        };
        let name = self.manoeuvre.name();
        let at = || at.to_owned();
        let not_of = |what: String, key| Err(ScenarioProblem::NotOf { at: at(), what, key });
        let missing = |what: String, key| Err(ScenarioProblem::Missing { at: at(), what, key });
        match (path, self.flight_path_deg) {
            (None, Some(_)) => return not_of(format!("a {name}"), "flight_path_deg"),
            (Some(sign), value) if !value.is_some_and(|value| value * sign > 0.0) => {
                let side = if sign < 0.0 { "below" } else { "above" };
                return Err(ScenarioProblem::WrongWay { at: at(), manoeuvre: self.manoeuvre, side });
            }
            _ => {}
        }
        match (bank, self.bank_deg) {
            (true, None) => return missing(format!("a {name}"), "bank_deg"),
            (false, Some(_)) => return not_of(format!("a {name}"), "bank_deg"),
            _ => {}
        }
        if airspeed && self.airspeed_mps.is_none() {
            return missing(name.to_owned(), "airspeed_mps");
        }
        if !load && self.load_factor.is_some() {
            return not_of(format!("a {name}"), "load_factor");
        }
        Ok(())
    }
}

impl Sampling {
    fn check(&self, at: &str, row_rate_hz: f64) -> Check {
        let key = format!("{at}.sampling.rate_hz");
        positive(&key, self.rate_hz)?;
        if self.rate_hz > row_rate_hz {
            return fail(&key, self.rate_hz, Expected::RowRate(row_rate_hz));
        }
        between(&format!("{at}.sampling.latency_s"), self.latency_s, 0.0, 60.0)?;
        between(&format!("{at}.sampling.dropout_probability"), self.dropout_probability, 0.0, 1.0)?;
        Interval::check_all(&self.outages, &format!("{at}.sampling.outages"))
    }
}

impl Interval {
    fn check_all(intervals: &[Self], at: &str) -> Check {
        intervals.iter().enumerate().try_for_each(|(index, interval)| {
            not_negative(&format!("{at}[{index}].start_s"), interval.start_s)?;
            positive(&format!("{at}[{index}].duration_s"), interval.duration_s)
        })
    }
}

impl Noise {
    fn check(&self, at: &str) -> Check {
        not_negative(&format!("{at}.white"), self.white)?;
        not_negative(&format!("{at}.wander"), self.wander)?;
        if self.wander > 0.0 {
            positive(&format!("{at}.wander_time_s"), self.wander_time_s)
        } else {
            not_negative(&format!("{at}.wander_time_s"), self.wander_time_s)
        }
    }
}

impl CarrierFlow {
    fn check(&self, at: &str) -> Check {
        not_negative(&format!("{at}.carrier_flow.sigma_m"), self.sigma_m)?;
        positive(&format!("{at}.carrier_flow.correlation_time_s"), self.correlation_time_s)?;
        not_negative(&format!("{at}.carrier_flow.settling_factor"), self.settling_factor)
    }
}

impl Gps {
    fn check(&self, row_rate_hz: f64) -> Check {
        self.sampling.check("sensors.gps", row_rate_hz)?;
        finite("sensors.gps.bias_m", self.bias_m)?;
        self.noise.check("sensors.gps.noise")?;
        not_negative("sensors.gps.velocity_sigma_mps", self.velocity_sigma_mps)?;
        not_negative("sensors.gps.quantum_m", self.quantum_m)?;
        not_negative("sensors.gps.smoothing_s", self.smoothing_s)?;
        positive("sensors.gps.accuracy_factor", self.accuracy_factor)?;
        if let Some(cold_start) = self.cold_start {
            finite("sensors.gps.cold_start.altitude_error_m", cold_start.altitude_error_m)?;
            positive("sensors.gps.cold_start.time_constant_s", cold_start.time_constant_s)?;
        }
        Interval::check_all(&self.freezes, "sensors.gps.freezes")
    }
}

impl Barometer {
    fn check(&self, row_rate_hz: f64) -> Check {
        self.sampling.check("sensors.baro", row_rate_hz)?;
        finite("sensors.baro.bias_m", self.bias_m)?;
        self.noise.check("sensors.baro.noise")?;
        not_negative("sensors.baro.quantum_pa", self.quantum_pa)?;
        self.carrier_flow.check("sensors.baro")?;
        finite("sensors.baro.temperature.initial_excess_c", self.temperature.initial_excess_c)?;
        finite("sensors.baro.temperature.self_heating_c", self.temperature.self_heating_c)?;
        positive("sensors.baro.temperature.time_constant_s", self.temperature.time_constant_s)?;
        not_negative("sensors.baro.temperature.sigma_c", self.temperature.sigma_c)
    }
}

impl AltitudeSensor {
    fn check(&self, at: &str, row_rate_hz: f64) -> Check {
        self.sampling.check(at, row_rate_hz)?;
        finite(&format!("{at}.bias_m"), self.bias_m)?;
        self.noise.check(&format!("{at}.noise"))?;
        not_negative(&format!("{at}.quantum_m"), self.quantum_m)?;
        self.carrier_flow.check(at)
    }
}

impl Inertial {
    fn check(&self, row_rate_hz: f64) -> Check {
        self.sampling.check("sensors.inertial", row_rate_hz)?;
        self.accel_noise.check("sensors.inertial.accel_noise")?;
        self.gyro_noise.check("sensors.inertial.gyro_noise")?;
        for value in self.accel_bias_mps2 {
            finite("sensors.inertial.accel_bias_mps2", value)?;
        }
        for value in self.gyro_bias_radps {
            finite("sensors.inertial.gyro_bias_radps", value)?;
        }
        not_negative("sensors.inertial.accel_quantum_mps2", self.accel_quantum_mps2)?;
        not_negative("sensors.inertial.gyro_quantum_radps", self.gyro_quantum_radps)
    }
}

impl AirData {
    fn check(&self, row_rate_hz: f64) -> Check {
        self.sampling.check("sensors.air_data", row_rate_hz)?;
        not_negative("sensors.air_data.airspeed_sigma_mps", self.airspeed_sigma_mps)?;
        not_negative("sensors.air_data.angle_sigma_rad", self.angle_sigma_rad)?;
        not_negative("sensors.air_data.temperature_sigma_c", self.temperature_sigma_c)
    }
}

impl AttitudeSensor {
    fn check(&self, row_rate_hz: f64) -> Check {
        self.sampling.check("sensors.attitude", row_rate_hz)?;
        not_negative("sensors.attitude.sigma_rad", self.sigma_rad)
    }
}

impl Effect {
    fn check(&self, at: &str) -> Check {
        finite(&format!("{at}.coefficient"), self.coefficient)?;
        let exponential = matches!(self.id, EffectId::BaroWarmUp | EffectId::GpsConvergence);
        let play = self.id == EffectId::BaroHysteresis;
        for (key, value, wanted) in
            [("time_constant_s", self.time_constant_s, exponential), ("width_m", self.width_m, play)]
        {
            match value {
                Some(value) if wanted => positive(&format!("{at}.{key}"), value)?,
                Some(_) => {
                    return Err(ScenarioProblem::NotOf {
                        at: at.to_owned(),
                        what: self.id.name().to_owned(),
                        key,
                    });
                }
                None if wanted => {
                    return Err(ScenarioProblem::Missing {
                        at: at.to_owned(),
                        what: self.id.name().to_owned(),
                        key,
                    });
                }
                None => {}
            }
        }
        Ok(())
    }
}
