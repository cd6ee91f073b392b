//! What the residuals contain besides effects: the reference's wander, which is common to all sensors, and
//! every sensor's own noise.

use kf_core::config::{ReferenceConfig, SensorConfig};
use kf_core::sensor::SENSORS;

use super::series::Series;

/// A first-order Gauss-Markov process.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GaussMarkov {
    /// Stationary standard deviation, metres.
    pub sigma_m: f64,
    /// Correlation time, seconds.
    pub time_s: f64,
}

/// One sensor's own noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorNoise {
    /// The slow part, which keeps its sign over many blocks.
    pub wander: GaussMarkov,
    /// White noise of the mean of a full block in captive flight, metres; it includes the mother ship's flow.
    pub captive_white_m: f64,
    /// White noise of the mean of a full block in free flight, metres.
    pub free_white_m: f64,
    /// How many times larger the wander is in free flight than in captive flight. An error that exists only
    /// in free flight and that no effect explains appears here.
    pub free_flight_factor: f64,
}

/// Noise of one flight's residuals.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// The reference's wander: in every residual at once.
    pub reference: GaussMarkov,
    /// A second, slower wander of the difference of altitudes, in every residual at once; sigma 0: none.
    pub slow: GaussMarkov,
    /// White noise of one fix, metres.
    pub fix_sigma_m: f64,
    /// The sensors' own noise.
    pub sensors: [SensorNoise; SENSORS],
}

impl Noise {
    /// Variance of the white noise of a sensor's mean of a block, m^2.
    #[must_use]
    pub fn white_m2(&self, series: &Series, block: usize, sensor: usize) -> f64 {
        let own = &self.sensors[sensor];
        let white_m = if series.free[block] { own.free_white_m } else { own.captive_white_m };
        white_m * white_m * white_share(series, block, sensor)
    }
}

/// Variance of the white noise of a block's mean, relative to that of a full block.
#[must_use]
pub fn white_share(series: &Series, block: usize, sensor: usize) -> f64 {
    series.full_block[sensor] / f64::from(series.readings[block][sensor])
}

/// Derivatives of a function of the noise with respect to a Gauss-Markov process' parameters.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ProcessSlope {
    /// With respect to its variance, 1/m^2.
    pub variance: f64,
    /// With respect to its correlation time, 1/s.
    pub time: f64,
}

/// Derivatives with respect to a sensor's own noise.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SensorSlope {
    /// With respect to its wander in captive flight; the time's over all of the flight.
    pub captive: ProcessSlope,
    /// With respect to the variance of its wander in free flight, 1/m^2.
    pub free_variance: f64,
    /// With respect to the variance of its white noise in captive flight, 1/m^2.
    pub captive_white_variance: f64,
    /// The same in free flight.
    pub free_white_variance: f64,
}

/// Derivatives of a function of the noise with respect to its parameters.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct NoiseSlope {
    /// With respect to the reference's wander.
    pub reference: ProcessSlope,
    /// With respect to the slow wander.
    pub slow: ProcessSlope,
    /// With respect to the variance of a fix, 1/m^2.
    pub fix_variance: f64,
    /// With respect to the sensors' own noise.
    pub sensors: [SensorSlope; SENSORS],
}

/// Which part of the noise a parameter is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Part {
    ReferenceSigma,
    ReferenceTime,
    SlowSigma,
    FixSigma,
    WanderSigma(usize),
    WanderTime(usize),
    CaptiveWhite(usize),
    FreeWhite(usize),
    WhiteFactor(usize),
    FreeFlightFactor(usize),
}

impl Part {
    /// Lower bound of the value. A wander that is faster than this is white noise of the blocks. Without a
    /// bound, a fit would treat fast noise as wander, and have none left for the slow errors from which a
    /// bias and an effect must be distinguished.
    const fn least(self) -> f64 {
        match self {
            Self::ReferenceTime => 8.0,
            Self::WanderTime(_) => 3.0,
            _ => 0.0,
        }
    }
}

/// A parameter: the logarithm of one of the noise's values in excess of its lower bound, with a normal prior.
#[derive(Clone, Copy, Debug)]
struct Parameter {
    part: Part,
    mean: f64,
    sigma: f64,
}

