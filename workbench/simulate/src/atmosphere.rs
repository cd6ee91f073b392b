//! The air, in double precision: the standard atmosphere (ICAO Doc 7488, third edition, eqs 4 to 12;
//! troposphere and lower stratosphere) and a non-standard day.
//!
//! It shares no code with `kf_core::atmosphere`, so that an error in either shows as a difference.

/// Standard gravity, m/s^2.
pub const GRAVITY: f64 = 9.806_65;
const SEA_LEVEL_PRESSURE: f64 = 101_325.0;
const SEA_LEVEL_TEMPERATURE: f64 = 288.15;
const LAPSE_RATE: f64 = 0.006_5;
const GAS_CONSTANT: f64 = 287.052_87;
const TROPOPAUSE: f64 = 11_000.0;
const STRATOSPHERE_TEMPERATURE: f64 = SEA_LEVEL_TEMPERATURE - LAPSE_RATE * TROPOPAUSE;
/// g / (R L).
const EXPONENT: f64 = GRAVITY / (GAS_CONSTANT * LAPSE_RATE);
/// Scale height of the isothermal stratosphere, m.
const SCALE_HEIGHT: f64 = GAS_CONSTANT * STRATOSPHERE_TEMPERATURE / GRAVITY;
/// Zero Celsius, K.
pub(super) const ZERO_CELSIUS: f64 = 273.15;

/// Standard temperature at a pressure altitude, K.
#[must_use]
pub fn standard_temperature_k(pressure_altitude_m: f64) -> f64 {
    if pressure_altitude_m < TROPOPAUSE {
        SEA_LEVEL_TEMPERATURE - LAPSE_RATE * pressure_altitude_m
    } else {
        STRATOSPHERE_TEMPERATURE
    }
}

fn tropopause_pressure() -> f64 {
    SEA_LEVEL_PRESSURE * libm::pow(STRATOSPHERE_TEMPERATURE / SEA_LEVEL_TEMPERATURE, EXPONENT)
}

/// Standard pressure at a pressure altitude (m), Pa.
#[must_use]
pub fn standard_pressure_pa(pressure_altitude_m: f64) -> f64 {
    if pressure_altitude_m < TROPOPAUSE {
        SEA_LEVEL_PRESSURE
            * libm::pow(standard_temperature_k(pressure_altitude_m) / SEA_LEVEL_TEMPERATURE, EXPONENT)
    } else {
        tropopause_pressure() * libm::exp((TROPOPAUSE - pressure_altitude_m) / SCALE_HEIGHT)
    }
}

/// Pressure altitude of a pressure (Pa), m: the inverse of [`standard_pressure_pa`].
#[must_use]
pub fn pressure_altitude_m(pressure_pa: f64) -> f64 {
    let tropopause = tropopause_pressure();
    if pressure_pa > tropopause {
        (1.0 - libm::pow(pressure_pa / SEA_LEVEL_PRESSURE, 1.0 / EXPONENT))
            * (SEA_LEVEL_TEMPERATURE / LAPSE_RATE)
    } else {
        TROPOPAUSE - SCALE_HEIGHT * libm::log(pressure_pa / tropopause)
    }
}

/// Integral of 1 / T_standard over pressure altitude from sea level, m/K.
fn inverse_temperature_integral(pressure_altitude_m: f64) -> f64 {
    let below = pressure_altitude_m.min(TROPOPAUSE);
    let above = pressure_altitude_m - below;
    -libm::log(standard_temperature_k(below) / SEA_LEVEL_TEMPERATURE) / LAPSE_RATE
        + above / STRATOSPHERE_TEMPERATURE
}

/// The air of one day: standard, or warmer (colder) by the same amount at every pressure level, and
/// with its own pressure at sea level.
#[derive(Clone, Copy, Debug)]
pub struct Air {
    temperature_offset_k: f64,
    /// Pressure altitude of true sea level, m.
    sea_level_pressure_altitude_m: f64,
}

/// The air at one altitude.
#[derive(Clone, Copy, Debug)]
pub struct AirState {
    /// Static temperature, K.
    pub temperature_k: f64,
    /// Density, kg/m^3.
    pub density: f64,
    /// Pressure altitude, m.
    pub pressure_altitude_m: f64,
}

impl Air {
    /// A day's air from its offset to the standard temperature (K) and its pressure at sea level (Pa).
    #[must_use]
    pub fn new(temperature_offset_k: f64, sea_level_pressure_pa: f64) -> Self {
        // Exact zero on a standard day, so that pressure altitude and altitude are the same bits then.
        let standard = sea_level_pressure_pa == SEA_LEVEL_PRESSURE;
        let sea_level = if standard { 0.0 } else { pressure_altitude_m(sea_level_pressure_pa) };
        Self { temperature_offset_k, sea_level_pressure_altitude_m: sea_level }
    }