/// Which values of the noise are estimated, and their priors.
///
/// The priors are weak: a factor of two to five either way (1 sigma). They keep a value about which a flight
/// has no information (a correlation time longer than the flight) where the model file has it.
#[derive(Clone, Debug)]
pub struct NoisePrior {
    parameters: Vec<Parameter>,
    start: Noise,
}

/// Sigma of the logarithm of a size of which only the order of magnitude is known: a factor of four.
const ORDER: f64 = 1.4;
/// The same for a wander's size: a factor of 2.7. With no wander at all, a step of any size would be
/// significant.
const WANDER_ORDER: f64 = 1.0;
/// The same for a correlation time: a factor of two.
const TIME_ORDER: f64 = 0.7;
/// The same for the ratio of the white noise after launch to that before: a factor of two. The mother ship's
/// flow is gone, and the sensor's own propeller and angle of attack are new.
const WHITE_ORDER: f64 = 0.7;
/// Correlation time of the slow wander, seconds: that of a flight's weather and of a receiver's
/// constellation, which a wander of minutes cannot represent.
const SLOW_S: f64 = 1200.0;
/// The same for a factor that is held at one.
const HELD: f64 = 0.02;
/// The same for the free-flight factor: a healthy sensor is noisier after launch by at most about 30 %.
const FACTOR_ORDER: f64 = 0.25;

impl NoisePrior {
    /// The prior for flights with these sensors, from a model's noise.
    #[must_use]
    pub fn new(flights: &[Series], reference: &ReferenceConfig, sensors: &[SensorConfig; SENSORS]) -> Self {
        let or = |value: f32, default: f64| if value > 0.0 { f64::from(value) } else { default };
        let start = Noise {
            reference: GaussMarkov {
                sigma_m: or(reference.sigma_m, 2.0),
                time_s: or(reference.correlation_time_s, 60.0),
            },
            slow: GaussMarkov { sigma_m: 0.0, time_s: SLOW_S },
            fix_sigma_m: 0.2 * or(reference.sigma_m, 2.0),
            sensors: sensors.map(|sensor| SensorNoise {
                wander: GaussMarkov { sigma_m: 0.6 * or(sensor.sigma_m, 1.0), time_s: 30.0 },
                captive_white_m: 0.3 * or(sensor.sigma_m, 1.0),
                free_white_m: 0.3 * or(sensor.sigma_m, 1.0),
                free_flight_factor: 1.0,
            }),
        };
        let mut parameters = Vec::new();
        let mut add = |part: Part, value: f64, sigma| {
            parameters.push(Parameter { part, mean: libm::log(value - part.least()), sigma });
        };
        add(Part::ReferenceSigma, start.reference.sigma_m, WANDER_ORDER);
        add(Part::ReferenceTime, start.reference.time_s.max(2.0 * Part::ReferenceTime.least()), TIME_ORDER);
        add(Part::FixSigma, start.fix_sigma_m, ORDER);
        let has = |sensor: usize, free: bool| {
            flights.iter().any(|flight| {
                let mut blocks = flight.free.iter().zip(&flight.residual_m);
                blocks.any(|(is_free, residuals)| *is_free == free && residuals[sensor].is_finite())
            })
        };
        for (i, noise) in start.sensors.iter().enumerate() {
            let (captive, free) = (has(i, false), has(i, true));
            if captive || free {
                add(Part::WanderSigma(i), noise.wander.sigma_m, WANDER_ORDER);
                add(Part::WanderTime(i), noise.wander.time_s, TIME_ORDER);
            }
            if captive {
                add(Part::CaptiveWhite(i), noise.captive_white_m, ORDER);
            }
            if free && !captive {
                add(Part::FreeWhite(i), noise.free_white_m, ORDER);
            }
            if captive && free {
                add(Part::WhiteFactor(i), 1.0, WHITE_ORDER);
                add(Part::FreeFlightFactor(i), 1.0, FACTOR_ORDER);
            }
        }
        Self { parameters, start }
    }

    /// The prior with a slow wander in addition to the reference's, for flights whose only evidence of a slow
    /// error is one sensor against the receiver. Weather, a warming instrument and the receiver's own slow
    /// errors are not a single Gauss-Markov process; a drift must be distinguished from them, not from the
    /// wander of a minute.
    #[must_use]
    pub fn with_slow_wander(mut self) -> Self {
        let mean = libm::log(0.5 * self.start.reference.sigma_m);
        self.parameters.push(Parameter { part: Part::SlowSigma, mean, sigma: ORDER });
        self
    }

    /// The prior's means, where a search starts.
    #[must_use]
    pub fn means(&self) -> Vec<f64> {
        self.parameters.iter().map(|parameter| parameter.mean).collect()
    }

    /// Logarithm of the prior's density, up to a constant.
    #[must_use]
    pub fn log_density(&self, values: &[f64]) -> f64 {
        let terms = self.parameters.iter().zip(values).map(|(parameter, value)| {
            let z = (value - parameter.mean) / parameter.sigma;
            -0.5 * z * z
        });
        terms.sum()
    }

    /// The noise with these parameters.
    #[must_use]
    pub fn noise(&self, values: &[f64]) -> Noise {
        let mut noise = self.start;
        // A factor comes after the value that it multiplies.
        for (parameter, value) in self.parameters.iter().zip(values) {
            let value = parameter.part.least() + libm::exp(*value);
            match parameter.part {
                Part::ReferenceSigma => noise.reference.sigma_m = value,
                Part::ReferenceTime => noise.reference.time_s = value,
                Part::SlowSigma => noise.slow.sigma_m = value,
                Part::FixSigma => noise.fix_sigma_m = value,
                Part::WanderSigma(i) => noise.sensors[i].wander.sigma_m = value,
                Part::WanderTime(i) => noise.sensors[i].wander.time_s = value,
                Part::CaptiveWhite(i) => noise.sensors[i].captive_white_m = value,
                Part::FreeWhite(i) => noise.sensors[i].free_white_m = value,
                Part::WhiteFactor(i) => {
                    noise.sensors[i].free_white_m = value * noise.sensors[i].captive_white_m
                }
                Part::FreeFlightFactor(i) => noise.sensors[i].free_flight_factor = value,
            }
        }
        noise
    }

    /// Derivatives with respect to the parameters, from the derivatives with respect to the noise's values.
    #[must_use]
    pub fn slope(&self, values: &[f64], of: &NoiseSlope) -> Vec<f64> {
        let noise = self.noise(values);
        let has_factor = |i| self.parameters.iter().any(|other| other.part == Part::WhiteFactor(i));
        let terms = self.parameters.iter().zip(values).map(|(parameter, value)| {
            let by_number = match parameter.part {
                Part::ReferenceSigma => 2.0 * noise.reference.sigma_m * of.reference.variance,
                Part::ReferenceTime => of.reference.time,
                Part::SlowSigma => 2.0 * noise.slow.sigma_m * of.slow.variance,
                Part::FixSigma => 2.0 * noise.fix_sigma_m * of.fix_variance,
                Part::WanderSigma(i) => {
                    let (own, of) = (&noise.sensors[i], &of.sensors[i]);
                    let free = own.free_flight_factor * own.free_flight_factor * of.free_variance;
                    2.0 * own.wander.sigma_m * (of.captive.variance + free)
                }
                Part::WanderTime(i) => of.sensors[i].captive.time,
                Part::CaptiveWhite(i) => {
                    let (own, of) = (&noise.sensors[i], &of.sensors[i]);
                    let captive = 2.0 * own.captive_white_m * of.captive_white_variance;
                    let free = 2.0 * own.free_white_m * of.free_white_variance;
                    // The white noise of free flight is a multiple of it.
                    if has_factor(i) {
                        captive + free * own.free_white_m / own.captive_white_m
                    } else {
                        captive
                    }
                }
                Part::FreeWhite(i) => 2.0 * noise.sensors[i].free_white_m * of.sensors[i].free_white_variance,
                Part::WhiteFactor(i) => {
                    let (own, of) = (&noise.sensors[i], &of.sensors[i]);
                    2.0 * own.free_white_m * own.captive_white_m * of.free_white_variance
                }
                Part::FreeFlightFactor(i) => {
                    let (own, of) = (&noise.sensors[i], &of.sensors[i]);
                    let sigma_m2 = own.wander.sigma_m * own.wander.sigma_m;
                    2.0 * sigma_m2 * own.free_flight_factor * of.free_variance
                }
            };
            // A value is its lower bound plus the exponential of its parameter.
            by_number * libm::exp(*value)
        });
        terms.collect()
    }