    /// Altitude (geopotential, m) at which the pressure altitude is `pressure_altitude_m`.
    ///
    /// Hydrostatics: `dh / dh_p = T / T_standard = 1 + offset / T_standard(h_p)`.
    #[must_use]
    pub fn altitude_m(&self, pressure_altitude_m: f64) -> f64 {
        let warm_layer = inverse_temperature_integral(pressure_altitude_m)
            - inverse_temperature_integral(self.sea_level_pressure_altitude_m);
        pressure_altitude_m - self.sea_level_pressure_altitude_m + self.temperature_offset_k * warm_layer
    }

    /// Pressure altitude (m) of an altitude (geopotential, m).
    #[must_use]
    pub fn pressure_altitude_m(&self, altitude_m: f64) -> f64 {
        let mut guess = altitude_m + self.sea_level_pressure_altitude_m;
        if self.temperature_offset_k != 0.0 {
            // Newton on a function whose slope is nearly constant: four steps reach rounding.
            for _ in 0..4 {
                let slope = 1.0 + self.temperature_offset_k / standard_temperature_k(guess);
                guess -= (self.altitude_m(guess) - altitude_m) / slope;
            }
        }
        guess
    }

    /// The air at an altitude (geopotential, m).
    #[must_use]
    pub fn at(&self, altitude_m: f64) -> AirState {
        let pressure_altitude_m = self.pressure_altitude_m(altitude_m);
        let temperature_k = standard_temperature_k(pressure_altitude_m) + self.temperature_offset_k;
        let density = standard_pressure_pa(pressure_altitude_m) / (GAS_CONSTANT * temperature_k);
        AirState { temperature_k, density, pressure_altitude_m }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn agrees_with_the_icao_table() {
        // ICAO Doc 7488 (1993), table 1: geopotential altitude (m), temperature (K), pressure (Pa), density.
        for (altitude, temperature, pressure, density) in [
            (-500.0, 291.400, 107_477.0, 1.284_89),
            (0.0, 288.150, 101_325.0, 1.225_00),
            (2_000.0, 275.150, 79_495.2, 1.006_49),
            (5_000.0, 255.650, 54_019.9, 0.736_116),
            (11_000.0, 216.650, 22_632.0, 0.363_918),
            (15_000.0, 216.650, 12_044.6, 0.193_674),
        ] {
            let air = Air::new(0.0, SEA_LEVEL_PRESSURE).at(altitude);
            // Six printed digits: half a unit of the last one.
            assert!((air.temperature_k - temperature).abs() < 6e-4);
            assert!((standard_pressure_pa(altitude) / pressure - 1.0).abs() < 6e-6, "{altitude}");
            assert!((air.density / density - 1.0).abs() < 6e-6, "{altitude}: {}", air.density);
        }
    }

    #[test]
    fn pressure_and_altitude_are_inverses() {
        for altitude in [-400.0, 0.0, 1_234.5, 10_999.0, 11_001.0, 18_000.0] {
            assert!((pressure_altitude_m(standard_pressure_pa(altitude)) - altitude).abs() < 1e-8);
            for air in [Air::new(0.0, 101_325.0), Air::new(17.0, 99_800.0), Air::new(-25.0, 103_000.0)] {
                let pressure_altitude = air.pressure_altitude_m(altitude);
                assert!((air.altitude_m(pressure_altitude) - altitude).abs() < 1e-8);
            }
        }
    }

    #[test]
    fn a_standard_day_adds_nothing() {
        let air = Air::new(0.0, 101_325.0);
        for altitude in [0.0, 777.7, 9_999.9] {
            assert_eq!(air.pressure_altitude_m(altitude).to_bits(), altitude.to_bits());
        }
    }

    #[test]
    fn a_warm_day_obeys_the_hydrostatic_equation() {
        let air = Air::new(20.0, 100_500.0);
        let half = 0.5;
        for altitude in [100.0, 3_000.0, 12_000.0] {
            let pressure = |h: f64| standard_pressure_pa(air.pressure_altitude_m(h));
            let gradient = pressure(altitude + half) - pressure(altitude - half);
            let expected = -air.at(altitude).density * GRAVITY;
            // Third-order term of the central difference: (dh^2 / 24) p''' / p' < 1e-9.
            assert!((gradient / expected - 1.0).abs() < 1e-7, "{altitude}: {gradient} {expected}");
        }
    }
}