    /// The slope of [`Self::log_density`].
    #[must_use]
    pub fn log_density_slope(&self, values: &[f64]) -> Vec<f64> {
        let terms = self.parameters.iter().zip(values);
        terms
            .map(|(parameter, value)| (parameter.mean - value) / (parameter.sigma * parameter.sigma))
            .collect()
    }

    /// The prior with a sensor's wander the same before and after launch; `None` where it already is.
    #[must_use]
    pub fn with_steady_wander(&self, sensor: usize) -> Option<Self> {
        self.held(Part::FreeFlightFactor(sensor))
    }

    /// The same for the sensor's white noise.
    #[must_use]
    pub fn with_steady_white(&self, sensor: usize) -> Option<Self> {
        self.held(Part::WhiteFactor(sensor))
    }

    fn held(&self, part: Part) -> Option<Self> {
        let mut held = self.clone();
        held.parameters.iter_mut().find(|parameter| parameter.part == part)?.sigma = HELD;
        Some(held)
    }
}

#[cfg(test)]
mod tests {
    use model::Model;

    use super::*;

    /// A flight of one sensor with both phases, with `free` blocks or none.
    fn prior() -> NoisePrior {
        let mut series = Series { block_s: 1.0, full_block: [10.0; SENSORS], ..Series::default() };
        for block in 0..40 {
            series.time_s.push(f64::from(block));
            series.fixes.push(1.0);
            series.free.push(block >= 20);
            series.residual_m.push([f64::NAN, f64::NAN, 1.0]);
            series.readings.push([0, 0, 10]);
        }
        let model = Model::default();
        NoisePrior::new(&[series], &model.reference, &model.sensors)
    }

    /// The density is normal in every parameter: one sigma away it is lower by a half, two sigmas away by
    /// two.
    #[test]
    fn a_priors_density_is_normal() {
        let prior = prior();
        let means = prior.means();
        assert_eq!(prior.log_density(&means), 0.0);
        for (k, parameter) in prior.parameters.iter().enumerate() {
            for sigmas in [1.0, -2.0] {
                let mut values = means.clone();
                values[k] += sigmas * parameter.sigma;
                let wanted = -0.5 * sigmas * sigmas;
                assert!((prior.log_density(&values) - wanted).abs() < 1e-9, "{k}");
            }
        }
    }

    /// The white noise of free flight is that of captive flight times its factor; what is not estimated
    /// stays.
    #[test]
    fn free_flights_white_noise_is_a_factor_of_captive_flights() {
        let prior = prior();
        let at = |part: Part| prior.parameters.iter().position(|parameter| parameter.part == part).unwrap();
        let mut values = prior.means();
        values[at(Part::CaptiveWhite(2))] = libm::log(0.5);
        values[at(Part::WhiteFactor(2))] = libm::log(3.0);
        values[at(Part::FreeFlightFactor(2))] = libm::log(1.25);
        let sensor = prior.noise(&values).sensors[2];
        assert!((sensor.captive_white_m - 0.5).abs() < 1e-12 && (sensor.free_white_m - 1.5).abs() < 1e-12);
        assert!((sensor.free_flight_factor - 1.25).abs() < 1e-12);
        // A correlation time has a lower bound.
        values[at(Part::WanderTime(2))] = libm::log(10.0);
        assert!((prior.noise(&values).sensors[2].wander.time_s - 13.0).abs() < 1e-12);
    }

    /// A prior that holds a part at one allows little else; for a missing sensor nothing can be held. The
    /// slow wander is one more parameter.
    #[test]
    fn a_held_part_stays_where_it_is() {
        let prior = prior();
        for (held, part) in [
            (prior.with_steady_wander(2), Part::FreeFlightFactor(2)),
            (prior.with_steady_white(2), Part::WhiteFactor(2)),
        ] {
            let held = held.unwrap();
            for (one, other) in held.parameters.iter().zip(&prior.parameters) {
                let wanted = if one.part == part { HELD } else { other.sigma };
                assert_eq!((one.part, one.mean, one.sigma), (other.part, other.mean, wanted));
            }
        }
        assert!(prior.with_steady_wander(0).is_none());
        let slow = prior.clone().with_slow_wander();
        assert_eq!(slow.means().len(), prior.means().len() + 1);
        let noise = slow.noise(&slow.means());
        assert!((noise.slow.sigma_m - 0.5 * noise.reference.sigma_m).abs() < 0.5 * noise.reference.sigma_m);
    }
}
